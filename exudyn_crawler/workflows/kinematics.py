"""Kinematics study (K-chapter and K-paper): motion of the shoes, straight and turning."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from exudyn_crawler.comparison import compare_kinematics
from exudyn_crawler.figures import KINEMATICS, comparison_figure, kinematic_figure, save_figure
from exudyn_crawler.history import History
from exudyn_crawler.tables import write_table
from exudyn_crawler.workflows.runs import CASES, DURATION, prepare, saved_run

COMPARED_SHOE = 10
"""Shoe that the K-chapter draws turning against translation."""


def run_kinematics(
    cases: Sequence[str] = tuple(CASES),
    duration: float = DURATION,
    out: Path | None = None,
    overwrite: bool = False,
    progress: bool | None = None,
) -> tuple[dict[str, History], pd.DataFrame]:
    """Run the cases and compare them with the papers.

    Parameters
    ----------
    cases : sequence of str
        Of "translation" and "turning".
    duration : float
        s.
    out : Path, optional
        Folder for the histories, figures and `comparison.csv`; None writes nothing.
    overwrite : bool
        Replace files of an earlier run.

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
    FileExistsError
        Before anything runs, if results are there and `overwrite` is false.
    SimulationStopped
        If a run ends early; its history is saved beside the others.
    """
    prepare(cases, out, overwrite)
    histories: dict[str, History] = {}
    for name in cases:
        histories[name] = saved_run(CASES[name](), duration, out, overwrite, progress)
    table = compare_kinematics(histories)
    if out is not None:
        write_table(table, out / "comparison.csv", overwrite)
        for name, history in histories.items():
            for quantity in KINEMATICS:
                figure = kinematic_figure(history, quantity)
                file = f"{name}_{quantity.replace(' ', '_')}.png"
                save_figure(figure, out / file, overwrite)
        if len(histories) > 1:
            for quantity in KINEMATICS:
                figure = comparison_figure(histories, quantity, COMPARED_SHOE)
                file = f"shoe_{COMPARED_SHOE}_{quantity.replace(' ', '_')}.png"
                save_figure(figure, out / file, overwrite)
    return histories, table
