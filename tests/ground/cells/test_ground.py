"""Ground of cells: points, tangents, supports, forces on a coarse grid, and what the map remembers."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from benchmarks import cells as benchmark
from exudyn_crawler.case.parameters.heights import Heights, Ridge, Roughness, Stone
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.tiles import SIDE
from tests.ground.cells import driving
from tests.ground.cells.driving import (
    DOWN,
    LENGTH,
    LOAD,
    ROCK,
    SAND,
    WIDTH,
    Shoe,
    frame,
    ground,
    points_of,
    turn,
)

ROUGH = Heights(roughness=Roughness(spectrum=256e-6, seed=3))


def test_clipped_areas_and_centroids_are_those_of_the_outline():
    random, cells = np.random.default_rng(1), ground(SAND)
    for _ in range(300):
        R = turn(random.normal(0, 0.02, 3)) @ turn([0, 0, random.uniform(-3, 3)])
        now = frame([*random.uniform(-1, 4, 2), 0.0], R)
        cells.cover(now, now)
        points = points_of(cells)
        areas = cells.shoes.areas[0, : cells.shoes.counts[0]]
        c = cells.shoes.corners @ R.T
        d, e = c[2] - c[0], c[3] - c[1]
        true = 0.5 * abs(d[0] * e[1] - d[1] * e[0])
        assert areas.sum() == pytest.approx(true, rel=1e-11)
        assert np.abs(areas @ points[:, :2]).max() < 1e-11 * true


def test_a_shoe_that_is_nowhere_meets_no_ground():
    cells = ground(SAND)
    level = np.eye(3)
    for place, R in (([np.nan, 0.0, 0.0], level), ([0.0, 1e300, 0.0], level), (np.zeros(3), -level)):
        cells.cover(frame(place, R), frame([0.0, 0.0, 0.0]))
        assert cells.shoes.counts[0] == 0
        assert not cells.press(frame(place, R)).any()


def test_no_map_is_made_up_to_a_shoe_that_went_astray():
    cells = ground(SAND, shoes=2)
    before = np.vstack([frame([0.0, y, 0.0]) for y in (0.0, 9.0)])
    now = np.vstack([frame(place) for place in ([0.01, 0.0, 0.0], [14e3, 780e3, 0.0])])
    cells.cover(now, before)
    assert cells.shoes.counts[0] > 0
    assert cells.shoes.counts[1] == 0
    assert cells.tiles.table.size < 20


CURVED = ROCK.with_(exponent=1.5, stiffness=7e10)  # 2e8 Pa/m at 0.2 mm


@pytest.mark.parametrize(
    ("law", "rough", "step"), [(SAND, 0.01, 1e-8), (ROCK, 1e-4, 1e-10), (CURVED, 1e-4, 1e-10)]
)
def test_tangents_are_the_differences_of_the_wrench(law, rough, step):
    """While shoes turn at 0.1 rad/s, the turning arms' velocities make the difference of 0.2 %."""
    random = np.random.default_rng(2)
    heights = Heights(roughness=Roughness(spectrum=256e-6 * (rough / 0.009) ** 2, seed=2))
    shoe, errors = Shoe(law, [3.0, 3.0, -2.0 * rough], turn([0, 0, 0.3]), heights=heights), []
    for trial in range(20):
        turning = trial < 10
        r = shoe.r + np.r_[random.normal(0, 0.01, 2), random.normal(0, 0.4 * rough)]
        R = turn(random.normal(0, 0.2 * rough, 3)) @ shoe.R
        v, w = random.normal(0, 0.1, 3), random.normal(0, 0.1, 3) * turning
        shoe.cover(r, R)
        by = np.zeros((2, 6, 6))
        for n, weights in enumerate(((1.0, 0.0), (0.0, 1.0), (2.0, 3.0))):
            shoe.press(r, R, v, w, weights)
            if n < 2:
                by[n] = shoe.tangent
        assert_allclose(shoe.tangent, 2.0 * by[0] + 3.0 * by[1], rtol=1e-9, atol=1e-9 * np.abs(by).max())
        by_place, by_velocity = np.zeros((2, 6, 6))
        for k, e in enumerate(np.eye(6)):
            pair = [shoe.press(r + x[:3], turn(x[3:]) @ R, v, w) for x in (step * e, -step * e)]
            by_place[:, k] = (pair[0] - pair[1]) / (2.0 * step)
            pair = [shoe.press(r, R, v + x[:3], w + x[3:]) for x in (1e-5 * e, -1e-5 * e)]
            by_velocity[:, k] = (pair[0] - pair[1]) / 2e-5
        assert_allclose(by[1], by_velocity, rtol=0, atol=1e-6 * np.abs(by_velocity).max())
        errors.append(np.abs(by[0] - by_place).max() / np.abs(by_place).max())
        shoe.press(r, R, v, w)
        if trial % 3 == 2:
            shoe.accept(r, R)
        else:
            shoe.ground.commit()
    assert max(errors[10:]) < 1e-6
    assert max(errors[:10]) < 5e-3


