"""Results: page of a run, comparison of two runs, life, checks, and all files of these."""

import asyncio
import os
from collections.abc import Awaitable, Callable
from pathlib import Path
from urllib.parse import quote

import tomlkit
from nicegui import ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.app.serving import FILES
from exudyn_crawler.files import whole_file, writable_folder
from exudyn_crawler.machines import write_case
from exudyn_crawler.run.folder.queue import COMMAND, IN_UTF8, Runs
from exudyn_crawler.settings import fields

SAVED = (".html", ".csv", ".png", ".mp4", ".nc", ".toml", ".pdf", ".svg")
"""Suffixes of files offered for saving."""
BUSY = "computing, for a minute or two"
"""Text while a command works; an animation would take half of a core where software draws it."""
SHARE = "share of the machine hours, %"
"""Label of the field for the share of all machine hours for which a run stands in a life."""
MADE = "pages"
"""Folder, beside the runs, of pages on several runs or on none."""


async def command(folder: Path, *words: object) -> tuple[bool, str]:
    """Run a command of the program as a process in a folder; return True if it succeeded, and its output."""
    process = await asyncio.create_subprocess_exec(
        *COMMAND,
        *map(str, words),
        cwd=folder,
        env=os.environ | IN_UTF8,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
    )
    out, _ = await process.communicate()
    return process.returncode == 0, out.decode(errors="replace").strip()


