"""One case into one folder: simulate, recover stresses, then a list of writers.

The module is not named after its function, which would hide it behind the package's public name.
"""

from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from pathlib import Path

import xarray as xr

from exudyn_crawler.case import Case, CaseFile
from exudyn_crawler.case.parameters.outputs import Outputs
from exudyn_crawler.files import whole_file
from exudyn_crawler.model.flexible_shoes import check_shoe, whole_reduction
from exudyn_crawler.model.reductions import reductions_in
from exudyn_crawler.netcdf import write_netcdf_along
from exudyn_crawler.results.history.catalogue import select
from exudyn_crawler.results.history.files import blocks
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.history.summary import extremes
from exudyn_crawler.results.history.tables import highest_by_phase, hot_spot_table, load_table, region_table
from exudyn_crawler.results.stress.recovery import StressResults, recover_stresses
from exudyn_crawler.run.folder.folder import kept_run
from exudyn_crawler.run.folder.histories import HISTORY, matching_history
from exudyn_crawler.run.folder.into_folder import simulate_into
from exudyn_crawler.run.folder.keeper import Keeper, quiet
from exudyn_crawler.run.folder.progress import heartbeat
from exudyn_crawler.run.folder.record import earlier_record
from exudyn_crawler.run.folder.standing import Standing, standing
from exudyn_crawler.run.solve.simulation import simulate
from exudyn_crawler.views.animation import write_animation
from exudyn_crawler.views.curves import KINEMATICS, kinematic_figure, save_figure
from exudyn_crawler.views.force_figures import force_figures
from exudyn_crawler.views.ground_figures import ground_figure
from exudyn_crawler.views.paraview import write_paraview
from exudyn_crawler.views.roller_figures import roller_figures
from exudyn_crawler.views.stress_figures import stress_figures
from exudyn_crawler.views.stress_pictures import write_stress_pictures
from exudyn_crawler.views.tables import write_table
from fem import write_vtu


@dataclass(frozen=True)
class CaseRun:
    """A case that was run.

    Attributes
    ----------
    history : History
    stresses : StressResults or None
        Of the flexible shoes, if there are any.
    folder : Path or None
        Where all of it is kept, if it is.
    """

    history: History
    stresses: StressResults | None
    folder: Path | None

    def _repr_html_(self) -> str:
        """Folder, hot spots if there are any, and history, for notebooks."""
        where = "kept nowhere" if self.folder is None else f"kept in {escape(str(self.folder))}"
        spots = {} if self.stresses is None else self.stresses.hot_spots
        tables = [f"<p>Shoe {shoe}</p>" + table.to_html(index=False) for shoe, table in spots.items()]
        return "".join([f"<p>Run {where}</p>", *tables, self.history._repr_html_()])

    def recovered(self) -> StressResults:
        """Stresses of a run with flexible shoes.

        Raises
        ------
        ValueError
            If it has none.
        """
        if self.stresses is None:
            raise ValueError(f"case {self.history.case.name!r} must have flexible shoes to have stresses")
        return self.stresses


def run_case(
    case_file: CaseFile,
    out: str | Path | None = None,
    *,
    overwrite: bool = False,
    finished_since: str | None = None,
    reuse: str | Path | None = None,
    progress: bool | None = None,
    say: Callable[[str], None] = quiet,
    reductions: str | Path | None = None,
) -> CaseRun:
    """Simulate a case and leave its folder: case, record, log, history, and what its outputs ask for.

    A run that was stopped goes on when the same case is run into the same folder, whatever it was at, and
    gives what it would have given; with a longer duration a finished run goes on, too.

    Parameters
    ----------
    case_file : CaseFile
        Case, duration and outputs.
    out : path, optional
        Folder of the run; None writes nothing.
    overwrite : bool
        Replace an earlier run.
    finished_since : str, optional
        Take a run of the same case that has finished in `out` as it is, if it was begun since then (time as
        in records; "" is any), in place of refusing or overwriting it.
    reuse : path, optional
        Folder of an earlier run whose history takes the place of the simulation.
    progress : bool, optional
        Show a progress bar; None shows one on a terminal and a line every 10 s elsewhere.
    say : callable
        Is told, in a line, what is going on.
    reductions : path, optional
        Folder in which reductions of flexible shoes are kept; `model.reductions.reductions_folder` says which
        else.

    Raises
    ------
    FileNotFoundError, ValueError
        Before anything is written, if `reuse` holds no history or one of other parameters, or if the flexible
        shoes' mesh does not fit the track; or if checkpoints come from other parameters.
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError
        If the track finds no rest before t = 0.
    SimulationStopped
        If the run ends early; its history is kept.
    """
    case, outputs = case_file.case, case_file.outputs
    folder = None if out is None else Path(out)
    reused = None if reuse is None else matching_history(Path(reuse), case_file)
    if case.flexible is not None:
        check_shoe(case)  # refuses a mesh that does not fit while nothing is written yet
    if folder is not None and finished_since is not None and _finished(folder, case_file, finished_since):
        say(f"{case.name}: finished already, in {folder}")
        with reductions_in(reductions):
            return _finished_run(case_file, folder, Keeper(say))
    with reductions_in(reductions), kept_run(folder, case_file, overwrite, say) as keeper:
        if case.flexible is not None:
            _reduce_shoe(case, keeper)
        if reused is None:
            history = _simulated(case_file, folder, progress, keeper)
        else:
            keeper.say(f"{case.name}: reusing the history in {reuse}, whose parameters are the same")
            history = reused
            if folder is not None:
                history.save(folder / HISTORY, keeper.replaces)
        stresses = _stresses(history, outputs, keeper)
        if folder is not None:
            with keeper.timed("tables and figures"), heartbeat(f"{case.name}: tables and figures"):
                write_outputs(history, stresses, folder, outputs, keeper.replaces)
    return CaseRun(history, stresses, folder)


