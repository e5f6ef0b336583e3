"""Life of a duty, or check of a shoe, into a folder: machine hours, cycles to a crack, and files."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler import files
from exudyn_crawler.case import Case, FlexibleShoes
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.results.checks import cases, roller_path, solve
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe
from exudyn_crawler.results.history import History
from exudyn_crawler.results.life import duty_runs, life as results
from exudyn_crawler.results.life.duty import Duty, DutyRun, read_duty
from exudyn_crawler.results.life.duty_runs import NodeLife
from exudyn_crawler.run.folder import folder as folders, progress, record
from exudyn_crawler.views import style, tables
from exudyn_crawler.views.pages import life as pages, signed
from fem import interrupts, write_vtu

LIFE = "life.nc"
FIELDS = "life.vtu"
PAGE = "life.html"
TABLE = "shortest_lives.csv"
CAUSES = "causes.csv"
MATRICES = "rainflow_matrices.csv"
GROWTH = "damage_histories.csv"
SHOE = "life.png"
FILES = (LIFE, FIELDS, PAGE, TABLE, CAUSES, MATRICES, GROWTH, SHOE, signed.STORED)  # outputs of a duty
CHECK_PAGE = "check.html"
PICTURES = "pictures"
CHECK_TABLES = {"peaks.csv": "table", "moments.csv": "moments", "cycles.csv": "cycles", "hertz.csv": "hertz"}


def life(
    duty: Duty | str | Path,
    out: str | Path | None = None,
    *,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _text: None,
) -> results.LifeResults:
    """Compute the life of the shoes in machine hours over a duty, or over that of its file.

    Tables, fields and page go into the folder `out` if it is given; `say` gets a line on each activity.

    Raises before anything is counted: FileNotFoundError if there is no such file or no history of a run;
    FileExistsError if the folder has results and `overwrite` is false; ValueError if the duty, its runs or a
    spread beside one do not fit together, see `read_duty`, `results.life.duty_runs.used_runs` and
    `results.checks.solve.case_shapes`.
    """
    sources = [] if isinstance(duty, Duty) else [Path(duty)]
    duty = duty if isinstance(duty, Duty) else read_duty(duty)
    folder = _folder(duty, out, FILES, overwrite)
    histories = [path for run in duty.runs if (path := _history_of(run)).is_file()]
    # before the work: the files may change meanwhile
    checksums = signed.input_sums([*sources, *histories], duty)
    lives = stage_lives(duty, say)
    total = results.life_of_stages(duty, lives) if duty.stages else lives[0]
    if folder is not None:
        write_life(total, files.writable_folder(folder), overwrite)
        report = pages.signed_life(total, checksums, record.program_line())
        signed.store(
            report,
            folder,
            {pages.SHOE_CAPTION: SHOE},
            overwrite,
        )
    return total


def check_cases(
    check: cases.ShoeCheck | str | Path,
    out: str | Path | None = None,
    *,
    pictures: bool = True,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _text: None,
) -> solve.CheckResults:
    """Check a shoe, or that of a file, by static cases: peaks by region, section moments, cycles to a crack.

    Tables, page and, if requested, `pictures` of all cases go into the folder `out` if it is given; `say`
    gets a line on each activity.

    Raises FileNotFoundError if there is no such file; FileExistsError, before anything is solved, if the
    folder has results and `overwrite` is false; ValueError with the name of a case that is not in balance or
    has no support.
    """
    path = None
    if not isinstance(check, cases.ShoeCheck):
        path = Path(check)
        check = cases.read_check(path)
    folder = _folder(check, out, (*CHECK_TABLES, CHECK_PAGE), overwrite)
    try:
        solution = solve.solve_cases(check, CheckedShoe(check), say)
    except ValueError as error:
        if path is None or str(path) in str(error):
            raise
        raise ValueError(f"{path}: {error}") from error
    if folder is None:
        return solution
    files.writable_folder(folder)
    for name, table in CHECK_TABLES.items():
        tables.write_table(getattr(solution, table), folder / name, overwrite)
    pages.write_check_page(solution, folder / CHECK_PAGE, overwrite)
    if pictures:
        say(f"pictures of {len(solution.cases)} cases")
        drawn = files.writable_folder(folder / PICTURES)
        for number, case in enumerate(solution.cases):
            name = "".join(letter if letter.isalnum() or letter in "-." else "_" for letter in case.name)
            figure = pages.case_figure(solution, number)
            style.save_figure(figure, drawn / f"{number + 1:03d}_{name}.png", overwrite)
            # reference cycles keep the surfaces and images of a figure alive
            figure.clear()
    return solution


def _folder(
    inputs: Duty | cases.ShoeCheck, out: str | Path | None, names: Sequence[str], overwrite: bool
) -> Path | None:
    """Return the folder for results, if given; warn of inputs out of range, and refuse existing files."""
    checks.warn_of(checks.out_of_range(inputs))
    if out is None:
        return None
    for name in names:
        files.refuse_existing(Path(out) / name, overwrite)
    return Path(out)


def stage_lives(duty: Duty, say: Callable[[str], None] = lambda _text: None) -> list[results.LifeResults]:
    """Return the life over each stage of a duty, or over all of it; arguments and errors as in `life`."""
    inputs = [(stage, _histories(stage)) for stage in duty.by_stage()]
    lives = []
    with progress.heartbeat(f"life of {duty.name}"):
        for stage, histories in inputs:
            names = duty_runs.check_cases_of(stage)
            check = _check_of(stage)
            if histories:
                # cases are solved with the pins of the runs
                check = check.with_(pins=histories[0].case.part(FlexibleShoes).pins)
            shapes = solve.case_shapes(check, names, say) if names else None
            spreads = [_spread(run, history.case) for run, history in zip(stage.runs, histories, strict=True)]
            lives.append(results.life_of(stage, histories, say, spreads, shapes))
    return lives


def _check_of(duty: Duty) -> cases.ShoeCheck:
    """Return the check with the cases of a duty and its material."""
    is_file = Path(duty.check).suffix == ".toml"
    check = cases.read_check(duty.check) if is_file else cases.ShoeCheck(name=duty.check, mesh=duty.check)
    return check.with_(material=duty.material)


def roller_paths(lives: results.LifeResults) -> dict[str, pd.DataFrame]:
    """Return line contacts of treads in the last stage: of rolled runs by name, and of check cases."""
    duty = lives.duty.by_stage()[-1]
    histories = {used_run.run.name: used_run.basis.history for used_run in lives.runs}
    paths = {
        name: roller_path.roller_path(history, [duty.material])
        for name, history in histories.items()
        if history is not None and roller_path.has_treads(history)
    }
    if duty.cases:
        check = _check_of(duty)
        names = set(duty_runs.check_cases_of(duty))
        there = solve.all_cases(check, cases.ShoeOutline.of(lives.whole.mesh))
        pressed = [case for case in there if case.name in names]
        paths["check cases"] = roller_path.hertz_table(check, pressed)
    return {name: table for name, table in paths.items() if len(table)}


def _histories(duty: Duty) -> list[History]:
    """Return the histories of a duty's runs; runs in the same folder share one."""
    paths = {run.name: _history_of(run) for run in duty.runs}
    for name, path in paths.items():
        if not path.is_file():
            raise FileNotFoundError(f"run {name!r}: no history at {path}")
    loaded = {path: History.load(path) for path in {*paths.values()}}
    return [loaded[path] for path in paths.values()]


