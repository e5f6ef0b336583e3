"""CalculiX's contact of an elastic pin in the rear left bore of the study shoe; writes its highest stresses.

``python -m tests.fem.pin_contact_reference`` needs ``ccx`` and takes five minutes.
"""

import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import fem
import meshes
from fem.body.element_stress import von_mises
from fem.body.surfaces import surface_weights
from tests.fem.bodies import box_mesh, closed
from tests.fem.calculix_reference import stresses_of

STORED = Path(__file__).with_suffix(".json")
NAME, PULL = "rear left", 1e6
"""Bore, and force of the pin backward, N."""
RADIUS, AROUND, HOLLOW = 0.065, 24, 0.1
"""m; number of elements around the pin; radius of a small hole along its axis, fraction of its own."""
STIFF = 2e14
"""Stiffness of the contact, N/m3."""
LOADED = 20.0
"""Factor of the force, beside which the facets of both meshes hardly matter."""
HIGHEST = 40
FACES = {1: (0, 1, 2), 2: (0, 3, 1), 3: (1, 3, 2), 4: (2, 3, 0)}
"""Corners of the faces of a tetrahedron by CalculiX's numbers."""


def pin_mesh(center: np.ndarray, ends: tuple[float, float]) -> fem.Mesh:
    """Hollow cylinder along y between two ends."""

    def mapping(p: np.ndarray) -> np.ndarray:
        angle, r = 2.0 * np.pi * p[:, 1], RADIUS * (HOLLOW + (1.0 - HOLLOW) * p[:, 0])
        y = ends[0] + p[:, 2] * (ends[1] - ends[0])
        return np.column_stack((center[0] + r * np.cos(angle), y, center[2] - r * np.sin(angle)))

    return closed(box_mesh((3, AROUND, 6), (1.0, 1.0, 1.0), mapping))


def surface_lines(name: str, mesh: fem.Mesh, nodes: np.ndarray, first: int) -> list[str]:
    """Faces of the boundary with all corners among some nodes; elements count from `first`."""
    outside = {tuple(face) for face in np.sort(mesh.boundary[:, :3], axis=1).tolist()}
    lines = [f"*SURFACE, NAME={name}"]
    for number, corners in FACES.items():
        faces = mesh.elements[:, list(corners)]
        inside = np.flatnonzero(np.isin(faces, nodes).all(axis=1)).tolist()
        shown = [element for element in inside if tuple(sorted(faces[element].tolist())) in outside]
        lines += [f"{element + first}, S{number}" for element in shown]
    return lines


def deck(body: fem.ElasticBody) -> list[str]:
    """Pin pulled at both ends, in frictionless contact with its bore; the free shoe's inertia balances it."""
    mesh, center = body.mesh, np.array(meshes.JOINT_CENTERS[NAME])
    bore = mesh.nodes_of(f"bore {NAME}")
    y = mesh.nodes[bore, 1]
    ends = (float(y.min()), float(y.max()))
    pin, n, elements = pin_mesh(center, ends), len(mesh.nodes), len(mesh.elements)
    away = np.hypot(*(pin.nodes - center)[:, [0, 2]].T)
    lines = ["*NODE, NSET=ALL"]
    for k, place in enumerate(np.vstack((mesh.nodes, pin.nodes)), 1):
        lines.append(f"{k}, " + ", ".join(f"{value:.12g}" for value in place))
    for name, part, nodes, first in (("SHOE", mesh, 1, 1), ("PIN", pin, n + 1, elements + 1)):
        lines.append(f"*ELEMENT, TYPE=C3D10, ELSET={name}")
        lines += [
            f"{k}, {', '.join(map(str, row))}"
            for k, row in enumerate((part.elements + nodes).tolist(), first)
        ]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "200e9, 0.3"]
    lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL" for name in ("SHOE", "PIN")]
    lines += surface_lines("BORE", mesh, bore, 1)
    lines += surface_lines("SKIN", pin, np.flatnonzero(away > RADIUS * (1.0 - 1e-6)), elements + 1)
    lines += [
        "*SURFACE INTERACTION, NAME=PRESS",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        f"{STIFF:g}",
    ]
    lines += ["*CONTACT PAIR, INTERACTION=PRESS, TYPE=SURFACE TO SURFACE, ADJUST=2e-4", "BORE, SKIN"]
    # nothing but these holds the pin along its axis and from turning about it
    inner = np.flatnonzero((away < 1.01 * HOLLOW * RADIUS) & (np.abs(pin.nodes[:, 1] - ends[0]) < 1e-9))
    front, rear = (n + 1 + inner[way(pin.nodes[inner, 0])] for way in (np.argmax, np.argmin))
    lines += ["*EQUATION", "2", f"{front}, 3, 1., {rear}, 3, -1.", "*BOUNDARY", f"{front}, 2, 2"]
    lines += [f"{dof // 3 + 1}, {dof % 3 + 1}, {dof % 3 + 1}" for dof in body.statically_determinate.tolist()]
    at_ends = pin.boundary[
        (np.abs(np.abs(pin.nodes[:, 1] - np.mean(ends)) * 2 - np.ptp(ends)) < 1e-9)[pin.boundary].all(axis=1)
    ]
    shares = surface_weights(pin, at_ends)
    force = np.array([-LOADED * PULL, 0.0, 0.0])
    resultant = np.concatenate((force, np.cross(center - body.center_of_mass, force)))
    moved = body.mass_matrix @ body.rigid_modes
    inertia = -(moved @ np.linalg.solve(body.rigid_modes.T @ moved, resultant))
    lines += ["*STEP, INC=200", "*STATIC", "1., 1.", "*CLOAD"]
    lines += [f"{k // 3 + 1}, {k % 3 + 1}, {value:.9g}" for k, value in enumerate(inertia.tolist())]
    pulled = np.flatnonzero(shares)
    lines += [f"{n + 1 + k}, 1, {force[0] * shares[k] / shares.sum():.9g}" for k in pulled.tolist()]
    return [*lines, "*EL FILE", "S", "*END STEP"]


def main() -> None:
    """Solve and write the nodes with the highest stresses at the bore, and off all bores."""
    body = fem.ElasticBody(meshes.shoe_mesh("study"), meshes.STEEL)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "pin.inp").write_text("\n".join(deck(body)) + "\n")
        subprocess.run(["ccx", "pin"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        table = stresses_of((Path(folder) / "pin.frd").read_text())
    write(body, np.array([table[node + 1] for node in range(len(body.mesh.nodes))]) / LOADED)


def write(body: fem.ElasticBody, stress: np.ndarray) -> None:
    """Write the highest of stresses (n, 6) under `PULL`."""
    mises = von_mises(stress)
    bores = np.concatenate([body.mesh.nodes_of(f"bore {name}") for name in meshes.JOINT_CENTERS])
    own = body.mesh.nodes_of(f"bore {NAME}")
    chosen = {"bore": own, "off bores": np.setdiff1d(np.arange(len(mises)), bores)}
    stored = {"mesh": body.mesh.digest, "program": "CalculiX 2.20"}
    for name, nodes in chosen.items():
        highest = nodes[np.argsort(-mises[nodes])[:HIGHEST]]
        stored[name] = {"nodes": highest.tolist(), "von Mises": [float(f"{v:.6g}") for v in mises[highest]]}
    STORED.write_text(json.dumps(stored, indent=1) + "\n")


if __name__ == "__main__":
    main()
