"""From a case to the numbers that the compiled equations of its track take."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.ground.coordinates import ReducedCoordinates
from exudyn_crawler.ground.pair_contact import PairGroundContact
from exudyn_crawler.model.compiled.bodies import Body, rigid_body
from exudyn_crawler.model.compiled.elimination import Fronts, fronts_of
from exudyn_crawler.model.compiled.joints import ROWS, Pins
from exudyn_crawler.model.compiled.own import Sizes
from exudyn_crawler.model.compiled.records import Ground, Model, Places
from exudyn_crawler.model.compiled.rollers import FRAME
from exudyn_crawler.model.compiled.undercarriage import side_frame_of
from exudyn_crawler.model.drive_point import DrivePoint
from exudyn_crawler.model.flexible_shoes import FloatingShoe, shoe_model


def _rigid_shoe(case: Case) -> Body:
    shoe = case.shoe
    return rigid_body(shoe.mass, shoe.inertia_tensor, np.zeros(3), np.array(shoe.load_point, dtype=float))


def _flexible_body(case: Case, floating: FloatingShoe) -> Body:
    """Integrals of the floating frame with the consistent mass matrix of the finite elements."""
    body, _ = shoe_model(case.flexible_shoes(), case.track)
    # the mass of a node is the same along x, y and z
    mass = body.mass_matrix[0::3, 0::3]
    places, modes = body.mesh.nodes, floating.reduced.modes
    count = modes.shape[2]
    heavy_places = mass @ places
    heavy = np.stack([mass @ modes[:, c] for c in range(3)], axis=1)
    products = np.einsum("naj,nck->jakc", modes, heavy, optimize=True)
    rows, (right, left) = floating.modes.reshape(-1, 3, count), floating.side_nodes
    omega = 2.0 * np.pi * floating.reduced.frequencies
    ratio = case.flexible_shoes().damping.value(floating.reduced.frequencies)
    return Body(
        mass=float(body.mass),
        first=heavy_places.sum(axis=0),
        second=places.T @ heavy_places,
        shapes=np.ascontiguousarray(heavy.sum(axis=0)),
        places=np.ascontiguousarray(np.einsum("na,nck->akc", places, heavy)).ravel(),
        products=np.ascontiguousarray(products.reshape(count, 9 * count)),
        stiffness=omega**2,
        damping=2.0 * ratio * omega,
        load_place=floating.positions[floating.top_node].copy(),
        load_shapes=np.ascontiguousarray(rows[floating.top_node]),
        side_place=0.5 / floating.reach * (floating.positions[left] - floating.positions[right]),
        side_shapes=0.5 / floating.reach * (rows[left] - rows[right]),
    )


def _pins(case: Case, floating: FloatingShoe | None, flexible: NDArray) -> tuple[Pins, list[tuple[int, str]]]:
    """Pins of all links, and of each the link's number (from 1) and its side."""
    modes = 0 if floating is None else floating.mode_count
    shoes, names = [], []
    for rear, front in pairwise(range(case.track.shoe_count)):
        for side in SIDES if flexible[rear] or flexible[front] else SIDES[:1]:
            shoes.append((rear, front))
            names.append((rear + 1, side))
    pins = Pins(
        np.array(shoes, dtype=np.int64).reshape(-1, 2),
        np.zeros((len(shoes), 2, 3)),
        np.zeros((len(shoes), 2, 3, modes)),
        np.zeros((len(shoes), 2, 3, modes)),
    )
    for p, (pair, (_, side)) in enumerate(zip(shoes, names, strict=True)):
        for end, (shoe, where) in enumerate(zip(pair, ("front", "rear"), strict=True)):
            name = f"{where} {side}"
            pins.places[p, end] = case.track.joint_centers[name]
            if floating is not None and flexible[shoe]:
                joint = floating.joints.index(name)
                pins.places[p, end] = floating.reduced.interfaces[joint].center
                pins.shifts[p, end] = floating.reduced.pilots[joint, :3]
                pins.turns[p, end] = floating.reduced.pilots[joint, 3:]
    return pins, names


