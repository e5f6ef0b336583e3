"""Reading and writing of meshes: decks, gmsh and MED files with all their names, others through meshio."""

import gzip
import sys
import tempfile
import warnings
import zlib
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import meshio
import numpy as np

from fem.body.mesh import Mesh, MeshError, MeshWarning
from fem.files.deck import read_deck
from fem.files.deck_lines import text_of
from fem.files.gmsh import read_gmsh
from fem.files.gmsh_sections import is_gmsh
from fem.files.mesh_content import LARGEST_FILE, FileCells, FileContent, VolumeMesh, volume_mesh

PHYSICAL = "gmsh:physical"
SOLID_TAG = 1
_TRIANGLE_OF = {"tetra": "triangle", "tetra10": "triangle6"}


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh of tetrahedra with its named surfaces, also gzip-compressed (`.gz`).

    Surfaces have names in gmsh files (`.msh`: physical surfaces), in decks of Abaqus and CalculiX (`.inp`:
    element sets of shells, or surfaces of element faces) and in MED files (`.med`: groups). Other formats
    that meshio reads have none, except FLAC3D's. A surface that cannot be read in full is left out.

    Parameters
    ----------
    path : str or Path
        File with lengths in m.

    Returns
    -------
    Mesh
        Mesh; its notes say which contents of the file are left out.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    MeshError
        If the file is not a mesh, has no tetrahedra or several kinds of solid elements, or fails a check of
        `Mesh`.

    Warns
    -----
    MeshWarning
        If a surface is left out.
    """
    content = read_volume(path)
    try:
        mesh = content.mesh()
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error
    if content.unread:
        reasons = "; ".join(f"{name!r}: {reason}" for name, reason in content.unread.items())
        warnings.warn(f"{path}: surfaces are left out, {reasons}", MeshWarning, stacklevel=2)
    return mesh


def read_volume(path: str | Path) -> VolumeMesh:
    """Read tetrahedra, named surfaces and named bodies of a file, in its own unit and axes.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    MeshError
        If the file is not a mesh, has no tetrahedra, several kinds of solid elements, or elements that are
        turned inside out.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no mesh file {path}")
    try:
        content = _content(path)
    except MeshError as error:
        raise MeshError(f"{path} must be a mesh that can be read: {error}") from error
    except (ValueError, KeyError, IndexError, OverflowError, RuntimeError, OSError) as error:
        reason = " ".join(str(error).split()) or repr(error)
        raise MeshError(f"{path} must be a mesh that can be read, it is broken: {reason}") from error
    try:
        return volume_mesh(content)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def _content(path: Path) -> FileContent:
    """Read the content of a file by its last two suffixes."""
    suffix = path.suffix.lower()
    packed = suffix == ".gz"
    plain_name = path.stem if packed else path.name
    suffix = Path(plain_name).suffix.lower()
    if suffix in (".msh", ".inp"):
        content = _bytes(path, packed)
        if suffix == ".msh" and is_gmsh(content):
            return read_gmsh(content)
        if suffix == ".inp":
            return read_deck(path, text_of(content, path.name))
    elif not path.stat().st_size:
        raise MeshError("the file is empty")
    if not packed:
        return _read_plain(path, suffix)
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / plain_name
        plain.write_bytes(_bytes(path, packed))
        return _read_plain(plain, suffix)


def _read_plain(path: Path, suffix: str) -> FileContent:
    if suffix != ".med":
        return _through_meshio(path)
    from fem.files.med import read_med  # imported here, since other meshes need no HDF5

    return read_med(path)


def _bytes(path: Path, packed: bool) -> bytes:
    """Return the content of a file, unpacked up to a size limit."""
    try:
        with gzip.open(path) if packed else path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise MeshError(f"it must be whole and readable, got: {error}") from error
    if len(content) > LARGEST_FILE:
        raise MeshError(
            f"it must be at most {LARGEST_FILE >> 20} MiB large{' when unpacked' * packed}, it is larger"
        )
    if not content:
        raise MeshError("the file is empty")
    return content


AS_OTHER_PROGRAMS = (
    "as .msh with physical surfaces, as .inp with *SURFACE or shells in element sets, or as .med with groups "
    "of faces"
)
"""Formats that keep named surfaces, and how other programs save them."""


def _through_meshio(path: Path) -> FileContent:
    """Read the content of a file by meshio; it prints errors and ends the process if all its readers fail."""
    printed = StringIO()
    warned = StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(warned):
            raw = meshio.read(path)
    except SystemExit as end:
        formats = " or ".join(meshio.extension_to_filetypes[path.suffix.lower()])
        lines = "; ".join(filter(None, map(str.strip, printed.getvalue().splitlines())))
        raise MeshError(f"it holds no mesh as {formats}{lines and f': {lines}'}") from end
    except Exception as error:  # meshio's readers raise all kinds of errors
        reason = f"got: {' '.join(str(error).split()) or repr(error)} ({type(error).__name__})"
        if isinstance(error, KeyError):
            reason = f"does not know {error.args[0]!s} in it: a kind of element, or a name"
        raise MeshError(
            f"meshio, which reads other files than .msh, .inp and .med, {reason}; save it {AS_OTHER_PROGRAMS}"
        ) from error
    sys.stderr.write(warned.getvalue())
    points = np.asarray(raw.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError(f"its nodes must have three coordinates, got an array {points.shape}")
    cells = []
    for number, block in enumerate(raw.cells):
        groups = {name: np.asarray(rows[number], dtype=np.int64) for name, rows in raw.cell_sets.items()}
        cells.append(
            FileCells(
                block.type, np.asarray(block.data), {name: rows for name, rows in groups.items() if len(rows)}
            )
        )
    notes = []
    if not any(block.groups for block in cells):
        notes.append(f"{path.suffix} brings no named surfaces: save the mesh {AS_OTHER_PROGRAMS}")
    return FileContent(points, cells, notes=notes)


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
