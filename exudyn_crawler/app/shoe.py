"""Shoe of a CAD or mesh file: what was recognized, coloured by name, and corrected by a click on a face."""

from pathlib import Path

import numpy as np
from nicegui import events, ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.app.results import command
from exudyn_crawler.files import writable_folder
from exudyn_crawler.shoe_file import paths_of
from exudyn_crawler.views.scenes.plots import CONFIG, DIGITS, Figure
from fem import Mesh, read_mesh
from fem.mesh import boundary_faces
from meshes.recognition.axes import UNITS
from meshes.recognition.picture import COLORS

SHOES = "shoes"
"""Folder of the shoes' files, and of what is made of them."""
CURVE = "(event) => emit(event.points[0].curveNumber)"
BARE = "#b9bfc4"
"""Colour of what has no name."""
WAYS = {"x": "ahead", "y": "left", "z": "up"}
REST = "rest of the surface"
WORDS = ("rear", "front", "underside", "top")
"""Names that a click may say a face has."""
OPPOSITE = {"front": "rear", "rear": "front", "underside": "top", "top": "underside"}
FLIPS = {"front": "--flip-front", "rear": "--flip-front", "underside": "--flip-up", "top": "--flip-up"}


def named_faces(mesh: Mesh) -> dict[str, np.ndarray]:
    """Triangles (m, 3) of the boundary by the last coloured surface that has them, and of the rest."""
    faces = boundary_faces(mesh.elements)
    corners = np.sort(faces[:, :3], axis=1)
    names = np.full(len(faces), REST, dtype=object)
    keys = {tuple(row): number for number, row in enumerate(corners.tolist())}
    for name in (name for name in COLORS if name in mesh.surfaces):
        rows = np.sort(mesh.surfaces[name][:, :3], axis=1).tolist()
        names[[keys[tuple(row)] for row in rows]] = name
    return {name: faces[names == name][:, :3] for name in dict.fromkeys(names)}


def shoe_figure(mesh: Mesh) -> Figure:
    """Shoe in 3D, every named surface in its colour."""
    traces = []
    look: Figure = {"type": "mesh3d", "flatshading": True, "showlegend": True, "hoverinfo": "name"}
    for name, faces in named_faces(mesh).items():
        used, numbers = np.unique(faces, return_inverse=True)
        columns = [*np.round(mesh.nodes[used], DIGITS).T, *np.reshape(numbers, faces.shape).T]
        shape = {name: column.tolist() for name, column in zip("xyzijk", columns, strict=True)}
        traces.append(look | shape | {"name": name, "color": COLORS.get(name, BARE)})
    axes = {f"{axis}axis": {"title": {"text": f"{axis}, {way}"}} for axis, way in WAYS.items()}
    layout = {"margin": {"l": 0, "r": 0, "t": 0, "b": 0}, "scene": {"aspectmode": "data"} | axes}
    layout |= {"legend": {"orientation": "h"}, "uirevision": "kept"}
    return {"data": traces, "layout": layout, "config": CONFIG}


class ShoePanel:
    """Shoe of a file, and what a user says of it."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.file: Path | None = None
        self.flips: set[str] = set()
        with ui.column().classes("panel wide"):
            ui.label("The shoe of the case is parametric: its values are under Machine. Or:").classes("quiet")
            with ui.row().classes("items-center w-full"):
                ui.upload(
                    label="drop a file of a shoe: STEP, STL, a mesh of tetrahedra",
                    auto_upload=True,
                    on_upload=self._dropped,
                ).classes("drop-wide").props('flat bordered data-testid="shoe-file"')
                self.unit = ui.select(["", *UNITS], label="unit, if the file's is not found").props(
                    "outlined dense"
                )
                self.unit.classes("choice").on_value_change(self._recognize)
                self.pins = ui.select([1, 2, 3], value=1, label="pair of bores").props("outlined dense")
                self.pins.classes("choice").on_value_change(self._recognize)
                self.sole = ui.select(["", "plate", "tips"], label="what carries, of grousers").props(
                    "outlined dense"
                )
                self.sole.classes("choice").on_value_change(self._recognize)
            self.clicked = ui.row().classes("items-center")
            self.spinner = ui.spinner(size="lg")
            self.spinner.set_visibility(False)
            self.plot = ui.plotly({}).classes("shoe-view").props('data-testid="shoe"')
            self.plot.on("plotly_click", self._click, js_handler=CURVE)
            self.plot.set_visibility(False)
            self.lines = ui.label().classes("console")
            self.take = ui.button("Work on a track of this shoe", on_click=self._take)
            self.take.set_visibility(False)

    async def _dropped(self, event: events.UploadEventArguments) -> None:
        self.file = self.folder / Path(event.file.name).name
        await event.file.save(self.file)
        self.flips.clear()
        await self._recognize()

    @property
    def folder(self) -> Path:
        """Folder of shoes."""
        return writable_folder(self.document.folder / SHOES)

    @property
    def paths(self) -> dict[str, Path]:
        """Files that are made of the shoe's file."""
        assert self.file is not None
        return paths_of(self.file.name.partition(".")[0], self.folder)

    async def _recognize(self) -> None:
        """Find what of the file is what, with what was said of it."""
        if self.file is None:
            return
        words = [str(self.file), "--out", str(self.folder), "--overwrite", "--pins", str(self.pins.value)]
        words += sorted(self.flips)
        for option, select in (("--unit", self.unit), ("--footprint", self.sole)):
            words += [option, select.value] if select.value else []
        self.spinner.set_visibility(True)
        try:
            is_made, said = await command(self.document.folder, "shoe", *words)
        finally:
            self.spinner.set_visibility(False)
        self.lines.set_text(said)
        self.plot.set_visibility(is_made)
        self.take.set_visibility(is_made)
        if is_made:
            self.plot.update_figure(shoe_figure(read_mesh(self.paths["mesh"])))

    def _click(self, event: events.GenericEventArguments) -> None:
        """Ask what a face is, that was clicked on, by the name that it was given."""
        name = self.plot.figure["data"][int(event.args)]["name"]
        self.clicked.clear()
        with self.clicked:
            word = next((word for word in WORDS if word in name), None)
            ui.label(
                f"This is the {name}." if word else f"This is the {name}: nothing follows from its name."
            )
            if word:
                other = OPPOSITE[word]
                ui.button(f"No, it is the {other}", on_click=lambda: self._flip(FLIPS[word])).props("dense")

    async def _flip(self, flag: str) -> None:
        self.flips ^= {flag}
        self.clicked.clear()
        await self._recognize()

    def _take(self) -> None:
        self.document.load(self.paths["case"])
        ui.notify("a track of this shoe is in the form")
