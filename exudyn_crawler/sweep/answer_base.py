"""What every kind of answer of a sweep has."""

from typing import Literal

from pydantic import Field

from exudyn_crawler.case import CaseFile
from exudyn_crawler.case.parameters.base import Name, Parameters


class AnyAnswer(Parameters):
    """What all answers have.

    A kind of answer adds a field `model` with its name, `label`, `unit` and `meaning` of its column,
    ``check(case_file)``, which refuses what runs of a case cannot give, and ``of_run(run)``, its number.
    """

    name: Name | None = Field(default=None, description="column of the table; made of the rest, if not given")
    better: Literal["less", "more"] = Field(
        default="less", description="which runs are the best ones: those with less or with more of it"
    )


def check_within(label: str, case_file: CaseFile, **times: float | None) -> None:
    """Refuse times that lie beyond a run.

    Raises
    ------
    ValueError
        Naming the answer and the time.
    """
    for name, time in times.items():
        if time is not None and time > case_file.duration:
            raise ValueError(
                f"{label}: {name} must lie within the run of {case_file.duration:g} s, got {time:g} s"
            )
