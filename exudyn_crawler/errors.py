"""Errors that a user of the package can meet."""

from pathlib import Path
from typing import Any

INTERRUPTED = "interrupted"  # why a simulation stopped that could have gone on
GOES_ON = "run the same command again to continue"  # what a user does then
ASK_TO_OVERWRITE = "allow overwriting (--overwrite, in Python overwrite=True)"
"""What a user may do about earlier results."""
ENDED_FROM_OUTSIDE = 130  # exit code of a command that an interrupt ended outside of a simulation
LONGEST_LINE = 560  # characters of a line on the console
LINE_BEGIN = 400
LINE_END = 120


def cut_line(line: str) -> str:
    """Return a line without its middle where it is too long to be read: libraries repeat a broken file."""
    return line if len(line) <= LONGEST_LINE else f"{line[:LINE_BEGIN]} ... {line[-LINE_END:]}"


class CrawlerError(Exception):
    """Base of the package's own errors."""


class ImplausibleWarning(UserWarning):
    """A case has values that no machine and no ground is known to have; it is run all the same."""


class UnbalancedWarning(UserWarning):
    """A run starts farther from rest than a hundredth of the weight; it is run all the same."""


class ParameterError(CrawlerError, ValueError):
    """Parameters that are not allowed: a line for each error with the name, its value and what is allowed."""

    @property
    def errors(self) -> list[str]:
        """A line each."""
        return str(self).splitlines()


class LeftMapError(CrawlerError):
    """A shoe is at a place where no height was measured."""


class EquilibriumError(CrawlerError):
    """No static equilibrium was found before the run."""


class NoAnswerError(CrawlerError):
    """No run of a sweep has an answer."""


class SimulationStopped(CrawlerError):  # noqa: N818 - it carries a result, as StopIteration does
    """A run ended before its time (s) for a reason; its history up to there is kept, None if it has none."""

    def __init__(self, time: float, reason: str, history: Any) -> None:
        super().__init__(f"the simulation stopped at t = {time:.6g} s: {reason}")
        self.time = time
        self.reason = reason
        self.history = history


class CaseFileError(CrawlerError, ValueError):
    """A case file, or a file that it names, cannot be used; `errors` has a line each."""

    def __init__(self, path: Path, errors: list[str]) -> None:
        self.errors = [" ".join(error.split()) for error in errors]
        super().__init__("\n".join(f"{path}: {error}" for error in self.errors))
