"""Machine, ground and duty: what is chosen from lists, the form, and the track drawn as it will start."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from nicegui import events, ui

from exudyn_crawler.app.document import Document, said
from exudyn_crawler.app.form import FormPart, in_words
from exudyn_crawler.case.datasheet import library
from exudyn_crawler.case.datasheet.files import KEY
from exudyn_crawler.case.datasheet.sheet import Datasheet
from exudyn_crawler.case.parameters import checks, fields
from exudyn_crawler.case.parameters.terrain import CellTerrain, SoilLaw
from exudyn_crawler.views.scenes.plots import side_figure, space_figure
from exudyn_crawler.views.scenes.start import start_solids

SHEET = [f"{KEY}.{name}" for name in Datasheet.model_fields if name not in ("travel", "speed")]
OF_MACHINE = ("shoe", "track", "gear", "flexible", "solver", "outputs")
DUTY = (f"{KEY}.travel", f"{KEY}.speed", "duration", "terrain.grade", "terrain.side_slope")
OF_DUTY = {
    "drive": "drive",
    "machine": "work: dig, slew",
    "loads": "loads on shoes",
    "terrain": "heights",
    "contact": "soil",
}
"""Titles of the tables of ground and duty."""
AHEAD = 1.0
"""M ahead of the foremost shoe at which an obstacle is put at first."""
OBSTACLES: dict[str, dict[str, Any]] = {
    "stone": {"height": 0.1, "width": 0.1, "flank": 0.3, "y": 0.0},
    "ridge": {"height": 0.1, "width": 0.2, "flank": 0.3},
    "rut": {"height": -0.1, "width": 0.3, "flank": 0.3},
    "ramp": {"height": 0.2, "flank": 1.0},
    "waves": {"height": 0.05, "length": 2.0},
}
"""What may lie on the ground, with sizes to begin with."""
MODELS = {"rut": "ridge"}


class Drawing:
    """Track as it will start, from the right and in 3D."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.case: object = None
        with ui.column().classes("drawing"):
            self.side = ui.plotly({}).classes("side-view").props('data-testid="side"')
            self.space = ui.plotly({}).classes("space-view").props('data-testid="space"')
            self.notes = ui.column().classes("notes")

    def refresh(self) -> None:
        """Draw the case again where it is another one."""
        case_file = self.document.case_file
        if case_file.case == self.case:
            return
        self.case = case_file.case
        self.notes.clear()
        with self.notes:
            ui.label("As it will start; shoes have not sunk in yet.").classes("quiet")
            try:
                solids = start_solids(case_file.case)
            except ValueError as error:
                ui.label(str(error)).classes("refused")
                return
            for line in checks.implausible(case_file.case, case_file.duration):
                ui.label(line).classes("warning")
        self.side.update_figure(side_figure(solids))
        self.space.update_figure(space_figure(solids))


class MachinePanel:
    """Where a machine comes from, and its values."""

    def __init__(self, document: Document, started: Callable[[], None]) -> None:
        self.document = document
        self.started = started
        titles = machine_titles()
        with ui.column().classes("panel"):
            self.machine = ui.select(titles, value=document.name if document.name in titles else None)
            self.machine.props('label="machine of the library"')
            self.machine.classes("w-full").props('data-testid="machine" outlined dense').on_value_change(
                self._begin
            )
            with ui.row().classes("items-end w-full"):
                self.file = ui.select([], label="or a case file of this folder", with_input=True)
                self.file.props('data-testid="file" outlined dense').classes("grow").on_value_change(
                    self._load
                )
                ui.upload(label="or drop one here", auto_upload=True, on_upload=self._dropped).props(
                    'accept=".toml" flat bordered'
                ).classes("drop")
            self.sheet = ui.label("What the maker prints").classes("part")
            parts = [
                FormPart(document, SHEET, keeps=lambda entry: entry.value is not None),
                FormPart(document, SHEET, "What it leaves out", keeps=lambda entry: entry.value is None),
            ]
            parts += [FormPart(document, [name], f"All values: {in_words(name)}") for name in OF_MACHINE]
            self.sections = parts

    def refresh(self) -> None:
        """Show the case again, and the files that there are."""
        files = sorted(path.name for path in self.document.folder.glob("*.toml"))
        if files != self.file.options:
            self.file.set_options(files)
        self.sheet.set_visibility(self.document.case_file.datasheet is not None)
        for section in self.sections:
            section.refresh()

    def _begin(self, event: events.ValueChangeEventArguments) -> None:
        if event.value is not None:
            self.document.start_from(event.value)
            self.file.set_value(None)
            self.started()

    def _load(self, event: events.ValueChangeEventArguments) -> None:
        if event.value is not None:
            self._read(self.document.folder / event.value)

    def _read(self, path: Path) -> None:
        try:
            self.document.load(path)
        except (ValueError, OSError) as error:
            ui.notify(str(error), type="negative", multi_line=True, timeout=0, close_button=True)
            return
        self.machine.set_value(None)
        self.started()

    async def _dropped(self, event: events.UploadEventArguments) -> None:
        path = self.document.folder / Path(event.file.name).name
        if path.exists():
            ui.notify(f"{path.name} is in the folder already: it was taken from there")
        else:
            await event.file.save(path)
        self.refresh()
        self._read(path)


