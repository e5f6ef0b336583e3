"""Mechanisms of rigid bodies and pins with known motions, by the compiled equations and solver of the tracks.

The pendulum and the N-four-bar are the problems A01 and A02 of the library of multibody benchmarks of IFToMM
(Gonzalez, Dopico, Lugris and Cuadrado, Multibody System Dynamics 16, 2006). Bodies have no ground below them.
All motion is in the plane of x and z, about y. The chain round a wheel is a run of the whole program.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.special import ellipj, ellipk

from exudyn_crawler import StepProfile, read_case, simulate
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.files import writable_folder
from exudyn_crawler.ground.cells.pressing import ShoePoints
from exudyn_crawler.ground.packed import nothing, pack
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.bodies import Bodies, second_moment
from exudyn_crawler.model.elimination import fronts_of
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.joints.drive import Speeds
from exudyn_crawler.model.joints.hold import Held
from exudyn_crawler.model.joints.pin import ROWS, Pins
from exudyn_crawler.model.joints.play import Plays
from exudyn_crawler.model.kinds import Joints
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.newton import Limits, step
from exudyn_crawler.model.parts.shoes import ACROSS_CHAIN
from exudyn_crawler.model.tables import SYSTEM, FrontRows, Search, System, Tables, Workspace
from studies.running import save

GRAVITY = 9.81
RADIUS = 0.9
"""Spectral radius of the integration."""
RESIDUAL = 1e-6
"""Residual at which a step ends, N."""
STILL = (0.0, 0.0, 0.0)
COMPLIANCE = 1e-9
"""Compliance of pins across the plane, m/N and rad/(N m), where loops make their equations redundant."""

Three = tuple[float, float, float]


class Rigid(NamedTuple):
    """Rigid body."""

    mass: float  # kg
    inertia: Three  # principal moments about the COM, which is the frame's origin, kg m2
    held: bool = False  # True if it does not move


class Joint(NamedTuple):
    """Pin along y between two bodies, by their numbers and its places (m) in their frames."""

    rear: int
    front: int
    behind: Three
    ahead: Three


class Swing(NamedTuple):
    """Motion of a mechanism by steps: n of them, b bodies with m modal coordinates, p pins."""

    q: np.ndarray  # (n + 1, b, 6): m and rad
    q_t: np.ndarray  # (n + 1, b, 6): m/s and rad/s
    forces: np.ndarray  # (n + 1, p, ROWS): multipliers of the pins, N and N m
    modes: np.ndarray  # (n + 1, m): modal coordinates of flexible bodies


def hinged(bodies: Sequence[Rigid], joints: Sequence[Joint], loops: bool = False) -> Tables:
    """Return the tables of bodies with pins; `loops` tells that pins close loops."""
    count = len(bodies)
    size, first, rigid = 6 * count, 6 * np.arange(count), np.full(count, -1)
    holds = [(b, k) for b, body in enumerate(bodies) if body.held for k in range(6)]
    first_row = ROWS * len(joints)
    multipliers = first_row + 2 + len(holds)
    ends = [(joint.rear, joint.behind) for joint in joints], [(joint.front, joint.ahead) for joint in joints]
    marked = [(0, STILL), *(end for pair in zip(*ends, strict=True) for end in pair)]
    of, places = np.array([body for body, _ in marked]), np.array([place for _, place in marked])
    unbent = np.zeros((len(places), 3, 0))
    still = np.zeros(3)
    moments = np.array([second_moment(body.mass, np.diag(body.inertia), still) for body in bodies])
    masses = np.array([body.mass for body in bodies], dtype=float)
    compliance = np.tile(COMPLIANCE * ACROSS_CHAIN if loops else np.zeros(ROWS), (len(joints), 1))
    coordinates = [list(range(k, k + 6)) for k in first.tolist()]
    pins = [list(range(size + ROWS * j, size + ROWS * (j + 1))) for j in range(len(joints))]
    others = list(range(size + first_row, size + multipliers))
    couplings = [
        [*coordinates[body], *rows]
        for joint, rows in zip(joints, pins, strict=True)
        for body in (joint.rear, joint.front)
    ]
    couplings += [[*coordinates[body], *others] for body in sorted({0, *(body for body, _ in holds)})]
    # pins of the ground are coupled once it is eliminated, and then meet in one front: with a front a pin, a
    # mechanism of 40 windows does not pass its singular position
    fronts = fronts_of([*coordinates, *pins, others], couplings)
    # row of every unknown in each front
    row_in = np.full((len(fronts.pivots), size + multipliers), -1)
    for front in range(len(fronts.pivots)):
        rows = fronts.rows(front)
        row_in[front, rows] = np.arange(len(rows))
    return nothing(Tables)._replace(
        bodies=Bodies(
            first, rigid, np.zeros((count, 6)), masses, np.zeros((count, 3)), moments, np.zeros((count, 2, 3))
        ),
        markers=Markers(of, places, unbent, unbent, np.zeros(len(places), dtype=np.int64)),
        joints=nothing(Joints)._replace(
            pins=Pins(
                0,
                np.arange(1, len(places)).reshape(-1, 2),
                compliance,
                np.zeros_like(compliance),
                in_plane=loops,
                follows=False,
            ),
            # as many pins as may turn in their loops
            plays=nothing(Plays)._replace(first=first_row, turned=len(joints)),
            drive=Speeds(first_row, marker=0, turning=0),
            holds=Held(first_row + 2, np.array(holds, dtype=np.int64).reshape(-1, 2)),
        ),
        multipliers=multipliers,
        search=Search(0.0, 0.0, 0, guards=False),
        fronts=fronts,
        rows=FrontRows(
            np.ascontiguousarray(row_in[:, first]),
            np.arange(count),
            np.full(len(fronts.pivots), -1),
            np.ascontiguousarray(row_in[:, size:]),
        ),
    )


def integrated(tables: Tables, start: ArrayLike, gravity: Three, h: float, steps: int) -> Swing:
    """Integrate a mechanism by steps of `h` (s), as the runs of tracks are, without Exudyn.

    `start` are coordinates, rates and accelerations (3, coordinates) or (3, bodies, 6), bodies before modes.
    Raises `RuntimeError` if a step fails.
    """
    state = np.reshape(np.array(start, dtype=float), (3, -1)).copy()
    multipliers = np.zeros(tables.multipliers)
    system = System(tables, Workspace.allocate(tables, 1, nothing(ShoePoints)))
    block = pack(system, SYSTEM)
    inputs = Inputs(gravity, np.zeros((0, 6)), 0.0, np.zeros(2), np.zeros(2))
    scratch = np.zeros(state.shape[1] + len(multipliers)), np.zeros(tables.fronts.size)
    # generalized alpha (Arnold and Bruels, Multibody System Dynamics 18, 2007)
    alpha_m, alpha_f = (2.0 * RADIUS - 1.0) / (RADIUS + 1.0), RADIUS / (RADIUS + 1.0)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    by_acceleration = (1.0 - alpha_m) / ((1.0 - alpha_f) * beta * h * h)
    weights = Weights(1.0, gamma / (h * beta), by_acceleration, False, beta * h / gamma)
    limits = Limits(RESIDUAL, 50, False)
    algorithmic, pins = state[2].copy(), tables.joints.drive.first
    found = [(*state[:2].copy(), multipliers[:pins].copy())]
    for number in range(steps):
        before = algorithmic
        algorithmic = (alpha_f * state[2] - alpha_m * before) / (1.0 - alpha_m)
        state[0] += h * state[1] + h * h * ((0.5 - beta) * before + beta * algorithmic)
        state[1] += h * ((1.0 - gamma) * before + gamma * algorithmic)
        state[2] = 0.0
        if not step(block, state, multipliers, inputs, weights, limits, scratch).converged:
            raise RuntimeError(f"the step from {number * h:g} s did not converge")
        algorithmic = algorithmic + (1.0 - alpha_f) / (1.0 - alpha_m) * state[2]
        found.append((*state[:2].copy(), multipliers[:pins].copy()))
    q, q_t, forces = map(np.array, zip(*found, strict=True))
    count = 6 * len(tables.bodies.mass)
    by_body, by_pin = (steps + 1, -1, 6), (steps + 1, -1, ROWS)
    places, rates = q[:, :count].reshape(by_body), q_t[:, :count].reshape(by_body)
    return Swing(places, rates, forces.reshape(by_pin), q[:, count:])


def energy(bodies: Sequence[Rigid], swing: Swing) -> np.ndarray:
    """Return kinetic and potential energy of a motion in the plane: array (n + 1,), J."""
    masses = np.array([body.mass for body in bodies])
    inertias = np.array([body.inertia[1] for body in bodies])
    moving = np.array([not body.held for body in bodies])
    speeds = (swing.q_t[..., :3] ** 2).sum(axis=2)
    each = (
        0.5 * masses * speeds + 0.5 * inertias * swing.q_t[..., 4] ** 2 + GRAVITY * masses * swing.q[..., 2]
    )
    return each[:, moving].sum(axis=1)


GROUND = Rigid(1.0, (1.0, 1.0, 1.0), held=True)
POINT = 1e-6
"""Moments of inertia of what is a mass point in the problem, kg m2."""


PITCH = 0.67
"""Pitch of the ring's links, m."""


