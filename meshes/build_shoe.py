"""Mesh a shoe of any dimensions: `python -m meshes.build_shoe thick.msh.gz --top-thickness 0.05`.

It needs netgen, which has its own geometry kernel and needs no system libraries.
"""

import argparse
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fem.body.distortion import straighten_distorted
from fem.body.mesh import Mesh
from fem.files.mesh_files import write_mesh
from meshes import mesher
from meshes.geometry import COM_HEIGHT, JOINT_CENTERS, SHOE_SIZES, ShoeDimensions
from meshes.solid import build_solid

FROM_NETGEN = [1, 0, 2, 3, 4, 5, 7, 8, 6, 9]
"""Node order of VTK in netgen's tetrahedra, whose orientation and edge order differ."""
FROM_NETGEN_TRIANGLE = [0, 1, 2, 5, 3, 4]
OTHER_DIMENSIONS = "change the dimensions a little, or the size of the elements"
LEVEL = 1e-5
"""Tolerance within which a face is level, m."""
FLANGE = "flange"
"""Name of the flat part of the flange, which with the roller path forms the top."""


@dataclass(frozen=True)
class ElementSizes:
    """Resolution of a mesh: greatest edge lengths, elements on curves, and growth.

    Attributes
    ----------
    at_bores, at_rear_roots, elsewhere : float
        Greatest edge lengths, m.
    on_curves : float
        Number of elements along a curve's radius.
    growth : float
        Growth of the elements from 0 (even) to 1 (fast).
    """

    at_bores: float
    at_rear_roots: float
    elsewhere: float
    on_curves: float
    growth: float = 0.3


SIZES = {
    "coarse": ElementSizes(0.070, 0.060, 0.22, 0.5),
    "study": ElementSizes(0.035, 0.021, 0.130, 1.0),
    "fine": ElementSizes(0.022, 0.012, 0.085, 1.5),
}
"""Resolutions similar to the ready meshes of these names."""


def name_level_faces(body: Any, heights: Mapping[str, float]) -> None:
    """Name the level faces of a solid at these heights, m; of equal heights the first counts."""
    for face in body.faces:
        low, high = face.bounding_box
        if high.z - low.z > LEVEL:
            continue
        for name, height in heights.items():
            if abs(low.z - height) < LEVEL:
                face.name = name
                break


def _name_faces(body: Any, shoe: ShoeDimensions) -> None:
    """Name underside, roller path and the flange's flat part; the bores are named already."""
    heights = {"underside": 0.0, "roller path": shoe.path_height, FLANGE: shoe.beam_height}
    name_level_faces(body, {name: height - COM_HEIGHT for name, height in heights.items()})
    wanted = ["underside", "roller path", FLANGE, *(f"bore {name}" for name in JOINT_CENTERS)]
    empty = set(wanted) - {face.name for face in body.faces}
    if empty:
        raise ValueError(
            f"dimensions must leave faces for all named surfaces, got none for {sorted(empty)} with {shoe}"
        )


def _set_sizes(body: Any, size: ElementSizes, shoe: ShoeDimensions) -> None:
    """Set small elements on bores, on root fillets of the rear lugs, and on overhanging rails."""
    for face in body.faces:
        low, high = face.bounding_box
        is_root = low.x > shoe.rear_face - 0.05 and high.x < 0.0
        fine = ("bore", "roller path") if shoe.rail_overhang > 0.0 else ("bore",)
        if face.name is not None and face.name.startswith(fine):
            face.maxh = size.at_bores
        elif is_root and LEVEL < high.x - low.x < 1.5 * shoe.rear_root_fillet:
            face.maxh = size.at_rear_roots


def netgen_kernel() -> Any:
    """Return the geometry kernel of netgen; a `ModuleNotFoundError` says how to install it."""
    mesher.require_netgen("meshing a shoe")
    from netgen import occ  # needed only here

    return occ


