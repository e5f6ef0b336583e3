"""What static fields are worth: errors between stations and grid points, in time, and their price.

The body in time is the full finite-element model of the coarse mesh, by Newmark's rule of average
acceleration; the modes go by the same rule with the same steps, so that the difference is that of the basis.
"""

import itertools
import time

import numpy as np
from scipy.sparse import csr_array, hstack

import fem
import meshes
from fem.body.element_stress import von_mises
from fem.body.mesh import Floats
from fem.body.rectangle_loads import FlatRectangle, PressureGrid, Stations, flat_parts
from fem.body.solver import factorized
from fem.stress.static_fields import UnitLoads

FORCE = np.array([0.1e6, 0.05e6, -1.0e6])
"""N, of one tread."""
REACH, STEP, STEPS = 0.1, 1e-4, 600
"""m; s; the load comes within RAMP steps and crosses the rail within all of them, at 10 m/s."""
RAMP = 100
EVERY = 10
"""Steps between the instants whose stress is compared."""
SEAMS = np.array([-1.7525, -1.0, 0.0, 1.0, 1.7525])
"""m, where units under the shoe meet."""


class Shoe:
    """A mesh of the shoe with its modes."""

    def __init__(self, size: str) -> None:
        self.body = fem.ElasticBody(meshes.shoe_mesh(size), meshes.STEEL)
        self.partition = fem.Partition(self.body, meshes.joint_interfaces(self.body.mesh))
        self.reduced = fem.craig_bampton(self.body, self.partition.interfaces, 76, partition=self.partition)
        self.rail = flat_parts(self.body.mesh, "roller path")[0]
        path = np.isin(self.body.mesh.elements, self.body.mesh.nodes_of("roller path")).any(axis=1)
        near = np.unique(self.body.mesh.elements[path])
        self.off_path = np.setdiff1d(np.arange(len(self.body.mesh.nodes)), near)

    def spread(self, weights: csr_array) -> UnitLoads:
        """Forces with nodal weights (n, p)."""
        return UnitLoads.spread(weights, self.partition.interfaces)

    def exact(self, family: UnitLoads, loads: Floats) -> Floats:
        """Stress (n, 6, t) of the full static answers to loads (t, k)."""
        u = self.partition.static_response(family.nodal @ loads.T)
        return self.body.stress(u.reshape(-1, 3, len(loads)))

    def found(self, fields: fem.StaticFields, loads: Floats) -> tuple[Floats, Floats]:
        """Stress (n, 6, t) of the modes alone and with fields under static loads (t, k)."""
        q = loads @ fields.work / (2 * np.pi * self.reduced.frequencies) ** 2
        modes = np.tensordot(self.reduced.stress_modes, q, axes=([2], [1]))
        return modes, modes + self.body.stress(fields.displacements @ loads.T)


def error(found: Floats, exact: Floats, nodes: np.ndarray | None = None) -> tuple[float, float]:
    """Greatest and mean over loads of the greatest error over the peak: stresses (n, 6, t)."""
    chosen = slice(None) if nodes is None else nodes
    off = von_mises(np.moveaxis(found - exact, 1, 2))[chosen].max(axis=0)
    part = off / von_mises(np.moveaxis(exact, 1, 2))[chosen].max(axis=0)
    return float(part.max()), float(part.mean())


def between_stations(shoe: Shoe) -> None:
    """Print what stations leave open of a tread anywhere on a rail."""
    x = np.linspace(shoe.rail.low[0], shoe.rail.high[0], 49)
    loads = np.kron(np.eye(49), FORCE)
    exact = shoe.exact(shoe.spread(Stations(shoe.rail, 2, REACH).weights_at(x)), loads)
    print(f"\na tread anywhere on a rail, reach {REACH} m: greatest and mean error over the peak")
    for count in (5, 7, 9, 13, 17, 25):
        stations = Stations(shoe.rail, count, REACH)
        fields = fem.static_fields(shoe.partition, shoe.reduced, {"rail": shoe.spread(stations.weights)})
        own = stations.coordinates(np.tile(FORCE, (49, 1)), x).reshape(49, -1)
        modes, both = shoe.found(fields, own)
        if count == 5:
            print("modes alone: {:.1%}, {:.1%}".format(*error(modes, exact)))
        print(
            f"{count} stations, {np.diff(stations.positions)[0]:.4f} m apart: "
            + "{:.2%}, {:.2%}".format(*error(both, exact))
            + "; off the path's elements {:.2%}, {:.2%}".format(*error(both, exact, shoe.off_path))
        )


