"""A whole track in instants of a history: where its parts are, what presses on them, and their solids.

Shoes are boxes, units of the ground boxes or faces; side frame and rollers come with a rolled run. `now` is
one instant without the dimension time, `dataset` some of them, as of `instants`.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from exudyn_crawler.case import Case, CellTerrain, Rails, Undercarriage
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import cell_ground
from exudyn_crawler.views.scenes.scene import Arrows, Colouring, Placement, Scene, Solid, box, disc

CONTACTS = ("contact", "axis")
STRIPS = ("roller", "rail", "strip", "neighbour", "axis")
"""Dimensions of what the ground and what treads press with."""
BEAM = (0.05, 0.85)
"""m above the rollers' axes that the drawn beam of the side frame reaches from and to: its parameters say how
long it is, not how high and wide."""
GAP = 0.03
"""m between the beam and the treads beside it."""
BESIDE = (0.6, 0.4)
"""m beyond the track and beside it of which ground of cells is drawn."""
PIN, PIN_SIDES, MARK = 0.03, 12, 0.012
"""m, radius of a drawn link pin; sides of its prism; m, width of the line that shows how far rollers roll."""


def instants(history: History, times: ArrayLike) -> xr.Dataset:
    """States of a history at the stored times nearest to some (s), each once; ground of cells with them."""
    rows = np.unique(history.dataset.get_index("time").get_indexer(np.asarray(times), method="nearest"))
    now, terrain = history.dataset.isel(time=rows).load(), history.case.terrain
    if not isinstance(terrain, CellTerrain):
        return now
    return cell_ground.with_ground(
        history, now, rows, cell_ground.grid_of(terrain, *_around(history, BESIDE))
    )


def shoe_poses(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Origins (times, shoes, 3), m, and turns (times, shoes, 3, 3) of all shoes."""
    names = ("position", "angles")
    origin, angles = (dataset[name].transpose("time", "shoe", "axis").values for name in names)
    return origin, rotation_matrices(angles)


def shoe_pose(now: xr.Dataset, shoe: int) -> Placement:
    """Place of one shoe."""
    chosen = now.sel(shoe=shoe)
    return Placement(chosen.position.values, rotation_matrices(chosen.angles.values))


