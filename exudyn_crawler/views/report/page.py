"""One self-contained page of a run's folder, to be read offline in a browser."""

import json
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd
import xarray as xr
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from exudyn_crawler.case.text import case_table
from exudyn_crawler.files import whole_file
from exudyn_crawler.results.contacts import terrain_deformation
from exudyn_crawler.results.history import History
from exudyn_crawler.views.report.pictures import embedded_picture
from exudyn_crawler.views.report.plots import (
    first_plots,
    packed_case,
    page_colours,
    points_a_series,
    thinning,
)
from exudyn_crawler.views.report.shoes import packed_shoes
from exudyn_crawler.views.report.tables import comparison_rows, hot_spot_table, html_table
from exudyn_crawler.views.series import dataset_series
from exudyn_crawler.views.stress_pictures import PICTURES, write_stress_pictures
from studies.comparison import summary

REPORT = "report.html"
SECTIONS = (
    ("comparison", "Paper against computed", "comparison"),
    ("histories", "Time histories", "has_series"),
    ("hot-spots", "Hot spots", "hot_spots"),
    ("shoes", "Flexible shoes in 3D", "has_shoes"),
    ("pictures", "Stress pictures", "pictures"),
    ("tables", "Further tables", "tables"),
    ("case", "Case", None),
)
"""Anchor and heading of each section, and what there must be for it to be shown."""


