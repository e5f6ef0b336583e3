"""Actions on a shoe in its axes: all of them at an instant, for other programs, and its pins over time."""

import itertools
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.files import whole_file
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads import actions, load_map
from exudyn_crawler.results.loads.kinds import Kind
from exudyn_crawler.results.loads.locations import Pin, Point
from fem import ElasticBody, Interface, Program, write_load_deck
from fem.body import interfaces


@dataclass(frozen=True)
class ShoeLoads:
    """Loads on the finite elements of a flexible shoe of n nodes and i joints, in the shoe's axes."""

    time: float  # s, stored instant
    shoe: int
    body: ElasticBody  # mesh and material
    interfaces: list[Interface]  # joints; their couplings hold the bores
    nodal: np.ndarray  # (n, 3), N: machine load, contacts, drive, weight and inertia
    centers: np.ndarray  # (i, 6), forces (N) and moments (N m) on the joint centres
    table: pd.DataFrame  # result of `action_table`

    def write(self, path: str | Path, program: Program = "calculix", overwrite: bool = False) -> Path:
        """Write mesh, joints and loads as a static step for CalculiX or Abaqus; raise as `whole_file`."""
        path = Path(path)
        remarks = [
            f"shoe {self.shoe} at t = {self.time:.6g} s; N, m, Pa; axes of the shoe, from its nominal COM",
            "loads, contacts, drive, joints, weight and inertia are in balance; the six held degrees of "
            "freedom have no reactions",
            *self.table.to_string(index=False, float_format="%.6g").splitlines(),
        ]
        acting = (self.body, self.interfaces, self.nodal, self.centers)
        with whole_file(path, overwrite) as temporary:
            write_load_deck(temporary, *acting, program=program, remarks=remarks)
        return path

    @property
    def residual(self) -> np.ndarray:
        """Sum of all forces (N) and moments about the centre of mass (N m): array (6,), zero in balance."""
        at_centers = interfaces.rigid_motion_of_centers(self.interfaces, self.body.center_of_mass)
        return self.body.rigid_modes.T @ self.nodal.ravel() + at_centers.T @ self.centers.ravel()


def at_instant(history: History, time: float) -> History:
    """Return the history of the stored instant nearest to `time` (s); ValueError outside of the run."""
    if not -1e-9 <= time <= history.duration * (1.0 + 1e-9):
        raise ValueError(f"time must be in 0..{history.duration:g} s, got {time:g} s")
    row = int(np.abs(history.time.values - time).argmin())
    return History(history.case, history.dataset.isel(time=[row]))


def action_table(history: History, shoe: int, time: float) -> pd.DataFrame:
    """Return the resultants of all actions on a shoe, rigid or flexible, at a stored instant, in its axes.

    There is a row for each action, one for the inertia, and one for the sums, which are zero. Columns are
    kind, where, place in the shoe's frame in m, force in N and moment about that place in N m. The sums'
    moment is about the frame's origin. Inertia acts at the mass centre and balances the actions. ValueError
    if the time is not within the run or the track has no such shoe.
    """
    history.case.track.check_shoe(shoe)
    now = at_instant(history, time)
    origin, frame = (array[0] for array in actions.shoe_frames(now, shoe))
    words = []
    vectors = []
    for action in actions.actions(now, shoe):
        force = action.force[0] @ frame
        moment = action.moment[0] @ frame
        if force.any() or moment.any():
            words.append((action.kind.value, action.where))
            vectors.append(np.concatenate(((action.point[0] - origin) @ frame, force, moment)))
    center = actions.shoe_mass(now.case, shoe).center
    force, moment = _sums(np.array(vectors))
    words += [(Kind.INERTIA.value, Point.CENTER.value), ("sum", "")]
    vectors.append(np.concatenate((center, -force, np.cross(center, force) - moment)))
    vectors.append(np.concatenate((np.zeros(3), *_sums(np.array(vectors)))))
    names = [f"{axis} in the shoe in m" for axis in "xyz"]
    names += [f"F{axis} in N" for axis in "xyz"] + [f"M{axis} in N m" for axis in "xyz"]
    return pd.DataFrame(words, columns=["kind", "where"]).join(pd.DataFrame(vectors, columns=names))


