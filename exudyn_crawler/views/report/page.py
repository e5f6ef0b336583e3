"""One self-contained page of a run's folder, to be read offline in a browser."""

import base64
import io
import json
from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
import xarray as xr
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup
from PIL import Image
from plotly.offline import get_plotlyjs
from pydantic import BaseModel

from exudyn_crawler.case import LoadCycle
from exudyn_crawler.files import whole_file
from exudyn_crawler.results.contacts import terrain_deformation
from exudyn_crawler.results.history import History
from exudyn_crawler.views.report.data import packed_case, packed_shoes, points_a_series, quantities
from exudyn_crawler.views.scenes import ARROW_COLOUR, COLOURS
from exudyn_crawler.views.stress_pictures import PICTURES, picture_time, write_stress_pictures
from exudyn_crawler.views.tables import within_by_class

REPORT = "report.html"
STRESSES = "stress.nc"
PICTURE_WIDTH = 1500
"""Pixels of a picture on the page."""
FIRST_PLOTS = {
    "rigid": ("velocity", "contact force"),
    "stress": ("highest von Mises stress", "contact force"),
}
"""What the plots show first, by what a folder holds."""
VERDICTS = {"yes": "within", "no": "outside", "": "none"}


def write_report(folder: Path, out: Path | None = None, overwrite: bool = False) -> Path:
    """Write the report of a run's folder: whatever of comparison, histories, stresses and case is there.

    Of a study's folder the runs in its folders are shown together; pictures, hot spots and the 3D view are
    those of the first run with flexible shoes.

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
    folders = _run_folders(folder)
    histories, places = _histories(folders)
    variables = {
        name: one.dataset.assign(terrain_deformation=terrain_deformation(one))
        for name, one in histories.items()
    }
    stressed = next((one for one in folders if (one / STRESSES).is_file()), folder)
    stress = _stress(stressed)
    comparison = _comparison(folder)
    if not variables and comparison is None:
        raise FileNotFoundError(f"{folder} holds neither a history nor a comparison.csv to report on")
    bent = next((n for n in histories if places[n] == stressed and histories[n].case.flexible), None)
    owner = None if bent is None else histories[bent]
    found = {
        name: quantities(dataset, stress if name == bent else None) for name, dataset in variables.items()
    }
    points = points_a_series(found)
    pictures = _pictures(stressed, stress, owner)
    hot_spots = hot_spot_tables(stressed, stress)
    further = [path for one in folders for path in _further(one)]
    data = {
        "cases": {name: packed_case(one, points) for name, one in found.items()},
        "shoes": None if stress is None or owner is None else packed_shoes(stress, owner),
        "first": _first_plots(found),
        "colours": _colour_scale(),
        "arrows": ARROW_COLOUR,
    }
    title = " and ".join(variables) if variables else folder.resolve().name
    lead = [
        f"{name}: {float(one.time[-1]):.4g} s, {one.sizes['time']} stored times"
        for name, one in variables.items()
    ]
    named = {
        "comparison": ("Paper against computed", comparison is not None),
        "histories": ("Time histories", bool(variables)),
        "hot-spots": ("Hot spots", bool(hot_spots)),
        "shoes": ("Flexible shoes in 3D", data["shoes"] is not None),
        "pictures": ("Stress pictures", bool(pictures)),
        "tables": ("Further tables", bool(further)),
        "case": ("Case", True),
    }
    environment = Environment(
        loader=FileSystemLoader(str(files("exudyn_crawler.views.report").joinpath("templates"))),
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    return environment.get_template("report.html").render(
        title=f"Crawler track: {title}",
        lead="; ".join(lead),
        style=Markup(_template("report.css")),
        script=Markup(_template("report.js")),
        plotly=Markup(get_plotlyjs()) if variables else "",
        # the page's own parser must not find the end of a script in the data
        data=Markup(json.dumps(data, separators=(",", ":")).replace("</", "<\\/")),
        sections=[(anchor, name) for anchor, (name, there) in named.items() if there],
        summary=[] if comparison is None else _summary_rows(comparison),
        comparison=None if comparison is None else _comparison_rows(comparison),
        has_series=bool(variables),
        thinning=_thinning(variables, points),
        hot_spots=hot_spots,
        has_shoes=data["shoes"] is not None,
        pictures=pictures,
        tables=[_table(path.relative_to(folder).as_posix(), pd.read_csv(path)) for path in further],
        cases=[{"title": name, "rows": case_rows(one.case)} for name, one in histories.items()],
        texts=_texts(folder),
    )


def _template(name: str) -> str:
    return files("exudyn_crawler.views.report").joinpath("templates", name).read_text(encoding="utf-8")


def _run_folders(folder: Path) -> list[Path]:
    """A folder and those of the runs in it: a study keeps each of its cases in a folder of its own."""
    return [folder, *sorted({path.parent for path in folder.glob("*/history*.nc")})]


def _histories(folders: list[Path]) -> tuple[dict[str, History], dict[str, Path]]:
    """Histories of some folders by case, and the folder of each."""
    histories: dict[str, History] = {}
    places: dict[str, Path] = {}
    for folder in folders:
        for path in sorted(folder.glob("*.nc")):
            with xr.open_dataset(path, engine="h5netcdf") as dataset:
                kept = "case" in dataset.attrs
            if not kept:
                continue
            history = History.load(path)
            name = history.case.name
            if name in histories:
                name = f"{folder.name}, {path.stem}"
            histories[name], places[name] = history, folder
    return histories, places


def _stress(folder: Path) -> xr.Dataset | None:
    path = folder / STRESSES
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
        {"name": row["class"], "within": int(row["within"]), "of": int(row["of"])}
        for _, row in within_by_class(table).iterrows()
    ]


def _comparison_rows(table: pd.DataFrame) -> dict[str, Any]:
    """Columns and rows of the comparison, each row with its verdict."""
    shown = table.assign(within=table["within"].map(VERDICTS))
    shown["within"] = shown["within"].replace("none", "no verdict")
    rows = [
        {"verdict": VERDICTS[verdict], "cells": [_cell(value) for value in row]}
        for verdict, row in zip(table["within"], shown.itertuples(index=False), strict=True)
    ]
    return {"columns": list(shown.columns), "rows": rows}


def _cell(value: object) -> dict[str, Any]:
    if isinstance(value, float | np.floating):
        return {"text": "" if np.isnan(value) else f"{value:.4g}", "number": True}
    return {"text": str(value), "number": isinstance(value, int | np.integer)}


def _table(title: str, table: pd.DataFrame) -> dict[str, Any]:
    html = table.to_html(index=False, border=0, na_rep="", float_format=lambda value: f"{value:.5g}")
    return {"title": title, "html": Markup(html)}


def hot_spot_tables(folder: Path, stress: xr.Dataset | None) -> list[dict[str, Any]]:
    """Titles and HTML of the hot spots' tables of a folder, in the order of the shoes."""
    return [_hot_spot_table(path, stress) for path in _by_number(folder.glob("hot_spots_*.csv"))]


