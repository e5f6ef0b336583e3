"""A whole track in space: shoes as boxes, units of the ground, side frame, rollers, forces on the shoes."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import poses
from exudyn_crawler.views.scenes.scene import BOX_FACES, Arrows, Colouring, Scene, Solid, box, disc

BEAM = (0.05, 0.85)
"""m above the rollers' axes that the drawn beam of the side frame reaches from and to: its parameters say how
long it is, not how high and wide."""
GAP = 0.03
"""m between the beam and the treads beside it."""
PIN, PIN_SIDES = 0.03, 12
"""m, radius of a drawn link pin; and sides of its prism."""
MARK = 0.012
"""m, width of the line across a roller that shows how far it has rolled."""


def track_scene(case: Case, dataset: xr.Dataset, force_scale: float, units: NDArray | None = None) -> Scene:
    """Shoes, faces of the ground, side frame and rollers in some instants of a history, and forces.

    Parameters
    ----------
    dataset : xarray.Dataset
        Instants of a history, as of `poses.instants`.
    force_scale : float
        m that are drawn for 1 N.
    units : int array, optional
        Indices of the units that are shown; all if not given.
    """
    tall, on_shoes = case.shoe.load_point[2] - case.shoe.footprint[4], poses.shoe_forces(dataset)
    arrows = [Arrows("contact forces", style.CONTACT_FORCE, *on_shoes, force_scale, through=tall)]
    solids = [*shoe_boxes(case, dataset), ground_faces(case, dataset, units)]
    if poses.rolls(dataset):
        solids += [side_frame(case, dataset), *rollers(case, dataset)]
        on_rails = poses.roller_forces(dataset)
        arrows.append(Arrows("forces of rollers", style.ROLLER_FORCE, *on_rails, force_scale))
    titles = tuple(f"t = {time:.2f} s" for time in dataset.time.values)
    return Scene(titles, tuple(solids), tuple(arrows))


def shoe_boxes(case: Case, dataset: xr.Dataset) -> list[Solid]:
    """Rigid shoes and flexible shoes, as far as there are any, as boxes."""
    x0, x1, y0, y1, z0 = case.shoe.footprint
    points = box(np.array([x0, y0, z0]), np.array([x1, y1, case.shoe.load_point[2]]))
    origin, turn = poses.shoe_poses(dataset)
    flexible = np.isin(dataset.shoe.values, () if case.flexible is None else case.flexible.shoes)
    kinds = (("rigid shoes", ~flexible, style.SHOE), ("flexible shoes", flexible, style.FLEXIBLE_SHOE))
    return [
        Solid(
            name,
            points,
            BOX_FACES,
            colour,
            origin[:, chosen],
            turn[:, chosen],
            edges=style.SHOE_EDGE,
            labels=tuple(f"shoe {shoe}" for shoe in dataset.shoe.values[chosen]),
        )
        for name, chosen, colour in kinds
        if chosen.any()
    ]


def link_pins(case: Case, dataset: xr.Dataset) -> Solid:
    """Pins at both ends of every shoe."""
    origin, turn = poses.shoe_poses(dataset)
    pins = np.array([case.track.rear_pin, case.track.front_pin]) * [1.0, 0.0, 1.0]
    points = origin[:, :, None] + np.einsum("tsij,pj->tspi", turn, pins)
    placed = points.reshape(len(origin), -1, 3), np.repeat(turn, len(pins), axis=1)
    shape = disc(PIN, case.shoe.width + 0.01, PIN_SIDES)
    return Solid("link pins", *shape, "white", *placed, edges=style.SHOE_EDGE)


def ground_units(case: Case, dataset: xr.Dataset) -> Solid:
    """Units of the ground as boxes, as high as their faces."""
    terrain = case.terrain
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width, terrain.unit_height])
    # with heights of their own, faces alone are raised
    bend = np.zeros((1, terrain.unit_count, 8, 3))
    if terrain.heights is not None:
        bend[0, :, 4:, 2] = terrain.top_heights[:, None]
    lift = dataset.unit_heave.transpose("time", "unit").values
    placed = terrain.centers[None], unit_turns(case, dataset)
    return Solid("ground", box(-half, half), BOX_FACES, style.GROUND, *placed, lift=lift, bend=bend)


def ground_faces(case: Case, dataset: xr.Dataset, units: NDArray | None = None) -> Solid:
    """Top faces of units, coloured by their heave in mm, without what they tilt in a run."""
    terrain = case.terrain
    chosen = np.arange(terrain.unit_count) if units is None else units
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width, 0.0])
    points = half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    heave = dataset.unit_heave.transpose("time", "unit").values[:, chosen]
    shown = heave / style.MILLI
    colouring = Colouring("heave of the ground in mm", shown, shown.min(), shown.max(), style.HEAVE_MAP)
    return Solid(
        "ground",
        points,
        (np.array([[0, 1, 2, 3]]),),
        style.GROUND,
        np.column_stack((terrain.middles, terrain.top_heights))[None, chosen],
        unit_turns(case)[:, chosen],
        opacity=0.6,
        edges=style.GROUND_EDGE,
        lift=heave,
        colourings=(colouring,),
    )


def unit_turns(case: Case, dataset: xr.Dataset | None = None) -> NDArray:
    """Turns of the units, (times, units, 3, 3), in some instants or with free springs."""
    tilt = case.terrain.tilts[None]
    if dataset is not None:
        tilt = tilt + dataset.unit_tilt.transpose("time", "unit").values
    return rotation_matrices(tilt[..., None] * np.eye(3)[case.terrain.tilt_axis])


def side_frame(case: Case, dataset: xr.Dataset) -> Solid:
    """Beam between the rails that stands for the side frame."""
    frame, middles = poses.frame_of(case)
    half = 0.5 * (max(middles) - min(middles) - frame.tread_width) - GAP
    (low, high), (origin, turn) = BEAM, poses.frame_poses(dataset)
    beam = box(np.array([frame.ends[0], -half, low]), np.array([frame.ends[1], half, high]))
    placed = origin[:, None], turn[:, None]
    return Solid("side frame", beam, BOX_FACES, style.SIDE_FRAME, *placed, 0.5, style.ROLLER_EDGE)


def rollers(case: Case, dataset: xr.Dataset) -> list[Solid]:
    """Treads of all rollers, roller by roller and its right one first, and a line across each."""
    frame, _ = poses.frame_of(case)
    centers = poses.tread_centers(dataset, case)
    # how far rollers have turned counts from upright, whatever the pitch of the frame
    axle = poses.frame_poses(dataset)[1][..., 1]
    forward = np.cross(axle, [0.0, 0.0, 1.0])
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    level = np.stack((forward, axle, np.cross(forward, axle)), axis=-1)
    rolled = level @ rotation_matrices(poses.rolled_angle(dataset, case)[:, None] * np.eye(3)[1])
    count = centers.shape[1] * centers.shape[2]
    placed = centers.reshape(-1, count, 3), np.repeat(rolled[:, None], count, axis=1)
    labels = tuple(f"roller {1 + k // centers.shape[2]}" for k in range(count))
    half = np.array([0.5 * MARK, 0.5 * frame.tread_width + 0.002, frame.radius])
    tread = disc(frame.radius, frame.tread_width)
    return [
        Solid("rollers", *tread, style.ROLLER, *placed, edges=style.ROLLER_EDGE, labels=labels),
        Solid("rollers, marks", box(-half, half), BOX_FACES, style.ROLLER_EDGE, *placed),
    ]


def shown_box(history: History, margin: Sequence[float]) -> list[list[float]]:
    """Least and greatest x, y and z of what a run is shown in, m.

    Parameters
    ----------
    margin : sequence of float (3)
        m beyond both ends, beside the shoes and below the ground's lowest face.
    """
    shoe, terrain = history.case.shoe, history.case.terrain
    x, y = (history.position.sel(axis=axis) for axis in "xy")
    low, high = shoe.footprint[:2]
    length = [float(x.min()) + low - margin[0], float(x.max()) + high + margin[0]]
    sideways = 0.5 * shoe.width + margin[1]
    near = np.abs(terrain.middles[:, 0] - np.mean(length)) < 0.5 * (np.ptp(length) + terrain.unit_length)
    tops = terrain.top_heights[near]
    top = float(tops.max(initial=0.0)) + 2.0 * (shoe.com_height + shoe.load_point[2])
    if poses.rolls(history.dataset):
        top = max(top, float(history.side_frame_position.sel(axis="z").max()) + BEAM[1])
    beside = [float(y.min()) - sideways, float(y.max()) + sideways]
    return [length, beside, [float(tops.min(initial=0.0)) - margin[2], top]]