def _sums(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return force and moment about the origin of rows (k, 9) of places, forces and moments."""
    place = rows[:, :3]
    force = rows[:, 3:6]
    moment = rows[:, 6:]
    return force.sum(axis=0), (np.cross(place, force) + moment).sum(axis=0)


def shoe_loads(history: History, shoe: int, time: float) -> ShoeLoads:
    """Return balanced loads on the nodes of a flexible shoe at the stored instant nearest to a time (s).

    Machine load, contacts, drive and joints enter as in the run. Weight, inertia of the rigid motion and
    actions on the floating frame alone are distributed as the mass, so that the loads balance (inertia
    relief). Inertia and damping of the integrated modes are also nodal forces. A static solution with these
    loads thus has the stress of the moving shoe. ValueError if the shoe is not a flexible one of the history
    or the time is not within the run.
    """
    load_map.check_flexible(history.case, shoe)
    now = at_instant(history, time)
    units = load_map.unit_loads(history.case)
    nodal, centers = units.forces(sum(load_map.loads_by_kind(now, shoe).values()).toarray()[0])
    body = units.body
    joints = list(units.whole.interfaces)
    table = action_table(now, shoe, now.duration)
    loads = ShoeLoads(now.duration, shoe, body, joints, nodal, centers, table)
    rigid = body.rigid_modes
    moved = body.mass_matrix @ rigid
    relief = moved @ np.linalg.solve(rigid.T @ moved, loads.residual)
    return replace(loads, nodal=nodal - relief.reshape(-1, 3))


def roller_loads(history: History, shoe: int) -> xr.Dataset:
    """Return the forces of the rollers on the rails of a shoe, in its axes.

    Both strips of a tread are summed: their forces have the same direction and act on a line across the rail.
    `force` is (time, roller, rail, axis), N. `place` is the point of action, (time, roller, rail, axis), m: x
    along and y across the shoe, z up; NaN while a roller is not on the rail. A closed track has all its
    wheels, flanges included, instead of rollers.

    ValueError if the history's case is neither rolled nor closed, or if its track has no such shoe.
    ValueError also for a rigid shoe of a closed track, since a history does not store where wheels are on it.
    """
    frame = history.case.part(RunningGear)
    wheel = "wheel" if "wheel" in history.dataset.dims else "roller"
    if wheel == "wheel":
        load_map.check_flexible(history.case, shoe)
    history.case.track.check_shoe(shoe)
    origin, axes = actions.shoe_frames(history, shoe)
    shape = (len(axes), *(history.dataset.sizes[dim] for dim in (wheel, "rail", "axis")))
    force = np.zeros(shape)
    weighted = np.zeros(shape)
    weight = np.zeros((*shape[:3], 1))
    for action in actions.actions(history, shoe):
        if isinstance(action.entry, actions.OnRail):
            slot = (slice(None), action.entry.roller, action.entry.line // frame.strips)
            size = np.linalg.norm(action.force, axis=1, keepdims=True)
            force[slot] += np.einsum("tij,ti->tj", axes, action.force)
            weighted[slot] += size * np.einsum("tij,ti->tj", axes, action.point - origin)
            weight[slot] += size
    place = np.divide(weighted, weight, out=np.full(shape, np.nan), where=weight > 0.0)
    dims = ("time", wheel, "rail", "axis")
    return xr.Dataset(
        {"force": (dims, force, {"units": "N"}), "place": (dims, place, {"units": "m"})},
        coords={name: history.dataset[name] for name in dims},
    )


def pin_forces(history: History, shoe: int) -> xr.Dataset:
    """Return the forces and moments of the pins on a shoe, in its axes.

    `force` (N) and `moment` about the joint centre (N m) are (time, pin, axis); pins are "front right",
    "front left", "rear right" and "rear left". Values are NaN where a shoe has no neighbour, and for a link
    of two rigid shoes: its single joint does not determine the forces of its two pins. ValueError if the
    track has no such shoe.
    """
    track = history.case.track
    track.check_shoe(shoe)
    _, frames = actions.shoe_frames(history, shoe)
    names = list(track.joint_centers)
    loads = np.full((2, len(frames), len(names), 3), np.nan)
    acting = actions.actions(history, shoe)
    joints = [
        (load, load.place) for load in acting if load.kind is Kind.JOINT and isinstance(load.place, Pin)
    ]
    ends = [pin.end for _, pin in joints]
    for action, pin in joints:
        if ends.count(pin.end) > 1:
            vectors = np.stack((action.force, action.moment))
            loads[:, :, names.index(action.where)] = np.einsum("tji,vtj->vti", frames, vectors)
    dims = ("time", "pin", "axis")
    text = "on the shoe at the joint centre, in the shoe's axes"
    return xr.Dataset(
        {
            name: (dims, values, {"units": unit, "long_name": f"{name} {text}"})
            for name, unit, values in zip(("force", "moment"), ("N", "N m"), loads, strict=True)
        },
        coords={"time": history.time, "pin": names, "axis": history.axis},
    )


def pin_table(history: History, shoe: int) -> pd.DataFrame:
    """Return the forces of `pin_forces` as a table: a row a stored time, columns by pin, axis and unit.

    ValueError if the track has no such shoe, or none of its pins has a force of its own.
    """
    forces = pin_forces(history, shoe).dropna("pin")
    if not forces.pin.size:
        raise ValueError(
            f"shoe must be flexible, or beside one that is, to have pin forces, got {shoe}; joint_force has "
            "the whole force of a link of rigid shoes"
        )
    columns = {"time in s": forces.time.values}
    for name, letter, unit in (("force", "F", "N"), ("moment", "M", "N m")):
        for pin, axis in itertools.product(forces.pin.values, forces.axis.values):
            columns[f"{pin} {letter}{axis} in {unit}"] = forces[name].sel(pin=pin, axis=axis).values
    return pd.DataFrame(columns)
