"""All that acts on a shoe at one instant, in balance and in its own axes: for other programs."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.files import whole_file
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.drive_point import pulled_node
from exudyn_crawler.model.flexible_shoes import integrated_reduction, shoe_model, weights_a_metre
from exudyn_crawler.model.rail_rows import strip_lines
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.actions import (
    AtDrivePoint,
    AtInterface,
    OnRail,
    OverRectangle,
    OverSurface,
    actions,
    shoe_mass,
)
from exudyn_crawler.results.stress.stress_columns import stress_columns
from fem import ElasticBody, Interface, Mesh, Program, recover_extremes, write_load_deck
from fem.interfaces import rigid_motion_of_centers
from fem.patches import integrate_underside, mean_rows
from meshes.rails import station_weights

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class ShoeLoads:
    """Loads on the finite elements of a flexible shoe of n nodes and i joints, in the shoe's axes.

    Attributes
    ----------
    time : float
        s, stored instant.
    shoe : int
        Number of the shoe.
    body : ElasticBody
        Mesh and material.
    interfaces : list of Interface
        Joints, whose centres hold the nodes of their bores rigidly.
    nodal : array (n, 3)
        Forces on nodes, N: machine load, contacts, drive, weight and inertia.
    centers : array (i, 6)
        Forces (N) and moments (N m) on the joint centres.
    table : pandas.DataFrame
        Of `action_table`.
    """

    time: float
    shoe: int
    body: ElasticBody
    interfaces: list[Interface]
    nodal: NDArray
    centers: NDArray
    table: pd.DataFrame

    def write(self, path: Path, program: Program = "calculix", overwrite: bool = False) -> Path:
        """Write mesh, joints and loads as a static step for CalculiX or Abaqus, whole or not at all.

        Raises
        ------
        FileExistsError
            If the file exists and `overwrite` is false.
        ValueError
            For another program.
        """
        remarks = [
            f"shoe {self.shoe} at t = {self.time:.6g} s; N, m, Pa; axes of the shoe, from its nominal COM",
            "loads, contacts, drive, joints, weight and inertia are in balance; the six held degrees of "
            "freedom have no reactions",
            *self.table.to_string(index=False, float_format="%.6g").splitlines(),
        ]
        with whole_file(path, overwrite) as temporary:
            write_load_deck(
                temporary,
                self.body,
                self.interfaces,
                self.nodal,
                self.centers,
                program=program,
                remarks=remarks,
            )
        return path

    def _repr_html_(self) -> str:
        """Instant and resultants, for notebooks."""
        return f"<p>Shoe {self.shoe} at t = {self.time:g} s</p>" + self.table.to_html(index=False)

    @property
    def residual(self) -> NDArray:
        """Sum of all forces (N) and of their moments about the centre of mass (N m): array (6,), zero."""
        at_centers = rigid_motion_of_centers(self.interfaces, self.body.center_of_mass)
        return self.body.rigid_modes.T @ self.nodal.ravel() + at_centers.T @ self.centers.ravel()


def at_instant(history: History, time: float) -> History:
    """Stored instant of a history that is nearest to `time` (s), as a history of one time.

    Raises
    ------
    ValueError
        If the time is not within the run.
    """
    if not -1e-9 <= time <= history.duration * (1.0 + 1e-9):
        raise ValueError(f"time must be in 0..{history.duration:g} s, got {time:g} s")
    at = int(np.abs(history.time.values - time).argmin())
    return History(history.case, history.dataset.isel(time=[at]))


def peak_time(history: History, shoe: int) -> float:
    """Time (s) of the highest von Mises stress of a flexible shoe.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history.
    """
    columns = stress_columns(history, [shoe])
    found = recover_extremes(columns.shapes.stress_modes, columns.coordinates[shoe])
    return float(history.time[int(found.highest.argmax())])


def action_table(history: History, shoe: int, time: float) -> pd.DataFrame:
    """Resultants of all that acts on a shoe, rigid or flexible, at a stored instant, in its axes.

    Returns
    -------
    pandas.DataFrame
        A row an action, one for the inertia, and the sums, which are zero: columns kind, where, place in the
        shoe's frame in m, force in N and moment about that place in N m (of the sums about the frame's
        origin). Inertia stands at the mass centre and balances the actions.

    Raises
    ------
    ValueError
        If the time is not within the run or the track has no such shoe.
    """
    history.case.track.check_shoe(shoe)
    now = at_instant(history, time)
    frame, origin = _frame(now, shoe), now.position.sel(shoe=shoe).values[0]
    words, vectors = [], []
    for action in actions(now, shoe):
        force, moment = action.force[0] @ frame, action.moment[0] @ frame
        if force.any() or moment.any():
            words.append((action.kind, action.where))
            vectors.append(np.concatenate(((action.point[0] - origin) @ frame, force, moment)))
    center = shoe_mass(now.case, shoe).center
    force, moment = _sums(np.array(vectors))
    words += [("inertia", "COM"), ("sum", "")]
    vectors.append(np.concatenate((center, -force, np.cross(center, force) - moment)))
    vectors.append(np.concatenate((np.zeros(3), *_sums(np.array(vectors)))))
    names = [f"{axis} in the shoe in m" for axis in AXES]
    names += [f"F{axis} in N" for axis in AXES] + [f"M{axis} in N m" for axis in AXES]
    return pd.concat(
        (pd.DataFrame(words, columns=["kind", "where"]), pd.DataFrame(vectors, columns=names)), axis=1
    )


def _sums(rows: NDArray) -> tuple[NDArray, NDArray]:
    """Force and moment about the origin of rows (k, 9) of places, forces and moments."""
    place, force, moment = rows[:, :3], rows[:, 3:6], rows[:, 6:]
    return force.sum(axis=0), (np.cross(place, force) + moment).sum(axis=0)


def _frame(now: History, shoe: int) -> NDArray:
    """Axes of a shoe in a history of one time: array (3, 3), its columns global."""
    return rotation_matrices(now.angles.sel(shoe=shoe).values)[0]


def shoe_loads(history: History, shoe: int, time: float) -> ShoeLoads:
    """Loads on the nodes of a flexible shoe at the stored instant nearest to a time, in balance.

    Machine load, contacts, drive and joints enter where the run lets them enter. Weight, inertia of the
    rigid motion and what acts on the floating frame alone are spread as the mass, so that all is in balance
    (inertia relief). Inertia and damping of the integrated modes are nodal forces, too, so that a static
    solution with these loads has the stress of the moving shoe.

    Parameters
    ----------
    shoe : int
        Number of a flexible shoe.
    time : float
        s.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history or the time is not within the run.
    """
    flexible = history.case.flexible
    if flexible is None or shoe not in flexible.shoes:
        there = [] if flexible is None else list(flexible.shoes)
        raise ValueError(f"shoe must be a flexible one of the history, of {there}, got {shoe}")
    now = at_instant(history, time)
    stored = now.duration
    body, interfaces = shoe_model(flexible, history.case.track)
    names = [interface.name for interface in interfaces]
    frame = _frame(now, shoe)
    nodal, centers = np.zeros((len(body.mesh.nodes), 3)), np.zeros((len(names), 6))
    for action in actions(now, shoe):
        force, moment = action.force[0] @ frame, action.moment[0] @ frame
        match action.entry:
            case AtInterface(name):
                centers[names.index(name)] += np.concatenate((force, moment))
            case OverSurface(name, shift):
                weights = body.surface_load(name, np.array([0.0, 0.0, 1.0]))[:, 2]
                if shift is not None:
                    weights = weights + shift[0] * weights_a_metre(weights, body.mesh.nodes)
                nodal += weights[:, None] * force
            case OverRectangle():
                nodal += patch_weights(history.case, body, action.entry)[:, None] * force
            case OnRail(line, x):
                nodal += _rail_weights(history.case, body, line, float(x[0]))[:, None] * force
            case AtDrivePoint():
                _add_drive(nodal, centers, force, history.case, interfaces, body.mesh)
    nodal += _elastic_inertia(now, shoe, body, nodal, centers)
    rigid = body.rigid_modes
    moved = body.mass_matrix @ rigid
    loads = ShoeLoads(stored, shoe, body, interfaces, nodal, centers, action_table(now, shoe, stored))
    relief = moved @ np.linalg.solve(rigid.T @ moved, loads.residual)
    return replace(loads, nodal=nodal - relief.reshape(-1, 3))


def patch_weights(case: Case, body: ElasticBody, entry: OverRectangle) -> NDArray:
    """Shares (n,) of the nodes in a force spread evenly over a rectangle of the underside; zero without one.

    The same mean over the rectangle gives the run its modal loads.
    """
    weights = np.zeros(len(body.mesh.nodes))
    if entry.pressed[0]:
        under = body.mesh.nodes_of("underside")
        each = np.eye(len(under))[:, None]
        grid = integrate_underside(body.mesh.nodes[under, :2], each, case.shoe.footprint)
        share = np.zeros((1, len(under)))
        (x0, y0), (x1, y1) = entry.low[0], entry.high[0]
        mean_rows(grid.corner, grid.cell, grid.integral, (x0, x1, y0, y1), share)
        weights[under] = share[0]
    return weights


def _rail_weights(case: Case, body: ElasticBody, line: int, x: float) -> NDArray:
    """Shares (n,) of the nodes in a force of a roller's strip at a place along its line (m)."""
    frame, rails = case.undercarriage, case.shoe.rails
    if frame is None or rails is None:
        raise ValueError("the case has no undercarriage")
    y = strip_lines(frame, rails)[line]
    return station_weights(body.mesh, [(min(max(x, rails.rear), rails.front), y)])[0]