RAMP, SETTLE = 1.0, 0.3
"""Times, s, in which a chain is brought to its speed, and until its mean counts."""


class Found(NamedTuple):
    """Result of a problem beside its known answer."""

    problem: str
    quantity: str
    unit: str
    known: float
    found: float


def pendulum(time: float = 10.0, h: float = 1e-3) -> list[Found]:
    """Solve the simple pendulum: 1 kg on a bar of 1 m, which starts level and at rest.

    Its swing is Jacobi's elliptic function. Positions are compared over the whole time (s).
    """
    bodies = [GROUND, Rigid(1.0, (POINT, POINT, POINT))]
    start = np.zeros((3, 2, 6))
    start[0, 1, 0] = -1.0
    about_pin = 1.0 + POINT
    start[2, 1, 2] = -GRAVITY / about_pin
    start[2, 1, 4] = -GRAVITY / about_pin
    swing = integrated(
        hinged(bodies, [Joint(0, 1, STILL, (1.0, 0.0, 0.0))]), start, (0.0, 0.0, -GRAVITY), h, round(time / h)
    )
    t = h * np.arange(len(swing.q))
    rate = np.sqrt(GRAVITY / about_pin)
    share = 0.5  # sin^2 of half the greatest angle from the lowest point
    _, cosine, delta, _ = ellipj(rate * t, share)
    angle = 2.0 * np.arcsin(np.sqrt(share) * cosine / delta)
    known = np.column_stack((-np.sin(angle), -np.cos(angle)))
    off = np.hypot(*(swing.q[:, 1, [0, 2]] - known).T).max()
    # downward through the lowest point, from left to right
    x = swing.q[:, 1, 0]
    (through,) = np.nonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    passed = t[through] - x[through] / (x[through + 1] - x[through]) * h
    period = float(np.diff(passed).mean())
    total = energy(bodies, swing)
    name = "simple pendulum"
    return [
        Found(name, f"greatest error of position in {time:g} s", "m", 0.0, float(off)),
        Found(name, "period", "s", float(4.0 * ellipk(share) / rate), period),
        Found(name, "greatest change of energy", "J", 0.0, float(np.abs(total - total[0]).max())),
    ]


