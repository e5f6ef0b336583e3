"""Kinds of files that users write or other programs do: a valid content each, what reads and what runs it."""

import io
import tempfile
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import xarray as xr

import exudyn_crawler as crawler
from exudyn_crawler import Case, History, read_case, read_duty, simulate
from exudyn_crawler.assess_run import assess
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.co_simulation import SteppedRun
from exudyn_crawler.ground.cells.laws import bekker, read_law
from exudyn_crawler.machines import CaseFile
from exudyn_crawler.machines.case_file import case_text
from exudyn_crawler.machines.datasheet.discrepancies import implausible_values
from exudyn_crawler.machines.datasheet.library import machines
from exudyn_crawler.model import flexible_shoes
from exudyn_crawler.results.checks.cases import read_check
from exudyn_crawler.results.measured import drawbar, series, soil_fit
from exudyn_crawler.run.solve.standing import standing
from exudyn_crawler.shoe_file import shoe_of
from exudyn_crawler.sweep.definition import Sweep
from exudyn_crawler.sweep.scatter import read_scatter
from exudyn_crawler.views import style
from fem import read_volume
from meshes import mesh_named
from tests import file_contents as contents
from tests.results import soils
from tests.small_shoe import SMALL_SHOE
from tests.stress_results import short_run

MOMENT = 0.02  # s, of a run
RUN, SAND_RUN = "run.nc", "sand.nc"
"""Histories of a track beside the files: with flexible shoes, and on sand."""


def nothing(_path: Path) -> None:
    """Do no more than read."""


@dataclass(frozen=True)
class Kind:
    """Kind of file: its name, a valid content, what a command does before it works, and what it does then."""

    name: str
    content: bytes
    read: Callable[[Path], Any]
    run: Callable[[Path], Any] = nothing
    beside: Mapping[str, str] = field(default_factory=dict)  # texts of the files that go with it, by name
    made: Callable[[str], bytes] | None = None  # file of the content, which is a text, of binary files


def heights_of(text: str) -> tuple[dict[str, Any], np.ndarray]:
    """Values of such a text, and heights."""
    told = tomllib.loads(text)
    columns = min(int(told["columns"]), 2000)
    rows = min(int(told["rows"]), 2000)
    x, y = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    heights = told["offset"] + told["amplitude"] * np.sin(0.3 * x) * np.cos(0.2 * y)
    heights[:1, :1] = told["missing"]
    return told, heights.astype(told["kind"])


def netcdf_of(text: str) -> bytes:
    """NetCDF file of such a text."""
    told, heights = heights_of(text)
    places = {
        told[axis]: (
            told[axis],
            told[f"{axis}_first"] + told[f"{axis}_step"] * np.arange(count),
            {"units": told["place_unit"]},
        )
        for axis, count in zip("xy", heights.shape, strict=True)
    }
    attributes = {"units": told["height_unit"], "_FillValue": heights.dtype.type(told["missing"])}
    data = xr.Dataset({told["height"]: ((told["x"], told["y"]), heights, attributes)}, places)
    return bytes(data.to_netcdf(engine="h5netcdf"))


def npy_of(text: str) -> bytes:
    """NPY file of such a text, whose missing height is NaN."""
    told, heights = heights_of(text)
    if heights.dtype.kind == "f":
        heights[:1, :1] = np.nan
    held = io.BytesIO()
    np.save(held, heights if told["x"] != "y" else heights.T)
    return held.getvalue()


def _case(path: Path) -> None:
    file = read_case(path)
    checks.warn_of(implausible_values(file))


def _run_case(path: Path) -> None:
    """Run a case as the command does, for a moment."""
    file = read_case(path)
    if file.case.gear.frame_parts:
        rest = standing(file.case)
        checks.warn_of(() if rest is None else rest.warnings)
    simulate(file.case, min(file.duration, MOMENT), progress=False)


def _beside(read: Callable[[Path], None], name: str = "case.toml") -> Callable[[Path], None]:
    """What reads the file beside that names the changed one."""
    return lambda path: read(path.with_name(name))


def _warned(read: Callable[[Path], Any]) -> Callable[[Path], None]:
    """What reads a file and warns of its values."""
    return lambda path: checks.warn_of(checks.out_of_range(read(path)))


