"""Self-contained page of a run's folder, for reading offline in a browser."""

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup

from exudyn_crawler.case import CellTerrain, Terrain
from exudyn_crawler.files import refuse_existing
from exudyn_crawler.machines.datasheet.ledger import GENERAL, ORIGINS_FILE
from exudyn_crawler.origins import Origin
from exudyn_crawler.results.history import History, ground_map, summary
from exudyn_crawler.settings.fields import case_rows
from exudyn_crawler.views import figures, style, tables
from exudyn_crawler.views.pages import first_screen, packing, page, runs
from exudyn_crawler.views.pages.page import FLAGS, Section, part, table, together
from exudyn_crawler.views.scenes import pictures, shoes, track

REPORT = "report.html"
RECORD = "run.json"
ORIGIN_WORDS = {
    Origin.GIVEN: "in the file: its source",
    Origin.LIBRARY: "not changed in the file: source of the library's machine",
    Origin.DERIVED: "by which rule, and its source",
    Origin.ASSUMED: "typical: range and source, and how it is known",
}
"""Origins of the values of a machine from its datasheet, and head of the column beside each."""
COMPARISON = "comparison.csv"
LONGEST_TABLE = 300  # rows of a table on the page; longer ones are series, which plots show
INSTANTS, MARGIN = 101, (0.6, 0.4, 0.3)
"""Number of evenly spread instants of the moving track; margins (m) beyond, beside and below the track."""
VERDICTS = {"yes": "within", "no": "outside"}
SPOTS = "hot_spots_"  # prefix of the file names of hot-spot tables
HOT_SPOTS = (
    "Highest von Mises stresses over the run and where they are. A jump as large as the value means that the "
    "mesh makes the peak."
)


