"""Processor time and memory of the damage of all surface nodes, of six shoes over the stress study's cycle.

``python -m benchmarks.life results/stress/cycle`` takes the run that the stress study leaves.
"""

import resource
import sys
import time as clock
from pathlib import Path

import numpy as np
import pandas as pd

from exudyn_crawler import FatigueMaterial, History
from exudyn_crawler.results.stress.basis import stress_basis
from exudyn_crawler.run.folder.folder import HISTORY
from exudyn_crawler.views.tables import print_table
from fem import Counting, critical_planes, damage_on_planes, recover_damage, surface_normals
from fem.fatigue.damage import SIGNED_CRITERIA

NEGLIGIBLE = 1e-11
"""Damage a pass that may be left out: 1e-9 an hour of a cycle that happens 90 times, about."""
WORST = 1000
"""Nodes, of all shoes, whose critical plane is sought."""


def study(folder: Path) -> pd.DataFrame:
    """Processor seconds of both signed criteria at all surface nodes, of critical planes at the worst."""
    history = History.load(folder / HISTORY)
    basis = stress_basis(history)
    whole, q = basis.shapes, basis.coordinates
    surface, shoes = whole.mesh.surface_nodes, list(q)
    curve = FatigueMaterial.cast_nicrmo().curve()
    counting = Counting(curve, (0.975,), np.zeros(history.time.size, dtype=np.int64), NEGLIGIBLE)
    rows, damage = [], {}
    for criterion in SIGNED_CRITERIA:
        begun = clock.process_time()
        for shoe in shoes:
            found = recover_damage(whole.stress_modes, q[shoe], criterion, counting, surface)
            damage[shoe] = found.damage[:, 0, 0]
        title = f"{criterion}, {len(shoes)} x {len(surface)} nodes, {history.time.size} times"
        rows.append({"what": title, "processor s": clock.process_time() - begun})
    begun = clock.process_time()
    least = np.sort(np.concatenate(list(damage.values())))[-WORST]
    normals = surface_normals(whole.mesh)
    for shoe in shoes:
        nodes = surface[damage[shoe] >= least]
        if len(nodes):

            def damage_on(nodes: np.ndarray, angles: np.ndarray, own: np.ndarray = q[shoe]) -> np.ndarray:
                return damage_on_planes(whole.stress_modes, own, normals, angles, counting, nodes)

            critical_planes(damage_on, nodes)
    title = f"critical planes of the {WORST} worst nodes of all shoes"
    rows.append({"what": title, "processor s": clock.process_time() - begun})
    return pd.DataFrame(rows)


def main() -> None:
    """Print the table and the greatest memory."""
    print_table(study(Path(sys.argv[1])), "Damage over the cycle")
    print(f"greatest memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")


if __name__ == "__main__":
    main()
