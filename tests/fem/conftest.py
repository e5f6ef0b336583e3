"""Bodies that several tests share: a cube, a beam and a shoe of few nodes, with their reductions."""

import os
from pathlib import Path

import numpy as np
import pytest

import fem
from exudyn_crawler.model.reductions import VARIABLE
from meshes import STEEL, joint_interfaces, mesh_named
from tests.fem.bodies import DOWN, beam_body, beam_interfaces, box_mesh
from tests.small_shoe import SMALL_SHOE


@pytest.fixture
def cube() -> fem.Mesh:
    return box_mesh((1, 1, 1), (1.0, 1.0, 1.0))


@pytest.fixture(scope="session")
def beam() -> fem.ElasticBody:
    return beam_body(6)


@pytest.fixture(scope="session")
def held(beam: fem.ElasticBody) -> dict[str, fem.Partition]:
    """The beam held by its ends, by kind of spider."""
    return {spider: fem.Partition(beam, beam_interfaces(beam, spider)) for spider in ("rigid", "averaging")}


@pytest.fixture(scope="session")
def small(beam: fem.ElasticBody, held: dict[str, fem.Partition]) -> fem.ReducedBody:
    return fem.craig_bampton(beam, held["rigid"].interfaces, 20, partition=held["rigid"])


@pytest.fixture(scope="session")
def history(small: fem.ReducedBody) -> np.ndarray:
    rng = np.random.default_rng(4)
    return rng.standard_normal((700, len(small.frequencies))) / small.frequencies**2


@pytest.fixture(scope="session")
def shoe() -> fem.ElasticBody:
    return fem.ElasticBody(mesh_named(SMALL_SHOE), STEEL)


@pytest.fixture(scope="session")
def partition(shoe: fem.ElasticBody) -> fem.Partition:
    return fem.Partition(shoe, joint_interfaces(shoe.mesh))


@pytest.fixture(scope="session")
def enriched(shoe: fem.ElasticBody) -> fem.ReducedBody:
    """With a mode for the machine's load; made once for all processes of a run of the tests."""
    folder, loads = Path(os.environ[VARIABLE]) / "fem", {"machine": shoe.surface_load("top", DOWN)}
    return fem.cached_craig_bampton(folder, shoe, joint_interfaces(shoe.mesh), 76, loads).body


@pytest.fixture(scope="session")
def reduced(enriched: fem.ReducedBody) -> fem.ReducedBody:
    """Without it: inside the other, which costs less than to reduce once more."""
    return fem.nested_reduction(enriched, 76).body
