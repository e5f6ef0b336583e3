"""Make the references again: `python -m tests.fem.calculix_reference` (needs ccx).

The decks come from `fem.write_calculix`. For the coarse shoe `calculix_reference.json` has its stresses under
1.3 MN on each rear bore and under a roller at a station of the left rail, balanced by inertia.
`calculix_modes.json` has frequencies and shapes of free-free modes of that shoe and of a bracket. CalculiX
2.20 made the numbers.
"""

import json
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from scipy.sparse import sparray

import fem
import meshes
from tests.fem.bodies import box_mesh, tube

REFERENCE = Path(__file__).with_name("calculix_reference.json")
MODES = Path(__file__).with_name("calculix_modes.json")
RIGID, ELASTIC = 6, 24
"""Numbers of modes."""
SHAPE_SAMPLES = 60
"""Number of nodes whose shapes are kept."""
PULL = 1.3e6
ROLLER = (0.03e6, 0.0, -0.5e6)
"""N, of one tread."""
STATIONS, STATION, REACH = 17, 4, 0.1
"""How many along the left rail, which one from the rear it is, and half the length of its force, m."""
AWAY_FROM_BORES = 0.15
SAMPLES = 400


def pull_forces(body: fem.ElasticBody) -> np.ndarray:
    """Nodal forces (n, 3) in N: backward pull on each rear bore, balanced by inertia."""
    forces = sum(body.surface_load(f"bore rear {side}", [-PULL, 0.0, 0.0]) for side in ("left", "right"))
    return body.balanced(forces.reshape(-1, 1)).reshape(-1, 3)


def roller_forces(body: fem.ElasticBody) -> np.ndarray:
    """Nodal forces (n, 3) in N: a tread at a station of the left rail, balanced by inertia."""
    _, left = fem.flat_parts(body.mesh, "roller path")
    weights = fem.Stations(left, STATIONS, REACH).weights[:, [STATION]].toarray()
    return body.balanced((weights * ROLLER).reshape(-1, 1)).reshape(-1, 3)


