"""Moving pictures of one flexible shoe with its stress, and of the rollers that pass over it."""

from pathlib import Path
from typing import Unpack

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.results.stress.recovery import surface_stress
from exudyn_crawler.views import style
from exudyn_crawler.views.curves import draw_phases
from exudyn_crawler.views.scenes import poses, shoes
from exudyn_crawler.views.scenes.drawing import Backend, Window, draw_arrows, draw_solids, usual_backend
from exudyn_crawler.views.scenes.film_files import Picture, Shown, write_film
from exudyn_crawler.views.scenes.scene import Scene, View

WIDTH, HEIGHT, DPI = 9.0, 8.2, 90
"""Inches, and pixels an inch, of a picture."""
VIEWS = {"above": View.seen_from(azimuth=212.0, elevation=34.0), "below": View.seen_from(212.0, -28.0)}
PARTS = {"above": (0.02, 0.51, 0.84, 0.41), "below": (0.02, 0.255, 0.84, 0.25)}
"""Parts of a picture: left, bottom, width and height over its own."""
NEAR = 1.1
"""m along the track from the shoe's COM to the rollers' axes that are shown with it."""
MARGIN = 0.08
"""m about the shoe that are shown."""
LONGEST = 0.35
"""m at which the greatest single force on the shoe is drawn."""


class ShoePicture(Picture):
    """Shoe with its stress from above and from below, and its load over time.

    Colours, magnification of the elastic displacement and lengths of arrows are the same at all times.

    Parameters
    ----------
    history : History
    shoe : int
        Number of a flexible shoe.
    times : array (n,)
        s; the stored instants nearest to them can be shown.
    backend : {"opengl", "painted"}, optional
        What draws the surface; the usual one of this machine if not given.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history.
    """

    def __init__(self, history: History, shoe: int, times: NDArray, backend: Backend | None = None) -> None:
        rows = np.unique(history.dataset.get_index("time").get_indexer(times, method="nearest"))
        self._stress = surface_stress(history, shoe, rows)
        shown = history.dataset.isel(time=rows).load()
        self.history, self._shoe = History(history.case, shown), shoe
        self.name = f"{history.case.name}, shoe {shoe}"
        self._backend: Backend = backend or usual_backend()
        self.limit = shoes.end_of_colours(float(self._stress.von_mises.max()))
        self.larger = style.drawn_scale(self._stress.displacement.values, shoes.BENT)
        forces = [poses.acting(shown.isel(time=row), shoe)[1] for row in range(len(rows))]
        self.force_scale = shoes.length_per_newton(LONGEST, forces)
        with mpl.rc_context(style.STYLE | {"figure.constrained_layout.use": False}):
            self.figure = Figure(figsize=(WIDTH, HEIGHT), dpi=DPI)
            self._axes = {name: self.figure.add_axes(place) for name, place in PARTS.items()}
            for ax in self._axes.values():
                ax.set_axis_off()
            self.cursor = self._draw_curves(self.figure.add_axes((0.08, 0.07, 0.8, 0.17)), history)
            mappable = ScalarMappable(Normalize(0.0, self.limit / style.MEGA), style.STRESS_MAP)
            bar = self.figure.add_axes((0.88, 0.34, 0.022, 0.53))
            self.figure.colorbar(mappable, cax=bar, label="von Mises stress in MPa")
            self.title = self.figure.text(0.02, 0.985, "", va="top", fontsize=13, parse_math=False)
            said = f"elastic displacement drawn {self.larger:g} times larger; arrows: forces on the shoe"
            self.figure.text(0.02, 0.947, said, va="top", fontsize=8.5, color="#444444")

    def _draw_curves(self, ax: Axes, history: History) -> Line2D:
        """Draw what presses on the shoe and its highest stress over time, and a cursor, which is returned."""
        shown = self._stress.time.values
        if poses.rolls(history.dataset):
            pressed, name = -history.rail_force.sel(shoe=self._shoe, axis="z").values, "rollers on the shoe"
        else:
            alone = history.dataset.sel(shoe=[self._shoe])
            pressed, name = poses.shoe_forces(alone)[1][:, 0, 2], "ground on the shoe"
        ax.plot(history.time, pressed / style.KILO, color=style.ROLLER_FORCE, label=name)
        # room for the legend above the curves
        ax.margins(y=0.35)
        ax.set(xlabel="time in s", ylabel="force in kN", xlim=(shown[0], shown[-1]))
        stress = ax.twinx()
        highest = self._stress.von_mises.max("node") / style.MEGA
        stress.plot(shown, highest, color="black", label="highest stress")
        stress.set(ylabel="stress in MPa", ylim=(0.0, self.limit / style.MEGA))
        stress.spines["right"].set_visible(True)
        stress.grid(False)
        draw_phases([ax], common_phases(history))
        lines = [*ax.lines, *stress.lines]
        ax.legend(lines, [str(line.get_label()) for line in lines], loc="upper left", ncols=2)
        return ax.axvline(shown[0], color="black", lw=0.8)

    def scene(self, now: xr.Dataset) -> Scene:
        """Shoe in its own axes at an instant, bent, with what presses on it and the rollers near it."""
        stress, moment = self._stress.sel(time=now.time.values), now.isel(time=0)
        pose = poses.shoe_pose(moment, self._shoe)
        shape = stress.node_position.values, stress.triangle.values
        fields = stress.displacement.values, stress.von_mises.values
        solids = [shoes.shoe_solid(self._shoe, shape, [pose], *fields, self.limit, self.larger)]
        if poses.rolls(now):
            x = float(pose.origin[0])
            solids.append(shoes.rollers_between(self.history.case, now, x - NEAR, x + NEAR))
        forces = shoes.forces_on(solids[0].name, [poses.acting(moment, self._shoe)], self.force_scale)
        return Scene(("",), tuple(solids), (forces,)).seen_in(pose)

    def _window(self, view: View, with_rollers: bool) -> Window:
        """Least and greatest coordinates to the right and upward of what is shown at any time."""
        points, case = self._stress.node_position.values, self.history.case
        if with_rollers and case.undercarriage is not None and case.shoe.rails is not None:
            rails, radius = case.shoe.rails, case.undercarriage.radius
            top = rails.height + 2.0 * radius
            points = np.vstack((points, [(x, y, top) for x in (-NEAR, NEAR) for y in rails.middles]))
        seen = view.project(points)
        (left, bottom, _), (right, top, _) = seen.min(axis=0) - MARGIN, seen.max(axis=0) + MARGIN
        return float(left), float(right), float(bottom), float(top)

    def draw(self, now: xr.Dataset) -> list[Artist]:
        """Shoe from above with the rollers, and from below without."""
        scene, drawn = self.scene(now), []
        for name, view in VIEWS.items():
            solids = [one.at() for one in scene.solids[: None if name == "above" else 1]]
            ax, window = self._axes[name], self._window(view, name == "above")
            drawn += draw_solids(ax, solids, view, window, self._backend, DPI)
            drawn += draw_arrows(ax, scene.arrows[0].at(), scene.arrows[0].colour, view)
        return drawn


def write_stress_animation(
    history: History, shoe: int, path: Path, overwrite: bool = False, **shown: Unpack[Shown]
) -> Path:
    """Write an animation of a flexible shoe with its stress as MP4 or GIF, without a display.

    Arguments and errors are those of `write_animation`, and `shoe` is the number of a flexible shoe.
    """
    return write_film(
        lambda times: ShoePicture(history, shoe, times), history.duration, path, overwrite, **shown
    )
