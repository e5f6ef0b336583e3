"""Commands of measurement: soil from tests, drawbar test, pressure in the ground."""

import warnings
from pathlib import Path
from typing import Annotated

import typer

import exudyn_crawler as crawler
from exudyn_crawler.cli import application
from exudyn_crawler.cli.commands import command
from exudyn_crawler.views.tables import print_table, write_table


@command("exudyn-crawler fit-soil plates.csv shear.csv")
def fit_soil(
    plates: Annotated[
        Path, typer.Argument(help="table of plate tests: pressure over sinkage", metavar="PLATE.csv")
    ],
    shear: Annotated[Path | None, typer.Argument(help="table of shear tests", metavar="[SHEAR.csv]")] = None,
    base: Annotated[
        str | None, typer.Option(help="soil with the values that the tests do not give, such as lete_sand")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="law file to write; default: PLATE_law.toml")] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Fit the soil law to plate and shear tests: parameters with intervals, a law file and a figure."""
    from exudyn_crawler.files import refuse_existing
    from exudyn_crawler.results.measured import law_file, soil_fit as fits
    from exudyn_crawler.views import measured, style

    path = out or plates.with_name(f"{plates.stem}_law.toml")
    figure_path, table_path = (path.with_name(path.stem + ending) for ending in (".png", ".csv"))
    for target in (path, figure_path, table_path):
        refuse_existing(target, overwrite)
    result = fits.fit_files(plates, shear, None if base is None else fits.named_soil(base))
    fits.warn(result)
    table = law_file.parameter_table(result)
    sources = [name.name for name in (plates, shear) if name is not None]
    print_table(table, f"Soil of {' and '.join(sources)}", law_file.HEADS[:5], table_path)
    correlations = law_file.correlation_table(result)
    if len(correlations):
        print_table(correlations, "Correlations")
    write_table(table, table_path, overwrite)
    with style.titled_figure(path.stem, 5.2 if shear is None else 10.0, 3.6) as figure:
        measured.draw_soil_fit(result, figure)
    style.save_figure(figure, figure_path, overwrite)
    written = law_file.write_law(result, path, sources, overwrite)
    typer.echo(f"{written}: a case reads it with file = '{written.name}' in [contact.law]")
    typer.echo(f"{figure_path}, {table_path}: the law over the points, and its parameters")


@command("exudyn-crawler drawbar closed_on_sand.toml --slips 0.02,0.05,0.2")
def drawbar(
    case: Annotated[
        Path, application.file_argument(help="case file of a closed track or a machine", metavar="CASE.toml")
    ],
    slips: Annotated[str | None, typer.Option(help="rising slips to hold; default: 0.01 to 0.4")] = None,
    height: Annotated[float, typer.Option(help="height of the drawbar above the ground, m")] = 0.0,
    slip: Annotated[
        float, typer.Option(help="slip of the pull in the table of numbers", min=0.0, max=1.0)
    ] = 0.2,
    out: application.OfName = None,
    changes: application.Changes = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Hold a track back at given slips: pull, torque, efficiency and sinkage over slip."""
    import pandas as pd

    from exudyn_crawler.results.measured import drawbar as tests
    from exudyn_crawler.views import measured, style

    held = tests.SLIPS if slips is None else tests.read_slips(slips)
    pulled = tests.pulled_case(crawler.read_case(case, changes or ()), tests.DrawbarTest(held, height))
    folder = out or application.RESULTS / f"{case.stem}_drawbar"
    done = crawler.run_case(pulled, folder, overwrite=overwrite, say=typer.echo)
    table = tests.drawbar_table(done.history)
    write_table(table, folder / "drawbar.csv", overwrite=True)
    with style.titled_figure(f"{pulled.case.name}: drawbar test", 8.0, 5.5) as figure:
        measured.draw_drawbar(table, tests.even_track(pulled.case), figure)
    style.save_figure(figure, folder / "drawbar.png", overwrite=True)
    rows = tests.result_rows(tests.drawbar_result(done.history, slip), slip)
    numbers = pd.DataFrame(rows, columns=["result", "value", "unit"])
    write_table(numbers, folder / "drawbar_numbers.csv", overwrite=True)
    print_table(numbers, f"Drawbar test of {pulled.case.name}")
    for remark in tests.remarks(done.history, table):
        warnings.warn(remark, stacklevel=2)
    typer.echo(f"{folder}: drawbar.csv over slip, drawbar.png beside the closed form, drawbar_numbers.csv")


@command("exudyn-crawler soil-stress results/closed --sensor 12,0,0 --sensor 12,0,0.5")
def soil_stress(
    run: application.Run,
    sensor: Annotated[
        list[str], typer.Option(help="x, y and depth of a sensor below the loaded surface, m; repeatable")
    ],
    concentration: Annotated[
        float | None, typer.Option(help="Froehlich's concentration factor; 3: Boussinesq; default: 4")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="table to write; default: RUN/soil_stress.csv")] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Compute the normal pressure at sensors in the ground as the track passes: table, peaks and figure."""
    from exudyn_crawler.files import refuse_existing
    from exudyn_crawler.results.measured import soil_stress as stresses
    from exudyn_crawler.views import measured, style

    sensors = [stresses.read_sensor(text) for text in sensor]
    path = out or application.history_path(run).parent / "soil_stress.csv"
    figure_path = path.with_suffix(".png")
    for target in (path, figure_path):
        refuse_existing(target, overwrite)
    factor = stresses.CONCENTRATION if concentration is None else concentration
    table = stresses.stress_table(application.loaded(run), sensors, factor)
    write_table(table, path, overwrite)
    passages = stresses.passage_table(table)
    print_table(passages, f"Pressure in the ground, concentration factor {factor:g}")
    with style.titled_figure(f"{run.name}: pressure in the ground", 7.0, 3.6) as figure:
        measured.draw_soil_stress(table, passages, figure)
    style.save_figure(figure, figure_path, overwrite)
    typer.echo(f"{path}: over time and distance; {figure_path}")