def _add_drive(
    nodal: NDArray, centers: NDArray, force: NDArray, case: Case, interfaces: list[Interface], mesh: Mesh
) -> None:
    """Add the force of the drive where it pulls: a node or both front pins; else it is spread as mass."""
    node = pulled_node(case, mesh)
    if node is not None:
        nodal[node] += force
    elif case.drive.point == "front pins":
        for row, interface in enumerate(interfaces):
            if interface.name.startswith("front"):
                centers[row, :3] += 0.5 * force


def _elastic_inertia(now: History, shoe: int, body: ElasticBody, nodal: NDArray, centers: NDArray) -> NDArray:
    """Nodal forces (n, 3) by which inertia and damping of the integrated modes answer loads, N.

    Their modal forces are what the elastic ones have beyond those of the loads; spread as the modes'
    momentum, they do the same work on every mode and none on a rigid motion.
    """
    reduced = integrated_reduction(now.case).body
    modes = reduced.modes.reshape(nodal.size, -1)
    q = now.modal_coordinate.sel(flexible_shoe=shoe).values[0]
    loads = modes.T @ nodal.ravel() + np.einsum("ik,ikm->m", centers, reduced.pilots)
    beyond = (2.0 * np.pi * reduced.frequencies) ** 2 * q - loads
    return np.asarray(body.mass_matrix @ (modes @ beyond)).reshape(-1, 3)