def test_a_cell_that_a_shoe_has_left_is_sheared_anew_and_sand_keeps_its_rut():
    place = np.array([1.5, 3.0])
    for law, depth in ((BekkerSoil.lete_sand("chrono"), 0.02), (ROCK, 2e-4)):
        shoe = Shoe(law, [*place, 0.0])
        for slip in np.linspace(0.0, 0.01, 20):
            slid = shoe.move([place[0] + slip, place[1], -depth])
        lifted = shoe.move([place[0] + 0.01, place[1], 0.05])
        again = shoe.move([place[0] + 0.01, place[1], -depth])
        assert -slid[0] > 0.3 * slid[2]
        assert not lifted.any()
        assert abs(again[0]) < 1e-12 * slid[2]
        half = shoe.move([place[0] + 0.01, place[1], -0.5 * depth])[2]
        assert (half == 0.0) == (law is not ROCK)


def shares(shoe):
    """Shares of the load on either side of the middle."""
    y = shoe.points[:, 1]
    return [shoe.force[beside, 2].sum() / LOAD for beside in (y < 0, y > 0)]


def test_supports_carry_their_shares():
    """Two ridges under a stiff shoe: by the lever."""
    ridges = tuple(Ridge(x=2.0, y=y, heading=0.0, height=0.3, width=0.0, flank=0.25) for y in (1.85, 4.15))
    shoe = Shoe(ROCK, [2.0, 3.0, 0.3], heights=Heights(parts=ridges))
    shoe.settle([0, 0, -LOAD, -0.4 * LOAD, 0, 0], steps=10)
    # the ridges' tops are two cells wide
    assert_allclose(shares(shoe), [0.5 - 0.4 / 2.3, 0.5 + 0.4 / 2.3], atol=2e-3)


def test_banks_of_a_bridged_rut_carry_as_a_beam_on_springs_does():
    rut = Ridge(x=2.0, y=3.0, heading=0.0, height=-0.3, width=1.6, flank=0.2)
    shoe = Shoe(ROCK, [2.0, 3.0, 0.0], heights=Heights(parts=(rut,)))
    shoe.settle([0, 0, -LOAD, -0.2 * LOAD, 0, 0], steps=10)
    a, b = 0.5 * rut.width + rut.flank, 0.5 * WIDTH
    even, lean = 0.5 / (b - a), 0.2 * 1.5 / (b**3 - a**3)  # pressure: even + lean y
    wanted = [even * (b - a) + sign * lean * (b * b - a * a) / 2.0 for sign in (-1.0, 1.0)]
    assert_allclose(shares(shoe), wanted, atol=1e-3)


def test_a_pass_beside_a_rut_meets_old_and_fresh_ground():
    """Cells at the rut's edge count as rut: an error of the order of the cell, 1.5 % at 0.1 m."""
    law, (first, second, shift) = SAND.constants(LENGTH), (0.035, 0.028, 0.13)
    p = [law.k * z**law.exponent for z in (first, second)]
    modulus = max(law.reload_growth * first, p[0] / first)
    old, fresh = max(0.0, p[0] - modulus * (first - second)), p[1]
    wanted, ratios = WIDTH * ((LENGTH - shift) * old + shift * fresh), []
    for x in 1.5 + 0.0125 * np.arange(8):
        shoe = Shoe(SAND, [x, 3.0, 0.0])
        for place in ((x, -first), (x, 0.01), (x + shift, 0.01)):
            shoe.move([place[0], 3.0, place[1]])
        ratios.append(shoe.move([x + shift, 3.0, -second])[2] / wanted)
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.02)


STONES = Heights(parts=tuple(Stone(x=2.0, y=y, height=0.02, width=0.2, flank=0.25) for y in (1.8, 3.9)))


