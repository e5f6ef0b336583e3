"""Computing time of a run: estimate of its parts beforehand, and progress while it works.

The estimates follow a rule, in s of processor time (docs/speed.md, docs/sweeps.md). A part takes longer
beside other work; its progress estimates the time left from the speed so far. Progress is a bar on a terminal
and a line now and then elsewhere; a run's log also has the lines.
"""

import json
import logging
import sys
import threading
import time as clock
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import progress as bars
from rich.console import Console

if TYPE_CHECKING:
    from exudyn_crawler.machines import CaseFile

REFRESH = 0.2  # s of wall time between updates of a bar; an update costs more than a time step
LINE_EVERY = 10.0  # s of wall time between lines where there is no terminal, and in a log

REDUCE = "reduce the flexible shoe"
COMPILE = "compile the equations"
SIMULATE = "simulate"
FIELDS = "static fields of the shoe"
RECOVER = "recover stresses"
WRITE = "tables and figures"
ONCE = (REDUCE, COMPILE, FIELDS)  # parts cached on a computer for further runs of the same shoe
SIMULATION = (COMPILE, SIMULATE)  # parts that a stored history replaces
BEGIN = {"dragged": 0.5, "rolled": 0.5, "closed": 2.5, "machine": 2.5}
"""Time of a run beside its steps, for rest, files and record, by the kind of gear, s."""
SHOES = 13
STEP = {True: 0.6e-3, False: 1.2e-3}  # time of a step of `SHOES` rigid shoes, compiled equations or not, s
STEP_FLEXIBLE = {True: 0.1e-3, False: 2.0e-3}  # more time of a step for each flexible shoe, s
SLOWER, MORE_FLEXIBLE = {"rolled": 2.5}, {"rolled": 1.0e-3}
"""Factor of the rigid shoes' time, and more time (s) of a flexible shoe, for gear kinds with other values."""
RECOVERY = 0.25e-3  # time to recover the stresses of a flexible shoe at a stored time, s
PER_NODE = {REDUCE: 0.6e-3, FIELDS: 0.3e-3, SIMULATE: 1.5e-4, RECOVER: 5e-5}  # s; the last for each shoe
COMPILING = 50.0  # time to compile the equations, s
WRITING = {"tables": 0.5, "figures": 8.0, "pictures": 1.0, "page": 4.0}  # s; pictures for each flexible shoe
TIMES = {"days": 86400.0, "h": 3600.0, "min": 60.0, "s": 1.0}

PROGRESS = "progress.json"
"""File with the progress of a running run's part, in the run's folder."""
NOTE_EVERY = 1.0  # wall time between writes of this file, s

logger = logging.getLogger("exudyn_crawler")
_noting: list[Path] = []  # files of the blocks of `noted_in` that have not ended


def rule_of_thumb(case_file: "CaseFile") -> dict[str, float]:
    """Return the processor time in s of the parts of a run by a rule, without any cached part.

    Compilation takes the same time again in a second process at once.
    """
    case = case_file.case
    quiet = case.drive.quiet_time(case_file.duration)
    steps = case.solver.steps(case_file.duration, quiet)
    stored = case.solver.stored_times(case_file.duration, quiet)
    outputs = case_file.outputs
    flexible = 0 if case.flexible is None else len(case.flexible.shoes)
    step = STEP[case.is_compiled] * SLOWER.get(case.gear.kind, 1.0) * case.track.shoe_count / SHOES
    more = MORE_FLEXIBLE.get(case.gear.kind, STEP_FLEXIBLE[case.is_compiled])
    times = {COMPILE: COMPILING} if case.is_compiled else {}
    times[SIMULATE] = BEGIN[case.gear.kind] + steps * (step + more * flexible)
    if case.flexible is not None:
        from meshes import geometry, mesh_named

        mesh = case.flexible.mesh
        nodes = geometry.NODES[mesh] if mesh in geometry.NODES else len(mesh_named(mesh).nodes)
        times[SIMULATE] += PER_NODE[SIMULATE] * nodes
        recovery = RECOVERY * stored + PER_NODE[RECOVER] * nodes
        fields = {FIELDS: PER_NODE[FIELDS] * nodes} if case.flexible.static_fields else {}
        times = {REDUCE: PER_NODE[REDUCE] * nodes} | fields | times | {RECOVER: recovery * flexible}
    written = {"pictures": flexible * WRITING["pictures"]}
    writing = sum((WRITING | written)[name] for name in WRITING if getattr(outputs, name))
    return times | ({WRITE: writing} if writing else {})


def times_line(times: Mapping[str, float]) -> str:
    """Return a line with the processor time of a run's parts (s) by the rule; cached parts are separate."""
    from exudyn_crawler.settings.fields import in_units

    def sum_of(parts: Mapping[str, float]) -> str:
        words = ", ".join(f"{part} {in_units(time, TIMES, 2)}" for part, time in parts.items())
        return f"about {in_units(sum(parts.values()), TIMES, 2)} of processor time ({words})"

    once = {part: time for part, time in times.items() if part in ONCE}
    every = {part: time for part, time in times.items() if part not in ONCE}
    more = f", at the first start on a computer {sum_of(once)} more" if once else ""
    return f"time: {sum_of(every)}{more}, by a rule of thumb"


