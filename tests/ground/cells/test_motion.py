"""Shoes on cells in time: energy closes, nothing creeps, Newton's method is quick; pull over slip."""

import math

import numpy as np
import pytest

from exudyn_crawler.case.parameters.heights import Heights, Roughness
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from tests.ground.cells import driving
from tests.ground.cells.driving import AREA, DOWN, LENGTH, LOAD, MASS, ROCK, SAND, WIDTH, Driven, frame, turn

KEEPS_RUTS = BekkerSoil.lete_sand("chrono")
LAWS = pytest.mark.parametrize("law", [SAND, KEEPS_RUTS, ROCK], ids=["wong", "chrono", "rock"])


def stored_energy(shoe):
    """Elastic energy of all cells under a shoe on sand after `press`, J."""
    law, constants, total = SAND, SAND.constants(LENGTH), 0.0
    shoes = shoe.ground.shoes
    for point, area, trial in zip(shoe.points, shoes.areas[0], shoes.trial[0], strict=False):
        depth = point[6] - point[3:6] @ (shoe.r + shoe.R @ point[:3])
        modulus, stiffness = law.kernel.prepare(constants, trial[0], trial[1])
        if modulus > 0.0:
            pressure = max(0.0, trial[1] - modulus * (trial[0] - depth))
            total += area * pressure**2 / (2.0 * modulus)
        if stiffness > 0.0:
            total += area * (trial[2] ** 2 + trial[3] ** 2) / (2.0 * stiffness)
    return total


def test_energy_of_a_drop_is_stored_or_lost():
    """The rest is the trapezoid's over the first contact: 1.4 % at 2 ms, 0.3 % at 0.5 ms."""
    rests = []
    for h in (2e-3, 5e-4):
        shoe = Driven(SAND, [3.0, 3.0, 0.018], turn([0.01, 0, 0.1]), h=h, rho=1.0)
        shoe.v[:] = [0.3, 0.15, -0.5, 0, 0, 0.3]
        start, old, work, least, lost = shoe.kinetic_energy(), np.zeros(6), 0.0, 0.0, 0.0
        for _ in range(round(0.3 / h)):
            r, omega = shoe.r, shoe.v[3:].copy()
            shoe.step(DOWN)
            wrench = shoe.ground.shoes.wrench[0].copy()
            turned = 0.5 * h * (omega + shoe.v[3:])
            work -= 0.5 * (wrench + old) @ np.r_[shoe.r - r, turned]
            old, before, lost = wrench, lost, work - stored_energy(shoe)
            least = min(least, lost - before)
        put_in = start + LOAD * (0.018 - shoe.r[2])
        rests.append(abs(put_in - shoe.kinetic_energy() - work) / put_in)
        assert least > -1e-5 * lost
        assert 0.5 * put_in < lost < put_in
    assert rests[0] < 0.02
    assert rests[1] < 0.005


def on_side_slope(law, h):
    """A shoe at rest on a side slope of 10 %, below friction."""
    lean = turn([math.atan(0.1), 0, 0])
    shoe = Driven(law, [1.5, 3.0, 1e-4], lean, h=h, heights=Heights(slope_y=0.1, level=-0.3))
    shoe.settle(DOWN)
    return shoe


@LAWS
def test_a_loaded_shoe_does_not_creep_down_a_slope(law):
    """An hour with 1 % noise of the load: it moves at first, and stays."""
    shoe, steps = on_side_slope(law, 2.0), 1800
    start, places = shoe.r.copy(), []
    for load in 1.0 + 0.01 * np.random.default_rng(9).standard_normal(steps):
        shoe.step(load * DOWN)
        places.append(np.linalg.norm(shoe.r[:2] - start[:2]))
    assert max(places) < 1e-3
    assert abs(places[-1] - places[steps // 2]) < 1e-5


def test_a_struck_shoe_comes_to_rest_where_it_was():
    shoe = on_side_slope(SAND, 2e-3)
    start, y = shoe.r[1], []
    shoe.v[1] = 0.02
    for _ in range(600):
        shoe.step(DOWN)
        y.append(shoe.r[1])
    assert abs(y[-1] - start) < 2e-4
    assert np.ptp(y[-100:]) < 1e-5


@driving.BOTH_LAWS
def test_newton_takes_few_iterations_through_drop_drag_pulse_and_lift(law):
    rough = Roughness(spectrum=64e-6 if law is SAND else 16e-6, seed=4)
    start = [3.0, 3.0, 0.02 if law is SAND else 0.012]
    shoe = Driven(law, start, turn([0.01, 0.005, 0.15]), heights=Heights(roughness=rough))
    lifted = 0
    for k in range(2800):
        t = (k + 1) * shoe.h
        f = LOAD * (1.0 if t < 2 else 1.0 + 0.6 * math.sin(4.0 * math.pi * (t - 2.0)))
        if t > 4.5:
            f = LOAD if t > 5.0 else -1.5e5
        target = 0.0 if t < 0.5 else 0.1 * math.sin(2.0 * math.pi * 0.8 * (t - 0.5))
        moment = 0.2 * f * math.sin(2.0 * math.pi * 0.7 * t) if 0.5 < t < 4.5 else 0.0
        servo = (2e6 if t > 0.5 else 0.0, target)
        shoe.step(np.array([0, 0, -f - MASS * 9.81, moment, 0, 0]), servo)
        lifted += shoe.ground.shoes.wrench[0, 2] <= 0.0
    assert lifted > 10
    assert np.mean(shoe.iterations) < (1.2 if law is SAND else 1.7)
    assert np.percentile(shoe.iterations, 99) <= (2 if law is SAND else 4)
    assert max(shoe.iterations) <= 8


@pytest.mark.parametrize("slip", [0.01, 0.1, 0.3])
def test_drawbar_pull_is_the_integral_of_janosis_curve(slip):
    """13 shoes laid one after the other, each sliding back over the ground: mean over the last laying.

    The ground remembers how far it was slid: ``j = i x / (1 - i)``, against ``i x`` of a point of the track.
    """
    p, number = 200e3, 13
    constants = SAND.constants(LENGTH)
    z = (p / constants.k) ** (1.0 / constants.exponent)
    strength = p * (constants.friction + constants.cohesion / (p + 1e3))
    cells, slid = driving.ground(SAND, shoes=number), LENGTH * slip
    x = 11.0 - LENGTH * np.arange(number)
    steps, pulls = max(40, math.ceil(slid / 2e-3)), []

    def frames(x):
        return np.concatenate([frame([at - LENGTH / 2, 2.1, -z]) for at in x])

    for laid in range(number + 2):
        if laid:
            x = np.r_[x[0] + LENGTH, x[:-1]]
        for _ in range(steps):
            before, x = x, x - slid / steps
            pulls.append(driving.step(cells, frames(x), frames(before))[:, 0].sum())
    length, K = number * LENGTH, constants.deformation * (1.0 - slip) / slip
    wanted = WIDTH * strength * (length - K * (1.0 - math.exp(-length / K)))
    assert np.mean(pulls[-steps:]) == pytest.approx(wanted, rel=0.005)
    assert p * AREA * number * 0.5 < wanted < strength * AREA * number
