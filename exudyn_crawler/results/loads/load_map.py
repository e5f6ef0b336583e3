"""Map from the actions on a flexible shoe to the coordinates of its unit loads.

Modal loads, coordinates of static fields and nodal forces are products with these coordinates. A new entry of
an action needs a case in `shares_of`.

Coordinates of each family:

- joints: (joint, 6): force and moment on each joint centre
- machine: (2, 3): force spread evenly over the loaded surface; force times its shift to the left, N m
- ground: (point, 3): tractions over the rectangles from a corner of the underside to the points of a grid
- rails: (station, 3): forces at stations along each strip of the treads; present under wheels
- drive: (3,): force on the pulled node; absent without such a node
- pins: (bore, 2, direction): forces of pins in contact, and moments that move them along their bores; each
  less the same load of the coupling, so that they are in balance; absent without contact
- inertia: (mode,): momentum of the integrated modes

The ground's grid and the rails' cubics are those of the equations of motion. A uniform traction over any
rectangle is the sum of 16 rectangles from the corner; a cubic distributes a force to the four nearest
stations. On cells the points are the nodes of a coarse grid of the underside, with tractions about each node
by hat functions.

The run integrates the constraint modes and the lowest fixed-interface modes. The other modes lie far above
the frequencies that the track excites and follow their loads statically. Craig-Bampton bases nest, so that
the mode-acceleration method (R. R. Craig, Structural Dynamics, 1981, ch. 15) covers the whole basis: its
elastic forces are the loads less the inertia and damping of the integrated modes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, hstack

from exudyn_crawler.case import Case, FlexibleShoes, RunningGear, Shoe, Track
from exudyn_crawler.ground.cells.ground import COARSE
from exudyn_crawler.model import flexible_shoes, shoe_mesh
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads import actions
from exudyn_crawler.results.loads.kinds import Kind
from fem import ElasticBody, Nested, PinContact, ReducedBody, contact_coordinates, contact_loads
from fem.body import rectangle_motion

JOINTS = "joints"
MACHINE = "machine"
GROUND = "ground"
RAILS = "rails"
DRIVE = "drive"
PINS = "pins"
INERTIA = "inertia"
PIN_KINDS = (Kind.JOINT, Kind.CHAIN, Kind.DRIVE)
"""Kinds of actions on joint centres that pins transmit; teeth press on the lugs themselves."""

THIRDS = 3  # number of pieces between two stations of the equations' rails, since a cubic has four values
STRIP_STATIONS = THIRDS * (shoe_mesh.STATIONS - 1) + 1  # stations along the line of a strip


class NodalShares(NamedTuple):
    """Family of p unit loads along each of x, y, z, shared by k nodes: weights (p, k), nodes (k,)."""

    nodes: np.ndarray
    weights: np.ndarray


class StripStations(NamedTuple):
    """Stations along the lines of the strips."""

    rear: float  # m, x of the first station
    spacing: float  # m, between neighbours
    lines: int  # number of lines on a rail

    def shares(self, line: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return numbers (times, 4) of stations and their shares of a force at x (times,) on a line."""
        t = np.clip((x - self.rear) / self.spacing, 0.0, STRIP_STATIONS - 1.0)
        first = THIRDS * np.minimum((t / THIRDS).astype(int), shoe_mesh.STATIONS - 2)
        u = t - first
        shares = (
            -(u - 1.0) * (u - 2.0) * (u - 3.0) / 6.0,
            u * (u - 2.0) * (u - 3.0) / 2.0,
            -u * (u - 1.0) * (u - 3.0) / 2.0,
            u * (u - 1.0) * (u - 2.0) / 6.0,
        )
        return line * STRIP_STATIONS + first[:, None] + np.arange(4), np.column_stack(shares)


