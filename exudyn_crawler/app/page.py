"""The page: steps from a machine to its results, over one document and the runs of one folder."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import app, run as threads, ui

if TYPE_CHECKING:
    from exudyn_crawler.app.document import Document
    from exudyn_crawler.app.runs import Runs

STYLE = Path(__file__).with_name("page.css")
POLL = 0.5
"""S between looks at the document and the runs, which other pages and processes change, too."""
MACHINE, GROUND, SHOE, RUN, RESULTS, CHECK, FILE = TABS = (
    *("Machine", "Ground and duty", "Shoe", "Run", "Results"),
    *("Check and assess", "File"),
)


class Workplace:
    """Document and runs of a folder, which all pages share; they are loaded while the first page is shown."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.document: Document | None = None
        self.runs: Runs | None = None

    def load(self) -> None:
        """Load all that the page needs, a second or two."""
        from exudyn_crawler.app import machine, results, running, shoe  # noqa: F401 - modules of the panels
        from exudyn_crawler.app.document import Document
        from exudyn_crawler.app.runs import Runs

        if self.document is None:
            self.runs = Runs(self.folder)
            self.document = Document(self.folder)


def build(folder: Path) -> Callable[[str], None]:
    """Function that fills a page over a folder; runs that wait start one after the other, page or not."""
    work = Workplace(folder)

    async def begin() -> None:
        await threads.io_bound(work.load)
        # nothing is loaded where the program ends meanwhile
        if work.runs is not None:
            app.timer(POLL, work.runs.start_next)

    app.on_startup(begin)
    return lambda files: Page(work, files).open()


class Page:
    """One open page."""

    def __init__(self, work: Workplace, files: str) -> None:
        self.work = work
        self.files = files
        self.version = -1

    def open(self) -> None:
        """Show at once that something comes, and fill the page when it is loaded."""
        ui.add_css(STYLE.read_text(encoding="utf-8"))
        self.wait = ui.column().classes("wait")
        with self.wait:
            ui.spinner(size="lg")
            ui.label("exudyn-crawler: the machines are being loaded")
        timer = ui.timer(0.1, lambda: self.fill() if self._is_ready(timer) else None)

    def _is_ready(self, timer: ui.timer) -> bool:
        if self.work.document is None:
            return False
        timer.cancel()
        return True

    def fill(self) -> None:
        """Make everything that is on the page."""
        from exudyn_crawler.app.machine import Drawing, FilePanel, GroundPanel, MachinePanel
        from exudyn_crawler.app.results import CheckPanel, ResultsPanel
        from exudyn_crawler.app.running import RunPanel
        from exudyn_crawler.app.shoe import ShoePanel

        assert self.work.document is not None
        assert self.work.runs is not None
        self.document = self.work.document
        self.runs = self.work.runs
        self.wait.delete()
        with ui.header().classes("bar items-center"):
            ui.label("exudyn-crawler").classes("brand")
            self.title = ui.label().classes("grow title").props('data-testid="title"')
            ui.button("Save", icon="save", on_click=self.ask_name).props(
                'flat color="white" data-testid="save"'
            )
            ui.button("Run", icon="play_arrow", on_click=self.run).props('data-testid="run" color="positive"')
        with ui.tabs(on_change=self._enter).classes("tabs") as self.tabs:
            self.tabs.props("align=left no-caps outside-arrows mobile-arrows")
            for name in TABS:
                ui.tab(name)
        with ui.element("div").classes("work"):
            with self._shown_with(MACHINE, GROUND).classes("left"):
                self.places = {name: self._shown_with(name) for name in (MACHINE, GROUND)}
            with self._shown_with(MACHINE, GROUND).classes("right"):
                self.drawing = Drawing(self.document)
            self.places |= {name: self._shown_with(name).classes("wide") for name in TABS[2:]}
        self.fillers: dict[str, Callable[[], Any]] = {
            MACHINE: lambda: MachinePanel(self.document, self.look),
            GROUND: lambda: GroundPanel(self.document),
            SHOE: lambda: ShoePanel(self.document),
            RUN: lambda: RunPanel(self.document, self.runs, self.show_results),
            RESULTS: lambda: ResultsPanel(self.document, self.runs, self.files),
            CHECK: lambda: CheckPanel(self.document, self.files, self.saved),
            FILE: lambda: FilePanel(self.document, self.look),
        }
        self.panels: dict[str, Any] = {}
        self.tabs.set_value(MACHINE)
        self.look()
        ui.timer(POLL, self.look)
        ui.timer(2.0 * POLL, self.look_at_runs)

    def _shown_with(self, *names: str) -> ui.element:
        """Element that is shown with some of the tabs."""
        return ui.element("div").bind_visibility_from(self.tabs, "value", backward=lambda name: name in names)

    def _enter(self) -> None:
        """Fill the place of the tab that is seen for the first time."""
        name = self.tabs.value
        if name not in self.panels:
            with self.places[name]:
                self.panels[name] = self.fillers[name]()
            self.version = -1

    def look(self) -> None:
        """Show what has changed of the case."""
        if self.version == self.document.version:
            return
        self.version = self.document.version
        is_saved = "" if self.document.is_saved else ", not saved"
        self.title.set_text(f"{self.document.case_file.case.name}: {self.document.name}.toml{is_saved}")
        self.drawing.refresh()
        for name in (MACHINE, GROUND, FILE):
            if name in self.panels:
                self.panels[name].refresh()

    async def look_at_runs(self) -> None:
        """Show what has changed of the runs, where they are seen."""
        if self.tabs.value == RUN:
            await self.panels[RUN].refresh()
        elif self.tabs.value == RESULTS:
            self.panels[RESULTS].refresh()

    def show_results(self, name: str) -> None:
        """Show the results of a run of a name."""
        self.tabs.set_value(RESULTS)
        self.panels[RESULTS].choose(name)

    def ask_name(self) -> None:
        """Ask for the name under which the case file is saved."""
        with ui.dialog(value=True) as dialog, ui.card():
            name = ui.input("name of the case file", value=self.document.name, suffix=".toml")
            name.props('autofocus data-testid="name"')
            with ui.row():
                ui.button("Save", on_click=lambda: self._save(dialog, name.value)).props(
                    'data-testid="save-as"'
                )
                ui.button("Cancel", on_click=dialog.close).props("flat")

    def _save(self, dialog: Any, name: str, overwrite: bool = False) -> None:
        try:
            path = self.document.save(Path(name).name, overwrite)
        except FileExistsError as error:
            ui.notify(f"{error}; choose another name", type="warning")
        except OSError as error:
            ui.notify(str(error), type="negative")
        else:
            dialog.close()
            ui.notify(f"saved as {path.name}")

    def saved(self) -> Path | None:
        """Save the case as it stands, under a name that no other file has; None if it cannot be."""
        name = self.document.name
        number = 1
        while True:
            try:
                return self.document.save(name)
            except FileExistsError:
                number += 1
                name = f"{self.document.name.rpartition('_')[0] or self.document.name}_{number}"
            except OSError as error:
                ui.notify(str(error), type="negative")
                return None

    def run(self) -> None:
        """Save the case as it stands, and let its run wait for its turn."""
        if self.document.errors:
            ui.notify("some values are refused: they stand in red in the form", type="warning")
            return
        path = self.saved()
        if path is None:
            return
        name = self.runs.free_name(path.stem)
        self.runs.add(self.document.case_file, name)
        self.tabs.set_value(RUN)
        ui.notify(f"{name} is in the queue")
