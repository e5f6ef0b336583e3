"""A track with its flexible shoes as a time series for ParaView: a PVD file and VTU files beside it."""

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.files import refuse_existing, whole_file, writable_folder
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.scenes import track
from exudyn_crawler.views.scenes.scene import Solid
from fem import Mesh
from fem.export import vtu_content
from meshes import mesh_named

SERIES = "track.pvd"
PARTS = "track_parts"
"""Folder of the VTU files, beside the series."""


def write_paraview(stress: xr.Dataset, history: History, folder: Path, overwrite: bool = False) -> Path:
    """Write the chosen times of a stress study: `track.pvd`, which is returned, and `track_parts`.

    Everything is in place in the global frame. Flexible shoes carry their elastic displacement (m, global
    components, for Warp By Vector) and von Mises stress (Pa) at all nodes of the mesh, rigid ones their
    number, units their heave (m), contacts and treads the force on the shoe (N, for glyphs), rollers their
    number and what they press with on both rails (N).

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
        moment = track.instants(history, [float(frame)])
        flexible = _flexible_shoes(stress.sel(frame=frame), moment.isel(time=0), mesh)
        for part, (name, content) in enumerate([*flexible, *_track(history.case, moment)]):
            file = parts / f"{name.replace(' ', '_')}_{number:03d}.vtu"
            with whole_file(file, overwrite) as temporary:
                meshio.write(temporary, content, file_format="vtu")
            where = {"timestep": repr(float(frame)), "part": str(part), "name": name}
            ElementTree.SubElement(collection, "DataSet", where, file=f"{PARTS}/{file.name}")
    ElementTree.indent(series)
    with whole_file(path, overwrite) as temporary:
        ElementTree.ElementTree(series).write(temporary, xml_declaration=True, encoding="utf-8")
    return path


def _mesh(stress: xr.Dataset, case: Case) -> Mesh:
    """Mesh of the flexible shoes."""
    if case.flexible is None:
        raise ValueError("the history has no flexible shoes")
    mesh, nodes = mesh_named(case.flexible.mesh), stress.node_position.transpose("node", "axis").values
    if nodes.shape != mesh.nodes.shape or not np.allclose(nodes, mesh.nodes, atol=1e-6):
        raise ValueError(
            f"the {len(nodes)} nodes of the stresses are not the {len(mesh.nodes)} of the mesh "
            f"{case.flexible.mesh!r}"
        )
    return mesh


def _flexible_shoes(stress: xr.Dataset, now: xr.Dataset, mesh: Mesh) -> Iterator[tuple[str, meshio.Mesh]]:
    """All elements of every flexible shoe, in place."""
    for shoe in stress.shoe.values:
        place, chosen = track.shoe_pose(now, int(shoe)), stress.sel(shoe=shoe)
        bend = chosen.frame_displacement.transpose("node", "axis").values @ place.turn.T
        fields = {"displacement": bend.astype("f4"), "von mises": chosen.frame_von_mises.values.astype("f4")}
        yield f"shoe {shoe}", vtu_content(mesh, fields, place.place(mesh.nodes))


def _track(case: Case, moment: xr.Dataset) -> Iterator[tuple[str, meshio.Mesh]]:
    """What is around the flexible shoes in one instant."""
    now = moment.isel(time=0)
    for solid in track.shoe_boxes(case, moment):
        if solid.name == "rigid shoes":
            numbers = [float(label.removeprefix("shoe ")) for label in solid.labels]
            yield solid.name, _cells(solid, shoe=np.array(numbers))
    yield "terrain", _cells(track.ground_units(case, moment), heave=now.unit_heave.values)
    yield from _forces("contacts", *track.touching(now))
    if track.rolls(now):
        beam = track.beam(case, moment)
        yield beam.name, _cells(beam)
        treads = now.roller_force.sum("rail").transpose("roller", "axis"), now.roller
        force, number = (np.repeat(one.values, now.sizes["rail"], axis=0) for one in treads)
        yield "rollers", _cells(track.rollers(case, moment)[0], roller=number, force=force)
        yield from _forces("treads", *track.pressing(now))


def _cells(solid: Solid, **fields: NDArray) -> meshio.Mesh:
    """Copies of a solid, boxes as hexahedra and others as triangles, with values of each field a copy."""
    surface, is_box = solid.at(), len(solid.points) == 8
    cells = np.arange(len(surface.points)).reshape(-1, 8) if is_box else surface.triangles
    data = {name: [values[cells[:, 0] // len(solid.points)]] for name, values in fields.items()}
    return meshio.Mesh(surface.points, [("hexahedron" if is_box else "triangle", cells)], cell_data=data)


def _forces(name: str, points: NDArray, forces: NDArray) -> Iterator[tuple[str, meshio.Mesh]]:
    """Forces as vertices, if there are any."""
    if len(points):
        vertices = [("vertex", np.arange(len(points))[:, None])]
        yield name, meshio.Mesh(points, vertices, point_data={"force": forces})
