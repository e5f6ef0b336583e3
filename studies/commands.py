"""Commands of the studies.

Heavy modules are imported in the commands that need them, so that help comes at once.
"""

import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from exudyn_crawler.cli import application
from exudyn_crawler.cli.application import RESULTS, Out, Overwrite
from exudyn_crawler.views.tables import print_table, within_by_class
from studies import CYCLE_DURATION, DURATION

if TYPE_CHECKING:
    import pandas as pd

app = typer.Typer(help="Studies of the papers and beyond them.", no_args_is_help=True, add_completion=False)
command = partial(application.command, app)


def _positive(duration: float | None) -> float | None:
    """Check the duration before a study is loaded, which takes two seconds."""
    if duration is not None and not (math.isfinite(duration) and duration > 0.0):
        raise typer.BadParameter(f"duration must be positive and finite, got {duration!r} s")
    return duration


def _show_tables(out: Path, tables: Mapping[str, tuple["pd.DataFrame", str, Sequence[str]]]) -> None:
    """Print tables of a folder's CSV files by name, with titles and the columns shown first."""
    for name, (table, title, keys) in tables.items():
        print_table(table, title, keys or [*table.columns], out / f"{name}.csv")
    typer.echo(f"the runs and {', '.join(f'{name}.csv' for name in tables)} are in {out}")


KINEMATICS = RESULTS / "kinematics"
COMPARED = ("quantity", "statistic", "paper", "computed", "within", "unit")
"""Columns of a comparison that are shown first if not all fit, see `print_table`."""
EVIDENCE = ("quantity", "statistic", "within", "variants", "median", "least", "greatest")
HOT = ("rank", "region", "von Mises in MPa", "time in s", "verdict", "node")
LIVES = ("propel_and_material", "region", "life in h at least", "life in h at most", "verdict", "main part")
"""Columns of hot spots, and of lives, that are shown first if not all fit."""
REGIONS = "Highest von Mises stress by region of the shoe"
Propel = Literal["translation", "turning", "both"]
Chosen = Annotated[Propel, typer.Option(help="propel motion to run")]
Ground = StrEnum("Ground", ["step", "ramp", "rough"])
Repeated = StrEnum("Repeated", ["rigid", "stress"])
Duration = Annotated[float, typer.Option(help="simulated time, s", callback=_positive)]
AtMost = Annotated[
    float | None,
    typer.Option(help="simulated time of every case, s; default: the whole case", callback=_positive),
]
MeshName = Annotated[str, typer.Option(help="mesh: coarse, study or fine, or the path of a file")]
Choices = Annotated[
    bool, typer.Option("--choices", help="show the effect of the study's open choices over 8 s instead")
]


def _names(case: Propel) -> tuple[str, ...]:
    return ("translation", "turning") if case == "both" else (case,)


def _show_comparison(table: "pd.DataFrame", study: str, out: Path) -> None:
    for case, rows in table.drop(columns="study").groupby("case", sort=False):
        title = f"{study}, {case}: paper against computed"
        print_table(rows.drop(columns="case"), title, COMPARED, out / "comparison.csv")
    print_table(within_by_class(table), "Rows within their class")


@command("python -m studies kinematics --case translation --duration 2 --out results/short")
def kinematics(
    case: Chosen = "both",
    duration: Duration = DURATION,
    out: Out = KINEMATICS,
    overwrite: Overwrite = False,
) -> None:
    """Run the kinematics study and compare it with the papers."""
    from studies.kinematics import study

    _, table = study(out, _names(case), duration=duration, overwrite=overwrite, say=typer.echo)
    _show_comparison(table, "Kinematics", out)
    typer.echo(f"runs, figures and comparison.csv are in {out}")