@pytest.mark.parametrize(
    ("law", "heights", "lean", "bounds"),
    [
        (SAND, Heights(), -0.3, (0.03, 0.008)),
        (SAND, ROUGH, 0.0, (0.03, 0.008)),
        (ROCK, STONES, 0.0, (0.08, 0.03)),
    ],
)
def test_coarse_grid_keeps_force_moment_and_bending(law, heights, lean, bounds, monkeypatch):
    start = 0.06 if law is SAND else 0.02  # a stiff shoe has to begin where it touches
    shoe = Shoe(law, [2.0, 3.0, start], turn([0, 0, 0.1]), heights=heights)
    shoe.settle([3e4, 0, -LOAD, lean * LOAD, 0, 0])
    force, points = shoe.force @ shoe.R, shoe.points
    true = bending(points[:, 1], force[:, 2], cuts := np.linspace(-WIDTH / 2, WIDTH / 2, 701))
    for nodes, bound in zip((9, 17), bounds, strict=True):
        monkeypatch.setattr("exudyn_crawler.ground.cells.ground.COARSE", (3, nodes))
        grid = shoe.ground.coarse_forces(frame(shoe.r, shoe.R))[0]
        x, y = np.linspace(-LENGTH / 2, LENGTH / 2, 3)[:, None], np.linspace(-WIDTH / 2, WIDTH / 2, nodes)
        assert_allclose(grid.sum(axis=(0, 1)), force.sum(axis=0), rtol=1e-12, atol=1e-12 * LOAD)
        for arm, arms in ((x, points[:, 0]), (y, points[:, 1])):
            moments = (grid * arm[..., None]).sum(axis=(0, 1)), arms @ force
            assert_allclose(*moments, rtol=1e-12, atol=1e-12 * LOAD)
        coarse = bending(y, grid[..., 2].sum(axis=0), cuts)
        assert np.abs(coarse - true).max() < bound * np.abs(true).max()
        at_nodes = bending(y, grid[..., 2].sum(axis=0), y), bending(points[:, 1], force[:, 2], y)
        assert_allclose(*at_nodes, atol=1e-12 * LOAD)


def bending(y, forces, cuts):
    """Moment about x at cuts of the forces beyond them, less that of a load in the middle."""
    return np.array([(forces * np.maximum(y - cut, 0.0)).sum() + LOAD * min(cut, 0.0) for cut in cuts])


def test_halving_the_cells_changes_little():
    found, rough = [], ROUGH.with_({"roughness.spectrum": 64e-6})
    for cell in (0.1, 0.05):
        shoe = Shoe(SAND, [2.0, 3.5, 0.06], turn([0, 0, 0.3]), heights=rough, cell=cell)
        shoe.settle([2e4, 0, -LOAD, -0.35 * LOAD, 0.05 * LOAD, 0])
        sunk, tilt, peak = -shoe.r[2], shoe.R[2, 1], shoe.traction.max()
        for _ in range(50):
            pull = shoe.move(shoe.r + np.array([2e-3, 0, 0]))[0]
        found.append([tilt, sunk, peak, pull])
    assert_allclose(found[1][1:], found[0][1:], rtol=0.02)
    assert found[1][0] == pytest.approx(found[0][0], rel=0.03)


def test_sliding_force_does_not_feel_the_cells():
    shoe = Shoe(SAND, [1.5, 3.0, 0.0], turn([0, 0, 0.1]))
    shoe.move([1.5, 3.0, -0.02])
    forces = np.array([shoe.move([1.5 + 1e-3 * k, 3.0, -0.02]) for k in range(1, 401)])
    assert np.ptp(forces[:, 2]) < 1e-12 * forces[-1, 2]
    assert np.ptp(forces[100:, 0]) < 5e-4 * -forces[-1, 0]


def test_two_shoes_share_cells_without_changing_their_sum():
    cells = ground(SAND, shoes=2)
    here, there = (
        np.concatenate([frame([x, 3, -0.0167]) for x in both]) for both in ((1.23, 1.88), (1.24, 1.87))
    )
    driving.step(cells, here, here)
    before, after = (driving.step(cells, there, start)[:, 0] for start in (here, there))
    for pull in (before, after):
        assert abs(pull.sum()) < 1e-9 * abs(pull[0])
    assert abs(after[0]) < abs(before[0])


def frames(number):
    """Two shoes that sink, slide, turn and leave tiles behind, at the end of a step."""
    t = 0.02 * number
    depth = -0.01 * (1.0 + np.sin(3.0 * t))
    return np.concatenate(
        [frame([x + 2.0 * t, -0.1 + 0.3 * np.sin(t), depth], turn([0.0, 0.0, 0.1 * t])) for x in (-1.0, -0.3)]
    )


