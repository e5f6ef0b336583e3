"""What a run leaves beside its history: a list of writers, each of which asks the outputs of the case."""

from collections.abc import Callable, Mapping
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from exudyn_crawler.case.files.case_file import Outputs
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


def write_forces(history: History, folder: Path, outputs: Outputs) -> None:
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
    write_netcdf_along("time", history.time.size, chunks, folder / "forces.nc", overwrite=True)


def write_extremes(history: History, folder: Path, outputs: Outputs) -> None:
    """Least and greatest value of every variable."""
    if outputs.tables:
        write_table(extremes(history), folder / "extremes.csv", overwrite=True)


def write_loads(history: History, folder: Path, outputs: Outputs) -> None:
    """Loads on the shoes at the ends of the phases, as far as the run goes."""
    if outputs.tables:
        write_table(load_table(history), folder / "loads.csv", overwrite=True)


def write_curves(history: History, folder: Path, outputs: Outputs) -> None:
    """Motion, contact and joint forces of some shoes and the links behind them; rollers and side frame."""
    if outputs.figures:
        _save(run_figures(history, outputs.drawn_shoes(history.case.track.shoe_count)), folder, outputs)


def write_ground(history: History, folder: Path, outputs: Outputs) -> None:
    """The track on uneven ground at the end of the run, and what the ground carries."""
    terrain = history.case.terrain
    if outputs.figures and not (terrain.heights is None and terrain.profile is None):
        _save({"ground": ground_figure(history, history.duration)}, folder, outputs)


def write_film(history: History, folder: Path, outputs: Outputs) -> None:
    """The track on its deforming terrain."""
    if outputs.animation:
        write_animation(history, folder / "track.mp4", overwrite=True)


def write_stresses(history: History, stresses: StressResults, folder: Path, outputs: Outputs) -> None:
    """Stresses over time, at all nodes and at chosen times."""
    stresses.save(folder / "stress.nc", overwrite=True)


def write_hot_spots(history: History, stresses: StressResults, folder: Path, outputs: Outputs) -> None:
    """Highest stresses of every shoe by phase, by region and over the run, and where they are."""
    if not outputs.tables:
        return
    table = highest_by_phase(history, stresses.dataset)
    write_table(table, folder / "highest_stresses.csv", overwrite=True)
    by_region = region_table(stresses.by_region, stresses.dataset)
    write_table(by_region, folder / "highest_by_region.csv", overwrite=True)
    for shoe, hot_spots in stresses.hot_spots.items():
        write_table(
            hot_spot_table(hot_spots, stresses.dataset), folder / f"hot_spots_shoe_{shoe}.csv", overwrite=True
        )


def write_flexible_shoes(history: History, stresses: StressResults, folder: Path, outputs: Outputs) -> None:
    """Motion, contact, joint forces, modal coordinates and stress of the flexible shoes, a figure each."""
    if outputs.figures:
        figures = stress_figures(history, stresses)
        _save({f"flexible {title}": figure for title, figure in figures.items()}, folder, outputs)


def write_fields(history: History, stresses: StressResults, folder: Path, outputs: Outputs) -> None:
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
        with whole_file(folder / f"fields_shoe_{shoe}.vtu", overwrite=True) as temporary:
            write_vtu(temporary, stresses.whole.mesh, fields)


def write_pictures(history: History, stresses: StressResults, folder: Path, outputs: Outputs) -> None:
    """Pictures of stressed shoes at the chosen times."""
    if outputs.pictures:
        write_stress_pictures(stresses.dataset, history, folder, overwrite=True)


def write_series(history: History, stresses: StressResults, folder: Path, outputs: Outputs) -> None:
    """Whole track with its stressed shoes at the chosen times, for ParaView."""
    if outputs.paraview:
        write_paraview(stresses.dataset, history, folder, overwrite=True)


STRESS_WRITERS: tuple[Callable[[History, StressResults, Path, Outputs], None], ...] = (
    write_stresses,
    write_hot_spots,
    write_flexible_shoes,
    write_fields,
    write_pictures,
    write_series,
)
"""What is written of flexible shoes, in this order."""
WRITERS: tuple[Callable[[History, Path, Outputs], None], ...] = (
    write_forces,
    write_extremes,
    write_loads,
    write_ground,
    write_film,
)
"""What is written of any run, in this order."""
MOST_DRAWN = 5 * 10**8
"""Bytes of a history whose curves are drawn as they are: 70 s of 13 rigid shoes, stored every 2 ms."""


def write_outputs(history: History, stresses: StressResults | None, folder: Path, outputs: Outputs) -> None:
    """Write what derives from a history and its stresses, as far as the outputs ask for it."""
    if stresses is not None:
        for write_stress in STRESS_WRITERS:
            write_stress(history, stresses, folder, outputs)
    for write in WRITERS:
        write(history, folder, outputs)
    # curves of a long run would not fit into memory, and no figure shows them at every step
    write_curves(history.every(-(-history.dataset.nbytes // MOST_DRAWN)), folder, outputs)


def _save(figures: Mapping[str, Figure], folder: Path, outputs: Outputs) -> None:
    """Write figures by their names."""
    for title, figure in figures.items():
        save_figure(figure, folder / f"{title.replace(' ', '_')}.{outputs.figure_format}", overwrite=True)
