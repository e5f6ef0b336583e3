"""A finished run repeated from starts that differ by rounding and with the other law of contact."""

from collections.abc import Callable
from pathlib import Path

import xarray as xr

from exudyn_crawler.case import Case, CaseFile, PairContact, read_case
from exudyn_crawler.case.files.case_file import Outputs
from exudyn_crawler.case_run import run_case
from exudyn_crawler.files import refuse_existing, writable_folder, write_netcdf
from exudyn_crawler.results.stress.recovery import recover_stresses
from exudyn_crawler.results.stress.spread import Spread, spread_of
from exudyn_crawler.run.folder.folder import SPREAD, SPREAD_FOLDER, held_of, matching_history
from exudyn_crawler.run.folder.progress import heartbeat
from exudyn_crawler.run.folder.record import CASE, Holds, quiet
from exudyn_crawler.views.tables import write_table
from fem.interrupts import interrupts_wait

TABLE = "spread.csv"
NUDGE = 1e-9
"""m by which the ground lies further along the track from start to start."""
BARE = Outputs(
    figures=False, pictures=False, paraview=False, tables=False, forces=False, picture_times=(0.0,)
)


def spread(
    run: str | Path,
    starts: int = 3,
    *,
    laws: bool = True,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = quiet,
) -> Spread:
    """Repeat a finished run into a folder "spread" in its own, and judge its stresses by what changes.

    From start to start the ground lies 1e-9 m further along the track. Repeated runs are folders of their
    own; those that are there are taken, and one that was stopped goes on. What is found goes into the
    verdicts on the lives of duties that the run is in.

    Parameters
    ----------
    run : path
        Folder of a run with flexible shoes, with its case and history.
    starts : int
        Number of starts, its own among them.
    laws : bool
        Repeat it, too, with the contact law of a pair given whole to each, or shared by area, whichever it
        has not. Under a side frame shoes share by area alone, and spheres have no other law.
    overwrite : bool
        Replace what earlier ones have found, and repeated runs of other cases.
    progress, say
        As of `run_case`.

    Raises
    ------
    FileNotFoundError, ValueError
        Before anything runs, if the folder has no case or no finished history of it, there are no flexible
        shoes, or nothing is to be repeated.
    FileExistsError
        Before anything runs, if results are there and `overwrite` is false.
    EquilibriumError, SimulationStopped
        As of `run_case`.
    """
    folder = Path(run)
    case_file = read_case(folder / CASE)
    history = matching_history(folder, case_file)
    case = case_file.case
    if case.flexible is None:
        raise ValueError(f"the run in {folder} must have flexible shoes to have stresses")
    other_laws = laws_beside(case) if laws else {}
    if starts < 1 or (starts == 1 and not other_laws):
        raise ValueError(f"starts must be at least {2 - bool(other_laws)}, got {starts}")
    for name in (SPREAD, TABLE):
        refuse_existing(folder / SPREAD_FOLDER / name, overwrite)
    out = writable_folder(folder / SPREAD_FOLDER)

    def peaks(cases: dict[str, Case]) -> dict[str, xr.DataArray]:
        found = {}
        for name, one in cases.items():
            own = CaseFile(case=one, duration=case_file.duration, outputs=BARE)
            found[name] = _peaks(own, out / name.replace(" ", "_"), overwrite, progress, say)
        return found

    from_starts = peaks({f"start {k + 1}": nudged(case, k) for k in range(1, starts)})
    with_laws = peaks(other_laws)
    with heartbeat(f"{case.name}: recovering stresses"):
        found = spread_of(recover_stresses(history), from_starts, with_laws)
    write_netcdf(found.dataset.assign_attrs(case=case.model_dump_json()), out / SPREAD, overwrite)
    write_table(found.by_shoe(), out / TABLE, overwrite)
    for shoe, table in found.hot_spot_tables().items():
        write_table(table, out / f"hot_spots_shoe_{shoe}.csv", overwrite)
    return found


def nudged(case: Case, times: int) -> Case:
    """Same case on ground that lies some nudges further along the track."""
    x, y = case.terrain.origin
    return case.with_(terrain=case.terrain.with_(origin=(x + times * NUDGE, y)))


def laws_beside(case: Case) -> dict[str, Case]:
    """Same case with laws of contact that could stand for the same ground, by name."""
    contact = case.contact
    if not isinstance(contact, PairContact) or case.undercarriage is not None:
        return {}
    other = "area" if contact.sharing == "pair" else "pair"
    return {f"law by {other}": case.with_(contact=contact.with_(sharing=other))}


def _peaks(
    case_file: CaseFile, out: Path, overwrite: bool, progress: bool | None, say: Callable[[str], None]
) -> xr.DataArray:
    """Greatest von Mises stress of every node in a run, which is made where it has not finished."""
    if held_of(out, case_file) is not Holds.FINISHED:
        say(f"{case_file.case.name}: {out.name.replace('_', ' ')}")
        run_case(case_file, out, overwrite=overwrite and out.exists(), progress=progress, say=say)
    with interrupts_wait(), xr.open_dataset(out / "stress.nc", engine="h5netcdf") as stress:
        return stress.peak_von_mises.load()
