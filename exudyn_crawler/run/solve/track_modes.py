"""Modes of a track that slides steadily on its ground: which of them grow, how fast and in what shape.

The equations of motion are linearised about steady sliding, with the ground's units where they are: a mode
lives for a second, in which a shoe moves by a tenth of its length.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.model.system import System
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.steady_sliding import (
    Equations,
    SteadySliding,
    check_sliding,
    equations_of,
    find_sliding,
)

COORDINATES = ["x", "y", "z", "roll", "pitch", "yaw"]
"""Of a shoe: displacement of the COM (m) and angles about x, y, z (rad)."""
SAME = 1e-9
"""Imaginary over greatest eigenvalue below which a mode does not swing."""


@dataclass(frozen=True)
class LinearTrack:
    """``mass y'' + damping y' + stiffness y = 0`` for the motion ``basis @ y`` about an equilibrium.

    `mass`, `damping`, `stiffness` are (f, f), `basis` is (n, f): f of the n coordinates are left by links and
    drive. Without friction all three matrices are symmetric.
    """

    mass: NDArray
    damping: NDArray
    stiffness: NDArray
    basis: NDArray


def linearized_track(state: SteadySliding) -> LinearTrack:
    """Linearise the equations of motion about steady sliding, without the constrained motions."""
    with equations_of(state.case) as (_, equations):
        return _linearized(equations, state)


def _linearized(equations: Equations, state: SteadySliding) -> LinearTrack:
    n, at = equations.size, (state.q, state.q_t, state.multipliers)
    directions = equations.directions(state.q, state.q_t)
    held = np.any(directions != 0.0, axis=0)
    basis = scipy.linalg.null_space(directions[:, held].T)
    stiffness, damping = -equations.by_coordinates(*at)[:n], -equations.by_rates(*at)[:n]
    mass = equations.mass()
    mass, damping, stiffness = (basis.T @ matrix @ basis for matrix in (mass, damping, stiffness))
    return LinearTrack(mass, damping, stiffness, basis)


def eigenmodes(linear: LinearTrack) -> tuple[NDArray, NDArray]:
    """Eigenvalues (1/s) by falling growth rate, of pairs the one above the real axis; and their shapes.

    Returns
    -------
    eigenvalues : array (modes,), complex
    shapes : array (n, modes), complex
        In all coordinates; not scaled.
    """
    f = len(linear.mass)
    below = np.linalg.solve(linear.mass, np.hstack((-linear.stiffness, -linear.damping)))
    values, vectors = np.linalg.eig(np.vstack((np.eye(f, 2 * f, f), below)))
    upper = np.flatnonzero(values.imag >= -SAME * np.abs(values).max())
    order = upper[np.argsort(-values.real[upper], kind="stable")]
    return values[order], linear.basis @ vectors[:f, order]


def track_modes(case: Case, speed: float, travel: float = 0.0) -> xr.Dataset:
    """Complex modes of the track on its ground about steady sliding, least stable first.

    A mode moves as the real part of ``shape exp((growth_rate + 2 pi i frequency) t)``.

    Parameters
    ----------
    case, speed, travel
        As for `steady_sliding`.

    Returns
    -------
    xarray.Dataset
        Over `mode`: `growth_rate` (1/s), `frequency` (Hz) and `damping_ratio` (NaN at rest). `shape` (mode,
        shoe, coordinate), complex: displacement of the COM in m and angles in rad; `unit_shape` (mode, unit,
        motion): heave in m and tilt in rad. The greatest motion of a shoe's COM or end is 1 m, real. Of the
        equilibrium: `place` (shoe, coordinate) from t = 0 before settling, `tension` (joint) and
        `normal_force` (shoe), N.

    Raises
    ------
    ValueError, EquilibriumError
        As `steady_sliding`.
    """
    check_sliding(case, speed)
    start = static_equilibrium(case)
    with equations_of(case) as (system, equations):
        state = find_sliding(system, equations, start, speed, travel)
        values, shapes = eigenmodes(_linearized(equations, state))
        return _dataset(system, state, values, shapes)


def _dataset(system: System, state: SteadySliding, values: NDArray, shapes: NDArray) -> xr.Dataset:
    case = state.case
    shoes = case.track.shoe_count
    arms = np.array([1.0, 1.0, 1.0, 0.5 * case.shoe.width, 0.5 * case.shoe.length, 0.5 * case.shoe.width])
    motion = shapes.T[:, : 6 * shoes].reshape(-1, shoes, 6)
    weighted = (motion * arms).reshape(len(values), -1)
    greatest = np.take_along_axis(weighted, np.abs(weighted).argmax(axis=1)[:, None], axis=1)[:, 0]
    # a mode of the ground alone may leave the shoes where they are
    scale = np.where(np.abs(greatest) > 0.0, greatest, 1.0)
    scaled = shapes / scale
    units = [system.contact.unit_motion(s.real) + 1j * system.contact.unit_motion(s.imag) for s in scaled.T]
    # a motion that nothing drives back, such as that across the path, has no damping ratio
    size = np.where(np.abs(values) > SAME * np.abs(values).max(), np.abs(values), np.nan)
    return xr.Dataset(
        {
            "growth_rate": ("mode", values.real, {"units": "1/s"}),
            "frequency": ("mode", values.imag / (2.0 * np.pi), {"units": "Hz"}),
            "damping_ratio": ("mode", -values.real / size, {"units": "1"}),
            "shape": (("mode", "shoe", "coordinate"), motion / scale[:, None, None]),
            "unit_shape": (("mode", "unit", "motion"), np.array(units)[..., 2:]),
            "place": (("shoe", "coordinate"), state.q[: 6 * shoes].reshape(shoes, 6)),
            "tension": ("joint", state.tension, {"units": "N"}),
            "normal_force": ("shoe", state.normal_force, {"units": "N"}),
        },
        coords={
            "mode": np.arange(1, len(values) + 1),
            "shoe": case.track.shoes,
            "joint": case.track.joints,
            "unit": case.terrain.units,
            "coordinate": COORDINATES,
            "motion": ["heave", "tilt"],
        },
        attrs={"title": case.name, "speed": state.speed},
    )
