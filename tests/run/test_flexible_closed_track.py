"""Flexible shoes in a closed track: below a roller, on the idler and on the tumbler, over a short run."""

import numpy as np
import pytest

from exudyn_crawler import Case, Duty, FatigueMaterial, FlexibleShoes, StepProfile, recover_stresses, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.assembler import Body
from exudyn_crawler.model.flexible_shoes import whole_reduction
from exudyn_crawler.model.parts import shoes
from exudyn_crawler.results.balance import energy_balance, shoe_actions, shoe_imbalance
from exudyn_crawler.results.checks.roller_path import PRESSURE, plane_modulus, roller_path
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.results.loads.actions import actions
from exudyn_crawler.results.loads.exports import roller_loads, shoe_loads
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from fem.body.elasticity import Material
from tests.modal_loads import kinds_of_gear_on_modes

pytestmark = [pytest.mark.simulation, pytest.mark.slow]

FLEXIBLE = UNDER_ROLLER, ON_IDLER, ON_TUMBLER = 8, 15, 35


def flexible_case(numbers, **values):
    """Closed track with flexible shoes, which reaches 0.3 m/s in 0.1 s."""
    flexible = FlexibleShoes.ph4100c("coarse").with_(shoes=numbers, **{"highest_frequency": 1500.0} | values)
    drive = Drive(speed=StepProfile(times=(0.0, 0.1), values=(0.0, 0.3)))
    case = Case.closed().with_(drive=drive, flexible=flexible)
    return case.with_(shoe=case.shoe.of_mass(whole_reduction(case).body.mass))


@pytest.fixture(scope="module")
def bent():
    """Run of 0.1 s with a flexible shoe at each place."""
    return simulate(flexible_case(FLEXIBLE), 0.1, progress=False)


def balanced_forces(history):
    """All that acts on the shoes of a run, once it is seen to balance."""
    acts, left = shoe_actions(history).force, shoe_imbalance(history).force
    assert np.abs(left).max() < 1e-5 * np.abs(acts).max()
    return acts


def balanced_loads(history):
    """Loads of the shoe on the tumbler for other programs, once they are seen to balance."""
    loads = shoe_loads(history, ON_TUMBLER, 0.1)
    assert np.abs(loads.residual).max() < 1e-5 * np.abs(loads.centers).max()
    return loads


@pytest.mark.filterwarnings("ignore:flexible.youngs_modulus")
@pytest.mark.parametrize("shoe", [UNDER_ROLLER, ON_TUMBLER])
def test_stiff_shoe_gives_the_forces_of_a_rigid_one(shoe, monkeypatch):
    """Of all links, with the inertia of the rigid shoe, whose COM is 1.4 mm off that of the mesh.

    With its own the shoe on the tumbler has 0.8 kN in place of 0.1. How side loads are shared depends on the
    compliance of pins, of which a flexible link has two.
    """
    of_mesh = shoes._bodies

    def of_rigid_shoe(assembler):
        shoe = assembler.case.shoe
        return [
            Body.rigid(body.name, body.mass, shoe.inertia_tensor, body.reference)._replace(bends=body.bends)
            for body in of_mesh(assembler)
        ]

    monkeypatch.setattr(shoes, "_bodies", of_rigid_shoe)
    steel = FlexibleShoes.ph4100c("coarse").youngs_modulus
    case = flexible_case((shoe,), youngs_modulus=1e3 * steel, highest_frequency=1500.0 * 1e3**0.5)
    stiff, rigid = (simulate(one, 0.1, progress=False) for one in (case, case.with_(flexible=None)))
    # what friction held at rest is let go at the start, which a rigid shoe feels at once
    apart = np.abs(stiff.joint_force - rigid.joint_force).isel(time=slice(10, None)).max(("time", "joint"))
    most = np.abs(rigid.joint_force).max().item()
    assert (apart.sel(axis=["x", "z"]) < 3e-4 * most).all()
    assert apart.sel(axis="y") < 1e-3 * most


