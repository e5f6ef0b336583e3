"""What a run takes: the time of its parts before it begins, and its progress while it works.

Times are those of a rule, in s of wall time on two cores (docs/speed.md, docs/sweeps.md), times what earlier
runs on this machine took over what the rule gives. Progress is a bar on a terminal and elsewhere a line now
and then; a run's log has the lines, too.
"""

import hashlib
import json
import logging
import statistics
import sys
import threading
import time as clock
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

if TYPE_CHECKING:
    from exudyn_crawler.case import CaseFile

REFRESH = 0.2  # s of wall time between updates of a bar; an update costs more than a time step
LINE_EVERY = 10.0  # s of wall time between lines where there is no terminal, and in a log

REDUCE, COMPILE, SIMULATE = "reduce the flexible shoe", "compile the equations", "simulate"
FIELDS, RECOVER, WRITE = "static fields of the shoe", "recover stresses", "tables and figures"
ONCE = (REDUCE, COMPILE, FIELDS)
"""Parts that stay on a machine: another run of the same shoe, or with the same equations, has none."""
BEGIN, BEGIN_CLOSED = 0.5, 2.5  # s of a run beside its steps: rest, files, record; rest of a closed track
SHOES = 13
STEP = {True: 0.6e-3, False: 1.2e-3}  # s a step of so many rigid shoes, with compiled equations and without
STEP_FLEXIBLE = {True: 0.1e-3, False: 2.0e-3}  # s more of a flexible one
ROLLED, ROLLED_FLEXIBLE = 2.5, 1.0e-3  # times that of rigid shoes, and s more of a flexible one, if rolled
RECOVERY = 1.0e-3  # s a stored time of a flexible shoe, whose stresses are recovered
PER_NODE = {REDUCE: 0.6e-3, FIELDS: 1.0e-3, SIMULATE: 1.5e-4, RECOVER: 5e-5}  # s; of each shoe, the last
COMPILING = 50.0  # s of the equations of a kind of track
WRITING = {"tables": 0.5, "figures": 5.0, "pictures": 1.0, "page": 4.0}  # s, pictures of each flexible shoe
TIMES = {"days": 86400.0, "h": 3600.0, "min": 60.0, "s": 1.0}
EARLIER, REMEMBERED = "run_times.json", 5
"""File of earlier runs among the cached reductions, and runs of a kind that count."""
MOST_MADE = 200  # parts that stay on the machine and are remembered
FOUND = 0.2
"""Part of its time below which a part was found and not made."""

logger = logging.getLogger("exudyn_crawler")


def rule_of_thumb(case_file: "CaseFile") -> dict[str, float]:
    """Wall time in s of the parts of a run of which nothing is cached, by a rule."""
    case, solver, outputs = case_file.case, case_file.case.solver, case_file.outputs
    flexible = 0 if case.flexible is None else len(case.flexible.shoes)
    step, more = STEP[case.is_compiled] * case.track.shoe_count / SHOES, STEP_FLEXIBLE[case.is_compiled]
    if case.is_rolled:
        step, more = ROLLED * step, ROLLED_FLEXIBLE
    times = {COMPILE: COMPILING} if case.is_compiled else {}
    begin = BEGIN_CLOSED if case.is_closed else BEGIN
    times[SIMULATE] = begin + case_file.duration / solver.step * (step + more * flexible)
    if case.flexible is not None:
        from meshes import geometry, mesh_named

        mesh = case.flexible.mesh
        nodes = geometry.NODES[mesh] if mesh in geometry.NODES else len(mesh_named(mesh).nodes)
        times[SIMULATE] += PER_NODE[SIMULATE] * nodes
        recovery = RECOVERY * solver.stored_times(case_file.duration) + PER_NODE[RECOVER] * nodes
        fields = {FIELDS: PER_NODE[FIELDS] * nodes} if case.flexible.static_fields else {}
        times = {REDUCE: PER_NODE[REDUCE] * nodes} | times | fields | {RECOVER: recovery * flexible}
    written = {"pictures": flexible * WRITING["pictures"]}
    writing = sum((WRITING | written)[name] for name in WRITING if getattr(outputs, name))
    return times | ({WRITE: writing} if writing else {})