def _hot_spot_table(path: Path, stress: xr.Dataset | None) -> dict[str, Any]:
    """Table of hot spots with stresses in MPa and places in the shoe's frame.

    Studies give places in the track at t = 0, as the S-paper does, which are kept beside.
    """
    table = pd.read_csv(path)
    for name in ("value", "jump"):
        if name in table:
            table[name] = table[name] / 1e6
    places = {"place in the shoe, m": table[list("xyz")].to_numpy()}
    if stress is not None:
        local = stress.node_position.transpose("node", "axis").values[table["node"]]
        if not np.allclose(local, places["place in the shoe, m"], atol=1e-6):
            places = {"place in the shoe, m": local, "place at t = 0, m": places["place in the shoe, m"]}
    at = table.columns.get_loc("x")
    table = table.drop(columns=list("xyz"))
    for offset, (name, values) in enumerate(places.items()):
        table.insert(at + offset, name, [", ".join(f"{value:.4f}" for value in row) for row in values])
    names = {"value": "von Mises, MPa", "jump": "jump, MPa", "time": "time, s"}
    title = path.stem.removeprefix("hot_spots_").replace("_", " ")
    return _table(title, table.rename(columns=names))


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
        return [_picture(path) for path in kept]
    with TemporaryDirectory() as temporary:
        return [_picture(path) for path in write_stress_pictures(stress, history, Path(temporary))]


