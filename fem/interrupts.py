"""Delay of interrupts while a library cannot handle them."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_wait() -> Iterator[list[int]]:
    """Delay Ctrl-C and requests to terminate until the end of the block; yield the list of those that wait.

    Also a decorator. Compiled libraries that call Python (HDF5 with its lock and with Python files, LLVM that
    asks for cached code, VTK that imports its parts) crash, end the process, lose the interrupt or report
    another error if it comes within such a call. Signals that are ignored stay ignored.
    """
    waiting: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield waiting
        return
    before = {
        number: signal.signal(number, lambda number, _frame: waiting.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield waiting
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        if waiting:
            signal.raise_signal(waiting[0])
