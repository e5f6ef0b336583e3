"""Numbers of results that pages quote, taken from the tables in `docs/numbers`.

A number stands on a page between two comments, which name its table and its row there::

    Shoe 13 reaches <!-- stress.csv: shoe 13 in propel -->187<!-- --> MPa.

``python -m docs.numbers`` writes the numbers of the tables into the pages, each with as many decimals as it
has there. ``python -m docs.numbers results`` first renews the tables and `comparison.md` from the folder that
holds the studies' folders. Change a table only by running what its column `run` names. The tests fail if a
page differs from the tables.
"""

import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import xarray as xr

from docs import comparison
from docs.mentions import PAGES
from exudyn_crawler import History
from exudyn_crawler.results.history.machine import machine_answers, together
from exudyn_crawler.views.tables import within_by_class, write_table
from studies import order, variants
from studies.comparison import ROW
from studies.stress import RANKS, highest_in_propel_and_loading

FOLDER = Path(__file__).with_name("numbers")
EVIDENCE = Path(variants.__file__).with_name("evidence.csv")
COLUMNS = ["name", "value", "unit", "run"]
"""Columns of a table: text or number by name, its unit, and the run that it comes from."""
MARKED = re.compile(r"<!-- (?P<table>\w+)\.csv: (?P<name>[^>]+?) -->(?P<text>[^<]*)<!-- -->")


@cache
def values(table: str) -> dict[str, str]:
    """Return the values of a table as text by name."""
    rows = pd.read_csv(FOLDER / f"{table}.csv", dtype=str, keep_default_na=False)
    return dict(zip(rows["name"], rows["value"], strict=True))


def filled(text: str) -> str:
    """Return the text of a page with all marked numbers from their tables; `KeyError` for an unknown one."""
    return MARKED.sub(_replaced, text)


def _replaced(mark: re.Match[str]) -> str:
    value = values(mark["table"])[mark["name"]]
    head, _, tail = mark[0].rpartition(f"{mark['text']}<!-- -->")
    return f"{head}{_like(mark['text'], value)}<!-- -->{tail}"


def _like(old: str, value: str) -> str:
    """Return a value with the decimals of an old text, or as it is if it is no number."""
    if not re.fullmatch(r"-?[\d.]+(e[-+]?\d+)?", value) or not re.fullmatch(r"-?[\d.]+", old):
        return value
    return f"{float(value):.{len(old.partition('.')[2])}f}"


def counts(tables: dict[str, pd.DataFrame]) -> Iterator[tuple[str, str, str, str]]:
    """Yield the counts of rows within their limits by study and class, and of rows that discriminate."""
    for study, table in tables.items():
        for row in within_by_class(table).itertuples():
            yield f"{study} {row._1}", f"{row.within} of {row.of}", "rows", f"make {study}"
    rigid = pd.concat([tables["kinematics"], tables["forces"]])
    for name, rows in {"rigid": rigid, "stress": tables["stress"]}.items():
        yield from _told(name, rows)


def _told(name: str, rows: pd.DataFrame) -> Iterator[tuple[str, str, str, str]]:
    """Yield how many rows of a study could have failed, and how many of these are within their limits."""
    how = f"python -m studies variants {name}"
    known = pd.read_csv(EVIDENCE, keep_default_na=False)[[*ROW, "outside"]]
    rows = rows.merge(known, on=ROW, validate="one_to_one")
    good = [
        variants.is_within(*row)
        for row in rows[["paper", "computed", "class", "unit"]].itertuples(index=False, name=None)
    ]
    rows = rows.assign(good=good, always=rows["outside"] == "")
    yield f"{name} variants", str(1 + len(variants.STUDIES[name].variants)), "runs", how
    limited = rows[rows["class"] != "lateral"]
    could_fail = limited[~limited["always"]]
    yield f"{name} rows", str(len(limited)), "rows", how
    yield f"{name} inputs", str(limited["always"].sum()), "rows", how
    yield f"{name} discriminating", f"{could_fail['good'].sum()} of {len(could_fail)}", "rows", how
    for kind, part in rows.groupby("class", sort=False):
        by_load = part["outside"] == "half the load"
        yield f"{name} {kind} within", f"{part['good'].sum()} of {len(part)}", "rows", how
        yield f"{name} {kind} inputs", str(part["always"].sum()), "rows", how
        yield f"{name} {kind} of load", str(by_load.sum()), "rows", how
        yield f"{name} {kind} other", str((~part["always"] & ~by_load).sum()), "rows", how