class PageFrame:
    """Frame of a page of the folder, or a message in its place, and all files beside the page for saving."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.page: Path | None = None
        self.shown = ""  # its shown address
        self.busy = ui.label(BUSY).classes("quiet")
        self.busy.set_visibility(False)
        self.words = ui.label().classes("console")
        self.save = ui.expansion("Save: everything that was made").classes("section")
        self.save.props('data-testid="saved"').set_visibility(False)
        self.frame = ui.element("iframe").classes("frame").props('title="page" data-testid="frame"')
        self.frame.set_visibility(False)

    def show(self, page: Path) -> None:
        """Show a page and the files beside it."""
        self.words.set_text("")
        self.page = page
        self.shown = self._version(page)
        self.frame.props["src"] = self.shown
        self.frame.update()
        self.frame.set_visibility(True)
        self.save.set_visibility(True)
        self.save.clear()
        with self.save, ui.element("div").classes("files"):
            for path in sorted(page.parent.iterdir()):
                if path.suffix in SAVED:
                    name = f"{page.parent.name}_{path.name}"
                    ui.link(path.name, self._address(path)).props(f'download="{name}"')

    def refresh(self) -> None:
        """Show the page again if its file was rewritten."""
        if self.page is not None and self.page.is_file() and self._version(self.page) != self.shown:
            self.show(self.page)

    def _version(self, page: Path) -> str:
        """Return the current address of a page: a browser loads an unchanged address only once."""
        return f"{self._address(page)}?written={page.stat().st_mtime_ns}"

    def _address(self, path: Path) -> str:
        return f"{FILES}/{quote(path.relative_to(self.folder).as_posix())}"

    async def show_made(self, page: Path, *words: object) -> None:
        """Show the page that a command makes, or the errors of the command."""
        self.page = None
        self.frame.set_visibility(False)
        self.save.set_visibility(False)
        self.words.set_text("")
        self.busy.set_visibility(True)
        is_made, said = await command(self.folder, *words)
        self.busy.set_visibility(False)
        if is_made:
            self.show(page)
        else:
            self.words.set_text(said)


class ResultsPanel:
    """Panel of a run's page, answers first, of its comparison with another run, and of life."""

    def __init__(self, runs: Runs, folder: Path) -> None:
        self.runs = runs
        self.made = folder / MADE
        with ui.column().classes("panel"):
            with ui.row().classes("items-center w-full"):
                self.run = self._choice("run", self._show)
                self.other = self._choice("beside", self._beside)
                self.life = self._choice("life, of a material", self._live)
                self.share = ui.number(SHARE, min=0.1, max=100.0, on_change=self._live).classes("choice")
                self.share.props(f'outlined dense debounce=800 data-testid="{SHARE}"')
            self.frame = PageFrame(folder)

    @staticmethod
    def _choice(label: str, chosen: Callable[[], Awaitable[None]]) -> ui.select:
        select = ui.select([], label=label, on_change=chosen).classes("choice")
        return select.props(f'outlined dense data-testid="{label}"')

    def refresh(self) -> None:
        """Show the present runs."""
        names = [run.name for run in self.runs.all() if run.page.is_file()]
        if names != self.run.options:
            self.run.set_options(names)
            self.choose(self.run.value or next(iter(names), None))
        self.frame.refresh()

    def choose(self, name: str | None) -> None:
        """Show the results of a run by its name."""
        self.run.set_value(name)

    async def _show(self) -> None:
        if self.run.value is None:
            return
        run = self.runs.named(self.run.value)
        self.other.set_options([name for name in self.run.options if name != run.name], value=None)
        # imports of a second wait until they are needed
        from exudyn_crawler.results.life.duty import FatigueMaterial
        from exudyn_crawler.views.pages.runs import STRESSES

        is_bent = (run.folder / STRESSES).is_file()
        self.life.set_options([*fields.named_values(FatigueMaterial)], value=None)
        self.life.set_visibility(is_bent)
        self.share.set_visibility(is_bent)
        self.frame.show(run.page)

    async def _beside(self) -> None:
        """Show the differences between two runs."""
        if self.other.value is None:
            return
        first = self.runs.named(self.run.value)
        second = self.runs.named(self.other.value)
        out = writable_folder(self.made / f"{first.name} and {second.name}") / "compared.html"
        words = "compare", first.folder, second.folder, "--out", out, "--overwrite"
        await self.frame.show_made(out, *words)

    async def _live(self) -> None:
        """Show the life of the shoes, once material and share of the machine hours are given."""
        share = self.share.value
        if self.life.value is None or share is None or not 0.0 < share <= 100.0:
            return
        run = self.runs.named(self.run.value)
        out = writable_folder(self.made / f"{run.name} life")
        content = {
            "name": f"{run.name}, {share:g} % of the hours",
            "material": {fields.BASE: self.life.value},
            "runs": [{"name": run.name, "folder": str(run.folder), "share": 0.01 * share}],
        }
        duty = out / "duty.toml"
        with whole_file(duty, overwrite=True) as temporary:
            temporary.write_text(tomlkit.dumps(content), encoding="utf-8")
        await self.frame.show_made(out / "life.html", "life", duty, "--out", out, "--overwrite")


class CheckPanel:
    """Panel of check and assessment without a run."""

    def __init__(self, document: Document) -> None:
        self.document = document
        with ui.column().classes("panel"):
            ui.label("By formulas and static cases, without a run.").classes("quiet")
            with ui.row().classes("items-center"):
                ui.button("Assess the machine", icon="rule", on_click=self.assess)
                ui.label("ground pressure, tipping, travel, utilisation of parts").classes("quiet")
            with ui.row().classes("items-center"):
                ui.button("Check the shoe", icon="fact_check", on_click=self.check)
                ui.label("which static case cracks the flexible shoe, and where").classes("quiet")
            self.frame = PageFrame(document.folder)

    async def assess(self) -> None:
        """Assess the machine of the current case."""
        await self._made("assess", "assessment.html")

    async def check(self) -> None:
        """Check the flexible shoe of the current case."""
        await self._made("check", "check.html", "--no-pictures")

    async def _made(self, word: str, page: str, *options: str) -> None:
        out = writable_folder(self.document.folder / MADE / f"{self.document.name} {word}")
        case = write_case(self.document.case_file, out / f"{self.document.name}.toml", overwrite=True)
        await self.frame.show_made(out / page, word, case, "--out", out, "--overwrite", *options)
