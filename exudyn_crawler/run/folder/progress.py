"""Progress of a run: a bar on a terminal, elsewhere a line now and then."""

import sys
import threading
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

REFRESH = 0.2
"""s of wall time between updates of a bar; an update costs more than a time step."""
LINE_EVERY = 10.0
"""s of wall time between lines where there is no terminal."""


@contextmanager
def progress_bar(
    title: str, duration: float, show: bool | None = None, unit: str = "s"
) -> Iterator[Callable[[float], None]]:
    """Show simulated time, speed and time left; the block gets a function to tell the time to.

    The unit is that of the duration, where something else than time is counted. `show` None shows a bar on a
    terminal, and a line every `LINE_EVERY` where stderr is something else.
    """
    console = Console(stderr=True)
    if show is False:
        yield lambda _time: None
    elif show or console.is_terminal:
        with _bar(title, duration, console, unit) as tell:
            yield tell
    else:
        yield _lines(title, duration, unit)


@contextmanager
def _bar(title: str, duration: float, console: Console, unit: str) -> Iterator[Callable[[float], None]]:
    digits = ".2f" if unit == "s" else ".0f"
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn(f"{{task.completed:{digits}}} of {{task.total:g}} {unit}"),
        TextColumn("{task.fields[speed]}"),
        TimeRemainingColumn(),
    )
    last = clock.perf_counter()
    pace = _pace()
    with Progress(*columns, console=console, transient=False) as bar:
        task = bar.add_task(title, total=duration, speed="")

        def tell(time: float) -> None:
            nonlocal last
            now = clock.perf_counter()
            wall = pace(time, now)
            if now - last < REFRESH and time < duration:
                return
            last = now
            bar.update(task, completed=time, speed=_speed(wall, unit))

        yield tell


def _lines(title: str, duration: float, unit: str) -> Callable[[float], None]:
    """Function that writes a line every `LINE_EVERY` until the run's end."""
    last = clock.perf_counter()
    pace = _pace()

    def tell(time: float) -> None:
        nonlocal last
        now = clock.perf_counter()
        wall = pace(time, now)
        if now - last < LINE_EVERY or time >= duration:
            return
        last = now
        line = f"{title}: {time:.4g} of {duration:g} {unit}"
        if wall is not None:
            line += f", {_speed(wall, unit)}, about {wall * (duration - time):.0f} s left"
        note(line)

    return tell


def note(line: str) -> None:
    """Write a line to stderr, where progress is shown, too."""
    print(line, file=sys.stderr, flush=True)


def _pace() -> Callable[[float, float], float | None]:
    """Function of time and clock (s) that gives the wall time a simulated second, as far as it is known.

    The first step is left out: it loads or compiles.
    """
    begun: list[tuple[float, float]] = []

    def pace(time: float, now: float) -> float | None:
        if not begun or (len(begun) == 1 and time > begun[0][0]):
            begun.append((time, now))
        first, start = begun[-1]
        return (now - start) / (time - first) if time > first else None

    return pace


def _speed(wall: float | None, unit: str) -> str:
    """Wall time for a simulated second, or for one of what is counted; empty where it is not known."""
    return "" if wall is None else f"{wall:.3g} s wall per {unit.removesuffix('s') or unit}"


@contextmanager
def heartbeat(title: str) -> Iterator[None]:
    """Write every `LINE_EVERY` how long a block has taken, to stderr."""
    start = clock.perf_counter()
    ended = threading.Event()

    def beat() -> None:
        while not ended.wait(LINE_EVERY):
            note(f"{title}: {clock.perf_counter() - start:.0f} s so far")

    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
