"""Forces study (F-paper): contact, friction and joint forces, sinkage and terrain deformation."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from exudyn_crawler.case import Case
from exudyn_crawler.files import write_netcdf
from exudyn_crawler.results.contacts import contact_force, terrain_deformation
from exudyn_crawler.results.history import History
from exudyn_crawler.run.folder import kept_run
from exudyn_crawler.runs import CASES, matching_history, saved_run, study_cases
from exudyn_crawler.views.curves import SHOES, save_figure
from exudyn_crawler.views.force_figures import crossing_figure, force_figures, turning_figures
from exudyn_crawler.views.tables import write_table
from studies.comparison import compare_kinematics
from studies.defaults import DURATION
from studies.force_comparison import JOINTS, compare_forces, turning_ratios

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
        Folder for the cases, forces, figures, `comparison.csv` and `turning_ratios.csv`; None writes nothing.
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
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    SimulationStopped
        If a run ends early; its history is saved.
    """
    files = study_cases(cases, duration)
    reused = {name: _reused(one.case, duration, reuse, strict, say) for name, one in files.items()}
    histories: dict[str, History] = {}
    with kept_run(out, files, overwrite, say) as keeper:
        for name, one in files.items():
            if found := reused[name]:
                keeper.say(f"{name}: reusing the history in {reuse}, whose parameters are the same")
                histories[name] = found
                continue
            with keeper.timed(f"simulate {name}"):
                histories[name] = saved_run(one.case, duration, out, overwrite, progress)
        table = compare_forces(histories)
        if out is not None:
            with keeper.timed("tables and figures"):
                _write(histories, table, out, overwrite)
    return histories, table


def _reused(
    case: Case, duration: float, reuse: Path | None, strict: bool, say: Callable[[str], None]
) -> History | None:
    if reuse is None:
        return None
    try:
        return matching_history(reuse, case, duration)
    except (FileNotFoundError, ValueError) as error:
        if strict:
            raise
        if not isinstance(error, FileNotFoundError):
            say(f"{case.name}: running anew, since {error}")
        return None


def _write(histories: dict[str, History], table: pd.DataFrame, out: Path, overwrite: bool) -> None:
    write_table(table, out / "comparison.csv", overwrite)
    for name, history in histories.items():
        write_forces(history, out / f"{name}_forces.nc", overwrite)
        write_force_figures(history, out, f"{name}_", overwrite)
        save_figure(crossing_figure(history), out / f"{name}_shoe_7_crossing.png", overwrite)
    if set(histories) == set(CASES):
        ratios = turning_ratios(histories["translation"], histories["turning"])
        write_table(ratios, out / "turning_ratios.csv", overwrite)
        for title, figure in turning_figures(histories).items():
            save_figure(figure, out / f"{title.replace(' ', '_')}.png", overwrite)


def write_forces(history: History, path: Path, overwrite: bool = False) -> Path:
    """Write contact and joint forces with what derives from them, without the units of the terrain."""
    forces = history.dataset.drop_dims("unit").assign(
        contact_force=contact_force(history), terrain_deformation=terrain_deformation(history)
    )
    return write_netcdf(forces, path, overwrite)


def write_force_figures(
    history: History,
    out: Path,
    prefix: str = "",
    overwrite: bool = False,
    shoes: Sequence[int] = SHOES,
    joints: Sequence[int] = JOINTS,
    suffix: str = "png",
) -> None:
    """Draw contact, joint forces and deformation of some shoes and links, a file each."""
    for title, figure in force_figures(history, shoes, joints).items():
        save_figure(figure, out / f"{prefix}{title.replace(' ', '_')}.{suffix}", overwrite)


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


if __name__ == "__main__":
    from exudyn_crawler.cli import forces, run_script

    run_script(forces)