def write_report(
    folder: str | Path,
    out: str | Path | None = None,
    overwrite: bool = False,
    loaded: Mapping[Path, History] | None = None,
) -> Path:
    """Write the report of a run's folder and return its path, `out` or `report.html` in the folder.

    The report shows the comparison, histories, stresses and cases that exist. For a study's folder, the runs
    in its folders are shown together; pictures, hot spots and the 3D view are those of the first run with
    flexible shoes. `loaded` are histories in memory, by their files.

    Raises NotADirectoryError if the folder does not exist, FileNotFoundError if it holds neither a history
    nor a comparison, FileExistsError if the report exists and `overwrite` is false, ValueError that names a
    file that cannot be read.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise NotADirectoryError(f"there is no folder {folder}")
    out = folder / REPORT if out is None else Path(out)
    refuse_existing(out, overwrite)
    return page.write_page(report_page(folder, loaded), out, overwrite)


def report_page(folder: Path, loaded: Mapping[Path, History] | None = None) -> str:
    """Return the HTML of the report; raises as `write_report`."""
    # a study keeps each of its cases in a folder of its own
    folders = [folder, *sorted({path.parent for path in folder.glob("*/history*.nc")})]
    histories, homes = runs.histories_in(folders, loaded or {})
    stressed = next((path for path in folders if (path / runs.STRESSES).is_file()), folder)
    stress = runs.stress_of(stressed)
    comparison = folder / COMPARISON
    compared = runs.contents(comparison, _compared) if comparison.is_file() else Markup()
    if not (histories or compared):
        raise FileNotFoundError(f"{folder} holds neither a history nor a {COMPARISON} to report on")
    bent = [name for name in histories if homes[name] == stressed and histories[name].case.flexible]
    stresses = {name: stress for name in bent[:1] if stress is not None}
    arrays = packing.SceneArrays()
    tracks = {name: packed_track(history, arrays) for name, history in histories.items()}
    scenes = {"track": tracks} if tracks else {}
    for name, dataset in stresses.items():
        scene = shoes.stress_scene(dataset, histories[name])
        scenes["shoe"] = {"": packing.packed_scene(scene, arrays, first=shoes.first_frame(dataset))}
    curves, thinned = packing.packed_curves(histories, stresses)
    shown, first = _pictures(stressed, stress)
    rolled = any(history.has("roller_force") for history in histories.values())
    closed = any(history.has("wheel_force") for history in histories.values())
    sections = [
        Section("comparison", "Paper against computed", compared),
        Section("histories", "Time histories", part("histories", thinned) if histories else Markup()),
        Section("track", "Track in motion", part("track", rolled, closed) if histories else Markup()),
        Section("ground", "Ground", _ground(histories)),
        Section("drive-work", "Where the drive's work goes", _drive_works(homes)),
        Section("roller-path", "Roller path", _roller_paths(homes)),
        Section("hot-spots", "Hot spots", _hot_spots(stressed)),
        Section("shoes", "Flexible shoes in 3D", part("shoes") if "shoe" in scenes else Markup()),
        Section("pictures", "Stress pictures", shown),
        Section("tables", "Further tables", _further(folder, folders)),
        Section("origins", "Where the machine's values come from", _origins(homes)),
        Section("case", "Case", _cases(folder, histories)),
    ]
    title = f"Crawler track: {' and '.join(histories) or folder.resolve().name}"
    data = curves | {"first_picture": first, "scenes": scenes, "arrays": arrays.packed}
    data |= {"bands": style.PHASE_BANDS, "phase_name": style.PHASE_NAME}
    results = {name: summary.key_results(run, stresses.get(name)) for name, run in histories.items()}
    opening = [
        first_screen.first_screen(histories[name], results[name], stresses.get(name))
        for name in [*bent, *histories][:1]
    ]
    keys = _key_table(results)
    top = together(*opening, part("folded", "All key results", keys, len(histories) > 1))
    return page.page(title, provenance(folder, histories), sections, data, top)


def packed_track(history: History, arrays: packing.SceneArrays) -> dict[str, object]:
    """Return the track at evenly spread instants of a run for a view in 3D."""
    case = history.case
    window = track.shown_box(history, MARGIN)
    shown = track.instants(history, np.linspace(0.0, history.duration, INSTANTS))
    near = None
    if isinstance(case.terrain, Terrain):
        x = case.terrain.middles[:, 0]
        half = 0.5 * case.terrain.unit_length
        near = np.flatnonzero((x + half >= window[0][0]) & (x - half <= window[0][1]))
    scene = track.track_scene(shown, shoes.shoe_force_scale(history), near)
    return packing.packed_scene(scene, arrays, window)


def _ground(histories: Mapping[str, History]) -> Markup:
    """Return maps of the ground at the end of runs on cells."""
    drawn = {
        name: history for name, history in histories.items() if isinstance(history.case.terrain, CellTerrain)
    }
    maps = {name: pictures.map_figure(each, ground_map.ground_map(each)) for name, each in drawn.items()}
    return together(*(page.figure_picture(f"greatest sinkage, {name}", each) for name, each in maps.items()))


def _roller_paths(homes: Mapping[str, Path]) -> Markup:
    """Return figures of the pressure of treads along the rails, for rolled runs that have the table."""
    paths = {name: home / f"{figures.ROLLER_PATH}.csv" for name, home in homes.items()}
    contacts = {name: runs.contents(path, pd.read_csv) for name, path in paths.items() if path.is_file()}
    drawn = {name: figures.roller_path_figure(contact, name) for name, contact in contacts.items()}
    return together(*(page.figure_picture(f"roller path, {name}", figure) for name, figure in drawn.items()))


def _drive_works(homes: Mapping[str, Path]) -> Markup:
    """Return tables and figures of where the work of drives goes, for runs that have the table."""
    parts = []
    for name, home in homes.items():
        if (path := home / f"{figures.DRIVE_WORK}.csv").is_file():
            table = runs.contents(path, pd.read_csv)
            picture = page.figure_picture(f"drive, {name}", figures.drive_work_figure(table, name))
            parts += [picture, part("folded", f"Table, {name}", page.table(table))]
    return together(*parts)


def provenance(folder: Path, histories: Mapping[str, History]) -> list[str]:
    """Return lines on what the page shows: times of the cases, versions, date of run and page."""
    shown = [
        f"{name}: {history.duration:.4g} s, {history.time.size} stored times"
        for name, history in histories.items()
    ]
    programs = {
        f"{program} {version}"
        for history in histories.values()
        for program in ("exudyn-crawler", "exudyn")
        if (version := history.dataset.attrs.get(f"{program.replace('-', '_')}_version"))
    }
    record = folder / RECORD
    recorded = runs.contents(record, _recorded) if record.is_file() else []
    made = f"page made {datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    lines = "; ".join(shown), "; ".join((*sorted(programs, reverse=True), *recorded, made))
    return list(filter(None, lines))


def _recorded(path: Path) -> list[str]:
    """Return lines of a run's record: its commit, and its end if it has ended."""
    record = json.loads(path.read_text(encoding="utf-8"))
    said = [f"commit {record['commit']}"] if record.get("commit") else []
    if "finished" in record:
        finished = datetime.fromisoformat(record["finished"])
        said.append(f"{record['status']} {finished:%Y-%m-%d %H:%M} UTC after {record['wall_time_s']:.0f} s")
    return said


def _key_table(results: Mapping[str, pd.DataFrame]) -> Markup:
    """Return key results as a table: one row a result, with value, unit, body and time for each case."""
    columns = []
    for name, frame in results.items():
        rows = [first_screen.value_and_place(row) for row in frame.itertuples()]
        values = [page.Cell(value, True) for value, _ in rows]
        where = [place for _, place in rows]
        names = pd.Index(frame["result"].map(first_screen.shown_name))
        columns.append(pd.DataFrame({name: values, "": where}, names))
    if not columns:
        return Markup()
    shown = pd.concat(columns, axis=1).fillna("").rename_axis("").reset_index(allow_duplicates=True)
    return table(shown, anchor="key-results", compact=True, headed=len(results) > 1)


