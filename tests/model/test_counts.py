"""Equations of the `constrained` formulation, counted in what Exudyn assembled, against the K-chapter."""

from functools import cache

import numpy as np
import pytest

from exudyn_crawler import Case, Terrain
from exudyn_crawler.model.exudyn.system import ExudynSystem
from exudyn_crawler.model.state import pin_name
from studies.grounds import plain
from tests.model.both import Matrices, linearized

CASES = {
    "straight": Case.translation(),
    "turn": Case.turning(),
    "fine": plain(Case.translation()).with_(terrain=Terrain.stress()),
}


@cache
def assembled(name: str) -> tuple[ExudynSystem, Matrices]:
    """System and its equations in the coordinates of a state.

    The papers' count has no Euler parameters, of which Exudyn has one more a shoe with an equation for their
    norm: these rows are left out.
    """
    system = ExudynSystem(CASES[name].with_(terrain_formulation="constrained"))
    matrices, still = linearized(system.mbs), np.zeros(system.layout.coordinate_count)
    convert = system._coordinates.of_state
    by_rates = np.column_stack([convert(still, e, still)[1] for e in np.eye(len(still))])
    rows = counted(system)
    return system, Matrices(
        by_rates.T @ matrices.mass @ by_rates,
        by_rates.T @ matrices.stiffness @ by_rates,
        by_rates.T @ matrices.damping @ by_rates,
        matrices.position[rows] @ by_rates,
        matrices.velocity[rows] @ by_rates,
        matrices.dummy[rows],
    )


def counted(system: ExudynSystem) -> list[int]:
    """Exudyn's algebraic equations without the norms of Euler parameters."""
    data = system.mbs.systemData
    norms = {row for body in system._shoe_bodies for row in data.GetObjectLTGAE(body)}
    return [row for row in range(len(data.GetAECoordinates())) if row not in norms]


def multipliers(system: ExudynSystem, item: str):
    """Where an item's multipliers are among the counted equations."""
    layout, rows = system.layout, counted(system)
    first = layout.first_multiplier(item)
    size = dict(layout.multipliers)[item]
    return np.array([rows.index(row) for row in system._rows[first : first + size]])


def effective(matrices: Matrices):
    """Rows that constrain motion: positions, or rates only."""
    position = np.any(matrices.position != 0.0, axis=1)
    return position, np.any(matrices.velocity != 0.0, axis=1) & ~position


def test_translation_has_346_equations_for_378_coordinates_of_63_bodies():
    _, matrices = assembled("straight")
    position, rate = effective(matrices)
    assert matrices.mass.shape == (378, 378)
    # 60 of links, 147 + 36 of terrain joints, 2 holds; 100 held rotations and the drive
    assert (position.sum(), rate.sum()) == (60 + 147 + 36 + 2, 100 + 1)
    # every other row only puts a multiplier to zero
    assert np.array_equal(matrices.dummy, ~(position | rate))


def test_turning_has_one_equation_more():
    system, matrices = assembled("turn")
    position, rate = effective(matrices)
    assert position.sum() + rate.sum() == 347
    assert rate[multipliers(system, "turn")].all()


def test_links_have_three_spherical_and_two_parallel_equations_each():
    system, matrices = assembled("straight")
    position, _ = effective(matrices)
    rows = np.array([multipliers(system, pin_name("right", link)) for link in range(1, 13)])
    assert rows.shape == (12, 5)
    assert position[rows[:, :3]].sum() == 36
    assert position[rows[:, 3:]].sum() == 24


@pytest.mark.parametrize("case", ["straight", "turn"])
def test_the_chapters_formula_gives_132_degrees_of_freedom(case):
    system, matrices = assembled(case)
    position, rate = effective(matrices)
    # the drive can be integrated to a position
    nonholonomic = rate.sum() - rate[multipliers(system, "drive")].all()
    equations = position.sum() + rate.sum()
    assert len(matrices.mass) - (equations - nonholonomic) == 132


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("case", "free"),
    [("straight", 17 + 15), ("turn", 16 + 15), pytest.param("fine", 17 + 32, marks=pytest.mark.slow)],
)
def test_the_equations_are_independent_and_leave_the_right_motion(case, free):
    _, matrices = assembled(case)
    position, rate = effective(matrices)
    rows = np.vstack((matrices.position[position], matrices.velocity[rate]))
    assert np.linalg.matrix_rank(rows) == len(rows)
    assert len(matrices.mass) - len(rows) == free


@pytest.mark.slow
def test_the_fine_grid_follows_the_same_rule():
    _, matrices = assembled("fine")
    position, rate = effective(matrices)
    assert len(matrices.mass) == 6 * (13 + 247)
    neighbours = 18 * 13 + 19 * 12
    assert position.sum() == 60 + 3 * 246 + (neighbours - 246) + 2
    assert rate.sum() == 2 * 247 + 1
