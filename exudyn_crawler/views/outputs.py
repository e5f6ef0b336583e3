"""Writers of a run's outputs: one for each output that its case requests."""

from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler import files
from exudyn_crawler.case import CellTerrain
from exudyn_crawler.machines import CaseFile, Outputs
from exudyn_crawler.machines.datasheet.ledger import ORIGINS_FILE, ledger_of
from exudyn_crawler.results import drive_work
from exudyn_crawler.results.checks import roller_path
from exudyn_crawler.results.history import History, catalogue, ground_map, summary
from exudyn_crawler.results.stress import hot_spots, recovery
from exudyn_crawler.views import figures, style, tables
from exudyn_crawler.views.scenes import films, gear, pictures, scene, shoes, track
from fem import Mesh, interrupts
from fem.files import export
from fem.memory import give_back_memory
from meshes import mesh_named

Stresses = recovery.StressResults | None  # of the flexible shoes, if there are any

MOST_DRAWN = 5 * 10**8
"""Size (bytes) of a history above which curves are thinned: 70 s of 13 rigid shoes, stored every 2 ms."""
GROUND = "ground.nc"  # map of the cells of the ground at the end of the run and at chosen times
SERIES, PARTS = "track.pvd", "track_parts"
"""File of the series for ParaView, and folder of its VTU files."""


def write_tables(history: History, stresses: Stresses, folder: Path, outputs: Outputs) -> None:
    """Write the tables of a run: extremes, loads, roller path, work of the drive, stresses."""
    by_name = {"extremes": summary.extremes(history), "loads": summary.load_table(history)}
    if stresses is not None:
        data = stresses.dataset
        spots = stresses.hot_spots
        by_name["highest_stresses"] = hot_spots.highest_by_phase(history, data)
        by_name["highest_by_region"] = hot_spots.region_table(stresses.by_region, data)
        by_name |= {f"hot_spots_shoe_{k}": hot_spots.hot_spot_table(rows, data) for k, rows in spots.items()}
    if roller_path.treads_press(history):
        by_name[figures.ROLLER_PATH] = roller_path.roller_path(history)
    if drive_work.has_works(history):
        by_name[figures.DRIVE_WORK] = drive_work.drive_work(history)
    for name, table in by_name.items():
        tables.write_table(table, folder / f"{name}.csv", overwrite=True)


def write_origins(case_file: CaseFile, folder: Path) -> None:
    """Write the origin of every value of a machine; nothing for a case without a datasheet."""
    if case_file.datasheet is not None:
        table = pd.DataFrame(tables.origin_rows(ledger_of(case_file)), columns=tables.ORIGIN_COLUMNS)
        tables.write_table(table, folder / ORIGINS_FILE, overwrite=True)


def write_forces(history: History, stresses: Stresses, folder: Path, outputs: Outputs) -> None:
    """Write the tables that derive from the forces of the history."""
    names = {
        name: quantity for name, quantity in catalogue.select(files="forces").items() if history.has(name)
    }

    def chunk(part: History) -> xr.Dataset:
        values = (
            (name, part.quantity(name).astype(quantity.dtype, keep_attrs=True))
            for name, quantity in names.items()
        )
        return xr.Dataset(dict(values), attrs=part.dataset.attrs)

    chunks = (chunk(part) for part, _ in history.parts())
    files.write_netcdf_along("time", history.time.size, chunks, folder / "forces.nc", overwrite=True)