@command("python -m studies forces --case translation --out results/straight")
def forces(
    case: Chosen = "both",
    duration: Duration = DURATION,
    out: Out = RESULTS / "forces",
    reuse: Annotated[
        Path | None,
        typer.Option(help=f"folder of runs to reuse; default: {KINEMATICS}, if they match"),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Run the forces study and compare it with the paper."""
    from studies.forces import study

    sources: dict[str, Any] = {"reuse": KINEMATICS if reuse is None else reuse, "strict": reuse is not None}
    _, table = study(out, _names(case), duration=duration, overwrite=overwrite, say=typer.echo, **sources)
    _show_comparison(table, "Forces", out)
    typer.echo(f"runs, figures, comparison.csv and turning_ratios.csv are in {out}")


@command("python -m studies variants rigid")
def variants(
    studies: Annotated[
        list[Repeated], typer.Argument(help="rigid: kinematics and forces; stress", metavar="rigid|stress...")
    ],
    workers: Annotated[
        int | None, typer.Option(help="number of processes; default: one for each core", min=1)
    ] = None,
    out: Out = RESULTS / "variants",
) -> None:
    """Repeat studies with other and with wrong choices and from other starts: which rows could have failed.

    The same command continues. The runs of the stress study take two minutes of processor time each.
    """
    from studies.variants import counts, study

    for name in studies:
        table, told = study(name, out, workers, typer.echo)
        print_table(counts(table), "Rows within their class; lateral ones within a factor of 2")
        title = "Variants in which a row is within, and its range over starts"
        print_table(told, title, EVIDENCE, out / f"{name}_evidence.csv")
    typer.echo(f"rows of all runs, tables by study and their evidence are in {out}")


@command("python -m studies stress --duration 8 --mesh coarse --out results/short")
def stress(
    duration: Duration = CYCLE_DURATION,
    mesh: MeshName = "study",
    modes: Annotated[
        str | None,
        typer.Option(
            help='modes that answer dynamically: all, 1200Hz (and below), 1-20,25 (by number) or "10 fixed"; '
            "the others follow without inertia"
        ),
    ] = None,
    cycle: Annotated[Path | None, typer.Option(help="file of a load cycle, TOML or CSV")] = None,
    out: Out = RESULTS / "stress",
    overwrite: Overwrite = False,
    choices: Choices = False,
) -> None:
    """Run the stress study and compare it with the paper; the same command continues a stopped study."""
    from exudyn_crawler import Case, FlexibleShoes, LoadCycle
    from exudyn_crawler.results.stress.hot_spots import hot_spot_table
    from studies.stress import RUN, highest_in_propel_and_loading, open_choices, study, with_modes

    if choices:
        print_table(open_choices(min(duration, 8.0), mesh), "Paper, and computed for some choices")
        return
    case = Case.stress(mesh)
    if modes is not None:
        case = case.with_(flexible=with_modes(case.part(FlexibleShoes), modes))
    if cycle is not None:
        case = case.with_(loads=LoadCycle.from_file(cycle))
    loads = case.loads.table()
    title = "Loads on the shoes at the ends of the phases, kN"
    print_table(loads, title, loads.columns, out / RUN / "loads.csv")
    run, table = study(out, case, duration=duration, overwrite=overwrite, say=typer.echo)
    stresses = run.recovered()
    for shoe, spots in stresses.hot_spots.items():
        rows = hot_spot_table(spots, stresses.dataset)
        whole = out / RUN / f"hot_spots_shoe_{shoe}.csv"
        print_table(rows, f"Shoe {shoe}: highest von Mises stresses", HOT, whole)
    summary = highest_in_propel_and_loading(run.history, run.recovered())
    print_table(summary, "Highest von Mises stress, MPa")
    _show_comparison(table, "Stress", out)
    typer.echo(f"the run and comparison.csv are in {out}")


@command("python -m studies uneven ramp --duration 2")
def uneven(
    grounds: Annotated[
        list[Ground] | None,
        typer.Argument(help="grounds to run over; default: all", metavar="[step|ramp|rough]..."),
    ] = None,
    duration: Duration = DURATION,
    out: Out = RESULTS / "uneven",
    overwrite: Overwrite = False,
) -> None:
    """Run the track over uneven ground; each ground has a folder with its run and a figure of its end."""
    from studies.uneven_ground import study

    study(out, grounds or list(Ground), duration=duration, overwrite=overwrite, say=typer.echo)
    typer.echo(f"runs and figures are in {out}")


@command("python -m studies shovel-life --stress results/stress --out results/life")
def shovel_life(
    stress: Annotated[
        Path, typer.Option(help="folder of the stress study; missing runs are made there")
    ] = RESULTS / "stress",
    rollers: Annotated[
        Path | None, typer.Option(help="folder of the rollers study, for comparison with the dragged runs")
    ] = None,
    out: Out = RESULTS / "life",
    overwrite: Overwrite = False,
) -> None:
    """Compute the life of the P&H 4100C's shoes in machine hours for three materials."""
    from studies.life import study

    _, summary = study(out, stress, rollers, overwrite=overwrite, say=typer.echo)
    print_table(summary, "Shortest life by propel and material", LIVES, out / "summary.csv")
    typer.echo(f"lives, pages and summary.csv are in {out}")


@command("python -m studies rollers --duration 2 --mesh coarse --out results/short")
def rollers(
    duration: AtMost = None,
    mesh: MeshName = "study",
    out: Out = RESULTS / "rollers",
    overwrite: Overwrite = False,
    choices: Choices = False,
) -> None:
    """Roll the machine over six flexible shoes and let it dig above them; beside the papers' dragging."""
    from studies.rollers import open_choices, study

    if choices:
        print_table(open_choices(min(duration or 8.0, 8.0)), "Effect of the open choices of the rollers")
        return
    _, regions = study(out, mesh, duration=duration, overwrite=overwrite, say=typer.echo)
    keys = ("case", "region", "von Mises in MPa", "time in s", "verdict", "shoe")
    _show_tables(out, {"regions": (regions, REGIONS, keys)})


@command("python -m studies closed --duration 2 --out results/short")
def closed(
    duration: AtMost = None,
    flexible: Annotated[
        int, typer.Option(min=0, help="number of the flexible shoe of the closed track; 0: none")
    ] = 7,
    mesh: MeshName = "coarse",
    out: Out = RESULTS / "closed",
    overwrite: Overwrite = False,
) -> None:
    """Run one revolution of a closed track on the papers' ground, beside the rolled open track, and turns."""
    from studies.closed import study

    how: dict[str, Any] = {
        "duration": duration,
        "flexible": flexible or None,
        "mesh": mesh,
        "overwrite": overwrite,
    }
    _, loads, torque, peaks, turns = study(out, **how, say=typer.echo)
    shown = {"loads": (loads, "Loads round the loop", ()), "torque": (torque, "Torque by tension", ())}
    shown |= {"peaks": (peaks, "Shoes in mid-track", ()), "turns": (turns, "Straight and in turns", ())}
    _show_tables(out, shown)


@command("python -m studies grounds --duration 2 --out results/short")
def grounds(
    duration: Duration = 60.0,
    mesh: MeshName = "coarse",
    powers: Annotated[
        bool, typer.Option("--powers", help="run rigid shoes instead, and show the power balance of the pull")
    ] = False,
    out: Out = RESULTS / "ground",
    overwrite: Overwrite = False,
) -> None:
    """Roll the machine over sand, oil sand and hard floor; beside the papers' ground."""
    from studies.ground import power_study, study

    if powers:
        out = out / "powers"
        table = power_study(out, duration=duration, overwrite=overwrite, say=typer.echo)
        keys = ("ground", "pull beyond rolling in kN", "taken by pressure in kN", "taken by shear in kN")
        _show_tables(out, {"powers": (table, "Where the pull goes, over the distance travelled", keys)})
        return
    _, table, regions, lives = study(out, mesh, duration=duration, overwrite=overwrite, say=typer.echo)
    keys = ("ground", "mean pull in kN", "greatest tilt of a shoe in mrad", "highest stress in MPa")
    lives_keys = ("ground", *LIVES[1:-1])
    shown: dict[str, Any] = {"grounds": (table, "The machine on every ground", keys)}
    shown |= {"regions": (regions, REGIONS, ("ground", "region", "von Mises in MPa", "verdict"))}
    shown |= {"lives": (lives, "Shortest life by region, in hours of propel", lives_keys)}
    _show_tables(out, shown)


@command("python -m studies plate-sweep --out results/plate_sweep")
def plate_sweep(
    workers: Annotated[
        int | None, typer.Option(help="number of processes; default: one for each core", min=1)
    ] = None,
    out: Out = RESULTS / "plate_sweep",
) -> None:
    """Sweep top plate and ground against the life of the roller path; the same command continues."""
    application.require_sweeps()  # before it meshes for minutes
    from studies.plate_sweep import study

    run = study(out, workers=workers, say=typer.echo)
    table = run.table.drop(columns=["folder", "reason"])
    print_table(table, "Runs; units are in the head of results.csv", table.columns, out / "results.csv")
    typer.echo(f"the runs, results.csv and report.html are in {out}")


@command("python -m studies library pc300lc d11")
def library(
    machines: Annotated[
        list[str] | None, typer.Argument(help="names of the library's machines; default: all")
    ] = None,
    out: Out = RESULTS / "library",
    overwrite: Overwrite = False,
) -> None:
    """Run machines of the library straight and on the spot: way and turn over the commanded, tensions."""
    from studies.library import NAMES, study

    _, table = study(out, machines or NAMES, overwrite=overwrite, say=typer.echo)
    _show_tables(out, {"motion": (table, "Motion over the commanded one", ())})


@command("python -m studies pins")
def pins(out: Out = RESULTS / "pins", overwrite: Overwrite = False) -> None:
    """Compare pins without and with friction: work of a pin in a lap, power of the drive, rattle (2 min)."""
    from studies.pins import study

    table = study(out, overwrite=overwrite, say=typer.echo)
    _show_tables(out, {"pins": (table, "A lap of a pin", ("run", "whole path in kJ", "closed form in kJ"))})
    typer.echo(f"the spectra are in {out / 'spectra.png'}")


@command("python -m studies play")
def play(out: Out = RESULTS / "play") -> None:
    """Show what play of pins changes in side forces and moments of links, and what it costs (5 min)."""
    from studies.play import study

    table = study(out, typer.echo)
    _show_tables(out, {"play": (table, "Links with play", ())})


@command("python -m studies sliding-modes --out results/sliding_modes")
def sliding_modes(
    runs: Annotated[bool, typer.Option("--runs", help="include the 10 s runs (ten minutes)")] = False,
    out: Out = RESULTS / "sliding_modes",
    overwrite: Overwrite = False,
) -> None:
    """Show why the shoes bounce: which modes of the sliding track grow, and over what."""
    from studies.sliding_modes import study, table_name

    for title, table in study(out, runs=runs, overwrite=overwrite):
        print_table(table, title, table.columns, out / table_name(title))
    typer.echo(f"the tables and modes.png are in {out}")


@command("python -m studies verify")
def verify() -> None:
    """Solve the two-body problem by hand and by the engine, side by side."""
    from studies.two_bodies import study

    side_by_side, table = study()
    print_table(side_by_side, "Two-body problem at t = 0.5 s")
    print_table(table, "Paper against computed")


@command("python -m studies mechanisms")
def mechanisms(out: Out = RESULTS / "mechanisms") -> None:
    """Solve mechanisms of pins with known motions: pendulum, N-four-bar, a ring that spins."""
    from studies.mechanisms import study

    _show_tables(out, {"mechanisms": (study(out), "Known answers beside the computed ones", ())})


@command("python -m studies order dragged closed")
def order(
    motions: Annotated[list[str] | None, typer.Argument(help="names of motions; default: all")] = None,
    out: Out = RESULTS / "order",
) -> None:
    """Show how fast smooth motions of each gear converge with the step: order two, on cells one."""
    from studies.order import MOTIONS, study

    table = study(out, motions or tuple(MOTIONS), typer.echo)
    _show_tables(out, {"order": (table, "Order of convergence", ())})


@command("python -m studies measurements --runs")
def measurements(
    runs: Annotated[
        bool, typer.Option("--runs", help="include trends that need runs (some minutes)")
    ] = False,
    out: Out = RESULTS / "measurements",
) -> None:
    """Compare the program with public measurements: numbers, and trends if only those are published."""
    from studies.measurements import study

    rows, trends = study(out, runs, typer.echo)
    _show_comparison(rows, "Measured", out)
    print_table(trends, "Trends", trends.columns, out / "trends.csv")
    typer.echo(f"comparison.csv and trends.csv are in {out}")
