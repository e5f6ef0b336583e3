"""Tables of `docs/fem.md`: mesh convergence, spiders, residual modes and flanges of the shoe."""

import sys

import numpy as np
from scipy.sparse.linalg import eigsh, spsolve

import fem
import meshes
from fem.body.element_stress import von_mises
from fem.body.interfaces import Spider
from meshes.build_shoe import ElementSizes
from tests.fem.bodies import box_mesh

MACHINE_LOAD = np.array([0.0, 0.0, -386.4e3])
PIN_LOADS = {
    "rear pins, 1.3 MN backward": {f"rear {side}": [-1.3e6, 0.0, 0.0] for side in ("right", "left")},
    "front pins, 1.3 MN forward": {f"front {side}": [1.3e6, 0.0, 0.0] for side in ("right", "left")},
    "rear pins, 0.5 MN inward": {"rear right": [0.0, 0.5e6, 0.0], "rear left": [0.0, -0.5e6, 0.0]},
}
"""N, forces on joint centres by interface."""


def convergence(sizes: tuple[str, ...]) -> None:
    """Print rigid properties, ten frequencies and peak stresses of each mesh."""
    for size in sizes:
        body = fem.ElasticBody(meshes.shoe_mesh(size), meshes.STEEL)
        frequencies = body.natural_frequencies(16)[6:]
        print(f"\n{size}: {len(body.mesh.nodes)} nodes, {len(body.mesh.elements)} elements")
        print(f"mass {body.mass:.2f} kg, centre {body.center_of_mass.round(5)} m")
        print(f"inertia {body.inertia.round(2).tolist()} kg m2")
        print("frequencies " + " | ".join(f"{f:.2f}" for f in frequencies))
        peaks_of_pin_loads(body, "rigid")
        peaks_of_pin_loads(body, "averaging")


def peaks_of_pin_loads(body: fem.ElasticBody, spider: Spider) -> None:
    """Print the greatest von Mises stress of each load on the pins, off and on the bores."""
    partition = fem.Partition(body, meshes.joint_interfaces(body.mesh, spider))
    bores = np.unique(np.concatenate([interface.nodes for interface in partition.interfaces]))
    for name, forces in PIN_LOADS.items():
        loads = fem.center_loads(partition.interfaces, forces)
        u = partition.static_response(center_loads=loads).reshape(-1, 3, 1)
        stress = von_mises(body.stress(u)[:, :, 0]) / 1e6
        on_bores = stress[bores].max()
        stress[bores] = 0.0
        place = int(stress.argmax())
        print(
            f"{spider} spider, {name}: {stress[place]:.1f} MPa at "
            f"{body.mesh.nodes[place].round(3)}, {on_bores:.1f} MPa on the bores"
        )


def residual_modes(size: str) -> None:
    """Print the error of the stress of each distributed load without its residual mode."""
    body = fem.ElasticBody(meshes.shoe_mesh(size), meshes.STEEL)
    partition = fem.Partition(body, meshes.joint_interfaces(body.mesh, "rigid"))
    reduced = fem.craig_bampton(body, partition.interfaces, 76, partition=partition)
    for surface in ("top", "roller path", "underside"):
        load = body.surface_load(surface, MACHINE_LOAD)
        u = partition.static_response(load.reshape(-1, 1)).reshape(-1, 3, 1)
        exact = body.stress(u)[:, :, 0]
        for count in (94, 20, 12):
            few = reduced.with_modes(range(count))
            q = few.load(surface, MACHINE_LOAD) / (2 * np.pi * few.frequencies) ** 2
            lost = von_mises(few.stress(q)[0] - exact).max()
            print(
                f"{surface}, {count} modes: peak {von_mises(exact).max() / 1e6:.2f} MPa, "
                f"greatest error {lost / 1e6:.2f} MPa ({lost / von_mises(exact).max():.1%})"
            )


OVERHANG = (0.132, 0.6, 0.042)
"""Sides of the flange beside the web, between two notches: across the web, along it, and its thickness, m."""
TIP_LOAD = np.array([0.0, 0.0, -1e5])
"""N, on the edge of the flange."""
EDGES = (0.132, 0.066, 0.044, 0.022)
"""Lengths of elements along the flange, m."""
ELSEWHERE = (0.13, 0.085, 0.06, 0.045)
"""Greatest edges of meshes of the shoe away from bores and roots, m."""


def overhang(edge: float, layers: int) -> fem.ElasticBody:
    """Return the flange beside the web with elements of a length (m) and a number of layers through it."""
    along = [max(1, round(OVERHANG[0] / edge)), 2 * max(1, round(0.5 * OVERHANG[1] / edge))]
    mesh = box_mesh((along[0], along[1], layers), OVERHANG)
    nodes = mesh.nodes
    tip = (nodes[mesh.boundary[:, :3], 0] > OVERHANG[0] - 1e-9).all(axis=1)
    return fem.ElasticBody(fem.Mesh(nodes, mesh.elements, {"tip": mesh.boundary[tip]}), meshes.STEEL)


def bending(edge: float, layers: int) -> tuple[float, float, float]:
    """Return first frequency (Hz), bending stress (Pa) and deflection (m) of the flange, clamped at the web.

    Stress and deflection are those under the load of its tip; the stress is on its face, in its middle.
    """
    body = overhang(edge, layers)
    nodes = body.mesh.nodes
    free = np.repeat(nodes[:, 0] > 1e-9, 3)
    stiffness, mass = (matrix.tocsc()[free][:, free] for matrix in (body.stiffness, body.mass_matrix))
    eigenvalues, _ = eigsh(stiffness, 1, mass, sigma=0.0)
    u = np.zeros(nodes.size)
    u[free] = spsolve(stiffness, body.surface_load("tip", TIP_LOAD).ravel()[free])
    middle = np.abs(nodes - (0.5 * OVERHANG[0], 0.5 * OVERHANG[1], OVERHANG[2])).sum(axis=1).argmin()
    stress = body.stress(u.reshape(-1, 3, 1), np.array([middle]))[0, 0, 0]
    return float(np.sqrt(eigenvalues[0]) / (2.0 * np.pi)), float(stress), float(-u[2::3].min())


def flanges() -> None:
    """Print convergence of the flange with its elements, and of the shoe's frequencies with their edges."""
    for edge, layers in [*((edge, layers) for edge in EDGES for layers in (1, 2, 3)), (0.0165, 4)]:
        frequency, stress, deflection = bending(edge, layers)
        print(
            f"{1e3 * edge:.1f} mm, {layers} layers: {frequency:.0f} Hz, {stress / 1e6:.1f} MPa, "
            f"{1e6 * deflection:.1f} um"
        )
    for elsewhere in ELSEWHERE:
        body = fem.ElasticBody(meshes.mesh_shoe(size=ElementSizes(0.05, 0.05, elsewhere, 0.7)), meshes.STEEL)
        frequencies = body.natural_frequencies(16)[6:]
        print(f"{1e3 * elsewhere:.0f} mm, {len(body.mesh.nodes)} nodes: {frequencies.round(1).tolist()}")


if __name__ == "__main__":
    convergence(tuple(sys.argv[1:]) or meshes.SHOE_SIZES)
    residual_modes("study")
    flanges()
