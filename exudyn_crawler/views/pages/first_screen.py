"""First screen of a run's page: picture of the machine, a sentence on the run, answers, the first warning."""

from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup
from matplotlib.figure import Figure

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.case.parameters.terrain import CellContact
from exudyn_crawler.results.history import History, summary
from exudyn_crawler.views import style
from exudyn_crawler.views.pages import page
from exudyn_crawler.views.scenes import pictures, shoes, track
from fem.stress import trust

ANSWERS = 5  # of the first screen; the rest of the key results is in a table
ASKED = (
    "highest von Mises stress",
    summary.HELD,
    "greatest tension of the chain",
    "greatest force on a roller",
    "greatest ground pressure below a shoe",
    "greatest torque of the drive",
)
"""Answers that come first if a run has them; the others follow in their order."""
WIDTH = 11.0  # inches, of the picture
LEVEL = 1e-6  # grade of ground that is level
GROUNDS = {
    "bekker": "soil by Bekker's law",
    "rock": "rock or a hard floor",
    "units": "elastic ground of blocks on springs",
}
"""Names of the ground by its model."""
WORDS = {
    "deepest penetration": "deepest sinkage",
    "greatest force on a carrier": "greatest force on a carrier roller",
}
"""Words of undercarriage makers for names of key results; all others stay as they are."""
ONE_DRAW = (
    " Extremes are one draw: a track pulled at its front shoe sticks and slips, and takes another "
    "path from a start that differs by rounding."
)
ROOM = 0.8  # inches, of a picture for its title and labels


def first_screen(history: History, results: pd.DataFrame, stress: xr.Dataset | None = None) -> Markup:
    """Return picture of the machine, sentence on the run, answers, and the first warning if there is any.

    `results` are the key results of the run.
    """
    case = history.case
    now = track.instants(history, [results["at"].iloc[0]])
    parts = [
        page.figure_picture(f"{case.name} from the right", machine_figure(now)),
        page.paragraph(sentence(history, results)),
        page.part("answers", answers(history, results, stress)[:ANSWERS]),
    ]
    if (line := next(checks.implausible(case, history.duration), None)) is not None:
        parts.append(page.part("warning", line))
    return page.together(*parts)


def answers(
    history: History, results: pd.DataFrame, stress: xr.Dataset | None = None
) -> list[tuple[str, str, str, str]]:
    """Return the key results of a run in the order of `ASKED`: name, value, location, limit or verdict.

    A value that is greater during the start stands beside the location of that after it.
    """
    is_start = results["result"].str.endswith(summary.START)
    starts = {row.result.removesuffix(summary.START): row for row in results[is_start].itertuples()}
    later = results[~is_start]
    rank = [ASKED.index(name) if name in ASKED else len(ASKED) for name in later["result"]]
    ordered = later.iloc[np.argsort(rank, kind="stable")]
    return [_answer(row, starts.get(row.result), history, stress) for row in ordered.itertuples()]


def sentence(history: History, results: pd.DataFrame) -> str:
    """Describe machine, distance, duration and ground of a run; `results` are its key results."""
    case = history.case
    travel = results.set_index("result").loc["distance travelled", "value"]
    way = f"{travel:.3g} m in {history.duration:.4g} s"
    bending = "" if case.flexible is None else f"; {len(case.flexible.shoes)} flexible"
    begin = summary.start_ends(history)
    window = f" Greatest forces and speeds are those after the start of {begin:.3g} s." if begin else ""
    draw = "" if case.gear.frame_parts else ONE_DRAW
    return f"{case.gear.words(case)}{bending}: {way} on {ground_words(case)}.{window}{draw}"


def ground_words(case: Case) -> str:
    """Describe the ground of a case: its model, relief and grade."""
    words = GROUNDS[case.part(CellContact).law.model if case.contact.model == "cells" else "units"]
    relief = "" if case.terrain.is_even else " with a relief"
    ahead, across, down = case.terrain.down
    rises = {"ahead": ahead / down, "to the left": across / down}
    grades = [f"{100.0 * rise:+.3g} % {way}" for way, rise in rises.items() if abs(rise) > LEVEL]
    return f"{words}{relief}" + (f", a grade of {' and '.join(grades)}" if grades else "")


def machine_figure(now: History) -> Figure:
    """Draw the side view of an instant with the forces of the ground on the shoes."""
    left, right, bottom, top = pictures.windows(now)[1]
    with mpl.rc_context(style.STYLE):
        figure = Figure(figsize=(WIDTH, WIDTH * (top - bottom) / (right - left) + ROOM))
        ax = figure.subplots()
        ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel="x in m", ylabel="z in m")
        ax.grid(False)
        pictures.draw_side(ax, now, force_scale=shoes.shoe_force_scale(now))
        ax.set_title(f"t = {float(now.time[0]):.3g} s")
    return figure


def _answer(
    result: Any, start: Any | None, history: History, stress: xr.Dataset | None
) -> tuple[str, str, str, str]:
    """Return name, value, location, and limit or verdict of a key result; with the start's if greater."""
    value, place = value_and_place(result)
    if start is not None:
        place += f"; during the start {start.value:.4g} {start.unit}, t = {start.at:.4g} s"
    limit = ""
    if result.unit == "kN":
        limit = f"{1e5 * result.value / _carried(history):.3g} % of the load on the ground at the start"
    elif result.unit == "kN m" and (most := getattr(history.case.gear, "torque_limit", None)) is not None:
        limit = f"{1e5 * result.value / most:.3g} % of the drive's limit"
    elif result.unit == "MPa" and stress is not None:
        is_held = result.result == summary.HELD
        chosen = stress.peak_verdict == trust.HELD if is_held else _usable(stress)
        peak = stress.peak_von_mises.where(chosen).argmax(...)
        limit = trust.verdict_words([int(stress.peak_verdict.isel(peak))])[0]
    return shown_name(result.result), value, place, limit


def _usable(stress: xr.Dataset) -> xr.DataArray:
    """Return True for nodes with a usable greatest stress: not held by a pin coupling, nor at a force."""
    verdict = stress.peak_verdict
    return (verdict >= 0) & (verdict != trust.HELD)


def shown_name(result: str) -> str:
    """Return the words for the name of a key result, also of the start or of one side."""
    name, comma, rest = result.partition(",")
    return WORDS.get(name, name) + comma + rest


def value_and_place(result: Any) -> tuple[str, str]:
    """Return the value of a key result with its unit, and its body and time."""
    kind, _, rest = result.of.partition(" ")
    of = {"wheel": rest, "track": f"{rest} track".strip()}.get(kind, result.of)
    place = ", ".join(filter(None, (of, f"t = {result.at:.4g} s")))
    return f"{result.value:.4g} {result.unit}", place


def _carried(history: History) -> float:
    """Return the upward force of the ground on all shoes at the start (N)."""
    start = history.dataset.isel(time=0)
    return float((start.normal_force + start.friction_force).sel(axis="z").sum())
