"""Assessment of a machine into a folder: tables, drawings and a page, with forces of given runs."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from exudyn_crawler import files
from exudyn_crawler.assessment import run_forces
from exudyn_crawler.assessment.assessment import Assessment, assessment_of
from exudyn_crawler.assessment.settings import AssessmentSettings, read_assessment
from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.machines.datasheet.ledger import ledger_of, stated_ledger
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.origins import Ledger
from exudyn_crawler.results.history import History
from exudyn_crawler.run.folder import record
from exudyn_crawler.settings import fields
from exudyn_crawler.views import assessment as drawings, style, tables
from exudyn_crawler.views.pages import assessment as pages, signed

ASSESSED_PAGE = "assessment.html"
ASSESSED_TABLES = {
    "items.csv": "items",
    "inputs.csv": "inputs",
    "load_cases.csv": "cases",
    "over_slew.csv": "over_slew",
    "tipping.csv": "tipping",
    "plate.csv": "plate",
    "clauses.csv": "clauses",
}
COMPARED = "run.csv"
LEAST_PAYLOAD = 1e-3  # fraction of the machine's mass, below that of any real payload; chosen here


def assess(
    machine: Case | str | Path,
    out: str | Path | None = None,
    *,
    settings: AssessmentSettings | None = None,
    run: str | Path | Iterable[str | Path] = (),
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _text: None,
) -> Assessment:
    """Assess a machine by formulas: ground pressure, tipping, travel, load cases, utilisation of its parts.

    Parameters
    ----------
    machine : Case, str or Path
        A machine on two closed tracks, its file, or the file of an assessment that names one.
    out : str or Path, optional
        Folder for tables, drawings and a page.
    settings : AssessmentSettings, optional
        Values that a case lacks: work, ground, drive, pins. Default: those of the file, or the defaults.
    run : str, Path or several of them
        Folder of a run of the machine, or its history: its forces replace those of the formulas in the load
        case of the run. "LOAD CASE=RUN" names the load case that a run stands for.
    overwrite : bool
        Replace earlier results in the folder.
    say : callable
        Function that gets a line on each activity.

    Raises
    ------
    FileNotFoundError, FileExistsError
        If there is no such file or run; if the folder has results, before anything is computed.
    ValueError
        If the machine does not stand on two closed tracks, a file has values that are not allowed, or a run
        fits no load case.
    """
    folder = None if out is None else Path(out)
    if folder is not None:
        for name in (*ASSESSED_TABLES, COMPARED, ASSESSED_PAGE, signed.STORED):
            files.refuse_existing(folder / name, overwrite)
    given: tuple[str, ...] = ()
    origins: Ledger | None = None
    sheet: Datasheet | None = None
    if isinstance(machine, Case):
        case = machine
        settings = settings or AssessmentSettings(name=case.name)
    else:
        asked = read_assessment(machine)
        case, sheet = asked.machine.case, asked.machine.datasheet
        given = asked.given if settings is None else ()
        origins = ledger_of(asked.machine) or stated_ledger(case, asked.stated)
        settings = settings or asked.settings
    checks.warn_of([*checks.out_of_range(settings), *_odd_payload(case, settings)])
    named_runs = [_history_of(named) for named in ([run] if isinstance(run, str | Path) else run)]
    sources = [*([] if isinstance(machine, Case) else [machine]), *(path for _, path, _ in named_runs)]
    # before the work: the files may change meanwhile
    checksums = signed.input_sums(sources, case, settings)
    runs = [
        (load_case, run_forces.forces_of_run(History.load(path), name))
        for load_case, path, name in named_runs
    ]
    found = assessment_of(case, settings, given=given, origins=origins, sheet=sheet, runs=runs, say=say)
    if folder is not None:
        write_assessment(found, files.writable_folder(folder), overwrite)
        of_machine = case.gear.words(case)
        report = pages.signed_assessment(found, of_machine, checksums, record.program_line())
        drawn = {name.capitalize(): drawings.file_name(name) for name in pages.SIGNED_FIGURES}
        signed.store(report, folder, drawn, overwrite)
    return found


def _odd_payload(case: Case, settings: AssessmentSettings) -> Iterator[str]:
    """Yield a warning of a payload that is negligible beside the machine."""
    payload = settings.work.payload or 0.0
    mass = case.gear.whole_mass(case)
    if 0.0 < payload < LEAST_PAYLOAD * mass:
        whole = fields.quantity_text(mass, "kg")
        share = f"{payload:g} kg is {payload / mass:.2g} of the machine's {whole}"
        yield f"work.payload: {share}; is it in t? The unit is kg; a text may have another, such as '90 t'"


def _history_of(named: str | Path) -> tuple[str | None, Path, str]:
    """Return the load case, if it is given, the history and the name of a run's folder or history."""
    run = Path(named)
    load_case = None
    if not run.exists() and "=" in str(named):
        load_case, _, place = str(named).partition("=")
        run = Path(place)
    path = run / record.HISTORY if run.is_dir() else run
    if not path.is_file():
        raise FileNotFoundError(f"no history of a run at {path}")
    return load_case, path, run.name


def write_assessment(found: Assessment, folder: Path, overwrite: bool = False) -> None:
    """Write all tables, drawings and the page of an assessment into a folder."""
    for name, table in ASSESSED_TABLES.items():
        tables.write_table(getattr(found, table), folder / name, overwrite)
    if found.compared is not None:
        tables.write_table(found.compared, folder / COMPARED, overwrite)
    drawn = drawings.assessment_figures(found)
    for name, figure in drawn.items():
        style.save_figure(figure, folder / drawings.file_name(name), overwrite)
    pages.write_assessment_page(found, drawn, folder / ASSESSED_PAGE, overwrite)