def test_all_that_acts_on_flexible_shoes_balances_and_work_of_the_torque_goes_into_modes_too(bent):
    balance = energy_balance(bent)
    assert np.abs(balance.imbalance.values).max() < 1e-2 * balance.drive.values.max()
    assert {"elastic", "modal_damping"} <= set(balance.data_vars)
    pressed = np.abs(balanced_forces(bent)).max(("time", "axis")).sel(shoe=[*FLEXIBLE])
    for shoe, kind in ((UNDER_ROLLER, "roller"), (ON_IDLER, "idler"), (ON_TUMBLER, "tooth")):
        assert pressed.sel(shoe=shoe, source=kind) > 1e5
    assert (pressed.sel(source=["wheel", "load"]) == 0.0).all()
    assert (balanced_loads(bent).table["kind"] == "tooth").sum() == 2


def test_flexible_shoes_with_play_balance_and_pass_on_the_forces_of_rigid_ones():
    """Each bore of a flexible shoe presses at both of its ends, the lug of a rigid one at both pins."""
    play = {"radial": 1e-3, "axial": 1e-3, "stiffness": 5e9, "damping": 1e6}
    steps = {"solver.step": 1e-3, "solver.output_interval": 1e-3}
    case = flexible_case(FLEXIBLE).with_(steps | {"gear.play": play})
    bent, rigid = (simulate(one, 0.3, progress=False) for one in (case, case.with_(flexible=None)))
    balanced_forces(bent)
    balanced_loads(bent)
    balance = energy_balance(bent)
    work = balance.drive.values.max()
    assert np.abs(balance.imbalance.values).max() < 1e-3 * work
    assert np.abs(balance.pin_springs.values).max() > 1e-2 * work
    tension, expected = (np.hypot(*(run.joint_force.sel(axis=one) for one in "xz")) for run in (bent, rigid))
    late = slice(100, None)
    apart = np.sqrt(((tension - expected).isel(time=late) ** 2).mean("time")).max()
    assert apart < 0.02 * np.sqrt((expected.isel(time=late) ** 2).mean("time")).max()


def test_loads_of_the_wheels_are_those_on_the_shoe(bent):
    for shoe in (UNDER_ROLLER, ON_IDLER):
        loads = roller_loads(bent, shoe).force.sum(("wheel", "rail")).values
        turn = rotation_matrices(bent.angles.sel(shoe=shoe).values)
        whole = bent.wheel_load.sel(shoe=shoe).values
        np.testing.assert_allclose(np.einsum("tij,tj->ti", turn, loads), whole, atol=1e-9 * abs(whole).max())
    with pytest.raises(ValueError, match="flexible one"):
        roller_loads(bent, UNDER_ROLLER + 1)


def test_modes_feel_in_the_stresses_what_they_feel_in_the_run():
    """Wheels, teeth and flanges on the modes by the records are those that leave with a lifted frame.

    The frame stands aside, so that flanges push; the chain is worn, so that pins are off their bores.
    """
    case = flexible_case(FLEXIBLE).with_({"gear.pitch_growth": 0.005})
    q = static_equilibrium(case)
    q[[-11, -5]] += 0.012  # y of frame and tumbler
    lifted = q.copy()
    lifted[[-10, -4]] += 20.0
    assert kinds_of_gear_on_modes(case, q, lifted) == {"roller", "idler", "tooth", "guide"}


def test_shares_of_hot_spots_name_tooth_idler_and_rollers_and_are_complete(bent):
    results = recover_stresses(bent)
    for shoe, name in ((UNDER_ROLLER, "rollers"), (ON_IDLER, "idler"), (ON_TUMBLER, "tooth")):
        table = results.by_region[shoe]
        shares = table.filter(like="contribution of ")
        assert np.abs(shares[f"contribution of {name}"]).max() > 0.1
        np.testing.assert_allclose(shares.sum(axis=1), 1.0, atol=1e-9)
        assert 1e7 < table["value"].max() < 1e9


