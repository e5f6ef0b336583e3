"""Build the shoe's meshes: `python -m meshes.build_shoe [size ...]`; needs gmsh (extra `mesh`)."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fem.mesh import TETRA_EDGES, Floats, Integers, Mesh, jacobian_determinants
from fem.mesh_files import write_mesh
from meshes.geometry import COM_HEIGHT, JOINT_CENTERS, ShoeDimensions
from meshes.solid import build_solid

FOLDER = Path(__file__).parent
GMSH_TETRA10, GMSH_TRIANGLE6 = 11, 9
GMSH_TO_MESHIO = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
LEAST_JACOBIAN_RATIO = 0.15
"""Elements whose Jacobian varies more than this from node to node get straight edges."""


@dataclass(frozen=True)
class Resolution:
    """Edge lengths of the elements in m, and the distance over which they grow in between."""

    at_bores: float
    at_rear_roots: float
    at_curves: float
    elsewhere: float
    growth: float


SIZES = {
    "coarse": Resolution(0.070, 0.060, 0.14, 0.22, 0.10),
    "study": Resolution(0.035, 0.021, 0.080, 0.130, 0.12),
    "fine": Resolution(0.022, 0.012, 0.040, 0.085, 0.15),
}


def _is_bore(model: Any, face: int, shoe: ShoeDimensions) -> str | None:
    """Name of the joint whose bore the cylindrical face belongs to, if any."""
    if model.getType(2, face) != "Cylinder":
        return None
    low, high = np.reshape(model.getBoundingBox(2, face), (2, 3))
    for name, center in JOINT_CENTERS.items():
        across = np.array([low[0], high[0], low[2], high[2]])
        at = np.array([center[0], center[0], center[2], center[2]])
        reach = shoe.bore_radius * np.array([-1, 1, -1, 1])
        near = abs((low[1] + high[1]) / 2 - center[1]) < 2 * shoe.rear_lug_width
        if near and np.allclose(across, at + reach, atol=1e-3):
            return name
    return None


def _named_faces(model: Any, shoe: ShoeDimensions) -> dict[str, list[int]]:
    names: dict[str, list[int]] = {"underside": [], "top": [], "roller path": []}
    names |= {f"bore {name}": [] for name in JOINT_CENTERS}
    for _, face in model.getEntities(2):
        low, high = np.reshape(model.getBoundingBox(2, face), (2, 3))
        height = low[2] + COM_HEIGHT
        if high[2] - low[2] < 1e-5:
            if abs(height) < 1e-5:
                names["underside"].append(face)
            if abs(height - shoe.rail_height) < 1e-5:
                names["roller path"].append(face)
            if min(abs(height - h) for h in (shoe.rail_height, shoe.beam_height)) < 1e-5:
                names["top"].append(face)
        elif joint := _is_bore(model, face, shoe):
            names[f"bore {joint}"].append(face)
    empty = [name for name, faces in names.items() if not faces]
    if empty:
        raise ValueError(
            f"dimensions must leave faces for all named surfaces, got none for {empty} with {shoe}"
        )
    return names


def _set_sizes(model: Any, bores: list[int], size: Resolution, shoe: ShoeDimensions) -> None:
    """Small elements on bores, root fillets and noses, growing with the distance from them."""
    curved = [tag for _, tag in model.getEntities(2) if model.getType(2, tag) != "Plane"]
    boxes = {tag: np.reshape(model.getBoundingBox(2, tag), (2, 3)) for tag in curved}
    roots = [tag for tag, (low, high) in boxes.items() if low[0] > shoe.rear_face - 0.05 and high[0] < 0.0]
    field = model.mesh.field
    thresholds = []
    for faces, fine in (
        (bores, size.at_bores),
        (roots, size.at_rear_roots),
        (curved, size.at_curves),
    ):
        distance = field.add("Distance")
        field.setNumbers(distance, "SurfacesList", faces)
        field.setNumber(distance, "Sampling", 20)
        threshold = field.add("Threshold")
        field.setNumber(threshold, "InField", distance)
        field.setNumber(threshold, "SizeMin", fine)
        field.setNumber(threshold, "SizeMax", size.elsewhere)
        field.setNumber(threshold, "DistMin", fine)
        field.setNumber(threshold, "DistMax", size.growth)
        thresholds.append(threshold)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", thresholds)
    field.setAsBackgroundMesh(least)


def straighten_distorted(nodes: Floats, elements: Integers) -> tuple[Floats, int]:
    """Give straight edges to those elements that a curved edge turns inside out.

    Parameters
    ----------
    nodes : array (n, 3)
        Coordinates in m.
    elements : int array (m, 10)
        Node numbers.

    Returns
    -------
    nodes : array (n, 3)
        Coordinates with the mid-side nodes moved.
    count : int
        Number of elements that were straightened.
    """
    nodes = nodes.copy()
    straightened = 0
    while True:
        determinant = jacobian_determinants(nodes, elements)
        bad = determinant.min(axis=1) < LEAST_JACOBIAN_RATIO * determinant.max(axis=1)
        middles = nodes[elements[:, TETRA_EDGES]].mean(axis=2)
        bent = np.linalg.norm(nodes[elements[:, 4:]] - middles, axis=2).max(axis=1)
        bad &= bent > 1e-9
        if not bad.any():
            return nodes, straightened
        nodes[elements[bad, 4:]] = middles[bad]
        straightened += int(bad.sum())


def mesh_shoe(size: Resolution, shoe: ShoeDimensions | None = None) -> Mesh:
    """Mesh the shoe with quadratic tetrahedra whose edges follow bores and fillets.

    Parameters
    ----------
    size : Resolution
    shoe : ShoeDimensions, optional
        The default ones if left out.

    Returns
    -------
    fem.Mesh
        In shoe axes, with the surfaces "underside", "top", "roller path" and
        "bore front right", "bore front left", "bore rear right", "bore rear left".

    Raises
    ------
    ValueError
        If the dimensions leave no faces for a surface or make several solids.
    """
    import gmsh  # wanted only here: it needs system libraries that no study shall need

    shoe = shoe or ShoeDimensions()
    gmsh.initialize()
    try:
        for name, value in {
            "General.Terminal": 0,
            "General.NumThreads": 1,
            "Mesh.MeshSizeExtendFromBoundary": 0,
            "Mesh.MeshSizeFromPoints": 0,
            "Mesh.MeshSizeFromCurvature": 0,
        }.items():
            gmsh.option.setNumber(name, value)
        gmsh.model.add("shoe")
        build_solid(gmsh.model.occ, shoe)
        gmsh.model.occ.synchronize()
        faces = _named_faces(gmsh.model, shoe)
        bores = [f for name, tags in faces.items() if name.startswith("bore") for f in tags]
        _set_sizes(gmsh.model, bores, size, shoe)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.optimize("Netgen")
        gmsh.model.mesh.setOrder(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, numbers = gmsh.model.mesh.getElementsByType(GMSH_TETRA10)
        triangles = {
            name: np.concatenate([gmsh.model.mesh.getElementsByType(GMSH_TRIANGLE6, f)[1] for f in tags_])
            for name, tags_ in faces.items()
        }
    finally:
        gmsh.finalize()
    used = np.unique(numbers)
    place = np.argsort(tags)[np.searchsorted(np.sort(tags), used)]
    elements = np.searchsorted(used, numbers).reshape(-1, 10)[:, GMSH_TO_MESHIO]
    nodes, _ = straighten_distorted(coordinates.reshape(-1, 3)[place], elements)
    surfaces = {name: np.searchsorted(used, t).reshape(-1, 6) for name, t in triangles.items()}
    return Mesh(nodes, elements, surfaces)


def main(sizes: list[str]) -> None:
    """Write the ready meshes of the named sizes, or of all."""
    for name in sizes or SIZES:
        mesh = mesh_shoe(SIZES[name])
        path = FOLDER / f"shoe_{name}.msh.gz"
        write_mesh(path, mesh)
        print(f"{path.name}: {len(mesh.nodes)} nodes, {len(mesh.elements)} elements")


if __name__ == "__main__":
    main(sys.argv[1:])