class GroundPanel:
    """Ground and duty: soils, slopes and obstacles from lists, what the machine does, and the law drawn."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.law: object = None
        self.soils = soils()
        with ui.column().classes("panel"):
            ui.label("Ground").classes("part")
            self.soil = ui.select([*self.soils], label="soil").props('data-testid="soil" outlined dense')
            self.soil.classes("w-full").on_value_change(self._take_soil)
            self.figure = ui.html("", sanitize=False).classes("figure")
            self.obstacle = ui.select([*OBSTACLES], label="put ahead of the machine").props("outlined dense")
            self.obstacle.classes("w-full").on_value_change(self._put)
            obstacles = FormPart(document, ["terrain.relief.parts"])
            ui.label("What the machine does").classes("part")
            duty = FormPart(document, DUTY, only=True)
            more = [FormPart(document, [name], f"All values: {title}") for name, title in OF_DUTY.items()]
            self.sections = [obstacles, duty, *more]

    def refresh(self) -> None:
        """Show the case again, and draw the law where it is another one."""
        for section in self.sections:
            section.refresh()
        contact = self.document.case_file.case.contact
        law = getattr(contact, "law", None)
        if law == self.law:
            return
        self.law = law
        self.figure.set_content("" if law is None else law_picture(law))

    def _take_soil(self, event: events.ValueChangeEventArguments) -> None:
        if event.value is None:
            return
        law, content = self.soils[event.value]
        case = self.document.case_file.case
        if isinstance(case.terrain, CellTerrain):
            self.document.change({"contact": {"model": "cells", "law": content}})
            return
        # a case on units gets the ground of cells that is as large
        terrain = said(case.on_cells(law).terrain.model_dump(mode="json"))
        self.document.change({"terrain": terrain, "contact": {"model": "cells", "law": content}})

    def _put(self, event: events.ValueChangeEventArguments) -> None:
        if event.value is None:
            return
        case = self.document.case_file.case
        ahead = float(case.outline(0.0)[:, 0].max()) + AHEAD
        part = {"model": MODELS.get(event.value, event.value), "name": event.value, "x": round(ahead, 2)}
        there = self.document.case_file.case.terrain.relief.parts
        number = len(there)
        paths = {f"terrain.relief.parts[{number}]": part | OBSTACLES[event.value]}
        self.document.change(paths)
        self.obstacle.set_value(None)


class FilePanel:
    """Text of the case file, which is all that the form shows."""

    def __init__(self, document: Document, taken: Callable[[], None]) -> None:
        self.document = document
        self.taken = taken
        with ui.column().classes("panel"):
            ui.label("The form and this file are the same. What is typed here is taken with the button.")
            self.text = ui.textarea().classes("text").props('outlined spellcheck="false" data-testid="text"')
            with ui.row():
                ui.button("Take this text", on_click=self._take).props('data-testid="take-text"')
                ui.button("Back to what was", on_click=self.refresh).props("flat")
            self.error = ui.label().classes("refused console")

    def refresh(self) -> None:
        """Show the text as it is taken."""
        self.text.set_value(self.document.text)
        self.error.set_text("")

    def _take(self) -> None:
        try:
            self.document.take_text(self.text.value)
        except (ValueError, OSError) as error:
            self.error.set_text(str(error))
            return
        self.taken()


def machine_titles() -> dict[str, str]:
    """Names of the library's machines for reading."""
    from exudyn_crawler.case import read_case

    return {name: read_case(path).case.name for name, path in library.machines().items()}


def soils() -> dict[str, tuple[SoilLaw, dict[str, str]]]:
    """Ready soils: law, and what a file says of it, by their names."""
    ready = {}
    for kind in SoilLaw.plugged_in():
        tag = fields.tag_of(kind)
        for name, make in fields.named_values(kind).items():
            law = make()
            assert isinstance(law, SoilLaw)
            ready[f"{in_words(name)} ({tag})"] = law, {fields.tag_field(kind): tag, fields.BASE: name}
    return ready


def law_picture(law: SoilLaw) -> str:
    """Picture of a law, pressure over sinkage and shear over slip, as HTML."""
    from exudyn_crawler.views import style
    from exudyn_crawler.views.pages.page import figure_picture

    with style.titled_figure("", 6.4, 2.6) as figure:
        law.draw(*figure.subplots(1, 2))
    return str(figure_picture("law of the ground", figure))
