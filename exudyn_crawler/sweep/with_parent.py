"""Dask loads this module in a process of workers: it ends them when the sweep that began them has ended.

Also if the sweep was killed: its end of the pipe to the process then closes.
"""

import os
import signal
import sys
from functools import cache
from threading import Thread


def dask_setup(_nanny: object) -> None:
    """Watch the pipe; Dask calls this for every worker of the process."""
    _watch()


@cache
def _watch() -> None:
    # once a process: Dask takes a second signal for a wish to end at once, without order
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    sys.stdin.buffer.read()
    os.kill(os.getpid(), signal.SIGTERM)
