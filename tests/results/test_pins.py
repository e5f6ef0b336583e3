"""Pins in contact with their bores: stress of a run and of check cases, verdicts, decks."""

import numpy as np
import pytest

from exudyn_crawler import Case, simulate
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.model.flexible_shoes import shoe_model
from exudyn_crawler.results.checks.cases import CheckCase, PinForce, ShoeCheck
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe
from exudyn_crawler.results.checks.solve import solve_cases
from exudyn_crawler.results.loads import load_map
from exudyn_crawler.results.loads.exports import pin_forces, shoe_loads
from exudyn_crawler.results.stress.basis import stress_basis
from exudyn_crawler.results.stress.recovery import recover_stresses
from fem import Partition
from fem.body.element_stress import von_mises

SHOE = 7


def contact_case() -> Case:
    case = Case.stress("coarse")
    return case.with_(flexible=case.flexible.with_(shoes=(SHOE,), pins="contact"))


def test_contact_needs_static_fields():
    with pytest.raises(ParameterError, match='pins = "contact" needs static_fields = true'):
        contact_case().with_({"flexible.static_fields": False})


@pytest.fixture(scope="module")
def pressed():
    return simulate(contact_case(), 0.02)


@pytest.mark.slow
@pytest.mark.simulation
def test_motion_is_that_of_averaging_pins(pressed):
    other = simulate(contact_case().with_({"flexible.pins": "averaging"}), 0.02)
    for name in ("position", "joint_force", "modal_coordinate"):
        np.testing.assert_array_equal(pressed.dataset[name], other.dataset[name])


@pytest.mark.slow
@pytest.mark.simulation
def test_stress_is_that_of_the_full_static_answer_with_pressures_in_the_bores(pressed):
    case = pressed.case
    body, interfaces = shoe_model(case.flexible, case.track)
    loads = shoe_loads(pressed, SHOE, pressed.duration)
    assert np.abs(loads.residual).max() < 1e-9 * np.abs(loads.nodal).sum()
    u = Partition(body, interfaces).static_response(loads.nodal.reshape(-1, 1), loads.centers.reshape(-1, 1))
    exact = body.stress(u.reshape(-1, 3, 1))[:, :, 0]
    basis = stress_basis(pressed)
    found = basis.shapes.stress(basis.coordinates[SHOE][-1])[0]
    bores = np.concatenate([interface.nodes for interface in interfaces])
    assert von_mises(found - exact)[bores].max() < 0.02 * von_mises(exact)[bores].max()


@pytest.mark.slow
@pytest.mark.simulation
def test_pressures_have_the_forces_of_the_pins(pressed):
    """What is left on the centres of the joints goes along the bores, or about their forces."""
    units = load_map.unit_loads(pressed.case)
    pins = pin_forces(pressed, SHOE).isel(time=-1).force.values
    loads = sum(load_map.loads_by_kind(pressed, SHOE).values()).toarray()[-1]
    _, centers = units.forces(loads)
    np.testing.assert_allclose(centers[:, [0, 2]], 0.0, atol=1e-3 * np.abs(pins).max())
    assert np.abs(centers[:, 1] - pins[:, 1]).max() < 0.05 * np.abs(pins).max()


@pytest.mark.slow
@pytest.mark.simulation
def test_bores_of_a_coarse_mesh_do_not_count(pressed):
    results = recover_stresses(pressed, peak=False)
    assert results.dataset.in_spider.any()
    assert not results.dataset.in_spider.values[results.dataset.highest_node.values].any()


@pytest.mark.slow
def test_a_check_of_pins_in_contact_stresses_the_net_section_of_the_pulled_lug():
    """Beside the bore, where a rigid coupling has a sixth of the stress; the sums of loads stay."""
    pull = CheckCase(
        name="pull",
        pins=[PinForce(pin=f"rear {side}", force=(-1e6, 0.0, 0.0)) for side in ("left", "right")],
        held_by=(
            "front left x",
            "front right x",
            "front left z",
            "front right z",
            "rear left z",
            "rear right z",
        ),
    )
    beside = {}
    for pins in ("rigid", "averaging", "contact"):
        check = ShoeCheck(mesh="coarse", pins=pins, levels=(), cases=(pull,))
        shoe = CheckedShoe(check)
        assert np.abs(shoe.resultant(shoe.loads(pull))).max() < 1.0
        found = solve_cases(check, shoe)
        place = shoe.mesh.nodes[shoe.mesh.surface_nodes]
        x, y, z = (place - shoe.partition.interfaces[3].center).T
        at = (np.abs(x) < 0.03) & (np.abs(y) < 0.09) & (np.abs(z) > 0.06) & (np.abs(z) < 0.1)
        beside[pins] = von_mises(found.stress[0])[at].max()
    assert beside["contact"] > 1.3 * beside["averaging"] > 1.3 * beside["rigid"]
