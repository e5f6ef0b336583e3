"""Reduced elastic bodies from finite-element meshes, with recoverable stresses."""

from .elasticity import Material
from .mesh import Mesh, MeshError, read_mesh, write_mesh

__all__ = ["Material", "Mesh", "MeshError", "read_mesh", "write_mesh"]
