"""Flexible shoes in space: bent, coloured by their stress, with what presses on them and the rollers near."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import poses
from exudyn_crawler.views.scenes.scene import Arrows, Colouring, Placement, Scene, Solid
from exudyn_crawler.views.scenes.track import rollers
from fem.trust import VERDICTS

LONGEST_OF_SHOE, LONGEST_OF_PAIR = 0.7, 0.4
"""m, lengths at which the greatest contact force on a shoe and of a single contact or tread are drawn."""
BENT = 0.04
"""m, length at which the greatest elastic displacement is drawn at most."""
BESIDE = 0.75
"""m beyond the places of the outer shoes to which rollers are drawn."""
ROLLER_OPACITY = 0.4
"""Of rollers, which would hide the rails."""
STRESS, TRUST = "von Mises stress", "how far to trust the greatest stress"
VERDICT_COLOURS = (
    *("#00682f", "#238443", "#41ab5d", "#78c679", "#a6d96a", "#c5e86c", "#e6f598", "#fff3a0"),
    *("#f79440", "#d73027", "#7b3294", "#d9d9d9"),
)
"""Of `fem.trust.VERDICTS`, and of what is too low to be judged."""
LOW = 0.1
"""Part of the highest stress below which a stress is not judged: its relative error is of no use."""


@dataclass(frozen=True)
class Scales:
    """What all stress pictures of a run have in common.

    Attributes
    ----------
    stress : float
        Stress at the end of the colours, Pa.
    displacement : float
        Magnification of the elastic displacement.
    pair_force, shoe_force : float
        m that are drawn for 1 N of a single contact or tread, and of all contacts of a shoe.
    """

    stress: float
    displacement: float
    pair_force: float
    shoe_force: float

    @classmethod
    def of(cls, stress: xr.Dataset, history: History) -> Self:
        """Scales that fit all chosen times of a stress dataset."""
        surface = np.unique(stress.triangle.values)
        chosen = history.dataset.sel(time=stress.frame.values, method="nearest")
        pairs = [poses.acting(chosen.isel(time=row))[1] for row in range(stress.sizes["frame"])]
        return cls(
            stress=end_of_colours(float(stress.frame_von_mises.isel(node=surface).max())),
            displacement=style.drawn_scale(stress.frame_displacement.values, BENT),
            pair_force=length_per_newton(LONGEST_OF_PAIR, pairs),
            shoe_force=shoe_force_scale(history),
        )


def shoe_force_scale(history: History) -> float:
    """M that are drawn for 1 N of the contact force on a shoe; 0 if there is none in the whole run."""
    greatest = poses.greatest_shoe_force(history)
    return LONGEST_OF_SHOE / greatest if greatest > 0.0 else 0.0


def length_per_newton(length: float, forces: Sequence[NDArray]) -> float:
    """M that are drawn for 1 N, for the greatest of forces (n, 3) to have a length; 0 if all are zero."""
    longest = max((float(np.linalg.norm(one, axis=1).max(initial=0.0)) for one in forces), default=0.0)
    return length / longest if longest > 0.0 else 0.0


def end_of_colours(greatest: float) -> float:
    """Round stress at the end of the colours, Pa, for a greatest one."""
    return style.round_up(greatest) if greatest > 0.0 else style.MEGA


def shoe_solid(
    shoe: int,
    shape: tuple[NDArray, NDArray],
    places: Sequence[Placement],
    bend: NDArray,
    von_mises: NDArray,
    limit: float,
    larger: float,
) -> Solid:
    """Flexible shoe with its stress.

    `shape` are points (n, 3), m, and triangles (m, 3), and `places` where the shoe is at each time; then
    elastic displacement (times, n, 3), m, drawn `larger` times larger, and stress (times, n), Pa, whose
    colours end at `limit`.
    """
    values, end = von_mises[:, None] / style.MEGA, limit / style.MEGA
    return Solid(
        f"shoe {shoe}",
        shape[0],
        (shape[1],),
        "white",
        np.array([one.origin for one in places])[:, None],
        np.array([one.turn for one in places])[:, None],
        labels=(f"shoe {shoe}",),
        bend=bend[:, None],
        larger=larger,
        colourings=(Colouring(f"{STRESS} in MPa", values, 0.0, end, style.STRESS_MAP, name=STRESS),),
    )


def stress_scene(stress: xr.Dataset, history: History, scales: Scales) -> Scene:
    """All flexible shoes at the chosen times of their stresses, with single forces and rollers near them."""
    used, corners = np.unique(stress.triangle.transpose("face", "corner").values, return_inverse=True)
    shape = stress.node_position.transpose("node", "axis").values[used], corners.reshape(-1, 3)
    shown = history.dataset.sel(time=stress.frame.values, method="nearest").load()
    moments = [shown.isel(time=row) for row in range(shown.sizes["time"])]
    near = [poses.shoe_pose(now, int(shoe)).origin[0] for now in moments for shoe in stress.shoe.values]
    solids, arrows = [], []
    for shoe in map(int, stress.shoe.values):
        own = stress.sel(shoe=shoe)
        bend = own.frame_displacement.transpose("frame", "node", "axis").values[:, used]
        mises = own.frame_von_mises.transpose("frame", "node").values
        places = [poses.shoe_pose(now, shoe) for now in moments]
        solid = shoe_solid(shoe, shape, places, bend, mises[:, used], scales.stress, scales.displacement)
        notes = tuple(f"{one / style.MEGA:.1f} MPa" for one in mises.max(axis=1))
        colourings = (*solid.colourings, *_trust(stress, shoe, used))
        solids.append(replace(solid, notes=notes, colourings=colourings, nodes=used))
        forces = forces_on(solid.name, [poses.acting(now, shoe) for now in moments], scales.pair_force)
        arrows.append(replace(forces, through=float(np.ptp(shape[0][:, 2]))))
    if poses.rolls(history.dataset):
        solids.append(rollers_between(history.case, shown, min(near) - BESIDE, max(near) + BESIDE))
    return Scene(tuple(frame_titles(stress)), tuple(solids), tuple(arrows))


def forces_on(solid: str, forces: Sequence[tuple[NDArray, NDArray]], scale: float) -> Arrows:
    """Single forces on a solid at some times: points (k, 3), m, and forces (k, 3), N."""
    count = max(len(points) for points, _ in forces)
    padded = np.full((2, len(forces), count, 3), np.nan)
    for row, pair in enumerate(forces):
        padded[:, row, : len(pair[0])] = pair
    return Arrows("contact forces", style.CONTACT_FORCE, padded[0], padded[1], scale, solid)


def rollers_between(case: Case, dataset: xr.Dataset, rear: float, front: float) -> Solid:
    """Treads in some instants whose axes lie between two x, m; others are not there."""
    treads, _ = rollers(case, dataset)
    away = (treads.origin[..., :1] < rear) | (treads.origin[..., :1] > front)
    return replace(treads, origin=np.where(away, np.nan, treads.origin), opacity=ROLLER_OPACITY)


def _trust(stress: xr.Dataset, shoe: int, used: NDArray) -> list[Colouring]:
    """Verdicts on the greatest stress of each node of a shoe's surface, as far as the run has them."""
    if "peak_verdict" not in stress:
        return []
    highest = stress.peak_von_mises.isel(node=used)
    low = highest.sel(shoe=shoe).values < LOW * float(highest.max())
    numbers = stress.peak_verdict.sel(shoe=shoe).values[used]
    return [verdict_colouring(numbers, low, f"low: below {100 * LOW:g} % of the highest", TRUST)]


