"""The commands of measurement: a soil from its tests."""

from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.cli import application
from exudyn_crawler.cli.commands import command
from exudyn_crawler.views.tables import print_table, write_table


@command("exudyn-crawler fit-soil plates.csv shear.csv")
def fit_soil(
    plates: Annotated[Path, typer.Argument(help="table of pressed plates", metavar="PLATE.csv")],
    shear: Annotated[Path | None, typer.Argument(help="table of shear tests", metavar="[SHEAR.csv]")] = None,
    base: Annotated[
        str | None, typer.Option(help="soil that has what the tests do not give, as lete_sand")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="law file to write; PLATE_law.toml, if not given")] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """Fit the soil law to plate and shear tests: parameters with intervals, a law file and a figure."""
    from exudyn_crawler.files import refuse_existing
    from exudyn_crawler.results.measured import law_file, soil_fit as fits, soil_tests
    from exudyn_crawler.views import measured, style

    path = out or plates.with_name(f"{plates.stem}_law.toml")
    figure_path, table_path = (path.with_name(path.stem + ending) for ending in (".png", ".csv"))
    for target in (path, figure_path, table_path):
        refuse_existing(target, overwrite)
    result = fits.fit_soil(
        soil_tests.read_plates(plates),
        None if shear is None else soil_tests.read_shear(shear),
        None if base is None else fits.named_soil(base),
    )
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
