"""Kinematics study (K-chapter and K-paper): motion of the shoes, straight and turning."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from exudyn_crawler.results.history import History
from exudyn_crawler.run.folder import Keeper, kept_run
from exudyn_crawler.runs import CASES, saved_run, study_cases
from exudyn_crawler.views.curves import KINEMATICS, SHOES, comparison_figure, kinematic_figure, save_figure
from exudyn_crawler.views.tables import write_table
from studies.comparison import compare_kinematics
from studies.defaults import DURATION

COMPARED_SHOE = 10
"""Shoe that the K-chapter draws turning against translation."""


def run_kinematics(
    cases: Sequence[str] = tuple(CASES),
    duration: float = DURATION,
    out: Path | None = None,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = lambda _text: None,
) -> tuple[dict[str, History], pd.DataFrame]:
    """Run the cases and compare them with the papers.

    Parameters
    ----------
    cases : sequence of str
        Of "translation" and "turning".
    duration : float
        s.
    out : Path, optional
        Folder for the cases, histories, figures and `comparison.csv`; None writes nothing.
    overwrite : bool
        Replace files of an earlier run.
    say : callable
        Is told, in a line, what is going on.

    Returns
    -------
    histories : dict
        By case.
    comparison : pandas.DataFrame
        As of `comparison.compare_kinematics`.

    Raises
    ------
    ValueError
        For an unknown case or a bad duration.
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    SimulationStopped
        If a run ends early; its history is saved beside the others.
    """
    files = study_cases(cases, duration)
    histories: dict[str, History] = {}
    with kept_run(out, files, overwrite, say) as keeper:
        for name, one in files.items():
            with keeper.timed(f"simulate {name}"):
                histories[name] = saved_run(one.case, duration, out, overwrite, progress)
        table = compare_kinematics(histories)
        if out is not None:
            _write(histories, table, out, overwrite, keeper)
    return histories, table


def _write(
    histories: dict[str, History], table: pd.DataFrame, out: Path, overwrite: bool, keeper: Keeper
) -> None:
    with keeper.timed("tables and figures"):
        write_table(table, out / "comparison.csv", overwrite)
        for name, history in histories.items():
            write_kinematic_figures(history, out, f"{name}_", overwrite)
        if len(histories) > 1:
            for quantity in KINEMATICS:
                figure = comparison_figure(histories, quantity, COMPARED_SHOE)
                file = f"shoe_{COMPARED_SHOE}_{quantity.replace(' ', '_')}.png"
                save_figure(figure, out / file, overwrite)


def write_kinematic_figures(
    history: History,
    out: Path,
    prefix: str = "",
    overwrite: bool = False,
    shoes: Sequence[int] = SHOES,
    suffix: str = "png",
) -> None:
    """Draw every kinematic quantity of some shoes, a file each."""
    for quantity in KINEMATICS:
        figure = kinematic_figure(history, quantity, shoes)
        save_figure(figure, out / f"{prefix}{quantity.replace(' ', '_')}.{suffix}", overwrite)


if __name__ == "__main__":
    from exudyn_crawler.cli import kinematics, run_script

    run_script(kinematics)
