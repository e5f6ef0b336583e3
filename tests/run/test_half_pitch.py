"""A closed track on a half-pitch sprocket of 21 teeth, of which its chain uses every second gap."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case, StepProfile, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.results.history.summary import tension_along_chain
from exudyn_crawler.results.wear.work import run_work
from studies.closed import torque_by_tension

pytestmark = [pytest.mark.simulation, pytest.mark.slow]

SPROCKET = {
    "gear.tumbler.teeth": 21,
    "gear.tumbler.gaps_per_shoe": 2,
    "gear.tumbler.depth": None,
    "gear.tumbler.reach": None,
}


def half_pitch_case():
    """The papers' chain, taut on posts, on a sprocket of 21 teeth whose lowest pins are where they were."""
    case = Case.closed()
    tumbler = case.gear.tumbler
    pitch = case.track.pitch
    (x, z) = tumbler.place
    higher = pitch / (2.0 * math.sin(math.pi / 10.5)) - tumbler.radius(pitch)
    carriers = tuple((place, height + 2.0 * higher) for place, height in case.gear.carriers)
    changes = SPROCKET | {"gear.tumbler.place": (x, z + higher), "gear.carriers": carriers}
    return case.with_(changes | {"gear.support": "posts", "gear.idler.slack": 0.0})


@pytest.fixture(scope="module")
def rig():
    """More than a turn of the sprocket, which takes 10.5 shoes: a lug meets other teeth the second time."""
    case = half_pitch_case().on_cells(RockFloor.hard_floor())
    speed = Drive(speed=StepProfile(times=(0.0, 0.5), values=(0.0, 0.4)))
    return simulate(case.with_(drive=speed), 18.6, progress=False)


def test_a_turn_moves_half_as_many_shoes_as_there_are_teeth(rig):
    """By times at which shoes pass a place above; the chain neither jumps nor folds."""
    data = rig.dataset
    place = data.position.values - data.tumbler_position.values[:, None]
    ahead = place[..., 0] > 4.0
    rows = np.sort(np.nonzero(ahead[1:] & ~ahead[:-1] & (place[1:, :, 2] > 0.0))[0])
    rows = rows[data.time.values[rows] > 1.2]
    angle = data.tumbler_angle.values
    assert angle[-1] > 2.0 * math.pi
    shoes = (len(rows) - 1) / (angle[rows[-1]] - angle[rows[0]]) * 2.0 * math.pi
    assert shoes == pytest.approx(10.5, rel=3e-3)


def test_work_of_pins_on_posts_is_that_of_tensions_and_bends(rig):
    """By sweeps of 20 deg and more, against r (a_t (T1 + T2) + a_i (T3 + T4)); a quarter of a lap."""
    work = run_work(rig, 0.1, 20.0, begin=1.2)
    assert work.pins_by_threshold[20.0] == pytest.approx(work.by_tensions, rel=0.05)
    half = run_work(rig.every(2), 0.1, 20.0, begin=1.2)
    assert half.pins_by_threshold[20.0] == pytest.approx(work.pins_by_threshold[20.0], rel=0.02)


def test_torque_is_what_tension_and_weight_say_over_whole_pitches(rig):
    """By moments, by work and by means at 10.5 p / (2 pi)."""
    table = torque_by_tension(rig, (0.5, 0.6))
    torque = table["torque in kN m"]
    assert table["by moments in kN m"].to_numpy() == pytest.approx(torque, rel=5e-3)
    assert table["by work in kN m"].to_numpy() == pytest.approx(torque, rel=3e-3)
    assert table["by means of tension in kN m"].to_numpy() == pytest.approx(torque, rel=1e-2)


def test_chain_has_tension_everywhere(rig):
    assert (tension_along_chain(rig).least.values > 0.0).all()
