"""Delay of interrupts while a library cannot handle them, and memory of those that are lost."""

import signal
import threading
from collections.abc import Callable, Iterator
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


@contextmanager
def interrupts_remembered() -> Iterator[Callable[[], None]]:
    """Give a function that raises `KeyboardInterrupt` if there was an interrupt within the block.

    One that comes while Python frees an object is raised in a callback there, which ends in a line on stderr
    and nothing else: who works through many parts asks between them.
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