class RunTimes:
    """Time of the parts of a run: expected, and noted for later runs on this machine."""

    def __init__(self, case_file: "CaseFile") -> None:
        from exudyn_crawler.model.reductions import program_digest, reductions_folder

        case, made = case_file.case, program_digest()
        self._rule, self._file = rule_of_thumb(case_file), reductions_folder() / EARLIER
        self._earlier: dict[str, Any] = {}
        with suppress(OSError, ValueError, TypeError):
            self._earlier = dict(json.loads(self._file.read_text(encoding="utf-8")))
        mesh = "" if case.flexible is None else f" {case.flexible.mesh}"
        kind = "closed" if case.is_closed else "rolled" if case.is_rolled else "dragged"
        kind += "" if case.is_compiled else " by Exudyn"
        written = " ".join(name for name in WRITING if getattr(case_file.outputs, name))
        of = {COMPILE: kind, SIMULATE: f"{kind}{mesh}", WRITE: f"{written}{mesh}"}
        self._keys = {part: f"{part}: {of.get(part, mesh)}" for part in self._rule}
        made += case.model_dump_json(include={"flexible", "track", "shoe", "undercarriage"})
        digest = hashlib.sha256(made.encode()).hexdigest()
        self._made = {part: f"{self._keys[part]} {digest}" for part in ONCE if part in self._rule}
        self._made |= {COMPILE: f"{kind} {program_digest()}"}

    def expected(self, without: Collection[str] = ()) -> dict[str, float]:
        """Wall time in s of the parts that the run is going to have, in order."""
        there = self._earlier.get("made", [])
        parts = [part for part in self._rule if part not in without and self._made.get(part) not in there]
        ratios = {part: self._earlier.get(self._keys[part]) or [1.0] for part in parts}
        return {part: self._rule[part] * statistics.median(ratios[part]) for part in parts}

    def line(self, without: Collection[str] = ()) -> str:
        """Time of a run and of each of its parts, for reading."""
        from exudyn_crawler.case.parameters.fields import in_units

        parts = self.expected(without)
        words = [
            f"{part} {in_units(time, TIMES, 2)}{' (once)' if part in ONCE else ''}"
            for part, time in parts.items()
        ]
        known = any(self._keys[part] in self._earlier for part in parts)
        whence = "as in earlier runs on this machine" if known else "by a rule of thumb"
        return f"time: about {in_units(sum(parts.values()), TIMES, 2)} {whence}: {', '.join(words)}"

    def note(self, taken: Mapping[str, float]) -> None:
        """Note what the parts of a run took, s, as far as it had them whole."""
        found: dict[str, Any] = dict(self._earlier)
        for part, time in taken.items():
            ratio = time / self._rule[part] if self._rule.get(part) else 0.0
            if ratio > 0.0 and (part not in ONCE or ratio > FOUND):
                found[self._keys[part]] = [*found.get(self._keys[part], []), ratio][-REMEMBERED:]
        there = dict.fromkeys(
            [*found.get("made", []), *(self._made[one] for one in taken if one in self._made)]
        )
        found["made"] = [*there][-MOST_MADE:]
        # what only saves a guess stops no run
        with suppress(OSError):
            from exudyn_crawler.files import whole_file

            self._file.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(self._file, overwrite=True) as temporary:
                temporary.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


@contextmanager
def progress_bar(
    title: str, duration: float, show: bool | None = None, unit: str = "s"
) -> Iterator[Callable[[float], None]]:
    """Show simulated time, or what counts in another unit, speed and time left; gives a function of the time.

    `show` None shows a bar on a terminal, and a line every `LINE_EVERY` where stderr is something else.
    """
    console, begun = Console(stderr=True), list[tuple[float, float]]()
    on_terminal = show or (show is None and console.is_terminal)
    digits = ".2f" if unit == "s" else ".0f"
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn(f"{{task.completed:{digits}}} of {{task.total:g}} {unit}"),
        TextColumn("{task.fields[speed]}"),
        TimeRemainingColumn(),
    )
    shown = told = clock.perf_counter()
    with Progress(*columns, console=console, disable=not on_terminal) as bar:
        task = bar.add_task(title, total=duration, speed="")

        def tell(time: float) -> None:
            nonlocal shown, told
            now = clock.perf_counter()
            # the first step, which loads or compiles, does not count
            if not begun or (len(begun) == 1 and time > begun[0][0]):
                begun.append((time, now))
            if now - shown < min(REFRESH, LINE_EVERY) and time < duration:
                return
            shown, (first, start) = now, begun[-1]
            wall = (now - start) / (time - first) if time > first else None
            speed = "" if wall is None else f"{wall:.3g} s wall per {unit.removesuffix('s') or unit}"
            bar.update(task, completed=time, speed=speed)
            if now - told >= LINE_EVERY and time < duration:
                told = now
                left = "" if wall is None else f", {speed}, about {wall * (duration - time):.0f} s left"
                _line(f"{title}: {time:.4g} of {duration:g} {unit}{left}", show is None and not on_terminal)

        yield tell


def _line(text: str, shown: bool) -> None:
    """Write a line of progress to the log and, where it is `shown`, to stderr."""
    logger.info(text)
    if shown:
        note(text)


def note(line: str) -> None:
    """Write a line to stderr, where progress is shown, too."""
    print(line, file=sys.stderr, flush=True)


@contextmanager
def heartbeat(title: str, expected: float | None = None, show: bool | None = None) -> Iterator[None]:
    """Show how long a block has taken, of what it is `expected` to take (s); `show` as of `progress_bar`."""
    start, ended, console = clock.perf_counter(), threading.Event(), Console(stderr=True)
    on_terminal = show or (show is None and console.is_terminal)
    about = "" if expected is None else f" of about {expected:.0f} s"
    columns = TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn(about)

    def beat() -> None:
        told = start
        while not ended.wait(min(REFRESH, LINE_EVERY)):
            now = clock.perf_counter()
            bar.update(task, completed=now - start)
            if now - told >= LINE_EVERY:
                told = now
                _line(f"{title}: {now - start:.0f} s so far{about}", show is None and not on_terminal)

    with Progress(*columns, console=console, transient=console.is_terminal, disable=not on_terminal) as bar:
        task = bar.add_task(title, total=expected)
        thread = threading.Thread(target=beat, daemon=True)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
