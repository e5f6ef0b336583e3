"""Reduced elastic bodies from finite-element meshes, with recoverable stresses."""

from fem.blocks import Fold, StressBlock, fold_stresses
from fem.body import ElasticBody
from fem.elasticity import Material
from fem.export import Program, write_calculix, write_frame_vtu, write_load_deck, write_modes_vtu, write_vtu
from fem.files import StaleCacheError, cached_craig_bampton, load_reduced, save_reduced
from fem.hotspots import Apart, OneARegion, hot_spots
from fem.interfaces import Interface, center_loads
from fem.mesh import Mesh, MeshError
from fem.mesh_files import read_mesh, write_mesh
from fem.recovery import Extremes, Peaks, recover_extremes, recover_peaks, shares
from fem.reduced import ReducedBody
from fem.reduction import Partition, craig_bampton
from fem.surfaces import faces_joined_to, faces_seen_from

__all__ = [
    "Apart",
    "ElasticBody",
    "Extremes",
    "Fold",
    "Interface",
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
    "load_reduced",
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