def frame_poses(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Origins (times, 3), m, and turns (times, 3, 3) of the side frame."""
    return dataset.side_frame_position.values, rotation_matrices(dataset.side_frame_angles.values)


def rolls(dataset: xr.Dataset) -> bool:
    """Whether a side frame rolls over the track of a history."""
    return "roller_force" in dataset


def touching(now: xr.Dataset, shoe: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Places (contacts, 3), m, where the ground touches one shoe or all, and its forces on the shoe there, N.

    Both are global; pairs that are apart are left out.
    """
    meets = now.area.values > 0.0
    if shoe is not None:
        meets &= now.contact_shoe.values == shoe
    forces = (now.normal_force + now.friction_force).transpose(*CONTACTS).values
    return now.point.transpose(*CONTACTS).values[meets], forces[meets]


def pressing(now: xr.Dataset, shoe: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Strips of treads that press on one shoe, or on all, as of `touching`."""
    forces, points = (now[name].transpose(*STRIPS).values for name in ("tread_force", "tread_foot"))
    meets = forces.any(axis=-1)
    if shoe is not None:
        number = now.roller_shoe.values[:, None] + np.arange(forces.shape[3])
        meets &= (number == shoe)[:, None, None, :]
    return points[meets], forces[meets]


def acting(now: xr.Dataset, shoe: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Contacts with the ground of one shoe or of all, and the treads that press there, as of `touching`."""
    if not rolls(now):
        return touching(now, shoe)
    points, forces = zip(touching(now, shoe), pressing(now, shoe), strict=True)
    return np.concatenate(points), np.concatenate(forces)


def shoe_forces(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Centres of pressure (times, shoes, 3), m, not a number without contact, and forces on the shoes, N."""
    meets = dataset.area.transpose("time", "contact").values[..., None] > 0.0
    total = (dataset.normal_force + dataset.friction_force, dataset.point)
    forces, points = (np.where(meets, one.transpose("time", *CONTACTS).values, 0.0) for one in total)
    own = dataset.shoe.values[:, None] == dataset.contact_shoe.values
    moments = np.einsum("sc,tc,tca->tsa", own, forces[..., 2], points, optimize=True)
    pressed = np.einsum("sc,tc->ts", own, forces[..., 2])
    return _centers(moments, pressed), np.einsum("sc,tca->tsa", own, forces)


def roller_forces(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Same of the rollers (times, rollers, 3): centres of what each presses on, and its force there."""
    names = ("tread_force", "tread_foot")
    forces, points = (dataset[name].transpose("time", *STRIPS).values for name in names)
    size = np.linalg.norm(forces, axis=-1)
    moments = np.einsum("trabn,trabnk->trk", size, points)
    return _centers(moments, size.sum(axis=(2, 3, 4))), forces.sum(axis=(2, 3, 4))


def _centers(moments: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Moments (..., 3) over weights (...), not a number where there is no weight."""
    centers = np.full(moments.shape, np.nan)
    return np.divide(moments, weights[..., None], out=centers, where=weights[..., None] > 0.0)


def greatest_shoe_force(history: History) -> float:
    """Greatest contact force on a shoe over the run, N."""
    total = history.over_time(["contact_force"])["contact_force"]
    return float(np.sqrt((total**2).sum("axis")).max())


def unloaded_level(case: Case) -> float:
    """Heave of units that carry nothing but themselves, m; cells stay where they are."""
    if isinstance(case.terrain, CellTerrain):
        return 0.0
    return case.unit_terrain().unit_mass * case.gravity_vector()[2] / case.unit_terrain().heave_stiffness


def track_scene(
    case: Case, dataset: xr.Dataset, force_scale: float, units: np.ndarray | None = None
) -> Scene:
    """Shoes, faces of the ground, side frame and rollers, and forces, drawn `force_scale` m long for 1 N.

    `units` are the indices of the units that are shown; all if not given.
    """
    tall, on_shoes = case.shoe.load_point[2] - case.shoe.footprint[4], shoe_forces(dataset)
    arrows = [Arrows("contact forces", style.CONTACT_FORCE, *on_shoes, force_scale, through=tall)]
    solids = [*shoe_boxes(case, dataset), ground_faces(case, dataset, units)]
    if rolls(dataset):
        solids += [beam(case, dataset), *rollers(case, dataset)]
        on_rails = roller_forces(dataset)
        arrows.append(Arrows("forces of rollers", style.ROLLER_FORCE, *on_rails, force_scale))
    titles = tuple(f"t = {time:.2f} s" for time in dataset.time.values)
    return Scene(titles, tuple(solids), tuple(arrows))


def shoe_boxes(case: Case, dataset: xr.Dataset) -> list[Solid]:
    """Rigid shoes and flexible shoes, as far as there are any, as boxes."""
    x0, x1, y0, y1, z0 = case.shoe.footprint
    shape = box(np.array([x0, y0, z0]), np.array([x1, y1, case.shoe.load_point[2]]))
    origin, turn = shoe_poses(dataset)
    flexible = np.isin(dataset.shoe.values, () if case.flexible is None else case.flexible.shoes)
    kinds = (("rigid shoes", ~flexible, style.SHOE), ("flexible shoes", flexible, style.FLEXIBLE_SHOE))
    solids = []
    for name, chosen, colour in kinds:
        labels = tuple(f"shoe {shoe}" for shoe in dataset.shoe.values[chosen])
        placed = origin[:, chosen], turn[:, chosen]
        solids.append(Solid(name, *shape, colour, *placed, edges=style.SHOE_EDGE, labels=labels))
    return [one for one in solids if one.labels]


def link_pins(case: Case, dataset: xr.Dataset) -> Solid:
    """Pins at both ends of every shoe."""
    origin, turn = shoe_poses(dataset)
    pins = np.array([case.track.rear_pin, case.track.front_pin]) * [1.0, 0.0, 1.0]
    points = origin[:, :, None] + np.einsum("tsij,pj->tspi", turn, pins)
    placed = points.reshape(len(origin), -1, 3), np.repeat(turn, len(pins), axis=1)
    shape = disc(PIN, case.shoe.width + 0.01, PIN_SIDES)
    return Solid("link pins", *shape, "white", *placed, edges=style.SHOE_EDGE)


def ground_units(case: Case, dataset: xr.Dataset) -> Solid:
    """Units of the ground as boxes."""
    terrain = case.unit_terrain()
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width, terrain.unit_height])
    lift = dataset.unit_heave.transpose("time", "unit").values
    placed = terrain.centers[None], unit_turns(case, dataset)
    return Solid("ground", *box(-half, half), style.GROUND, *placed, lift=lift)


def ground_faces(case: Case, dataset: xr.Dataset, units: np.ndarray | None = None) -> Solid:
    """Top faces of units, coloured by their heave in mm, without what they tilt in a run; or of cells."""
    if isinstance(case.terrain, CellTerrain):
        return cell_ground.surface(dataset)
    terrain = case.unit_terrain()
    chosen = np.arange(terrain.unit_count) if units is None else units
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width, 0.0])
    points = half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    tops = np.column_stack((terrain.middles, terrain.top_heights))
    placed = tops[None, chosen], unit_turns(case)[:, chosen]
    lift = dataset.unit_heave.transpose("time", "unit").values[:, chosen]
    heave = lift / style.MILLI
    colouring = Colouring("heave of the ground in mm", heave, heave.min(), heave.max(), style.HEAVE_MAP)
    faces, how = (np.array([[0, 1, 2, 3]]),), (0.6, style.GROUND_EDGE)
    return Solid("ground", points, faces, style.GROUND, *placed, *how, lift=lift, colourings=(colouring,))


def unit_turns(case: Case, dataset: xr.Dataset | None = None) -> np.ndarray:
    """Turns of the units, (times, units, 3, 3), in some instants or with free springs."""
    tilt = case.unit_terrain().tilts[None]
    if dataset is not None:
        tilt = tilt + dataset.unit_tilt.transpose("time", "unit").values
    return rotation_matrices(tilt[..., None] * np.eye(3)[case.unit_terrain().tilt_axis])


def beam(case: Case, dataset: xr.Dataset) -> Solid:
    """Beam between the rails that stands for the side frame."""
    frame, rails = frame_on_rails(case)
    half = 0.5 * (float(np.ptp(rails.middles)) - frame.tread_width) - GAP
    (low, high), (origin, turn) = BEAM, frame_poses(dataset)
    shape = box(np.array([frame.ends[0], -half, low]), np.array([frame.ends[1], half, high]))
    placed = origin[:, None], turn[:, None]
    return Solid("side frame", *shape, style.BEAM, *placed, 0.5, style.ROLLER_EDGE)


def rollers(case: Case, dataset: xr.Dataset) -> list[Solid]:
    """Treads of all rollers, roller by roller and its right one first, and a line across each."""
    frame, rails = frame_on_rails(case)
    origin, turn = frame_poses(dataset)
    on_frame = np.array([(x, y, 0.0) for x in frame.rollers for y in rails.middles])
    centers = origin[:, None] + np.einsum("tij,nj->tni", turn, on_frame)
    # how far rollers have turned counts from upright, whatever the pitch of the frame
    axle = turn[..., 1]
    forward = np.cross(axle, [0.0, 0.0, 1.0])
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    level = np.stack((forward, axle, np.cross(forward, axle)), axis=-1)
    angle = (origin[:, :1] - frame.start) / frame.radius
    rolled = level @ rotation_matrices(angle * np.eye(3)[1])
    placed = centers, np.repeat(rolled[:, None], len(on_frame), axis=1)
    labels = tuple(f"roller {number}" for number in range(1, len(frame.rollers) + 1) for _ in rails.middles)
    half = np.array([0.5 * MARK, 0.5 * frame.tread_width + 0.002, frame.radius])
    tread, edge = disc(frame.radius, frame.tread_width), style.ROLLER_EDGE
    return [
        Solid("rollers", *tread, style.ROLLER, *placed, edges=edge, labels=labels),
        Solid("rollers, marks", *box(-half, half), edge, *placed),
    ]


def frame_on_rails(case: Case) -> tuple[Undercarriage, Rails]:
    """Undercarriage of a rolled case, and the rails that it rolls on."""
    frame, rails = case.undercarriage, case.shoe.rails
    if frame is None or rails is None:
        raise ValueError(f"the case {case.name!r} must have an undercarriage to show one")
    return frame, rails


def shown_box(history: History, margin: Sequence[float]) -> list[tuple[float, float]]:
    """Least and greatest x, y and z of what a run is shown in, m.

    `margin` are the m beyond both ends, beside the shoes and below the ground's lowest face.
    """
    shoe, terrain = history.case.shoe, history.case.terrain
    length, beside = _around(history, margin)
    if isinstance(terrain, CellTerrain):
        tops = cell_ground.grid_of(terrain, length, beside)[2]
    else:
        near = np.abs(terrain.middles[:, 0] - np.mean(length)) < 0.5 * (np.ptp(length) + terrain.unit_length)
        tops = terrain.top_heights[near]
    top = float(tops.max(initial=0.0)) + 2.0 * (shoe.com_height + shoe.load_point[2])
    if rolls(history.dataset):
        top = max(top, float(history.side_frame_position.sel(axis="z").max()) + BEAM[1])
    return [length, beside, (float(tops.min(initial=0.0)) - margin[2], top)]


def _around(history: History, margin: Sequence[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Least and greatest x and y of all shoes in a run, with m beyond both ends and beside them, m."""
    shoe, (x, y) = history.case.shoe, (history.position.sel(axis=axis) for axis in "xy")
    low, high = shoe.footprint[:2]
    sideways = 0.5 * shoe.width + margin[1]
    length = float(x.min()) + low - margin[0], float(x.max()) + high + margin[0]
    return length, (float(y.min()) - sideways, float(y.max()) + sideways)
