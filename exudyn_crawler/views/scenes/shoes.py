"""Flexible shoes in space: bent, coloured by stress, with the forces on them and the rollers nearby.

`stress` is the dataset of the stress study, or part of it; `docs/report.md` lists its variables. All stress
pictures of a study have the same colours, arrow lengths and magnification of the elastic displacement.
"""

from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from exudyn_crawler.results.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import gear, pictures, track
from exudyn_crawler.views.scenes.scene import Arrows, Colouring, Placement, Scene, Solid, View
from fem.stress.trust import VERDICTS

LONGEST_OF_SHOE, LONGEST_OF_PAIR, BENT = 0.7, 0.4, 0.04
"""Drawn lengths (m) of the greatest force on a shoe, of the greatest single contact or tread force, and, at
most, of the greatest elastic displacement."""
BESIDE, ROLLER_OPACITY = 0.75, 0.4
"""Distance (m) from a shoe within which rollers are drawn; their opacity, since they would hide the rails."""
STRESS = "von Mises stress"
TRUST = "how far to trust the greatest stress"
VERDICT_COLOURS = (
    *("#00682f", "#238443", "#41ab5d", "#78c679", "#a6d96a", "#c5e86c", "#e6f598", "#fff3a0"),
    *("#f79440", "#d73027", "#7b3294", "#d9d9d9"),
)
"""Colours of `fem.stress.trust.VERDICTS`, and of stress too low to be judged."""
LOW = 0.1  # part of the highest stress below which a stress is not judged: its relative error is of no use
SPREAD, HEADROOM = 3.62, 0.02
"""Width (m) of a view of a shoe, and room (m) above the shoe; the room below is for arrows."""
VIEWS = {
    "from behind and above": View.seen_from(azimuth=190.0, elevation=30.0),
    "from ahead and below": View.seen_from(azimuth=10.0, elevation=-30.0),
}
WIDTH, ROW, STRIP, HEAD, FOOT = 14.0, 1.6, 1.9, 1.05, 0.55
"""Inches: width of a stress picture; heights of a shoe, of the track below all shoes, and of the text."""
PICTURES = "stress_[0-9]*s.png"  # pattern of the stress pictures' file names


def shoe_force_scale(history: History) -> float:
    """Return the drawn length (m) of 1 N of contact force on a shoe; 0 if the run has no contact."""
    greatest = track.greatest_shoe_force(history)
    return LONGEST_OF_SHOE / greatest if greatest > 0.0 else 0.0


def stress_scene(stress: xr.Dataset, history: History) -> Scene:
    """Return all flexible shoes at the chosen times of the stresses, with single forces and near rollers."""
    used, corners = np.unique(stress.triangle.transpose("face", "corner").values, return_inverse=True)
    faces = (corners.reshape(-1, 3),)
    points = stress.node_position.transpose("node", "axis").values[used]
    shown = history.dataset.sel(time=stress.frame.values, method="nearest").load()
    origin, turn = gear.poses(shown.sel(shoe=stress.shoe.values))
    numbers = list(map(int, stress.shoe.values))
    pressing = [track.forces_on(shown, shoe) for shoe in numbers]
    sizes = np.concatenate([np.linalg.norm(forces, axis=-1) for _, forces in pressing], axis=1)
    longest = float(np.nan_to_num(sizes).max(initial=0.0))
    force_scale = LONGEST_OF_PAIR / longest if longest > 0.0 else 0.0
    larger = style.drawn_scale(stress.frame_displacement.values, BENT)
    greatest = float(stress.frame_von_mises.isel(node=used).max()) / style.MEGA
    ends = 0.0, style.round_up(greatest) if greatest > 0.0 else 1.0
    usable = ~stress.in_spider.values
    solids = []
    arrows = []
    for k, shoe in enumerate(numbers):
        data = stress.sel(shoe=shoe)
        name = f"shoe {shoe}"
        mises = data.frame_von_mises.transpose("frame", "node").values / style.MEGA
        bend = data.frame_displacement.transpose("frame", "node", "axis").values[:, used]
        notes = tuple(f"{peak:.1f} MPa" for peak in mises[:, usable].max(axis=1))
        colouring = Colouring(f"{STRESS} in MPa", mises[:, None, used], *ends, style.STRESS_MAP, name=STRESS)
        placed = Solid(name, points, faces, "white", origin[:, [k]], turn[:, [k]], labels=(name,), nodes=used)
        bent = replace(placed, notes=notes, bend=bend[:, None], larger=larger)
        solids.append(replace(bent, colourings=(colouring, _trust(stress, shoe, used))))
        tall = float(np.ptp(points[:, 2]))
        arrows.append(Arrows("contact forces", style.CONTACT_FORCE, *pressing[k], force_scale, name, tall))
    near = gear.near_gear(History(history.case, shown), origin, BESIDE)
    solids += [replace(solid, opacity=ROLLER_OPACITY) for solid in near]
    return Scene(tuple(frame_titles(stress)), tuple(solids), tuple(arrows))


