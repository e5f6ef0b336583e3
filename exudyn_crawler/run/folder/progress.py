"""Progress of a run: a bar on a terminal, elsewhere a line now and then."""

import sys
import threading
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

REFRESH = 0.2  # s of wall time between updates of a bar; an update costs more than a time step
LINE_EVERY = 10.0  # s of wall time between lines where there is no terminal


@contextmanager
def progress_bar(
    title: str, duration: float, show: bool | None = None, unit: str = "s"
) -> Iterator[Callable[[float], None]]:
    """Show simulated time, or what counts in another unit, speed and time left; gives a function of the time.

    `show` None shows a bar on a terminal, and a line every `LINE_EVERY` where stderr is something else.
    """
    console = Console(stderr=True)
    if show is False:
        yield lambda _time: None
    elif show or console.is_terminal:
        digits = ".2f" if unit == "s" else ".0f"
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn(f"{{task.completed:{digits}}} of {{task.total:g}} {unit}"),
            TextColumn("{task.fields[speed]}"),
            TimeRemainingColumn(),
        )
        with Progress(*columns, console=console, transient=False) as bar:
            task = bar.add_task(title, total=duration, speed="")

            def update(time: float, wall: float | None) -> None:
                bar.update(task, completed=time, speed=_speed(wall, unit))

            yield _paced(REFRESH, duration, update)
    else:

        def line(time: float, wall: float | None) -> None:
            if (rest := duration - time) > 0.0:
                left = "" if wall is None else f", {_speed(wall, unit)}, about {wall * rest:.0f} s left"
                note(f"{title}: {time:.4g} of {duration:g} {unit}{left}")

        yield _paced(LINE_EVERY, duration, line)


def _paced(
    every: float, duration: float, show: Callable[[float, float | None], None]
) -> Callable[[float], None]:
    """Function that shows a time, with the wall time a simulated second, every so many s and at the end.

    The first step, which loads or compiles, does not count.
    """
    last = clock.perf_counter()
    begun: list[tuple[float, float]] = []

    def tell(time: float) -> None:
        nonlocal last
        now = clock.perf_counter()
        if not begun or (len(begun) == 1 and time > begun[0][0]):
            begun.append((time, now))
        if now - last < every and time < duration:
            return
        last = now
        first, start = begun[-1]
        show(time, (now - start) / (time - first) if time > first else None)

    return tell


def note(line: str) -> None:
    """Write a line to stderr, where progress is shown, too."""
    print(line, file=sys.stderr, flush=True)


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
