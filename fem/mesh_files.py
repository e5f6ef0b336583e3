"""Meshes from and to files: any format that meshio reads, and gmsh's own to write."""

import gzip
import shutil
import sys
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import meshio
import numpy as np

from fem.mesh import Integers, Mesh, MeshError

PHYSICAL = "gmsh:physical"
SOLID_TAG = 1
_TRIANGLE_OF = {"tetra": "triangle", "tetra10": "triangle6"}


def _surfaces_of(raw: meshio.Mesh, kind: str) -> dict[str, Integers]:
    surfaces: dict[str, list[Integers]] = {}
    tags = raw.cell_data.get(PHYSICAL, [None] * len(raw.cells))
    names = {int(tag): name for name, (tag, dim) in raw.field_data.items() if dim == 2}
    for block, tag in zip(raw.cells, tags, strict=True):
        if block.type == kind and tag is not None:
            for value in np.unique(tag):
                name = names.get(int(value))
                if name is not None:
                    surfaces.setdefault(name, []).append(block.data[tag == value])
    if not surfaces:
        for name, per_block in raw.cell_sets.items():
            for block, chosen in zip(raw.cells, per_block, strict=True):
                if block.type == kind and chosen is not None and len(chosen):
                    surfaces.setdefault(name, []).append(block.data[chosen])
    return {name: np.concatenate(parts) for name, parts in surfaces.items()}


def _read_plain(path: Path) -> meshio.Mesh:
    if path.suffix != ".gz":
        return _parsed(path)
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / path.stem
        with gzip.open(path) as packed, plain.open("wb") as out:
            shutil.copyfileobj(packed, out)
        return _parsed(plain)


def _parsed(path: Path) -> meshio.Mesh:
    """Mesh of a file; if all of meshio's readers fail, it prints their errors and ends the process."""
    if not path.stat().st_size:
        raise MeshError("the file is empty")
    printed, warned = StringIO(), StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(warned):
            raw = meshio.read(path)
    except SystemExit as end:
        formats = " or ".join(meshio.extension_to_filetypes[path.suffix.lower()])
        said = "; ".join(filter(None, map(str.strip, printed.getvalue().splitlines())))
        raise MeshError(f"it holds no mesh as {formats}{said and f': {said}'}") from end
    sys.stderr.write(warned.getvalue())
    return raw


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh of tetrahedra from any format that meshio reads, also gzip-compressed (`.gz`).

    Named surfaces come from triangle cells with gmsh's physical names or, in other formats, from
    cell sets.

    Parameters
    ----------
    path : str or Path
        Lengths in the file are in m.

    Returns
    -------
    Mesh

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    MeshError
        If it is not a mesh, has no tetrahedra or several kinds of solid elements, or fails a check of
        `Mesh`.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no mesh file {path}")
    try:
        raw = _read_plain(path)
    except MeshError as error:
        raise MeshError(f"{path} must be a mesh that meshio can read: {error}") from error
    except Exception as error:  # meshio's readers raise all kinds of errors
        reason = " ".join(str(error).split()) or repr(error)
        raise MeshError(f"{path} must be a mesh that meshio can read, got: {reason}") from error
    counts = {
        block.type: sum(len(b.data) for b in raw.cells if b.type == block.type)
        for block in raw.cells
        if block.dim == 3
    }
    if not set(counts) & set(_TRIANGLE_OF):
        held = ", ".join(f"{n} {kind}" for kind, n in counts.items()) or "no solid elements"
        raise MeshError(f"{path} must hold tetrahedra (tetra or tetra10), got {held}")
    if len(counts) > 1:
        held = ", ".join(f"{n} {kind}" for kind, n in counts.items())
        raise MeshError(f"{path} must hold one kind of solid elements, got {held}")
    kind = next(iter(counts))
    elements = np.concatenate([b.data for b in raw.cells if b.type == kind]).astype(np.int64)
    nodes = np.asarray(raw.points, dtype=np.float64)
    try:
        return Mesh(nodes, elements, _surfaces_of(raw, _TRIANGLE_OF[kind]))
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def write_mesh(path: str | Path, mesh: Mesh) -> None:
    """Write a mesh with its named surfaces as a binary gmsh file, gzip-compressed if `.msh.gz`."""
    path = Path(path)
    kind = "tetra" if mesh.order == 1 else "tetra10"
    cells = [(kind, mesh.elements)]
    tags = [np.full(len(mesh.elements), SOLID_TAG)]
    field_data = {"solid": np.array([SOLID_TAG, 3])}
    for number, (name, faces) in enumerate(mesh.surfaces.items(), start=SOLID_TAG + 1):
        cells.append((_TRIANGLE_OF[kind], faces))
        tags.append(np.full(len(faces), number))
        field_data[name] = np.array([number, 2])
    raw = meshio.Mesh(
        mesh.nodes,
        cells,
        cell_data={PHYSICAL: tags, "gmsh:geometrical": tags},
        field_data=field_data,
    )
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / "plain.msh"
        meshio.write(plain, raw, file_format="gmsh22", binary=True)
        content = plain.read_bytes()
    path.write_bytes(gzip.compress(content, mtime=0) if path.suffix == ".gz" else content)
