"""A track with its flexible shoes as a time series for ParaView: a PVD file and VTU files beside it."""

from collections.abc import Iterator
from pathlib import Path
from typing import TypeAlias
from xml.etree import ElementTree

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.files import refuse_existing, whole_file, writable_folder
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.placement import Pose, instant, touching
from exudyn_crawler.views.undercarriage import beam_corners, frame_pose, pressing, rollers_surface, rolls
from fem import Mesh, write_vtu
from meshes import mesh_named

SERIES = "track.pvd"
PARTS = "track_parts"
"""Folder of the VTU files, beside the series."""
BOX = np.array([[x, y, z] for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float)
"""Corners of a hexahedron in VTK's order, from -1 to 1."""


def write_paraview(stress: xr.Dataset, history: History, folder: Path, overwrite: bool = False) -> Path:
    """Write the chosen times of a stress study: shoes, terrain, contact forces, side frame and rollers.

    Everything is in place in the global frame. Flexible shoes carry their elastic displacement (m, global
    components, for Warp By Vector) and von Mises stress (Pa) at all nodes of the mesh, rigid ones their
    number, units their heave (m), contacts and treads the force on the shoe (N, for glyphs), rollers their
    number and what they press with on both rails (N).

    Parameters
    ----------
    stress : xarray.Dataset
        As the stress study leaves it.
    folder : Path
        Where `track.pvd` and the folder `track_parts` go.

    Returns
    -------
    Path
        The series, to be opened in ParaView.

    Raises
    ------
    ValueError
        If the nodes of `stress` are not those of the history's mesh.
    FileExistsError
        If the series exists and `overwrite` is false.
    """
    path = folder / SERIES
    refuse_existing(path, overwrite)
    mesh = _mesh(stress, history.case)
    parts = writable_folder(folder / PARTS)
    series = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ElementTree.SubElement(series, "Collection")
    for number, frame in enumerate(stress.frame.values):
        now = instant(history, float(frame))
        around = [*_surroundings(history.case, now), *_side_frame(history.case, now)]
        pieces = [*_flexible_shoes(stress, now, float(frame), mesh), *around]
        for part, (name, content) in enumerate(pieces):
            file = parts / f"{name.replace(' ', '_')}_{number:03d}.vtu"
            with whole_file(file, overwrite) as temporary:
                _write(content, temporary)
            ElementTree.SubElement(
                collection,
                "DataSet",
                timestep=repr(float(frame)),
                part=str(part),
                name=name,
                file=f"{PARTS}/{file.name}",
            )
    ElementTree.indent(series)
    with whole_file(path, overwrite) as temporary:
        ElementTree.ElementTree(series).write(temporary, xml_declaration=True, encoding="utf-8")
    return path


Content: TypeAlias = "meshio.Mesh | tuple[Mesh, dict[str, NDArray], NDArray]"
"""Pieces of the track, or the flexible shoes' mesh with its fields and where its nodes are, m."""


def _write(content: Content, path: Path) -> None:
    if isinstance(content, meshio.Mesh):
        meshio.write(path, content, file_format="vtu")
    else:
        write_vtu(path, *content)


def _mesh(stress: xr.Dataset, case: Case) -> Mesh:
    """Mesh of the flexible shoes."""
    if case.flexible is None:
        raise ValueError("the history has no flexible shoes")
    mesh = mesh_named(case.flexible.mesh)
    nodes = stress.node_position.transpose("node", "axis").values
    if nodes.shape != mesh.nodes.shape or not np.allclose(nodes, mesh.nodes, atol=1e-6):
        raise ValueError(
            f"the {len(nodes)} nodes of the stresses are not the {len(mesh.nodes)} of the mesh "
            f"{case.flexible.mesh!r}"
        )
    return mesh


def _flexible_shoes(
    stress: xr.Dataset, now: xr.Dataset, frame: float, mesh: Mesh
) -> Iterator[tuple[str, Content]]:
    for shoe in stress.shoe.values:
        pose = Pose.of(now, int(shoe))
        chosen = stress.sel(shoe=shoe, frame=frame)
        fields = {
            "displacement": pose.turn(chosen.frame_displacement.transpose("node", "axis").values).astype(
                "f4"
            ),
            "von mises": chosen.frame_von_mises.values.astype("f4"),
        }
        yield f"shoe {shoe}", (mesh, fields, pose.place(mesh.nodes))


def _surroundings(case: Case, now: xr.Dataset) -> Iterator[tuple[str, Content]]:
    """Rigid shoes as boxes, units and contacts."""
    flexible = () if case.flexible is None else case.flexible.shoes
    rigid = [int(shoe) for shoe in now.shoe.values if shoe not in flexible]
    if rigid:
        x0, x1, y0, y1, z0 = case.shoe.footprint
        low, high = np.array([x0, y0, z0]), np.array([x1, y1, case.shoe.load_point[2]])
        box = 0.5 * (low + high) + 0.5 * (high - low) * BOX
        places = np.stack([Pose.of(now, shoe).place(box) for shoe in rigid])
        yield "rigid shoes", _boxes(places, {"shoe": np.array(rigid, dtype=float)})

    terrain = case.terrain
    angles = np.zeros((terrain.unit_count, 3))
    angles[:, terrain.tilt_axis] = terrain.tilts + now.unit_tilt.values
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width, terrain.unit_height])
    boxes = np.tile(half * BOX, (terrain.unit_count, 1, 1))
    if terrain.heights is not None:
        boxes[:, BOX[:, 2] > 0.0, 2] += terrain.top_heights[:, None]
    units = np.einsum("uij,ucj->uci", rotation_matrices(angles), boxes) + terrain.centers[:, None]
    units[:, :, 2] += now.unit_heave.values[:, None]
    yield "terrain", _boxes(units, {"heave": now.unit_heave.values})

    yield from _forces("contacts", *touching(now))


def _side_frame(case: Case, now: xr.Dataset) -> Iterator[tuple[str, Content]]:
    """Side frame as a box, rollers and the strips that press on shoes, of a rolled run."""
    if not rolls(now):
        return
    low, high = beam_corners(case)
    box = 0.5 * (low + high) + 0.5 * (high - low) * BOX
    yield "side frame", _boxes(frame_pose(now).place(box)[None], {})
    points, triangles = rollers_surface(now, case)
    each = len(triangles) // now.sizes["roller"]
    forces = now.roller_force.sum("rail").transpose("roller", "axis").values
    fields = {"roller": [np.repeat(now.roller.values, each)], "force": [np.repeat(forces, each, axis=0)]}
    yield "rollers", meshio.Mesh(points, [("triangle", triangles)], cell_data=fields)
    yield from _forces("treads", *pressing(now))


def _forces(name: str, points: NDArray, forces: NDArray) -> Iterator[tuple[str, Content]]:
    """Forces as vertices, if there are any."""
    if len(points):
        vertices = [("vertex", np.arange(len(points))[:, None])]
        yield name, meshio.Mesh(points, vertices, point_data={"force": forces})


def _boxes(corners: NDArray, fields: dict[str, NDArray]) -> meshio.Mesh:
    """Hexahedra of corners (boxes, 8, 3), with a value of each field a box."""
    cells = np.arange(corners.size // 3).reshape(-1, 8)
    return meshio.Mesh(
        corners.reshape(-1, 3),
        [("hexahedron", cells)],
        cell_data={name: [values] for name, values in fields.items()},
    )
