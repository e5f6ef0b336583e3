"""Commands that evaluate runs: report, film, stress, forces and loads of one, comparison of two, lives."""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Literal

import typer

import exudyn_crawler as crawler
from exudyn_crawler.cli import application, datasheets
from exudyn_crawler.cli.commands import command
from exudyn_crawler.run.folder.progress import heartbeat
from exudyn_crawler.views.tables import print_table, write_table

COMPARED = ("quantity", "axis", "greatest in A", "greatest in B", "change in %", "unit")
"""Key columns of differences between two runs, see `print_rows`."""
LIVES = ("region", "life in h at least", "life in h at most", "above", "verdict", "main part", "node")
"""Key columns of shortest lives."""
CRACKED = ("region", "cycles to a crack", "from", "to", "an hour", "above yield", "pairs within 10 %")
"""Key columns of a check's cycles to a crack."""
ASSESSED = ("item", "utilisation", "within", "load case", "group", "number", "limit", "unit")
"""Key columns of an assessment."""
WORN = ("part", "worn in %", "machine hours left", "at least", "at most", "about", "action")
"""Key columns of a wear forecast."""
WORKED = ("part", "duty", "work a propel hour in kJ", "ratio", "hours left", "hours from")
"""Key columns of the work of duties."""
TYPST = "typst"
"""Package that typesets reports to sign."""
WHY = "what makes a difference"
"""Column of formulas beside runs, too wide for a terminal."""

Shoe = Annotated[int, typer.Option(help="number of the shoe")]
Out = Annotated[Path | None, typer.Option(help="file to write; default: a file beside RUN or LAW")]


@command("exudyn-crawler report results/stress")
def report(
    runs: Annotated[
        list[Path],
        typer.Argument(
            help="folder of a run or a study; with --pdf of a run, an assessment, a life or a wear forecast",
            metavar="RUN...",
        ),
    ],
    pdf: Annotated[
        bool,
        typer.Option("--pdf", help="make a report to sign, two to four pages on paper, in place of the page"),
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="file to write; default: RUN/report.html or RUN/report.pdf")
    ] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Make one self-contained page of a run, for reading offline in a browser, or a PDF to sign."""
    folders = [application.run_folder(run) for run in runs]  # refused before slow imports
    if out is not None and len(folders) > 1:
        raise ValueError(f"--out must go with one folder, got {len(folders)}")
    if pdf and find_spec(TYPST) is None:
        raise ValueError(application.needs("reports to sign", [TYPST], "report"))
    for folder in folders:
        with heartbeat(f"report of {folder}"):
            made = (crawler.write_signed if pdf else crawler.write_report)(folder, out, overwrite)
        application.report_made(made, ": print and sign it" if pdf else ": open it in a browser")


@command("exudyn-crawler animate results/kinematics/translation --end 5")
def animate(
    run: application.Run,
    out: Annotated[
        Path | None,
        typer.Option(help=".mp4 or .gif file to write; default: RUN/history.mp4"),
    ] = None,
    scale: Annotated[
        float | None,
        typer.Option(help="magnification of the ground's displacements; default: chosen to fit the picture"),
    ] = None,
    start: Annotated[float, typer.Option(help="first shown time, s")] = 0.0,
    end: Annotated[float | None, typer.Option(help="last shown time, s; default: the run's end")] = None,
    speed: Annotated[float, typer.Option(help="simulated seconds in a second of the film")] = 1.0,
    overwrite: application.Overwrite = False,
) -> None:
    """Animate the track on the deforming terrain, without a display."""
    path = out or application.history_path(run).with_suffix(".mp4")
    history = application.loaded(run)  # refused before slow imports
    with heartbeat(f"animation of {run}"):
        crawler.write_animation(history, path, overwrite, scale, speed=speed, start=start, end=end)
    application.report_made(path)


@command("exudyn-crawler node-stress results/stress/cycle --shoe 13 --near 0.3 -0.6 0.05")
def node_stress(
    run: application.Run,
    shoe: Shoe,
    near: Annotated[
        tuple[float, float, float] | None,
        typer.Option(help="point in the shoe's frame, m; the nearest node counts", metavar="X Y Z"),
    ] = None,
    node: Annotated[int | None, typer.Option(help="number of the node; alternative to --near")] = None,
    out: Out = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Write the stress at a point of a flexible shoe over time: tensor, principal stresses, von Mises."""
    path = application.history_path(run)
    from exudyn_crawler.results.stress import recovery

    stress = recovery.node_stress(path, shoe, near, node)
    place = ", ".join(f"{value:.4f}" for value in stress.place.values)
    number = stress.attrs["node"]
    typer.echo(
        f"shoe {shoe}, node {number} at ({place}) m in the shoe's frame, "
        f"{stress.attrs['distance_m']:.4f} m from the given point"
    )
    if stress.attrs["in_spider"]:
        typer.echo("the node is held by a pin coupling: its stress is beside a rigid coupling, not in a bore")
    mises = stress.von_mises.values
    greatest = int(mises.argmax())
    typer.echo(
        f"greatest von Mises stress {mises[greatest] / 1e6:.4g} MPa at t = {float(stress.time[greatest]):g} s"
    )
    out = out or path.parent / f"stress_shoe_{shoe}_node_{number}.csv"
    application.report_made(write_table(recovery.node_table(stress), out, overwrite))


