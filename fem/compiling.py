"""Cache of compiled functions on disk, valid until a function that they call changes.

numba caches compiled code beside the source and compiles again when that file changes. It does not notice
changes in other files. A cached function is therefore stamped with all sources that it consists of.
"""

import hashlib
import inspect
import sys
import warnings
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, get_args

import numba
import numpy as np
from numba import njit, types
from numba.core.event import Event, Listener, install_listener

from fem.interrupts import interrupts_wait

THEIRS = {*sys.stdlib_module_names, *sys.builtin_module_names, "llvmlite", "numba", "numpy"}
"""Top modules whose changes make no compiled code stale: numba checks its own version."""
CONSTANTS = (bool, int, float, complex, str, bytes, tuple, type(None), np.generic, np.ndarray)
"""Types of values that compiled code takes as they are."""
COUNTS = {"_nrt": True} if hasattr(getattr(numba.core.options, "DefaultOptions", None), "_nrt") else {}
"""Option, private to numba, that a function counts references to arrays whatever its first caller does."""


def compiler(*parts: Any, **options: Any) -> Callable[[Callable], Any]:
    """Return a decorator that compiles a function and caches the code until one of its sources changes.

    Parameters
    ----------
    parts : Any
        Functions and classes that the function uses without naming them itself.
    options :
        Options of `numba.njit`.
    """
    options = COUNTS | options

    def compiled(function: Callable) -> Any:
        dispatcher = njit(cache=True, **options)(function)
        # read now: a later change of the file does not concern the imported code
        _content(Path(function.__code__.co_filename))
        # numba has no public way to add sources
        cached: Any = getattr(dispatcher, "_cache", None)
        file: Any = getattr(cached, "_cache_file", None)
        classes: tuple[type, type] = type(cached), type(file)
        compile_now = interrupts_wait()(dispatcher.compile)
        if not _compares_stamps(*classes):
            dispatcher = njit(**options)(function)
            dispatcher.compile = interrupts_wait()(dispatcher.compile)
            return dispatcher
        cached.save_overload = _forgiving(cached.save_overload, cached.flush)
        add_stamp = cache(lambda: _add_stamp(file, _stamp(dispatcher, *parts)))

        # LLVM asks Python for cached code; an interrupt at that moment makes it call a missing function
        def stamped(signature: Any) -> Any:
            # only now, since called functions may be defined below this one
            add_stamp()
            return compile_now(signature)

        dispatcher.compile = stamped
        return dispatcher

    return compiled


@cache
def _content(path: Path) -> bytes:
    return path.read_bytes()


def _stamp(*roots: Any) -> str:
    """Return the digest of all sources and constants of compiled functions and classes."""
    files, texts = _reached(roots)
    digest = hashlib.sha256()
    for content in sorted(map(_content, files)):
        digest.update(content)
    digest.update("\n".join(sorted(texts)).encode())
    return digest.hexdigest()


def sources_of(function: Any) -> set[Path]:
    """Return the files of a compiled function and all functions and classes it uses; none of constants."""
    return _reached([function])[0]


def _reached(roots: Iterable[Any]) -> tuple[set[Path], set[str]]:
    """Return the files of all functions and classes that compiled functions use, directly or not.

    The second result holds, as texts, their options and the values of the constants that they read: a
    constant may come from any file.
    """
    files: set[Path] = set()
    texts: set[str] = set()
    known: dict[int, Any] = {}
    todo = list(roots)
    while todo:
        thing = todo.pop()
        if id(thing) not in known:
            known[id(thing)] = thing
            file, text, named = _consists_of(thing)
            files |= file
            texts |= text
            todo += named
    return files, texts


def _consists_of(thing: Any) -> tuple[set[Path], set[str], list[Any]]:
    """Return the file of an object of compiled code, its dependencies as texts, and the objects it names."""
    function = getattr(thing, "py_func", getattr(thing, "_defn", thing))
    if isinstance(thing, ModuleType) or _is_theirs(function):
        return set(), set(), []
    if isinstance(function, FunctionType):
        named = _named_by(function)
        name = f"{function.__module__}.{function.__qualname__}"
        texts = {f"{name}: {key} = {_text(value)}" for key, value in named if isinstance(value, CONSTANTS)}
        texts.add(f"{name}: {_options(getattr(thing, 'targetoptions', {}))}")
        return {Path(function.__code__.co_filename)}, texts, [value for _, value in named]
    if isinstance(thing, type):
        hints = getattr(thing, "__annotations__", {}).values()
        return {Path(inspect.getfile(thing))}, set(), [hint for hint in hints if not isinstance(hint, str)]
    if isinstance(thing, types.NamedTuple | types.NamedUniTuple):
        return set(), {str(thing)}, [thing.instance_class, *thing.types]
    if isinstance(thing, types.BaseTuple):
        return set(), {str(thing)}, list(thing.types)
    if isinstance(thing, tuple):
        return set(), set(), [type(thing), *thing]
    if isinstance(thing, CONSTANTS):
        return set(), set(), []
    return set(), set(), [type(thing), *get_args(thing)]