@dataclass(frozen=True, eq=False)
class ShoeUnitLoads:
    """Unit loads of a flexible shoe: k in all, family by family."""

    body: ElasticBody
    whole: ReducedBody  # basis of the stress with all M modes
    integrated: Nested  # basis of the m modes that a run integrates
    underside: rectangle_motion.Underside | None  # grid of the family "ground"; None on cells
    strips: StripStations | None  # stations of "rails"; None without wheels on rails
    spread: Mapping[str, NodalShares]  # families with forces shared by nodes
    contacts: tuple[PinContact, ...]  # pins of the family "pins"

    @cached_property
    def families(self) -> dict[str, slice]:
        """Slice of the coordinates of each family."""
        counts = {JOINTS: 6 * len(self.whole.interfaces)}
        counts |= {name: 3 * len(family.weights) for name, family in self.spread.items()}
        counts |= {PINS: self.pressures[1].shape[1]} if self.contacts else {}
        counts[INERTIA] = len(self.integrated.body.frequencies)
        ends = np.cumsum(list(counts.values())).tolist()
        return {name: slice(end - counts[name], end) for name, end in zip(counts, ends, strict=True)}

    @property
    def size(self) -> int:
        """Number k of unit loads."""
        return self.families[INERTIA].stop

    @cached_property
    def pressures(self) -> tuple[csr_array, np.ndarray]:
        """Loads (3 n, p) on nodes and (6 i, p) on joint centres of the family "pins"."""
        return contact_loads(self.contacts, self.whole.interfaces, len(self.whole.nodes))

    @cached_property
    def work(self) -> np.ndarray:
        """Work (k, M) of the unit loads on all modes, their modal loads."""
        modes = self.whole.modes
        count = len(self.whole.frequencies)
        spread = [
            np.tensordot(family.weights, modes[family.nodes], axes=1) for family in self.spread.values()
        ]
        nodal, centers = self.pressures
        pilots = self.whole.pilots.reshape(-1, count)
        pressed = nodal.T @ modes.reshape(-1, count) + centers.T @ pilots
        rows = [block.reshape(-1, count) for block in (pilots, *spread, pressed)]
        return np.concatenate([*rows, self.integrated.inside.T])

    @cached_property
    def answers(self) -> np.ndarray:
        """Static coordinates (k, M) of all modes under the unit loads."""
        return self.work / (2.0 * np.pi * self.whole.frequencies) ** 2

    def forces(self, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return nodal forces (n, 3), N, and loads on joint centres (i, 6), N, N m, of coordinates (k,)."""
        nodal = np.zeros_like(self.body.mesh.nodes)
        for name, family in self.spread.items():
            nodal[family.nodes] += family.weights.T @ loads[self.families[name]].reshape(-1, 3)
        modes = self.integrated.body.modes
        inertia = self.body.mass_matrix @ (modes @ loads[self.families[INERTIA]]).ravel()
        centers = loads[self.families[JOINTS]]
        if self.contacts:
            pressed, taken = self.pressures
            nodal += (pressed @ loads[self.families[PINS]]).reshape(-1, 3)
            centers = centers + taken @ loads[self.families[PINS]]
        return nodal + inertia.reshape(-1, 3), centers.reshape(-1, 6)


def unit_loads(case: Case) -> ShoeUnitLoads:
    """Return the unit loads of a case's flexible shoes, cached; ValueError without any or a fitting mesh."""
    flexible = case.part(FlexibleShoes)
    body, _ = flexible_shoes.shoe_model(flexible, case.track)
    node = shoe_mesh.pulled_node(case, body.mesh)
    whole = flexible_shoes.whole_reduction(case).body
    cells = case.terrain.model == "cells"
    frame = case.part(RunningGear) if case.gear.wheel_names else None
    return _unit_loads(flexible, case.track, case.shoe, frame, whole, node, cells)


@lru_cache(maxsize=2)
def _unit_loads(
    flexible: FlexibleShoes,
    track: Track,
    shoe: Shoe,
    frame: RunningGear | None,
    whole: ReducedBody,
    node: int | None,
    cells: bool,
) -> ShoeUnitLoads:
    body, _ = flexible_shoes.shoe_model(flexible, track)
    mesh = body.mesh
    strips = None
    under = mesh.nodes_of("underside")
    # integrals for each node: products with modes are then those of the equations of motion
    each = np.eye(len(under))[:, None]
    underside = rectangle_motion.integrate_underside(mesh.nodes[under, :2], each, shoe.footprint)
    ground = rectangle_motion.hat_grid(underside, COARSE)[1] if cells else underside.integral
    # forces by a unit over the loaded surface, and their change by a metre of shift
    even = whole.weights(flexible.load_surface)
    machine = np.column_stack((even, flexible_shoes.weights_a_metre(even, whole.nodes)))
    loaded = np.flatnonzero(machine.any(axis=1))
    spread = {
        MACHINE: NodalShares(loaded, machine[loaded].T),
        GROUND: NodalShares(under, ground.reshape(-1, len(under))),
    }
    if frame is not None and (rails := shoe.rails) is not None:
        strips = StripStations(rails.rear, shoe_mesh.station_spacing(rails) / THIRDS, frame.strips)
        nodes, weights = shoe_mesh.strip_weights(mesh, frame, rails)
        along = shoe_mesh.cubic_weights(np.arange(STRIP_STATIONS) / THIRDS) @ shoe_mesh.extended(weights)
        spread[RAILS] = NodalShares(nodes, along.reshape(-1, len(nodes)))
    if node is not None:
        spread[DRIVE] = NodalShares(np.array([node]), np.eye(1))
    rectangles = None if cells else underside
    integrated = flexible_shoes.integrated_in(flexible, whole)
    contacts = flexible_shoes.pin_contacts(flexible, track)
    return ShoeUnitLoads(body, whole, integrated, rectangles, strips, spread, contacts)


def shares_of(units: ShoeUnitLoads, action: actions.Action) -> tuple[str, np.ndarray, np.ndarray] | None:
    """Return family, numbers and shares (times or 1, j) of an action's unit loads; None without any."""
    joints = [interface.name for interface in units.whole.interfaces]
    match action.entry:
        case actions.AtInterface(name):
            return JOINTS, np.array([[joints.index(name)]]), np.ones((1, 1))
        case actions.OverSurface(shift):
            metres = np.zeros(1) if shift is None else shift
            return MACHINE, np.array([[0, 1]]), np.column_stack((np.ones_like(metres), metres))
        case actions.AtGridNode(node):
            return GROUND, np.array([[node]]), np.ones((1, 1))
        case actions.OverRectangle(low, high, pressed) if units.underside is not None:
            points, shares = units.underside.rectangle_mean(low, high)
            return GROUND, points, shares * pressed[:, None]
        case actions.OnRail(line, x) if units.strips is not None:
            return RAILS, *units.strips.shares(line, x)
        case actions.AtDriveNode() if DRIVE in units.spread:
            return DRIVE, np.zeros((1, 1), dtype=int), np.ones((1, 1))
        case actions.AtPins(names):
            pins = [number for number, name in enumerate(joints) if name in names]
            return JOINTS, np.array([pins]), np.full((1, len(pins)), 1.0 / len(pins))
        case actions.AtDriveNode() | None:
            return None
    raise TypeError(f"no unit loads for an action that enters by {action.entry}")


def coordinates(units: ShoeUnitLoads, action: actions.Action, frames: np.ndarray) -> csr_array:
    """Return an action's coordinates (times, k) of unit loads on a shoe of axes `frames` (times, 3, 3)."""
    shared = shares_of(units, action)
    if shared is None:
        return csr_array((len(frames), units.size))
    family, numbers, shares = shared
    vectors = (action.force, action.moment) if family == JOINTS else (action.force,)
    in_body = np.concatenate([np.einsum("tji,tj->ti", frames, vector) for vector in vectors], axis=1)
    values = shares[..., None] * in_body[:, None]
    times, loads, components = values.shape
    columns = units.families[family].start + numbers[..., None] * components + np.arange(components)
    rows = np.arange(times + 1) * loads * components
    places = np.broadcast_to(columns, values.shape).flatten()
    matrix = csr_array((values.ravel(), places, rows), shape=(times, units.size))
    matrix.eliminate_zeros()
    return matrix


def loads_by_kind(history: History, shoe: int) -> dict[Kind, csr_array]:
    """Return the coordinates (times, k) of the unit loads of a flexible shoe by kind of action.

    Inertia is the momentum of the integrated modes with their damping, ``k q - P^T f``. Here f are the loads
    of all modes. k and q are stiffness and coordinates of the integrated modes, P their columns in the whole
    basis. The elastic forces of all modes are then ``f - P P^T f + P k q``. Motion outside of the space of P
    follows its loads statically; motion within it has the elastic forces of the integration. ValueError if
    the shoe is not flexible.
    """
    check_flexible(history.case, shoe)
    units = unit_loads(history.case)
    _, frames = actions.shoe_frames(history, shoe)
    by_kind: dict[Kind, csr_array] = {}
    for action in actions.actions(history, shoe):
        loads = coordinates(units, action, frames)
        if loads.nnz:
            by_kind[action.kind] = by_kind[action.kind] + loads if action.kind in by_kind else loads
    q = history.modal_coordinate.sel(flexible_shoe=shoe).values
    elastic = q * (2.0 * np.pi * history.frequency.values) ** 2
    acting = sum(by_kind.values(), start=csr_array((len(q), units.size)))
    momentum = elastic - acting @ units.work @ units.integrated.inside
    before = csr_array((len(q), units.families[INERTIA].start))
    by_kind[Kind.INERTIA] = hstack((before, csr_array(momentum)), format="csr")
    if units.contacts:
        # in balance with the coupling and without effect on the integrated motion
        pressed = _pressed(units, by_kind)
        by_kind[Kind.JOINT] = by_kind[Kind.JOINT] + pressed if Kind.JOINT in by_kind else pressed
    return by_kind


def _pressed(units: ShoeUnitLoads, by_kind: Mapping[Kind, csr_array]) -> csr_array:
    """Return the coordinates (times, k) of pins in contact under the loads of their kinds."""
    joints = units.families[JOINTS]
    of_pins = [by_kind[kind][:, joints].toarray() for kind in PIN_KINDS if kind in by_kind]
    times = next(iter(by_kind.values())).shape[0]
    loads = sum(of_pins, start=np.zeros((times, joints.stop)))
    found = contact_coordinates(units.contacts, units.whole.interfaces, loads.reshape(times, -1, 6))
    place = units.families[PINS]
    around = [csr_array((times, place.start)), csr_array(found), csr_array((times, units.size - place.stop))]
    return csr_array(hstack(around, format="csr"))


def check_flexible(case: Case, shoe: int) -> None:
    """Raise ValueError if a shoe is not a flexible one of a history's case."""
    there = [] if case.flexible is None else list(case.flexible.shoes)
    if shoe not in there:
        raise ValueError(f"shoe must be a flexible one of the history, of {there or 'none'}, got {shoe}")