def _picture(path: Path) -> dict[str, str]:
    """Picture as a data URI, no wider than the page needs."""
    with Image.open(path) as opened:
        image = opened.convert("RGB")
    if image.width > PICTURE_WIDTH:
        size = (PICTURE_WIDTH, round(image.height * PICTURE_WIDTH / image.width))
        image = image.resize(size, Image.Resampling.LANCZOS)
    memory = io.BytesIO()
    image.save(memory, format="webp", quality=85)
    encoded = base64.b64encode(memory.getvalue()).decode("ascii")
    return {"time": f"{picture_time(path):g}", "uri": f"data:image/webp;base64,{encoded}"}


def _first_plots(found: Mapping[str, list]) -> list[str]:
    labels = {quantity.label for one in found.values() for quantity in one}
    return list(FIRST_PLOTS["stress" if "highest von Mises stress" in labels else "rigid"])


def _colour_scale() -> list[list[Any]]:
    """Colours of stresses as Plotly takes them."""
    places = np.linspace(0.0, 1.0, 17)
    return [[float(at), mpl.colors.to_hex(mpl.colormaps[COLOURS](at))] for at in places]


def _thinning(variables: Mapping[str, xr.Dataset], points: int) -> str:
    """What the reader has to know about left-out times."""
    most = max((one.sizes["time"] for one in variables.values()), default=0)
    if most <= points:
        return "Every stored time is drawn."
    return (
        f"Of the {most} stored times each curve keeps the least and the greatest value in every one of "
        f"{points // 2 - 1} equal parts of the run, so that no extreme is lost; in between it is thinner "
        "than what was computed."
    )


def _texts(folder: Path) -> list[dict[str, str]]:
    """Files about the run that are shown as they are."""
    found = [folder / name for name in ("case.toml", "run.json")]
    return [
        {"title": path.name, "content": path.read_text(encoding="utf-8")} for path in found if path.is_file()
    ]


def case_rows(model: BaseModel, prefix: str = "") -> list[dict[str, str]]:
    """Every parameter of a case: name, value, unit and meaning, in the order of its fields."""
    rows: list[dict[str, str]] = []
    for name, field in type(model).model_fields.items():
        value = getattr(model, name)
        path = f"{prefix}{name}"
        if isinstance(value, LoadCycle):
            rows += [
                {
                    "name": f"{path}.{phase.name}",
                    "value": _shown(phase.loads),
                    "unit": "N",
                    "meaning": f"downward load on shoes 1 to {value.shoe_count} at t = {phase.end:g} s",
                }
                for phase in value.phases
            ]
        elif isinstance(value, BaseModel) and not (isinstance(field.json_schema_extra, dict)):
            rows += case_rows(value, f"{path}.")
        else:
            extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
            rows.append(
                {
                    "name": path,
                    "value": _shown(value),
                    "unit": str(extra.get("unit", "")),
                    "meaning": field.description or "",
                }
            )
    return rows


def _shown(value: object) -> str:
    """Value of a parameter for reading."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.8g}"
    if isinstance(value, tuple):
        return ", ".join(_shown(one) for one in value)
    if isinstance(value, BaseModel):
        return "; ".join(f"{name} {_shown(getattr(value, name))}" for name in type(value).model_fields)
    return "none" if value is None else str(value)