def _options(options: Mapping[str, Any]) -> str:
    """Return the options of a compiled function as text; sets are sorted, since their order varies."""
    ordered = {name: sorted(value) if isinstance(value, set) else value for name, value in options.items()}
    return str(sorted(ordered.items()))


def _text(value: Any) -> str:
    """Return the value of a constant as text."""
    return f"{value.dtype} {value.tolist()}" if isinstance(value, np.ndarray) else repr(value)


def _is_theirs(thing: Any) -> bool:
    """Return True for a function or class of Python, numpy or numba."""
    module = getattr(thing, "__module__", None) or ""
    return isinstance(thing, FunctionType | BuiltinFunctionType | type) and (
        module.partition(".")[0] in THEIRS
    )


def _named_by(function: FunctionType) -> list[tuple[str, Any]]:
    """Return the values of a function's global names, free variables and names taken from modules."""
    names: set[str] = set()
    codes = [function.__code__]
    while codes:
        code = codes.pop()
        names.update(code.co_names)
        codes += [constant for constant in code.co_consts if isinstance(constant, CodeType)]
    values = [(name, function.__globals__[name]) for name in names if name in function.__globals__]
    for _, module in [*values]:
        if isinstance(module, ModuleType) and module.__name__.partition(".")[0] not in THEIRS:
            of_module = vars(module)
            values += [(f"{module.__name__}.{name}", of_module[name]) for name in names if name in of_module]
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    return values + [(name, cell.cell_contents) for name, cell in cells]


def _add_stamp(file: Any, stamp: str) -> None:
    """Make a file of numba's cache valid for the stamped sources only, whenever they were written.

    numba compares the version before it reads the rest of the file, which may name types that are gone.
    """
    file._version = f"{file._version} {stamp}"
    file._source_stamp = None


@cache
def _compares_stamps(cache_class: type, kind: type) -> bool:
    """Return True if numba's class of cache files, used by its cache, notices another stamp of `_add_stamp`.

    Warns
    -----
    RuntimeWarning
        If it does not: code compiled from other sources would pass for that of the present ones.
    """
    try:
        with TemporaryDirectory() as folder:
            before, after = (kind(folder, "trial", 0.0) for _ in range(2))
            _add_stamp(before, "before")
            _add_stamp(after, "after")
            before.save("key", "code")
            works = before.load("key") == "code" and after.load("key") is None
            works = works and hasattr(cache_class, "save_overload") and hasattr(cache_class, "flush")
    except OSError:
        works = True  # a full disk says nothing about numba
    except Exception:
        works = False
    if not works:
        warnings.warn(
            f"numba {numba.__version__} no longer stamps its cache as expected: every process compiles all "
            f"functions again, which takes minutes",
            RuntimeWarning,
            stacklevel=3,
        )
    return works


@contextmanager
def notify_compiling(functions: Collection[Any], notify: Callable[[], None]) -> Iterator[None]:
    """Call `notify` once if one of the given compiled functions has to be compiled within the context."""
    with install_listener("numba:compile", _Once(functions, notify)):
        yield


class _Once(Listener):
    def __init__(self, functions: Collection[Any], notify: Callable[[], None]) -> None:
        self._left = list(functions)
        self._notify = notify

    def on_start(self, event: Event) -> None:
        if any(event.data["dispatcher"] is dispatcher for dispatcher in self._left):
            self._left = []
            self._notify()

    def on_end(self, event: Event) -> None:
        """Do nothing at the end of a compilation."""


def _forgiving(save: Callable[..., None], forget: Callable[[], None]) -> Callable[..., None]:
    """Return a function that saves compiled code and ignores a full disk: the cache only saves time."""

    def saved(*values: Any) -> None:
        try:
            save(*values)
        except OSError:
            # numba writes the index first; it may then name a file with code of earlier sources
            with suppress(OSError):
                forget()

    return saved
