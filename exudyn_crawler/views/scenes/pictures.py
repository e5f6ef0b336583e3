"""Scenes on axes of matplotlib in parallel projection: the track from the side and from above.

Solids are painted back to front, which needs neither a display nor OpenGL. Flat solids have edges; opaque
solids without edges are `shaded`. The ground's displacement under the track is a few millimetres, counted
from the level under its own weight; the side view can magnify it. All bodies above then move up or down with
the ground beneath, so that shoes keep their true depth in the ground and rollers theirs in the rails.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.case import CellTerrain, Terrain, statics
from exudyn_crawler.results.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import gear, track
from exudyn_crawler.views.scenes.scene import FLAT, Arrows, Scene, Solid, View, carried, disc, upward
from exudyn_crawler.views.scenes.shaded import shade, shaded_surface, turned_to_viewer

Window = tuple[float, float, float, float]
"""Least and greatest coordinate to the right, then upward, m."""
Drawn = list[mpl.artist.Artist]
ARROW_WIDTH, FINEST = 0.018, 0.06
"""Width of an arrow's shaft (inches); longest edge of shaded triangles that are not split (m)."""
FROM_THE_RIGHT = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
FROM_ABOVE = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
MARGIN = (0.6, 0.4, 1.0)  # m shown beyond the track, beside it and below the ground
ABOVE, DEPTH = 0.4, 0.4
"""Height (m) shown above a side frame, which magnified ground may lift; depth (m) shown below the lowest
face."""
PIN, PIN_SIDES = 0.03, 12  # m, radius of a drawn link pin; sides of its prism


def paint(ax: Axes, solids: list[Solid], view: View, window: Window | None = None) -> mpl.artist.Artist:
    """Draw the visible faces of solids, each in one colour, in axes in m; a window sets their limits."""
    if window is not None:
        ax.set(xlim=window[:2], ylim=window[2:], aspect="equal")
    drawn: mpl.collections.Collection
    if any(solid.edges or solid.opacity < 1.0 for solid in solids):
        drawn = _polygons(solids, view)
    else:
        drawn = shaded_surface(solids, view, zorder=1)
    ax.add_collection(drawn, autolim=False)
    return drawn


def _polygons(solids: list[Solid], view: View) -> mpl.collections.PolyCollection:
    """Return the faces of solids that are turned to the viewer, the nearest last."""
    parts: list[_Faces] = []
    for solid in solids:
        points = np.column_stack((view.project(solid.points), solid.values))
        kinds = [points[faces] for faces in solid.faces] if solid.edges else [_fine(points[solid.triangles])]
        parts += [_seen_faces(solid, corners) for corners in kinds]
    order = np.argsort(np.concatenate([part.depths for part in parts]), kind="stable")
    fills = np.concatenate([part.fills for part in parts])[order]
    lines = np.concatenate([part.lines for part in parts])[order]
    # the type hints of matplotlib omit arrays
    polygons: Any = _of_one_length([part.outlines for part in parts])[order]
    how: dict[str, Any] = {"facecolors": fills, "edgecolors": lines, "linewidths": 0.7, "zorder": 1}
    return mpl.collections.PolyCollection(polygons, **how)


class _Faces(NamedTuple):
    """Faces of a solid that are turned to the viewer."""

    outlines: np.ndarray  # (m, k, 2), m to the right and upward
    fills: np.ndarray  # (m, 4), colours of the faces
    lines: np.ndarray  # (m, 4), colours of the lines around them
    depths: np.ndarray  # (m,), m toward the viewer


def _seen_faces(solid: Solid, points: np.ndarray) -> _Faces:
    """Return the visible faces of a solid; `points` (m, k, 4) are corners in the view, m, and values."""
    corners = points[..., :3]
    normals, seen = turned_to_viewer(corners)
    fills = _fills(solid, points[seen, :, 3].mean(axis=1), normals[seen])
    if solid.edges not in ("", FLAT) and corners.shape[1] > 3:
        lines = np.tile(mpl.colors.to_rgba(solid.edges), (len(fills), 1))
    else:
        # opaque faces have lines of their own colour, so that no gap shows between them
        lines = fills * [1.0, 1.0, 1.0, solid.opacity == 1.0]
    return _Faces(corners[seen, :, :2], fills, lines, corners[seen, :, 2].mean(axis=1))


def _of_one_length(outlines: list[np.ndarray]) -> np.ndarray:
    """Return outlines (m, k, 2) of faces as one array; shorter ones repeat their last corner.

    matplotlib makes paths of an array in a tenth of the time that it takes for a list.
    """
    most = max(part.shape[1] for part in outlines)
    corners = np.arange(most)
    return np.concatenate([part[:, np.minimum(corners, part.shape[1] - 1)] for part in outlines])