def _draw_law(path: Path) -> None:
    with style.titled_figure("law", 8.0, 3.2) as figure:
        read_law(path).draw(*figure.subplots(1, 2))


def _step_unit(path: Path) -> None:
    """Step the unit of co-simulation of a case."""
    run = SteppedRun(read_case(path).case, np.zeros(6))
    for _ in range(2):
        run.advance(0.5 * MOMENT, 0.01, np.zeros(6))


def _pulled(path: Path) -> CaseFile:
    return drawbar.pulled_case(read_case(path), drawbar.DrawbarTest(drawbar.SLIPS, 0.0))


def _run_pulled(path: Path) -> None:
    simulate(_pulled(path).case, MOMENT, progress=False)


def _run_sweep(path: Path) -> None:
    """Run the first of a sweep's runs for a moment, or all of a scatter of lives, which need none."""
    plan = read_scatter(path)
    if isinstance(plan, Sweep):
        case_file, _, _ = plan.case_of(plan.planned[0].values)
        simulate(case_file.case, MOMENT, progress=False)
    else:
        plan.lives()


def _planned(path: Path) -> None:
    assert read_scatter(path).planned


def _life(path: Path) -> None:
    crawler.life(path)


def _check_cases(path: Path) -> None:
    crawler.check_cases(path, pictures=False)


def _assess(path: Path) -> None:
    assess(path)


def _compare(path: Path) -> None:
    series.compare(History.load(path.with_name(RUN)), path)


def _fit_plates(path: Path) -> None:
    soil_fit.warn(soil_fit.fit_files(path, base=bekker.BekkerSoil.lete_sand()))


def _fit_shear(path: Path) -> None:
    soil_fit.warn(soil_fit.fit_files(path.with_name("plates.csv"), path))


def _shoe(path: Path) -> None:
    crawler.Shoe.from_mesh(path)


def _bend(path: Path) -> None:
    """Make flexible shoes of a mesh, as far as a run does before it reduces them."""
    case = Case.stress(SMALL_SHOE).with_({"shoe": crawler.Shoe.from_mesh(path), "flexible.mesh": str(path)})
    flexible_shoes.check_shoe(case)


def _mesh_content(suffix: str, form: str, **how: Any) -> bytes:
    """Coarse mesh of the shoe in a format of meshio's."""
    mesh = mesh_named(SMALL_SHOE)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        if form == "stl":
            corners = mesh.boundary[:, :3]
            meshio.write(path, meshio.Mesh(mesh.nodes, [("triangle", corners)]), "stl", binary=False)
            return path.read_bytes()
        cells = [("tetra10" if mesh.order == 2 else "tetra", mesh.elements)]
        tags = [np.ones(len(mesh.elements), dtype=int)]
        names = {"solid": np.array([1, 3])}
        for number, (name, faces) in enumerate(mesh.surfaces.items(), start=2):
            cells.append(("triangle6" if mesh.order == 2 else "triangle", faces))
            tags.append(np.full(len(faces), number))
            names[name] = np.array([number, 2])
        data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
        meshio.write(path, meshio.Mesh(mesh.nodes, cells, cell_data=data, field_data=names), form, **how)
        return path.read_bytes()


def prepare(folder: Path) -> None:
    """Write the histories that some kinds need into a folder."""
    short_run(MOMENT).save(folder / RUN)
    sand = Case.rolled().on_cells(bekker.BekkerSoil.lete_sand())
    simulate(sand, MOMENT, progress=False).save(folder / SAND_RUN)


