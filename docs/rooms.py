"""The rooms of the code, read from its imports, and the picture of them that the handbook shows.

``python -m docs.rooms`` draws `docs/images/rooms.svg` again; the tests hold the picture, and what each room
may import, against the code.
"""

import ast
from functools import cache
from pathlib import Path
from xml.sax.saxutils import escape

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "images" / "rooms.svg"
PACKAGE = "exudyn_crawler"

FLOORS = (
    ("studies",),
    ("cli",),
    ("app",),
    ("sweep", "spread_run"),
    ("case_run", "life_run", "wear_run", "assess_run", "co_simulation", "coupled", "shoe_file"),
    ("run", "views"),
    ("assessment",),
    ("results", "engine"),
    ("model",),
    ("ground",),
    ("machines",),
    ("case",),
    ("settings", "meshes"),
    ("fem",),
)
"""Rooms from the top of the house to the ground: a room imports only from floors below its own."""
SHARED = ("errors", "files", "origins")
"""What any room may import; they import each other and the lowest floor alone."""
ALSO = {("run", "views")}
"""Imports beside those of the floors: (from, to)."""
FACE = PACKAGE
"""The public names: imports from any room of the package; the command, studies and users import from it."""


def room_of(module: str) -> str:
    """Return the room of a module: ``run`` of ``exudyn_crawler.run.solve``, ``fem`` of ``fem.files``."""
    parts = module.split(".")
    if parts[0] != PACKAGE:
        return parts[0]
    if module == f"{PACKAGE}.__main__":
        return "cli"
    return parts[1] if len(parts) > 1 else FACE


@cache
def modules() -> dict[str, Path]:
    """Every module of the code by its dotted name."""
    found = {}
    for top in (PACKAGE, "fem", "meshes", "studies"):
        for path in sorted((ROOT / top).rglob("*.py")):
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            found[name.removesuffix(".__init__")] = path
    return found


@cache
def tree(path: Path) -> ast.Module:
    """Return the syntax tree of a module by its file."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imports() -> list[tuple[str, str]]:
    """Every import of one module of the code by another, wherever in a file it stands: (from, to).

    A text that is a module's dotted name counts as an import of it: what else would it be for.
    """
    return [pair for module, path in modules().items() for pair in imports_of(module, tree(path))]


def imports_of(module: str, tree: ast.Module) -> list[tuple[str, str]]:
    """Imports of one module, which has this tree: (from, to)."""
    known = modules()
    targets: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            targets.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            targets.update(name if name in known else node.module for name in names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "." in node.value:
            targets.add(node.value)
        elif isinstance(node, ast.ImportFrom):
            raise ValueError(f"{module}: imports must be absolute, got a relative one in line {node.lineno}")
    return [(module, target) for target in sorted(targets) if target in known and target != module]


def arrows() -> set[tuple[str, str]]:
    """Imports from room to room."""
    pairs = {(room_of(a), room_of(b)) for a, b in imports()}
    return {(a, b) for a, b in pairs if a != b}


def allowed(room: str) -> set[str]:
    """Rooms that a room may import."""
    if room in SHARED:
        return set(FLOORS[-1]) | set(SHARED)
    if room == FACE:
        return {one for floor in FLOORS for one in floor} - {"studies", "cli", "app"} | set(SHARED)
    floor = next(k for k, rooms in enumerate(FLOORS) if room in rooms)
    below = {one for rooms in FLOORS[floor + 1 :] for one in rooms}
    if room == "settings":
        return {"errors", "files"}
    if room in ("fem", "meshes"):
        return below
    also = {b for a, b in ALSO if a == room}
    return below | also | set(SHARED) | ({FACE} if room in ("studies", "cli") else set())


def purpose(room: str) -> str:
    """What a room is for: the first sentence of its docstring."""
    path = ROOT / ("" if room in ("fem", "meshes", "studies") else PACKAGE) / room
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    text = ast.get_docstring(tree(path)) or ""
    return " ".join(text.split("\n\n")[0].split())


WIDTH, STEP, BOX = 980, 74, 52
"""Pixels: width of the picture, from floor to floor, height of a room."""


def _boxes() -> dict[str, tuple[float, float, float]]:
    """Left, top and width of every room's box."""
    boxes = {}
    for floor, rooms in enumerate(FLOORS):
        width = (620 - 20 * (len(rooms) - 1)) / len(rooms)
        for k, room in enumerate(rooms):
            boxes[room] = (180 + k * (width + 20), 20 + floor * STEP, width)
    for k, room in enumerate(SHARED):
        boxes[room] = (820, 20 + (8 + k) * STEP, 140)
    return boxes


def picture() -> str:
    """SVG of the rooms: a box each with its purpose, an arrow for every import that skips no floor between.

    An arrow that others already imply (by way of a room between) is left out: the picture shows the order.
    """
    found = {(a, b) for a, b in arrows() if FACE not in (a, b) and not {a, b} & set(SHARED)}
    shown = sorted(pair for pair in found if not _implied(pair, found))
    boxes = _boxes()
    height = 20 + len(FLOORS) * STEP
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif">',
        '<defs><marker id="tip" markerWidth="9" markerHeight="7" refX="8" refY="3.5" orient="auto">'
        '<path d="M0,0 L9,3.5 L0,7 z" fill="#3c4a54"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
    ]
    for a, b in shown:
        lines.append(_arrow(boxes[a], boxes[b]))
    for room, (left, top, width) in boxes.items():
        fill = "#f3ead6" if room in SHARED else "#dfe8ee"
        lines.append(
            f'<rect x="{left:g}" y="{top:g}" width="{width:g}" height="{BOX}" rx="6" fill="{fill}" '
            'stroke="#3c4a54"/>'
        )
        place = f'x="{left + 12:g}" y="{top + 20:g}"'
        lines.append(f'<text {place} font-size="15" font-weight="bold">{escape(room)}</text>')
        for k, part in enumerate(_wrapped(purpose(room), int(width / 6.0))[:2]):
            lines.append(
                f'<text x="{left + 12:g}" y="{top + 34 + 12 * k:g}" font-size="10.5" fill="#444">'
                f"{escape(part)}</text>"
            )
    return "\n".join([*lines, "</svg>"]) + "\n"


def _implied(pair: tuple[str, str], found: set[tuple[str, str]]) -> bool:
    """Whether a way through other rooms leads from the first to the second."""
    start, end = pair
    reached, todo = set(), [b for a, b in found if a == start and b != end]
    while todo:
        room = todo.pop()
        if room == end:
            return True
        if room not in reached:
            reached.add(room)
            todo += [b for a, b in found if a == room]
    return False


def _arrow(start: tuple[float, float, float], end: tuple[float, float, float]) -> str:
    """Line from one box to another: down the middle, or sideways between neighbours."""
    (x0, y0, w0), (x1, y1, w1) = start, end
    if y0 == y1:
        points = (x0 + w0, y0 + BOX / 2, x1, y1 + BOX / 2)
    else:
        low, high = max(x0, x1), min(x0 + w0, x1 + w1)
        points = ((low + high) / 2, y0 + BOX, (low + high) / 2, y1)
    x, y, u, v = points
    return f'<line x1="{x:g}" y1="{y:g}" x2="{u:g}" y2="{v:g}" stroke="#3c4a54" marker-end="url(#tip)"/>'


def _wrapped(text: str, width: int) -> list[str]:
    """Text in lines of at most `width` characters."""
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) + 1 > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
