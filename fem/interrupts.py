"""Delay of interrupts during calls of compiled libraries, and a record of interrupts that Python loses."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_wait() -> Iterator[list[int]]:
    """Delay Ctrl-C and requests to terminate until the end of the block; yield the list of delayed signals.

    It is also a decorator. Some compiled libraries call Python: HDF5 for its lock and for Python files, LLVM
    for cached code, VTK for the import of its parts. An interrupt within such a call makes them crash, end
    the process, lose the interrupt or report another error. Signals that are ignored stay ignored.
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


@contextmanager
def interrupts_remembered() -> Iterator[Callable[[], None]]:
    """Yield a function that raises `KeyboardInterrupt` if there was an interrupt within the block.

    Python raises an interrupt in a callback if it frees an object at that moment. The callback prints a line
    on stderr, and the interrupt is lost. A loop over many parts therefore calls the function between them.
    """
    came: list[int] = []

    def interrupt(number: int, _frame: object) -> None:
        came.append(number)
        raise KeyboardInterrupt

    def ask() -> None:
        if came:
            raise KeyboardInterrupt

    in_main = threading.current_thread() is threading.main_thread()
    numbers = (signal.SIGINT, signal.SIGTERM) if in_main else ()
    usual = [number for number in numbers if signal.getsignal(number) is signal.default_int_handler]
    for number in usual:
        signal.signal(number, interrupt)
    try:
        yield ask
    finally:
        for number in usual:
            signal.signal(number, signal.default_int_handler)
