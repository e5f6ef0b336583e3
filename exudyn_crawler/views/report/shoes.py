"""What the report's 3D view of the flexible shoes draws."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.colours import ROLLER
from exudyn_crawler.views.placement import Pose, instant
from exudyn_crawler.views.report.frames import first_frame, frame_titles
from exudyn_crawler.views.report.packing import packed
from exudyn_crawler.views.report.track import packed_undercarriage
from exudyn_crawler.views.scales import MEGA, Scales
from exudyn_crawler.views.undercarriage import acting, frame_pose, rolls
from fem.trust import VERDICTS


def packed_shoes(stress: xr.Dataset, history: History) -> dict[str, Any]:
    """Surface, places, elastic displacement, von Mises stress and contact forces at the chosen times.

    Beside them the verdicts on each node's greatest stress, as far as the run has them.

    Displacements and stresses are 16-bit steps of their greatest magnitude, which is coarser than nothing
    that can be seen.
    """
    scales = Scales.of(stress, history)
    used, corners = np.unique(stress.triangle.transpose("face", "corner").values, return_inverse=True)
    bend = stress.frame_displacement.transpose("frame", "shoe", "node", "axis").values[:, :, used]
    mises = stress.frame_von_mises.transpose("frame", "shoe", "node").values[:, :, used] / MEGA
    bend_step = max(float(np.abs(bend).max()), 1e-12) / 32767.0
    mises_step = max(float(mises.max()), 1e-12) / 65535.0
    shoes = [int(shoe) for shoe in stress.shoe.values]
    frames, titles = [], frame_titles(stress)
    for number, time in enumerate(stress.frame.values):
        highest = (stress.frame_von_mises.isel(frame=number).max("node") / MEGA).values.tolist()
        fields = {
            "bend": [packed(np.rint(one / bend_step), "i2") for one in bend[number]],
            "mises": [packed(np.rint(one / mises_step), "u2") for one in mises[number]],
            "highest": highest,
        }
        frames.append({"title": titles[number]} | _placed(instant(history, float(time)), shoes) | fields)
    return {
        "shoes": shoes,
        "position": packed(stress.node_position.transpose("node", "axis").values[used], "f4"),
        "triangle": packed(corners.reshape(-1, 3), "u4"),
        "bend_step": bend_step,
        "mises_step": mises_step,
        "limit": scales.stress / MEGA,
        "magnification": scales.displacement,
        "force_scale": scales.pair_force,
        "first": first_frame(stress),
        "verdicts": list(VERDICTS),
        "verdict": _verdicts(stress, used),
        "frames": frames,
        "undercarriage": _rollers(history),
    }


def _verdicts(stress: xr.Dataset, used: NDArray) -> list[str]:
    """Packed numbers of the verdicts on each shoe's nodes; none of a run that has none."""
    if "peak_verdict" not in stress:
        return []
    numbers = stress.peak_verdict.transpose("shoe", "node").values[:, used]
    return [packed(one, "i2") for one in numbers]


def _rollers(history: History) -> dict[str, Any] | None:
    """Shape and colour of the rollers of a rolled run."""
    if not rolls(history.dataset):
        return None
    return packed_undercarriage(history.case) | {"colour": ROLLER}


def _placed(now: xr.Dataset, shoes: Sequence[int]) -> dict[str, Any]:
    """Places of shoes in one instant, and what acts on them where."""
    poses = [Pose.of(now, shoe) for shoe in shoes]
    contacts = [acting(now, shoe) for shoe in shoes]
    side_frame = {}
    if rolls(now):
        pose = frame_pose(now)
        side_frame = {"side_frame": {"origin": pose.origin.tolist(), "turn": pose.frame.ravel().tolist()}}
    return side_frame | {
        "origin": [pose.origin.tolist() for pose in poses],
        "frame": [pose.frame.ravel().tolist() for pose in poses],
        "points": [packed(points, "f4") for points, _ in contacts],
        "forces": [packed(forces, "f4") for _, forces in contacts],
    }
