"""Displacements of a shoe under its check cases: at rest on the ground, and under blows."""

from collections.abc import Callable, Sequence

import numpy as np

from exudyn_crawler.results.checks import cases as ready
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe, inside
from exudyn_crawler.settings.fields import errors_at
from fem.body import supports

BLOW_STEPS = 8  # number of iterations for the force of a blow; each more than halves the error
MEGA = 1e6


def static_answers(
    shoe: CheckedShoe, cases: Sequence[ready.CheckCase], say: Callable[[str], None]
) -> tuple[np.ndarray, np.ndarray, dict[str, tuple[float, float]]]:
    """Return loads (3 n + 24, k) with the ground's, displacements (n, 3, k), and blows (`_blow`) by case."""
    each = []
    blows = {}
    for case in cases:
        with errors_at(f"case {case.name!r}"):
            load_case = case
            if case.energy is not None:
                load_case, blows[case.name] = _blow(shoe, case, case.energy)
            each.append(shoe.loads(load_case))
    say(f"{len(cases)} cases in balance: answers of {len(shoe.mesh.nodes)} nodes")
    loads = np.stack(each, axis=-1)
    answers = shoe.answers(loads)
    below = np.zeros_like(loads)
    carried = [k for k, case in enumerate(cases) if case.ground is not None]
    for k in carried:
        with errors_at(f"case {cases[k].name!r}"):
            pushed = rest_on_ground(shoe, cases[k], each[k], answers[..., k]).forces
        shoe.parts(below)[0][2::3, k] = shoe.bed.points.shapes.T @ pushed
    say("answers to what the ground pushes with")
    if carried:
        answers[..., carried] += shoe.answers(below[:, carried])
    return loads + below, answers, blows


def rest_on_ground(
    shoe: CheckedShoe, case: ready.CheckCase, loads: np.ndarray, answer: np.ndarray
) -> supports.Rest:
    """Return the rest of the shoe on the ground of a case."""
    assert case.ground is not None
    points = shoe.bed.points
    x = points.positions[:, :2]
    gap = np.zeros(len(x))
    stiffness = np.full(len(x), case.ground.stiffness)
    for part in case.ground.parts:
        below = inside(x, part, [0, 1])
        gap[below] = -part.height
        stiffness[below] = part.stiffness
    shift = points.shapes @ answer[:, 2]
    return shoe.bed.settle(shoe.resultant(loads), shift, gap, stiffness)


def _blow(
    shoe: CheckedShoe, case: ready.CheckCase, energy: float
) -> tuple[ready.CheckCase, tuple[float, float]]:
    """Return a blow's case with scaled pressures, their force (MN), and compliance of shoe and ground (m/N).

    The work of the pressures, half of force times displacement, is the energy (J). All of it goes into shoe
    and ground, from the rest under the other loads: rope, crowd and dipper do not yield.
    """
    alone = shoe.loads(case.with_(pressures=(), energy=None))
    blow = shoe.loads(case.with_(energy=None)) - alone
    answers = shoe.answers(np.stack((alone, blow), axis=-1))
    forces = shoe.parts(blow)[0].reshape(-1, 3)
    own_way = float(np.sum(forces * answers[..., 1]))
    whole = float(np.linalg.norm(forces.sum(axis=0)))
    below = shoe.bed.points.shapes @ answers[:, 2, 1]
    resultant = shoe.resultant(blow)[supports.UPRIGHT]

    def way(times: float) -> float:
        """Return the work of the unit blow's forces on the ground's displacement, N m, by reciprocity."""
        rest = rest_on_ground(shoe, case, alone + times * blow, answers @ (1.0, times))
        return float(rest.forces @ below + resultant @ rest.motion)

    at_rest = way(0.0)
    times = 1.0
    for _ in range(BLOW_STEPS):
        work = own_way + (way(times) - at_rest) / times  # work of the unit blow on its own displacement, J
        times = np.sqrt(2.0 * energy / work)
    scaled = tuple(
        pressure.with_(force=tuple(times * part for part in pressure.force)) for pressure in case.pressures
    )
    return case.with_(pressures=scaled, energy=None), (times * whole / MEGA, work / whole**2)
