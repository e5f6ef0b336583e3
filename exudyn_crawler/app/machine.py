"""Machine and its file: choice from the library, form, and drawing of the track at its start."""

from pathlib import Path

from nicegui import events, ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.app.form import FormPart, below, in_words, pick_list, refuse
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.machines.datasheet.discrepancies import implausible_values
from exudyn_crawler.machines.datasheet.files import KEY
from exudyn_crawler.settings import fields
from exudyn_crawler.views.scenes.plots import side_figure, space_figure
from exudyn_crawler.views.scenes.start import start_solids

OF_DUTY = (f"{KEY}.travel", f"{KEY}.speed")
"""Values of a datasheet that describe the task of the machine."""
PARTS = ("shoe", "track", "gear", "flexible", "solver", "outputs")
"""Tables of a case for its machine and for its run."""


class Drawing:
    """Track at its start, from the right and in 3D."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.case: object = None
        with ui.column().classes("drawing"):
            self.side = ui.plotly({}).classes("side-view").props('data-testid="side"')
            self.space = ui.plotly({}).classes("space-view").props('data-testid="space"')
            self.notes = ui.column().classes("notes")

    def refresh(self) -> None:
        """Draw the case again if it has changed."""
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
            for line in implausible_values(case_file):
                ui.label(line).classes("warning")
        self.side.update_figure(side_figure(solids))
        self.space.update_figure(space_figure(solids))


class MachinePanel:
    """Panel of the machine: its source and its values."""

    def __init__(self, document: Document) -> None:
        self.document = document
        titles = {name: library.machine_content(name)["name"] for name in library.machines()}
        with ui.column().classes("panel"):
            pick_list("machine of the library", titles, document.start_from)
            with ui.row().classes("items-end w-full"):
                self.file = pick_list("or a case file of this folder", [], self._load)
                upload = ui.upload(label="or drop one", auto_upload=True, on_upload=self._dropped)
                upload.props('accept=".toml" flat bordered data-testid="case-file"').classes("drop")
            self.sheet = ui.label("What the maker prints").classes("part")
            self.parts = [
                FormPart(document, _printed),
                FormPart(document, _left_out, "What the maker leaves out"),
                *(FormPart(document, below(name), f"All values: {in_words(name)}") for name in PARTS),
            ]

    def refresh(self) -> None:
        """Show the case again, and the present files."""
        files = sorted(path.name for path in self.document.folder.glob("*.toml"))
        if files != self.file.options:
            self.file.set_options(files)
        self.sheet.set_visibility(self.document.case_file.datasheet is not None)
        for part in self.parts:
            part.refresh()

    def _load(self, name: str) -> None:
        load(self.document, self.document.folder / name)

    async def _dropped(self, event: events.UploadEventArguments) -> None:
        content = await event.file.read()
        try:
            path = self.document.store(event.file.name, content)
        except OSError as error:
            refuse(error)
            return
        if path.name != Path(event.file.name).name:
            ui.notify(f"{event.file.name} in the folder is another file and stays: this one is {path.name}")
        load(self.document, path)


class FilePanel:
    """Panel of the case file's text, from which the form is made."""

    def __init__(self, document: Document) -> None:
        self.document = document
        with ui.column().classes("panel"):
            with ui.row().classes("items-center"):
                self.name = ui.input("name of the file", suffix=".toml")
                self.name.props('outlined dense data-testid="name"')
                ui.button("Save", icon="save", on_click=self._save).props('data-testid="save-as"')
            ui.label("The form and this file are the same case. The button takes over what you type here.")
            self.text = ui.textarea().classes("text").props('outlined spellcheck="false" data-testid="text"')
            ui.button("Take this text", on_click=self._take).props('data-testid="take-text"')
            self.error = ui.label().classes("refused console")

    def refresh(self) -> None:
        """Show the accepted text."""
        self.name.set_value(self.document.name)
        self.text.set_value(self.document.text)
        self.error.set_text("")

    def _take(self) -> None:
        try:
            self.document.take_text(self.text.value)
        except (ValueError, OSError) as error:
            self.error.set_text(str(error))

    def _save(self) -> None:
        try:
            path = self.document.save(Path(self.name.value).name)
        except OSError as error:
            refuse(error)
        else:
            ui.notify(f"saved as {path.name}")


def load(document: Document, path: Path) -> None:
    """Start with a case file, or report why it cannot be used."""
    try:
        document.load(path)
    except (ValueError, OSError) as error:
        refuse(error)


def _printed(entry: fields.Item) -> bool:
    return below(KEY)(entry) and entry.path not in (KEY, *OF_DUTY) and entry.value is not None


def _left_out(entry: fields.Item) -> bool:
    return below(KEY)(entry) and entry.path not in (KEY, *OF_DUTY) and entry.value is None
