"""Bodies that several tests share: a cube, a beam and the coarse shoe, with their reductions."""

import numpy as np
import pytest

import fem
import meshes
from meshes import STEEL, joint_interfaces
from tests.fem.bodies import beam_interfaces, box_mesh


@pytest.fixture
def cube() -> fem.Mesh:
    return box_mesh((1, 1, 1), (1.0, 1.0, 1.0))


@pytest.fixture(scope="session")
def beam() -> fem.ElasticBody:
    """Steel beam of 0.6 x 0.1 x 0.1 m, with its ends as named surfaces."""
    mesh = box_mesh((6, 1, 1), (0.6, 0.1, 0.1))
    ends = {
        name: mesh.boundary[np.isclose(mesh.nodes[mesh.boundary][:, :, 0], x).all(axis=1)]
        for name, x in (("left", 0.0), ("right", 0.6))
    }
    return fem.ElasticBody(fem.Mesh(mesh.nodes, mesh.elements, ends), STEEL)


@pytest.fixture(scope="session")
def small(beam: fem.ElasticBody) -> fem.ReducedBody:
    return fem.craig_bampton(beam, beam_interfaces(beam), 20)


@pytest.fixture(scope="session")
def history(small: fem.ReducedBody) -> np.ndarray:
    rng = np.random.default_rng(4)
    return rng.standard_normal((700, len(small.frequencies))) / small.frequencies**2


@pytest.fixture(scope="session")
def shoe() -> fem.ElasticBody:
    return fem.ElasticBody(meshes.shoe_mesh("coarse"), STEEL)


@pytest.fixture(scope="session")
def partition(shoe: fem.ElasticBody) -> fem.Partition:
    return fem.Partition(shoe, joint_interfaces(shoe.mesh))


@pytest.fixture(scope="session")
def reduced(shoe: fem.ElasticBody, partition: fem.Partition) -> fem.ReducedBody:
    return fem.craig_bampton(shoe, partition.interfaces, 76, partition=partition)