def sample_nodes(mesh: fem.Mesh) -> np.ndarray:
    """Corner nodes at least 0.15 m away from every pin axis, evenly taken."""
    axes = np.array(list(meshes.JOINT_CENTERS.values()))[:, None, [0, 2]]
    distance = np.linalg.norm(mesh.nodes[:, [0, 2]] - axes, axis=2).min(axis=0)
    corners = np.unique(mesh.elements[:, :4])
    corners = corners[distance[corners] > AWAY_FROM_BORES]
    return corners[:: max(1, len(corners) // SAMPLES)]


def bracket() -> fem.Mesh:
    """Quarter of a ring of 0.5 m, 40 mm thick, whose width grows from 0.2 to 0.3 m."""
    bend = tube(0.46, 0.5, np.pi / 2)
    return box_mesh((2, 20, 6), (1.0, 1.0, 0.2), lambda p: bend(p) * (1.0, 1.0, 0.0) + wide(p))


def wide(p: np.ndarray) -> np.ndarray:
    """Places along the width of the bracket."""
    return np.outer(p[:, 2] * (1.0 + 0.5 * p[:, 1]), (0.0, 0.0, 1.0))


BODIES = {"shoe": lambda: meshes.shoe_mesh("coarse"), "bracket": bracket}
"""Meshes of bodies whose modes are compared."""


def shape_nodes(mesh: fem.Mesh) -> np.ndarray:
    """Corner nodes whose shapes are kept, drawn from all."""
    corners = np.unique(mesh.elements[:, :4])
    return np.sort(np.random.default_rng(0).choice(corners, SHAPE_SAMPLES, replace=False))


def modal_assurance(ours: np.ndarray, theirs: np.ndarray, mass: sparray | None = None) -> np.ndarray:
    """Modal assurance criterion of shapes (n, ours) and (n, theirs), 1 for shapes that are multiples.

    With a mass matrix (n, n) different modes of a body have 0 (Allemang, Sound and Vibration 37, 2003).
    """
    heavy = theirs if mass is None else mass @ theirs
    heavy_ours = ours if mass is None else mass @ ours
    own = (ours * heavy_ours).sum(axis=0)[:, None] * (theirs * heavy).sum(axis=0)
    return (ours.T @ heavy) ** 2 / own


def run(folder: Path, job: str) -> None:
    """Run CalculiX on a deck."""
    done = subprocess.run(["ccx", job], cwd=folder, capture_output=True, text=True, check=False)
    if not (folder / f"{job}.frd").exists() or "*ERROR" in done.stdout:
        raise RuntimeError(done.stdout[-2000:])


def frequencies_of(dat: str) -> list[float]:
    """Frequencies in Hz (cycles per time) from the table of eigenvalues; negative ones are 0."""
    table = dat.split("E I G E N V A L U E   O U T P U T")[1].split("P A R T I C I P A T I O N")[0]
    rows = re.findall(r"^\s+\d+\s+(\S+)\s+\S+\s+(\S+)\s+\S+\s*$", table, re.MULTILINE)
    return [float(frequency) if float(value) > 0 else 0.0 for value, frequency in rows]


def stresses_of(frd: str) -> dict[int, list[float]]:
    """Nodal stresses (xx, yy, zz, xy, yz, zx) in Pa by node number from 1."""
    block = frd.split(" -4  STRESS")[1].split("\n -3")[0]
    return {
        int(line[3:13]): [float(line[13 + 12 * k : 25 + 12 * k]) for k in range(6)]
        for line in block.splitlines()
        if line.startswith(" -1")
    }


def shapes_of(frd: str) -> np.ndarray:
    """Displacements (modes, n, 3) of all modes."""
    blocks = [block.split("\n -3")[0] for block in frd.split(" -4  DISP")[1:]]
    lines = [[line for line in block.splitlines() if line.startswith(" -1")] for block in blocks]
    return np.array(
        [[[float(line[13 + 12 * k : 25 + 12 * k]) for k in range(3)] for line in block] for block in lines]
    )


def modes_of(folder: Path, name: str) -> dict[str, object]:
    """Frequencies (Hz), and shapes at some nodes, of a body's elastic modes; how far all nodes' agree."""
    body = fem.ElasticBody(BODIES[name](), meshes.STEEL)
    fem.write_calculix(folder / f"{name}.inp", body, frequencies=RIGID + ELASTIC)
    run(folder, name)
    shapes = shapes_of((folder / f"{name}.frd").read_text())[RIGID:]
    _, ours = body.free_modes(RIGID + ELASTIC)
    mac = modal_assurance(ours[:, RIGID:], shapes.reshape(ELASTIC, -1).T, body.mass_matrix)
    nodes = shape_nodes(body.mesh)
    return {
        "frequencies": frequencies_of((folder / f"{name}.dat").read_text())[RIGID:],
        "nodes": nodes.tolist(),
        "shapes": [
            [float(f"{value:.4g}") for value in mode] for mode in shapes[:, nodes].reshape(ELASTIC, -1)
        ],
        "least diagonal of all nodes": float(mac.diagonal().min()),
        "greatest beside it of all nodes": float((mac - np.diag(mac.diagonal())).max()),
    }


def static_stresses(folder: Path, job: str, body: fem.ElasticBody, forces: np.ndarray) -> list[list[float]]:
    """Nodal stresses in Pa of the sampled nodes under nodal forces (n, 3) in balance."""
    fem.write_calculix(folder / f"{job}.inp", body, forces=forces, fixed=body.statically_determinate)
    run(folder, job)
    stresses = stresses_of((folder / f"{job}.frd").read_text())
    return [stresses[int(node) + 1] for node in sample_nodes(body.mesh)]


def main() -> None:
    """Write the decks, run them and keep the numbers that the tests compare."""
    mesh = meshes.shoe_mesh("coarse")
    body = fem.ElasticBody(mesh, meshes.STEEL)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        modes = {name: modes_of(folder, name) for name in BODIES}
        pull = static_stresses(folder, "pull", body, pull_forces(body))
        roller = static_stresses(folder, "roller", body, roller_forces(body))
    numbers = {"mesh": mesh.digest, "nodes": sample_nodes(mesh).tolist()}
    MODES.write_text(json.dumps({"program": "CalculiX 2.20"} | modes) + "\n")
    REFERENCE.write_text(json.dumps(numbers | {"stress": pull, "roller stress": roller}) + "\n")


if __name__ == "__main__":
    main()