def _compared(path: Path) -> Markup:
    """Return a comparison with verdicts, and the number of rows within limits."""
    comparison = pd.read_csv(path, dtype={"within": str})
    if missing := {"class", "within"}.difference(comparison):
        raise ValueError(f"{path} has no column {max(missing)!r} and is not a comparison")
    verdicts = comparison["within"]
    count = tables.within_by_class(comparison)
    shown = comparison.assign(within=verdicts.replace(VERDICTS).fillna("no verdict"))
    rows = table(shown, kinds=verdicts.map(VERDICTS).fillna("none").tolist(), anchor="comparison-table")
    counts = Markup() if count.empty else table(count, compact=True)
    return together(counts, part("verdict_filter"), rows)


def _tables(how: str, paths: Mapping[str, Path]) -> list[Markup]:
    """Return tables of files by title, rendered by the macro `how`; tables too long to read are left out."""
    contents = {title: runs.contents(path, pd.read_csv) for title, path in paths.items()}
    short = {title: content for title, content in contents.items() if len(content) <= LONGEST_TABLE}
    shown = {title: content.replace(FLAGS) for title, content in short.items()}
    return [part(how, title, table(content, digits=5)) for title, content in shown.items()]


def _hot_spots(folder: Path) -> Markup:
    """Return the tables of hot spots in a folder, in the order of the shoes."""
    paths = sorted(folder.glob(f"{SPOTS}*.csv"), key=lambda path: (len(path.name), path.name))
    parts = _tables("titled", {path.stem.removeprefix(SPOTS).replace("_", " "): path for path in paths})
    return together(page.paragraph(HOT_SPOTS), *parts) if parts else Markup()


def _further(folder: Path, folders: list[Path]) -> Markup:
    """Return tables without a section of their own."""
    paths = [path for home in folders for path in sorted(home.glob("[!.]*.csv"))]
    elsewhere = (COMPARISON, ORIGINS_FILE)
    further = [path for path in paths if path.name not in elsewhere and not path.name.startswith(SPOTS)]
    return together(*_tables("folded", {path.relative_to(folder).as_posix(): path for path in further}))


def _origins(homes: Mapping[str, Path]) -> Markup:
    """Return the values of machines from datasheets as tables by origin, with rule or source."""
    parts = []
    for name, home in homes.items():
        path = home / ORIGINS_FILE
        if not path.is_file():
            continue
        rows = runs.contents(path, lambda one: pd.read_csv(one, dtype=str, keep_default_na=False))
        general = rows["how"] == GENERAL
        kinds: dict[str, pd.DataFrame] = {
            origin: rows[(rows["origin"] == origin) & ~general] for origin in ORIGIN_WORDS
        }
        kinds["general"] = rows[general]
        counts = ", ".join(f"{len(kinds[origin])} {origin}" for origin in ORIGIN_WORDS if len(kinds[origin]))
        parts.append(
            page.paragraph(f"{name}: of {len(rows)} values {counts}; {len(rows[general])} {GENERAL}.")
        )
        for origin, words in (ORIGIN_WORDS | {"general": GENERAL}).items():
            if len(kinds[origin]):
                shown = kinds[origin].drop(columns="origin").rename(columns={"key": "value of", "how": words})
                parts.append(part("folded", f"{origin}: {words}", table(shown), origin == "assumed"))
    return together(*parts)


def _cases(folder: Path, histories: Mapping[str, History]) -> Markup:
    """Return resolved cases with units, and the unchanged text of the files of the run."""
    resolved = [page.paragraph("The folder keeps no resolved case.")]
    if histories:
        rows = {name: pd.DataFrame(case_rows(history.case)) for name, history in histories.items()}
        shown = {name: table(row.rename(columns={"key": "parameter"})) for name, row in rows.items()}
        resolved = [
            part("folded", name, each, not number) for number, (name, each) in enumerate(shown.items())
        ]
    there = [path for path in (folder / "case.toml", folder / RECORD) if path.is_file()]
    texts = {path.name: runs.contents(path, lambda each: each.read_text(encoding="utf-8")) for path in there}
    as_they_are = (part("folded", name, part("preformatted", text)) for name, text in texts.items())
    return together(*resolved, *as_they_are)


def _pictures(folder: Path, stress: xr.Dataset | None) -> tuple[Markup, int]:
    """Return the stress pictures of the folder, and the index of the first shown: that of highest stress."""
    paths = sorted(folder.glob(shoes.PICTURES))
    if not paths:
        return Markup(), 0
    uris = {shoes.picture_time(path): runs.contents(path, page.picture_file) for path in paths}
    times = np.array(list(uris))
    titles = {time: f"t = {time:.6g} s" for time in uris}
    shown = 0
    if stress is not None:
        shown = int(np.abs(times - float(stress.frame[shoes.first_frame(stress)])).argmin())
        for frame, title in zip(stress.frame.values, shoes.frame_titles(stress), strict=True):
            titles |= {time: title for time in uris if abs(frame - time) < 1e-4}
    drawn = [part("picture", f"von Mises stress at {titles[t]}", uri, "picture") for t, uri in uris.items()]
    return together(part("buttons", [*titles.values()]), *drawn), shown
