"""Files of the shoe's meshes."""

from pathlib import Path

from meshes.geometry import SHOE_SIZES


def shoe_path(size: str = "study") -> Path:
    """Path of a ready mesh of the shoe: "coarse", "study" or "fine".

    Raises
    ------
    ValueError
        If there is no such size.
    """
    if size not in SHOE_SIZES:
        raise ValueError(f"size must be one of {SHOE_SIZES}, got {size!r}")
    return Path(__file__).parent / f"shoe_{size}.msh.gz"


def mesh_path(name: str) -> Path:
    """Path of a ready mesh by its size, or of any mesh, by its path."""
    return shoe_path(name) if name in SHOE_SIZES else Path(name)
