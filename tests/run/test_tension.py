"""Tension of closed chains at rest: what is asked for is what the rest has; key results of a closed track."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case, StepProfile, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.case.gear.closed_frame import LEAST_SAG, MAKERS_SAG
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.library import machines
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.results.history.summary import difference_table, key_results
from exudyn_crawler.results.history.tension import depth_below_edge, hanging_chains
from exudyn_crawler.run.solve import rest
from exudyn_crawler.run.solve.standing import standing
from exudyn_crawler.run.solve.tension import adjusted_track, chains_at_rest, history_at_rest, tensioned
from studies import measurements
from tests.case.random_datasheets import drawn
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

LIMIT = 20e3
"""N m, far less than what the chain takes to move."""


def with_idler(case, **idler):
    """Same case with some values of its idler."""
    return case.with_({f"gear.idler.{name}": value for name, value in idler.items()})


def test_straight_edge_on_points_that_hang_as_a_parabola():
    x = np.linspace(0.0, 2.0, 21)
    hanging = np.column_stack((x, -4.0 * 0.03 * x / 2.0 * (1.0 - x / 2.0)))
    assert depth_below_edge(hanging) == pytest.approx(0.03, rel=1e-12)
    # the edge lies on the highest ones between its ends
    assert depth_below_edge(np.array([[0.0, 0.0], [1.0, 0.2], [2.0, 0.0]])) == 0.0
    assert depth_below_edge(np.array([[0.0, 0.1], [1.0, 0.0], [2.0, 0.3]])) == pytest.approx(0.2)


@pytest.mark.parametrize("asked", [{"pretension": 300e3}, {"sag": 0.06}])
def test_rest_has_the_tension_that_is_asked_for(asked):
    ((name, value),) = asked.items()
    (chain,) = chains_at_rest(tensioned(with_idler(Case.closed(), **asked)))
    assert getattr(chain, name) == pytest.approx(value, rel=3e-3)


def test_chain_that_no_file_says_more_of_sags_as_makers_ask():
    """Far from taut: 45 mm in 1.8 m, where a taut chain pulls nearly three times as hard."""
    case = tensioned(Case.closed())
    (chain,) = chains_at_rest(case)
    (taut,) = chains_at_rest(with_idler(Case.closed(), slack=0.0))
    assert chain.sag == pytest.approx(MAKERS_SAG * 1.8, rel=3e-3)
    assert chain.carrier == "carrier 4"
    assert chain.span == pytest.approx(1.8 + case.gear.idler.take_up)
    assert chain.pretension < 0.4 * taut.pretension
    # it does not change what says where its idler is
    assert tensioned(case) is case


def test_tension_that_no_take_up_gives_is_refused_with_the_nearest():
    with pytest.raises(EquilibriumError, match=r"pretension of 20 kN at rest; the nearest is [\d.]+ kN"):
        tensioned(with_idler(Case.closed(), pretension=20e3))


@pytest.mark.slow
def test_sag_less_than_that_of_the_tautest_chain_is_refused():
    """Sprocket and idler give way to a chain without slack, so that it sags more than its links would."""
    words = (
        r"sag of 5 mm at rest; the nearest is [\d.]+ mm, with a take-up of \S+ m, where the chain just closes"
    )
    with pytest.raises(EquilibriumError, match=words):
        tensioned(with_idler(Case.closed(), sag=0.005))


@pytest.mark.slow
def test_a_long_chain_that_slips_back_over_its_wheels_comes_to_rest_soon(monkeypatch):
    """Of 684 t without carriers: its upper run of 11.6 m creeps on with as many iterations in each step."""
    case = derived(Datasheet(**drawn(126))).case
    inner = rest._creeping_step
    steps = []

    def counted(*arguments):
        steps.append(arguments[5])
        return inner(*arguments)

    monkeypatch.setattr(rest, "_creeping_step", counted)
    whole = tensioned(case)
    assert len(steps) < 5000
    # on the ground of either track, under its half of the machine
    for chain in chains_at_rest(whole):
        assert chain.sag == pytest.approx(MAKERS_SAG * chain.span, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("side", [0, 1])
def test_both_tracks_of_a_machine_have_it(side):
    chain = chains_at_rest(tensioned(with_idler(Case.shovel(), pretension=300e3)))[side]
    assert chain.pretension == pytest.approx(300e3, rel=0.02)


def test_machine_says_how_it_stands():
    """Pressure is that below loaded shoes, of the whole weight, with tumbler and shoes."""
    case = Case.closed()
    found = standing(case)
    ground, chain = found.lines
    assert list(found.warnings) == []
    closed, shoe = case.gear, case.shoe
    weight = (closed.mass + closed.tumbler.mass + 38 * shoe.mass) * case.gravity
    # units lean, so that friction carries 1e-4 of it, which has no slip yet
    carried = float(ground.partition("carries ")[2].partition(" MN, most of it on")[0])
    assert 1e6 * carried == pytest.approx(weight, rel=2e-4)
    count = int(ground.partition("most of it on ")[2].split()[0])
    mean = float(ground.partition("these is ")[2].split()[0])
    # nearly all of the weight is on these
    assert mean == pytest.approx(1e-3 * weight / (count * shoe.length * shoe.width), rel=0.05)
    assert 9 <= count <= 13
    assert "sags by 45 mm in 1.85 m between idler and carrier 4" in chain


def test_taut_chain_of_short_links_is_warned_of():
    """The chain of a light shoe hangs less at the same slack."""
    light = with_idler(Case.closed(), slack=0.0).with_(
        {"shoe.mass": 468.0, "shoe.inertia": (400.0, 18.0, 400.0, 0, 0, 0)}
    )
    (line,) = standing(light).warnings
    assert "the chain is tauter than makers ask for" in line
    assert f"not {100 * LEAST_SAG:g} to 4 %" in line


def test_machine_on_cells_says_how_it_stands():
    """Forces of cells, which no coordinates give, carry the weight."""
    case = small_case().on_cells(BekkerSoil.lete_sand())
    found = standing(case)
    weight = (case.gear.mass + case.track.shoe_count * case.shoe.mass) * case.gravity
    carried = float(found.history.normal_force.isel(time=0).sel(axis="z").sum())
    assert carried == pytest.approx(weight, rel=1e-3)
    assert f"at rest: the ground carries {1e-6 * carried:.4g} MN" in found.lines[0]


@pytest.fixture(scope="module")
def stalled():
    """A drive that has not the torque to move the machine."""
    drive = Drive(speed=StepProfile(times=(0.0, 0.05), values=(0.0, 0.3)))
    case = with_idler(Case.closed(), slack=0.005)
    return simulate(case.with_({"drive": drive, "gear.torque_limit": LIMIT}), 0.1, progress=False)


def test_drive_at_its_torque_limit_says_so(stalled):
    found = key_results(stalled).set_index("result")
    row = found.loc["time at the torque limit of the drive"]
    assert row["of"] == "tumbler"
    assert 0.03 < row["value"] < 0.1
    moment = np.abs(stalled.drive_moment.values)
    assert row["at"] == stalled.time.values[(moment >= 0.95 * LIMIT).argmax()]


def test_key_results_tell_idler_rollers_and_carriers_apart(stalled):
    found = key_results(stalled).set_index("result")
    after = stalled.wheel_force.sel(time=slice(0.05, None)).transpose("wheel", "time", "axis")
    force = np.linalg.norm(after.values, axis=-1).max(axis=1)
    force = dict(zip(stalled.wheel.values.tolist(), force, strict=True))
    assert found.loc["greatest force on the idler", "value"] == pytest.approx(1e-3 * force["idler"])
    for kind in ("roller", "carrier"):
        greatest = max(value for name, value in force.items() if name.startswith(kind))
        row = found.loc[f"greatest force on a {kind}"]
        assert row["value"] == pytest.approx(1e-3 * greatest)
        assert row["of"].startswith(f"wheel {kind}")
    assert "greatest force on a wheel" not in found.index
    assert found.loc["pretension at the start", "value"] == pytest.approx(
        1e-3 * float(stalled.pretension[0]), rel=1e-9
    )


def test_results_of_two_tracks_are_told_apart():
    """A page sets results of several runs side by side by their names."""
    found = key_results(standing(Case.shovel()).history).set_index("result")
    assert found.index.is_unique
    for side in ("right", "left"):
        assert found.loc[f"pretension at the start, {side}", "of"] == f"{side} idler"
        assert found.loc[f"sag at the start, {side}", "value"] == pytest.approx(45.0, rel=0.01)


def test_changes_of_more_than_tenfold_have_no_per_cent(stalled):
    first = {"way": stalled.drive_moment.rename("way")}
    table = difference_table(first, {"way": 11.5 * first["way"]})
    assert np.isnan(table["change in %"].item())
    table = difference_table(first, {"way": 2.0 * first["way"]})
    assert table["change in %"].item() == pytest.approx(100.0)


@pytest.fixture(scope="module")
def m113():
    """One track of a vehicle on sprung arms, on the ground under half of its weight."""
    return adjusted_track(read_case(machines()["m113"]).case)


def test_arms_bear_what_the_chain_pulls_down(m113):
    """Beyond the take-up at which it closes: springs of the arms and the ground, each by statics."""
    case = m113.with_({"gear.idler.pretension": None, "gear.idler.take_up": 0.158})
    rest = history_at_rest(case)
    (chain,) = hanging_chains(case, rest.dataset.isel(time=0))
    assert case.gear.assembled(case).sunk > 0.03
    assert chain.pretension > 30e3
    angles, gear = rest.arm_angle.isel(time=0).values, case.gear
    assert angles[0] < angles[-1] < -0.005
    for arm, angle in zip(gear.arms, angles, strict=True):
        x, z = arm.pivot
        c, s = math.cos(angle), math.sin(angle)
        # of the wheel and the COM from the pivot, in the frame, which hardly pitches
        wheel = np.array([[c, s], [-s, c]]) @ [gear.rollers[arm.roller - 1] - x, -z]
        com = np.array([[c, s], [-s, c]]) @ arm.com
        push = rest.wheel_force.sel(wheel=f"roller {arm.roller}").isel(time=0).values
        # on the wheel, about the axis of the pivot: of the rails, of the weight, of the spring
        moment = wheel[1] * push[0] - wheel[0] * push[2] + com[0] * arm.mass * case.gravity
        spring = arm.torque - arm.stiffness * angle
        assert moment == pytest.approx(-spring, rel=0.02)


@pytest.mark.slow
def test_pretension_of_a_machine_on_arms(m113):
    """The manual's gap of 9.5 to 15.9 mm to the second wheel, where the third is touched, has it as well."""
    (chain,) = chains_at_rest(tensioned(m113))
    assert chain.pretension == pytest.approx(23e3, rel=5e-3)
    trend = measurements.adjustment_trend(print)
    assert trend.agrees, trend.here


