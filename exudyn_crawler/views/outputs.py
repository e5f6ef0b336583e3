"""What a run leaves beside its history: a writer for each of the outputs that its case asks for."""

from collections.abc import Callable
from pathlib import Path

import xarray as xr

from exudyn_crawler.case import Outputs
from exudyn_crawler.files import blocks, whole_file, write_netcdf_along
from exudyn_crawler.results.history.catalogue import select
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.history.summary import extremes, load_table
from exudyn_crawler.results.stress.hot_spots import highest_by_phase, hot_spot_table, region_table
from exudyn_crawler.results.stress.recovery import StressResults
from exudyn_crawler.views.figures import run_figures, stress_figures
from exudyn_crawler.views.scenes.films import write_animation
from exudyn_crawler.views.scenes.paraview import write_paraview
from exudyn_crawler.views.scenes.pictures import ground_figure, write_stress_pictures
from exudyn_crawler.views.style import save_figure
from exudyn_crawler.views.tables import write_table
from fem import write_vtu

MOST_DRAWN = 5 * 10**8
"""Bytes of a history whose curves are drawn as they are: 70 s of 13 rigid shoes, stored every 2 ms."""


def write_tables(history: History, stresses: StressResults | None, folder: Path, outputs: Outputs) -> None:
    """Extremes, loads at the ends of the phases; highest stresses by phase, by region and over the run."""
    tables = {"extremes": extremes(history), "loads": load_table(history)}
    if stresses is not None:
        dataset = stresses.dataset
        tables["highest_stresses"] = highest_by_phase(history, dataset)
        tables["highest_by_region"] = region_table(stresses.by_region, dataset)
        for shoe, hot_spots in stresses.hot_spots.items():
            tables[f"hot_spots_shoe_{shoe}"] = hot_spot_table(hot_spots, dataset)
    for name, table in tables.items():
        write_table(table, folder / f"{name}.csv", overwrite=True)


def write_forces(history: History, stresses: StressResults | None, folder: Path, outputs: Outputs) -> None:
    """What derives from the forces of the history, which has them themselves."""
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
    write_netcdf_along("time", history.time.size, chunks, folder / "forces.nc", overwrite=True)


def write_figures(history: History, stresses: StressResults | None, folder: Path, outputs: Outputs) -> None:
    """Curves of some shoes and links, of rollers and of flexible shoes; uneven ground as the run ends."""
    terrain, figures = history.case.terrain, {}
    if stresses is not None:
        figures = {f"flexible {name}": one for name, one in stress_figures(history, stresses).items()}
    if not (terrain.heights is None and terrain.profile is None):
        figures["ground"] = ground_figure(history, history.duration)
    # curves of a long run would not fit into memory, and no figure shows them at every step
    drawn = history.every(-(-history.dataset.nbytes // MOST_DRAWN))
    figures |= run_figures(drawn, outputs.drawn_shoes(history.case.track.shoe_count))
    for name, figure in figures.items():
        save_figure(figure, folder / f"{name.replace(' ', '_')}.{outputs.figure_format}", overwrite=True)


def write_pictures(history: History, stresses: StressResults | None, folder: Path, outputs: Outputs) -> None:
    """Pictures of stressed shoes at the chosen times."""
    if stresses is not None:
        write_stress_pictures(stresses.dataset, history, folder, overwrite=True)


def write_for_paraview(
    history: History, stresses: StressResults | None, folder: Path, outputs: Outputs
) -> None:
    """Whole track with its stressed shoes at the chosen times; greatest stress of every node of each shoe."""
    if stresses is None:
        return
    for shoe in stresses.dataset.shoe.values:
        own = stresses.dataset.sel(shoe=shoe)
        fields = {
            "greatest von Mises": own.peak_von_mises.values,
            "time of the greatest": own.peak_time.values,
            "range of von Mises": (own.peak_von_mises - own.least_von_mises).values,
            "error of the mesh over the stress": own.peak_mesh_error.values,
            "verdict": own.peak_verdict.values,
        }
        with whole_file(folder / f"fields_shoe_{shoe}.vtu", overwrite=True) as temporary:
            write_vtu(temporary, stresses.whole.mesh, fields)
    write_paraview(stresses.dataset, history, folder, overwrite=True)


def write_film(history: History, stresses: StressResults | None, folder: Path, outputs: Outputs) -> None:
    """The track on its deforming terrain."""
    write_animation(history, folder / "track.mp4", overwrite=True)


WRITERS: dict[str, Callable[[History, StressResults | None, Path, Outputs], None]] = {
    "tables": write_tables,
    "forces": write_forces,
    "figures": write_figures,
    "pictures": write_pictures,
    "paraview": write_for_paraview,
    "animation": write_film,
}
"""What is written of a run, by the output that asks for it, in this order."""


def write_outputs(history: History, stresses: StressResults | None, folder: Path, outputs: Outputs) -> None:
    """Write the stresses, and what derives from history and stresses as far as the outputs ask for it."""
    if stresses is not None:
        stresses.save(folder / "stress.nc", overwrite=True)
    for output, write in WRITERS.items():
        if getattr(outputs, output):
            write(history, stresses, folder, outputs)