def verdict_colouring(numbers: NDArray, low: NDArray, low_words: str, name: str) -> Colouring:
    """Colours of verdicts (n,), numbers of `fem.trust.VERDICTS`; those that are `low` (n,) are not judged."""
    judged = np.where(numbers < 0, np.nan, np.where(low, len(VERDICTS), numbers))
    words = (*VERDICTS, low_words)
    return Colouring("verdict", judged[None, None], -0.5, len(VERDICTS) + 0.5, VERDICT_COLOURS, words, name)


def frame_titles(stress: xr.Dataset) -> list[str]:
    """Chosen times for reading: ``t = 0.226 s, peak``."""
    names = stress.frame_name.values.tolist() if "frame_name" in stress else [""] * stress.sizes["frame"]
    return [
        ", ".join(filter(None, (f"t = {time:.6g} s", name)))
        for time, name in zip(stress.frame.values, names, strict=True)
    ]


def first_frame(stress: xr.Dataset) -> int:
    """Index of the peak, or of the highest stress among the chosen times where that is not one of them."""
    peaks = [k for k, title in enumerate(frame_titles(stress)) if "peak" in title.split(", ")]
    if peaks:
        return peaks[0]
    highest = stress.frame_von_mises.max([dim for dim in stress.frame_von_mises.dims if dim != "frame"])
    return int(highest.values.argmax())