def four_bars(windows: int) -> tuple[list[Rigid], list[Joint]]:
    """Return bodies and pins of the N-four-bar: ground, upright bars, level bars, each of 1 m and 1 kg."""
    bar = Rigid(1.0, (1.0 / 12.0,) * 3)
    bodies = [GROUND, *[bar] * (2 * windows + 1)]
    low, high = (0.0, 0.0, -0.5), (0.0, 0.0, 0.5)
    left, right = (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)
    joints = [Joint(0, 1 + k, (float(k), 0.0, 0.0), low) for k in range(windows + 1)]
    for k in range(windows):
        level = windows + 2 + k
        joints += [Joint(1 + k, level, high, left), Joint(2 + k, level, high, right)]
    return bodies, joints


def n_four_bar(windows: int = 2, time: float = 10.0, h: float = 1e-3) -> list[Found]:
    """Solve the N-four-bar: bars that start upright with 1 m/s at their tips and turn all round.

    Level, twice a turn, all bars are in line: the position is singular, and bars could fold. While they do
    not, it is a pendulum: ``w^2 = w0^2 + a (1 - cos)`` with the turn from upright.
    """
    bodies, joints = four_bars(windows)
    count = windows + 1
    start = np.zeros((3, len(bodies), 6))
    start[0, 1 : 1 + count, 0] = np.arange(count)
    start[0, 1 : 1 + count, 2] = 0.5
    start[0, 1 + count :, 0] = np.arange(windows) + 0.5
    start[0, 1 + count :, 2] = 1.0
    start[1, 1 : 1 + count, [0]] = 0.5
    start[1, 1 : 1 + count, 4] = 1.0
    start[1, 1 + count :, 0] = 1.0
    start[2, 1 : 1 + count, 2] = -0.5
    start[2, 1 + count :, 2] = -1.0
    swing = integrated(hinged(bodies, joints, loops=True), start, (0.0, 0.0, -GRAVITY), h, round(time / h))
    inertia = count / 3.0 + windows
    a = 2.0 * GRAVITY * (0.5 * count + windows) / inertia
    # turn from the lowest point: w^2 = (1 + 2 a) (1 - k sin^2 of its half), a pendulum that goes all round
    fastest = np.sqrt(1.0 + 2.0 * a)
    share = 2.0 * a / (1.0 + 2.0 * a)
    quarter = ellipk(share)
    t = h * np.arange(len(swing.q))
    _, _, _, amplitude = ellipj(0.5 * fastest * t - quarter, share)
    turn = np.pi + 2.0 * amplitude
    tip = np.column_stack((np.sin(turn), np.cos(turn)))
    found = 2.0 * swing.q[:, 1, [0, 2]]
    off = float(np.hypot(*(found - tip).T).max())
    total = energy(bodies, swing)
    level = swing.q[:, 1 + count :, 4]
    name = f"N-four-bar, N = {windows}"
    return [
        Found(name, f"greatest error of the tip in {time:g} s", "m", 0.0, off),
        Found(name, "turns", "1", float(turn[-1] / (2.0 * np.pi)), float(swing.q[-1, 1, 4] / (2.0 * np.pi))),
        Found(name, "greatest change of energy", "J", 0.0, float(np.abs(total - total[0]).max())),
        Found(name, "greatest tilt of level bars", "rad", 0.0, float(np.abs(level).max())),
    ]


