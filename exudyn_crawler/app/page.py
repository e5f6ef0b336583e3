"""Page to work in: steps from a machine to its results, for one document and the runs of one folder."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from nicegui import app, ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.app.ground import GroundPanel
from exudyn_crawler.app.machine import Drawing, FilePanel, MachinePanel
from exudyn_crawler.app.results import CheckPanel, ResultsPanel
from exudyn_crawler.app.running import RunPanel
from exudyn_crawler.run.folder.queue import Runs

STYLE = Path(__file__).with_name("page.css")
POLL = 0.5
"""Time (s) between checks of the document and the runs, which other pages and processes change, too."""
MACHINE = "Machine"
GROUND = "Ground and duty"
SHOE = "Shoe"
RUN = "Run"
RESULTS = "Results"
CHECK = "Check and assess"
FILE = "File"
TABS = (MACHINE, GROUND, SHOE, RUN, RESULTS, CHECK, FILE)


def build(folder: Path) -> Callable[[], object]:
    """Return a function that fills a page for a folder; waiting runs start in turn, also without a page."""
    document = Document(folder)
    runs = Runs(folder)
    app.on_startup(lambda: app.timer(POLL, runs.start_next))
    return lambda: Page(document, runs)


class Page:
    """Open page; all open pages share the document and the runs."""

    def __init__(self, document: Document, runs: Runs) -> None:
        self.document = document
        self.runs = runs
        self.version = -1
        self.makers: dict[str, Callable[[], Any]] = {
            MACHINE: lambda: MachinePanel(document),
            GROUND: lambda: GroundPanel(document),
            # the import of shoe recognition takes a second and waits until it is needed
            SHOE: lambda: import_module("exudyn_crawler.app.shoe").ShoePanel(document),
            RUN: lambda: RunPanel(document, runs, self.show_results),
            RESULTS: lambda: ResultsPanel(runs, document.folder),
            CHECK: lambda: CheckPanel(document),
            FILE: lambda: FilePanel(document),
        }
        self.panels: dict[str, Any] = {}
        ui.add_css(STYLE.read_text(encoding="utf-8"))
        with ui.header().classes("bar items-center"):
            self.title = ui.label().classes("grow title").props('data-testid="title"')
            run = ui.button("Run", icon="play_arrow", on_click=self.run)
            run.props('data-testid="run" color="positive"')
        with ui.tabs(on_change=self._enter).classes("tabs") as self.tabs:
            self.tabs.props("align=left no-caps outside-arrows mobile-arrows")
            for name in TABS:
                ui.tab(name)
        with ui.element("div").classes("work"):
            with self._shown_with(MACHINE, GROUND).classes("left"):
                self.places = {name: self._shown_with(name) for name in (MACHINE, GROUND)}
            with self._shown_with(MACHINE, GROUND).classes("right"):
                self.drawing = Drawing(document)
            self.places |= {name: self._shown_with(name).classes("wide") for name in TABS[2:]}
        self.tabs.set_value(MACHINE)
        ui.timer(POLL, self.look)

    def _shown_with(self, *names: str) -> ui.element:
        """Return an element that is visible with some of the tabs."""
        return ui.element("div").bind_visibility_from(self.tabs, "value", backward=lambda name: name in names)

    def _enter(self) -> None:
        """Fill the panel of a tab when it is first opened."""
        name = self.tabs.value
        if name not in self.panels:
            with self.places[name]:
                self.panels[name] = self.makers[name]()
            self.version = -1
        ui.timer(0.0, self.look, once=True)

    async def look(self) -> None:
        """Show changes of the case, and those of the runs if they are visible."""
        if self.version != self.document.version:
            self.version = self.document.version
            is_saved = self.document.text == self.document.saved
            name = f"{self.document.case_file.case.name}: {self.document.name}.toml"
            self.title.set_text(name if is_saved else f"{name}, not saved")
            self.drawing.refresh()
            for name in {MACHINE, GROUND, FILE} & self.panels.keys():
                self.panels[name].refresh()
        if self.tabs.value == RUN:
            await self.panels[RUN].refresh()
        elif self.tabs.value == RESULTS:
            self.panels[RESULTS].refresh()

    def show_results(self, name: str) -> None:
        """Show the results of a run by its name."""
        self.tabs.set_value(RESULTS)
        self.panels[RESULTS].choose(name)

    def run(self) -> None:
        """Add a run of the current case to the queue."""
        if self.document.errors:
            ui.notify("some values are refused: the form marks them in red", type="warning")
            return
        name = self.runs.add(self.document.case_file, self.document.name)
        self.tabs.set_value(RUN)
        ui.notify(f"{name} is in the queue")
