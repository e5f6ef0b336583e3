"""Moving pictures of one flexible shoe with its stress, and of the rollers that pass over it."""

from dataclasses import replace
from pathlib import Path
from typing import Unpack

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.results.stress.recovery import surface_stress
from exudyn_crawler.views.colours import ROLLER, ROLLER_FORCE, STRESS_MAP
from exudyn_crawler.views.curves import STYLE
from exudyn_crawler.views.film import RATE, Shown, check_film, drawn_image, film_times, write_film
from exudyn_crawler.views.phase_bands import draw_phases
from exudyn_crawler.views.placement import Pose, shoe_forces_over_time
from exudyn_crawler.views.scales import BENT, MEGA, drawn_scale, round_up
from exudyn_crawler.views.scene import Body, Scene, View
from exudyn_crawler.views.scenes import Backend, draw_scene, usual_backend
from exudyn_crawler.views.undercarriage import acting, rollers_surface, rolls

WIDTH, HEIGHT, DPI = 9.0, 8.2, 90
"""Inches, and pixels an inch, of a picture."""
ABOVE = View.seen_from(azimuth=212.0, elevation=34.0)
BELOW = View.seen_from(azimuth=212.0, elevation=-28.0)
NEAR = 1.1
"""m along the shoe from its COM to the rollers' axes that are shown with it."""
MARGIN = 0.08
"""m about what is shown."""
OPACITY = 0.35
"""Of rollers, which would hide the rails."""
LONGEST = 0.35
"""m at which the greatest single force on the shoe is drawn."""
PLACES = {"above": (0.02, 0.51, 0.84, 0.41), "below": (0.02, 0.255, 0.84, 0.25)}
"""Parts of a picture: left, bottom, width and height over its own."""


