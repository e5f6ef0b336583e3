"""Make `calculix_reference.json` again: `python tests/fem/calculix_reference.py` (needs ccx).

The decks come from `fem.write_calculix` for the coarse shoe: its free-free frequencies, and its stresses
under 1.3 MN on each rear bore and under a roller at a station of the left rail, balanced by inertia. CalculiX
2.20 made the numbers.
"""

import json
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import fem
import meshes

REFERENCE = Path(__file__).with_name("calculix_reference.json")
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
        fem.write_calculix(folder / "modes.inp", body, frequencies=26)
        run(folder, "modes")
        frequencies = frequencies_of((folder / "modes.dat").read_text())
        pull = static_stresses(folder, "pull", body, pull_forces(body))
        roller = static_stresses(folder, "roller", body, roller_forces(body))
    numbers = {"mesh": mesh.digest, "frequencies": frequencies, "nodes": sample_nodes(mesh).tolist()}
    REFERENCE.write_text(json.dumps(numbers | {"stress": pull, "roller stress": roller}) + "\n")


if __name__ == "__main__":
    main()