def test_life_counts_cycles_of_the_loop_with_their_causes(bent):
    weak = FatigueMaterial.a36().with_(fatigue_strength=20e6)
    run = DutyRun(name="start", folder=".", share=0.1)
    found = life_of(Duty(runs=(run,), material=weak, plane_nodes=0), [bent])
    assert found.dataset.shoe.values.tolist() == [*FLEXIBLE]
    assert (found.dataset.place_damage.max(("survival", "node")) > 0.0).all()
    shares = [one.load_shares for one in found.nodes.values()]
    assert {"pins", "ground", "rollers", "idler", "tooth"} <= set().union(*shares)
    for one in shares:
        assert sum(one.values()) == pytest.approx(1.0, abs=1e-6)


def test_a_flexible_shoe_goes_over_the_tumbler():
    """From the lower run to the upper one at 1 m/s, in balance at every stored time.

    Work is summed over stored times: 2 % are missing with 8 ms between them, 0.3, 0.14 and 0.03 with 4, 2, 1.
    """
    drive = Drive(speed=StepProfile(times=(0.0, 0.5), values=(0.0, 1.0)))
    case = flexible_case((ON_TUMBLER,)).with_(drive=drive)
    history = simulate(case, 3.0, progress=False)
    way = history.position.sel(shoe=ON_TUMBLER, axis="z") - history.side_frame_position.sel(axis="z")
    # below and above the tumbler, whose axis is at 0.6 m
    assert way[0] < -0.4
    assert way[-1] > 1.2
    turned = history.angles.sel(shoe=ON_TUMBLER).isel({history.angles.dims[-1]: 1})
    assert abs(float(turned[-1] - turned[0])) > 2.0
    assert float(abs(balanced_forces(history)).sel(shoe=ON_TUMBLER, source="tooth").max()) > 5e5
    balance = energy_balance(history)
    assert np.abs(balance.imbalance.values).max() < 1e-2 * balance.drive.values.max()


def test_lugs_beside_the_pins_load_the_bores_next_to_them():
    """Two circles a shoe, one beside each pin: its own bores hold both, and the shoe is in balance."""
    track = Case.closed().track
    rear, front = (track.joint_centers[f"{end} right"] for end in ("rear", "front"))
    lugs = tuple((float(x + beside), float(z)) for (x, _, z), beside in ((rear, 0.05), (front, -0.05)))
    case = flexible_case((ON_TUMBLER,)).with_({"gear.tumbler.lugs": lugs})
    history = simulate(case, 0.1, progress=False)
    assert history.lug_force.sizes["lug"] == 4
    balanced_forces(history)
    balanced_loads(history)
    teeth = [one for one in actions(history, ON_TUMBLER) if one.kind == "tooth"]
    assert {"rear right", "rear left"} <= {one.where for one in teeth}
    shares = recover_stresses(history).by_region[ON_TUMBLER].filter(like="contribution of ")
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, atol=1e-9)


def test_roller_path_of_a_closed_track_is_hertz_of_its_treads(bent):
    """Rollers and idler, each by its radius; a rigid chain has no strips."""
    table = roller_path(bent)
    assert "idler" in set(table["roller"])
    assert table["roller"].str.startswith("roller").any()
    row = table.loc[table[PRESSURE].idxmax()]
    closed = bent.case.gear
    radius = closed.idler.radius if row["roller"] == "idler" else closed.roller_radius
    steel = Material(bent.case.flexible.youngs_modulus, bent.case.flexible.poissons_ratio, 7850.0)
    line_load = row["edge over mean"] * row["greatest force in kN"] * 1e3 / closed.tread_width
    assert row[PRESSURE] == pytest.approx(1e-6 * np.sqrt(line_load * plane_modulus(steel) / (np.pi * radius)))
    with pytest.raises(ValueError, match="flexible shoes"):
        roller_path(simulate(Case.closed(), 0.004, progress=False))