def case_kinds() -> list[Kind]:
    """Case files with all their values, and datasheets."""
    on_sand = Case.closed().on_cells(bekker.BekkerSoil.lete_sand())
    named = {
        "dragged": Case.translation(),
        "turned": Case.turning(),
        "stressed": Case.stress(SMALL_SHOE),
        "rolled": Case.rolled(),
        "cells": Case.rolled().on_cells(bekker.BekkerSoil.lete_sand()),
        "closed": Case.closed(),
        "machine": Case.shovel(),
        "excavator": read_case(machines()["pc300lc"]).case,
        "vehicle": read_case(machines()["m113"]).case,
    }
    texts = {name: case_text(CaseFile(case=case, duration=MOMENT)) for name, case in named.items()}
    kinds = [Kind(f"{name}.toml", text.encode(), _case, _run_case) for name, text in texts.items()]
    kinds += [
        Kind(f"{name}_sheet.toml", machines()[name].read_bytes(), _case, _run_case) for name in machines()
    ]
    kinds.append(Kind("unit.toml", texts["rolled"].encode(), _case, _step_unit))
    sand_text = case_text(CaseFile(case=on_sand, duration=MOMENT))
    kinds.append(Kind("drawbar.toml", sand_text.encode(), lambda path: _pulled(path) and None, _run_pulled))
    return kinds


def table_kinds() -> list[Kind]:
    """Files of parameters beside cases, and tables of numbers."""
    plates = soils.plate_text(soils.plates(0.01))
    loads = {"case.toml": contents.LOADS_CASE}
    load_cases = files("exudyn_crawler.assessment").joinpath("load_cases.toml").read_bytes()
    of_case = _beside(_case)
    run_beside = _beside(_run_case)
    of_assessment = {"assessed.toml": contents.LOAD_CASES_OF}
    return [
        Kind("law.toml", contents.LAW.encode(), _warned(read_law), _draw_law),
        Kind("named_law.toml", contents.LAW.encode(), of_case, run_beside, {"case.toml": contents.LAW_CASE}),
        Kind("duty.toml", contents.DUTY.encode(), _warned(read_duty), _life),
        Kind("check.toml", contents.CHECK.encode(), _warned(read_check), _check_cases),
        Kind("sweep.toml", contents.SWEEP.encode(), _planned, _run_sweep),
        Kind("scatter.toml", contents.SCATTER.encode(), _planned, _run_sweep, {"duty.toml": contents.DUTY}),
        Kind("cycle.toml", contents.PHASES.encode(), of_case, run_beside, loads),
        Kind("assessment.toml", contents.ASSESSMENT.encode(), _assess),
        Kind("load_cases.toml", load_cases, _beside(_assess, "assessed.toml"), beside=of_assessment),
        Kind("loads.csv", contents.TABLE.encode(), of_case, run_beside, loads),
        Kind("measured.csv", contents.MEASURED.encode(), _compare),
        Kind("plates.csv", plates.encode(), _fit_plates),
        Kind(
            "shear.csv",
            soils.shear_text(soils.shear(0.01)).encode(),
            _fit_shear,
            beside={"plates.csv": plates},
        ),
    ]


def map_kinds() -> list[Kind]:
    """Measured heights, and ground of an earlier run."""
    how: dict[str, Any] = {"read": _beside(_case), "run": _beside(_run_case)}
    return [
        Kind("map.asc", contents.GRID.encode(), **how, beside={"case.toml": contents.MAP_CASE}),
        Kind(
            "map.nc", contents.NETCDF.encode(), **how, beside={"case.toml": contents.MAP_CASE}, made=netcdf_of
        ),
        Kind(
            "map.npy", contents.NETCDF.encode(), **how, beside={"case.toml": contents.PLAIN_MAP}, made=npy_of
        ),
    ]


def mesh_kinds() -> list[Kind]:
    """Meshes of a block and of a shoe, in formats of other programs."""
    ascii_mesh = _mesh_content(".msh", "gmsh22", binary=False)
    return [
        Kind("block.inp", contents.DECK.encode(), read_volume),
        Kind("shoe.msh", ascii_mesh, _shoe, _bend),
        Kind("binary.msh", _mesh_content(".msh", "gmsh22", binary=True), _shoe, _bend),
        Kind("shoe.stl", _mesh_content(".stl", "stl"), shoe_of),
    ]


def run_kinds(folder: Path) -> list[Kind]:
    """Histories of runs, which must be prepared in the folder."""
    sand = (folder / SAND_RUN).read_bytes()
    return [
        Kind("history.nc", (folder / RUN).read_bytes(), History.load),
        Kind("ruts.nc", sand, _beside(_case), _beside(_run_case), {"case.toml": contents.RUTS_CASE}),
    ]
