"""Files of every kind with a value, a line or a byte changed by seed, and how what comes of them is judged.

    python -m tests.mutations 1000

reads a thousand of them, as the commands do before they start work, and writes a line for each that fails.

A changed file is at fault where reading it

- ends in anything but a result or bad input, takes longer than `LONGEST`, or says more than two
  lines of errors (four of a file that is cut off),
- says no line of errors that names the file or the key, or a line that is longer than `WIDEST`,
- is silent: a number of physics is a thousand times larger or smaller, or has the other sign, is taken, and
  no warning names its section. `ANY` lists keys for which such a number is no mistake, with the reason.

How silence was judged: of a thousand changes by `SEED` some three quarters are refused and a quarter taken.
The list of those taken was read once, with their keys and warnings: about a third change a comment, a head, a
name, a set of nodes or a bit in such text; the others leave out a line whose default is the same, or are a
number of `ANY`, a number that a warning names, a height of a map away from the track, or a part of a deck
that its notes name. A run of what was taken is no part of this.
"""

import contextlib
import io
import random
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from exudyn_crawler import Case, read_case, read_duty
from exudyn_crawler.case import CaseFile
from exudyn_crawler.case.case_file import case_text
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.cli import application
from exudyn_crawler.ground.cells.laws import bekker, read_law
from exudyn_crawler.results.checks.cases import read_check
from exudyn_crawler.sweep.definition import read_sweep
from fem import read_volume

SEED = 20160316
LONGEST = 60.0  # s
WIDEST = 600  # characters of a line
SILENT = "silent"
FACTORS = (1e3, 1e-3, -1.0)
ODD = ("nan", "inf", "-1", "0", "1e300", "true", '""', "[]", "{}", "'7 kN'", "1,5", "99999999999999999999")
ANY = {
    "duration": "runs are as long as one likes",
    "name": "any name",
    "outputs": "what is drawn",
    "solver": "numbers of the method, whose bounds are those of the program",
    "drive": "a drive may go rearward, or stand",
    "terrain.spring_stiffness": "from soil to rock; how far units sink is judged",
    "terrain.relief": "heights may be any",
    "gear.damping_depth": "a depth over which damping fades",
    "shoe.rails.height": "rails may lie low",
    "phases.end": "a run may end within a phase",
    "contact.stiffness": "the depth that follows is judged",
    "gear.rolling_resistance": "wheels may roll freely",
    "gear.tumbler": "the tumbler may be in front",
    "gear.torque_speed": "a speed over which a sign fades",
    "track.pin_height": "pins may lie below the COM",
    "phases.side_shift": "loads act on both sides",
    "damping": "ground and shoes have hardly any, or much: it shows in vibrations alone",
    "cohesion": "sand has next to none",
    "changes_an_hour": "any rate",
    "gear.guide_stiffness": "guides may be soft",
    "guide_damping": "hardly any, or much",
    "contact.stiction_speed": "a speed over which a sign fades",
    "terrain.width": "ground may be wide",
    "terrain.length": "ground may be long",
    "terrain.spring_offset": "springs may be close to the middle",
    "k_c": "soils without cohesion have next to none",
    "cases.ground.stiffness": "from mud to rock; more is warned of",
    "seed": "any seed",
    "vary": "what is varied is checked as a case",
    "answers": "times and places of answers are checked against the run",
    "hours": "from a shift to a century; more is warned of",
    "an_hour": "any rate",
    "share": "any share",
}
"""Beginnings of keys whose values may be a thousand times another, or negative, without a word."""


@dataclass(frozen=True)
class Changed:
    """Changed content of a file, and what was changed."""

    content: bytes
    what: str
    key: str = ""  # of a number that was scaled


@dataclass(frozen=True)
class Kind:
    """Kind of file: its name, a valid content, files beside it, and what reads it."""

    name: str
    content: bytes
    read: Callable[[Path], Any]
    case: str = ""  # of a file that a case names: the case's


@dataclass(frozen=True)
class Outcome:
    """End of a reading."""

    code: Any
    errors: tuple[str, ...]
    warnings: tuple[str, ...]
    others: tuple[str, ...]
    seconds: float


