"""Equations of the `constrained` formulation, counted in what Exudyn assembled, against the K-chapter."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from exudyn_crawler import Case, Terrain
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.model.state import pin_name
from studies.grounds import plain
from tests.model.both import linearized

SLOW = pytest.mark.slow
CASES = {
    "straight": Case.translation(),
    "turn": Case.turning(),
    "fine": plain(Case.translation()).with_(terrain=Terrain.stress()),
}


class Counted(NamedTuple):
    """System, its algebraic equations without the norms of Euler parameters, and what each of these does.

    The papers' count has no Euler parameters, of which Exudyn has one more a shoe with an equation for their
    norm. `position` and `rate` tell what constrains positions, and rates only; `dummy` what does neither.
    """

    system: ExudynSystem
    rows: list[int]
    position: np.ndarray
    rate: np.ndarray
    dummy: np.ndarray
    gradients: np.ndarray  # (equations, coordinates of a state), of those that constrain

    def places(self, item: str) -> list[int]:
        """Where an item's multipliers are among the counted equations."""
        layout = self.system.layout
        first, size = layout.first_multiplier(item), dict(layout.multipliers)[item]
        return [self.rows.index(row) for row in self.system._rows[first : first + size]]


@cache
def counted(name: str) -> Counted:
    system = ExudynSystem(CASES[name].with_(terrain_formulation="constrained"))
    matrices, still = linearized(system.mbs), np.zeros(system.layout.coordinate_count)
    by_rates = np.column_stack([system._coordinates.of_state(still, e, still)[1] for e in np.eye(len(still))])
    data = system.mbs.systemData
    norms = {row for body in system._shoe_bodies for row in data.GetObjectLTGAE(body)}
    rows = [row for row in range(len(data.GetAECoordinates())) if row not in norms]
    by_position, by_rate = (one[rows] @ by_rates for one in (matrices.position, matrices.velocity))
    position = np.any(by_position != 0.0, axis=1)
    rate = np.any(by_rate != 0.0, axis=1) & ~position
    gradients = np.vstack((by_position[position], by_rate[rate]))
    return Counted(system, rows, position, rate, matrices.dummy[rows], gradients)


@pytest.mark.parametrize(
    ("name", "bodies", "position", "rate"),
    [
        # 60 of links, 147 + 36 of terrain joints, 2 holds; 100 held rotations and the drive: 346
        ("straight", 63, 60 + 147 + 36 + 2, 100 + 1),
        ("turn", 63, 60 + 147 + 36 + 2, 100 + 2),
        pytest.param("fine", 13 + 247, 60 + 738 + (18 * 13 + 19 * 12 - 246) + 2, 494 + 1, marks=SLOW),
    ],
)
def test_equations_are_as_many_as_the_chapter_counts(name, bodies, position, rate):
    """The drive can be integrated to a position: by its formula 378 - 245 - 1 = 132 degrees of freedom."""
    found = counted(name)
    sizes = found.system.layout.coordinate_count, found.position.sum(), found.rate.sum()
    assert sizes == (6 * bodies, position, rate)
    # every other row only puts a multiplier to zero
    assert np.array_equal(found.dummy, ~(found.position | found.rate))
    assert found.rate[found.places("drive")].all()
    assert found.rate[found.places("turn")].all() == (name == "turn")


def test_links_have_three_spherical_and_two_parallel_equations_each():
    found = counted("straight")
    rows = np.array([found.places(pin_name("right", link)) for link in range(1, 13)])
    assert rows.shape == (12, 5)
    assert found.position[rows].all()


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("name", "free"),
    [("straight", 17 + 15), ("turn", 16 + 15), pytest.param("fine", 17 + 32, marks=SLOW)],
)
def test_the_equations_are_independent_and_leave_the_right_motion(name, free):
    gradients = counted(name).gradients
    assert np.linalg.matrix_rank(gradients) == len(gradients)
    assert gradients.shape[1] - len(gradients) == free
