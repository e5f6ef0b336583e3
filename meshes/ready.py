"""The ready meshes of the shoe, and any mesh by its path; reading one needs no solver."""

from fem.mesh import Mesh
from fem.mesh_files import read_mesh
from meshes.load_surfaces import with_load_surfaces
from meshes.paths import mesh_path, shoe_path


def shoe_mesh(size: str = "study") -> Mesh:
    """Ready mesh of the shoe in shoe axes, in m, with the surfaces of its file."""
    return read_mesh(shoe_path(size))


def mesh_named(name: str) -> Mesh:
    """Ready mesh of the shoe by its size, or any mesh by its path, with `LOAD_SURFACES`.

    Errors are those of `fem.read_mesh`.
    """
    return with_load_surfaces(read_mesh(mesh_path(name)))
