"""Meshes of MED files of Salome and code_aster (.med), with all groups of every cell; fields are ignored.

A family is a set of cells in the same groups. (meshio 5.3 fails if a kind of cells has no family or a field
is not on all kinds.)
"""

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from fem.body.mesh import Integers, MeshError
from fem.files.mesh_content import LARGEST_FILE, FileCells, FileContent

_KINDS = {
    "TR3": "triangle",
    "TR6": "triangle6",
    "TR7": "triangle7",
    "QU4": "quad",
    "QU8": "quad8",
    "QU9": "quad9",
    "TE4": "tetra",
    "T10": "tetra10",
    "HE8": "hexahedron",
    "H20": "hexahedron20",
    "H27": "hexahedron27",
    "PE6": "wedge",
    "P15": "wedge15",
    "PY5": "pyramid",
    "P13": "pyramid13",
}


def read_med(path: Path) -> FileContent:
    """Read a MED file.

    Raises
    ------
    MeshError
        If the file is not a MED file, or holds several meshes or a mesh at several times.
    """
    try:
        with h5py.File(path, "r") as file:
            return _content(file)
    except MeshError:
        raise
    except OSError as error:
        raise MeshError("it holds no MED mesh: it is not an HDF5 file, or broken") from error
    except (AttributeError, KeyError, TypeError, ValueError, RuntimeError) as error:  # due to missing content
        raise MeshError(f"it holds no MED mesh: {' '.join(str(error).split())}") from error


def _content(file: h5py.File) -> FileContent:
    if "ENS_MAA" not in file or len(file["ENS_MAA"]) != 1:
        raise MeshError(f"it must hold one mesh, got {list(file.get('ENS_MAA', []))}; export one alone")
    (name,) = file["ENS_MAA"]
    mesh = file["ENS_MAA"][name]
    if "NOE" not in mesh:
        if len(mesh) != 1:
            raise MeshError(f"its mesh must have one time, got {len(mesh)}; export one alone")
        (step,) = mesh
        mesh = mesh[step]
    points = _rows(mesh["NOE"]["COO"])
    if points.shape[1] != 3:
        raise MeshError(f"its nodes must have three coordinates, got {points.shape[1]}")
    families = _families(file.get(f"FAS/{name}/ELEME"))
    cells = [_cells(_KINDS[kind], block, families) for kind, block in mesh["MAI"].items() if kind in _KINDS]
    node_groups = {group for groups in _families(file.get(f"FAS/{name}/NOEUD")).values() for group in groups}
    notes = []
    if node_groups:
        listed = ", ".join(map(repr, sorted(node_groups)))
        notes.append(
            f"groups of nodes do not say which faces are a surface, so that these are left out: {listed}"
        )
    return FileContent(points, cells, notes=notes)


def _rows(numbers: h5py.Dataset) -> np.ndarray:
    """Return the numbers of a file, stored column by column, as rows."""
    if numbers.nbytes > LARGEST_FILE:
        raise MeshError(f"it must be at most {LARGEST_FILE >> 20} MiB large, got {numbers.nbytes >> 20} MiB")
    return np.asarray(numbers[()].reshape(-1, int(numbers.attrs["NBR"])).T)


def _families(entries: h5py.Group | None) -> dict[int, list[str]]:
    """Return the names of the groups of each family."""
    families = {}
    for family in filter(None, () if entries is None else entries.values()):
        names = family["GRO"]["NOM"][()] if "GRO" in family else []
        families[int(family.attrs["NUM"])] = [
            bytes(name.astype(np.uint8)).rstrip(b"\0 ").decode(errors="replace")
            for name in map(np.asarray, names)
        ]
    return families


def _cells(kind: str, block: h5py.Group, families: Mapping[int, list[str]]) -> FileCells:
    nodes: Integers = _rows(block["NOD"]).astype(np.int64) - 1
    groups: dict[str, list[Integers]] = {}
    if "FAM" in block:
        family_of = block["FAM"][()]
        for family in np.unique(family_of):
            for name in families.get(int(family), []):
                groups.setdefault(name, []).append(np.flatnonzero(family_of == family))
    return FileCells(kind, nodes, {name: np.concatenate(rows) for name, rows in groups.items()})
