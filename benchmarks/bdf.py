"""Whether the solver error of 1e-2 explains the quiet track of the S-paper.

Runs its rigid track (13 shoes, 1 m units) in minimal coordinates by a variable-order BDF, as ADAMS's GSTIFF
is, at several error tolerances, beside generalized-alpha in the engine:
``python -m benchmarks.bdf [seconds]``.

The tolerance is taken as ADAMS documents its error: absolute and relative, in m and rad, of the displacements
alone (formulation I3) or of displacements and velocities (SI2).
"""

import sys
import time
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from exudyn_crawler import Case, simulate
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.ground.terrain import reduced_coordinates
from exudyn_crawler.model.compiled_system import CompiledSystem, compiled_system
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.views.tables import print_table

OUTPUT = 2e-3
"""s between compared states."""
UNCHECKED = 1e3
"""Tolerance of a rate that is not to limit the step."""


@dataclass
class PlanarTrack:
    """Even ground keeps a straight track in its plane: height of the front COM, pitches, terrain coordinates.

    The drive gives x of the front shoe. Contact is the package's; there are no constraints and no engine.
    """

    case: Case
    system: CompiledSystem = field(init=False)

    def __post_init__(self) -> None:
        case = self.case
        self.system = compiled_system(case)
        assert isinstance(self.system.contact, PairGroundContact)
        self.contact = self.system.contact
        self.shoes = case.track.shoe_count
        self.modes = reduced_coordinates(case)
        self.free = 1 + self.shoes + self.modes.size
        self.load = case.loads.loads(0.0)[0]
        self.inertia = np.tile([case.shoe.mass, case.shoe.mass, case.shoe.inertia[1]], self.shoes)

    def chain(self, y: NDArray, y_t: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        """x, z, pitch of all shoes (3 shoes,), their derivative by y, and its rate times y_t.

        x counts from that of the front shoe.
        """
        track, n = self.case.track, self.shoes
        ahead, behind, up = track.pin_ahead, track.pitch - track.pin_ahead, track.pin_height
        pitch, rate = y[1 : 1 + n], y_t[1 : 1 + n]
        s, c = np.sin(pitch), np.cos(pitch)
        # from a shoe's COM back to its rear pin, and from its front pin back to its COM
        rear = np.array([-behind * c + up * s, behind * s + up * c])
        com = np.array([-ahead * c - up * s, ahead * s - up * c])
        rear_by = np.array([behind * s + up * c, behind * c - up * s])
        com_by = np.array([ahead * s - up * c, ahead * c + up * s])
        place = np.zeros((n, 3))
        by = np.zeros((n, 3, 1 + n))
        bend = np.zeros((n, 3))
        place[-1, 1], place[:, 2] = y[0], pitch
        by[:, 1, 0] = 1.0
        by[np.arange(n), 2, 1 + np.arange(n)] = 1.0
        for k in range(n - 2, -1, -1):
            place[k, :2] = place[k + 1, :2] + rear[:, k + 1] + com[:, k]
            by[k, :2, 1:] = by[k + 1, :2, 1:]
            by[k, :2, 2 + k] += rear_by[:, k + 1]
            by[k, :2, 1 + k] += com_by[:, k]
            bend[k, :2] = bend[k + 1, :2] - rear[:, k + 1] * rate[k + 1] ** 2 - com[:, k] * rate[k] ** 2
        return place.ravel(), by.reshape(3 * n, 1 + n), bend.ravel()

    def full(self, time: float, state: NDArray) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """Engine coordinates and rates, derivative of the places and its rate's share of acceleration."""
        y, y_t = np.split(state, 2)
        n, speed = self.shoes, self.case.drive.speed
        place, by, bend = self.chain(y, y_t)
        rate = by @ y_t[: 1 + n]
        place, rate = place.reshape(n, 3), rate.reshape(n, 3)
        q, q_t = np.zeros(6 * n + self.modes.size), np.zeros(6 * n + self.modes.size)
        gone = np.arange(n - 1, -1, -1) * self.case.track.pitch
        q[0 : 6 * n : 6] = place[:, 0] + gone + float(speed.integral(time))
        q_t[0 : 6 * n : 6] = rate[:, 0] + float(speed.value(time))
        q[2 : 6 * n : 6], q[4 : 6 * n : 6] = place[:, 1], place[:, 2]
        q_t[2 : 6 * n : 6], q_t[4 : 6 * n : 6] = rate[:, 1], rate[:, 2]
        q[6 * n :], q_t[6 * n :] = y[1 + n :], y_t[1 + n :]
        bend[0::3] += float(speed.rate(time))
        return q, q_t, by, bend

    def accelerations(self, time: float, state: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        """Of the free coordinates; forces on the shoes (shoes, 3) and their COMs' accelerations."""
        q, q_t, by, bend = self.full(time, state)
        n, case = self.shoes, self.case
        generalized = self.contact.forces(q, q_t)
        forces = generalized[: 6 * n].reshape(n, 6)[:, [0, 2, 4]].copy()
        forces[:, 1] -= self.load + case.shoe.mass * case.gravity
        forces[:, 2] += self.load * case.shoe.load_point[2] * np.sin(q[4 : 6 * n : 6])
        mass = by.T @ (self.inertia[:, None] * by)
        chain = np.linalg.solve(mass, by.T @ (forces.ravel() - self.inertia * bend))
        modes = self.modes
        ground = generalized[6 * n :] + case.gravity * modes.weight
        ground -= modes.stiffness @ q[6 * n :] + modes.damping @ q_t[6 * n :]
        return np.concatenate((chain, ground)), forces, (by @ chain + bend).reshape(n, 3)

    def rate(self, time: float, state: NDArray) -> NDArray:
        """Rate of (coordinates, rates)."""
        return np.concatenate((state[self.free :], self.accelerations(time, state)[0]))

    def start(self) -> NDArray:
        """Static equilibrium at rest."""
        q, n = static_equilibrium(self.case), self.shoes
        y = np.concatenate(([q[6 * n - 4]], q[4 : 6 * n : 6], q[6 * n :]))
        return np.concatenate((y, np.zeros_like(y)))

    def tolerance(self, error: float, rates: bool) -> NDArray:
        """Absolute tolerance of every state; terrain coordinates by the heave that they are."""
        coordinates = np.full(self.free, error)
        coordinates[1 + self.shoes :] = error / np.abs(self.modes.heave).max()
        return np.concatenate((coordinates, coordinates if rates else np.full(self.free, UNCHECKED)))


def bdf_run(
    track: PlanarTrack, error: float, rates: bool, duration: float, longest: float = np.inf
) -> dict[str, NDArray | float]:
    """Vertical velocities (times, shoes), front link's force along x and evaluations of one run.

    `error` limits displacements, with `rates` velocities as well; `longest` is the greatest step, s.
    """
    began = time.process_time()
    times = np.arange(0.0, duration + 0.5 * OUTPUT, OUTPUT)
    solution = solve_ivp(
        track.rate,
        (0.0, times[-1]),
        track.start(),
        method="BDF",
        t_eval=times,
        rtol=error,
        atol=track.tolerance(error, rates),
        max_step=longest,
    )
    if not solution.success:
        raise RuntimeError(f"BDF with error {error:g} stopped: {solution.message}")
    velocity, link = [], []
    for t, state in zip(times, solution.y.T, strict=True):
        velocity.append(track.full(t, state)[1][2 : 6 * track.shoes : 6])
        _, forces, acceleration = track.accelerations(t, state)
        link.append((track.case.shoe.mass * acceleration - forces)[:-1, 0].sum())
    return {
        "velocity": np.array(velocity),
        "link": np.array(link),
        "evaluations": solution.nfev,
        "time": time.process_time() - began,
    }


def engine_run(case: Case, duration: float) -> dict[str, NDArray | float]:
    """Same of generalized-alpha in the engine."""
    began = time.process_time()
    run = simulate(case, duration).dataset
    return {
        "velocity": run.velocity.sel(axis="z").values,
        "link": run.joint_force.sel(axis="x").isel(joint=-1).values,
        "evaluations": np.nan,
        "time": time.process_time() - began,
    }


def row(name: str, run: dict[str, NDArray | float]) -> dict[str, object]:
    """Line of the table; means and extremes over the second half."""
    velocity, link = np.asarray(run["velocity"]), np.asarray(run["link"])
    late = len(velocity) // 2
    return {
        "run": name,
        "least z velocity, m/s": velocity.min(),
        "greatest": velocity.max(),
        "late rms": float(np.sqrt(np.mean(velocity[late:] ** 2))),
        "late front link force, MN": link[late:].mean() / 1e6,
        "its deviation": link[late:].std() / 1e6,
        "evaluations": run["evaluations"],
        "CPU s": run["time"],
    }


RUNS = (
    (1e-2, False, np.inf),
    (1e-3, False, np.inf),
    (1e-4, False, np.inf),
    (1e-2, False, 1e-2),
    (1e-2, True, np.inf),
    (1e-4, True, np.inf),
)
"""Error, whether it limits rates, longest step (s)."""


def main(duration: float = 5.0) -> pd.DataFrame:
    """Run all and print the table."""
    case = Case.stress().with_(flexible=None)
    track = PlanarTrack(case)
    rows = [row("generalized-alpha, 2 ms", engine_run(case, duration))]
    for error, rates, longest in RUNS:
        name = f"BDF {error:g} of {'displacements and rates' if rates else 'displacements'}"
        if longest < np.inf:
            name += f", steps up to {longest:g} s"
        rows.append(row(name, bdf_run(track, error, rates, duration, longest)))
    table = pd.DataFrame(rows)
    print_table(table, f"rigid track of the S-paper, {duration:g} s of propel")
    return table


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