MAP_CASE = """base = "rolled"
duration = 0.01
[terrain]
model = "cells"
origin = [5.0, 3.0]
length = 25.0
width = 13.0
[terrain.relief.measured]
file = "{file}"
smoothing = 0.5
[contact]
model = "cells"
[contact.law]
model = "bekker"
base = "lete_sand"
"""
LOADS_CASE = 'base = "translation"\nduration = 0.01\n[loads]\nfile = "{file}"\n'
LAW = """model = "bekker"
base = "lete_sand"
k_c = 102e3
k_phi = 5.301e6
exponent = 0.793
cohesion = 1.3e3
friction_angle = 0.54
"""
DUTY = """name = "digging"
plane_nodes = 0
survivals = [0.5, 0.975]
changes_an_hour = 4
[material]
base = "cast_nicrmo"
[[stages]]
name = "new"
hours = 12500
[[runs]]
name = "pass"
folder = "results/pass"
stage = "new"
share = 0.07
[[runs]]
name = "dig"
folder = "results/dig"
stage = "new"
an_hour = 23.3
"""
CHECK = """mesh = "coarse"
hours = 25000
[material]
base = "cast_nicrmo"
[[cases]]
name = "two stones"
treads = [{ side = "left", force = 574e3, width = 0.06 }, { side = "right", force = 574e3 }]
[cases.ground]
stiffness = 1e9
parts = [{ low = [-0.3, 1.2], high = [0.0, 1.5], round = true, height = 0.05, stiffness = 1e10 }]
"""
SWEEP = """design = "latin_hypercube"
runs = 8
seed = 3
[case]
base = "translation"
duration = 0.5
[[vary]]
key = "terrain.spring_stiffness"
low = 5e6
high = 80e6
scale = "log"
[[vary]]
key = ["contact.static_friction", "contact.dynamic_friction"]
name = "friction"
factor = true
low = 0.5
high = 1.5
[[answers]]
quantity = "joint_force"
statistic = "mean"
of = [12]
start = 0.2
"""
PHASES = """[[phases]]
name = "propel"
end = 15.0
loads = 386.4e3
[[phases]]
name = "dig"
end = 20.0
loads = 420e3
side_shift = 0.05
"""
TABLE = "time [s],load [kN],side shift [mm]\n" + "".join(f"{t / 2},{386 + t},{t}\n" for t in range(20))
GRID = "ncols 60\nnrows 40\nxllcorner 3.0\nyllcorner 1.0\ncellsize 0.5\nNODATA_value -9999\n" + "\n".join(
    " ".join(f"{0.01 * ((row * column) % 7):.3f}" for column in range(60)) for row in range(40)
)
DECK = """*HEADING
a block
*NODE, NSET=ALL
1, 0.0, 0.0, 0.0
2, 1.0, 0.0, 0.0
3, 0.0, 1.0, 0.0
4, 0.0, 0.0, 1.0
5, 1.0, 1.0, 1.0
*ELEMENT, TYPE=C3D4, ELSET=SOLID
1, 1, 2, 3, 4
2, 2, 3, 4, 5
*NSET, NSET=BASE
1, 2, 3
*SURFACE, NAME=TOP, TYPE=ELEMENT
2, S3
"""


def _case(path: Path) -> None:
    file = read_case(path)
    checks.warn_implausible(file.case, file.duration)


def _of_case(path: Path) -> None:
    _case(path.with_name("case.toml"))


def _warned(read: Callable[[Path], Any]) -> Callable[[Path], None]:
    """What reads a file and warns of its values."""
    return lambda path: checks.warn_of(checks.out_of_range(read(path)))


def kinds() -> list[Kind]:
    """All kinds of files, those of cases with all their values."""
    named = {
        "dragged": Case.translation(),
        "turned": Case.turning(),
        "stressed": Case.stress("coarse"),
        "rolled": Case.rolled(),
        "cells": Case.rolled().on_cells(bekker.BekkerSoil.lete_sand()),
        "closed": Case.closed(),
        "machine": Case.shovel(),
    }
    cases = [
        Kind(f"{name}.toml", case_text(CaseFile(case=case, duration=0.01)).encode(), _case)
        for name, case in named.items()
    ]
    return [
        *cases,
        Kind("law.toml", LAW.encode(), _warned(read_law)),
        Kind("duty.toml", DUTY.encode(), _warned(read_duty)),
        Kind("check.toml", CHECK.encode(), _warned(read_check)),
        Kind("sweep.toml", SWEEP.encode(), lambda path: read_sweep(path).planned),
        Kind("cycle.toml", PHASES.encode(), _of_case, LOADS_CASE),
        Kind("measured.csv", TABLE.encode(), _of_case, LOADS_CASE),
        Kind("map.asc", GRID.encode(), _of_case, MAP_CASE),
        Kind("block.inp", DECK.encode(), read_volume),
    ]