class ShoePicture:
    """Shoe with its stress from above and from below, and its load over time; `image` draws a time.

    Colours, magnification of the elastic displacement and lengths of arrows are the same at all times.

    Parameters
    ----------
    history : History
    shoe : int
        Number of a flexible shoe.
    times : array (n,)
        s; the stored instants nearest to them can be shown.
    backend : {"opengl", "plain"}, optional
        What draws the surface; the usual one of this machine if not given.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history.
    """

    def __init__(self, history: History, shoe: int, times: NDArray, backend: Backend | None = None) -> None:
        rows = np.unique(history.dataset.get_index("time").get_indexer(times, method="nearest"))
        self._history, self._shoe = history, shoe
        self._stress = surface_stress(history, shoe, rows)
        self._backend: Backend = backend or usual_backend()
        greatest = float(self._stress.von_mises.max()) / MEGA
        self._limits = (0.0, round_up(greatest) if greatest > 0.0 else 1.0)
        self._bend = drawn_scale(self._stress.displacement.values, BENT)
        self._instants = history.dataset.isel(time=rows).load()
        every = (acting(self._instants.isel(time=row), shoe)[1] for row in range(len(rows)))
        longest = max(float(np.linalg.norm(forces, axis=1).max(initial=0.0)) for forces in every)
        self._force_scale = LONGEST / longest if longest > 0.0 else 0.0
        with mpl.rc_context(STYLE | {"figure.constrained_layout.use": False}):
            self.figure = Figure(figsize=(WIDTH, HEIGHT), dpi=DPI)
            self._axes = {name: self.figure.add_axes(place) for name, place in PLACES.items()}
            for ax in self._axes.values():
                ax.set_axis_off()
            self._cursor = self._draw_curves(self.figure.add_axes((0.08, 0.07, 0.8, 0.17)))
            colours = self.figure.add_axes((0.88, 0.34, 0.022, 0.53))
            mappable = ScalarMappable(Normalize(*self._limits), STRESS_MAP)
            self.figure.colorbar(mappable, cax=colours, label="von Mises stress in MPa")
            self._title = self.figure.text(0.02, 0.985, "", va="top", fontsize=13, parse_math=False)
            said = f"elastic displacement drawn {self._bend:g} times larger; arrows: forces on the shoe"
            self.figure.text(0.02, 0.947, said, va="top", fontsize=8.5, color="#444444")

    def _draw_curves(self, ax: Axes) -> Line2D:
        """Draw what presses on the shoe and its highest stress over time, and a cursor, which is returned."""
        time, shown = self._history.time, self._stress.time.values
        if rolls(self._history.dataset):
            pressed = -self._history.rail_force.sel(shoe=self._shoe, axis="z").values
            name = "rollers on the shoe"
        else:
            pressed = shoe_forces_over_time(self._history.dataset.sel(shoe=[self._shoe]))[1][:, 0, 2]
            name = "ground on the shoe"
        ax.plot(time, pressed / 1e3, color=ROLLER_FORCE, label=name)
        ax.set(xlabel="time in s", ylabel="force in kN", xlim=(shown[0], shown[-1]))
        stress = ax.twinx()
        stress.plot(shown, self._stress.von_mises.max("node") / MEGA, color="black", label="highest stress")
        stress.set(ylabel="stress in MPa", ylim=self._limits)
        stress.spines["right"].set_visible(True)
        stress.grid(False)
        draw_phases([ax], common_phases(self._history))
        lines = [*ax.lines, *stress.lines]
        ax.legend(lines, [str(line.get_label()) for line in lines], loc="upper left", ncols=2)
        return ax.axvline(shown[0], color="black", lw=0.8)

    def scene(self, now: xr.Dataset) -> Scene:
        """Shoe in its own frame at an instant, bent, with what presses on it and the rollers near it."""
        stress = self._stress.sel(time=now.time)
        pose = Pose.of(now, self._shoe)
        points, forces = acting(now, self._shoe)
        heads = pose.inside(points)
        return Scene(
            points=stress.node_position.values + self._bend * stress.displacement.values,
            triangles=stress.triangle.values,
            values=stress.von_mises.values / MEGA,
            arrows=np.stack((heads - self._force_scale * pose.components(forces), heads), axis=1),
            bodies=self._rollers(now, pose),
        )

    def _rollers(self, now: xr.Dataset, pose: Pose) -> tuple[Body, ...]:
        """Treads whose axes are near the shoe, in its frame."""
        if not rolls(now):
            return ()
        points, triangles = rollers_surface(now, self._history.case)
        treads = now.sizes["roller"] * now.sizes["rail"]
        inside = pose.inside(points).reshape(treads, -1, 3)
        each = triangles[: len(triangles) // treads]
        near = np.abs(inside.mean(axis=1)[:, 0]) < NEAR
        return tuple(Body(tread, each, ROLLER, OPACITY) for tread in inside[near])

    def _window(self, view: View, rollers: bool) -> tuple[float, float, float, float]:
        """Least and greatest coordinates to the right and upward of what is shown at any time."""
        places, case = self._stress.node_position.values, self._history.case
        if rollers and case.undercarriage is not None and case.shoe.rails is not None:
            rails, radius = case.shoe.rails, case.undercarriage.radius
            top = rails.height + 2.0 * radius
            places = np.vstack((places, [(x, y, top) for x in (-NEAR, NEAR) for y in rails.middles]))
        seen = view.project(places)
        (left, bottom, _), (right, top, _) = seen.min(axis=0) - MARGIN, seen.max(axis=0) + MARGIN
        return float(left), float(right), float(bottom), float(top)

    def image(self, time: float) -> NDArray:
        """Picture at the shown instant nearest to a time (s): array (height, width, 3), uint8."""
        now = self._instants.sel(time=time, method="nearest")
        scene = self.scene(now)
        from_below = replace(scene, bodies=())
        for name, view, shown in (("above", ABOVE, scene), ("below", BELOW, from_below)):
            ax = self._axes[name]
            for artist in (*ax.images, *ax.collections, *ax.patches):
                artist.remove()
            window = self._window(view, name == "above")
            draw_scene(ax, shown, view, window, self._limits, self._backend, DPI)
        self._cursor.set_xdata([float(now.time)] * 2)
        self._title.set_text(f"{self._history.case.name}, shoe {self._shoe}: t = {float(now.time):.2f} s")
        return drawn_image(self.figure)


def write_stress_animation(
    history: History,
    shoe: int,
    path: Path,
    overwrite: bool = False,
    **shown: Unpack[Shown],
) -> Path:
    """Write an animation of a flexible shoe with its stress as MP4 or GIF, without a display.

    Parameters
    ----------
    shoe : int
        Number of a flexible shoe.
    path : Path
        File to write; its suffix, `.mp4` or `.gif`, says which.
    **shown
        Options `rate`, `speed`, `start` and `end` of `film_times`.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    ValueError
        For another suffix, a shoe that is not flexible, times outside the run, or a rate or speed that is not
        positive.
    FileExistsError
        If the file exists and `overwrite` is false.
    """
    check_film(path, overwrite)
    times = film_times(history.duration, **shown)
    picture = ShoePicture(history, shoe, times)
    images = (picture.image(float(time)) for time in times)
    return write_film(images, path, shown.get("rate", RATE), overwrite)
