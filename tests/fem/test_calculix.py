"""The coarse shoe and a bracket against CalculiX 2.20, whose numbers `calculix_reference.py` makes."""

import json
from functools import cache

import numpy as np
import pytest

import fem
from fem.body.element_stress import von_mises
from meshes import STEEL
from tests.fem.calculix_reference import (
    BODIES,
    ELASTIC,
    MODES,
    REFERENCE,
    RIGID,
    modal_assurance,
    pull_forces,
    roller_forces,
    shape_nodes,
)

pytestmark = pytest.mark.simulation


@cache
def solved(name: str) -> tuple[fem.ElasticBody, np.ndarray, np.ndarray]:
    """Body, with eigenvalues and shapes of its free-free modes."""
    body = fem.ElasticBody(BODIES[name](), STEEL)
    return body, *body.free_modes(RIGID + ELASTIC)


@pytest.fixture(scope="module")
def shoe() -> fem.ElasticBody:
    return solved("shoe")[0]


@pytest.fixture(scope="module")
def free_modes() -> tuple[np.ndarray, np.ndarray]:
    return solved("shoe")[1:]


@pytest.mark.parametrize(
    ("name", "frequency", "shape"),
    # CalculiX integrates the mass at four points, which is felt by short waves in the bracket's coarse mesh
    [("shoe", 3e-4, 1e-3), ("bracket", 2e-3, 1e-2)],
)
def test_frequencies_and_shapes_of_24_modes(name, frequency, shape):
    """Shapes by the modal assurance criterion at the stored nodes."""
    reference = json.loads(MODES.read_text())[name]
    body, eigenvalues, modes = solved(name)
    found = np.sqrt(eigenvalues[RIGID:]) / (2 * np.pi)
    np.testing.assert_allclose(found, reference["frequencies"], rtol=frequency)
    nodes = shape_nodes(body.mesh)
    assert nodes.tolist() == reference["nodes"]
    ours = modes.reshape(-1, 3, RIGID + ELASTIC)[nodes, :, RIGID:].reshape(-1, ELASTIC)
    theirs = np.array(reference["shapes"]).T
    assurance = modal_assurance(ours, theirs)
    assert assurance.diagonal().min() > 1.0 - shape / 50
    # few nodes do not tell different modes apart wholly, but alike in both programs
    np.testing.assert_allclose(assurance, modal_assurance(ours, ours), atol=shape)


def test_assurance_of_a_mixed_shape_is_half():
    ours = np.eye(3)
    mixed = np.column_stack((ours[:, 0] + ours[:, 1], -2.0 * ours[:, 1], ours[:, 2]))
    expected = [[0.5, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]]
    np.testing.assert_allclose(modal_assurance(ours, mixed), expected, atol=1e-15)


def test_rigid_modes_store_no_energy(shoe, free_modes):
    eigenvalues, modes = free_modes
    assert np.abs(eigenvalues[:6]).max() < 1e-6 * eigenvalues[6]
    np.testing.assert_allclose(modes.T @ (shoe.mass_matrix @ modes), np.eye(RIGID + ELASTIC), atol=1e-12)
    rigid = np.linalg.qr(shoe.rigid_modes)[0]
    left = modes[:, :6] - rigid @ (rigid.T @ modes[:, :6])
    assert np.linalg.norm(left) < 1e-6 * np.linalg.norm(modes[:, :6])


def test_first_free_free_mode_bends_the_shoe_at_178_hz(shoe, free_modes):
    eigenvalues, modes = free_modes
    assert np.sqrt(eigenvalues[6]) / 2 / np.pi == pytest.approx(178.07, rel=0.02)
    first = modes[:, 6].reshape(-1, 3)
    share = (first**2).sum(axis=0)
    assert share[2] > 0.85 * share.sum()  # vertical
    aside = np.abs(shoe.mesh.nodes[:, 1])
    assert first[aside > 1.6, 2].mean() * first[aside < 0.1, 2].mean() < 0.0


@pytest.mark.parametrize(
    ("load", "stress"), [(pull_forces, "stress"), (roller_forces, "roller stress")], ids=["bores", "roller"]
)
def test_von_mises_stress_away_from_the_bores(shoe, load, stress):
    reference = json.loads(REFERENCE.read_text())
    assert reference["mesh"] == shoe.mesh.digest
    displacement = shoe.displacement_under(load(shoe).reshape(-1, 1)).reshape(-1, 3, 1)
    found = von_mises(shoe.stress(displacement, np.array(reference["nodes"]))[:, :, 0])
    expected = von_mises(np.array(reference[stress]))
    # six digits in CalculiX's file
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5 * expected.max())
