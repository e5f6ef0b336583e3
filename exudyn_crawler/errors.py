"""Errors and warnings for users of the package."""

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

INTERRUPTED = "interrupted"  # reason of a stopped simulation that could continue
GOES_ON = "run the same command again to continue"  # advice for this case
ASK_TO_OVERWRITE = "allow overwriting (--overwrite, in Python overwrite=True)"
"""Advice for existing results."""
ENDED_FROM_OUTSIDE = 130  # exit code of a command interrupted outside of a simulation
LONGEST_LINE = 560  # greatest number of characters of a line on the console
LINE_BEGIN = 400
LINE_END = 120


def cut_line(line: str) -> str:
    """Return a line without its middle if it is too long to read: libraries repeat a broken file."""
    return line if len(line) <= LONGEST_LINE else f"{line[:LINE_BEGIN]} ... {line[-LINE_END:]}"


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Return a question with the known name nearest to a wrong one; empty if none is near."""
    near = difflib.get_close_matches(str(name), known, n=1)
    return f"did you mean {near[0]!r}? " if near else ""


class CrawlerError(Exception):
    """Base of the package's own errors."""


class ImplausibleWarning(UserWarning):
    """Warning of values that no known machine or ground has; the case runs all the same."""


class UnbalancedWarning(UserWarning):
    """Warning of a start with residual forces above a hundredth of the weight; the run goes on."""


class ParameterError(CrawlerError, ValueError):
    """Error of parameters that are not allowed: one line each with name, value and what is allowed."""

    @property
    def errors(self) -> list[str]:
        """Lines of the error, one for each parameter."""
        return str(self).splitlines()


class LeftMapError(CrawlerError):
    """Error of a shoe outside of the measured heights."""


class EquilibriumError(CrawlerError):
    """Error of a track without a static equilibrium before the run."""


class NoAnswerError(CrawlerError):
    """Error of a sweep without an answer of any run."""


class SimulationStopped(CrawlerError):  # noqa: N818 - it carries a result, as StopIteration does
    """End of a run before its time (s), with a reason; its history so far is kept, None if it has none."""

    def __init__(self, time: float, reason: str, history: Any) -> None:
        super().__init__(f"the simulation stopped at t = {time:.6g} s: {reason}")
        self.time = time
        self.reason = reason
        self.history = history


class CaseFileError(CrawlerError, ValueError):
    """Error of a case file, or of a file in it, that cannot be used; `errors` has one line each."""

    def __init__(self, path: Path, errors: list[str]) -> None:
        self.errors = [" ".join(error.split()) for error in errors]
        super().__init__("\n".join(f"{path}: {error}" for error in self.errors))