def _finished(folder: Path, case_file: CaseFile, since: str) -> bool:
    """Whether a run of a case that was begun since a time has finished in a folder."""
    begun = str(earlier_record(folder).get("begun", ""))
    return begun >= since and standing(folder, case_file) is Standing.FINISHED


def _finished_run(case_file: CaseFile, folder: Path, keeper: Keeper) -> CaseRun:
    """Run that has finished in a folder, which stays as it is."""
    history = matching_history(folder, case_file)
    return CaseRun(history, _stresses(history, case_file.outputs, keeper), folder)


def _reduce_shoe(case: Case, keeper: Keeper) -> None:
    """Reduce the flexible shoe, which is remembered, and say so if it was on disk."""
    with keeper.timed("reduce the flexible shoe"):
        kept = whole_reduction(case)
    if kept.found:
        keeper.say(f"{case.name}: the reduced shoe is taken from {kept.path}")


def _stresses(history: History, outputs: Outputs, keeper: Keeper) -> StressResults | None:
    """Stresses of the flexible shoes, if there are any."""
    case = history.case
    if case.flexible is None:
        return None
    with keeper.timed("recover stresses"), heartbeat(f"{case.name}: recovering stresses"):
        return recover_stresses(history, outputs.picture_times)


def _simulated(case_file: CaseFile, folder: Path | None, progress: bool | None, keeper: Keeper) -> History:
    """Simulate a case, or what is missing of it in its folder."""
    if folder is not None:
        return simulate_into(folder, case_file, progress, keeper)
    with keeper.timed("simulate"):
        return simulate(case_file.case, case_file.duration, progress)


def write_forces(history: History, folder: Path, outputs: Outputs, overwrite: bool) -> None:
    """What derives from the forces of the history, which has them themselves."""
    if not outputs.forces:
        return
    names = select(files="forces")
    # those of pairs may be larger than memory, and change nothing from one time to another
    whole = {name: history.quantity(name) for name, one in names.items() if one.per != "pair"}

    def chunk(part: xr.Dataset) -> xr.Dataset:
        own = History(history.case, part)
        values = {name: own.quantity(name) for name in names if name not in whole}
        values |= {name: one.sel(time=part.time) for name, one in whole.items()}
        stored = {name: values[name].astype(one.dtype, keep_attrs=True) for name, one in names.items()}
        return xr.Dataset(stored, attrs=part.attrs)

    chunks = (chunk(part) for part in blocks(history.dataset))
    write_netcdf_along("time", history.time.size, chunks, folder / "forces.nc", overwrite)


def write_extremes(history: History, folder: Path, outputs: Outputs, overwrite: bool) -> None:
    """Least and greatest value of every variable."""
    if outputs.tables:
        write_table(extremes(history), folder / "extremes.csv", overwrite)


def write_loads(history: History, folder: Path, outputs: Outputs, overwrite: bool) -> None:
    """Loads on the shoes at the ends of the phases, as far as the run goes."""
    if outputs.tables:
        write_table(load_table(history), folder / "loads.csv", overwrite)


def write_motion(history: History, folder: Path, outputs: Outputs, overwrite: bool) -> None:
    """Every kinematic quantity of some shoes, a figure each."""
    shoes = outputs.drawn_shoes(history.case.track.shoe_count)
    for quantity in KINEMATICS if outputs.figures else ():
        figure = kinematic_figure(history, quantity, shoes)
        save_figure(figure, _figure_file(folder, quantity, outputs), overwrite)


def write_contact_and_joints(history: History, folder: Path, outputs: Outputs, overwrite: bool) -> None:
    """Contact and joint forces of the same shoes and the links behind them, a figure each."""
    if not outputs.figures:
        return
    count = history.case.track.shoe_count
    shoes = outputs.drawn_shoes(count)
    joints = sorted({min(shoe, count - 1) for shoe in shoes})
    for title, figure in force_figures(history, shoes, joints).items():
        save_figure(figure, _figure_file(folder, title, outputs), overwrite)


def write_rollers(history: History, folder: Path, outputs: Outputs, overwrite: bool) -> None:
    """Forces of the rollers, of them on the flexible shoes or else on the drawn ones, and the side frame."""
    case = history.case
    if not outputs.figures or case.propel == "dragged":
        return
    shoes = outputs.drawn_shoes(case.track.shoe_count) if case.flexible is None else case.flexible.shoes
    for title, figure in roller_figures(history, shoes).items():
        save_figure(figure, _figure_file(folder, title, outputs), overwrite)


