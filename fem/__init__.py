"""Reduced elastic bodies from finite-element meshes, with recoverable stresses."""

from .body import ElasticBody
from .elasticity import Material
from .export import write_calculix, write_frame_vtu, write_modes_vtu, write_vtu
from .files import StaleCacheError, cached_craig_bampton, load_reduced, save_reduced
from .hotspots import hot_spots
from .interfaces import Interface
from .mesh import Mesh, MeshError, read_mesh, write_mesh
from .recovery import Extremes, Peaks, recover_extremes, recover_peaks, shares
from .reduced import ReducedBody
from .reduction import Partition, craig_bampton

__all__ = [
    "ElasticBody",
    "Extremes",
    "Interface",
    "Material",
    "Mesh",
    "MeshError",
    "Partition",
    "Peaks",
    "ReducedBody",
    "StaleCacheError",
    "cached_craig_bampton",
    "craig_bampton",
    "hot_spots",
    "load_reduced",
    "read_mesh",
    "recover_extremes",
    "recover_peaks",
    "save_reduced",
    "shares",
    "write_calculix",
    "write_frame_vtu",
    "write_mesh",
    "write_modes_vtu",
    "write_vtu",
]
