"""Whole track at instants of a history: poses of its parts, forces on shoes, and solids.

Shoes are boxes, units of the ground boxes or faces. Cells are a surface of heights, lowered below former
positions of shoes. Side frame, wheels and tumbler are in `gear`. `history` holds some instants, see
`instants`; `dataset` is that of `history`, and `now` that of one instant without the dimension time.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import xarray as xr

from exudyn_crawler.case import Case, CellTerrain, Terrain
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history import History, ground_map
from exudyn_crawler.results.history.catalogue import QUANTITIES
from exudyn_crawler.results.loads.actions import treads
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import gear
from exudyn_crawler.views.scenes.scene import FLAT, Arrows, Colouring, Placement, Scene, Solid, box, upward

BESIDE = (0.6, 0.4)  # m of cells drawn beyond the track and beside it
SPACING, MOST_POINTS = 0.25, 4000
"""Least distance (m) between points of a surface of cells; greatest number of points."""


def instants(history: History, times: np.typing.ArrayLike) -> History:
    """Return a history at its stored times nearest to given ones (s), each once.

    On ground of cells it also has the ground's height and its depth below that height, m.
    """
    rows = np.unique(history.dataset.get_index("time").get_indexer(np.asarray(times), method="nearest"))
    now = history.dataset.isel(time=rows).load()
    terrain = history.case.terrain
    if isinstance(terrain, CellTerrain):
        x, y, height = cell_grid(terrain, *around(history, BESIDE))
        depth = ground_map.pressed_depths(history, rows, x, y, height)
        now = now.assign_coords(ground_x=x, ground_y=y).assign(
            ground_height=(("ground_x", "ground_y"), height),
            ground_depth=(("time", "ground_x", "ground_y"), depth),
        )
    return History(history.case, now)


def shoe_pose(now: xr.Dataset, shoe: int) -> Placement:
    """Return the pose of one shoe."""
    chosen = now.sel(shoe=shoe)
    return Placement(chosen.position.values, rotation_matrices(chosen.angles.values))


def single_forces(dataset: xr.Dataset) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return all forces on shoes by kind: contacts with the ground, treads, wheels and teeth.

    Each kind has points (times, n, 3), m, forces there, N, global, zero without contact, and the numbers of
    the shoes (n,) or (times, n).
    """

    def values(name: str) -> np.ndarray:
        return dataset[name].transpose(*QUANTITIES[name].dimensions).values

    meets = values("area")[..., None] > 0.0
    forces = values("normal_force") + values("friction_force")
    points = values("point")
    shoes = dataset.contact_shoe.values
    by_kind = {"contacts": (np.where(meets, points, 0.0), np.where(meets, forces, 0.0), shoes)}
    if "tread_force" in dataset:
        on = treads(dataset)
        times, _, *strips, _ = on.force.shape
        shoes = np.repeat(on.shoe, np.prod(strips), axis=1)
        by_kind["treads"] = on.foot.reshape(times, -1, 3), on.force.reshape(times, -1, 3), shoes
    if "wheel_load" in dataset:
        for name, _, places, forces in gear.gear_forces(dataset):
            by_kind[name] = places, forces, dataset.shoe.values
    return by_kind


