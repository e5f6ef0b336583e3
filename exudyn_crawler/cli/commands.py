"""Commands on a case or a sweep: write, show and run it, and export it to editors and other programs.

Heavy modules are imported only when a command needs them, so that help appears at once.
"""

import json
import os
import re
import warnings
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import exudyn_crawler as crawler
from exudyn_crawler.cli import application, datasheets
from exudyn_crawler.run.folder.progress import noted_in, rule_of_thumb, times_line
from exudyn_crawler.views.tables import print_rows, print_table

if TYPE_CHECKING:
    from exudyn_crawler.case import Case
    from exudyn_crawler.case_run import CaseRun
    from exudyn_crawler.sweep.results import SweepRun

START = "kinematics"  # default study of `init`
SHOWN = 60  # greatest number of printed rows of the table of runs

app = typer.Typer(help="Simulator of the crawler tracks of mining shovels.", no_args_is_help=True)
command = partial(application.command, app)


def _show_versions(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version
        from platform import python_version

        lines = [f"{name} {version(name)}" for name in ("exudyn-crawler", "exudyn")]
        typer.echo(", ".join([*lines, f"Python {python_version()}"]))
        raise typer.Exit


@app.callback()
def common(
    _version: Annotated[
        bool, typer.Option("--version", help="show the versions", callback=_show_versions, is_eager=True)
    ] = False,
) -> None:
    """Accept the options before the name of a command."""


REFERENCE = re.compile(r'^((?:check|duty|folder)\s*=\s*)"([^"]+)"', re.MULTILINE)
"""Line of a study's file with another file, relative to the study's folder."""


def copy_study(file: Path, path: Path, overwrite: bool) -> None:
    """Copy a study's file to a path, and adapt its references to other files."""
    from exudyn_crawler.files import whole_file

    def moved(line: re.Match[str]) -> str:
        target = (file.parent / line[2]).resolve()
        if "/" not in line[2] and not target.exists():
            return line[0]
        return f'{line[1]}"{Path(os.path.relpath(target, path.resolve().parent)).as_posix()}"'

    with whole_file(path, overwrite) as temporary:
        text = REFERENCE.sub(moved, file.read_text(encoding="utf-8"))
        temporary.write_text(text, encoding="utf-8")


@command("exudyn-crawler init my_track --study closed")
def init(
    name: Annotated[str, typer.Argument(help="name of the case; the file is NAME.toml", metavar="NAME")],
    study: Annotated[
        str | None, typer.Option(help="study to start from, such as m113; default: the study called NAME")
    ] = None,
    machine: Annotated[
        str | None,
        typer.Option(help="machine of the library to start from, such as pc300lc; `machines` lists them"),
    ] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Write a case file with every value, its unit and its meaning, to be changed and run.

    Studies of duties and sweeps are copied as they are.
    """
    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if machine is not None:
        if study is not None:
            raise ValueError(
                "--study and --machine must not be given together: a case starts from one of them"
            )
        datasheets.copy_machine(machine, path, overwrite)
        typer.echo(
            f"{path}: edit it; show what follows: exudyn-crawler machine {path}; "
            f"run it: exudyn-crawler run {path}"
        )
        return
    start = study or path.stem
    known = application.study_names()
    if start not in known:
        from exudyn_crawler.machines.datasheet import library

        if start in library.machines():
            raise ValueError(
                f"{start} is a machine of the library, not a study: start from it with --machine {start}"
            )
        how = "" if study else f"; give {path.stem!r} one to start from, such as --study {START}"
        raise ValueError(f"study must be one of {', '.join(known)}, got {start!r}{how}")
    file = application.study_files().get(start)
    if file is not None and not application.is_case(file):
        copy_study(file, path, overwrite)
        typer.echo(f"{path}: edit it; its first lines say which command runs it")
        return
    case_file = application.study_case(start)
    written = crawler.write_case(case_file.with_({"name": path.stem}), path, overwrite, by_hand=True)
    typer.echo(f"{written}: edit it, then run it: exudyn-crawler run {written}")


@command("exudyn-crawler info soft_ground.toml")
def info(
    case: Annotated[
        str, typer.Argument(help="case file, or name of a study", metavar="[CASE.toml|STUDY]")
    ] = START,
    changes: application.Changes = None,
) -> None:
    """Show all values of a case, and where they differ from the nearest case of the papers."""
    from exudyn_crawler.case.parameters import checks
    from exudyn_crawler.machines.case_file import nearest_base, run_lines
    from exudyn_crawler.machines.datasheet.discrepancies import implausible_values
    from exudyn_crawler.machines.unscaled_values import unscaled_lines
    from exudyn_crawler.settings import fields

    studies = application.study_names(cases=True)
    of_the_base = list[str]()
    if case in studies:
        if changes:
            raise ValueError(f"--set must go with a case file, got the study {case!r}; init writes its file")
        case_file = application.study_case(case)
    elif Path(case).suffix or Path(case).exists():
        case_file = crawler.read_case(case, changes or ())
        of_the_base = unscaled_lines(case, changes or ())
    else:
        if case not in application.study_names():
            application.file_named(Path(case))
        raise ValueError(f"case must be a case file or a study of {studies}, got {case!r}")
    if case_file.datasheet is not None:
        datasheets.show_values(case_file, case)
        typer.echo("\n".join([*run_lines(case_file), times_line(rule_of_thumb(case_file))]))
        checks.warn_of(implausible_values(case_file))
        return
    base, of_base = nearest_base(case_file.case)
    rows = [(*row[:2], of_base.get(row.key, ""), *row[2:]) for row in fields.case_rows(case_file)]
    columns = ("key", "value", "in the base", "meaning")
    title = f"{case}: {sum(row[2] != '' for row in rows)} of {len(rows)} values differ from the case {base!r}"
    print_rows(columns, rows, title, keys=columns[:3], whole="in the file that init writes")
    typer.echo("\n".join([*of_the_base, *run_lines(case_file), times_line(rule_of_thumb(case_file))]))
    checks.warn_of(implausible_values(case_file))
    show_standing(case_file.case)
    if case_file.case.flexible is not None:
        from exudyn_crawler.model.reductions import reductions_line

        typer.echo(reductions_line())


@command("exudyn-crawler run soft_ground.toml --out results/softer --set terrain.spring_stiffness=1e7")
def run(
    case: Annotated[Path, application.file_argument(help="case file", metavar="CASE.toml")],
    out: application.OfName = None,
    reuse: Annotated[
        Path | None, typer.Option(help="folder of a run whose history replaces the simulation")
    ] = None,
    changes: application.Changes = None,
    page: Annotated[
        bool | None, typer.Option(help="write report.html or not; default: as in the case")
    ] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Run a case file into a folder of its own."""
    case_file = crawler.read_case(case, changes or ())
    if page is not None:
        case_file = case_file.with_({"outputs.page": page})
    out = out or application.RESULTS / case.stem
    from exudyn_crawler.machines.case_file import run_lines
    from exudyn_crawler.machines.unscaled_values import unscaled_lines
    from exudyn_crawler.run.folder.folder import refuse_other_results

    if not overwrite:
        refuse_other_results(out)
    typer.echo("\n".join([*unscaled_lines(case, changes or ()), *run_lines(case_file)]))
    # the first equilibrium on a computer compiles; the folder shows its progress
    with noted_in(out if out.is_dir() else None):
        show_standing(case_file.case)
    done = crawler.run_case(case_file, out, overwrite=overwrite, reuse=reuse, say=typer.echo)
    show_answers(done)
    if case_file.datasheet is not None:
        datasheets.show_machine(done.history)
    name = case_file.case.name
    duration = done.history.duration
    typer.echo(f"{name}: {duration:g} s; case, log, results and figures are in {out}")
    if case_file.outputs.page:
        typer.echo(f"{out / 'report.html'}: open it in a browser")
    else:
        typer.echo(f"everything on one page: exudyn-crawler report {out}")


def show_standing(case: "Case") -> None:
    """Print how a machine stands on its track, and warn of chains that are too taut or too slack."""
    if not case.gear.frame_parts:
        return
    from exudyn_crawler.case.parameters import checks
    from exudyn_crawler.run.solve.standing import standing

    rest = standing(case)
    assert rest is not None
    typer.echo("\n".join(rest.lines))
    checks.warn_of(rest.warnings)


def show_answers(run: "CaseRun") -> None:
    """Print the greatest values of a run, and location and verdict of its peak stress."""
    from exudyn_crawler.results.history.summary import key_results, start_ends
    from exudyn_crawler.results.stress.hot_spots import hot_spot_table, peak_spots

    stresses = run.stresses
    table = key_results(run.history, None if stresses is None else stresses.dataset)
    begin = start_ends(run.history)
    window = f", greatest forces and speeds after the start of {begin:.4g} s" if begin else ""
    print_table(table.rename(columns={"at": "at t in s"}), f"{run.history.case.name}: results{window}")
    if stresses is None:
        return
    for words, (shoe, spot) in peak_spots(stresses.hot_spots).items():
        top = hot_spot_table(spot, stresses.dataset).to_dict("records")[0]
        place = ", ".join(f"{top[f'{axis} in the shoe in m']:.3f}" for axis in "xyz")
        typer.echo(
            f"{words}: {top['von Mises in MPa']:.4g} MPa at t = {top['time in s']:g} s in shoe {shoe}, "
            f"{top['region']}, node {top['node']} at ({place}) m in the shoe; {top['verdict']}"
        )


@command("exudyn-crawler demo")
def demo(
    out: application.Out = application.RESULTS / "demo",
    prepare: bool = typer.Option(
        False, "--prepare", help="only compile the equations and reduce the shoe, as after the installation"
    ),
    overwrite: application.Overwrite = False,
) -> None:
    """Drive half a machine on a closed track with a flexible shoe, and make a page of results."""
    case_file = application.study_case("demo")
    if prepare:
        typer.echo("compiling the equations of motion and reducing a shoe, once: a minute or two")
        crawler.run_case(case_file.with_({"duration": 0.02}), progress=False)
        from exudyn_crawler.ground.cells.laws import bekker, rock

        for law in (bekker.BekkerSoil.lete_sand(), rock.RockFloor.hard_floor()):
            crawler.simulate(crawler.Case.translation().on_cells(law), 0.004, progress=False)
        return
    case = case_file.case
    typer.echo(
        f"half of a machine drives on a track of {case.track.shoe_count} shoes, one of them flexible, for "
        f"{case_file.duration:g} s: this takes about 20 s, the first time on a machine a minute or two more"
    )
    done = crawler.run_case(case_file, out, overwrite=overwrite, take_finished=True, say=typer.echo)
    show_answers(done)
    typer.echo(f"{out / 'report.html'}: open it in a browser")
    typer.echo("next, a machine of your own: exudyn-crawler init my_machine --study demo")


@command("exudyn-crawler schema")
def schema(
    out: Annotated[Path, typer.Argument(help="file to write", metavar="FILE")] = Path("case.schema.json"),
    overwrite: application.Overwrite = False,
) -> None:
    """Write the JSON schema of case files, with which editors complete and check them."""
    from exudyn_crawler.files import whole_file
    from exudyn_crawler.machines.case_files import case_schema

    with whole_file(out, overwrite) as temporary:
        temporary.write_text(json.dumps(case_schema(), indent=1) + "\n", encoding="utf-8")
    typer.echo(f"{out}: begin a case file in the same folder with the line '#:schema {out.name}'")


@command("exudyn-crawler fmu mine.toml")
def fmu(
    case: Annotated[
        Path, application.file_argument(help="case file of a machine on its track", metavar="CASE.toml")
    ],
    changes: application.Changes = None,
    out: Annotated[Path | None, typer.Option(help="file to write; default: CASE.fmu")] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Write a case as a unit of co-simulation (FMU, FMI 2.0) that other programs step."""
    if find_spec("pythonfmu") is None:
        raise ValueError(application.needs("units of co-simulation", ["pythonfmu"], "fmu"))
    case_file = crawler.read_case(case, changes or ())
    from exudyn_crawler.case.parameters import checks
    from exudyn_crawler.co_simulation import write_fmu
    from exudyn_crawler.machines.datasheet.discrepancies import implausible_values

    checks.warn_of(implausible_values(case_file))
    written = write_fmu(case_file, out or case.with_suffix(".fmu"), overwrite)
    typer.echo(
        f"{written}: takes speed, force and moment; gives motion of the frame, forces of pins and ground"
    )


def _sweeping(show: Callable[["SweepRun"], None], example: str, sampled: bool = False) -> None:
    """Register a command that runs a sweep and shows its results; `show` gives its name and description."""

    def run(
        file: Annotated[Path, application.file_argument(help="sweep file", metavar="SWEEP.toml")],
        dry_run: Annotated[
            bool,
            typer.Option(
                "--dry-run", help="show the runs, their number and their duration, without running them"
            ),
        ] = False,
        out: application.OfName = None,
        scheduler: Annotated[
            str | None,
            typer.Option(help="Dask scheduler: tcp://host:8786 or a scheduler file; default: this machine"),
        ] = None,
        workers: Annotated[
            int | None,
            typer.Option(help="number of processes on this machine; default: one for each core", min=1),
        ] = None,
        wait: Annotated[
            float | None,
            typer.Option(help="time to go on without a worker of the scheduler, s; default: no limit", min=0),
        ] = None,
        retry: Annotated[bool, typer.Option("--retry", help="run failed runs again")] = False,
        overwrite: application.Overwrite = False,
    ) -> None:
        application.require_sweeps()
        from exudyn_crawler.settings.fields import value_text
        from exudyn_crawler.sweep.scatter import DutyScatter, read_scatter

        plan = read_scatter(file)
        folder = out or application.RESULTS / file.stem
        if sampled and not plan.is_sampled:
            raise ValueError(
                f"{file}: design must draw a sample, such as 'latin_hypercube', got {plan.design!r}"
            )
        if scheduler is not None and workers is not None:
            raise ValueError("--workers must be left out with --scheduler, which has workers of its own")
        if scheduler is None and wait is not None:
            raise ValueError("--wait must be left out without --scheduler: this machine starts its workers")
        from exudyn_crawler.sweep import running

        how: dict[str, Any] = {"workers": workers, "retry": retry}
        if dry_run:
            table = plan.table()
            units = plan.units()
            top = table.head(SHOWN)
            more = f", the first {SHOWN}" if len(table) > SHOWN else ""
            read = {name: [value_text(cell, units[name]) for cell in top[name]] for name in plan.columns}
            print_table(top.assign(**read), f"{len(table)} runs{more}; {', '.join(plan.columns)}")
            if not isinstance(plan, DutyScatter):
                typer.echo(running.folder_state(plan, folder, **how))
            return
        how |= {"scheduler": scheduler, "wait": wait, "overwrite": overwrite}
        done = running.run_sweep(plan, folder, say=typer.echo, **how)
        without = done.check_answers()
        show(done)
        typer.echo(f"{done.folder}: open report.html in a browser; results.csv and .nc hold the answers")
        if without:
            warnings.warn(f"{without}; results.csv has each, --retry runs failed ones again", stacklevel=1)

    run.__name__ = show.__name__
    run.__doc__ = show.__doc__
    command(f"exudyn-crawler {example}")(run)


def sweep(run: "SweepRun") -> None:
    """Run a case with some of its values varied, on all cores or a cluster; the same command continues it."""
    from exudyn_crawler.sweep.results import best_and_worst, for_reading

    print_table(best_and_worst(run.sweep, for_reading(run.table)), "Best and worst runs")


def scatter(run: "SweepRun") -> None:
    """Run a case or evaluate a duty with values drawn at random: quantiles of answers, cracked shoes."""
    from exudyn_crawler.sweep.results import for_reading, scatter_tables

    tables = scatter_tables(run.sweep, for_reading(run.table))
    titles = {"quantiles": "Quantiles over the runs", "failures": "Shoes that crack"}
    for name in (title for title in titles if title in tables and len(tables[title])):
        print_table(tables[name], titles[name])


_sweeping(sweep, "sweep soils.toml --dry-run")
_sweeping(scatter, "scatter studies/duty_scatter.toml", sampled=True)