def _fills(solid: Solid, values: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return colours (m, 4) of faces by their values (m,), shaded by their normals (m, 3) without edges."""
    colours = np.tile(mpl.colors.to_rgba(solid.colour), (len(values), 1))
    for colouring in solid.colourings:
        colours = style.colour_map(colouring.colours)(
            mpl.colors.Normalize(colouring.low, colouring.high)(values)
        )
    colours[:, 3] = solid.opacity
    if not solid.edges:
        colours[:, :3] = np.clip(colours[:, :3] * shade(normals)[:, None], 0.0, 1.0)
    return colours


def draw_arrows(ax: Axes, kinds: Iterable[Arrows], view: View, time: int = 0) -> Drawn:
    """Draw the arrows of a time over all else, visible from every side; return the drawn artists."""
    how: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "units": "inches", "zorder": 4}
    drawn: Drawn = []
    for kind in kinds:
        tails, heads = view.project(kind.at(time))[..., :2].transpose(1, 2, 0)
        if heads.size:
            ways = (*heads, *(heads - tails))
            drawn.append(ax.quiver(*ways, color=kind.colour, pivot="tip", width=ARROW_WIDTH, **how))
    return drawn


def _fine(corners: np.ndarray) -> np.ndarray:
    """Return triangles (m, 3, 4), corners and values, with large ones split in four until they are small."""
    done: list[np.ndarray] = []
    while len(corners):
        edges = np.linalg.norm((corners - np.roll(corners, -1, axis=1))[..., :3], axis=2)
        small = edges.max(axis=1) <= FINEST
        done.append(corners[small])
        a, b, c = corners[~small].transpose(1, 0, 2)
        ab = 0.5 * (a + b)
        bc = 0.5 * (b + c)
        ca = 0.5 * (c + a)
        quarters = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        corners = np.concatenate([np.stack(quarter, axis=1) for quarter in quarters])
    return np.concatenate(done)


def windows(history: History) -> tuple[Window, Window]:
    """Return windows of a run for all times, m: x and y from above, x and z from the side."""
    x, y, (bottom, top) = track.shown_box(history, MARGIN)
    return (*x, *y), (*x, bottom, top + (ABOVE if history.has("side_frame_position") else 0.0))


def ground_section(history: History, at_rest: bool = False) -> Solid:
    """Return the ground cut along the middle line of the track, as it is or at rest with free springs."""
    y = float(gear.poses(history.dataset)[0][0, :, 1].mean())
    terrain = history.case.terrain
    if isinstance(terrain, CellTerrain):
        return track.cell_section(history.dataset, y, 2.0 * MARGIN[2], at_rest)
    row = int(np.clip((y - terrain.origin[1]) // terrain.unit_width, 0, terrain.rows - 1))
    units = np.arange(terrain.columns) * terrain.rows + row
    half = 0.5 * terrain.unit_length
    deep = 2.0 * MARGIN[2] + float(np.ptp(terrain.top_heights))
    points = np.array([[-half, 0.0, -deep], [half, 0.0, -deep], [half, 0.0, 0.0], [-half, 0.0, 0.0]])
    middle = np.full(len(units), y)
    origin = np.column_stack((terrain.middles[units, 0], middle, terrain.top_heights[units]))[None]
    lift = None if at_rest else history.unit_heave.transpose("time", "unit").values[:, units]
    pitching = terrain.tilt == "pitch" and not at_rest
    turn = track.unit_turns(terrain, history.unit_tilt if pitching else None)[:, units]
    faces = (np.array([[0, 1, 2, 3]]),)
    return Solid("units", points, faces, style.GROUND, origin, turn, edges=style.GROUND_EDGE, lift=lift)


def side_scene(now: History, scale: float = 1.0, force_scale: float = 0.0) -> Scene:
    """Return an instant from the right, ground displacements times `scale`; 1 N is `force_scale` m long."""
    moved, still = (ground_section(now, at_rest).at() for at_rest in (False, True))
    tops = np.array([3, 2]) + 4 * np.arange(len(moved.points) // 4)[:, None]
    x = moved.points[tops, 0]
    rise = moved.points[tops, 2] - still.points[tops, 2]
    larger = (scale - 1.0) * (rise - track.unloaded_level(now.case))
    moved.points[tops, 2] += larger

    def beneath(points: np.ndarray) -> np.ndarray:
        return np.interp(points[..., 0], x.ravel(), larger.ravel())

    scene = track.track_scene(now, force_scale)
    solids = [moved]
    for solid in (*scene.solids, link_pins(now)):
        if solid.name.endswith("shoes"):
            shoes = solid.at()
            solids.append(replace(shoes, points=shoes.points + upward(beneath(shoes.points))))
        elif solid.name != "ground":
            solids.append(replace(solid, lift=beneath(solid.origin)).at())
    arrows = [replace(arrow, heads=arrow.heads + upward(beneath(arrow.heads))) for arrow in scene.arrows]
    return Scene(scene.titles, tuple(solids), tuple(arrows))


def link_pins(history: History) -> Solid:
    """Return the pins at both ends of every shoe."""
    case = history.case
    pins = np.array([case.track.rear_pin, case.track.front_pin]) * [1.0, 0.0, 1.0]
    shape = disc(PIN, case.shoe.width + 0.01, PIN_SIDES)
    placed = carried(*gear.poses(history.dataset), pins)
    return Solid("link pins", *shape, "white", *placed, edges=style.SHOE_EDGE)


def draw_side(
    ax: Axes, now: History, scale: float = 1.0, force_scale: float = 0.0, opacity: float = 0.75
) -> Drawn:
    """Draw `side_scene` in axes that keep their limits; return the artists. `opacity` is that of shoes."""
    scene = side_scene(now, scale, force_scale)
    shown = [
        replace(solid, opacity=opacity) if solid.name.endswith("shoes") else solid for solid in scene.solids
    ]
    return [paint(ax, shown, FROM_THE_RIGHT), *draw_arrows(ax, scene.arrows, FROM_THE_RIGHT)]


def draw_plan(ax: Axes, now: History, heave: tuple[float, float]) -> Drawn:
    """Draw `plan_solids` with the numbers of the shoes; return the artists."""
    drawn: Drawn = [paint(ax, plan_solids(now, heave), FROM_ABOVE)]
    places = gear.poses(now.dataset)[0][0]
    # the lower run of a closed track is hidden
    lowest = places[:, 2].mean() if now.case.gear.loops else -np.inf
    for shoe, (x, y, z) in zip(now.shoe.values, places, strict=True):
        if z < lowest:
            continue
        drawn.append(ax.text(x, y, str(shoe), ha="center", va="center", fontsize=7, zorder=5, clip_on=True))
    return drawn


def plan_solids(now: History, heave: tuple[float, float]) -> list[Solid]:
    """Return shoes and rollers at an instant from above; `heave` (mm) limits the ground's colours."""
    shown = []
    for shape in (solid.at() for solid in track.track_scene(now, 0.0).solids):
        if shape.name == "ground":
            colouring = replace(shape.colourings[0], low=heave[0], high=heave[1])
            shape = replace(shape, opacity=1.0, colourings=(colouring,))
        elif shape.name.endswith("shoes"):
            shape = replace(shape, colour="white", opacity=0.35, edges="black")
        shown.append(shape)
    return shown


def ground_figure(history: History, time: float) -> Figure:
    """Draw the side view of a run at a time (s), and below it the contact force under every shoe."""
    case = history.case
    now = track.instants(history, [time])
    left, right, _, top = windows(now)[1]
    bottom = min(0.0, float(case.part(Terrain).top_heights.min())) - DEPTH
    # height of the side view at full width, so that both panels have the same width
    high = 10.5 * (top - bottom) / (right - left)
    with mpl.rc_context(style.STYLE):
        figure = Figure(figsize=(11.0, high + 3.2))
        side, carried = figure.subplots(2, 1, sharex=True, height_ratios=[high, 2.2])
        side.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", ylabel="z in m")
        side.grid(False)
        draw_side(side, now)
        side.set_title(f"{case.name}, t = {float(now.time[0]):.3g} s", parse_math=False)
        named = (("ground", style.GROUND), ("shoes", style.SHOE), ("link pins", "white"))
        keys = [mpl.patches.Patch(fc=colour, ec=style.SHOE_EDGE, label=name) for name, colour in named]
        side.legend(handles=keys, ncols=3, loc="upper left", fontsize="small")
        x = now.position.sel(axis="x").isel(time=0)
        force = now.over_time(["contact_force"])["contact_force"].sel(axis="z").isel(time=0) / style.KILO
        carried.bar(x, force, width=0.8 * case.shoe.length, color=style.SHOE)
        how: dict[str, Any] = {"xytext": (0, 3), "textcoords": "offset points", "ha": "center"}
        for place, number in zip(x.values, x["shoe"].values, strict=True):
            carried.annotate(str(number), (place, 0.0), **how)
        mean = statics.mean_load(case) / style.KILO
        carried.axhline(mean, color="k", ls="--", lw=0.8, label="mean load and weight")
        carried.set_ylim(top=1.25 * max(float(force.max()), mean))
        carried.legend(loc="upper left", fontsize="small")
        carried.set(xlabel="x in m; numbers are those of the shoes", ylabel="z contact force\nin kN")
    return figure


def map_figure(history: History, ground: xr.Dataset, time: float | None = None) -> Figure:
    """Draw the ground of cells from above (mm), see `ground_map`, with the outlines of the shoes.

    At the end of the run the map shows the greatest sinkage. At another time of the map (s) it shows the
    greatest sinkage until then or, if the run has not kept it, the greatest depth below shoes so far.
    """
    case = history.case
    shown = history.duration if time is None else time
    end = history.dataset.sel(time=shown, method="nearest")
    x0, x1, y0, y1, z0 = case.shoe.footprint
    corners = np.array([[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0]])
    outlines = [track.shoe_pose(end, shoe).place(corners)[:, :2] for shoe in end.shoe.values]
    half = 0.5 * case.part(CellTerrain).cell
    sinkage = ground.sinkage.values
    rut = ground.rut.values
    label = "greatest sinkage in mm"
    if time is not None:
        then = ground.sel(time=time, method="nearest")
        sinkage = then.sinkage_then.values
        rut = then.rut_then.values
        label = f"{label} until then"
        if np.isnan(sinkage).any():
            sinkage = then.depth.values
            rut = None
            label = "greatest depth so far in mm"
    (left, right), (low, high) = (
        (middles[0] - half, middles[-1] + half) for middles in (ground.x.values, ground.y.values)
    )
    shape = (high - low + 1.0) / (right - left + 1.0)
    with mpl.rc_context(style.STYLE):
        figure = Figure(figsize=(11.0, float(np.clip(10.0 * shape, 1.6, 9.0)) + 1.0))
        ax = figure.subplots()
        how: dict[str, Any] = {"extent": (left, right, low, high), "origin": "lower", "vmin": 0.0}
        image = ax.imshow(sinkage.T / style.MILLI, cmap=style.SINKAGE_MAP, **how)
        lines: dict[str, Any] = {"facecolors": "none", "edgecolors": style.SHOE_EDGE, "linewidths": 0.6}
        ax.add_collection(mpl.collections.PolyCollection(outlines, **lines))
        for number, outline in zip(end.shoe.values, outlines, strict=True):
            x, y = outline.mean(axis=0)
            ax.text(x, y, str(number), ha="center", va="center", fontsize=6.5, clip_on=True)
        ax.autoscale_view()
        ax.grid(False)
        ax.set(xlabel="x in m; numbers are those of the shoes", ylabel="y in m", aspect="equal")
        ax.set_title(f"{case.name}: ground at t = {shown:.3g} s", loc="left", parse_math=False)
        if rut is not None:
            stays = f"where nothing presses, ruts of at most {rut.max() / style.MILLI:.3g} mm stay"
            ax.set_title(stays, loc="right", fontsize=8)
        figure.colorbar(image, ax=ax, label=label, fraction=0.025, pad=0.01, shrink=0.75)
    return figure


def pressure_figure(history: History) -> Figure:
    """Draw the ground pressure below every shoe from above: at the start, and at its greatest."""
    case = history.case
    pressure = history.ground_pressure.transpose("time", "shoe")
    greatest = int(pressure.max("shoe").argmax("time"))
    x0, x1, y0, y1, z0 = case.shoe.footprint
    corners = np.array([[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0]])
    scale = style.scale_of(0.0, float(pressure.max()) / style.KILO or 1.0, style.SINKAGE_MAP)
    with style.titled_figure(f"{case.name}: ground pressure", 11.0, 7.0) as figure:
        panels = figure.subplots(2, 1, sharex=True, sharey=True)
        for ax, row, words in zip(panels, (0, greatest), ("start", "greatest"), strict=True):
            now = history.dataset.isel(time=row)
            below = pressure.values[row] / style.KILO
            mean = float(history.mean_ground_pressure[row]) / style.KILO
            on_ground = now.shoe.values[below > 0.0]
            outlines = [track.shoe_pose(now, shoe).place(corners)[:, :2] for shoe in on_ground]
            colours = scale.to_rgba(below[below > 0.0])
            edges: dict[str, Any] = {"edgecolors": style.SHOE_EDGE, "linewidths": 0.6}
            ax.add_collection(mpl.collections.PolyCollection(outlines, facecolors=colours, **edges))
            for outline, number in zip(outlines, on_ground, strict=True):
                x, y = outline.mean(axis=0)
                ax.text(x, y, str(number), ha="center", va="center", fontsize=6.5, clip_on=True)
            ax.autoscale_view()
            ax.grid(False)
            ax.set(ylabel="y in m", aspect="equal")
            # on two lines, since a short track is narrow
            most = f"{below.max():.4g} kPa at most,\n{mean:.4g} on the mean of the loaded shoes"
            ax.set_title(f"{words}, t = {float(now.time):.3g} s: {most}", loc="left", fontsize=8)
        panels[-1].set_xlabel("x in m; numbers are those of the shoes")
        figure.colorbar(scale, ax=panels, label="ground pressure in kPa", fraction=0.025, pad=0.01)
    return figure