def write_ground(history: History, folder: Path, outputs: Outputs, overwrite: bool) -> None:
    """The track on uneven ground at the end of the run, and what the ground carries."""
    terrain = history.case.terrain
    if outputs.figures and not (terrain.heights is None and terrain.profile is None):
        figure = ground_figure(history, history.duration)
        save_figure(figure, _figure_file(folder, "ground", outputs), overwrite)


def write_film(history: History, folder: Path, outputs: Outputs, overwrite: bool) -> None:
    """The track on its deforming terrain."""
    if outputs.animation:
        write_animation(history, folder / "track.mp4", overwrite)


def write_stresses(
    history: History, stresses: StressResults, folder: Path, outputs: Outputs, overwrite: bool
) -> None:
    """Stresses over time, at all nodes and at chosen times."""
    stresses.save(folder / "stress.nc", overwrite)


def write_hot_spots(
    history: History, stresses: StressResults, folder: Path, outputs: Outputs, overwrite: bool
) -> None:
    """Highest stresses of every shoe by phase, by region and over the run, and where they are."""
    if not outputs.tables:
        return
    table = highest_by_phase(history, stresses.dataset)
    write_table(table, folder / "highest_stresses.csv", overwrite)
    by_region = region_table(stresses.by_region, stresses.dataset)
    write_table(by_region, folder / "highest_by_region.csv", overwrite)
    for shoe, hot_spots in stresses.hot_spots.items():
        write_table(
            hot_spot_table(hot_spots, stresses.dataset), folder / f"hot_spots_shoe_{shoe}.csv", overwrite
        )


def write_flexible_shoes(
    history: History, stresses: StressResults, folder: Path, outputs: Outputs, overwrite: bool
) -> None:
    """Motion, contact, joint forces, modal coordinates and stress of the flexible shoes, a figure each."""
    for title, figure in stress_figures(history, stresses).items() if outputs.figures else ():
        save_figure(figure, _figure_file(folder, f"flexible {title}", outputs), overwrite)


def write_fields(
    history: History, stresses: StressResults, folder: Path, outputs: Outputs, overwrite: bool
) -> None:
    """Greatest von Mises stress of every node, when it occurs, its range and trust, for ParaView."""
    for shoe in stresses.dataset.shoe.values if outputs.paraview else ():
        own = stresses.dataset.sel(shoe=shoe)
        fields = {
            "greatest von Mises": own.peak_von_mises.values,
            "time of the greatest": own.peak_time.values,
            "range of von Mises": (own.peak_von_mises - own.least_von_mises).values,
            "error of the mesh over the stress": own.peak_mesh_error.values,
            "verdict": own.peak_verdict.values,
        }
        with whole_file(folder / f"fields_shoe_{shoe}.vtu", overwrite) as temporary:
            write_vtu(temporary, stresses.whole.mesh, fields)


def write_pictures(
    history: History, stresses: StressResults, folder: Path, outputs: Outputs, overwrite: bool
) -> None:
    """Pictures of stressed shoes at the chosen times."""
    if outputs.pictures:
        write_stress_pictures(stresses.dataset, history, folder, overwrite)


def write_series(
    history: History, stresses: StressResults, folder: Path, outputs: Outputs, overwrite: bool
) -> None:
    """Whole track with its stressed shoes at the chosen times, for ParaView."""
    if outputs.paraview:
        write_paraview(stresses.dataset, history, folder, overwrite)


STRESS_WRITERS: tuple[Callable[[History, StressResults, Path, Outputs, bool], None], ...] = (
    write_stresses,
    write_hot_spots,
    write_flexible_shoes,
    write_fields,
    write_pictures,
    write_series,
)
"""What is written of flexible shoes, in this order."""
WRITERS: tuple[Callable[[History, Path, Outputs, bool], None], ...] = (
    write_forces,
    write_extremes,
    write_loads,
    write_ground,
    write_film,
)
"""What is written of any run, in this order."""
CURVE_WRITERS = (write_motion, write_contact_and_joints, write_rollers)
"""Figures over time of any run."""
MOST_DRAWN = 5 * 10**8
"""Bytes of a history whose curves are drawn as they are: 70 s of 13 rigid shoes, stored every 2 ms."""


def write_outputs(
    history: History, stresses: StressResults | None, folder: Path, outputs: Outputs, overwrite: bool = False
) -> None:
    """Write what derives from a history and its stresses, as far as the outputs ask for it."""
    if stresses is not None:
        for write_stress in STRESS_WRITERS:
            write_stress(history, stresses, folder, outputs, overwrite)
    for write in WRITERS:
        write(history, folder, outputs, overwrite)
    # curves of a long run would not fit into memory, and no figure shows them at every step
    drawn = history.every(-(-history.dataset.nbytes // MOST_DRAWN))
    for write_curves in CURVE_WRITERS:
        write_curves(drawn, folder, outputs, overwrite)


def _figure_file(folder: Path, title: str, outputs: Outputs) -> Path:
    return folder / f"{title.replace(' ', '_')}.{outputs.figure_format}"
