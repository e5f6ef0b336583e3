"""Shoe of a CAD or mesh file: recognized surfaces, coloured by name, corrected by a click on a face."""

from functools import partial
from pathlib import Path

from nicegui import events, ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.app.form import refuse
from exudyn_crawler.app.machine import load
from exudyn_crawler.app.results import BUSY, command
from exudyn_crawler.files import writable_folder
from exudyn_crawler.shoe_file import paths_of, shoe_name
from exudyn_crawler.views.scenes.recognized import shoe_figure
from fem import read_mesh
from meshes.recognition.axes import UNITS

SHOES = "shoes"
"""Folder of the files of shoes and of their results."""
CURVE = "(event) => emit(event.points[0].curveNumber)"
OTHERS = {
    "front": ("rear", "--flip-front"),
    "rear": ("front", "--flip-front"),
    "underside": ("top", "--flip-up"),
    "top": ("underside", "--flip-up"),
}
"""Words in the names of surfaces that a click corrects: the opposite surface, and the option for it."""
OPTIONS: dict[str, tuple[str, list[str]]] = {
    "--unit": ("unit of the file, if not as found", [*UNITS]),
    "--pins": ("pins, if not in these bores", ["1", "2", "3"]),
    "--footprint": ("what carries, of grousers", ["plate", "tips"]),
}
"""Other corrections: titles and choices."""


class ShoePanel:
    """Panel of a shoe from a file or of the machine's size, and of its corrections."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.file = Path()
        self.flips: set[str] = set()
        self.selects: dict[str, ui.select] = {}
        with ui.column().classes("panel"):
            ui.label("Plate and links of the case's shoe are parameters, under Machine. For its stress:")
            ui.button("Make a flexible shoe that fits the machine", on_click=self._fit).props("no-caps")
            ui.upload(
                label="or drop a file of a shoe: STEP, STL, a mesh of tetrahedra",
                auto_upload=True,
                on_upload=self._dropped,
            ).classes("drop-wide").props('flat bordered data-testid="shoe-file"')
            with ui.row().classes("items-center w-full") as self.asked:
                for option, (title, choices) in OPTIONS.items():
                    select = ui.select([*choices], label=title, clearable=True, on_change=self._recognize)
                    self.selects[option] = select.props("outlined dense").classes("choice")
            self.asked.set_visibility(False)
            self.clicked = ui.row().classes("items-center").props('data-testid="clicked"')
            self.busy = ui.label(BUSY).classes("quiet")
            self.plot = ui.plotly({}).classes("shoe-view").props('data-testid="shoe"')
            self.plot.on("plotly_click", self._click, js_handler=CURVE)
            self.take = ui.button("Work on a track of this shoe", on_click=self._take).props("no-caps")
            self.words = ui.label().classes("console")
            for element in (self.busy, self.plot, self.take):
                element.set_visibility(False)

    async def _fit(self) -> None:
        """Make the ready shoe that fits the machine of the case, after saving the case."""
        try:
            case = self.document.save(self.document.name)
        except OSError as error:
            refuse(error)
            return
        self.asked.set_visibility(False)
        await self._make(f"{case.stem}_shoe", case, "--out", case.parent)

    async def _dropped(self, event: events.UploadEventArguments) -> None:
        name = Path(event.file.name)
        try:
            shoe_name(name)
            self.file = writable_folder(self.document.folder / SHOES) / name.name
        except (OSError, ValueError) as error:
            refuse(error)
            return
        await event.file.save(self.file)
        self.flips.clear()
        self.asked.set_visibility(True)
        await self._recognize()

    async def _recognize(self) -> None:
        """Recognize the shoe of the file, with the corrections so far."""
        said: list[object] = [*sorted(self.flips), "--out", self.file.parent, "--overwrite"]
        for option, select in self.selects.items():
            said += [option, select.value] if select.value else []
        await self._make(shoe_name(self.file), self.file, *said)

    async def _make(self, name: str, source: Path, *options: object) -> None:
        """Make a named shoe of a file, and show it."""
        self.paths = paths_of(name, source.parent)
        self.clicked.clear()
        self.busy.set_visibility(True)
        is_made, said = await command(self.document.folder, "shoe", source, *options)
        self.busy.set_visibility(False)
        self.words.set_text(said)
        self.take.set_visibility(is_made)
        # the shoe recognized before stays visible, so that a click undoes a wrong correction
        if is_made:
            self.plot.set_visibility(True)
            self.plot.update_figure(shoe_figure(read_mesh(self.paths["mesh"])))

    def _click(self, event: events.GenericEventArguments) -> None:
        """Ask for the correct name of a clicked face."""
        name = self.plot.figure["data"][int(event.args)]["name"]
        self.clicked.clear()
        with self.clicked:
            ui.label(f"This is the {name}.")
            for word, (other, flag) in OTHERS.items():
                if word in name:
                    ui.button(f"No, it is the {other}", on_click=partial(self._flip, flag)).props(
                        "dense no-caps"
                    )

    async def _flip(self, flag: str) -> None:
        self.flips ^= {flag}
        await self._recognize()

    def _take(self) -> None:
        load(self.document, self.paths["case"])
        ui.notify("a track of this shoe is in the form")
