"""Reduced elastic bodies from finite-element meshes, with recoverable stresses."""

from fem.blocks import Fold, StressBlock, fold_stresses
from fem.body import ElasticBody
from fem.cache import Kept, cached_craig_bampton, kept_reductions
from fem.elasticity import Material
from fem.export import Program, write_calculix, write_frame_vtu, write_load_deck, write_modes_vtu, write_vtu
from fem.extremes import Extremes, recover_extremes
from fem.files import StaleCacheError, load_reduced, save_reduced
from fem.hotspots import Apart, OneARegion, hot_spots
from fem.interfaces import Interface, center_loads
from fem.mesh import Mesh, MeshError
from fem.mesh_files import read_mesh, write_mesh
from fem.recovery import Peaks, recover_peaks, shares
from fem.reduced import ReducedBody
from fem.reduction import Partition, craig_bampton, nested_reduction
from fem.surfaces import faces_joined_to, faces_seen_from

__all__ = [
    "Apart",
    "ElasticBody",
    "Extremes",
    "Fold",
    "Interface",
    "Kept",
    "Material",
    "Mesh",
    "MeshError",
    "OneARegion",
    "Partition",
    "Peaks",
    "Program",
    "ReducedBody",
    "StaleCacheError",
    "StressBlock",
    "cached_craig_bampton",
    "center_loads",
    "craig_bampton",
    "faces_joined_to",
    "faces_seen_from",
    "fold_stresses",
    "hot_spots",
    "kept_reductions",
    "load_reduced",
    "nested_reduction",
    "read_mesh",
    "recover_extremes",
    "recover_peaks",
    "save_reduced",
    "shares",
    "write_calculix",
    "write_frame_vtu",
    "write_load_deck",
    "write_mesh",
    "write_modes_vtu",
    "write_vtu",
]
