"""Mesher in a process of its own: its crash, hang or interrupt does not end this program.

netgen is compiled code. It holds the interpreter while it works, so that no signal reaches Python. It prints
to the terminal, and damaged solids make it end its process.
"""

import importlib.util
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from multiprocessing.connection import Connection, Pipe
from typing import IO, Any, ParamSpec, TypeVar

from fem.body.mesh import MeshError

LONGEST = 300
"""Time limit of a mesher step, s; a longer step is ended."""
NEEDED = "{} needs netgen, which is not installed: pip install netgen-mesher"
REMEDY = "heal the solid in CAD, or send a mesh of tetrahedra"
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
_to_caller: Connection | None = None
"""Connection to the calling process; set in the mesher's process alone."""


def require_netgen(for_what: str) -> None:
    """Raise a `ModuleNotFoundError` if netgen is missing; it says what needs netgen and how to install it."""
    if importlib.util.find_spec("netgen") is None:
        raise ModuleNotFoundError(NEEDED.format(for_what), name="netgen")


def begin_step(step: str, suspect: str = "") -> None:
    """Tell the calling process which step begins, and which part of the solid may make it fail.

    In the mesher's process the time limit of a step restarts; elsewhere nothing happens.
    """
    if _to_caller is None:
        return
    _to_caller.send((False, step, suspect))
    if sys.platform != "win32":
        # the default action of the alarm ends this process if the calling one has ended
        signal.alarm(2 * LONGEST)


def call(
    function: Callable[Arguments, Result], *arguments: Arguments.args, **named: Arguments.kwargs
) -> Result:
    """Call a function of a module in a process of its own, and return its result or raise its error.

    The process has no terminal; its output is not shown. On Windows this process calls the function.

    Raises
    ------
    MeshError
        If the process crashes, or a step takes longer than `LONGEST`; the message names step and suspect.
    """
    if sys.platform == "win32":
        return function(*arguments, **named)
    # the process finds modules on the same path, without the current folder
    paths = [os.path.abspath(path) for path in sys.path]
    here, there = Pipe()
    with here, tempfile.TemporaryFile() as lines:
        with there:
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", "meshes.mesher", str(there.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=lines,
                stderr=subprocess.STDOUT,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
                pass_fds=(there.fileno(),),
                start_new_session=True,
            )
        try:
            error, result = _answer(here, (function, arguments, named), process, lines)
        finally:
            process.kill()
            process.wait()
    if error is not None:
        raise error
    return result


def _answer(
    here: Connection, task: object, process: "subprocess.Popen[bytes]", lines: IO[bytes]
) -> tuple[Exception | None, Any]:
    """Return the error or the result of a task; raise `MeshError` without either."""
    step = "its start"
    suspect = ""
    try:
        here.send(task)
        while here.poll(LONGEST):
            is_end, *words = here.recv()
            if is_end:
                error, result = words
                return error, result
            step, suspect = words
    except (EOFError, OSError):
        code = process.wait()
        lines.seek(0)
        printed = lines.read().decode(errors="replace").splitlines()
        last = next((line.strip()[:120] for line in reversed(printed) if line.strip()), "no words")
        how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        raise MeshError(f"netgen crashed during {step} ({how}: {last}); {suspect or REMEDY}") from None
    raise MeshError(f"netgen was ended after {LONGEST} s during {step}; {suspect or REMEDY}")


def serve(descriptor: int) -> None:
    """Call the function received through a connection, and answer with its result or its error."""
    global _to_caller
    with Connection(descriptor) as _to_caller:
        function, arguments, named = _to_caller.recv()
        try:
            answer: tuple[bool, Exception | None, Any] = True, None, function(*arguments, **named)
        except Exception as error:
            answer = True, error, None
        _to_caller.send(answer)
    # netgen may crash at exit
    os._exit(0)


if __name__ == "__main__":
    # run as a script, this file is not the module that others import
    from meshes import mesher

    mesher.serve(int(sys.argv[1]))
