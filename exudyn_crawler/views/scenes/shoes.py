"""Flexible shoes in space: bent, coloured by their stress, with what presses on them and the rollers near.

`stress` is the dataset that the stress study leaves, or part of one; `docs/report.md` lists what it holds.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import track
from exudyn_crawler.views.scenes.scene import Arrows, Colouring, Scene, Solid
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
    """What all pictures of some stresses have in common.

    Attributes
    ----------
    stress : float
        Stress at the end of the colours, Pa.
    displacement : float
        Magnification of the elastic displacement.
    pair_force, shoe_force : float
        m that are drawn for 1 N of a single contact or tread on these shoes, and of all contacts of a shoe.
    """

    stress: float
    displacement: float
    pair_force: float
    shoe_force: float

    @classmethod
    def of(cls, stress: xr.Dataset, history: History) -> Self:
        """Scales that fit all chosen times of a stress dataset."""
        surface = np.unique(stress.triangle.values)
        greatest = float(stress.frame_von_mises.isel(node=surface).max())
        chosen = history.dataset.sel(time=stress.frame.values, method="nearest")
        moments = [chosen.isel(time=row) for row in range(stress.sizes["frame"])]
        forces = [track.acting(now, int(shoe))[1] for now in moments for shoe in stress.shoe.values]
        longest = float(np.linalg.norm(np.concatenate(forces), axis=1).max(initial=0.0))
        return cls(
            stress=style.round_up(greatest) if greatest > 0.0 else style.MEGA,
            displacement=style.drawn_scale(stress.frame_displacement.values, BENT),
            pair_force=LONGEST_OF_PAIR / longest if longest > 0.0 else 0.0,
            shoe_force=shoe_force_scale(history),
        )


def shoe_force_scale(history: History) -> float:
    """M that are drawn for 1 N of the contact force on a shoe; 0 if there is none in the whole run."""
    greatest = track.greatest_shoe_force(history)
    return LONGEST_OF_SHOE / greatest if greatest > 0.0 else 0.0


def stress_scene(stress: xr.Dataset, history: History, scales: Scales) -> Scene:
    """All flexible shoes at the chosen times of their stresses, with single forces and rollers near them."""
    used, corners = np.unique(stress.triangle.transpose("face", "corner").values, return_inverse=True)
    faces = (corners.reshape(-1, 3),)
    points = stress.node_position.transpose("node", "axis").values[used]
    shown = history.dataset.sel(time=stress.frame.values, method="nearest").load()
    moments = [shown.isel(time=row) for row in range(shown.sizes["time"])]
    solids, arrows = [], []
    for shoe in map(int, stress.shoe.values):
        own, name = stress.sel(shoe=shoe), f"shoe {shoe}"
        mises = own.frame_von_mises.transpose("frame", "node").values / style.MEGA
        bend = own.frame_displacement.transpose("frame", "node", "axis").values[:, used]
        end = scales.stress / style.MEGA
        colouring = Colouring(
            f"{STRESS} in MPa", mises[:, None, used], 0.0, end, style.STRESS_MAP, name=STRESS
        )
        poses = [track.shoe_pose(now, shoe) for now in moments]
        solids.append(
            Solid(
                name,
                points,
                faces,
                "white",
                np.array([one.origin for one in poses])[:, None],
                np.array([one.turn for one in poses])[:, None],
                labels=(name,),
                notes=tuple(f"{one:.1f} MPa" for one in mises.max(axis=1)),
                bend=bend[:, None],
                larger=scales.displacement,
                colourings=(colouring, *_trust(stress, shoe, used)),
                nodes=used,
            )
        )
        forces = [track.acting(now, shoe) for now in moments]
        padded = np.full((2, len(forces), max(len(heads) for heads, _ in forces), 3), np.nan)
        for row, pair in enumerate(forces):
            padded[:, row, : len(pair[0])] = pair
        how = (style.CONTACT_FORCE, *padded, scales.pair_force, name, float(np.ptp(points[:, 2])))
        arrows.append(Arrows("contact forces", *how))
    if track.rolls(shown):
        treads, _ = track.rollers(history.case, shown)
        x = np.array([one.origin[..., 0] for one in solids])
        away = (treads.origin[..., 0] < x.min() - BESIDE) | (treads.origin[..., 0] > x.max() + BESIDE)
        near = np.where(away[..., None], np.nan, treads.origin)
        solids.append(replace(treads, origin=near, opacity=ROLLER_OPACITY))
    return Scene(tuple(frame_titles(stress)), tuple(solids), tuple(arrows))


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
    return peaks[0] if peaks else int(stress.frame_von_mises.max(("shoe", "node")).values.argmax())