def mesh_shoe(dimensions: ShoeDimensions | None = None, size: str | ElementSizes = "study") -> Mesh:
    """Mesh a shoe with quadratic tetrahedra whose edges follow bores and fillets.

    Parameters
    ----------
    dimensions : ShoeDimensions, optional
        Dimensions of the shoe; None: the default ones.
    size : str or ElementSizes
        "coarse", "study", "fine", or other element sizes.

    Returns
    -------
    fem.Mesh
        Mesh in shoe axes, with the surfaces "underside", "top", "roller path" and
        "bore front right", "bore front left", "bore rear right", "bore rear left".

    Raises
    ------
    ModuleNotFoundError
        If netgen is not installed.
    ValueError
        If the size is unknown, or the dimensions leave no faces for a surface or make several solids.
    """
    if isinstance(size, str) and size not in SIZES:
        raise ValueError(f"size must be one of {SHOE_SIZES} or ElementSizes, got {size!r}")
    mesher.require_netgen("meshing a shoe")
    resolution = SIZES[size] if isinstance(size, str) else size
    return mesher.call(_meshed, dimensions or ShoeDimensions(), resolution)


def _meshed(shoe: ShoeDimensions, resolution: ElementSizes) -> Mesh:
    """Mesh a shoe in the mesher's process."""
    occ = netgen_kernel()
    body = build_solid(occ, shoe)
    _name_faces(body, shoe)
    _set_sizes(body, resolution, shoe)
    mesh = netgen_mesh(occ, body, resolution)
    return mesh_of_netgen(
        mesh, {"underside": ["underside"], "roller path": ["roller path"], "top": ["roller path", FLANGE]}
    )


def netgen_mesh(occ: Any, body: Any, size: ElementSizes) -> Any:
    """Mesh a solid with curved elements of second order."""
    mesher.begin_step("the meshing of the solid", OTHER_DIMENSIONS)
    mesh = occ.OCCGeometry(body).GenerateMesh(
        maxh=size.elsewhere, grading=size.growth, curvaturesafety=size.on_curves, segmentsperedge=0.5
    )
    mesh.SecondOrder()
    return mesh


def mesh_of_netgen(meshed: Any, surfaces_of: Mapping[str, Sequence[str]]) -> Mesh:
    """Return the mesh of a second-order netgen mesh: the bores, and surfaces by the names of their faces."""
    elements = meshed.Elements3D().NumPy()["nodes"][:, FROM_NETGEN].astype(np.int64) - 1
    sides = meshed.Elements2D().NumPy()
    triangles = sides["nodes"][:, FROM_NETGEN_TRIANGLE].astype(np.int64) - 1
    names = np.array(["", *(face.bcname for face in meshed.FaceDescriptors())])[sides["index"]]
    surfaces = {name: triangles[np.isin(names, faces)] for name, faces in surfaces_of.items()}
    surfaces |= {f"bore {name}": triangles[names == f"bore {name}"] for name in JOINT_CENTERS}
    nodes, _ = straighten_distorted(np.array(meshed.Coordinates()), elements)
    return Mesh(nodes, elements, surfaces)


def main(arguments: Sequence[str] | None = None) -> None:
    """Mesh a shoe into a file."""
    parser = argparse.ArgumentParser(prog="python -m meshes.build_shoe", description=(main.__doc__ or ""))
    parser.add_argument("file", type=Path, help="mesh to write, .msh or .msh.gz")
    parser.add_argument(
        "--size", choices=SHOE_SIZES, default="study", help="fineness of the mesh; default: study"
    )
    for field in dataclasses.fields(ShoeDimensions):
        option = f"--{field.name.replace('_', '-')}"
        parser.add_argument(
            option, type=float, metavar="M", default=field.default, help=f"m; {field.default}"
        )
    options = vars(parser.parse_args(arguments))
    path = options.pop("file")
    size = options.pop("size")
    try:
        mesh = mesh_shoe(ShoeDimensions(**options), size)
    except (ValueError, ModuleNotFoundError) as error:
        parser.error(str(error))
    write_mesh(path, mesh)
    print(f"{path}: {len(mesh.nodes)} nodes, {len(mesh.elements)} elements")


if __name__ == "__main__":
    main()
