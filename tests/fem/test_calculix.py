"""The coarse shoe against CalculiX 2.20, whose numbers `calculix_reference.py` makes; and its free modes."""

import json

import numpy as np
import pytest

import fem
from fem.body.element_stress import von_mises
from meshes import STEEL, shoe_mesh
from tests.fem.calculix_reference import REFERENCE, pull_forces, roller_forces

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def shoe() -> fem.ElasticBody:
    return fem.ElasticBody(shoe_mesh("coarse"), STEEL)


@pytest.fixture(scope="module")
def free_modes(shoe: fem.ElasticBody) -> tuple[np.ndarray, np.ndarray]:
    return shoe.free_modes(26)


def test_first_twenty_elastic_frequencies(shoe, free_modes):
    reference = json.loads(REFERENCE.read_text())
    assert reference["mesh"] == shoe.mesh.digest
    found = np.sqrt(free_modes[0][6:]) / (2 * np.pi)
    np.testing.assert_allclose(found, reference["frequencies"][6:], rtol=1e-3)


def test_rigid_modes_store_no_energy(shoe, free_modes):
    eigenvalues, modes = free_modes
    assert np.abs(eigenvalues[:6]).max() < 1e-6 * eigenvalues[6]
    np.testing.assert_allclose(modes.T @ (shoe.mass_matrix @ modes), np.eye(26), atol=1e-12)
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
    displacement = shoe.displacement_under(load(shoe).reshape(-1, 1)).reshape(-1, 3, 1)
    found = von_mises(shoe.stress(displacement, np.array(reference["nodes"]))[:, :, 0])
    expected = von_mises(np.array(reference[stress]))
    # six digits in CalculiX's file
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5 * expected.max())