def forces_on(dataset: xr.Dataset, shoe: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (times, n, 3), m, and forces, N, that ever act on a shoe; NaN while they do not."""
    parts = []
    for places, forces, shoes in single_forces(dataset).values():
        acts = (shoes == shoe) & forces.any(axis=-1)
        parts.append(np.where(acts[..., None], (places, forces), np.nan)[:, :, acts.any(axis=0)])
    places, forces = np.concatenate(parts, axis=2)
    return places, forces


def shoe_forces(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return centres of pressure (times, shoes, 3), m, NaN without contact, and forces on the shoes, N."""
    points, forces, shoes = single_forces(dataset)["contacts"]
    return _resultants(points, forces, forces[..., 2], dataset.shoe.values[:, None] == shoes)


def roller_forces(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return centres (times, rollers, 3), m, of each roller's forces on shoes, and their resultants, N."""
    points, forces, _ = single_forces(dataset)["treads"]
    rollers = np.arange(dataset.sizes["roller"])
    mask = rollers[:, None] == np.repeat(rollers, points.shape[1] // len(rollers))
    return _resultants(points, forces, np.linalg.norm(forces, axis=-1), mask)


def _resultants(
    points: np.ndarray, forces: np.ndarray, weights: np.ndarray, members: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return weighted centres of points (times, n, 3), sums of forces (times, groups, 3).

    `members` (groups, n) is True for the points of a group.
    """
    moments = np.einsum("gn,tn,tna->tga", members, weights, points, optimize=True)
    total = np.einsum("gn,tn->tg", members, weights)[..., None]
    centers = np.divide(moments, total, out=np.full(moments.shape, np.nan), where=total > 0.0)
    return centers, np.einsum("gn,tna->tga", members, forces)


def greatest_shoe_force(history: History) -> float:
    """Return the greatest force (N) of ground, wheels or teeth on a shoe over the run."""
    names = [name for name in ("contact_force", "wheel_load", "tooth_force") if history.has(name)]
    values = (force for part, _ in history.parts() for force in part.over_time(names).values())
    return max(float(np.sqrt((force**2).sum("axis")).max()) for force in values)


def unloaded_level(case: Case) -> float:
    """Return the heave (m) of units under their own weight alone; 0 for cells."""
    if isinstance(case.terrain, CellTerrain):
        return 0.0
    return case.part(Terrain).unit_mass * case.gravity_vector()[2] / case.part(Terrain).heave_stiffness


def track_scene(history: History, force_scale: float, units: np.ndarray | None = None) -> Scene:
    """Return shoes, ground (`units` by index, or all), gear and forces; 1 N is `force_scale` m long."""
    case = history.case
    dataset = history.dataset
    tall = case.shoe.load_point[2] - case.shoe.footprint[4]
    on_shoes = shoe_forces(dataset)
    arrows = [Arrows("contact forces", style.CONTACT_FORCE, *on_shoes, force_scale, through=tall)]
    solids = [*shoe_boxes(history), ground_faces(history, units), *gear.gear_solids(history)]
    if history.has("wheel_load"):
        arrows += [Arrows(*gear_force, force_scale) for gear_force in gear.gear_forces(dataset)]
    if history.has("roller_force"):
        on_rails = roller_forces(dataset)
        arrows.append(Arrows("forces of rollers", style.ROLLER_FORCE, *on_rails, force_scale))
    titles = tuple(f"t = {time:.2f} s" for time in dataset.time.values)
    return Scene(titles, tuple(solids), tuple(arrows))


def shoe_boxes(history: History) -> list[Solid]:
    """Return rigid shoes and flexible shoes as boxes, each kind if there is any."""
    case = history.case
    numbers = history.shoe.values
    x0, x1, y0, y1, z0 = case.shoe.footprint
    shape = box((x0, y0, z0), (x1, y1, case.shoe.load_point[2]))
    origin, turn = gear.poses(history.dataset)
    flexible = np.isin(numbers, () if case.flexible is None else case.flexible.shoes)
    kinds = (("rigid shoes", ~flexible, style.SHOE), ("flexible shoes", flexible, style.FLEXIBLE_SHOE))
    solids = []
    for name, chosen, colour in kinds:
        labels = tuple(f"shoe {shoe}" for shoe in numbers[chosen])
        placed = origin[:, chosen], turn[:, chosen]
        solids.append(Solid(name, *shape, colour, *placed, edges=style.SHOE_EDGE, labels=labels))
    return [solid for solid in solids if solid.labels]


def ground_units(history: History) -> Solid:
    """Return the units of the ground as boxes."""
    terrain = history.case.part(Terrain)
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width, terrain.unit_height])
    lift = history.unit_heave.transpose("time", "unit").values
    placed = terrain.centers[None], unit_turns(terrain, history.unit_tilt)
    return Solid("ground", *box(-half, half), style.GROUND, *placed, lift=lift)


def ground_faces(history: History, units: np.ndarray | None = None) -> Solid:
    """Return top faces of units, coloured by heave in mm, without their tilt in the run; or cells."""
    terrain = history.case.terrain
    if isinstance(terrain, CellTerrain):
        return cell_surface(history.dataset)
    chosen = np.arange(terrain.unit_count) if units is None else units
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width, 0.0])
    points = half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    tops = np.column_stack((terrain.middles, terrain.top_heights))
    placed = tops[None, chosen], unit_turns(terrain)[:, chosen]
    lift = history.unit_heave.transpose("time", "unit").values[:, chosen]
    heave = lift / style.MILLI
    colouring = Colouring("ground displacement in mm", heave, heave.min(), heave.max(), style.HEAVE_MAP)
    faces = (np.array([[0, 1, 2, 3]]),)
    how = (0.6, style.GROUND_EDGE)
    return Solid("ground", points, faces, style.GROUND, *placed, *how, lift=lift, colourings=(colouring,))


def unit_turns(terrain: Terrain, unit_tilt: xr.DataArray | None = None) -> np.ndarray:
    """Return the axes of the units, (times, units, 3, 3), with further tilts (rad) or with free springs."""
    tilt = terrain.tilts[None]
    if unit_tilt is not None:
        tilt = tilt + unit_tilt.transpose("time", "unit").values
    return rotation_matrices(tilt[..., None] * np.eye(3)[terrain.tilt_axis])


@lru_cache(maxsize=4)
def cell_grid(terrain: CellTerrain, x: tuple[float, float], y: tuple[float, float]) -> tuple[np.ndarray, ...]:
    """Return evenly spaced x and y (m) within bounds, and heights (x, y); unmeasured ones are the least."""
    ends = [(max(a, low), min(b, high)) for (a, b), (low, high) in zip((x, y), terrain.bounds, strict=True)]
    spacing = max(SPACING, float(np.sqrt(np.prod(np.diff(ends)) / MOST_POINTS)))
    places = [np.linspace(a, b, max(2, int(np.ceil((b - a) / spacing)) + 1)) for a, b in ends]
    height = terrain.surface(*np.meshgrid(*places, indexing="ij"))
    return *places, np.nan_to_num(height, nan=np.nanmin(height))


def cell_surface(dataset: xr.Dataset) -> Solid:
    """Return the ground of cells as a surface, coloured by its height in mm."""
    x, y = dataset.ground_x.values, dataset.ground_y.values
    height = dataset.ground_height.transpose("ground_x", "ground_y").values
    depth = dataset.ground_depth.transpose("time", "ground_x", "ground_y").values
    depth = depth.reshape(len(depth), -1)
    places = np.meshgrid(x, y, indexing="ij")
    points = np.column_stack([grid.ravel() for grid in (*places, height)])
    number = np.arange(height.size).reshape(height.shape)
    faces = np.stack((number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]), axis=-1)
    now = (points[:, 2] - depth) / style.MILLI
    colouring = Colouring("height of the ground in mm", now[:, None], now.min(), now.max(), style.HEAVE_MAP)
    shape = points, (faces.reshape(-1, 4),)
    flat = Solid("ground", *shape, style.GROUND, opacity=0.6, edges=FLAT, colourings=(colouring,))
    return replace(flat, bend=upward(-depth[:, None]))


def cell_section(dataset: xr.Dataset, y: float, deep: float, at_rest: bool = False) -> Solid:
    """Return the ground cut at one y (m), at an instant or before any shoe, down to `deep` (m)."""
    line = dataset.isel(time=0).sel(ground_y=y, method="nearest")
    x = line.ground_x.values
    top = line.ground_height.values - (0.0 if at_rest else line.ground_depth.values)
    bottom = line.ground_height.values - deep
    ends = np.stack((x[:-1], x[1:], x[1:], x[:-1]), axis=1)
    heights = np.stack((bottom[:-1], bottom[1:], top[1:], top[:-1]), axis=1)
    points = np.stack((ends, np.full_like(ends, y), heights), axis=-1)
    faces = (np.arange(ends.size).reshape(-1, 4),)
    return Solid("ground", points.reshape(-1, 3), faces, style.GROUND, edges=style.GROUND)


def shown_box(history: History, margin: tuple[float, ...]) -> list[tuple[float, float]]:
    """Return least and greatest x, y and z (m) of a run's view; margins (m) beyond, beside and below."""
    shoe = history.case.shoe
    terrain = history.case.terrain
    length, beside = around(history, margin)
    if isinstance(terrain, CellTerrain):
        tops = cell_grid(terrain, length, beside)[2]
    else:
        near = np.abs(terrain.middles[:, 0] - np.mean(length)) < 0.5 * (np.ptp(length) + terrain.unit_length)
        tops = terrain.top_heights[near]
    top = float(tops.max(initial=0.0)) + 2.0 * (shoe.com_height + shoe.load_point[2])
    # the upper run of a closed track
    top = max(top, float(history.position.sel(axis="z").max()) - shoe.footprint[4])
    if history.has("side_frame_position"):
        top = max(top, float(gear.frame_poses(history)[0][..., 2].max()) + gear.beam_ends(history.case)[1])
    return [length, beside, (float(tops.min(initial=0.0)) - margin[2], top)]


def around(history: History, margin: tuple[float, ...]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return least and greatest x and y (m) of all shoes in a run, with margins (m) beyond and beside."""
    shoe = history.case.shoe
    (x, y) = (history.position.sel(axis=axis) for axis in "xy")
    low, high = shoe.footprint[:2]
    sideways = 0.5 * shoe.width + margin[1]
    length = float(x.min()) + low - margin[0], float(x.max()) + high + margin[0]
    return length, (float(y.min()) - sideways, float(y.max()) + sideways)
