"""Runs as the page shows them: cost, queue, progress of all parts, curves that grow."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import run as threads, ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.app.runs import DONE, FAILED, GOES_ON, RUNNING, WAITING, Run, Runs
from exudyn_crawler.case.case_file import run_lines
from exudyn_crawler.results.history import History, catalogue
from exudyn_crawler.run.folder import checkpoints, record
from exudyn_crawler.run.folder.progress import rule_of_thumb, times_line

LIVE = ("link_tension", "wheel_force", "roller_force", "drive_moment", "contact_force", "joint_force")
"""Quantities whose greatest value over the machine grows in curves while a run is at work."""
CURVES = 3
POINTS = 2000  # of a curve
ICONS = {
    WAITING: "schedule",
    RUNNING: "autorenew",
    DONE: "check_circle",
    FAILED: "error",
    "stopped": "pause_circle",
}
COLOUR = "#1565c0"
MARGINS = {"l": 60, "r": 10, "t": 28, "b": 36}
Curve = tuple[str, list[float], list[float]]


class Curves:
    """Curves of a run, of which the parts that are there are read once each."""

    def __init__(self, run: Run) -> None:
        self.folder = run.folder
        self.seen: dict[Path, dict[str, Curve]] = {}

    def read(self, run: Run) -> dict[str, Curve]:
        """Title, times and greatest values of each quantity, as far as the run has come."""
        whole = run.folder / record.HISTORY
        paths = [whole] if run.has_history else list(run.stages)
        for path in paths:
            if path not in self.seen:
                try:
                    history = History.load(path) if path == whole else checkpoints.stage_history(path)
                except (ValueError, OSError):
                    # it is being replaced: the next look finds it
                    return {}
                self.seen[path] = {curve[0]: curve for curve in greatest(history)}
        joined: dict[str, Curve] = {}
        for path in paths:
            for title, (_, times, values) in self.seen[path].items():
                before = joined.get(title, (title, [], []))
                joined[title] = title, before[1] + times, before[2] + values
        return joined


def greatest(history: History) -> list[Curve]:
    """Title, times (s) and greatest magnitudes over the machine of the first quantities that it has."""
    curves = []
    rollers = [label.words for label in history.case.gear.wheel_labels if label.kind == "roller"]
    for name in (name for name in LIVE if history.has(name)):
        quantity = catalogue.for_reading(history.quantity(name).astype(float))
        unit = quantity.attrs.get("units", "")
        label = catalogue.QUANTITIES[name].label
        if "wheel" in quantity.dims:
            quantity = quantity.sel(wheel=rollers)
            label = "force on a roller"
        if "axis" in quantity.dims:
            quantity = (quantity**2).sum("axis") ** 0.5
        others = [dimension for dimension in quantity.dims if dimension != "time"]
        step = -(-quantity.sizes["time"] // POINTS)
        values = abs(quantity).max(others).values[::step]
        title = f"greatest {label} in {unit}"
        curves.append((title, history.time.values[::step].tolist(), values.round(4).tolist()))
    return curves[:CURVES]


def curve_figure(curve: Curve, end: float) -> dict[str, Any]:
    """Figure of a curve over a run that ends at a time, s."""
    title, times, values = curve
    trace = {"type": "scatter", "x": times, "y": values, "line": {"color": COLOUR, "width": 1.5}}
    layout = {
        "margin": MARGINS,
        "title": {"text": title, "font": {"size": 13}, "x": 0.02},
        "xaxis": {"title": {"text": "time in s"}, "range": [0.0, end]},
        "yaxis": {"rangemode": "tozero"},
    }
    return {"data": [trace], "layout": layout, "config": {"displaylogo": False, "responsive": True}}


class RunPanel:
    """What a run of the case costs, all runs of the folder, and the curves of the one at work."""

    def __init__(self, document: Document, runs: Runs, show_results: Callable[[str], None]) -> None:
        self.document = document
        self.runs = runs
        self.show_results = show_results
        self.version = -1
        self.rows: dict[str, RunRow] = {}
        self.curves: Curves | None = None
        self.drawn: dict[str, Curve] = {}
        with ui.column().classes("panel wide"):
            self.cost = ui.column().classes("notes")
            ui.label("Runs").classes("part")
            self.none = ui.label("None yet: the button Run, above, starts the case as it stands.").classes(
                "quiet"
            )
            self.list = ui.column().classes("w-full")
            self.plots = [ui.plotly({}).classes("curve") for _ in range(CURVES)]
            for plot in self.plots:
                plot.set_visibility(False)

    async def refresh(self) -> None:
        """Show what has changed of the case and of all runs."""
        if self.version != self.document.version:
            self.version = self.document.version
            case_file = self.document.case_file
            self.cost.clear()
            with self.cost:
                for line in (*run_lines(case_file), times_line(rule_of_thumb(case_file))):
                    ui.label(line).classes("quiet")
        found = self.runs.all()
        if [run.name for run in found] != list(self.rows):
            self._list(found)
        for run in found:
            self.rows[run.name].show(run)
        self.none.set_visibility(not found)
        await self._draw(found)

    def _list(self, found: list[Run]) -> None:
        self.list.clear()
        with self.list:
            self.rows = {run.name: RunRow(run, self.runs, self.show_results) for run in found}

    async def _draw(self, found: list[Run]) -> None:
        """Draw the curves of the run at work, else of the newest that has some."""
        shown = next((run for run in found if run.status == RUNNING), next(iter(found), None))
        if shown is None:
            return
        if self.curves is None or self.curves.folder != shown.folder:
            self.curves = Curves(shown)
            self.drawn = {}
        curves = await threads.io_bound(self.curves.read, shown)
        if curves is None or curves == self.drawn:
            return
        self.drawn = curves
        for number, plot in enumerate(self.plots):
            plot.set_visibility(number < len(curves))
        for plot, curve in zip(self.plots, curves.values(), strict=False):
            plot.update_figure(curve_figure(curve, curve[1][-1]))


class RunRow:
    """One run in the list, and what can be done with it."""

    def __init__(self, run: Run, runs: Runs, show_results: Callable[[str], None]) -> None:
        self.runs = runs
        name = run.name
        with ui.card().classes("run w-full").props(f'data-run="{name}"'):
            with ui.row().classes("items-center w-full"):
                self.icon = ui.icon("schedule")
                ui.label(name).classes("part")
                self.status = ui.label().classes("grow").props('data-testid="status"')
                self.stop = ui.button("Stop", icon="stop", on_click=partial(runs.stop, name)).props(
                    "flat dense"
                )
                self.drop = ui.button("Take out", on_click=partial(runs.withdraw, name)).props("flat dense")
                self.on = ui.button("Go on", icon="play_arrow", on_click=partial(runs.go_on, name)).props(
                    "flat dense"
                )
                self.see = ui.button("Results", icon="insights", on_click=partial(show_results, name))
                self.see.props("flat dense")
            self.bar = ui.linear_progress(0.0, show_value=False).props("instant-feedback")
            self.parts = ui.label().classes("quiet")
            self.lines = ui.label().classes("refused console")

    def show(self, run: Run) -> None:
        """Show how far a run is."""
        self.icon.set_name(ICONS.get(run.status, "help"))
        at_work = run.status == RUNNING
        part = run.progress if at_work else {}
        total = part.get("total")
        done = min(1.0, part["done"] / total) if total else 0.0
        said = f"{run.status}: {part['title']}" if part else run.status
        self.status.set_text(f"{said}, {100.0 * done:.0f} %" if total else said)
        self.bar.set_visibility(at_work)
        self.bar.set_value(done)
        ended = ", ".join(f"{name} {time:.3g} s" for name, time in run.record.get("stages_s", {}).items())
        self.parts.set_text(f"done: {ended}" if ended else "")
        self.parts.set_visibility(bool(ended))
        error = run.record.get("error") or run.last_lines() if run.status in GOES_ON else ""
        self.lines.set_text(error)
        self.lines.set_visibility(bool(error))
        self.stop.set_visibility(at_work)
        self.drop.set_visibility(run.status == WAITING)
        self.on.set_visibility(run.status in GOES_ON)
        self.see.set_visibility(run.has_page)
