"""Mesh of the shoe with a quarter of the nodes of the ready coarse one, for what holds on any mesh.

`python -m tests.small_shoe` makes the file anew.
"""

from pathlib import Path

from fem import write_mesh
from meshes import mesh_shoe
from meshes.build_shoe import ElementSizes

SMALL_SHOE = str(Path(__file__).parent / "meshes" / "small_shoe.msh.gz")
"""Path of the mesh. Its mass and its first mode are within 2 % of those of the ready meshes."""
SIZES = ElementSizes(at_bores=0.12, at_rear_roots=0.12, elsewhere=0.5, on_curves=0.25, growth=0.9)

if __name__ == "__main__":
    write_mesh(Path(SMALL_SHOE), mesh_shoe(size=SIZES))