def ring(links: int) -> tuple[list[Rigid], list[Joint]]:
    """Return the bodies and pins of a ring of heavy links; body 0 stands beside it."""
    link = Rigid(4500.0, (1000.0, 200.0, 1000.0))
    rear, front = (-0.5 * PITCH, 0.0, 0.0), (0.5 * PITCH, 0.0, 0.0)
    joints = [Joint(1 + k, 1 + (k + 1) % links, front, rear) for k in range(links)]
    return [GROUND, *[link] * links], joints


def spinning_ring(links: int = 24, speed: float = 5.0, steps: int = 500) -> list[Found]:
    """Solve a ring of N links that spins freely, as on a drum on which it no longer presses.

    A link's balance between its pins gives ``T = m' v^2 / cos(pi / N)``: the tension of a belt of mass m' per
    length, and that of its corners. `speed` (m/s) is that of the links' middles.
    """
    bodies, joints = ring(links)
    middle = 0.5 * PITCH / np.tan(np.pi / links)
    omega = speed / middle
    pitch = 2.0 * np.pi * np.arange(links) / links
    start = np.zeros((3, 1 + links, 6))
    start[0, 1:, 0] = middle * np.sin(pitch)
    start[0, 1:, 2] = middle * np.cos(pitch)
    start[0, 1:, 4] = pitch
    start[1, 1:, 0] = omega * start[0, 1:, 2]
    start[1, 1:, 2] = -omega * start[0, 1:, 0]
    start[1, 1:, 4] = omega
    start[2, 1:, [0, 2]] = -(omega**2) * start[0, 1:, [0, 2]]
    time = 2.0 * np.pi / omega
    swing = integrated(hinged(bodies, joints, loops=True), start, STILL, time / steps, steps)
    tensions = np.linalg.norm(swing.forces[1:, :, :3], axis=2)
    mass = bodies[1].mass
    known = mass / PITCH * speed**2 / float(np.cos(np.pi / links))
    back = np.abs(swing.q[-1, 1:, [0, 2]] - swing.q[0, 1:, [0, 2]]).max()
    mean, farthest = float(tensions.mean()), float(tensions.flat[np.abs(tensions - known).argmax()])
    name = f"spinning ring of {links} links"
    return [
        Found(name, "tension, mean", "N", known, mean),
        Found(name, "tension, farthest from the known one", "N", known, farthest),
        Found(name, "greatest distance from the start after a turn", "m", 0.0, float(back)),
    ]


M113 = Path(__file__).with_name("m113.toml")


def wheel(speed: float = 10.0, steady: float = 1.0) -> list[Found]:
    """Run the chain of an M113 on posts round its wheels, for a `steady` time (s) at a speed (m/s).

    The idler's load is the pull of both runs less what turns the chain round: ``N = 2 (T - m' v^2)``, in the
    mean over time. Here the whole program runs, with teeth, wheels and a tensioner.
    """
    case = read_case(M113).case
    drive = case.drive.with_(speed=StepProfile(times=(0.0, RAMP), values=(0.0, speed)))
    case = case.with_(drive=drive, solver=case.solver.with_(step=1e-3))
    history = simulate(case, RAMP + SETTLE + steady, progress=False)
    late = history.time.values > RAMP + SETTLE
    load = history.wheel_force.sel(wheel="idler").values[late].mean(axis=0)
    ahead = (history.position - history.side_frame_position).values[late][..., 0]
    x, _ = case.part(Closed).idler.place
    tension = float(history.link_tension.values[late].mean(where=ahead > x))
    known = 0.5 * float(np.hypot(load[0], load[2])) + case.shoe.mass / case.track.pitch * speed**2
    return [Found("chain of an M113", f"tension on its idler at {speed:g} m/s", "N", known, tension)]


def study(out: Path | None = None) -> pd.DataFrame:
    """Tabulate all problems, see `Found`; `out` gets `mechanisms.csv`."""
    folder = None if out is None else writable_folder(out)
    table = pd.DataFrame([*pendulum(), *n_four_bar(), *spinning_ring(), *wheel()])
    save(folder, mechanisms=table)
    return table