def _elimination(sizes: Sizes, row: NDArray, links: Sequence[int], pins: Pins) -> tuple[Fronts, Places]:
    """Shoes go first, then the links along the chain, last the terrain with drive, turn and side frame.

    `links` names the link of every pin.
    """
    n, t, m = sizes.shoes, sizes.terrain, sizes.modes
    terrain = list(range(6 * n, 6 * n + t))
    modal, flexible = 6 * n + t, int(row.max()) + 1
    frame = list(range(modal + flexible * m, modal + flexible * m + sizes.frame))
    first = modal + flexible * m + sizes.frame
    shoes = [
        [*range(6 * s, 6 * s + 6), *(range(modal + f * m, modal + f * m + m) if f >= 0 else ())]
        for s, f in enumerate(row)
    ]
    multipliers = [list(range(first + ROWS * p, first + ROWS * p + ROWS)) for p in range(sizes.pins)]
    drive = [first + ROWS * sizes.pins, first + ROWS * sizes.pins + 1]
    chain: dict[int, list[int]] = {}
    for link, own in zip(links, multipliers, strict=True):
        chain.setdefault(link, []).extend(own)
    couplings = [[*shoe, *terrain] for shoe in shoes] + [[*shoes[-1], *drive]]
    couplings += [[*shoes[s], *own] for own, pair in zip(multipliers, pins.shoes, strict=True) for s in pair]
    rolled = [frame[0], drive[0]] if frame else []
    couplings += [[*shoe, *frame, *rolled[1:]] for shoe in shoes] if frame else []
    fronts = fronts_of([*shoes, *chain.values(), [*terrain, *drive, *frame]], couplings)
    last = len(fronts.own) - 1
    places = Places(
        np.array([fronts.row(s, terrain[0]) for s in range(n)]),
        np.array(
            [
                [fronts.row(s, own[0]) for s in pair]
                for own, pair in zip(multipliers, pins.shoes, strict=True)
            ],
            dtype=np.int64,
        ).reshape(-1, 2),
        np.array([fronts.row(n - 1, unknown) for unknown in drive]),
        np.array([last, t, t + 1]),
        np.array([[fronts.row(k, one) for one in rolled] for k in (*range(n), last)], dtype=np.int64),
    )
    return fronts, places


def track_model(
    case: Case, contact: PairGroundContact, floating: FloatingShoe | None, point: DrivePoint
) -> tuple[Model, list[tuple[int, str]]]:
    """Numbers of a case's track, and of each pin the link's number (from 1) and its side."""
    coordinates = contact.coordinates
    if not isinstance(coordinates, ReducedCoordinates):
        raise ValueError("terrain_formulation must be 'reduced' for the compiled equations")
    row = contact.flexible_rows
    modes = 0 if floating is None else floating.mode_count
    pins, names = _pins(case, floating, row >= 0)
    framed = 0 if case.undercarriage is None else FRAME
    sizes = Sizes(case.track.shoe_count, coordinates.size, modes, len(names), framed)
    fronts, places = _elimination(sizes, row, [link for link, _ in names], pins)
    shapes = np.zeros((3, modes))
    if point.rows.size:
        shapes[:] = point.rows
    rigid = _rigid_shoe(case)
    terrain = coordinates.modes
    model = Model(
        sizes=sizes,
        rigid=rigid,
        flexible=rigid if floating is None else _flexible_body(case, floating),
        row=row,
        reference=contact.shoe_reference,
        ground=Ground(
            terrain.heave,
            terrain.tilt,
            contact.unit_reference,
            np.ascontiguousarray(terrain.stiffness),
            np.ascontiguousarray(terrain.damping),
            terrain.weight,
        ),
        pins=pins,
        pulled=(np.array(point.place, dtype=float), shapes, np.zeros((3, modes))),
        contact=contact.track,
        fronts=fronts,
        places=places,
        side=side_frame_of(case, None if floating is None else floating.reduced),
    )
    return model, names