def write_figures(history: History, stresses: Stresses, folder: Path, outputs: Outputs) -> None:
    """Write the curves of shoes, links, rollers and flexible shoes, and the ground at the end of the run."""
    terrain = history.case.terrain
    drawn = {}
    if isinstance(terrain, CellTerrain):
        ground = xr.load_dataset(folder / GROUND, engine="h5netcdf")
        drawn["ground"] = pictures.map_figure(history, ground)
        for time in outputs.ground_times:
            drawn[f"ground at {time:g} s"] = pictures.map_figure(history, ground, time)
    elif not terrain.is_even:
        drawn["ground"] = pictures.ground_figure(history, history.duration)
    # the curves of a long run would not fit into memory, and no figure shows every step
    thinned = history.every(-(-history.dataset.nbytes // MOST_DRAWN))
    drawn["ground pressure"] = pictures.pressure_figure(thinned)
    series = figures.history_series(thinned, None if stresses is None else stresses.dataset)
    if stresses is not None:
        of_stress = figures.stress_figures(thinned, stresses.dataset, series)
        drawn |= {f"flexible {name}": figure for name, figure in of_stress.items()}
    if (path := folder / f"{figures.ROLLER_PATH}.csv").is_file():
        drawn[figures.ROLLER_PATH] = figures.roller_path_figure(pd.read_csv(path), history.case.name)
    if (path := folder / f"{figures.DRIVE_WORK}.csv").is_file():
        drawn[figures.DRIVE_WORK] = figures.drive_work_figure(pd.read_csv(path), history.case.name)
    drawn |= figures.run_figures(thinned, outputs.drawn_shoes(history.case.track.shoe_count), series)
    for name in [*drawn]:
        file = f"{name.replace(' ', '_')}.{outputs.figure_format}"
        figure = drawn.pop(name)
        style.save_figure(figure, folder / file, overwrite=True)
        # reference cycles keep 10 MB of pixels and curves alive in each figure
        figure.clear()


def write_pictures(history: History, stresses: Stresses, folder: Path, outputs: Outputs) -> None:
    """Write pictures of stressed shoes at the chosen times."""
    if stresses is not None:
        shoes.write_stress_pictures(stresses.dataset, history, folder, overwrite=True)


def write_3d(history: History, stresses: Stresses, folder: Path, outputs: Outputs) -> None:
    """Write files for ParaView: the track at the chosen times, and the greatest stress at each node."""
    if stresses is None:
        return
    for shoe in stresses.dataset.shoe.values:
        data = stresses.dataset.sel(shoe=shoe)
        fields = {
            "greatest von Mises": data.peak_von_mises.values,
            "time of the greatest": data.peak_time.values,
            "range of von Mises": (data.peak_von_mises - data.least_von_mises).values,
            "error of the mesh over the stress": data.peak_mesh_error.values,
            "verdict": data.peak_verdict.values,
        }
        with files.whole_file(folder / f"fields_shoe_{shoe}.vtu", overwrite=True) as temporary:
            export.write_vtu(temporary, stresses.whole.mesh, fields)
    write_paraview(stresses.dataset, history, folder, overwrite=True)


def write_paraview(stress: xr.Dataset, history: History, folder: Path, overwrite: bool = False) -> Path:
    """Write the chosen times of a stress study as `track.pvd`, whose path is returned, and `track_parts`.

    All points are in the global frame. Flexible shoes have their elastic displacement (m, global components,
    for Warp By Vector) and von Mises stress (Pa) at all nodes of the mesh. Rigid shoes have their number,
    units their heave (m), the surface of cells its height and sinkage (m). Contacts and treads have the force
    on the shoe (N, for glyphs), rollers their number and their force on both rails (N).

    Raises ValueError if the nodes of `stress` are not those of the history's mesh, FileExistsError if the
    series exists and `overwrite` is false.
    """
    path = folder / SERIES
    files.refuse_existing(path, overwrite)
    if history.case.flexible is None:
        raise ValueError("the history must have flexible shoes")
    name = history.case.flexible.mesh
    nodes = stress.node_position.transpose("node", "axis").values
    mesh = mesh_named(name)
    if nodes.shape != mesh.nodes.shape or not np.allclose(nodes, mesh.nodes, atol=1e-6):
        of_mesh = f"the {len(mesh.nodes)} of the mesh {name!r}"
        raise ValueError(f"the {len(nodes)} nodes of the stresses are not {of_mesh}")
    parts = files.writable_folder(folder / PARTS)
    series = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ElementTree.SubElement(series, "Collection")
    for number, frame in enumerate(stress.frame.values):
        moment = track.instants(history, [float(frame)])
        flexible = _flexible_shoes(stress.sel(frame=frame), moment.dataset.isel(time=0), mesh)
        for part, (name, content) in enumerate([*flexible, *_track(moment)]):
            file = parts / f"{name.replace(' ', '_')}_{number:03d}.vtu"
            with files.whole_file(file, overwrite) as temporary:
                meshio.write(temporary, content, file_format="vtu")
            where = {"timestep": repr(float(frame)), "part": str(part), "name": name}
            ElementTree.SubElement(collection, "DataSet", where, file=f"{PARTS}/{file.name}")
    ElementTree.indent(series)
    with files.whole_file(path, overwrite) as temporary:
        ElementTree.ElementTree(series).write(temporary, xml_declaration=True, encoding="utf-8")
    return path


def _flexible_shoes(stress: xr.Dataset, now: xr.Dataset, mesh: Mesh) -> Iterator[tuple[str, meshio.Mesh]]:
    """Yield name and elements of every flexible shoe at its pose."""
    for shoe in stress.shoe.values:
        place = track.shoe_pose(now, int(shoe))
        chosen = stress.sel(shoe=shoe)
        bend = chosen.frame_displacement.transpose("node", "axis").values @ place.turn.T
        fields = {"displacement": bend.astype("f4"), "von mises": chosen.frame_von_mises.values.astype("f4")}
        yield f"shoe {shoe}", export.vtu_content(mesh, fields, place.place(mesh.nodes))


def _track(moment: History) -> Iterator[tuple[str, meshio.Mesh]]:
    """Yield the solids around the flexible shoes at one instant."""
    for solid in track.shoe_boxes(moment):
        if solid.name == "rigid shoes":
            numbers = [float(label.removeprefix("shoe ")) for label in solid.labels]
            yield solid.name, _cells(solid, shoe=np.array(numbers))
    yield "terrain", _ground(moment)
    pressing = track.single_forces(moment.dataset)
    yield from _vertices("contacts", *pressing.pop("contacts")[:2])
    of_rollers = _roller_fields(moment)
    for solid in gear.gear_solids(moment):
        yield solid.name, _cells(solid, **(of_rollers if solid.name == "rollers" else {}))
    for name, (places, forces, _) in pressing.items():
        yield from _vertices(name, places, forces)


def _roller_fields(moment: History) -> dict[str, np.ndarray]:
    """Return number and force of every roller of an open track at an instant, repeated for its treads."""
    if not moment.has("roller_force"):
        return {}
    force = moment.roller_force.isel(time=0).sum("rail").transpose("roller", "axis")
    count = moment.dataset.sizes["rail"]
    return {
        "roller": np.repeat(moment.roller.values, count),
        "force": np.repeat(force.values, count, axis=0),
    }


def _ground(moment: History) -> meshio.Mesh:
    """Return units as boxes with their heave (m), or cells as a surface with its height and sinkage (m)."""
    if not isinstance(moment.case.terrain, CellTerrain):
        return _cells(track.ground_units(moment), heave=moment.unit_heave.isel(time=0).values)
    solid = track.ground_faces(moment).at()
    depth = moment.ground_depth.values.ravel()
    return meshio.Mesh(
        solid.points, [("quad", solid.faces[0])], point_data={"height": solid.points[:, 2], "sinkage": depth}
    )


def _cells(solid: scene.Solid, **fields: np.ndarray) -> meshio.Mesh:
    """Return all copies of a solid, boxes as hexahedra, others as triangles; `fields` have a value a copy."""
    surface = solid.at()
    is_box = len(solid.points) == 8
    cells = np.arange(len(surface.points)).reshape(-1, 8) if is_box else surface.triangles
    data = {name: [values[cells[:, 0] // len(solid.points)]] for name, values in fields.items()}
    return meshio.Mesh(surface.points, [("hexahedron" if is_box else "triangle", cells)], cell_data=data)


def _vertices(name: str, places: np.ndarray, forces: np.ndarray) -> Iterator[tuple[str, meshio.Mesh]]:
    """Yield the forces (1, n, 3) of one kind as vertices at their points, if there are any."""
    if (acts := forces[0].any(axis=-1)).any():
        vertices = [("vertex", np.arange(acts.sum())[:, None])]
        yield name, meshio.Mesh(places[0][acts], vertices, point_data={"force": forces[0][acts]})


def write_film(history: History, stresses: Stresses, folder: Path, outputs: Outputs) -> None:
    """Write an animation of the track on its deforming terrain."""
    films.write_animation(history, folder / "track.mp4", overwrite=True)


def write_page(history: History, stresses: Stresses, folder: Path, outputs: Outputs) -> None:
    """Write the report of the run as one page."""
    # the modules of pages load slowly, and sweeps write no pages of their runs
    from exudyn_crawler.views.pages.report import write_report

    write_report(folder, overwrite=True, loaded={folder / files.HISTORY: history})


WRITERS: dict[str, Callable[[History, Stresses, Path, Outputs], None]] = {
    "tables": write_tables,
    "forces": write_forces,
    "figures": write_figures,
    "pictures": write_pictures,
    "paraview": write_3d,
    "animation": write_film,
    "page": write_page,
}
"""Writers by the output that requests them, in the order of writing."""


def write_outputs(history: History, stresses: Stresses, folder: Path, outputs: Outputs) -> None:
    """Write stresses, the map of the ground, and all further outputs that are requested."""
    if stresses is not None:
        files.write_netcdf(stresses.dataset, folder / "stress.nc", overwrite=True)
    if isinstance(history.case.terrain, CellTerrain):
        files.write_netcdf(
            ground_map.ground_map(history, outputs.ground_times), folder / GROUND, overwrite=True
        )
    with interrupts.interrupts_remembered() as ask:
        for output, write in WRITERS.items():
            if getattr(outputs, output):
                write(history, stresses, folder, outputs)
                give_back_memory()
                ask()
