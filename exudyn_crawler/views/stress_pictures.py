"""Pictures of the flexible shoes' von Mises stress at single times, with the contact forces as arrows.

Every picture of a study has the same colours, the same arrow lengths and the same magnification of the
elastic displacement. `stress` is everywhere the dataset that the stress study leaves; `docs/report.md` lists
what it holds.
"""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.colours import STRESS_MAP
from exudyn_crawler.views.curves import STYLE, save_figure
from exudyn_crawler.views.placement import Pose, instant
from exudyn_crawler.views.scales import MEGA, Scales
from exudyn_crawler.views.scene import Scene, View
from exudyn_crawler.views.scenes import Backend, draw_scene, usual_backend
from exudyn_crawler.views.side_view import SideView
from exudyn_crawler.views.undercarriage import acting, rolls

SPREAD = 3.62
"""m that a column of shoes shows from left to right."""
BEHIND_ABOVE = View.seen_from(azimuth=190.0, elevation=30.0)
AHEAD_BELOW = View.seen_from(azimuth=10.0, elevation=-30.0)
FROM_THE_RIGHT = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))


def shoe_scene(
    stress: xr.Dataset, frame: float, shoe: int, scales: Scales, points: NDArray, forces: NDArray
) -> Scene:
    """Surface of a shoe in its own frame with its von Mises stress in MPa, bent as it is at a chosen time.

    Parameters
    ----------
    points, forces : arrays (contacts, 3)
        Where contacts press on the shoe (m) and how (N), in its frame.
    """
    now = stress.sel(shoe=shoe, frame=frame)
    used, corners = np.unique(stress.triangle.values, return_inverse=True)
    bend = now.frame_displacement.transpose("node", "axis").values[used]
    position = stress.node_position.transpose("node", "axis").values[used]
    return Scene(
        points=position + scales.displacement * bend,
        triangles=corners.reshape(stress.triangle.shape),
        values=now.frame_von_mises.values[used] / MEGA,
        arrows=np.stack((points - scales.pair_force * forces, points), axis=1),
    )


def stress_picture(
    stress: xr.Dataset,
    history: History,
    frame: float,
    scales: Scales | None = None,
    backend: Backend | None = None,
) -> Figure:
    """All flexible shoes at one chosen time: each from two sides, and all in place.

    Parameters
    ----------
    frame : float
        s, one of the chosen times.
    scales : Scales, optional
        Those of all chosen times, if not given.
    backend : {"opengl", "plain"}, optional
        What draws the surfaces; the usual one of this machine if not given.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        If `frame` is none of the chosen times.
    """
    if not np.isclose(stress.frame.values, frame, rtol=0.0, atol=1e-6).any():
        raise ValueError(
            f"frame must be one of the chosen times {stress.frame.values.tolist()}, got {frame:g}"
        )
    frame = float(stress.frame.sel(frame=frame, method="nearest"))
    scales = scales or Scales.of(stress, history)
    backend = backend or usual_backend()
    now = instant(history, frame)
    shoes = [int(shoe) for shoe in stress.shoe.values]
    poses = [Pose.of(now, shoe) for shoe in shoes]
    scenes = []
    for shoe, pose in zip(shoes, poses, strict=True):
        points, forces = acting(now, shoe)
        scenes.append(shoe_scene(stress, frame, shoe, scales, pose.inside(points), pose.components(forces)))
    with mpl.rc_context(STYLE | {"axes.grid": False, "figure.constrained_layout.use": False}):
        figure = Figure(figsize=(14.0, 3.6 + 1.6 * len(shoes)))
        page = _Page(figure, len(shoes))
        limits = (0.0, scales.stress / MEGA)
        bare = [scene.without_arrows() for scene in scenes]
        page.shoes(0, bare, BEHIND_ABOVE, limits, backend, "from behind and above")
        page.shoes(1, scenes, AHEAD_BELOW, limits, backend, "from ahead and below")
        page.label(stress, frame, shoes)
        placed = [
            Scene(pose.place(scene.points), scene.triangles, scene.values, scene.arrows)
            for pose, scene in zip(poses, bare, strict=True)
        ]
        page.track(history, now, Scene.joined(placed), scales, limits, backend)
        page.scale(limits)
        figure.text(
            0.01, 0.985, f"{history.case.name}: von Mises stress at t = {frame:g} s", va="top", fontsize=13
        )
        acts = "forces of ground and rollers" if rolls(now) else "contact forces"
        figure.text(
            0.01,
            0.985 - 0.3 / figure.get_figheight(),
            f"elastic displacement drawn {scales.displacement:g} times larger; circle: highest stress on the "
            f"shoe's surface, where it is seen; blue arrows: {acts} on the shoe, "
            f"{1e5 * scales.pair_force:.2f} m long for 100 kN in single contacts and "
            f"{1e5 * scales.shoe_force:.2f} m for the sum below",
            va="top",
            fontsize=8.5,
            color="#444444",
        )
    return figure


