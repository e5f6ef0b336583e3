"""Reduced elastic bodies from finite-element meshes, with recoverable stresses."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fem.blocks import Fold, StressBlock, fold_stresses
    from fem.body import ElasticBody
    from fem.cache import (
        CachedFields,
        CachedReduction,
        cached_craig_bampton,
        cached_files,
        cached_static_fields,
    )
    from fem.critical_plane import CriticalPlanes, critical_planes, damage_on_planes, surface_normals
    from fem.damage import Counting, Damage, recover_damage
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
    from fem.fatigue import SNCurve
    from fem.fields import FieldColumns, StaticFields, UnitLoads, field_columns, static_fields
    from fem.files import StaleCacheError, load_fields, load_reduced, save_fields, save_reduced
    from fem.hotspots import Apart, OneARegion, OneOfEach, hot_spots
    from fem.interfaces import Interface, center_loads
    from fem.mesh import Mesh, MeshError, MeshWarning
    from fem.mesh_content import VolumeMesh
    from fem.mesh_files import read_mesh, read_volume, write_mesh
    from fem.places import FlatRectangle, PressureGrid, Stations, flat_parts
    from fem.rainflow import Cycles, repeated_cycles
    from fem.recovery import Peaks, recover_peaks, shares
    from fem.reduced import ReducedBody
    from fem.reduction import Nested, Partition, craig_bampton, nested_reduction
    from fem.shapes import Shapes, SideBySide
    from fem.surfaces import faces_joined_to, faces_seen_from
    from fem.trust import judged, mesh_error

_NAMES = {
    "blocks": "Fold StressBlock fold_stresses",
    "body": "ElasticBody",
    "cache": "CachedFields CachedReduction cached_craig_bampton cached_files cached_static_fields",
    "critical_plane": "CriticalPlanes critical_planes damage_on_planes surface_normals",
    "damage": "Counting Damage recover_damage",
    "elasticity": "Material",
    "export": "Program write_calculix write_frame_vtu write_load_deck write_modes_vtu write_vtu",
    "extremes": "Extremes recover_extremes",
    "fatigue": "SNCurve",
    "fields": "FieldColumns StaticFields UnitLoads field_columns static_fields",
    "files": "StaleCacheError load_fields load_reduced save_fields save_reduced",
    "hotspots": "Apart OneARegion OneOfEach hot_spots",
    "interfaces": "Interface center_loads",
    "mesh": "Mesh MeshError MeshWarning",
    "mesh_content": "VolumeMesh",
    "mesh_files": "read_mesh read_volume write_mesh",
    "places": "FlatRectangle PressureGrid Stations flat_parts",
    "rainflow": "Cycles repeated_cycles",
    "recovery": "Peaks recover_peaks shares",
    "reduced": "ReducedBody",
    "reduction": "Nested Partition craig_bampton nested_reduction",
    "shapes": "Shapes SideBySide",
    "surfaces": "faces_joined_to faces_seen_from",
    "trust": "judged mesh_error",
}
"""Public names of each module."""

__all__ = [
    "Apart",
    "CachedFields",
    "CachedReduction",
    "Counting",
    "CriticalPlanes",
    "Cycles",
    "Damage",
    "ElasticBody",
    "Extremes",
    "FieldColumns",
    "FlatRectangle",
    "Fold",
    "Interface",
    "Material",
    "Mesh",
    "MeshError",
    "MeshWarning",
    "Nested",
    "OneARegion",
    "OneOfEach",
    "Partition",
    "Peaks",
    "PressureGrid",
    "Program",
    "ReducedBody",
    "SNCurve",
    "Shapes",
    "SideBySide",
    "StaleCacheError",
    "StaticFields",
    "Stations",
    "StressBlock",
    "UnitLoads",
    "VolumeMesh",
    "cached_craig_bampton",
    "cached_files",
    "cached_static_fields",
    "center_loads",
    "craig_bampton",
    "critical_planes",
    "damage_on_planes",
    "faces_joined_to",
    "faces_seen_from",
    "field_columns",
    "flat_parts",
    "fold_stresses",
    "hot_spots",
    "judged",
    "load_fields",
    "load_reduced",
    "mesh_error",
    "nested_reduction",
    "read_mesh",
    "read_volume",
    "recover_damage",
    "recover_extremes",
    "recover_peaks",
    "repeated_cycles",
    "save_fields",
    "save_reduced",
    "shares",
    "static_fields",
    "surface_normals",
    "write_calculix",
    "write_frame_vtu",
    "write_load_deck",
    "write_mesh",
    "write_modes_vtu",
    "write_vtu",
]


def __getattr__(name: str) -> Any:
    """Import a module when it is asked for: a mesh alone needs neither solver nor compiler."""
    for module, names in _NAMES.items():
        if name in names.split():
            return getattr(import_module(f"fem.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
