"""Results: the page of a run, two runs beside each other, life, and everything that a run has left."""

import asyncio
from collections.abc import Callable
from pathlib import Path
from urllib.parse import quote

import pandas as pd
import tomlkit
from nicegui import run as threads, ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.app.runs import COMMAND, Runs
from exudyn_crawler.case import read_case
from exudyn_crawler.case.parameters import fields
from exudyn_crawler.files import whole_file, writable_folder
from exudyn_crawler.results.history import History
from exudyn_crawler.results.history.summary import key_results
from exudyn_crawler.results.life.duty import FatigueMaterial
from exudyn_crawler.run.folder import record
from exudyn_crawler.views.pages.first_screen import ANSWERS, value_and_place
from exudyn_crawler.views.pages.runs import stress_of

REPORT = "report.html"
SAVED = (".html", ".csv", ".png", ".mp4", ".nc", ".toml", ".pdf", ".svg")
"""Ends of the names of files that are offered."""
MADE = "pages"
"""Folder, beside the runs, of pages that are made of several or of none."""


async def command(folder: Path, *words: str) -> tuple[bool, str]:
    """Call a command of the program as a process in a folder: whether it ended well, and what it has said."""
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(
        *COMMAND,
        *words,
        cwd=folder,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=pipe,
        stderr=asyncio.subprocess.STDOUT,
    )
    out, _ = await process.communicate()
    return process.returncode == 0, out.decode(errors="replace").strip()


class PageFrame:
    """Page of a file of the folder, or what is said in its place."""

    def __init__(self, folder: Path, files: str) -> None:
        self.folder = folder
        self.files = files
        self.shown: tuple[Path, int] | None = None
        self.spinner = ui.spinner(size="lg")
        self.spinner.set_visibility(False)
        self.words = ui.label().classes("console")
        self.frame = ui.element("iframe").classes("frame").props('title="page" data-testid="frame"')
        self.frame.set_visibility(False)

    def address(self, path: Path) -> str:
        """Address of a file of the folder."""
        return self.files + quote(path.relative_to(self.folder).as_posix())

    def show(self, path: Path) -> None:
        """Show a page where it is another one than before."""
        now = path, path.stat().st_mtime_ns
        if now != self.shown:
            self.shown = now
            self.frame.props["src"] = self.address(path)
            self.frame.update()
        self.words.set_text("")
        self.frame.set_visibility(True)

    async def show_made(self, page: Path, *words: str) -> None:
        """Show a page that a command makes, else what it says is wrong."""
        self.frame.set_visibility(False)
        self.words.set_text("")
        self.spinner.set_visibility(True)
        try:
            is_made, said = await command(self.folder, *words)
        finally:
            self.spinner.set_visibility(False)
        if is_made and page.is_file():
            self.show(page)
        else:
            self.words.set_text(said)


def answers(folder: Path) -> pd.DataFrame:
    """Key results of a run."""
    return key_results(History.load(folder / record.HISTORY), stress_of(folder)).head(ANSWERS)