def changed(kind: Kind, dice: random.Random) -> Changed:
    """Change a line, a number or bytes of a kind's content."""
    how = dice.choice(("number", "number", "number", "odd", "odd", "line", "bytes"))
    if how == "bytes":
        return _other_bytes(kind.content, dice)
    lines = kind.content.decode().splitlines()
    # tables of a file begin with a line in brackets
    sections = [""]
    for line in lines:
        table = line.strip().startswith("[") and "=" not in line
        sections.append(line.strip("[] ") if table else sections[-1])
    places = [place for place, line in enumerate(lines) if "=" in line] or range(len(lines))
    if not kind.name.endswith(".toml"):
        places = range(len(lines))
    place = dice.choice(places)
    line = lines[place]
    key, equals, rest = line.partition(" = ")
    value, mark, comment = rest.partition(" # ")
    if how == "line":
        lines[place : place + 1] = dice.choice(([], [line, line], [line[: len(line) // 2]], ["x" + line]))
        return Changed(_text(lines), f"line {place + 1}: {line[:60]!r} left out, doubled, cut or misspelt")
    if how == "number" and equals and (number := _number(value)):
        scaled = repr(dice.choice(FACTORS) * number)
        lines[place] = f"{key} = {scaled}{mark}{comment}"
        path = ".".join(filter(None, (sections[place], key.strip())))
        return Changed(_text(lines), f"{path}: {value} -> {scaled}", path)
    odd = dice.choice(ODD)
    if equals:
        lines[place] = f"{key} = {odd}{mark}{comment}"
    else:
        parts = line.split(",") if "," in line else line.split()
        parts[dice.randrange(len(parts))] = odd
        lines[place] = ("," if "," in line else " ").join(parts)
    return Changed(_text(lines), f"line {place + 1}: {line[:60]!r} -> {odd}")


def _number(value: str) -> float:
    """Number of a text; 0 where it is none."""
    try:
        return float(value)
    except ValueError:
        return 0.0


def _text(lines: list[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode()


def _other_bytes(content: bytes, dice: random.Random) -> Changed:
    """Cut the content, flip a bit, or put bytes in."""
    place = dice.randrange(len(content))
    how = dice.choice(("cut", "flipped", "put in"))
    if how == "cut":
        return Changed(content[:place], f"cut at byte {place}")
    if how == "flipped":
        flipped = content[place] ^ (1 << dice.randrange(8))
        return Changed(content[:place] + bytes([flipped]) + content[place + 1 :], f"bit at {place}")
    new = dice.choice((b"\0", b"\xff\xfe", b"\r", b"[" * 500, b"\xef\xbb\xbf"))
    return Changed(content[:place] + new + content[place:], f"{new[:4]!r} at {place}")


def outcome(kind: Kind, content: bytes, folder: Path) -> Outcome:
    """Read a changed file as the commands do, and keep what they say."""
    path = folder / kind.name
    path.write_bytes(content)
    if kind.case:
        (folder / "case.toml").write_text(kind.case.format(file=kind.name))
    told = io.StringIO()
    start = time.monotonic()
    argv = sys.argv
    code: Any = None
    try:
        sys.argv = ["program", "file"]
        with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
            application.call(lambda standalone_mode: kind.read(path) and None)  # type: ignore[arg-type]
    except SystemExit as end:
        code = end.code
    finally:
        sys.argv = argv
    lines = told.getvalue().splitlines()
    errors = tuple(line for line in lines if line.startswith("error: "))
    warned = tuple(line for line in lines if line.startswith("warning: "))
    others = tuple(line for line in lines if not line.startswith(("error: ", "warning: ")))
    return Outcome(code, errors, warned, others, time.monotonic() - start)


def faults(kind: Kind, change: Changed, end: Outcome) -> Iterator[str]:
    """Lines that say what is wrong with what came of a change; see the head of this file."""
    if end.code not in (0, 2):
        yield f"exit {end.code}: {end.errors[:2]}"
    if end.seconds > LONGEST:
        yield f"took {end.seconds:.0f} s"
    if end.others:
        yield f"says {end.others[:2]}"
    # a file that is cut off may lack parts of several tables
    most = 4 if change.what.startswith("cut") else 2
    if end.code == 2 and not 1 <= len(end.errors) <= most:
        yield f"{len(end.errors)} lines of errors: {end.errors[:3]}"
    if end.code == 2 and not any(_names(line, kind, change) for line in end.errors):
        yield f"names neither file nor key: {end.errors}"
    for line in (*end.errors, *end.warnings):
        if len(line) > WIDEST:
            yield f"a line of {len(line)} characters: {line[:200]}"
    if end.code == 0 and change.key and not _may_be_any(change.key):
        section = change.key.partition(".")[0]
        if not any(section in line or change.key.rpartition(".")[2] in line for line in end.warnings):
            yield SILENT


def _names(line: str, kind: Kind, change: Changed) -> bool:
    return any(name in line for name in (kind.name, "case.toml", change.key or kind.name, "run "))


def _may_be_any(key: str) -> bool:
    return any(key.startswith(name) or key.endswith(f".{name}") for name in ANY)


def mutated(count: int, folder: Path, seed: int = SEED) -> Iterator[tuple[Kind, Changed, Outcome, list[str]]]:
    """Changes by turns of all kinds of files, what came of each, and its faults."""
    dice = random.Random(seed)
    all_kinds = kinds()
    for number in range(count):
        kind = all_kinds[number % len(all_kinds)]
        change = changed(kind, dice)
        end = outcome(kind, change.content, folder)
        yield kind, change, end, list(faults(kind, change, end))


def main() -> None:
    """Read as many changed files as asked for, and print those at fault."""
    count = int(sys.argv[1])
    ends: dict[Any, int] = {}
    slowest = 0.0
    at_fault = 0
    with tempfile.TemporaryDirectory() as folder:
        for number, (kind, change, end, wrong) in enumerate(mutated(count, Path(folder))):
            ends[end.code] = ends.get(end.code, 0) + 1
            slowest = max(slowest, end.seconds)
            at_fault += bool(wrong)
            for line in wrong:
                print(f"{number} {kind.name}: {change.what}: {line}", flush=True)
    print(f"{count} changes, exit codes {ends}, slowest {slowest:.1f} s, at fault {at_fault}")


if __name__ == "__main__":
    main()
