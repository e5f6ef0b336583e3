"""Files of every kind with a value, a line or a byte changed by seed, and how what comes of them is judged.

    python -m tests.mutations 1000 --run

reads a thousand of them as the commands do before they start work, does for a moment of simulated time what
the commands do with those that are taken, and writes a line for each that fails. With `--taken` it writes
those that were taken, too, with their first warning, to be looked at.

A changed file is at fault where it

- ends in anything but a result, bad input or a run that stopped, in a crash of the process, or takes more
  than `LONGEST` of processor time,
- says more than two lines of errors (four of a file that is cut off), none that names the file or the key, or
  a line that is longer than `WIDEST`,
- is silent: a number of physics is a thousand times larger or smaller, or has the other sign, is taken, and
  the first warning does not name its section. `ANY` lists keys for which such a number is no mistake, with
  the reason.

How silence was judged: of a thousand changes that were read and run, 738 were refused as they were read, 22
as they ran, 9 runs stopped, 231 were taken and none was without end; the slowest took 38 s. The list of those
taken was looked through, with their keys and first warnings, and each key of `ANY` was tried with all
`FACTORS`: most of the silent ones change a comment, a name or a bit in such text, leave out a line whose
default is the same, or are a number of `ANY`, a height of a map or one point of many in a table.
"""

import argparse
import contextlib
import io
import multiprocessing
import random
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from exudyn_crawler.cli import application
from tests import file_kinds
from tests.file_kinds import Kind