def stresses(results: Path, table: pd.DataFrame) -> Iterator[tuple[str, float, str, str]]:
    """Yield highest stresses of the stress study's run, and their median and range over other starts."""
    folder = results / "stress" / "cycle"
    history = History.load(folder / "history.nc")
    with xr.open_dataset(folder / "stress.nc") as dataset:
        summary = highest_in_propel_and_loading(history, SimpleNamespace(dataset=dataset))
    run = "make stress: start 1, compiled formulation, study mesh"
    for row in summary.itertuples():
        yield f"shoe {row.shoe} in propel", row.propel, "MPa", run
        yield f"shoe {row.shoe} in loading", row.loading, "MPa", run
        yield f"shoe {row.shoe} loading over propel", row.ratio, "1", run
    spots = table[table["case"] == "hot spots"]
    for shoe in (13, 7):
        rows = spots[spots["quantity"].str.startswith(f"shoe {shoe} ")].set_index("statistic")
        first = rows.loc["1st"]
        yield f"shoe {shoe}, paper", first["paper"], "MPa", "S-paper"
        for name in ("median", "least", "greatest"):
            yield f"shoe {shoe}, {name} of starts", first[name], "MPa", "python -m studies variants stress"
        for rank in list(RANKS)[1:]:
            yield f"shoe {shoe}, {rank} over first", rows.loc[rank, "computed"] / first["computed"], "1", run
    of_runs = pd.read_csv(results / "variants" / "stress.csv").set_index(["quantity", "statistic"])
    for variant in variants.STUDIES["stress"].variants:
        value = of_runs.loc[("shoe 13 greatest von Mises", "1st"), variant]
        yield f"shoe 13, {variant}", value, "MPa", "python -m studies variants stress"
    for row in table.itertuples():
        if row.case in ("propel", "loading"):
            yield f"{row.case}: {row.quantity}, {row.statistic}", row.computed, row.unit, run


TUTORIAL = {"straight": "mine", "turn": "turn"}
"""Folders of the tutorial's runs by name."""


def tutorial(results: Path) -> Iterator[tuple[str, float, str, str]]:
    """Yield the machine's answers of the tutorial's runs; those of one side have its name."""
    for name, folder in TUTORIAL.items():
        history = History.load(results / folder / "history.nc")
        table = together(machine_answers(history))
        apart = table["result"].duplicated(keep=False)
        for row, is_apart in zip(table.itertuples(), apart, strict=True):
            side = f", {row.of.split()[0]}" if is_apart else ""
            yield f"{name}: {row.result}{side}", row.value, row.unit, f"run mine.toml --out results/{folder}"


MOTION = {
    "distance in m": "way",
    "commanded distance in m": "commanded way",
    "distance over the commanded after the start": "way after start",
    "greatest tension in kN, distance": "tension",
    "turn in rad": "turn",
    "commanded turn in rad": "commanded turn",
    "turn over the commanded after the start": "turn after start",
    "greatest tension in kN, turn": "tension in turn",
}
"""Short names of the columns of `motion.csv`, for tables with many numbers."""


def machines(results: Path) -> Iterator[tuple[str, float, str, str]]:
    """Yield the motion of the library's machines."""
    table = pd.read_csv(results / "library" / "motion.csv").set_index("machine")
    for machine, row in table.iterrows():
        for column, name in MOTION.items():
            unit = re.search(r" in (kN|rad|m)\b", column)
            how = f"python -m studies library {machine}"
            yield f"{machine} {name}", row[column], unit[1] if unit else "1", how


