"""Ready meshes of the shoe, and any mesh by its path; reading needs no solver."""

from pathlib import Path

from fem.body.mesh import Mesh
from fem.files.mesh_files import read_mesh
from meshes.checks import check_whole
from meshes.geometry import SHOE_SIZES
from meshes.load_surfaces import with_load_surfaces


def shoe_path(size: str = "study") -> Path:
    """Return the path of a ready mesh of the shoe: "coarse", "study" or "fine".

    Raises
    ------
    ValueError
        If the size is unknown.
    """
    if size not in SHOE_SIZES:
        raise ValueError(f"size must be one of {SHOE_SIZES}, got {size!r}")
    return Path(__file__).parent / f"shoe_{size}.msh.gz"


def mesh_path(name: str) -> Path:
    """Return the path of a ready mesh by its size, or of any mesh by its path."""
    return shoe_path(name) if name in SHOE_SIZES else Path(name)


def shoe_mesh(size: str = "study") -> Mesh:
    """Return a ready mesh of the shoe in shoe axes, m, with the surfaces of its file."""
    return read_mesh(shoe_path(size))


def mesh_named(name: str) -> Mesh:
    """Return a ready mesh of the shoe by its size, or any mesh by its path, with `LOAD_SURFACES`.

    Errors and warnings are those of `fem.read_mesh` and `checks.check_whole`.
    """
    mesh = with_load_surfaces(read_mesh(mesh_path(name)))
    check_whole(mesh, name)
    return mesh
