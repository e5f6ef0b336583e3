"""Tables of `docs/fem.md`: mesh convergence, spiders and residual modes of the shoe."""

import sys

import numpy as np

import fem
import meshes
from fem.body.element_stress import von_mises
from fem.body.interfaces import Spider

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


if __name__ == "__main__":
    convergence(tuple(sys.argv[1:]) or meshes.SHOE_SIZES)
    residual_modes("study")
