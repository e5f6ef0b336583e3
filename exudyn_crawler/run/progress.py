"""Progress of a run on a terminal."""

import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

REFRESH = 0.2
"""s of wall time between updates; an update costs more than a time step."""


@contextmanager
def progress_bar(title: str, duration: float, show: bool | None = None) -> Iterator[Callable[[float], None]]:
    """Show simulated time, speed and time left; the block gets a function to tell the time to.

    Parameters
    ----------
    show : bool, optional
        None shows it on a terminal only.
    """
    console = Console(stderr=True)
    if not (console.is_terminal if show is None else show):
        yield lambda _time: None
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.2f} of {task.total:g} s"),
        TextColumn("{task.fields[speed]:.2f} s wall per s"),
        TimeRemainingColumn(),
    )
    start = clock.perf_counter()
    last = start
    with Progress(*columns, console=console, transient=False) as bar:
        task = bar.add_task(title, total=duration, speed=float("nan"))

        def tell(time: float) -> None:
            nonlocal last
            now = clock.perf_counter()
            if now - last < REFRESH and time < duration:
                return
            last = now
            bar.update(task, completed=time, speed=(now - start) / max(time, 1e-12))

        yield tell