@command("exudyn-crawler pin-forces results/stress/cycle --shoe 13")
def pin_forces(
    run: application.Run, shoe: Shoe, out: Out = None, overwrite: application.Overwrite = False
) -> None:
    """Write the forces and moments of a shoe's pins over time, in the shoe's axes."""
    history = application.loaded(run)
    from exudyn_crawler.results.loads import exports

    out = out or application.history_path(run).parent / f"pin_forces_shoe_{shoe}.csv"
    application.report_made(write_table(exports.pin_table(history, shoe), out, overwrite))


@command("exudyn-crawler shoe-loads results/stress/cycle --shoe 13 --program abaqus")
def shoe_loads(
    run: application.Run,
    shoe: Shoe,
    time: Annotated[
        float | None, typer.Option(help="time, s; default: time of the shoe's highest stress")
    ] = None,
    program: Annotated[
        Literal["calculix", "abaqus"], typer.Option(help="finite-element program of the deck")
    ] = "calculix",
    out: Annotated[
        Path | None, typer.Option(help="folder for the files; default: folder of the history")
    ] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Write all forces on a shoe at one instant, in balance: a table, and a deck if it is flexible."""
    history = application.loaded(run)
    history.case.track.check_shoe(shoe)
    from exudyn_crawler.results.loads import exports

    flexible = history.case.flexible is not None and shoe in history.case.flexible.shoes
    if time is None:
        if not flexible:
            raise ValueError(f"time must be given for shoe {shoe}, which is rigid and has no highest stress")
        from exudyn_crawler.results.stress.recovery import peak_time

        time = peak_time(history, shoe)
    folder = out or application.history_path(run).parent
    table = exports.action_table(history, shoe, time)
    name = f"loads_shoe_{shoe}_{exports.at_instant(history, time).duration:.4f}s"
    if flexible:
        deck = folder / f"{name}_{program}.inp"
        application.report_made(exports.shoe_loads(history, shoe, time).write(deck, program, overwrite))
    application.report_made(write_table(table, folder / f"{name}.csv", overwrite))


@command("exudyn-crawler compare results/soft_ground results/hard_ground --out soft_and_hard.html")
def compare(
    first: Annotated[Path, typer.Argument(help="folder of a run, or its history", metavar="A")],
    second: Annotated[
        Path,
        typer.Argument(
            help="folder of the other run, its history, or a table of measured series", metavar="B"
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            help="page to write, or figure of series, with its tables beside it; default: named A_B"
        ),
    ] = None,
    shift: Annotated[
        float | None, typer.Option(help="shift added to the times (s) or distances (m) of measured series")
    ] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Compare two runs in cases and results, or a run with measured series (CSV)."""
    if second.suffix.lower() == ".csv":
        compare_series(first, second, out, shift or 0.0, overwrite)
        return
    if shift is not None:
        raise ValueError(f"--shift must go with measured series (CSV), got {second}")
    names = [application.run_folder(run).resolve().name for run in (first, second)]
    runs = dict(zip(names if names[0] != names[1] else "AB", (first, second), strict=True))
    histories = {name: application.loaded(run) for name, run in runs.items()}
    from exudyn_crawler.views.pages import runs as pages

    by_run = {name: pages.stress_of(application.run_folder(run)) for name, run in runs.items()}
    stresses = {name: stress for name, stress in by_run.items() if stress is not None}
    page = out or Path("_".join(runs) + ".html")
    pages.write_comparison(histories, page, stresses, overwrite)
    parameters, results = pages.comparison_tables(histories, stresses)
    named = ", ".join(f"{letter} is {name}" for letter, name in zip("AB", runs, strict=True))
    whole = write_table(results, page.with_suffix(".csv"), overwrite)
    for table, title, same in (
        (parameters, f"What differs in the cases: {named}", pages.SAME_CASES),
        (results, "What differs in the results", pages.SAME_RESULTS),
    ):
        if table.empty:
            typer.echo(same)
        else:
            print_table(table, title, COMPARED, whole)
    typer.echo(f"{page}: open it in a browser; {whole}: the table of results")


def compare_series(run: Path, measured: Path, out: Path | None, shift: float, overwrite: bool) -> None:
    """Compare a run with measured series: a table of differences, and a figure."""
    history = application.loaded(run)
    from exudyn_crawler.files import refuse_existing
    from exudyn_crawler.results.measured import series
    from exudyn_crawler.views import measured as drawing, style

    name = f"{application.run_folder(run).resolve().name}_{measured.stem}"
    path = out or Path(f"{name}.png")
    table_path = path.with_suffix(".csv")
    for target in (path, table_path):
        refuse_existing(target, overwrite)
    compared = series.compare(history, measured, shift)
    table = series.compared_table(compared)
    moved = f", shifted by {shift:g} {series.OVER[compared[0].over]}" if shift else ""
    print_table(table, f"{measured.name}{moved}, beside {run}")
    write_table(table, table_path, overwrite)
    with style.titled_figure(path.stem, 8.0, 0.7 + 2.2 * len(compared)) as figure:
        drawing.draw_compared(compared, figure)
    style.save_figure(figure, path, overwrite)
    typer.echo(f"{path}: curves of the run and of the measurement; {table_path}: the table")


@command("exudyn-crawler ground oil_sand.toml")
def ground(
    file: Annotated[Path, application.file_argument(help="file of a law of the ground", metavar="LAW.toml")],
    out: Out = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Draw a law of the ground: pressure over sinkage with unloading, shear over slip with a reversal."""
    from exudyn_crawler.case.parameters import checks
    from exudyn_crawler.ground.cells.laws import read_law
    from exudyn_crawler.views import style

    law = read_law(file)
    checks.warn_of(f"{file}: {line}" for line in checks.out_of_range(law))
    with style.titled_figure(file.stem, 8.0, 3.2) as figure:
        law.draw(*figure.subplots(1, 2))
    application.report_made(style.save_figure(figure, out or file.with_suffix(".png"), overwrite))


@command("exudyn-crawler life digging.toml --out results/digging")
def life(
    duty: Annotated[Path, application.file_argument(help="duty file", metavar="DUTY.toml")],
    out: application.OfName = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Compute the life of the shoes in machine hours over a mix of runs: where they crack, and why."""
    asked = crawler.read_duty(duty)  # refused before slow imports
    from exudyn_crawler.results.life.life import for_reading
    from exudyn_crawler.views.pages.life import life_lines

    folder = out or application.RESULTS / duty.stem
    result = crawler.life(asked, folder, overwrite=overwrite, say=typer.echo)
    title = f"{asked.name}: shortest lives by region"
    whole = folder / "shortest_lives.csv"
    print_table(for_reading(result.table), title, LIVES, whole)
    typer.echo("\n".join(life_lines(result)))
    typer.echo(f"life, tables, fields and page (life.html) are in {folder}")


@command("exudyn-crawler wear excavator_wear.toml --out results/excavator_wear")
def wear(
    file: Annotated[Path, application.file_argument(help="file of a wear forecast", metavar="WEAR.toml")],
    out: application.OfName = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Forecast the wear of the undercarriage: work of a duty's runs, residual hours by inspections."""
    plan = crawler.read_wear(file)  # refused before slow imports
    folder = out or application.RESULTS / file.stem
    found = crawler.wear(plan, folder, overwrite=overwrite, say=typer.echo)
    if found.duties:
        print_table(found.by_duty, f"{plan.name}: work and hours by duty", WORKED, folder / "duties.csv")
    if found.forecast is not None:
        print_table(found.forecast.table, f"{plan.name}: what is due first", WORN, folder / "due.csv")
    typer.echo("\n".join(found.lines))
    typer.echo(f"tables, drawings and page are in {folder}; wear.html: open it in a browser")


Unit = Annotated[
    Literal["mm", "m", "inch", "cm"] | None,
    typer.Option(help="unit of lengths in the file; default: recognised from the size"),
]
FlipFront = Annotated[
    bool, typer.Option("--flip-front", help="turn the shoe so that its other end is the front")
]
FlipUp = Annotated[bool, typer.Option("--flip-up", help="turn the shoe so that its other side is up")]
Footprint = Annotated[
    Literal["plate", "tips"] | None,
    typer.Option(help="underside of a shoe with grousers: plate, or tips of the grousers"),
]
Body = Annotated[str | None, typer.Option(help="number of the solid, 1 is the largest; or all", metavar="N")]
Pins = Annotated[int, typer.Option(help="number of the pair of bores, 1 is the most likely", min=1)]
ShapeChoices = tuple[
    Literal["mm", "m", "inch", "cm"] | None, bool, bool, Literal["plate", "tips"] | None, str | None, int
]
"""Options above in the order of `meshes.recognition.axes.Choices`."""
NO_CHOICES: ShapeChoices = (None, False, False, None, None, 1)
Size = Annotated[
    Literal["coarse", "study", "fine"], typer.Option(help="size of the elements if the file is a solid")
]


@command("exudyn-crawler shoe excavator_shoe.step")
def shoe(
    file: Annotated[
        Path,
        application.file_argument(
            help="maker's file (STEP, STL, tetrahedra), or a case file with a datasheet", metavar="FILE"
        ),
    ],
    unit: Unit = None,
    flip_front: FlipFront = False,
    flip_up: FlipUp = False,
    footprint: Footprint = None,
    body: Body = None,
    pins: Pins = 1,
    size: Size = "study",
    out: Annotated[Path, typer.Option(help="folder for mesh, case and picture")] = Path(),
    overwrite: application.Overwrite = False,
) -> None:
    """Make a mesh and a case from a maker's file of a shoe, or from the ready shoe of a datasheet."""
    if file.suffix.lower() == ".toml":
        datasheets.fit_shoe(file, size, out, overwrite)
        return
    write_maker_shoe(file, (unit, flip_front, flip_up, footprint, body, pins), size, out, overwrite)


def write_maker_shoe(file: Path, choices: ShapeChoices, size: str, out: Path, overwrite: bool) -> None:
    """Write mesh, case and picture of the shoe in a maker's file into a folder."""
    from exudyn_crawler.files import refuse_existing
    from exudyn_crawler.shoe_file import paths_of, shoe_name, shoe_of, write_shoe
    from meshes.recognition.axes import Choices

    name = shoe_name(file)
    for path in paths_of(name, out).values():
        refuse_existing(path, overwrite)
    with heartbeat(f"shoe of {file}"):
        recognised = shoe_of(file, Choices(*choices), size)
        paths = write_shoe(recognised, out, overwrite)
    print_table(recognised.table, f"{name}: shoe of {file}")
    typer.echo("\n".join(recognised.lines()))
    typer.echo(f"{paths['picture']}: check that every surface has its colour")
    typer.echo(f"{paths['case']}: its cycles to a crack: exudyn-crawler check {paths['case']}")


@command("exudyn-crawler check overhanging.toml --no-pictures")
def check(
    file: Annotated[
        Path,
        application.file_argument(help="check file of a shoe, case file, or maker's file", metavar="SHOE"),
    ],
    unit: Unit = None,
    flip_front: FlipFront = False,
    flip_up: FlipUp = False,
    footprint: Footprint = None,
    body: Body = None,
    pins: Pins = 1,
    size: Size = "study",
    out: Annotated[
        Path | None,
        typer.Option(
            help=f"folder for the results; default: {application.RESULTS}/NAME_check; maker's file: NAME"
        ),
    ] = None,
    pictures: Annotated[bool, typer.Option(help="draw each case")] = True,
    overwrite: application.Overwrite = False,
) -> None:
    """Check a shoe by static cases without a run: which case cracks which region after how many cycles."""
    of_maker = file.suffix.lower() != ".toml"
    choices = unit, flip_front, flip_up, footprint, body, pins
    # a run of the same case has the folder with its name
    folder = out or application.RESULTS / (file.stem if of_maker else f"{file.stem}_check")
    if of_maker:
        write_maker_shoe(file, choices, size, folder, overwrite)
        from exudyn_crawler.shoe_file import shoe_name

        file = folder / f"{shoe_name(file)}.toml"
    elif choices != NO_CHOICES:
        raise ValueError(f"flags of a shoe's shape must go with a maker's file, got {file}")
    result = crawler.check_cases(file, folder, pictures=pictures, overwrite=overwrite, say=typer.echo)
    from exudyn_crawler.views.pages.life import check_lines

    typer.echo("\n".join(check_lines(result)))
    shown = result.by_region
    hours = f"how many an hour crack within {result.check.hours:g} h"
    title = f"{result.check.name}, {result.check.material.name}: shortest of each region; an hour: {hours}"
    print_table(shown, title, CRACKED, folder / "cycles.csv")
    typer.echo(
        f"all pairs of cases, section moments and pictures are in {folder}; check.html: open it in a browser"
    )


@command("exudyn-crawler assess studies/shovel_assessment.toml --run results/turn")
def assess(
    machine: Annotated[
        Path,
        application.file_argument(help="case file of a machine, or assessment file", metavar="MACHINE.toml"),
    ],
    out: application.OfName = None,
    run: Annotated[
        list[str] | None,
        typer.Option(
            help="folder of a run whose forces replace those of the formulas in its load case, or "
            "LOAD CASE=RUN; may be repeated"
        ),
    ] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Assess a machine without a run: ground pressure, tipping, travel, load cases, utilisation of parts."""
    if not machine.is_file():
        raise FileNotFoundError(f"there is no file {machine}")
    folder = out or application.RESULTS / machine.stem
    result = crawler.assess(machine, folder, run=run or (), overwrite=overwrite, say=typer.echo)
    from exudyn_crawler.views.pages.assessment import printed

    typer.echo("\n".join(result.lines))
    print_table(printed(result), f"{result.name}: utilisation", ASSESSED, folder / "items.csv")
    if result.compared is not None:
        beside = result.compared.drop(columns=WHY)
        print_table(beside, "Formulas beside runs; what makes a difference is on the page")
    typer.echo(f"tables, drawings and page are in {folder}; assessment.html: open it in a browser")


@command("exudyn-crawler spread results/stress/cycle")
def spread(
    run: application.Run,
    starts: Annotated[
        int, typer.Option(help="number of starts that differ by rounding, including the run's own")
    ] = 3,
    laws: Annotated[
        bool, typer.Option(help="repeat the run also with the other contact law, sharing pair or area")
    ] = True,
    overwrite: application.Overwrite = False,
) -> None:
    """Repeat a run from other starts and with the other contact law, and judge its stresses."""
    folder = application.run_folder(run)  # refused before slow imports
    from exudyn_crawler.spread_run import spread as spread_into

    result = spread_into(folder, starts, laws=laws, overwrite=overwrite, say=typer.echo)
    print_table(result.by_shoe(), f"{folder}: highest stresses of the repeated runs at the first one's node")
    typer.echo(f"runs, tables of hot spots and verdicts of all nodes are in {folder / 'spread'}")
