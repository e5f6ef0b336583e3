"""Interrupts that wait while a library must not meet them."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_wait() -> Iterator[list[int]]:
    """Let Ctrl-C and requests to terminate wait for the end of the block, in a list that it gives.

    Serves as a decorator, too. Compiled libraries that call Python (HDF5 with its lock and with Python files,
    LLVM that asks for kept code, VTK that imports its parts) crash, end the process, lose the interrupt or
    tell of another error where it comes within such a call. One that is ignored stays so.
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
