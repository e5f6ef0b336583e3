"""One self-contained page of a run's folder, to be read offline in a browser."""

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd
import xarray as xr
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from exudyn_crawler.case.files.text import case_rows
from exudyn_crawler.files import refuse_existing, whole_file
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.report.heading import bouncing_lines, key_rows, provenance
from exudyn_crawler.views.report.left_out import LeftOut
from exudyn_crawler.views.report.pictures import embedded_picture, first_picture
from exudyn_crawler.views.report.plots import (
    first_plots,
    packed_case,
    packed_phases,
    page_colours,
    points_a_series,
    thinning,
)
from exudyn_crawler.views.report.reading import STRESSES, histories_in, run_folders, stress_of
from exudyn_crawler.views.report.shoes import packed_shoes
from exudyn_crawler.views.report.tables import comparison_rows, html_table
from exudyn_crawler.views.report.templating import rendered_page, template_text
from exudyn_crawler.views.report.track import packed_track
from exudyn_crawler.views.series import history_series
from exudyn_crawler.views.stress_pictures import PICTURES, write_stress_pictures
from exudyn_crawler.views.tables import within_by_class

REPORT = "report.html"
SCRIPTS = ("bodies.js", "camera.js", "phases.js", "track.js", "shoes.js", "report.js")
LONGEST_TABLE = 300
"""Rows of a table on the page; longer ones are series, which plots show."""
SECTIONS = (
    ("comparison", "Paper against computed", "comparison"),
    ("histories", "Time histories", "has_series"),
    ("track", "Track in motion", "has_series"),
    ("hot-spots", "Hot spots", "hot_spots"),
    ("shoes", "Flexible shoes in 3D", "has_shoes"),
    ("pictures", "Stress pictures", "pictures"),
    ("tables", "Further tables", "tables"),
    ("case", "Case", None),
)
"""Anchor and heading of each section, and what there must be for it to be shown."""


def write_report(
    folder: Path,
    out: Path | None = None,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _text: None,
) -> Path:
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
    say : callable
        Is told of the files beside the histories that cannot be read; the report goes on without them.

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
        If a history cannot be read, or nothing else can.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise NotADirectoryError(f"no folder {folder}")
    out = folder / REPORT if out is None else Path(out)
    refuse_existing(out, overwrite)
    page = report_page(folder, say)
    with whole_file(out, overwrite) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return out


def report_page(folder: Path, say: Callable[[str], None] = lambda _text: None) -> str:
    """HTML of the report; raises as `write_report`."""
    folders = run_folders(folder)
    left_out = LeftOut()
    histories, places = histories_in(folders, left_out)
    stressed = next((one for one in folders if (one / STRESSES).is_file()), folder)
    stress = left_out.unless_broken(stressed / STRESSES, lambda _: stress_of(stressed))
    comparison = left_out.unless_broken(folder / "comparison.csv", _comparison)
    if not histories and comparison is None:
        if left_out:
            raise ValueError("; ".join(left_out))
        raise FileNotFoundError(f"{folder} holds neither a history nor a comparison.csv to report on")
    bent = next((n for n in histories if places[n] == stressed and histories[n].case.flexible), None)
    owner = None if bent is None else histories[bent]
    found = {
        name: list(history_series(one, stress if name == bent else None).values())
        for name, one in histories.items()
    }
    points = points_a_series(found)
    pictures, first = _pictures(stressed, stress, owner, left_out)
    data = {
        "first_picture": first,
        "cases": {
            name: packed_case(one, points) | {"phases": packed_phases(histories[name])}
            for name, one in found.items()
        },
        "shoes": left_out.unless_broken(stressed / STRESSES, lambda _: _shoes(stress, owner)),
        "tracks": {name: packed_track(one) for name, one in histories.items()},
        "first": first_plots(found),
        **page_colours(),
    }
    title = " and ".join(histories) if histories else folder.resolve().name
    content: dict[str, Any] = {
        "title": f"Crawler track: {title}",
        "lead": [*provenance(folder, histories), *bouncing_lines(histories)],
        "key_results": key_rows(histories, {} if bent is None or stress is None else {bent: stress}),
        "summary": [] if comparison is None else _summary_rows(comparison),
        "comparison": None if comparison is None else comparison_rows(comparison),
        "has_series": bool(histories),
        "rolled": any(one.case.propel == "rolled" for one in histories.values()),
        "thinning": thinning(histories.values(), points),
        "hot_spots": _hot_spot_tables(stressed, left_out),
        "has_shoes": data["shoes"] is not None,
        "pictures": pictures,
        "tables": left_out.of_all(
            [path for one in folders for path in _further(one)],
            lambda path: _short_table(path, path.relative_to(folder).as_posix()),
        ),
        "cases": [
            {"title": name, "rows": [row._asdict() for row in case_rows(one.case)]}
            for name, one in histories.items()
        ],
        "texts": left_out.of_all([folder / "case.toml", folder / "run.json"], _text),
    }
    for line in left_out:
        say(f"{line}; left out")
    content["left_out"] = left_out
    return _rendered(content, data)