def _trust(stress: xr.Dataset, shoe: int, used: np.ndarray) -> Colouring:
    """Return verdicts on the greatest stress at each node of a shoe's surface."""
    highest = stress.peak_von_mises.isel(node=used)
    low = highest.sel(shoe=shoe).values < LOW * float(highest.max())
    numbers = stress.peak_verdict.sel(shoe=shoe).values[used]
    return verdict_colouring(numbers, low, f"low: below {100 * LOW:g} % of the highest", TRUST)


def verdict_colouring(numbers: np.ndarray, low: np.ndarray, low_words: str, name: str) -> Colouring:
    """Return colours of verdicts (n,), of `trust.VERDICTS`; nodes with `low` (n,) stress are not judged."""
    judged = np.where(numbers < 0, np.nan, np.where(low, len(VERDICTS), numbers))
    words = (*VERDICTS, low_words)
    return Colouring("verdict", judged[None, None], -0.5, len(VERDICTS) + 0.5, VERDICT_COLOURS, words, name)


def frame_titles(stress: xr.Dataset) -> list[str]:
    """Return the chosen times for reading: ``t = 0.226 s, peak``."""
    named = zip(stress.frame.values, stress.frame_name.values, strict=True)
    return [", ".join(filter(None, (f"t = {time:.6g} s", name))) for time, name in named]


def first_frame(stress: xr.Dataset) -> int:
    """Return the index of the peak or, if the chosen times lack it, of the highest stress among them."""
    peaks = [k for k, title in enumerate(frame_titles(stress)) if "peak" in title.split(", ")]
    return peaks[0] if peaks else int(stress.frame_von_mises.max(("shoe", "node")).values.argmax())


