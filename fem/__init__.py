"""Reduced elastic bodies from finite-element meshes, with recoverable stresses."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fem.blocks import Fold, StressBlock, fold_stresses
    from fem.body import ElasticBody
    from fem.cache import Kept, cached_craig_bampton, kept_reductions
    from fem.elasticity import Material
    from fem.export import (
        Program,
        write_calculix,
        write_frame_vtu,
        write_load_deck,
        write_modes_vtu,
        write_vtu,
    )
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

_HOMES = {
    "Apart": "hotspots",
    "ElasticBody": "body",
    "Extremes": "extremes",
    "Fold": "blocks",
    "Interface": "interfaces",
    "Kept": "cache",
    "Material": "elasticity",
    "Mesh": "mesh",
    "MeshError": "mesh",
    "OneARegion": "hotspots",
    "Partition": "reduction",
    "Peaks": "recovery",
    "Program": "export",
    "ReducedBody": "reduced",
    "StaleCacheError": "files",
    "StressBlock": "blocks",
    "cached_craig_bampton": "cache",
    "center_loads": "interfaces",
    "craig_bampton": "reduction",
    "faces_joined_to": "surfaces",
    "faces_seen_from": "surfaces",
    "fold_stresses": "blocks",
    "hot_spots": "hotspots",
    "kept_reductions": "cache",
    "load_reduced": "files",
    "nested_reduction": "reduction",
    "read_mesh": "mesh_files",
    "recover_extremes": "extremes",
    "recover_peaks": "recovery",
    "save_reduced": "files",
    "shares": "recovery",
    "write_calculix": "export",
    "write_frame_vtu": "export",
    "write_load_deck": "export",
    "write_mesh": "mesh_files",
    "write_modes_vtu": "export",
    "write_vtu": "export",
}
"""Modules of the public names."""

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


def __getattr__(name: str) -> Any:
    """Import a module when it is asked for: a mesh alone needs neither solver nor compiler."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"fem.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