def between_grid_points(shoe: Shoe) -> None:
    """Print the error of the underside's grid for pressures that jump at the seams of units."""
    under = flat_parts(shoe.body.mesh, "underside")[0]
    rng = np.random.default_rng(6)
    corners = []
    for seam in (-0.315, -0.2, 0.0, 0.1):
        columns = [(under.low[0], seam), (seam, under.high[0])] if seam > under.low[0] else [(-0.315, 0.315)]
        corners.append([(x, y) for x in columns for y in itertools.pairwise(SEAMS)])
    each = [rng.uniform(0.6, 1.0, (len(one), 1)) * [0.25, 0.05, 1.0] * 400e3 / len(one) for one in corners]
    exact = shoe.body.stress(
        shoe.partition.static_response(_on_nodes(under, corners, each)).reshape(-1, 3, len(corners))
    )
    print("\n400 kN on the underside, uneven by units of 1 m: greatest and mean error over the peak")
    for spacing in (0.35, 0.25, 0.2, 0.1):
        counts = [1 + int(np.ceil(side / spacing)) for side in under.high - under.low]
        grid = PressureGrid(under, (counts[0], counts[1]))
        fields = fem.static_fields(shoe.partition, shoe.reduced, {"ground": shoe.spread(grid.weights)})
        modes, both = shoe.found(fields, _on_grid(grid, corners, each))
        if spacing == 0.35:
            print("modes alone: {:.1%}, {:.1%}".format(*error(modes, exact)))
        print(f"{spacing} m, {3 * np.prod(counts)} loads: " + "{:.2%}, {:.2%}".format(*error(both, exact)))


def _on_nodes(under: FlatRectangle, corners: list, forces: list[Floats]) -> Floats:
    """Nodal forces (3n, t) of sets of rectangles with their forces, by 2400 points in each."""
    columns = []
    for places, pushes in zip(corners, forces, strict=True):
        nodal = np.zeros((len(under.mesh.nodes), 3))
        for ((x0, x1), (y0, y1)), push in zip(places, pushes, strict=True):
            x, y = x0 + (x1 - x0) * (np.arange(40) + 0.5) / 40, y0 + (y1 - y0) * (np.arange(60) + 0.5) / 60
            grid = np.meshgrid(x, y, indexing="ij")
            mean = under.samples(grid[0].ravel(), grid[1].ravel()).mean(axis=0)
            nodal += np.outer(mean, push)
        columns.append(nodal.ravel())
    return np.column_stack(columns)


def _on_grid(grid: PressureGrid, corners: list, forces: list[Floats]) -> Floats:
    """Coordinates (t, p 3) of sets of rectangles with their forces."""
    rows = []
    for places, pushes in zip(corners, forces, strict=True):
        bounds = np.array(places)
        rows.append(grid.coordinates(pushes, bounds[:, :, 0], bounds[:, :, 1]).sum(axis=0).ravel())
    return np.array(rows)


def moving_load() -> tuple[Floats, Floats]:
    """Force (steps + 1, 3) in N and place (steps + 1,) over the rail's length, from 0 to 1."""
    k = np.arange(STEPS + 1)
    come = 0.5 * (1.0 - np.cos(np.pi * np.minimum(k / RAMP, 1.0)))
    return come[:, None] * FORCE, k / STEPS


def newmark(mass: csr_array, stiffness: csr_array, forces: Floats, step: float = STEP) -> Floats:
    """Displacements (d, instants) from rest, every `EVERY` steps, of M u'' + K u = f (d, steps + 1)."""
    solve = factorized(csr_array(mass + 0.25 * step**2 * stiffness))
    u, v, a = (np.zeros(len(forces)) for _ in range(3))
    kept = []
    for k in range(1, forces.shape[1]):
        ahead = u + step * v + 0.25 * step**2 * a
        new = solve(forces[:, k] - stiffness @ ahead)
        u = ahead + 0.25 * step**2 * new
        v += 0.5 * step * (a + new)
        a = new
        if k % EVERY == 0:
            kept.append(u)
    return np.array(kept).T


