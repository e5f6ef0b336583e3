"""Contact of spheres under rigid shoes with the top faces of terrain units, on frames.

The law is that of Exudyn's `GeneralContact` (`laws.linear`), along the line from the nearest point of the
face to the sphere's centre. Each face is a rectangle of two triangles; a sphere beside the face touches
its edge, and near the two corners on the diagonal the nearest points of both triangles.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.faces import Nearest, nearest_on_face
from exudyn_crawler.ground.frames import (
    Frame,
    Vector,
    about,
    along,
    columns_of,
    compiled,
    dot,
    norm,
    turned,
    turned_back,
    velocity_at,
    within,
)
from exudyn_crawler.ground.grid import Grid, cell, cells_about
from exudyn_crawler.ground.laws import Law, drag_ratio, named_law, normal_force
from exudyn_crawler.ground.rotations import FloatArray, attitude, generalized_moment, shoe_at, unit_at


class SphereTrack(NamedTuple):
    """What stays as it is.

    Attributes
    ----------
    grid : Grid
        Units.
    tops : array (units,)
        Height of each unit's face above its centre, m.
    half_x, half_y : float
        Half the sides of the faces, m: less than the units' where they are drawn back from the edges.
    places : array (spheres, 3)
        Centres of the spheres in the shoe's frame, m.
    radius : float
        Of the spheres, m.
    law : Law
        Of one sphere.
    """

    grid: Grid
    tops: FloatArray
    half_x: float
    half_y: float
    places: FloatArray
    radius: float
    law: Law


class SphereBodies(NamedTuple):
    """Places of all bodies and their rates, as of `pair_track.Bodies`."""

    shoes: FloatArray
    shoe_rates: FloatArray
    units: FloatArray
    unit_rates: FloatArray


class Touch(NamedTuple):
    """A touching sphere; vectors are global.

    Depth (m) and its rate (m/s), point on the face (m), normal towards the sphere, normal force (N), slip of
    the shoe over the unit (m/s), friction over slip (N s/m), distance of the centre from the point (m),
    direction of the edge it touches, and what it touches.
    """

    depth: float
    approach: float
    point: Vector
    normal: Vector
    size: float
    slip: Vector
    drag: float
    distance: float
    edge: Vector
    kind: float


@compiled
def sphere_touch(
    center: Vector, above: Vector, near: Nearest, shoe: Frame, unit: Frame, radius: float, law: Law
) -> Touch:
    """Force of a sphere on a unit's face; without depth it does not touch.

    Its centre is `center` (m, global) and, in the unit's axes, `above` (m) the nearest point `near`.
    """
    distance = norm(above)
    normal = turned(unit.R, (above[0] / distance, above[1] / distance, above[2] / distance))
    point = along(center, -distance, normal)
    velocity = along(velocity_at(shoe, point), -1.0, velocity_at(unit, point))
    approach = -dot(velocity, normal)
    slip = along(velocity, approach, normal)
    depth = radius - distance
    size = normal_force(law, depth, approach)
    edge = turned(unit.R, (near.edge_x, near.edge_y, 0.0))
    drag = size * drag_ratio(law, norm(slip))
    return Touch(depth, approach, point, normal, size, slip, drag, distance, edge, near.kind)


COLUMN, COLUMNS = columns_of(Touch, "shoe", "unit")
"""Columns of a touching sphere, shoe and unit from 0, and how many they are."""


@within
def _append(touch: Touch, s: int, u: int, table: FloatArray, count: int) -> int:
    """Write a sphere of shoe s on unit u that is deep enough below `count` rows; gives their number."""
    if touch.depth <= 0.0 or count >= table.shape[0]:
        return count
    row = table[count]
    row[0], row[1], row[2], row[3] = s, u, touch.depth, touch.approach
    row[10], row[14], row[15], row[19] = touch.size, touch.drag, touch.distance, touch.kind
    for k in range(3):
        row[4 + k], row[7 + k] = touch.point[k], touch.normal[k]
        row[11 + k], row[16 + k] = touch.slip[k], touch.edge[k]
    return count + 1


@compiled
def kept(row: FloatArray) -> Touch:
    """Touching sphere of a row of the table."""
    point, normal = (row[4], row[5], row[6]), (row[7], row[8], row[9])
    slip, edge = (row[11], row[12], row[13]), (row[16], row[17], row[18])
    return Touch(row[2], row[3], point, normal, row[10], slip, row[14], row[15], edge, row[19])


@within
def _shoe_touches(
    shoe: Frame, s: int, bodies: SphereBodies, track: SphereTrack, table: FloatArray, count: int
) -> int:
    """Append what the spheres of shoe s touch to a table that has `count` rows; gives their number."""
    radius, axis = track.radius, track.grid.tilt_axis
    for n in range(track.places.shape[0]):
        place = (track.places[n, 0], track.places[n, 1], track.places[n, 2])
        center = along(shoe.r, 1.0, turned(shoe.R, place))
        cells = cells_about(track.grid, center[0], center[1], radius, radius)
        for k in range(cells.columns * cells.rows):
            u = cell(track.grid, cells, k)
            unit = unit_at(bodies.units[u], bodies.unit_rates[u], axis)
            local = turned_back(unit.R, along(center, -1.0, unit.r))
            above = local[2] - track.tops[u]
            if above <= 0.0 or above >= radius:
                continue
            number, first, second = nearest_on_face(local[0], local[1], track.half_x, track.half_y)
            for f in range(number):
                near = first if f == 0 else second
                apart = (local[0] - near.x, local[1] - near.y, above)
                touch = sphere_touch(center, apart, near, shoe, unit, radius, track.law)
                count = _append(touch, s, u, table, count)
    return count


@compiled
def sphere_contacts(places: tuple, model: tuple, table: FloatArray) -> int:
    """All spheres that touch a unit.

    Parameters
    ----------
    places, model : tuple
        `SphereBodies` and `SphereTrack` as plain tuples.
    table : array (contacts, COLUMNS)
        Out: one row a touching sphere, columns as in `COLUMN`.

    Returns
    -------
    int
        Number of touching spheres.
    """
    bodies = SphereBodies(*places)
    grid, tops, half_x, half_y, centers, radius, law = model
    track = SphereTrack(Grid(*grid), tops, half_x, half_y, centers, radius, named_law(law))
    count = np.int64(0)
    for s in range(bodies.shoes.shape[0]):
        shoe = shoe_at(bodies.shoes[s], bodies.shoe_rates[s])
        count = _shoe_touches(shoe, s, bodies, track, table, count)
    return int(count)


@compiled
def touch_force(touch: Touch) -> Vector:
    """Force on the shoe, N."""
    force = along((0.0, 0.0, 0.0), touch.size, touch.normal)
    return along(force, -touch.drag, touch.slip)


@compiled
def sphere_forces(
    shoes: FloatArray,
    units: FloatArray,
    table: FloatArray,
    shoe_forces: FloatArray,
    unit_forces: FloatArray,
) -> None:
    """Sum the touching spheres' forces.

    Parameters
    ----------
    shoes, units : array (shoes, 6), array (units, 4)
        Places.
    table : array (contacts, COLUMNS)
        Touching spheres.
    shoe_forces : array (shoes, 6)
        Out: generalized forces on the shoes' coordinates (N, N m).
    unit_forces : array (units, 6)
        Out: force (N) and moment about the centre (N m) on each unit, global.
    """
    nothing = (0.0, 0.0, 0.0)
    shoe_forces.fill(0.0)
    unit_forces.fill(0.0)
    for n in range(table.shape[0]):
        touch, s, u = kept(table[n]), int(table[n, 0]), int(table[n, 1])
        force = touch_force(touch)
        on_shoe = about((shoes[s, 0], shoes[s, 1], shoes[s, 2]), touch.point, force, nothing)
        on_unit = about((units[u, 0], units[u, 1], units[u, 2]), touch.point, force, nothing)
        for k in range(3):
            shoe_forces[s, k] += force[k]
            shoe_forces[s, 3 + k] += on_shoe.moment[k]
            unit_forces[u, k] -= force[k]
            unit_forces[u, 3 + k] -= on_unit.moment[k]
    for s in range(shoes.shape[0]):
        moment = (shoe_forces[s, 3], shoe_forces[s, 4], shoe_forces[s, 5])
        parts = generalized_moment(moment, attitude(shoes[s, 3], shoes[s, 4], shoes[s, 5]))
        for k in range(3):
            shoe_forces[s, 3 + k] = parts[k]