def stress_picture(scene: Scene, now: History, time: int, force_scale: float) -> Figure:
    """Draw the flexible shoes of a stress scene at a time index: each from two sides, and all in place.

    `now` is that instant, see `track.instants`. 1 N of the resultant on a shoe is `force_scale` m long.
    """
    bent = [solid for solid in scene.solids if solid.colourings]
    tall = HEAD + ROW * len(bent) + STRIP + FOOT
    with mpl.rc_context(style.STYLE | {"axes.grid": False, "figure.constrained_layout.use": False}):
        figure = Figure(figsize=(WIDTH, tall))
        place = {"left": 0.08, "right": 0.93, "top": 1.0 - HEAD / tall, "bottom": (STRIP + FOOT) / tall}
        grid = figure.add_gridspec(len(bent), 2, wspace=0.02, hspace=0.0, **place)
        for row, (shoe, forces) in enumerate(zip(bent, scene.arrows, strict=True)):
            for column, (title, view) in enumerate(VIEWS.items()):
                ax = figure.add_subplot(grid[row, column])
                _draw_shoe(ax, shoe, forces, view, time)
                if row == 0:
                    ax.set_title(title, fontsize=9.5, loc="left")
            y = figure.axes[-2].get_position().intervaly.mean()
            figure.text(0.011, y, shoe.name, fontsize=11, va="bottom")
            figure.text(0.011, y, shoe.notes[time], fontsize=9, va="top")
        ax = figure.add_axes((0.08, FOOT / tall, 0.85, (STRIP - 0.3) / tall))
        pictures.draw_side(ax, now, 1.0, force_scale, opacity=0.0)
        _, window = pictures.windows(now)
        pictures.paint(ax, [shoe.at(time) for shoe in bent], pictures.FROM_THE_RIGHT, window)
        ax.set(xlabel="x in m", ylabel="z in m")
        ax.set_title("in place, seen from the right", fontsize=9.5, loc="left")
        bottom = (STRIP + FOOT + 0.3) / tall
        beside = figure.add_axes((0.945, bottom, 0.013, 1.0 - HEAD / tall - bottom))
        colours = bent[0].colourings[0]
        figure.colorbar(
            style.scale_of(colours.low, colours.high, style.STRESS_MAP), cax=beside, label=colours.title
        )
        title = f"{now.case.name}: von Mises stress at t = {now.duration:g} s"
        figure.text(0.011, 1.0 - 0.1 / tall, title, va="top", fontsize=13, parse_math=False)
        words = (
            f"elastic displacement drawn {bent[0].larger:g} times larger; circle: highest stress on the "
            f"shoe's surface, where it is seen\nblue arrows: all that presses on the shoe, "
            f"{1e5 * scene.arrows[0].scale:.2f} m long for 100 kN in single contacts and "
            f"{1e5 * force_scale:.2f} m for the sum below"
        )
        figure.text(0.011, 1.0 - 0.4 / tall, words, va="top", fontsize=8.5, color="#444444")
    return figure


def _draw_shoe(ax: mpl.axes.Axes, shoe: Solid, forces: Arrows, seen_from: View, time: int) -> None:
    """Draw a shoe in its own axes with the forces on it, and a circle at its highest stress if visible."""
    solid = shoe.at(time)
    view = seen_from.on(Placement(shoe.origin[time, 0], shoe.turn[time, 0]))
    seen = view.project(solid.points)
    middle = 0.5 * (seen[:, 0].min() + seen[:, 0].max())
    top = seen[:, 1].max() + HEADROOM
    place = ax.get_window_extent()
    window = (middle - 0.5 * SPREAD, middle + 0.5 * SPREAD, top - SPREAD * place.height / place.width, top)
    pictures.paint(ax, [solid], view, window)
    pictures.draw_arrows(ax, [forces], view, time)
    highest = int(solid.values.argmax())
    if solid.shows(highest, view):
        ax.plot(*seen[highest, :2], "o", ms=9, mfc="none", mec="black", mew=0.9, zorder=5)
    ax.set_axis_off()


def picture_name(frame: float) -> str:
    """Return the file name of the stress picture at a time (s); names sort by time."""
    return f"stress_{frame:08.4f}s.png"


def picture_time(path: Path) -> float:
    """Return the time (s) in the file name of a stress picture."""
    return float(path.stem.removeprefix("stress_").removesuffix("s"))


def write_stress_pictures(
    stress: xr.Dataset, history: History, folder: Path, overwrite: bool = False
) -> list[Path]:
    """Write a picture of every chosen time into a folder; return paths by time; raises as `save_figure`."""
    scene = stress_scene(stress, history)
    force_scale = shoe_force_scale(history)
    written = []
    for time, frame in enumerate(stress.frame.values.tolist()):
        figure = stress_picture(scene, track.instants(history, [frame]), time, force_scale)
        written.append(style.save_figure(figure, folder / picture_name(frame), overwrite))
        # reference cycles keep the surfaces and images of a figure alive
        figure.clear()
    return written