def write_report(folder: Path, out: Path | None = None, overwrite: bool = False) -> Path:
    """Write the report of a run's folder: whatever of comparison, histories, stresses and case is there.

    Parameters
    ----------
    folder : Path
        What a study or a run left.
    out : Path, optional
        File to write; `report.html` in the folder if not given.
    overwrite : bool
        Replace an earlier report.

    Returns
    -------
    Path
        The report.

    Raises
    ------
    NotADirectoryError
        If there is no such folder.
    FileNotFoundError
        If it holds neither a history nor a comparison.
    FileExistsError
        If the report exists and `overwrite` is false.
    ValueError
        If a file of the folder does not hold what its name says.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise NotADirectoryError(f"no folder {folder}")
    out = folder / REPORT if out is None else Path(out)
    if out.exists() and not overwrite:
        raise FileExistsError(f"{out} exists; ask for overwriting to replace it")
    page = report_page(folder)
    with whole_file(out, overwrite) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return out


def report_page(folder: Path) -> str:
    """HTML of the report; raises as `write_report`."""
    histories, variables = _histories(folder)
    stress, comparison = _stress(folder), _comparison(folder)
    if not variables and comparison is None:
        raise FileNotFoundError(f"{folder} holds neither a history nor a comparison.csv to report on")
    owner = next((one for one in histories.values() if one.case.flexible is not None), None)
    found = {
        name: dataset_series(dataset, stress if owner is None or name == owner.case.name else None)
        for name, dataset in variables.items()
    }
    points = points_a_series(found)
    data = {
        "cases": {name: packed_case(one, points) for name, one in found.items()},
        "shoes": None if stress is None or owner is None else packed_shoes(stress, owner),
        "first": first_plots(found),
        **page_colours(),
    }
    title = " and ".join(variables) if variables else folder.resolve().name
    lead = [
        f"{name}: {float(one.time[-1]):.4g} s, {one.sizes['time']} stored times"
        for name, one in variables.items()
    ]
    content = {
        "title": f"Crawler track: {title}",
        "lead": "; ".join(lead),
        "summary": [] if comparison is None else _summary_rows(comparison),
        "comparison": None if comparison is None else comparison_rows(comparison),
        "has_series": bool(variables),
        "thinning": thinning(variables, points),
        "hot_spots": hot_spot_tables(folder, stress),
        "has_shoes": data["shoes"] is not None,
        "pictures": _pictures(folder, stress, owner),
        "tables": [html_table(path.name, pd.read_csv(path)) for path in _further(folder)],
        "cases": [
            {"title": name, "rows": case_table(one.case).to_dict("records")}
            for name, one in histories.items()
        ],
        "texts": _texts(folder),
    }
    return _rendered(content, data)


def _rendered(content: dict[str, Any], data: dict[str, Any]) -> str:
    """Page of what its sections show and of the data that its script draws."""
    environment = Environment(
        loader=FileSystemLoader(str(files("exudyn_crawler.views.report").joinpath("templates"))),
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    return environment.get_template("report.html").render(
        content,
        style=Markup(_template("report.css")),
        script=Markup(_template("report.js")),
        plotly=Markup(get_plotlyjs()) if content["has_series"] else "",
        # the page's own parser must not find the end of a script in the data
        data=Markup(json.dumps(data, separators=(",", ":")).replace("</", "<\\/")),
        sections=[
            (anchor, heading) for anchor, heading, shown in SECTIONS if shown is None or content[shown]
        ],
    )


def _template(name: str) -> str:
    return files("exudyn_crawler.views.report").joinpath("templates", name).read_text(encoding="utf-8")


def _histories(folder: Path) -> tuple[dict[str, History], dict[str, xr.Dataset]]:
    """Histories of a folder by case, and the variables over time of each case.

    The forces study keeps variables without the case of a history that it reused.
    """
    histories: dict[str, History] = {}
    variables: dict[str, xr.Dataset] = {}
    loose: dict[str, xr.Dataset] = {}
    for path in sorted(folder.glob("*.nc")):
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            attributes, names = dict(dataset.attrs), set(dataset.data_vars)
        if "case" in attributes:
            history = History.load(path)
            name = history.case.name if history.case.name not in histories else path.stem
            histories[name] = history
            variables[name] = history.dataset.assign(terrain_deformation=terrain_deformation(history))
        elif {"position", "contact_shoe"} <= names | set(dataset.coords):
            loose[str(attributes.get("title", path.stem))] = xr.load_dataset(path, engine="h5netcdf")
    for name, dataset in loose.items():
        variables.setdefault(name, dataset)
    return histories, variables


def _stress(folder: Path) -> xr.Dataset | None:
    path = folder / "stress.nc"
    return xr.load_dataset(path, engine="h5netcdf") if path.is_file() else None


def _comparison(folder: Path) -> pd.DataFrame | None:
    path = folder / "comparison.csv"
    if not path.is_file():
        return None
    table = pd.read_csv(path, dtype={"within": str})
    missing = [name for name in ("class", "within") if name not in table]
    if missing:
        raise ValueError(f"{path} has no column {missing[-1]!r} and is no comparison")
    return table.assign(within=table["within"].fillna(""))


def _summary_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    return [
        {"name": name, "within": int(row["within"]), "of": int(row["of"])}
        for name, row in summary(table).iterrows()
    ]


def hot_spot_tables(folder: Path, stress: xr.Dataset | None) -> list[dict[str, Any]]:
    """Titles and HTML of the hot spots' tables of a folder, in the order of the shoes."""
    return [hot_spot_table(path, stress) for path in _by_number(folder.glob("hot_spots_*.csv"))]


def _by_number(paths: Iterator[Path]) -> list[Path]:
    """Paths sorted by the number that their names hold, then by name."""
    return sorted(paths, key=lambda p: (int("".join(filter(str.isdigit, p.stem)) or 0), p.name))


def _further(folder: Path) -> list[Path]:
    """Tables that have no section of their own."""
    return sorted(
        path
        for path in folder.glob("*.csv")
        if path.name != "comparison.csv" and not path.name.startswith("hot_spots_")
    )


def _pictures(folder: Path, stress: xr.Dataset | None, history: History | None) -> list[dict[str, str]]:
    """Stress pictures of the folder, or new ones where it has none."""
    kept = sorted(folder.glob(PICTURES))
    if kept or stress is None or history is None:
        return [embedded_picture(path) for path in kept]
    with TemporaryDirectory() as temporary:
        return [embedded_picture(path) for path in write_stress_pictures(stress, history, Path(temporary))]


def _texts(folder: Path) -> list[dict[str, str]]:
    """Files about the run that are shown as they are."""
    found = [folder / name for name in ("case.toml", "run.json")]
    return [
        {"title": path.name, "content": path.read_text(encoding="utf-8")} for path in found if path.is_file()
    ]