class _Page:
    """Places of the parts on a picture, in inches from its corners."""

    LEFT, GAP, RIGHT, TOP, STRIP, BOTTOM = 1.1, 0.15, 0.95, 0.85, 1.9, 0.55

    def __init__(self, figure: Figure, rows: int) -> None:
        self.figure, self.rows = figure, rows
        self.width, self.height = figure.get_size_inches()
        self.column = 0.5 * (self.width - self.LEFT - self.GAP - self.RIGHT)
        self.tall = self.height - self.TOP - self.STRIP - self.BOTTOM - 0.3

    def axes(self, left: float, bottom: float, width: float, height: float) -> Axes:
        """Axes at a place in inches."""
        return self.figure.add_axes(
            (left / self.width, bottom / self.height, width / self.width, height / self.height)
        )

    def shoes(
        self,
        column: int,
        scenes: Sequence[Scene],
        view: View,
        limits: tuple[float, float],
        backend: Backend,
        title: str,
    ) -> None:
        """Shoes one below the other, each in its own frame, with their highest places."""
        ax = self.axes(
            self.LEFT + column * (self.column + self.GAP),
            self.STRIP + self.BOTTOM + 0.15,
            self.column,
            self.tall,
        )
        spacing = SPREAD * self.tall / self.column / self.rows
        moved = [scene.moved(-row * spacing * view.up) for row, scene in enumerate(scenes)]
        first = view.project(scenes[0].points)
        x = 0.5 * (first[:, 0].min() + first[:, 0].max())
        # room for arrows below the last shoe
        top = first[:, 1].max() + 0.02
        window = (x - 0.5 * SPREAD, x + 0.5 * SPREAD, top - self.rows * spacing, top)
        draw_scene(ax, Scene.joined(moved), view, window, limits, backend)
        for scene in moved:
            highest = int(scene.values.argmax())
            if scene.shows(highest, view):
                place = view.project(scene.points[[highest]])[0]
                ax.plot(place[0], place[1], "o", ms=9, mfc="none", mec="black", mew=0.9, zorder=5)
        ax.set_title(title, fontsize=9.5, loc="left")
        ax.set_axis_off()

    def label(self, stress: xr.Dataset, frame: float, shoes: Sequence[int]) -> None:
        """Numbers of the shoes and their highest stresses at the left."""
        for row, shoe in enumerate(shoes):
            highest = float(stress.frame_von_mises.sel(shoe=shoe, frame=frame).max()) / MEGA
            y = self.STRIP + self.BOTTOM + 0.15 + self.tall * (1.0 - (row + 0.5) / self.rows)
            self.figure.text(0.15 / self.width, y / self.height, f"shoe {shoe}", fontsize=11, va="bottom")
            self.figure.text(0.15 / self.width, y / self.height, f"{highest:.1f} MPa", fontsize=9, va="top")

    def track(
        self,
        history: History,
        now: xr.Dataset,
        scene: Scene,
        scales: Scales,
        limits: tuple[float, float],
        backend: Backend,
    ) -> None:
        """Whole track from the right, with the contact force of each shoe."""
        ax = self.axes(self.LEFT, self.BOTTOM, self.width - self.LEFT - self.GAP - self.RIGHT, self.STRIP)
        view = SideView(ax, history, 1.0, scales.shoe_force, filled=False)
        view.show(now)
        draw_scene(ax, scene, FROM_THE_RIGHT, (*ax.get_xlim(), *ax.get_ylim()), limits, backend)
        ax.set_title("in place, seen from the right", fontsize=9.5, loc="left")

    def scale(self, limits: tuple[float, float]) -> None:
        """Bar of the colours at the right."""
        ax = self.axes(self.width - 0.75, self.STRIP + self.BOTTOM + 0.4, 0.18, self.tall - 0.5)
        self.figure.colorbar(
            ScalarMappable(Normalize(*limits), STRESS_MAP), cax=ax, label="von Mises stress in MPa"
        )


def picture_name(frame: float) -> str:
    """File name of the picture at a time (s); names sort as times do."""
    return f"stress_{frame:08.4f}s.png"


PICTURES = "stress_[0-9]*s.png"
"""Pattern of the pictures' file names."""


def picture_time(path: Path) -> float:
    """Time (s) that a picture's file name says."""
    return float(path.stem.removeprefix("stress_").removesuffix("s"))


def write_stress_pictures(
    stress: xr.Dataset,
    history: History,
    folder: Path,
    overwrite: bool = False,
    backend: Backend | None = None,
) -> list[Path]:
    """Write a picture of every chosen time into a folder.

    Returns
    -------
    list of Path
        In order of time.

    Raises
    ------
    FileExistsError
        If a file exists and `overwrite` is false.
    """
    scales = Scales.of(stress, history)
    return [
        save_figure(
            stress_picture(stress, history, float(frame), scales, backend),
            folder / picture_name(float(frame)),
            overwrite,
        )
        for frame in stress.frame.values
    ]