SEED = 20160316
LONGEST = 60.0  # s of processor time
PATIENCE = 600.0  # s, after which a process has no end
WIDEST = 600  # characters of a line
SILENT = "silent"
LEFT = "this is another machine than the library's"
"""Words of the line about figures that are left of a machine of the library."""
FACTORS = (1e3, 1e-3, -1.0)
ODD = ("nan", "inf", "-1", "0", "1e300", "true", '""', "[]", "{}", "'7 kN'", "1,5", "99999999999999999999")
NUMBER = re.compile(r"(?<![\w.\-+])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
PROGRESS = re.compile(r": \d+ s so far")
STOPPED = (0, 2, 3)
"""Exit codes: done, bad input, and a run that stopped early."""
ANY = {
    "duration": "runs are as long as one likes",
    "name": "any name",
    "outputs": "what is drawn",
    "solver": "numbers of the method, whose bounds are those of the program",
    "drive": "a drive may go rearward, or stand",
    "terrain.spring_stiffness": "from soil to rock; how far units sink is judged",
    "terrain.relief": "heights may be any",
    "gear.com": "the COM of a frame may be below its origin, and behind it",
    "gear.car_body.upper_com": "a COM may be on the axis of slewing, or below the floor of the cab",
    "gear.damping_depth": "a depth over which damping fades",
    "shoe.rails.height": "rails may lie low",
    "shoe.underside_center": "an underside may be in the middle",
    "phases.end": "a run may end within a phase",
    "contact.stiffness": "the depth that follows is judged",
    "gear.rolling_resistance": "wheels may roll freely",
    "gear.tumbler.place": "the tumbler may be in front",
    "tumbler": "that of an open chain may be in front, too",
    "gear.tumbler.damping_depth": "a depth over which damping fades",
    "gear.tumbler.backlash": "a seat may have play",
    "gear.torque_speed": "a speed over which a sign fades",
    "gear.resistance_speed": "a speed over which a sign fades",
    "gear.guide_play": "guides may have none",
    "gear.compliance": "pins may be as good as rigid",
    "gear.arms.com": "the COM of an arm may be at its pivot, or beyond",
    "gear.arms.pivot": "arms may trail or lead",
    "datasheet.arm_pivot": "arms may trail or lead",
    "track.pin_height": "pins may lie below the COM",
    "phases.side_shift": "loads act on both sides",
    "damping": "there may be hardly any; much is judged by the critical one",
    "guide_damping": "there may be hardly any; much is judged by the critical one",
    "arm_damping": "there may be hardly any; much is judged by the critical one",
    "cohesion": "sand has next to none",
    "reload_stiffness": "the law unloads no softer than it was loaded, whatever this is",
    "changes_an_hour": "any rate",
    "contact.stiction_speed": "a speed over which a sign fades",
    "terrain.width": "ground may be wide",
    "terrain.length": "ground may be long",
    "terrain.spring_offset": "springs may be close to the middle",
    "k_c": "soils without cohesion have next to none",
    "cases.ground.stiffness": "from mud to rock; more is warned of",
    "cases.ground.parts": "stones and hollows may be anywhere, and as flat as one likes",
    "seed": "any seed",
    "vary": "what is varied is checked as a case",
    "answers": "times and places of answers are checked against the run",
    "hours": "from a shift to a century; more is warned of",
    "an_hour": "any rate",
    "share": "any share",
    "amplitude": "of a map: heights may be any",
    "offset": "of a map: the search for rest and the map's own checks tell",
    "missing": "of a map: what stands for a missing height",
    "columns": "of a map: it may be large",
    "rows": "of a map: it may be large",
    "work.side_slope": "ground may be level",
    "work.grade": "ground may be level",
    "work.slew_rate": "a machine may slew slowly, or not at all",
    "pins.gap": "lugs may touch; more than 30 mm is warned of",
    "source": "any words",
    "x_first": "of a map: checked against the track, and of no effect on an array",
    "y_first": "of a map: checked against the track, and of no effect on an array",
    "x_step": "of a map: checked against the track, and of no effect on an array",
    "y_step": "of a map: checked against the track, and of no effect on an array",
}
"""Beginnings of keys whose values may be a thousand times another, or negative, without a word."""


@dataclass(frozen=True)
class Changed:
    """Changed content of a file, and what was changed."""

    content: bytes
    what: str
    key: str = ""  # of a number that was scaled


@dataclass(frozen=True)
class Outcome:
    """End of a reading, or of a run."""

    code: Any
    errors: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    seconds: float = 0.0


def changed(kind: Kind, dice: random.Random) -> Changed:
    """Change a line, a number or bytes of a kind's content."""
    how = dice.choice(("number", "number", "number", "odd", "odd", "line", "bytes"))
    try:
        lines = kind.content.decode().splitlines()
    except UnicodeDecodeError:
        return _other_bytes(kind.content, dice)
    if how == "bytes":
        return _other_bytes(kind.content if kind.made is None else kind.made(kind.content.decode()), dice)
    change = _other_line(kind, lines, how, dice)
    if kind.made is None:
        return change
    try:
        return Changed(kind.made(change.content.decode()), change.what, change.key)
    # no such file can be made
    except Exception:
        return _other_bytes(kind.made(kind.content.decode()), dice)


def _other_line(kind: Kind, lines: list[str], how: str, dice: random.Random) -> Changed:
    """Leave a line out, double, cut or misspell it, scale one of its numbers, or put an odd value in."""
    is_table = kind.name.endswith(".toml") or kind.made is not None
    # tables of a file begin with a line in brackets
    sections = [""]
    for line in lines:
        table = line.strip().startswith("[") and "=" not in line
        sections.append(line.strip("[] ") if table else sections[-1])
    places = [place for place, line in enumerate(lines) if " = " in line] if is_table else range(len(lines))
    place = dice.choice(places)
    line = lines[place]
    key, equals, rest = line.partition(" = ") if is_table else ("", "", line)
    value, mark, comment = rest.partition(" # ")
    if how == "line":
        lines[place : place + 1] = dice.choice(([], [line, line], [line[: len(line) // 2]], ["x" + line]))
        return Changed(_text(lines), f"line {place + 1}: {line[:60]!r} left out, doubled, cut or misspelt")
    numbers = [found for found in NUMBER.finditer(value) if float(found[0]) != 0.0]
    if how == "number" and numbers:
        found = dice.choice(numbers)
        scaled = repr(dice.choice(FACTORS) * float(found[0]))
        lines[place] = f"{key}{equals}{value[: found.start()]}{scaled}{value[found.end() :]}{mark}{comment}"
        path = ".".join(filter(None, (sections[place], key.strip()))) if is_table else ""
        return Changed(
            _text(lines), f"line {place + 1}: {path} {found[0]} -> {scaled} in {value[:40]!r}", path
        )
    odd = dice.choice(ODD)
    if equals:
        lines[place] = f"{key} = {odd}{mark}{comment}"
    else:
        parts = line.split(",") if "," in line else line.split()
        if parts:
            parts[dice.randrange(len(parts))] = odd
        lines[place] = ("," if "," in line else " ").join(parts)
    return Changed(_text(lines), f"line {place + 1}: {line[:60]!r} -> {odd}")


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


def write(kind: Kind, content: bytes, folder: Path) -> Path:
    """Write a file and those beside it; its path."""
    path = folder / kind.name
    path.write_bytes(content)
    for name, text in kind.beside.items():
        (folder / name).write_text(text.replace("{file}", kind.name))
    return path


def outcome(path: Path, act: Callable[[Path], Any]) -> Outcome:
    """Read or run a file as the commands do, and keep what they say."""
    told = io.StringIO()
    start = time.process_time()
    argv = sys.argv
    code: Any = None
    try:
        sys.argv = ["program", "file"]
        with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
            application.call(lambda standalone_mode: act(path) and None)  # type: ignore[arg-type]
    except SystemExit as end:
        code = end.code
    finally:
        sys.argv = argv
    lines = told.getvalue().splitlines()
    errors = tuple(line for line in lines if line.startswith("error: "))
    warned = tuple(line for line in lines if line.startswith("warning: "))
    # how long work has taken so far is said where the machine is busy
    others = tuple(
        line for line in lines if not line.startswith(("error: ", "warning: ")) and not PROGRESS.search(line)
    )
    return Outcome(code, errors, warned, others, time.process_time() - start)


def outcome_apart(path: Path, act: Callable[[Path], Any]) -> Outcome:
    """End in a process of its own, which may crash or hang."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=lambda: sender.send(outcome(path, act)))
    start = time.monotonic()
    process.start()
    sender.close()
    try:
        if receiver.poll(PATIENCE):
            return receiver.recv()  # type: ignore[no-any-return]
        return Outcome("no end", seconds=time.monotonic() - start)
    except EOFError:
        process.join()
        return Outcome(f"crash {process.exitcode}", seconds=time.monotonic() - start)
    finally:
        process.kill()
        process.join()
        receiver.close()


def faults(kind: Kind, change: Changed, ends: Sequence[Outcome]) -> Iterator[str]:
    """Lines that say what is wrong with what came of a change, read and run; see the head of this file."""
    last = ends[-1]
    for end in ends:
        if end.code not in STOPPED or (end.code == 3 and end is ends[0]):
            yield f"exit {end.code}: {end.errors[:2]}"
        if end.seconds > LONGEST:
            yield f"took {end.seconds:.0f} s"
        for line in (*end.errors, *end.warnings):
            if len(line) > WIDEST:
                yield f"a line of {len(line)} characters: {line[:200]}"
        if end.others:
            yield f"says {end.others[:2]}"
    # a file that is cut off may lack parts of several tables
    most = 4 if change.what.startswith("cut") else 2
    # a datasheet that began as a machine of the library says besides what is left of that machine
    refusals = [line for line in last.errors if LEFT not in line]
    if last.code and not 1 <= len(refusals) <= most:
        yield f"{len(last.errors)} lines of errors: {last.errors[:3]}"
    if last.code == 2 and not any(_names(line, kind, change) for line in (*last.errors, *last.warnings)):
        yield f"names neither file nor key: {last.errors}"
    if last.code == 0 and change.key and not _may_be_any(change.key):
        warned = [line for end in ends for line in end.warnings]
        if not warned or not _is_of(warned[0], change.key):
            yield f"{SILENT}: {warned[:1]}"


def _is_of(line: str, key: str) -> bool:
    """True for a warning that names a key or its section."""
    section = key.partition(".")[0]
    return section in line or key.rpartition(".")[2] in line


def _names(line: str, kind: Kind, change: Changed) -> bool:
    return any(name in line for name in (kind.name, *kind.beside, change.key or kind.name, "run "))


def _may_be_any(key: str) -> bool:
    return any(key.startswith(name) or key.endswith(f".{name}") for name in ANY)


def mutated(
    kinds: Sequence[Kind], count: int, folder: Path, seed: int = SEED, run: bool = False, first: int = 0
) -> Iterator[tuple[Kind, Changed, list[Outcome], list[str]]]:
    """Changes by turns of kinds of files from the first asked on, what came of each and its faults."""
    dice = random.Random(seed)
    for number in range(count):
        kind = kinds[number % len(kinds)]
        change = changed(kind, dice)
        if number < first:
            continue
        path = write(kind, change.content, folder)
        end = outcome_apart if run else outcome
        ends = [end(path, kind.read)]
        if run and ends[0].code == 0:
            ends.append(end(path, kind.run))
        yield kind, change, ends, list(faults(kind, change, ends))


def all_kinds(folder: Path) -> list[Kind]:
    """All kinds, of which some need histories, which are written into the folder."""
    file_kinds.prepare(folder)
    return [
        *file_kinds.case_kinds(),
        *file_kinds.table_kinds(),
        *file_kinds.map_kinds(),
        *file_kinds.mesh_kinds(),
        *file_kinds.run_kinds(folder),
    ]


def quick_kinds() -> list[Kind]:
    """Kinds that are read in a few tenths of a second at most, and need no history."""
    slow = {"assessment.toml", "load_cases.toml", "measured.csv"}
    kinds = [*file_kinds.case_kinds(), *file_kinds.table_kinds(), *file_kinds.map_kinds()]
    return [kind for kind in kinds if kind.name not in slow]


def main() -> None:
    """Read as many changed files as asked for, and print those at fault."""
    parser = argparse.ArgumentParser()
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--first", type=int, default=0, help="number of the first change that is tried")
    parser.add_argument("--run", action="store_true")
    parser.add_argument("--taken", action="store_true")
    parser.add_argument("--only", default="")
    asked = parser.parse_args()
    ends: Counter[str] = Counter()
    slowest = 0.0
    at_fault = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        kinds = all_kinds(folder) if asked.run else quick_kinds()
        kinds = [kind for kind in kinds if asked.only in kind.name]
        if asked.run:
            # what is compiled is loaded once, for all processes
            for kind in kinds:
                path = write(
                    kind, kind.content if kind.made is None else kind.made(kind.content.decode()), folder
                )
                done = [outcome(path, kind.read), outcome(path, kind.run)]
                said = [(end.code, round(end.seconds, 1), end.errors, end.warnings) for end in done]
                print(f"{kind.name}: {said}", flush=True)
        for number, (kind, change, came, wrong) in enumerate(
            mutated(kinds, asked.count, folder, asked.seed, asked.run, asked.first), start=asked.first
        ):
            ends[f"{[end.code for end in came]}"] += 1
            slowest = max(slowest, *(end.seconds for end in came))
            at_fault += bool(wrong)
            for line in wrong:
                print(f"{number} {kind.name}: {change.what}: {line}", flush=True)
            if asked.taken and not wrong and came[-1].code != 2:
                said = [line for end in came for line in (*end.errors, *end.warnings)]
                end = f"{came[-1].code} in {sum(part.seconds for part in came):.1f} s"
                print(f"    {number} {kind.name}: {change.what}: {end} {said[:1]}", flush=True)
    tried = asked.count - asked.first
    print(f"{tried} changes, exit codes {dict(ends)}, slowest {slowest:.1f} s, at fault {at_fault}")


if __name__ == "__main__":
    main()
