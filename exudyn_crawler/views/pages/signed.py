"""Report to sign: record of question, answers, inputs and validity, typeset as PDF or pictures."""

import hashlib
import io
import json
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import pandas as pd
from matplotlib.figure import Figure
from pydantic import BaseModel, TypeAdapter

from exudyn_crawler.files import whole_file
from exudyn_crawler.machines.datasheet.ledger import GENERAL
from exudyn_crawler.origins import Origin
from exudyn_crawler.views.pages import runs
from exudyn_crawler.views.pages.page import TEMPLATES
from exudyn_crawler.views.tables import cell_text, short_numbers

PDF = "report.pdf"
STORED = "report.json"
"""Files in a folder of results: report as PDF, and its record without the pictures."""
TEMPLATE = "signed.typ"

PIXELS = 110.0  # an inch, of a page as a picture
DPI = 170  # of figures on the paper
ALL_VALUES = "all values as computed"
"""Name of the checksum of parameters with their defaults."""
NOT_VARIED = (
    "How far the answers move with an assumed value is not computed here; a sweep over the value tells it."
)

Pairs = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Rows:
    """Table of texts; `numeric` are the numbers of the columns that are aligned to the right."""

    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    numeric: tuple[int, ...] = ()


@dataclass(frozen=True)
class SignedReport:
    """Content of a report to sign."""

    kind: str
    title: str
    facts: Pairs
    """Machine, its file, program: names and texts."""
    question: str
    lines: tuple[str, ...]
    """Answers in words."""
    answers: Rows
    given_words: str
    given: Pairs
    """Given values by name."""
    assumed_words: str
    assumed: Pairs
    validity: tuple[str, str, str]
    checksums: Pairs
    """Inputs by name, with their SHA-256."""
    figures: Mapping[str, bytes] = field(default_factory=dict)
    """PNG files by caption."""


READER = TypeAdapter(SignedReport)


def rows_of(frame: pd.DataFrame) -> Rows:
    """Return a table in the words of a page."""
    names = [str(name) for name in frame.columns]
    numeric = tuple(
        number for number, name in enumerate(frame.columns) if pd.api.types.is_numeric_dtype(frame[name])
    )
    cells = tuple(tuple(map(cell_text, row)) for row in frame.itertuples(index=False))
    return Rows(tuple(names), cells, numeric)


def ledger_parts(rows: Sequence[tuple[str, str, str, str]], where: str) -> dict[str, Any]:
    """Return the fields of a report on given and assumed values, from rows of a ledger (`ORIGIN_COLUMNS`).

    Values that are the same for all machines are only counted. `where` names the table of all rows.
    """
    chosen = [row for row in rows if row[3] != GENERAL]
    given = _named(chosen, (Origin.GIVEN, Origin.LIBRARY))
    assumed = _named(chosen, (Origin.ASSUMED,))
    derived = len(chosen) - len(given) - len(assumed)
    said = (
        f"Of {len(rows)} values {len(given)} are given by the file or the machine's datasheet, {derived} "
        "follow from these and typical ones."
    )
    general = len(rows) - len(chosen)
    more = f"; {general} further values are the same for all machines" if general else ""
    unsure = f"{len(assumed)} typical values, each with its source in {where}{more}. {NOT_VARIED}"
    return {"given_words": said, "given": given, "assumed_words": unsure, "assumed": assumed}


def _named(rows: Iterable[tuple[str, str, str, str]], origins: Sequence[str]) -> Pairs:
    """Return names and short values of rows with the given origins."""
    return tuple((key, short_numbers(value)) for key, value, origin, _ in rows if origin in origins)


def input_sums(files: Iterable[Path | str], *parameters: BaseModel) -> Pairs:
    """Return the checksums of files, named with their folders, and of all values of parameters."""
    paths = dict.fromkeys(map(Path, files))
    named = ((f"{path.resolve().parent.name}/{path.name}", file_sum(path)) for path in paths)
    return (*named, (ALL_VALUES, values_sum(*parameters)))


def file_sum(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def values_sum(*parameters: BaseModel) -> str:
    """Return the SHA-256 of parameters with all defaults."""
    return hashlib.sha256("\n".join(each.model_dump_json() for each in parameters).encode()).hexdigest()


def picture(figure: Figure) -> bytes:
    """Return a figure as a PNG file."""
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=DPI, bbox_inches="tight")
    return memory.getvalue()


def typeset(report: SignedReport, kind: Literal["pdf", "png"] = "pdf") -> list[bytes]:
    """Return the PDF as one file, or its pages as PNG files.

    Raises ModuleNotFoundError if typst is not installed.
    """
    import typst

    content = asdict(report)
    content["figures"] = [[caption, f"{number}.png"] for number, caption in enumerate(report.figures)]
    sources = {TEMPLATE: (TEMPLATES / TEMPLATE).read_bytes(), STORED: json.dumps(content).encode()}
    sources |= {f"{number}.png": png for number, png in enumerate(report.figures.values())}
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, text in sources.items():
            (root / name).write_bytes(text)
        found = typst.compile(root / TEMPLATE, root=root, format=kind, ppi=PIXELS)
    return found if isinstance(found, list) else [found]


def write_pdf(report: SignedReport, path: Path, overwrite: bool = False) -> Path:
    """Write a report to sign as PDF; the file appears whole or not at all."""
    (pdf,) = typeset(report)
    with whole_file(path, overwrite) as temporary:
        temporary.write_bytes(pdf)
    return path


def store(report: SignedReport, folder: Path, drawn: Mapping[str, str], overwrite: bool = False) -> None:
    """Write the record of a report into a folder; `drawn` are the folder's files of figures by caption."""
    content = asdict(report) | {"figures": dict(drawn)}
    with whole_file(folder / STORED, overwrite) as temporary:
        temporary.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def revision(checksums: Pairs) -> tuple[str, str]:
    """Return the fact that names the revision of a report's inputs: the first of them and its checksum."""
    name, checksum = checksums[0]
    return "revision", f"{Path(name).name}, SHA-256 {checksum[:16]}"


def stored(folder: Path) -> SignedReport:
    """Return the report whose record a folder has; raise ValueError that names a file that cannot be read."""
    content = runs.contents(folder / STORED, _content)
    files = {caption: folder / name for caption, name in content["figures"].items()}
    figures = {caption: runs.contents(path, Path.read_bytes) for caption, path in files.items()}
    return runs.contents(folder / STORED, lambda _: READER.validate_python(content | {"figures": figures}))


def _content(path: Path) -> dict[str, Any]:
    content = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict) or not isinstance(content.get("figures"), dict):
        raise ValueError(f"{path} is not the record of a report")
    return content