def newmark_modes(frequencies: Floats, loads: Floats, step: float = STEP) -> tuple[Floats, Floats]:
    """Coordinates and accelerations (instants, m) of modes from rest, by the same rule."""
    squares = (2 * np.pi * frequencies) ** 2
    q, v, a = (np.zeros(len(frequencies)) for _ in range(3))
    kept = []
    for k in range(1, len(loads)):
        ahead = q + step * v + 0.25 * step**2 * a
        new = (loads[k] - squares * ahead) / (1.0 + 0.25 * step**2 * squares)
        q = ahead + 0.25 * step**2 * new
        v = v + 0.5 * step * (a + new)
        a = new
        if k % EVERY == 0:
            kept.append((q, a))
    found = np.array(kept)
    return found[:, 0], found[:, 1]


def in_time(shoe: Shoe) -> None:
    """Print errors of a tread that crosses a rail, against the full model in time."""
    partition, reduced = shoe.partition, shoe.reduced
    stations = Stations(shoe.rail, 17, REACH)
    family = shoe.spread(stations.weights)
    force, place = moving_load()
    x = shoe.rail.low[0] + place * (shoe.rail.high[0] - shoe.rail.low[0])
    loads = stations.coordinates(force, x).reshape(len(x), -1)
    free = csr_array(hstack([partition.of_centers, partition.of_rest]))
    mass, stiffness = (csr_array(free.T @ m @ free) for m in (shoe.body.mass_matrix, shoe.body.stiffness))
    u = free @ newmark(mass, stiffness, free.T @ (family.nodal @ loads.T))
    exact = shoe.body.stress(u.reshape(-1, 3, u.shape[1]))
    families = {
        "rail": family,
        "inertia": UnitLoads.of_inertia(reduced.modes, partition.interfaces),
    }
    fields = fem.static_fields(partition, reduced, families)
    q, acceleration = newmark_modes(reduced.frequencies, fields.coordinates({"rail": loads}) @ fields.work)
    modes = np.tensordot(reduced.stress_modes, q, axes=([2], [1]))
    now = slice(EVERY, None, EVERY)
    print(f"\na tread that crosses a rail in {STEP * STEPS:g} s against the full model in time")
    peak = von_mises(np.moveaxis(exact, 1, 2)).max()
    for name, own in (
        ("modes alone", {}),
        ("modes and fields", {"rail": loads[now]}),
        ("with the modes' inertia", {"rail": loads[now], "inertia": -acceleration}),
    ):
        rest = shoe.body.stress(fields.displacements @ fields.coordinates(own).T) if own else 0.0
        off = von_mises(np.moveaxis(modes + rest - exact, 1, 2)).max()
        print(f"{name}: greatest error {off / peak:.2%} of the peak, {peak / 1e6:.1f} MPa")


def price(shoe: Shoe, rows: int = 4000) -> None:
    """Print what 37 fields beside 94 modes cost in processor time and memory."""
    stations = Stations(shoe.rail, 17, REACH)
    began = time.process_time()
    fields = fem.static_fields(shoe.partition, shoe.reduced, {"rail": shoe.spread(stations.weights)})
    print(f"\n{len(fields.energy)} fields, solved: {time.process_time() - began:.1f} s")
    rng = np.random.default_rng(1)
    t = np.linspace(0.0, 1.0, rows)[:, None]
    count = len(shoe.reduced.frequencies) + len(fields.energy)
    slow = np.sin(2 * np.pi * (t * np.arange(1, 31) + rng.random(30))) @ rng.standard_normal((30, count))
    q, loads = np.split(slow, [len(shoe.reduced.frequencies)], axis=1)
    q, loads = q / shoe.reduced.frequencies**2, loads * 1e4
    columns = fem.field_columns(shoe.body, fields, [loads], most=37)
    shapes, both = columns.beside(shoe.reduced), np.hstack((q, loads @ columns.turn))
    spent = []
    for stress_modes, coordinates in ((shoe.reduced.stress_modes, q), (shapes.stress_modes, both)):
        fem.recover_extremes(stress_modes, coordinates[:300])  # compiles
        began = time.process_time()
        fem.recover_extremes(stress_modes, coordinates)
        spent.append(time.process_time() - began)
    more = columns.modes.nbytes + columns.stress_modes.nbytes
    own = shoe.reduced.modes.nbytes + shoe.reduced.stress_modes.nbytes
    print(
        f"extremes of {rows} rows: {spent[0]:.2f} s with {q.shape[1]} modes, {spent[1]:.2f} s with "
        f"{columns.turn.shape[1]} fields beside; memory of columns {more / own:+.0%}"
    )


def main() -> None:
    """Print all tables for the coarse mesh."""
    shoe = Shoe("coarse")
    between_stations(shoe)
    between_grid_points(shoe)
    in_time(shoe)
    price(shoe)


if __name__ == "__main__":
    main()