@pytest.mark.slow
def test_a_vehicle_on_fixed_wheels_takes_its_sag():
    rigid = derived(read_case(machines()["marder"]).datasheet.with_(suspension="rigid")).case
    track = adjusted_track(rigid)
    (chain,) = chains_at_rest(tensioned(track))
    assert chain.sag == pytest.approx(track.gear.wanted_sag, rel=3e-3)


@pytest.mark.parametrize(
    "growth", [0.01, pytest.param(0.02, marks=pytest.mark.slow), pytest.param(0.03, marks=pytest.mark.slow)]
)
def test_worn_chains_on_a_half_pitch_sprocket_find_their_sag(growth):
    """The idler follows the growth: N p / 2 for 1, less at most what the arc on the tumbler takes of it."""
    new = with_idler(adjusted_track(read_case(machines()["pc300lc"]).case), range=(-0.02, 0.3))
    worn = tensioned(new.with_({"gear.pitch_growth": growth}))
    track, tumbler = worn.track, worn.gear.tumbler
    chain = 0.5 * track.shoe_count * track.pitch
    radius = tumbler.radius(track.pitch)
    followed = (worn.gear.idler.take_up - tensioned(new).gear.idler.take_up) / growth
    assert chain - 0.5 * math.pi * radius < followed < chain
    (hanging,) = chains_at_rest(worn)
    assert hanging.sag == pytest.approx(new.gear.wanted_sag, rel=2e-3)
    # the highest bushes stand at the radius of their own pitch
    rest_of_it = history_at_rest(worn).dataset.isel(time=0)
    turn = rotation_matrices(rest_of_it.angles.transpose("shoe", "axis").values)
    lug = np.array(worn.gear.lugs(track)[0][1]) * [1.0, 0.0, 1.0]
    place = rest_of_it.position.transpose("shoe", "axis").values + turn @ lug
    apart = np.linalg.norm((place - rest_of_it.tumbler_position.values)[:, [0, 2]], axis=1)
    force = np.linalg.norm(rest_of_it.tooth_force.transpose("shoe", "axis").values, axis=1)
    highest = apart[force > 0.1 * force.max()].max()
    assert highest - radius == pytest.approx(growth * radius, rel=0.1)
