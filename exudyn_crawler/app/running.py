"""Runs on the page: cost, queue, progress of all parts, curves."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import xarray as xr
from nicegui import run as threads, ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.files import HISTORY
from exudyn_crawler.machines.case_file import run_lines
from exudyn_crawler.results.history import History
from exudyn_crawler.results.history.summary import greatest_over_time
from exudyn_crawler.run.folder import checkpoints
from exudyn_crawler.run.folder.progress import rule_of_thumb, times_line
from exudyn_crawler.run.folder.queue import GOES_ON, RUNNING, WAITING, Run, Runs
from exudyn_crawler.views.scenes.plots import curve_figure

LIVE = ("link_tension", "wheel_force", "roller_force", "drive_moment", "contact_force")
"""Quantities with curves of their greatest value over the machine."""
Curves = dict[str, xr.DataArray]
Parts = dict[tuple[Path, int], Curves]
"""Curves by file and the time of its last change."""


class RunPanel:
    """Panel of the cost of a run, all runs of the folder, and curves of the one at work or the newest."""

    def __init__(self, document: Document, runs: Runs, show_results: Callable[[str], None]) -> None:
        self.document = document
        self.runs = runs
        self.show_results = show_results
        self.version = -1
        self.rows: dict[str, RunRow] = {}
        self.drawn = ""  # run whose curves are drawn
        self.parts: Parts = {}  # curves of its files read so far
        self.plots: dict[str, ui.plotly] = {}
        with ui.column().classes("panel"):
            self.cost = ui.label().classes("quiet console").props('data-testid="cost"')
            self.curves = ui.element("div").classes("curves").props('data-testid="curves"')
            self.list = ui.column().classes("w-full")

    async def refresh(self) -> None:
        """Show changes of the case and of all runs."""
        if self.version != self.document.version:
            self.version = self.document.version
            case_file = self.document.case_file
            self.cost.set_text("\n".join([*run_lines(case_file), times_line(rule_of_thumb(case_file))]))
        runs = self.runs.all()
        if [run.name for run in runs] != list(self.rows):
            self.list.clear()
            with self.list:
                self.rows = {run.name: RunRow(run.name, self.runs, self.show_results) for run in runs}
        for run in runs:
            self.rows[run.name].show(run)
        if (shown := shown_run(runs)) is not None:
            await self._draw(shown)

    async def _draw(self, run: Run) -> None:
        """Draw the curves of a run; those of another one stay until it has some."""
        is_new = self.drawn != run.name
        parts = {} if is_new else self.parts
        seen = set(parts)
        curves = await threads.io_bound(joined_curves, run.folder, parts)
        if not curves or (not is_new and set(parts) == seen):
            return
        if is_new or self.plots.keys() != curves.keys():
            self.plots = {}
            self.curves.clear()
            with self.curves:
                ui.label(f"{run.name}: greatest over the machine").classes("part w-full")
        self.drawn, self.parts = run.name, parts
        for title, values in curves.items():
            if title not in self.plots:
                with self.curves:
                    self.plots[title] = ui.plotly({}).classes("curve")
            self.plots[title].update_figure(curve_figure(title, values))


def shown_run(runs: list[Run]) -> Run | None:
    """Return the run whose curves are drawn: the one at work, else the newest that has a history."""
    at_work = (run for run in runs if run.status == RUNNING)
    ended = (run for run in runs if (run.folder / HISTORY).is_file())
    return next(at_work, next(ended, None))


class RunRow:
    """Row of a run in the list, with its buttons."""

    def __init__(self, name: str, runs: Runs, show_results: Callable[[str], None]) -> None:
        with ui.card().classes("run w-full").props(f'data-run="{name}"'):
            with ui.row().classes("items-center w-full"):
                ui.label(name).classes("part")
                self.status = ui.label().classes("grow")
                self.stop = ui.button("Stop", icon="stop", on_click=partial(runs.stop, name))
                self.on = ui.button("Go on", icon="play_arrow", on_click=partial(runs.go_on, name))
                self.results = ui.button("Results", icon="insights", on_click=partial(show_results, name))
                for button in (self.stop, self.on, self.results):
                    button.props("flat dense")
            self.bar = ui.linear_progress(0.0, show_value=False).props("instant-feedback")
            self.parts = ui.label().classes("quiet")
            self.error = ui.label().classes("refused console")

    def show(self, run: Run) -> None:
        """Show the progress of a run."""
        part = run.progress if run.status == RUNNING else {}
        total = part.get("total")
        share = min(1.0, part["done"] / total) if total else 0.0
        title = f", {part['title']}" if part else ""
        self.status.set_text(
            f"{run.status}{title}, {100.0 * share:.0f} %" if total else f"{run.status}{title}"
        )
        self.bar.set_value(share)
        self.bar.set_visibility(run.status == RUNNING)
        ended = ", ".join(f"{name} {time:.3g} s" for name, time in run.record.get("stages_s", {}).items())
        self.parts.set_text(f"parts done: {ended}" if ended else "")
        self.error.set_text(run.error)
        self.stop.set_visibility(run.status in (RUNNING, WAITING))
        self.on.set_visibility(run.status in GOES_ON)
        self.results.set_visibility(run.page.is_file())


def joined_curves(folder: Path, parts: Parts) -> Curves:
    """Return the greatest values over the machine, of the whole history if it is there, else of all stages.

    `parts` caches the curves of files that have not changed.
    """
    history = folder / HISTORY
    is_whole = history.is_file()
    keys = []
    for path in [history] if is_whole else checkpoints.stage_files(folder):
        try:
            key = path, path.stat().st_mtime_ns
            if key not in parts:
                read = History.load(path) if is_whole else checkpoints.stage_history(path)
                parts[key] = greatest_over_time(read, LIVE)
        except (ValueError, FileNotFoundError):
            # the run ends now and removes its checkpoints
            return {}
        keys.append(key)
    titles = parts[keys[0]] if keys else {}
    return {title: xr.concat([parts[key][title] for key in keys], "time") for title in titles}