def pins(results: Path) -> Iterator[tuple[str, float, str, str]]:
    """Yield works, powers and fluctuations of the runs with and without friction of pins."""
    table = pd.read_csv(results / "pins" / "pins.csv").set_index("run")
    for run, row in table.drop(columns=["kind", "speed", "ground"]).iterrows():
        for column, value in row.items():
            name, unit, rest = re.split(r" in (kJ|kW|kN m|kN)\b", str(column))
            yield f"{run}: {name}{rest}", value, unit, "python -m studies pins"


def by_variant(results: Path) -> Iterator[tuple[str, str, str, str]]:
    """Yield the counts of rows of the rigid studies within their limits, by variant, case and class."""
    table = variants.counts(pd.read_csv(results / "variants" / "rigid.csv")).set_index("variant")
    for run in (variants.FIRST, *variants.STUDIES["rigid"].variants):
        for kind, count in table.loc[run].items():
            yield f"{run}: {kind}", count, "rows", "python -m studies variants rigid"


def orders(results: Path) -> Iterator[tuple[str, float, str, str]]:
    """Yield the orders of convergence, and the differences of multipliers, by motion, radius and steps."""
    for _, row in pd.read_csv(results / "order" / "order.csv").iterrows():
        name = f"{row['motion']}, {row['spectral radius']:g}, {row['steps, ms'].split(',')[0]} ms"
        for part in order.PARTS:
            yield f"{name}: {part}", row[part], "1", "python -m studies order"
        yield f"{name}: difference", row[order.DIFFERENCE], "N", "python -m studies order"


def mechanisms(results: Path) -> Iterator[tuple[str, float, str, str]]:
    """Yield computed values of problems with known motions, and the known ones that are not zero."""
    for row in pd.read_csv(results / "mechanisms" / "mechanisms.csv").itertuples():
        name = f"{row.problem}: {row.quantity}"
        yield name, row.found, row.unit, "python -m studies mechanisms"
        if row.known != 0.0:
            yield f"{name}, known", row.known, row.unit, "closed form"


def plays(results: Path) -> Iterator[tuple[str, float, str, str]]:
    """Yield loads of links with play, and what their runs cost over those of ideal joints."""
    for _, row in pd.read_csv(results / "play" / "play.csv").iterrows():
        for column, value in row.drop(["motion", "joints"]).items():
            kind = str(column).partition(",")[0]
            unit = {"across": "kN", "moment": "kN m"}.get(kind, "1")
            yield f"{row['motion']}, {row['joints']}: {column}", value, unit, "python -m studies play"


def renew(results: Path) -> None:
    """Write `comparison.md` and the tables whose runs are in a folder of folders of runs."""
    if (results / "variants").is_dir():
        _renew_studies(results)
    sources = {
        "tutorial": ("mine", tutorial),
        "machines": ("library", machines),
        "order": ("order", orders),
        "pins": ("pins", pins),
        "mechanisms": ("mechanisms", mechanisms),
        "play": ("play", plays),
    }
    for name, (folder, rows) in sources.items():
        if (results / folder).is_dir():
            _write(name, rows(results))


def _write(name: str, rows: Iterator[tuple[str, object, str, str]]) -> None:
    write_table(pd.DataFrame(rows, columns=COLUMNS), FOLDER / f"{name}.csv", overwrite=True)


def _renew_studies(results: Path) -> None:
    """Write what the papers' studies and their variants have found."""
    known = [pd.read_csv(results / "variants" / f"{name}_evidence.csv") for name in variants.STUDIES]
    write_table(pd.concat(known), EVIDENCE, overwrite=True)
    comparison.PAGE.write_text(comparison.page(results), encoding="utf-8")
    tables = {study: comparison.compared(results, study) for study in comparison.STUDIES}
    _write("counts", counts(tables))
    _write("stress", stresses(results, tables["stress"]))
    _write("variants", by_variant(results))


def main(folder: str | None = None) -> None:
    """Renew the tables from a folder, if given; write their numbers into all pages."""
    if folder is not None:
        renew(Path(folder))
    for path in PAGES:
        text = path.read_text(encoding="utf-8")
        if (changed := filled(text)) != text:
            path.write_text(changed, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
