"""Draw the shoe's surface: `python -m meshes.draw_shoe [folder]`."""

import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from fem.body.mesh import Floats, Mesh, triangle_normals
from meshes import LOAD_SURFACES, mesh_named, shoe_mesh

COLORS = {"top": "#e8c48a", "roller path": "#d98c3f", "bore": "#b23a48"}
STEEL_COLOR = "#9fb1bd"
LIGHT = np.array([0.45, -0.35, 0.82])


def draw_surface(
    ax: Axes3D, mesh: Mesh, colors: Floats, elevation: float, azimuth: float, light: Floats = LIGHT
) -> Axes3D:
    """Draw the boundary of a mesh with shading.

    Parameters
    ----------
    ax : Axes3D
        Axes in three dimensions.
    mesh : Mesh
    colors : array (k, 3)
        Red, green, blue of each boundary triangle, 0 to 1.
    elevation, azimuth : float
        Direction of the viewer, degrees; faces turned away are left out.
    light : array (3,)
        Direction towards the light.
    """
    corners = mesh.nodes[mesh.boundary[:, :3]]
    normals = triangle_normals(corners)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    up, around = np.radians([elevation, azimuth])
    viewer = [np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)]
    seen = normals @ viewer > 0.0
    shade = 0.62 + 0.38 * (normals @ light / np.linalg.norm(light))
    ax.add_collection3d(
        Poly3DCollection(
            corners[seen],
            facecolors=np.clip(colors * shade[:, None], 0, 1)[seen],
            edgecolors="#00000030",
            linewidths=0.2,
        )
    )
    low = mesh.nodes.min(axis=0)
    high = mesh.nodes.max(axis=0)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(tuple(high - low), zoom=1.25)
    ax.set(xlabel="x", zlabel="z (m)")
    ax.set_ylabel("y", labelpad=14)
    ax.view_init(elev=elevation, azim=azimuth)
    return ax


def face_names(mesh: Mesh, keys: Iterable[str]) -> np.ndarray:
    """Return the name of each boundary triangle, (k,): the last key that begins its surface's name, or ""."""
    order = {tuple(f): i for i, f in enumerate(np.sort(mesh.boundary[:, :3], axis=1).tolist())}
    names = np.full(len(order), "", dtype=object)
    for key in keys:
        for name in (n for n in mesh.surfaces if n.startswith(key)):
            faces = np.sort(mesh.surface(name)[:, :3], axis=1).tolist()
            names[[order[tuple(f)] for f in faces]] = key
    return names


def named_colors(mesh: Mesh, colors: Mapping[str, str]) -> Floats:
    """Return the colours (k, 3) of the boundary triangles by their named surface.

    Parameters
    ----------
    mesh : Mesh
    colors : mapping of str to str
        Colour "#rrggbb" by the beginning of surface names; a later one covers an earlier one.
    """
    codes = [colors.get(name, STEEL_COLOR) for name in face_names(mesh, colors)]
    return np.array([[int(code[i : i + 2], 16) / 255 for i in (1, 3, 5)] for code in codes])


def draw_shoe(path: Path, mesh: Mesh) -> None:
    """Draw a shoe mesh from the front above and from the rear above into a file."""
    figure = Figure(figsize=(11, 8))
    for place, azimuth, title in ((1, 35, "front pins (+x)"), (2, 215, "rear pins (-x)")):
        ax = figure.add_axes((-0.1, 0.98 - 0.5 * place, 1.2, 0.5), projection="3d")
        draw_surface(ax, mesh, named_colors(mesh, COLORS), 28, azimuth)
        figure.text(0.5, 0.97 - 0.5 * (place - 1), f"seen from the {title}", ha="center")
        ax.set(xticks=[-0.4, 0.0, 0.4], zticks=[-0.2, 0.0, 0.2])
    figure.savefig(path, dpi=110)


def draw_load_surfaces(path: Path, mesh: Mesh) -> None:
    """Draw the load surfaces of the top, one below the other, into a file."""
    figure = Figure(figsize=(8, 9))
    for place, name in enumerate(LOAD_SURFACES, start=1):
        ax = figure.add_axes((-0.1, 0.99 - 0.33 * place, 1.2, 0.34), projection="3d")
        draw_surface(ax, mesh, named_colors(mesh, {name: COLORS["roller path"]}), 40, 35)
        figure.text(0.05, 0.97 - 0.33 * (place - 1), name)
        ax.set(xticks=[-0.4, 0.0, 0.4], zticks=[-0.2, 0.0, 0.2])
    figure.savefig(path, dpi=80)


def main(folder: Path) -> None:
    """Draw the study mesh as `shoe.png` and `load_surfaces.png`."""
    draw_shoe(folder / "shoe.png", shoe_mesh("study"))
    draw_load_surfaces(folder / "load_surfaces.png", mesh_named("study"))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent))
