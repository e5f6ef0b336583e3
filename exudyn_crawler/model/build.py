"""From a case to the tables of its system."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from exudyn_crawler.case import Case, CellTerrain, Closed, Rolled
from exudyn_crawler.case.parameters import base
from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.ground import packed, pair_geometry
from exudyn_crawler.ground.cells import ground
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.contact import GroundContact, PairGroundContact, ground_contact
from exudyn_crawler.ground.laws import Impact
from exudyn_crawler.ground.terrain import TerrainModes, reduced_coordinates
from exudyn_crawler.model import elimination, shoe_mesh
from exudyn_crawler.model.bodies import Bodies, Modes, second_moment
from exudyn_crawler.model.flexible_shoes import FloatingShoe, floating_shoe, shoe_model
from exudyn_crawler.model.forces import cells, loads, teeth, treads, units
from exudyn_crawler.model.forces.impact import Flange
from exudyn_crawler.model.forces.wheels import ROLLED, Wheels
from exudyn_crawler.model.joints.drive import Drive
from exudyn_crawler.model.joints.hold import Holds
from exudyn_crawler.model.joints.motor import Motors
from exudyn_crawler.model.joints.pin import ROWS, Pins
from exudyn_crawler.model.joints.pull import Pull
from exudyn_crawler.model.kinds import Forces, Joints
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.tables import FrontRows, Search, Tables
from exudyn_crawler.model.terrain import TerrainTable
from fem.patches import hat_grid

ACROSS_CHAIN = np.array([0.0, 1.0, 0.0, 1.0, 1.0])
"""Equations of a pin that are redundant in a closed chain."""


def _flexible_modes(case: Case, floating: FloatingShoe) -> tuple[Modes, np.ndarray, np.ndarray]:
    """Modes, and first and second moments of the body, by the mass matrix of the finite elements."""
    body, _ = shoe_model(case.flexible_shoes(), case.track)
    # the mass of a node is the same along x, y and z
    mass = body.mass_matrix[0::3, 0::3]
    places, shapes = body.mesh.nodes, floating.reduced.modes
    count = shapes.shape[2]
    heavy_places = mass @ places
    heavy = np.stack([mass @ shapes[:, c] for c in range(3)], axis=1)
    products = np.einsum("naj,nck->jack", shapes, heavy, optimize=True)
    omega = 2.0 * np.pi * floating.reduced.frequencies
    ratio = case.flexible_shoes().damping.value(floating.reduced.frequencies)
    modes = Modes(
        stiffness=omega**2,
        damping=2.0 * ratio * omega,
        shapes=np.ascontiguousarray(heavy.sum(axis=0)),
        places=np.einsum("na,nck->ack", places, heavy).reshape(9, count),
        products=products.reshape(count, 9 * count),
    )
    return modes, heavy_places.sum(axis=0), places.T @ heavy_places


class _Builder:
    """Tables of a case as they are made, one after the other."""

    def __init__(
        self, case: Case, terrain_size: int, floating: FloatingShoe | None, point: shoe_mesh.DrivePoint
    ) -> None:
        self.case, self.floating, self.point = case, floating, point
        self.shoes = case.track.shoe_count
        self.flexible = np.zeros(self.shoes, dtype=bool)
        self.flexible[flexible_shoes(case)] = True
        self.modes = 0 if floating is None else floating.mode_count
        self._markers: list[tuple[int, np.ndarray, np.ndarray, np.ndarray]] = []
        self.frame = case.gear if isinstance(case.gear, Rolled) else None
        self.closed = case.gear if isinstance(case.gear, Closed) else None
        # a side frame, or the machine on two tracks, and the tumblers of closed ones
        self.tumblers = self.shoes + 1 + np.arange(case.tracks if self.closed else 0)
        self.tensioner = self.closed.idler.tensioner if self.closed else None
        self.idlers = self.shoes + 1 + len(self.tumblers) + np.arange(case.tracks if self.tensioner else 0)
        # bodies that turn against the frame
        self.turning = [*self.tumblers.tolist(), *self.idlers.tolist()]
        self.count = self.shoes + len(case.frame_parts[:1]) + len(self.turning)
        self.first_modal = 6 * self.shoes + terrain_size

    def _add(self, body: int, position: ArrayLike, *rows: np.ndarray | None) -> int:
        """Number of a marker on a body at a position (3,), m, which rows (3, modes) move and turn."""
        none = np.zeros((3, self.modes))
        moved, turned = (none if one is None else one for one in (*rows, None, None)[:2])
        self._markers.append((body, np.array(position, dtype=float), moved, turned))
        return len(self._markers) - 1

    def markers(self) -> Markers:
        """All markers that were added."""
        body, position, moved, turned = (np.array(one) for one in zip(*self._markers, strict=True))
        bends = moved.any(axis=(1, 2)) | turned.any(axis=(1, 2))
        return Markers(body, position, moved, turned, np.where(bends, self.modes, 0))

    def bodies(self) -> tuple[Bodies, Modes]:
        """Shoes, then the side frame or the machine, and the tumblers of closed tracks."""
        case, shoe, n = self.case, self.case.shoe, self.shoes
        none = np.zeros(3)
        mass, first = np.full(self.count, float(shoe.mass)), np.zeros((self.count, 3))
        second = np.tile(second_moment(shoe.mass, shoe.inertia_tensor, none), (self.count, 1, 1))
        modes = packed.nothing(Modes)
        if self.floating is not None:
            body, _ = shoe_model(case.flexible_shoes(), case.track)
            modes, own_first, own_second = _flexible_modes(case, self.floating)
            chosen = np.flatnonzero(self.flexible)
            mass[chosen], first[chosen], second[chosen] = body.mass, own_first, own_second
        reference = np.zeros((self.count, 6))
        reference[:n] = case.shoe_reference
        if parts := case.frame_parts:
            mass[n] = sum(part.mass for part in parts)
            first[n] = sum(part.mass * part.com for part in parts)
            second[n] = sum(second_moment(part.mass, part.inertia, part.com) for part in parts)
            reference[n, :3] = case.frame_start
        if self.closed is not None:
            tumbler, own = self.closed.tumbler, self.tumblers
            mass[own], reference[own] = tumbler.mass, case.tumbler_reference
            second[own] = second_moment(tumbler.mass, base.inertia_tensor(tumbler.inertia), none)
            if self.tensioner is not None:
                own, inertia = self.idlers, self.tensioner.inertia_tensor(self.closed.idler.radius)
                mass[own], reference[own] = self.tensioner.mass, case.idler_reference
                second[own] = second_moment(self.tensioner.mass, inertia, none)
        modal = np.full(self.count, -1)
        chosen = np.flatnonzero(self.flexible)
        modal[chosen] = self.first_modal + self.modes * np.arange(len(chosen))
        others = self.first_modal + self.modes * len(chosen) + 6 * np.arange(self.count - n)
        coordinate = np.concatenate((6 * np.arange(n), others))
        return Bodies(coordinate, modal, reference, mass, first, second, np.zeros((self.count, 2, 3))), modes

    def _pin(self, shoe: int, name: str, place: np.ndarray | None = None) -> int:
        """Marker of a joint centre of a shoe, or of a place (3,), m, that goes with its bore."""
        at = self._worn(name) if place is None else place
        if self.floating is None or not self.flexible[shoe]:
            return self._add(shoe, at)
        reduced = self.floating.reduced
        joint = [interface.name for interface in reduced.interfaces].index(name)
        moved, turned = reduced.pilots[joint, :3], reduced.pilots[joint, 3:]
        arm = at - self.case.track.joint_centers[name]
        center = reduced.interfaces[joint].center + arm
        return self._add(shoe, center, moved + np.cross(turned.T, arm).T, turned)

    def _worn(self, name: str) -> np.ndarray:
        """Joint centre of a shoe, or the middle of two; the pins of a worn chain are farther apart."""
        end, side = name.split()
        both = [self.case.track.joint_centers[f"{end} {one}"] for one in SIDES]
        center = np.mean(both, axis=0) if side == "middle" else both[SIDES.index(side)]
        if self.closed is None or not name.startswith("rear"):
            return center
        return center - [self.closed.pitch_growth * self.case.track.pitch, 0.0, 0.0]

    def _pin_middle(self, shoe: int, end: str) -> int:
        """Marker in the middle of the rear or the front pins of a shoe."""
        reduced = self.floating.reduced if self.floating is not None and self.flexible[shoe] else None
        return self._add(shoe, *shoe_mesh.pin_middle(self.case.track, reduced, end))

    def _axes(self) -> np.ndarray:
        """Where in the frame the bodies that turn have their axes: array (bodies, 3), m.

        Those of idlers are where their tensioners do not push them.
        """
        if self.closed is None:
            return np.zeros((0, 3))
        axes = self.case.tumbler_reference[:, :3]
        if self.tensioner is not None:
            beyond = self.tensioner.preload / self.tensioner.stiffness - self.case.assembled.take_up
            axes = np.vstack((axes, self.case.idler_reference[:, :3] + np.array([beyond, 0.0, 0.0])))
        return axes - self.case.frame_start

    def joints(self) -> tuple[Joints, list[tuple[int, str]], int]:
        """Joints, of each pin the link's number (from 1), or that of a bearing (-1, -2), and side; rows."""
        pins = self._pins()
        names = [name for _, name in pins]
        row = ROWS * len(pins)
        last = self.shoes - 1
        if self.case.gear.bodies:
            marker = self._add(self.shoes, np.zeros(3))
        else:
            marker = self._add(last, self.point.place, self.point.rows if self.point.rows.size else None)
        drive = Drive(row, marker, last)
        holds = [(self.shoes, k) for k in self.case.gear.holds]
        first_motor = row + 2 + len(holds)
        joints = Joints(
            pins=self._pin_table(pins),
            drive=drive,
            pull=self.pull(row),
            holds=Holds(row + 2, np.array(holds, dtype=np.int64).reshape(-1, 2)),
            motors=self._motors(first_motor),
        )
        return joints, names, first_motor + len(joints.motors.bodies)

    def _pins(self) -> list[tuple[tuple[int, int], tuple[int, str]]]:
        """Markers and names of all pins: of the links, then of the bearings of what turns in a frame."""
        pins = []
        for rear, front in (self.case.links - 1).tolist():
            bends = self.flexible[rear] or self.flexible[front]
            for side in SIDES if bends else SIDES[:1]:
                # in a tight chain a joint beside the middle would bear a moment of the whole tension
                where = "middle" if self.closed is not None and not bends else side
                markers = self._pin(rear, f"front {where}"), self._pin(front, f"rear {where}")
                pins.append((markers, (rear + 1, side)))
        for body, axis in zip(self.turning, self._axes(), strict=True):
            markers = self._add(self.shoes, axis), self._add(body, np.zeros(3))
            pins.append((markers, (self.shoes - body, SIDES[0])))
        return pins

    def _pin_table(self, pins: list[tuple[tuple[int, int], tuple[int, str]]]) -> Pins:
        """Table of all pins; those of a closed chain and of sliding idlers are compliant."""
        compliance = np.zeros((len(pins), ROWS))
        relaxation = np.zeros((len(pins), ROWS))
        if self.closed is not None:
            # the bearings of what turns, which come last, are no part of the chains
            compliance[: len(pins) - len(self.turning)] = self.closed.compliance * ACROSS_CHAIN
        if self.tensioner is not None:
            slides = len(self.idlers)
            compliance[-slides:, 0] = 1.0 / self.tensioner.stiffness
            relaxation[-slides:, 0] = self.tensioner.damping / self.tensioner.stiffness
        return Pins(
            0,
            np.array([markers for markers, _ in pins], dtype=np.int64).reshape(-1, 2),
            compliance,
            relaxation,
            in_plane=self.closed is not None,
            follows=isinstance(self.case.terrain, CellTerrain),
        )

    def _motors(self, first: int) -> Motors:
        """Motors of tumblers, and what keeps sliding idlers from spinning, from a row on."""
        if self.closed is None:
            return packed.nothing(Motors)
        limit = np.inf if self.closed.torque_limit is None else self.closed.torque_limit
        return Motors(
            first,
            np.column_stack((np.full(len(self.turning), self.shoes), self.turning)),
            np.array([*[limit] * len(self.tumblers), *[np.inf] * len(self.idlers)]),
            np.full(len(self.turning), self.closed.torque_speed),
        )

    def loads(self) -> loads.Loads:
        """Machine load of every shoe; with a side frame, its load and the tension of the chain's ends."""
        places = []
        for s in range(self.shoes):
            if self.floating is not None and self.flexible[s]:
                floating = self.floating
                place = self._add(s, floating.load_point, floating.load_rows)
                places.append((place, self._add(s, floating.beside, floating.beside_rows)))
            else:
                places.append((self._add(s, self.case.shoe.load_point), self._add(s, (0.0, 1.0, 0.0))))
        if self.case.gear.bodies:
            places.append((self._add(self.shoes, np.zeros(3)), -1))
        if self.frame is not None:
            places += [(self._pin_middle(0, "rear"), -1), (self._pin_middle(self.shoes - 1, "front"), -1)]
        return loads.Loads(*(np.array(one) for one in zip(*places, strict=True)))

    def pull(self, row: int) -> Pull:
        """Pull of a side frame's drive, which is the multiplier of a row."""
        if self.frame is None:
            return packed.nothing(Pull)
        markers = np.array([self._pin_middle(s, "front") for s in range(self.shoes)])
        ahead = self.case.track.pin_ahead
        pitch = float(self.case.track.pitch)
        return Pull(row, self.shoes, float(self.frame.tumbler), pitch, float(ahead), markers)

    def cells(self) -> cells.CellTable:
        """Undersides on cells, with a grid of nodes under the flexible shoes."""
        row = np.where(self.flexible, np.cumsum(self.flexible) - 1, -1)
        if self.floating is None:
            return cells.CellTable(row, np.zeros((*ground.COARSE, 3)), np.zeros((*ground.COARSE, 3, 0)))
        nodes, rows = hat_grid(self.floating.underside, ground.COARSE)
        height = np.full((*ground.COARSE, 1), self.case.shoe.footprint[4])
        return cells.CellTable(row, np.concatenate((nodes, height), axis=2), rows)

    def teeth(self) -> teeth.Teeth:
        """Lugs of the shoes and the tumbler of a closed track."""
        closed, track = self.closed, self.case.track
        if closed is None:
            return packed.nothing(teeth.Teeth)
        tumbler, lugs = closed.tumbler, closed.lugs(track)
        markers = [self._pin(shoe, *lug) for shoe in range(self.shoes) for lug in lugs]
        half = 0.5  # of the guide at each gear plane
        return teeth.Teeth(
            markers=np.array(markers),
            tumblers=np.repeat(self.tumblers, len(markers) // len(self.tumblers)),
            side=np.tile([place[1] for _, place in lugs], self.shoes),
            profile=teeth.Profile(*tumbler.profile(track)),
            law=Impact(tumbler.stiffness, tumbler.exponent, tumbler.damping, tumbler.damping_depth),
            flange=Flange(closed.guide_play, half * closed.guide_stiffness, half * closed.guide_damping),
        )

    def wheels(self) -> Wheels:
        """Wheels of a side frame on the rails of the shoes; rollers of an open track have no flanges."""
        rails = self.case.shoe.rails
        if rails is None or not self.case.gear.wheel_names:
            return packed.nothing(Wheels)
        gear = self.case.running_gear()
        lines = shoe_mesh.strip_lines(gear, rails)
        middles, count = self.case.track_middles, self.shoes // self.case.tracks
        wheels = gear.first_wheels(self.case.shoe, self.case.track)
        play, stiffness, damping = gear.flange
        first = count * np.repeat(np.arange(len(middles)), len(wheels))
        frames, beside = np.full(len(first), self.shoes), np.repeat(middles, len(wheels))
        places = [[(x, y + m, z) for y in lines] for m in middles for x, z, _ in wheels]
        for track, idler in enumerate(self.idlers):
            w = track * len(wheels) + len(gear.rollers)
            frames[w], places[w], beside[w] = idler, [(0.0, y, 0.0) for y in lines], 0.0
        reduced = None if self.floating is None else self.floating.reduced
        strips, ahead = gear.strips, np.subtract.outer(gear.rollers, gear.rollers)
        on_a_rail = (ahead >= 0.0) & (ahead < rails.front - rails.rear + 2.0 * ROLLED)
        return Wheels(
            frames=frames,
            shoes=np.column_stack((first, first + count)),
            places=np.array(places),
            middles=beside,
            radii=np.tile(wheels[:, 2], len(middles)),
            law=Impact(gear.stiffness / strips, gear.exponent, gear.damping / strips, gear.damping_depth),
            flange=Flange(play, stiffness / len(lines), damping / len(lines)),
            height=gear.flange_height,
            rail=treads.Rail(rails.rear, rails.front, rails.height),
            rows=shoe_mesh.rail_rows(reduced, gear, rails),
            spacing=shoe_mesh.station_spacing(rails),
            slots=max(2, int(on_a_rail.sum(axis=0).max())),  # of the upper run two
        )


def _with_fronts(tables: Tables, shoes: int, links: Sequence[int]) -> Tables:
    """Tables with the order of the elimination.

    Shoes go first, then the links along the chain, last the terrain, other bodies and other multipliers.

    `links` names the link of every pin. Of a closed chain those with two pins go first, then every second one
    of those that are left in turn, so that what touches one part of the loop is not carried round all of it.
    """
    bodies, joints, forces, m = tables.bodies, tables.joints, tables.forces, len(tables.modes.stiffness)
    size = tables.terrain.heave.shape[1]
    terrain = list(range(tables.terrain.first, tables.terrain.first + size))
    coordinates = [
        [*range(first, first + 6), *(range(modal, modal + m) if modal >= 0 else ())]
        for first, modal in zip(bodies.coordinate.tolist(), bodies.modal.tolist(), strict=True)
    ]
    start = size + sum(map(len, coordinates))
    multipliers = list(range(start, start + tables.multipliers))
    pins = [multipliers[ROWS * p : ROWS * p + ROWS] for p in range(len(joints.pins.markers))]
    others = multipliers[ROWS * len(pins) :]
    chain: dict[int, list[int]] = {}
    for link, rows in zip(links, pins, strict=True):
        # the bearing of a tumbler, which is no link
        (chain.setdefault(link, []) if link > 0 else others).extend(rows)
    body = tables.markers.body
    couplings = [[*shoe, *terrain] for shoe in coordinates[:shoes]]
    couplings += [
        [*coordinates[body[marker]], *rows]
        for rows, pair in zip(pins, joints.pins.markers, strict=True)
        for marker in pair
    ]
    couplings += [[*coordinates[body[joints.drive.marker]], others[0]]]
    if not len(joints.motors.bodies):
        couplings.append([*coordinates[joints.drive.turning], others[1]])
    frames = [one for group in coordinates[shoes:] for one in group]
    met = zip(forces.wheels.frames.tolist(), forces.wheels.shoes.tolist(), strict=True)
    couplings += [[*coordinates[k], *coordinates[wheel]] for wheel, ends in met for k in range(*ends)]
    met = zip(body[forces.teeth.markers].tolist(), forces.teeth.tumblers.tolist(), strict=True)
    couplings += [[*coordinates[shoe], *coordinates[tumbler]] for shoe, tumbler in met]
    couplings += [[*shoe, others[0]] for shoe in coordinates[: len(joints.pull.markers)]]
    order = sorted(chain)
    if len(joints.motors.bodies):
        order.sort(key=lambda link: (len(chain[link]) == ROWS, link & -link))
    groups = [*coordinates[:shoes], *(chain[link] for link in order), [*terrain, *frames, *others]]
    fronts = elimination.fronts_of(groups, couplings)
    places = [{unknown: k for k, unknown in enumerate(fronts.rows(f))} for f in range(len(fronts.own))]
    last = len(fronts.own) - 1
    in_fronts = FrontRows(
        np.array([[row.get(body[0], -1) for body in coordinates] for row in places]),
        np.array([*range(shoes), *[last] * (len(coordinates) - shoes)]),
        np.array([row.get(terrain[0], -1) if terrain else -1 for row in places]),
        np.array([[row.get(one, -1) for one in multipliers] for row in places]),
    )
    return tables._replace(fronts=fronts, rows=in_fronts)


def flexible_shoes(case: Case) -> list[int]:
    """Indices (from 0) of a case's flexible shoes."""
    return [] if case.flexible is None else [number - 1 for number in case.flexible.shoes]


class Parts(NamedTuple):
    """What a multibody system of a case is made of; `pins` are link (from 1) and side of each link pin."""

    floating: FloatingShoe | None
    point: shoe_mesh.DrivePoint
    contact: GroundContact
    tables: Tables
    pins: list[tuple[int, str]]


def parts_of(case: Case) -> Parts:
    """Flexible shoes, contact and tables of a case."""
    bending, floating = flexible_shoes(case), None if case.flexible is None else floating_shoe(case)
    bends = case.track.shoe_count - 1 in bending
    point = shoe_mesh.drive_point(case, floating.reduced if floating is not None and bends else None)
    contact = ground_contact(case, None if floating is None else floating.underside, bending)
    coordinates = contact.coordinates
    terrain = coordinates if isinstance(coordinates, TerrainModes) else reduced_coordinates(case)
    builder = _Builder(case, terrain.size, floating, point)
    bodies, modes = builder.bodies()
    joints, pins, multipliers = builder.joints()
    loads, teeth = builder.loads(), builder.teeth()
    geometry, reference = packed.nothing(pair_geometry.ContactGeometry), np.zeros((0, 4))
    if isinstance(contact, PairGroundContact):
        geometry, reference = contact.geometry, contact.unit_reference
    on_cells = isinstance(contact, CellGroundContact)
    tables = Tables(
        bodies=bodies,
        modes=modes,
        markers=builder.markers(),
        joints=joints,
        loads=loads,
        terrain=TerrainTable(
            terrain.heave,
            terrain.tilt,
            reference,
            np.ascontiguousarray(terrain.stiffness),
            np.ascontiguousarray(terrain.damping),
            terrain.weight,
            6 * builder.shoes,
        ),
        forces=Forces(
            units=units.UnitTable(geometry, builder.first_modal, len(bending)),
            cells=builder.cells() if on_cells else packed.nothing(cells.CellTable),
            teeth=teeth,
            wheels=builder.wheels(),
        ),
        multipliers=multipliers,
        fronts=elimination.fronts_of([], []),
        rows=packed.nothing(FrontRows),
        search=search_of(case),
    )
    tables = _with_fronts(tables, builder.shoes, [link for link, _ in pins])
    return Parts(floating, point, contact, tables, pins)


def search_of(case: Case) -> Search:
    """Search of a case's steps.

    On cells, rows that load or unload change their stiffness by forty: under dragged shoes an old matrix
    leaves 0.02 of such a residual in the median and seldom over 0.13, whatever the first correction left; up
    to 1 where points come back. Under wheels a matrix costs more than it saves, unless what the old one
    gained, known within ten, says that it will not do. In a closed track a new matrix takes about as long as
    three iterations.
    """
    on_cells = isinstance(case.terrain, CellTerrain)
    rolls = bool(case.gear.bodies)
    return Search(
        kept=0.15 if on_cells and not rolls else 0.0,
        slower=0.0 if not on_cells else 10.0 if rolls else 1.0,
        ahead=3 if case.gear.loops else 0,
    )
