"""Machine at its start: the assembled bodies of a case, without a system, equilibrium or run."""

from dataclasses import replace

import numpy as np
import xarray as xr

from exudyn_crawler.case import SIDES, Case, CellTerrain, Closed, Terrain
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.results.history import History, catalogue
from exudyn_crawler.views.scenes import gear, pictures, track
from exudyn_crawler.views.scenes.scene import Solid

MARGIN = (2.0, 0.6)
"""Ground (m) drawn beyond the track and beside it."""
SECTION = "ground, cut"


def start_solids(case: Case) -> list[Solid]:
    """Return ground, its section, shoes, wheels and frames of a machine at its start, the right track first.

    Shoes have no sinkage, and a chain hangs as estimated for its assembly.
    """
    whole = with_ground(start_of(case))
    section = replace(pictures.ground_section(whole, at_rest=True), name=SECTION)
    solids = [section, _surface(whole), *track.shoe_boxes(whole)]
    if case.gear.tracks == 1:
        return [*solids, *gear.gear_solids(whole)]
    solids.append(gear.car_body(whole))
    for side in SIDES:
        of_side = gear.gear_solids(start_of(case.of_track(side)))
        solids += [replace(solid, name=f"{side} {solid.name}") for solid in of_side]
    return solids


def start_of(case: Case) -> History:
    """Return a history of the start alone, with the motion of the bodies but no forces."""
    shoes = case.gear.shoe_reference(case)
    values: dict[str, np.ndarray] = {"position": shoes[None, :, :3], "angles": shoes[None, :, 3:]}
    if case.gear.frame_parts:
        values["side_frame_position"] = case.part(RunningGear).frame_start(case)[None]
        values["side_frame_angles"] = np.zeros((1, 3))
    if case.gear.tracks == 1 and case.gear.tumblers:
        closed = case.part(Closed)
        values["tumbler_position"] = closed.tumbler_reference(case)[:, :3]
        values["tumbler_angle"] = np.zeros(1)
        values["take_up"] = np.array([closed.assembled(case).take_up])
    if case.gear.tracks == 1 and case.gear.frame_parts:
        frame = case.part(RunningGear)
        for name, bodies in (("bogie_angle", frame.bogies), ("arm_angle", frame.arms)):
            if bodies:
                values[name] = np.zeros((1, len(bodies)))
        if frame.arms:
            values["arm_angle"] += frame.arm_reference(case)[:, 4]
    if isinstance(case.terrain, Terrain):
        values["unit_heave"] = np.zeros((1, len(case.terrain.units)))
    variables = {name: catalogue.variable(name, value) for name, value in values.items()}
    coordinates = {"time": [0.0], "shoe": case.track.shoes, "axis": ["x", "y", "z"]}
    return History(case, xr.Dataset(variables, coordinates))


def with_ground(start: History) -> History:
    """Return a start with the heights of ground of cells around the track, without ruts."""
    terrain = start.case.terrain
    if not isinstance(terrain, CellTerrain):
        return start
    x, y, height = track.cell_grid(terrain, *track.around(start, MARGIN))
    dimensions = ("ground_x", "ground_y")
    level: dict[str, tuple[tuple[str, ...], np.ndarray]] = {"ground_height": (dimensions, height)}
    level["ground_depth"] = (("time", *dimensions), np.zeros((1, *height.shape)))
    return History(start.case, start.dataset.assign_coords(ground_x=x, ground_y=y).assign(level))


def _surface(start: History) -> Solid:
    """Return the surface of the ground around the track."""
    terrain = start.case.terrain
    if isinstance(terrain, CellTerrain):
        return track.cell_surface(start.dataset)
    places = terrain.middles
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
    low, high = np.array(track.around(start, MARGIN)).T
    near = ((places > low - half) & (places < high + half)).all(axis=1)
    return track.ground_faces(start, np.flatnonzero(near))