def walk(cells, first, last):
    """Wrenches of accepted steps."""
    return np.array([driving.step(cells, frames(k + 1), frames(k)) for k in range(first, last)])


@driving.BOTH_LAWS
def test_a_restored_ground_goes_on_bit_for_bit(law):
    whole, first = (ground(law, ROUGH, shoes=2) for _ in range(2))
    wrenches = walk(whole, 0, 80)
    walk(first, 0, 37)
    state = {name: values.copy() for name, values in first.state().items()}
    assert len(state["cells"]) == len(np.unique(state["cells"], axis=0)) == len(state["memory"])
    second = ground(law, ROUGH, shoes=2)
    second.restore(state)
    assert_array_equal(walk(second, 37, 80), wrenches[37:])
    ends = whole.state(), second.state()
    orders = [np.lexsort(one["cells"].T) for one in ends]
    for name in ends[0].keys() - {"held"}:
        assert_array_equal(*(one[name][order] for one, order in zip(ends, orders, strict=True)))
    # a run that went on after a checkpoint, and one that is set back to it
    walk(first, 37, 60)
    first.restore(state)
    assert_array_equal(walk(first, 37, 80), wrenches[37:])


def test_only_accepted_steps_are_remembered():
    one, other = (ground(SAND, ROUGH, shoes=2) for _ in range(2))
    for cells in (one, other):
        walk(cells, 0, 10)
    other.cover(frames(30), frames(10))
    for number in (25, 30, 28):
        other.press(frames(number), (1.0, 10.0))
    assert_array_equal(walk(one, 10, 20), walk(other, 10, 20))


def test_tiles_are_made_where_shoes_come_alone():
    cells = ground(SAND)
    for x in (0.0, 500.0, -300.0):
        driving.step(cells, *[frame([x + 1.0, 1.0, -0.01])] * 2)
    assert len(cells.tiles.planes) <= 12
    state = cells.state()
    assert state["memory"].nbytes < 3 * 48 * (0.65 / 0.1 + 2) * (3.505 / 0.1 + 2)
    assert len(state["held"]) < len(state["cells"])
    x = cells.tiles.cell * (state["cells"][:, 0] + 0.5)
    assert set(np.round(x, -2)) == {-300.0, 0.0, 500.0}
    assert SIDE == 32


def test_the_benchmark_of_a_steps_parts_presses_16_shoes(monkeypatch):
    """Its figures are in benchmarks/README.md; here five times the 0.2 and 0.4 ms that are wanted."""
    monkeypatch.setattr(benchmark, "CALLS", 10)
    table = pd.DataFrame(benchmark.parts()).set_index(["ground", "what"])
    assert set(table["points"]) == {4356}
    for ground_name in benchmark.GROUNDS:
        assert 0.0 < table["ms"][ground_name, "residual"] < 1.0
        assert 0.0 < table["ms"][ground_name, "with tangents"] < 2.0


def test_strips_press_with_their_area_and_sink_as_plates_of_their_breadth():
    breadth = 0.05
    share = 3.0 * breadth / LENGTH
    shoe = Shoe(SAND, np.zeros(3), share=share, breadth=breadth)
    shoe.settle(DOWN)
    assert shoe.force[:, 2].sum() == pytest.approx(LOAD, rel=1e-6)
    areas = shoe.ground.shoes.areas[0, : shoe.ground.shoes.counts[0]]
    assert areas.sum() == pytest.approx(3.0 * breadth * WIDTH, rel=1e-9)
    pressure = LOAD / (3.0 * breadth * WIDTH)
    assert_allclose(shoe.traction, pressure, rtol=1e-6)
    assert -shoe.r[2] == pytest.approx(SAND.sinkage(pressure, breadth), rel=1e-6)
    # cells that stay covered keep their shear
    ahead = np.array([0.002, 0.0, 0.0])
    slid = [shoe.move(shoe.r + ahead)[0] for _ in range(2)]
    whole = Shoe(SAND, np.zeros(3))
    whole.settle(DOWN * pressure * LENGTH * WIDTH / LOAD)
    kept = [whole.move(whole.r + ahead)[0] for _ in range(2)]
    assert slid[1] / slid[0] == pytest.approx(kept[1] / kept[0], rel=1e-2)
