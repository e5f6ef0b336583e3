"""Tables of `docs/fem.md`: mesh convergence, spiders and residual modes of the shoe."""

import sys

import numpy as np

import fem
import meshes
from fem.stress import von_mises

PULL = 1.3e6
MACHINE_LOAD = np.array([0.0, 0.0, -386.4e3])


def center_loads(interfaces: tuple[fem.Interface, ...], end: str, axis: int) -> np.ndarray:
    """Load the joint centres, (24, 1): 1.3 MN outward along x, or 0.5 MN inward along y."""
    loads = np.zeros((6 * len(interfaces), 1))
    for k, interface in enumerate(interfaces):
        if interface.name.startswith(end):
            outward = 1.0 if end == "front" else -1.0
            inward = -1.0 if interface.name.endswith("left") else 1.0
            loads[6 * k + axis] = PULL * outward if axis == 0 else 0.5e6 * inward
    return loads


def convergence(sizes: tuple[str, ...]) -> None:
    """Print rigid properties, ten frequencies and peak stresses of each mesh."""
    for size in sizes:
        body = fem.ElasticBody(meshes.shoe_mesh(size), meshes.STEEL)
        frequencies = body.natural_frequencies(16)[6:]
        print(f"\n{size}: {len(body.mesh.nodes)} nodes, {len(body.mesh.elements)} elements")
        print(f"mass {body.mass:.2f} kg, centre {body.center_of_mass.round(5)} m")
        print(f"inertia {body.inertia.round(2).tolist()} kg m2")
        print("frequencies " + " | ".join(f"{f:.2f}" for f in frequencies))
        for spider in ("rigid", "averaging"):
            partition = fem.Partition(body, meshes.joint_interfaces(body.mesh, spider))
            for end, axis in (("rear", 0), ("front", 0), ("rear", 1)):
                loads = center_loads(partition.interfaces, end, axis)
                u = partition.static_response(center_loads=loads).reshape(-1, 3, 1)
                stress = von_mises(body.stress(u)[:, :, 0]) / 1e6
                inside = np.isin(
                    np.arange(len(stress)), np.concatenate([i.nodes for i in partition.interfaces])
                )
                place = int(np.argmax(np.where(inside, 0.0, stress)))
                bores = stress[inside].max()
                print(
                    f"{spider} spider, {end} pins, axis {'xyz'[axis]}: {stress[place]:.1f} MPa at "
                    f"{body.mesh.nodes[place].round(3)}, {bores:.1f} MPa on the bores"
                )


def residual_modes(size: str) -> None:
    """Print what the stress of each distributed load loses without its residual mode."""
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


if __name__ == "__main__":
    convergence(tuple(sys.argv[1:]) or meshes.SHOE_SIZES)
    residual_modes("study")
