"""Small systems of tables without ground: hinged rigid bodies, and their motion."""

import numpy as np

from exudyn_crawler.ground.cells.kernel import ShoePoints
from exudyn_crawler.ground.frames import plain
from exudyn_crawler.ground.packed import nothing, pack
from exudyn_crawler.ground.pair_geometry import ContactGeometry
from exudyn_crawler.ground.rotations import Weights
from exudyn_crawler.model.bodies import Bodies, Modes, second_moment
from exudyn_crawler.model.elimination import fronts_of
from exudyn_crawler.model.forces.cells import CellTable
from exudyn_crawler.model.forces.loads import Loads
from exudyn_crawler.model.forces.teeth import Teeth
from exudyn_crawler.model.forces.units import TerrainTable
from exudyn_crawler.model.forces.wheels import Wheels
from exudyn_crawler.model.joints import ROWS, ClosedJoints, Joints, Markers, Pull
from exudyn_crawler.model.newton import step
from exudyn_crawler.model.tables import SYSTEM, FrontRows, Inputs, System, Tables, Workspace

RADIUS = 0.9
"""Spectral radius of the integration."""


def hinged(masses, inertias, pins, held=()):
    """Rigid bodies in a row; `pins` are the places of each pin in the bodies behind and ahead of it.

    All coordinates of the `held` bodies are held.
    """
    count, none = len(masses), np.zeros(0, dtype=np.int64)
    size = 6 * count + 1  # one coordinate of a terrain without units
    rows = [(k, k + 1) for k in range(len(pins)) for _ in range(ROWS)] + [(0, -1), (0, -1)]
    holds = [(b, k) for b in held for k in range(6)]
    rows += [(b, -1) for b, _ in holds]
    places = np.array([(0.0, 0.0, 0.0), *(place for pair in pins for place in pair)])
    bodies = [0, *(b for k in range(len(pins)) for b in (k, k + 1))]
    zeros, empty = np.zeros((len(places), 3, 0)), np.zeros((0, 1))
    unknowns = list(range(6 * count))
    last = list(range(6 * count, size + len(rows)))
    fronts = fronts_of([unknowns, last], [[*unknowns, *last]])
    place = {unknown: k for k, unknown in enumerate(fronts.rows(0))}
    return Tables(
        bodies=Bodies(
            6 * np.arange(count),
            np.full(count, -1),
            np.zeros((count, 6)),
            np.array(masses, dtype=float),
            np.zeros((count, 3)),
            np.array(
                [second_moment(m, np.diag(i), np.zeros(3)) for m, i in zip(masses, inertias, strict=True)]
            ),
            np.zeros((count, 2, 3)),
        ),
        modes=nothing(Modes),
        markers=Markers(np.array(bodies), places, zeros, zeros, np.zeros(len(bodies), dtype=np.int64)),
        joints=Joints(
            np.array([(2 * k + 1, 2 * k + 2) for k in range(len(pins))], dtype=np.int64).reshape(-1, 2),
            0,
            0,
            np.array(holds, dtype=np.int64).reshape(-1, 2),
            np.array(rows),
        ),
        loads=Loads(none, none),
        terrain=TerrainTable(
            empty, empty, np.zeros((0, 4)), np.zeros((1, 1)), np.zeros((1, 1)), np.zeros(1), 6 * count
        ),
        flexible=np.array([size, 0]),
        contact=plain(nothing(ContactGeometry)),
        fronts=fronts,
        rows=FrontRows(
            np.array([6 * np.arange(count), np.full(count, -1)]),
            np.zeros(count, dtype=np.int64),
            np.array([place[6 * count], 0]),
            np.array([[place[size + r] for r in range(len(rows))], np.arange(1, 1 + len(rows))]),
        ),
        pull=nothing(Pull),
        cells=nothing(CellTable),
        closed=nothing(ClosedJoints),
        teeth=nothing(Teeth),
        wheels=nothing(Wheels),
    )


def integrated(tables, start, gravity, h, steps):
    """Coordinates, rates (steps + 1, bodies, 6) and multipliers of pins (steps + 1, pins, ROWS).

    `start` are coordinates, rates and accelerations (3, bodies, 6).
    """
    size, rows = 6 * len(tables.bodies.mass) + 1, tables.multiplier_count
    state, multipliers = np.zeros((3, size)), np.zeros(rows)
    state[:, :-1] = np.reshape(start, (3, -1))
    system = System(tables, Workspace.allocate(tables, 1, nothing(ShoePoints)))
    block = pack(system, SYSTEM)
    inputs = tuple(Inputs(tuple(gravity), np.zeros((0, 6)), 0.0, np.zeros(2), np.zeros(2), np.zeros(1)))
    scratch = np.zeros(size + rows), np.zeros(tables.fronts.size)
    # generalized alpha (Arnold and Bruels, Multibody System Dynamics 18, 2007)
    alpha_m, alpha_f = (2.0 * RADIUS - 1.0) / (RADIUS + 1.0), RADIUS / (RADIUS + 1.0)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    by_acceleration = (1.0 - alpha_m) / ((1.0 - alpha_f) * beta * h * h)
    weights = tuple(Weights(1.0, gamma / (h * beta), by_acceleration, False, beta * h / gamma))
    algorithmic = state[2].copy()
    found = [(state.copy(), multipliers.copy())]
    for _ in range(steps):
        before = algorithmic
        algorithmic = (alpha_f * state[2] - alpha_m * before) / (1.0 - alpha_m)
        state[0] += h * state[1] + h * h * ((0.5 - beta) * before + beta * algorithmic)
        state[1] += h * ((1.0 - gamma) * before + gamma * algorithmic)
        state[2] = 0.0
        converged, *_ = step(block, state, multipliers, inputs, weights, (1e-6, 50, False), scratch)
        assert converged
        algorithmic = algorithmic + (1.0 - alpha_f) / (1.0 - alpha_m) * state[2]
        found.append((state.copy(), multipliers.copy()))
    pins = ROWS * len(tables.joints.pins)
    coordinates = np.array([s[0, :-1].reshape(-1, 6) for s, _ in found])
    rates = np.array([s[1, :-1].reshape(-1, 6) for s, _ in found])
    return coordinates, rates, np.array([m[:pins].reshape(-1, ROWS) for _, m in found])