def _rendered(content: dict[str, Any], data: dict[str, Any]) -> str:
    """Page of what its sections show and of the data that its script draws."""
    return rendered_page(
        "report.html",
        **content,
        scripts=[template_text(name) for name in SCRIPTS],
        plotly=Markup(get_plotlyjs()) if content["has_series"] else "",
        # the page's own parser must not find the end of a script in the data
        data=Markup(json.dumps(data, separators=(",", ":")).replace("</", "<\\/")),
        sections=[
            (anchor, heading) for anchor, heading, shown in SECTIONS if shown is None or content[shown]
        ],
    )


def _shoes(stress: xr.Dataset | None, owner: History | None) -> dict[str, Any] | None:
    return None if stress is None or owner is None else packed_shoes(stress, owner)


def _comparison(path: Path) -> pd.DataFrame | None:
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


def _hot_spot_tables(folder: Path, left_out: LeftOut) -> list[dict[str, Any]]:
    """Titles and HTML of the hot spots' tables of a folder, in the order of the shoes."""
    return left_out.of_all(
        _by_number(folder.glob("hot_spots_*.csv")),
        lambda path: html_table(path.stem.removeprefix("hot_spots_").replace("_", " "), pd.read_csv(path)),
    )


def _by_number(paths: Iterator[Path]) -> list[Path]:
    """Paths sorted by the number that their names hold, then by name."""
    return sorted(paths, key=lambda p: (int("".join(filter(str.isdigit, p.stem)) or 0), p.name))


def _further(folder: Path) -> list[Path]:
    """Tables that have no section of their own."""
    return sorted(
        path
        for path in folder.glob("[!.]*.csv")
        if path.name != "comparison.csv" and not path.name.startswith("hot_spots_")
    )


def _short_table(path: Path, title: str) -> dict[str, Any] | None:
    """Title and HTML of a table; None if it is too long to be read."""
    table = pd.read_csv(path)
    return html_table(title, table) if len(table) <= LONGEST_TABLE else None


def _pictures(
    folder: Path, stress: xr.Dataset | None, history: History | None, left_out: LeftOut
) -> tuple[list[dict[str, str]], int]:
    """Stress pictures of the folder, or new ones where it has none, and which of them is shown first."""
    kept = sorted(folder.glob(PICTURES))
    if kept or stress is None or history is None:
        return _embedded(kept, stress, left_out)
    with TemporaryDirectory() as temporary:
        return _embedded(write_stress_pictures(stress, history, Path(temporary)), stress, left_out)


def _embedded(
    paths: Sequence[Path], stress: xr.Dataset | None, left_out: LeftOut
) -> tuple[list[dict[str, str]], int]:
    """Pictures that can be read, and which of them is shown first."""
    found = [
        (path, left_out.unless_broken(path, lambda one: embedded_picture(one, stress))) for path in paths
    ]
    shown = {path: picture for path, picture in found if picture is not None}
    return list(shown.values()), first_picture(list(shown), stress)


def _text(path: Path) -> dict[str, str] | None:
    """File about the run that is shown as it is."""
    if not path.is_file():
        return None
    content = path.read_text(encoding="utf-8")
    if path.suffix == ".json":
        json.loads(content)
    return {"title": path.name, "content": content}
