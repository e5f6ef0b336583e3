"""Ground and duty: lists of soils, slopes, obstacles and tasks of the machine, and a drawing of the law."""

from nicegui import ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.app.form import FormPart, below, choose, pick_list
from exudyn_crawler.app.machine import OF_DUTY
from exudyn_crawler.case.parameters.terrain import SoilLaw
from exudyn_crawler.machines import duties
from exudyn_crawler.views import style
from exudyn_crawler.views.pages.page import figure_picture

VALUES = (*OF_DUTY, "duration", "terrain.grade", "terrain.side_slope")
TABLES = {
    "contact": "soil",
    "terrain": "heights",
    "drive": "drive",
    "machine": "forces on the machine",
    "loads": "loads on shoes",
}
"""Tables of ground and duty, and their titles."""


class GroundPanel:
    """Panel of ground and duty of the case."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.law: object = None
        self.choices = duties.lists()
        with ui.column().classes("panel"):
            self.lists = {label: self._list(label) for label in self.choices}
            self.figure = ui.html("", sanitize=False).classes("figure")
            self.parts = [
                FormPart(document, lambda entry: entry.path in VALUES),
                FormPart(document, below("terrain.relief.parts")),
                *(FormPart(document, below(name), f"All values: {TABLES[name]}") for name in TABLES),
            ]

    def _list(self, label: str) -> ui.select:
        """Return a list; its picked option changes values of the case file."""

        def take(name: str) -> None:
            choose(self.document, self.choices[label][name](self.document.case_file))

        return pick_list(label, [*self.choices[label]], take)

    def refresh(self) -> None:
        """Show the case again, and draw the law if it has changed."""
        for part in self.parts:
            part.refresh()
        self.lists[duties.DUTY].set_visibility(self.document.case_file.datasheet is not None)
        law = getattr(self.document.case_file.case.contact, "law", None)
        if law != self.law:
            self.law = law
            self.figure.set_content("" if law is None else law_picture(law))


def law_picture(law: SoilLaw) -> str:
    """Return the picture of a law, pressure over sinkage and shear over slip, as HTML."""
    with style.titled_figure("", 6.4, 2.6) as figure:
        law.draw(*figure.subplots(1, 2))
    return str(figure_picture("law of the ground", figure))