class ResultsPanel:
    """Results of a run: answers first, as its page has them."""

    def __init__(self, document: Document, runs: Runs, files: str) -> None:
        self.document = document
        self.runs = runs
        self.folder = document.folder
        self.names: list[str] = []
        with ui.column().classes("panel wide"):
            self.choices = ui.row().classes("items-center w-full")
            with self.choices:
                self.run = (
                    ui.select([], label="run")
                    .props('outlined dense data-testid="results-of"')
                    .classes("choice")
                )
                self.other = (
                    ui.select([], label="beside")
                    .props('outlined dense clearable data-testid="beside"')
                    .classes("choice")
                )
                self.life = ui.select(self._materials(), label="life, of a material").props("outlined dense")
                self.life.classes("choice").on_value_change(self._show_life)
                self.open = ui.link("open it by itself", "", new_tab=True)
                self.again = ui.button("Work on its case", on_click=self._work_on).props("flat dense")
            self.none = ui.label("No run has ended yet.").classes("quiet")
            self.answers = ui.row().classes("answers").props('data-testid="answers"')
            self.frame = PageFrame(self.folder, files)
            self.save = ui.expansion("Save: everything that the run has left").classes("section")
            with self.save:
                self.left = ui.column().classes("files")
        self.run.on_value_change(self._show)
        self.other.on_value_change(self._show)

    @staticmethod
    def _materials() -> list[str]:
        return [*fields.named_values(FatigueMaterial)]

    def choose(self, name: str) -> None:
        """Show the results of a run of a name."""
        self.refresh()
        self.other.set_value(None)
        if name in self.names:
            self.run.set_value(name)

    def refresh(self) -> None:
        """Show which runs there are."""
        names = [run.name for run in self.runs.all() if run.has_page]
        if names != self.names:
            self.names = names
            self.run.set_options(names)
            self.other.set_options(names)
            if self.run.value is None and names:
                self.run.set_value(names[0])
        self.none.set_visibility(not names)
        self.choices.set_visibility(bool(names))
        self.save.set_visibility(bool(names))

    async def _show(self) -> None:
        name = self.run.value
        if name is None:
            return
        run = self.runs.named(name)
        page = run.folder / REPORT
        beside = None if self.other.value == name else self.other.value
        self.other.set_options([other for other in self.names if other != name], value=beside)
        self.life.set_visibility((run.folder / "stress.nc").is_file())
        self.answers.clear()
        rows = await threads.io_bound(answers, run.folder)
        with self.answers:
            for row in [] if rows is None else rows.itertuples():
                value, place = value_and_place(row)
                with ui.column().classes("answer"):
                    ui.label(row.result).classes("quiet")
                    ui.label(value).classes("value")
                    ui.label(place).classes("quiet")
        self.left.clear()
        with self.left:
            for path in sorted(run.folder.iterdir()):
                if path.suffix in SAVED:
                    ui.link(path.name, self.frame.address(path)).props(f'download="{name}_{path.name}"')
        self.open.props["href"] = self.frame.address(page)
        self.open.update()
        if self.other.value in (None, name):
            self.frame.show(page)
            return
        made = writable_folder(self.folder / MADE) / f"{name}_{self.other.value}.html"
        folders = (str(run.folder), str(self.runs.named(self.other.value).folder))
        await self.frame.show_made(made, "compare", *folders, "--out", str(made), "--overwrite")
        self.open.props["href"] = self.frame.address(made)
        self.open.update()

    async def _show_life(self) -> None:
        """Show the life of the shoes where the run is all that the machine does."""
        name = self.run.value
        if name is None or self.life.value is None:
            return
        duty = writable_folder(self.folder / MADE) / f"{name}_duty.toml"
        content = {
            "name": f"{name}, all hours",
            "material": {fields.BASE: self.life.value},
            "runs": [{"name": name, "folder": str(self.runs.named(name).folder), "share": 1.0}],
        }
        with whole_file(duty, overwrite=True) as temporary:
            temporary.write_text(tomlkit.dumps(content), encoding="utf-8")
        out = duty.with_name(f"{name}_life")
        await self.frame.show_made(out / "life.html", "life", str(duty), "--out", str(out), "--overwrite")

    def _work_on(self) -> None:
        if self.run.value is not None:
            case_file = read_case(self.runs.named(self.run.value).folder / record.CASE)
            self.document.start_with(case_file, self.run.value)
            ui.notify(f"the case of {self.run.value} is in the form")


class CheckPanel:
    """Check and assessment without a run."""

    def __init__(self, document: Document, files: str, save: Callable[[], Path | None]) -> None:
        self.document = document
        self.save = save
        with ui.column().classes("panel wide"):
            ui.label("By formulas and static cases, without a run.").classes("quiet")
            with ui.row().classes("items-center"):
                ui.button("Assess the machine", icon="rule", on_click=self.assess).props(
                    'data-testid="assess"'
                )
                ui.label("ground pressure, tipping, travel, utilisation of parts").classes("quiet")
            with ui.row().classes("items-center"):
                ui.button("Check the shoe", icon="fact_check", on_click=self.check).props(
                    'data-testid="check"'
                )
                ui.label("which static case cracks the flexible shoe, and where").classes("quiet")
            self.frame = PageFrame(document.folder, files)

    async def assess(self) -> None:
        """Assess the machine of the case as it stands."""
        await self._made("assess", "assessment.html")

    async def check(self) -> None:
        """Check the flexible shoe of the case as it stands."""
        await self._made("check", "check.html", "--no-pictures")

    async def _made(self, word: str, page: str, *options: str) -> None:
        case = self.save()
        if case is None:
            return
        out = self.document.folder / MADE / f"{case.stem}_{word}"
        await self.frame.show_made(out / page, word, str(case), "--out", str(out), "--overwrite", *options)