@contextmanager
def noted_in(folder: Path | None) -> Iterator[None]:
    """Write the progress of the block to a file of a folder, for other programs."""
    if folder is None:
        yield
        return
    path = folder / PROGRESS
    _noting.append(path)
    try:
        yield
    finally:
        _noting.remove(path)
        with suppress(OSError):
            path.unlink(missing_ok=True)


def _note(title: str, done: float, total: float | None) -> None:
    """Write the progress of a part to the files of `noted_in`; a full disk does not stop a run."""
    for path in _noting:
        temporary = path.with_name(f".{path.name}")
        with suppress(OSError):
            temporary.write_text(json.dumps({"title": title, "done": done, "total": total}), encoding="utf-8")
            temporary.replace(path)


@contextmanager
def _shown(
    title: str, total: float | None, show: bool | None, *columns: bars.ProgressColumn, transient: bool = False
) -> Iterator[Callable[..., None]]:
    """Show a bar or lines as in `progress_bar`, also in a log; yield a function of done part and line."""
    console = Console(stderr=True)
    last_line = clock.perf_counter()
    noted = last_line - NOTE_EVERY
    on_terminal = show or (show is None and console.is_terminal)
    described = bars.TextColumn("{task.description}"), bars.BarColumn()
    with bars.Progress(
        *described,
        *columns,
        console=console,
        transient=transient and console.is_terminal,
        disable=not on_terminal,
    ) as bar:
        task = bar.add_task(title, total=total, speed="", about="")

        def tell(done: float, now: float, line: str, **fields: Any) -> None:
            nonlocal last_line, noted
            bar.update(task, completed=done, **fields)
            if now - noted >= NOTE_EVERY:
                noted = now
                _note(title, done, total)
            if now - last_line >= LINE_EVERY and line:
                last_line = now
                logger.info("%s: %s", title, line)
                if show is None and not on_terminal:
                    print(f"{title}: {line}", file=sys.stderr, flush=True)

        yield tell


@contextmanager
def progress_bar(
    title: str, duration: float, show: bool | None = None, unit: str = "s"
) -> Iterator[Callable[[float], None]]:
    """Show simulated time (or a count in another unit), speed and time left; yield a function of the time.

    `show` None shows a bar on a terminal, or a line every `LINE_EVERY` if stderr is not a terminal.
    """
    begun = list[tuple[float, float]]()
    shown = 0.0
    digits = ".2f" if unit == "s" else ".0f"
    done = bars.TextColumn(f"{{task.completed:{digits}}} of {{task.total:g}} {unit}")
    columns = done, bars.TextColumn("{task.fields[speed]}"), bars.TimeRemainingColumn()
    with _shown(title, duration, show, *columns) as tell:

        def advance(time: float) -> None:
            nonlocal shown
            now = clock.perf_counter()
            # the first step does not count, since it loads or compiles
            if not begun or (len(begun) == 1 and time > begun[0][0]):
                begun.append((time, now))
            if now - shown < min(REFRESH, LINE_EVERY) and time < duration:
                return
            shown = now
            first, start = begun[-1]
            wall = (now - start) / (time - first) if time > first else None
            speed = "" if wall is None else f"{wall:.3g} s wall per {unit.removesuffix('s') or unit}"
            left = "" if wall is None else f", {speed}, about {wall * (duration - time):.0f} s left"
            line = f"{time:.4g} of {duration:g} {unit}{left}" if time < duration else ""
            tell(time, now, line, speed=speed)

        yield advance


@contextmanager
def heartbeat(title: str, expected: float | None = None, show: bool | None = None) -> Iterator[None]:
    """Show the time of a block, of an `expected` processor time (s); for `show` see `progress_bar`.

    The time left follows from the remaining expected time and the block's speed so far.
    """
    start = clock.perf_counter()
    begun = clock.process_time()
    ended = threading.Event()

    def beat() -> None:
        while not ended.wait(min(REFRESH, LINE_EVERY)):
            now = clock.perf_counter()
            taken = clock.process_time() - begun
            about = "" if expected is None else _of_expected(taken, expected, now - start)
            done = now - start if expected is None else min(taken, expected)
            tell(done, now, f"{now - start:.0f} s so far{about}", about=about)

    columns = bars.TimeElapsedColumn(), bars.TextColumn("{task.fields[about]}")
    with _shown(title, expected, show, *columns, transient=True) as tell:
        thread = threading.Thread(target=beat, daemon=True)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()


def _of_expected(taken: float, expected: float, wall: float) -> str:
    """Return a text of the processor time taken of the expected one (s), and of the wall time left (s)."""
    if taken >= expected:
        return f", {taken:.0f} s of processor time, more than the {expected:.0f} s of the rule"
    share = f", {taken:.0f} of about {expected:.0f} s of processor time"
    # the first instants do not show the speed
    return share if taken < 1.0 else f"{share}, about {wall * (expected - taken) / taken:.0f} s left"