def _history_of(run: DutyRun) -> Path:
    path = Path(run.folder)
    return path / record.HISTORY if path.is_dir() else path


@interrupts.interrupts_wait()
def _spread(run: DutyRun, case: Case) -> xr.DataArray | None:
    """Return the relative spread of a run's peaks if it lies beside the history.

    Raises ValueError if the spread is of another case.
    """
    path = _history_of(run).parent / folders.SPREAD_FOLDER / folders.SPREAD
    if not path.is_file():
        return None
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        if dataset.attrs.get("case") != case.model_dump_json():
            raise ValueError(
                f"{path} comes from another case than the run beside it: run spread again, or remove it"
            )
        return results.relative_spread(dataset[["peak_von_mises", "peak_spread", "peak_choice"]].load())


def write_life(lives: results.LifeResults, folder: Path, overwrite: bool = False) -> None:
    """Write all results of a life into a folder: dataset, tables, fields and a page with the shoe in 3D."""
    files.write_netcdf(lives.dataset, folder / LIFE, overwrite)
    tables.write_table(results.in_words(lives.table), folder / TABLE, overwrite)
    tables.write_table(lives.causes().map(results.life_words).reset_index(), folder / CAUSES, overwrite)
    for name, made in ((MATRICES, NodeLife.rainflow_matrix), (GROWTH, NodeLife.damage_history)):
        of_nodes = {node: made(node_life) for node, node_life in lives.nodes.items()}
        joined = pd.concat(of_nodes, names=["node"]).reset_index(level="node")
        tables.write_table(joined, folder / name, overwrite)
    data = lives.dataset
    fields = {
        f"life in h, {100 * survival:g} % survive": data.life.sel(survival=survival)
        for survival in data.survival.values
    }
    fields |= {
        "life may be shorter or longer by the factor": data.life_factor,
        "uncertainty of the stress range": data.stress_error,
        "verdict": data.verdict,
        "damage an hour": data.damage_an_hour[-1],
    }
    fields |= {f"damage an hour, {part}": data.part_damage.sel(part=part) for part in data.part.values}
    at_last = data.place_damage.isel(survival=-1)
    fields |= {f"damage an hour, place {shoe}": at_last.sel(shoe=shoe) for shoe in data.shoe.values}
    with files.whole_file(folder / FIELDS, overwrite) as temporary:
        write_vtu(temporary, lives.whole.mesh, {name: np.asarray(field) for name, field in fields.items()})
    style.save_figure(pages.life_figure(lives), folder / SHOE, overwrite)
    pages.write_life_page(lives, folder / PAGE, overwrite, roller_paths(lives))
