"""Forces study (F-paper): contact, friction and joint forces, sinkage and terrain deformation."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from exudyn_crawler.comparison import compare_kinematics
from exudyn_crawler.contact_forces import contact_force, terrain_deformation
from exudyn_crawler.figures import save_figure
from exudyn_crawler.files import whole_file
from exudyn_crawler.force_comparison import compare_forces, turning_ratios
from exudyn_crawler.force_figures import crossing_figure, force_figures, turning_figures
from exudyn_crawler.history import History
from exudyn_crawler.parameters import Case
from exudyn_crawler.tables import write_table
from exudyn_crawler.workflows.runs import CASES, DURATION, matching_history, prepare, saved_run

ECCENTRICITY = 0.05
"""m, offset of the machine load along y that `lateral_effects` shows."""


def run_forces(
    cases: Sequence[str] = tuple(CASES),
    duration: float = DURATION,
    out: Path | None = None,
    reuse: Path | None = None,
    strict: bool = True,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = lambda _text: None,
) -> tuple[dict[str, History], pd.DataFrame]:
    """Get the cases' histories and compare their forces with the paper.

    Parameters
    ----------
    cases : sequence of str
        Of "translation" and "turning".
    duration : float
        s.
    out : Path, optional
        Folder for the forces, figures, `comparison.csv` and `turning_ratios.csv`; None writes nothing.
    reuse : Path, optional
        Folder whose histories take the place of runs where the parameters are the same.
    strict : bool
        Refuse histories in `reuse` that are missing or come from other parameters, instead of running
        these cases.
    overwrite : bool
        Replace files of an earlier study.
    say : callable
        Is told, in a line, which histories are reused and which are not.

    Returns
    -------
    histories : dict
        By case.
    comparison : pandas.DataFrame
        As of `force_comparison.compare_forces`.

    Raises
    ------
    ValueError
        For an unknown case, a bad duration or, if `strict`, a history from other parameters.
    FileExistsError
        Before anything runs, if results are there and `overwrite` is false.
    SimulationStopped
        If a run ends early; its history is saved.
    """
    prepare(cases, out, overwrite)
    histories: dict[str, History] = {}
    for name in cases:
        found = _reused(CASES[name](), duration, reuse, strict, say)
        histories[name] = found or saved_run(CASES[name](), duration, out, overwrite, progress)
    table = compare_forces(histories)
    if out is not None:
        _write(histories, table, out, overwrite)
    return histories, table


def _reused(
    case: Case, duration: float, reuse: Path | None, strict: bool, say: Callable[[str], None]
) -> History | None:
    if reuse is None:
        return None
    try:
        history = matching_history(reuse, case, duration)
    except (FileNotFoundError, ValueError) as error:
        if strict:
            raise
        if not isinstance(error, FileNotFoundError):
            say(f"{case.name}: running anew, since {error}")
        return None
    say(f"{case.name}: reusing the history in {reuse}, whose parameters are the same")
    return history


def _write(histories: dict[str, History], table: pd.DataFrame, out: Path, overwrite: bool) -> None:
    write_table(table, out / "comparison.csv", overwrite)
    for name, history in histories.items():
        forces = history.dataset.drop_dims("unit").assign(
            contact_force=contact_force(history), terrain_deformation=terrain_deformation(history)
        )
        with whole_file(out / f"{name}_forces.nc", overwrite) as temporary:
            forces.to_netcdf(temporary, engine="h5netcdf")
        figures = force_figures(history)
        figures["shoe 7 crossing"] = crossing_figure(history)
        for title, figure in figures.items():
            save_figure(figure, out / f"{name}_{title.replace(' ', '_')}.png", overwrite)
    if set(histories) == set(CASES):
        ratios = turning_ratios(histories["translation"], histories["turning"])
        write_table(ratios, out / "turning_ratios.csv", overwrite)
        for title, figure in turning_figures(histories).items():
            save_figure(figure, out / f"{title.replace(' ', '_')}.png", overwrite)


def lateral_effects(duration: float = DURATION, progress: bool | None = None) -> pd.DataFrame:
    """What makes a straight track move sideways: lateral rows of both papers for some causes.

    A track that is even about its middle, on units that only pitch, stays in its plane but for
    rounding. Units that roll under a track off their middle, and a machine load off the shoes' middle,
    push it sideways as the papers report.

    Returns
    -------
    pandas.DataFrame
        Columns quantity, statistic, unit, paper, then one a cause.
    """
    case = Case.translation()
    x, y, z = case.shoe.load_point
    eccentric = case.shoe.with_(load_point=(x, y + ECCENTRICITY, z))
    rolling = case.terrain.with_(tilt="roll")
    causes = {
        "even track": case,
        "units roll": case.with_(terrain=rolling),
        "load off the middle": case.with_(shoe=eccentric),
        "both": case.with_(terrain=rolling, shoe=eccentric),
    }
    columns = {}
    for cause, changed in causes.items():
        history = {"translation": saved_run(changed, duration, None, False, progress)}
        tables = pd.concat([compare_kinematics(history), compare_forces(history)])
        rows = tables[(tables["class"] == "lateral") & (tables["case"] == "translation")]
        columns[cause] = rows["computed"].to_numpy()
    table = rows[["quantity", "statistic", "unit", "paper"]].reset_index(drop=True)
    return table.assign(**columns)
