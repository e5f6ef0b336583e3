"""Runs on ground of cells: every output; the ground's map as its memory and the shoes' motion have it."""

import meshio
import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import Case, CaseFile, History, run_case, simulate
from exudyn_crawler.case.parameters.heights import Heights, Ridge
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.machines import Outputs
from exudyn_crawler.results.history.ground_map import ground_map, pressed_depths
from exudyn_crawler.results.history.summary import extremes, key_results
from exudyn_crawler.views.figures import history_series, run_figures
from exudyn_crawler.views.pages.runs import write_comparison
from exudyn_crawler.views.scenes import pictures, track
from exudyn_crawler.views.scenes.films import TrackPicture, ground_scale
from tests.rolled import small_case
from tests.small_shoe import SMALL_SHOE
from tests.views.test_figures import curves

pytestmark = pytest.mark.simulation

RIDGE = Ridge(x=19.0, height=0.05, width=0.2, flank=0.3)
"""Ahead of the track's front shoe, where none stands."""


SAND = BekkerSoil.lete_sand("chrono")
CASES = {
    # the papers' track beside a ridge, whose drive starts at once
    "dragged": lambda: Case.translation().on_cells(SAND, Heights(parts=(RIDGE,))),
    "rolled": lambda: small_case().on_cells(SAND),
    "flexible": lambda: Case.stress(SMALL_SHOE).with_({"flexible.shoes": (7, 13)}).on_cells(SAND),
}


TIMES = (0.0, 0.01)
"""At which the runs keep what cells remember."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What a short run over two flexible shoes leaves, with every output but pictures of shoes."""
    folder = tmp_path_factory.mktemp("cells") / "flexible"
    # curves of one shoe take less time than those of five
    outputs = Outputs(animation=True, pictures=False, ground_times=TIMES, shoes=(7,))
    case = CASES["flexible"]().with_(name="flexible")
    run_case(CaseFile(case=case, duration=0.02, outputs=outputs), folder, progress=False)
    return folder


@pytest.fixture(scope="module")
def histories(folder):
    rigid = {name: CASES[name]().with_(name=name) for name in ("dragged", "rolled")}
    runs = {name: simulate(case, 0.02, False, ground_times=TIMES) for name, case in rigid.items()}
    return runs | {"flexible": History.load(folder / "history.nc")}


def test_a_run_leaves_every_output(folder):
    always = {"case.toml", "run.json", "history.nc", "ground.nc", "ground.png", "track.mp4", "forces.nc"}
    always |= {"ground_at_0_s.png", "ground_at_0.01_s.png", "extremes.csv", "loads.csv"}
    always |= {"sinkage_and_friction_torque.png", "slip_velocity.png", "stress.nc", "track.pvd"}
    assert always <= {path.name for path in folder.iterdir()}
    # no springs are below cells
    assert not (folder / "terrain_deformation.png").exists()


def test_the_file_of_the_map_has_units(folder, histories):
    found = xr.load_dataset(folder / "ground.nc", engine="h5netcdf")
    assert found.equals(ground_map(histories["flexible"], TIMES))
    units = {name: variable.attrs["units"] for name, variable in found.variables.items()}
    assert units == dict.fromkeys(found.variables, "m") | {"time": "s"}
    assert all(found[name].attrs["long_name"] for name in found.data_vars)
    assert found.time.values == pytest.approx(TIMES)


@pytest.mark.parametrize("name", CASES)
def test_the_map_has_what_the_cells_remember(histories, name):
    history = histories[name]
    found = ground_map(history, TIMES)
    for growing in (found.depth.values, found.sinkage_then.values):
        assert (growing[1] >= growing[0]).all()
        assert growing[0].max() > 0.01
    terrain, soil = history.case.terrain, history.case.contact.law
    cell = history.dataset.isel(cell=int(history.cell_sinkage.values.argmax()))
    x, y = ((float(one) + 0.5) * terrain.cell for one in (cell.cell_column, cell.cell_row))
    deepest = found.sel(x=x, y=y, method="nearest")
    assert float(deepest.sinkage) == float(found.sinkage.max()) == float(cell.cell_sinkage)
    # unloading at one modulus; the greatest pressure is Bekker's, of Chrono's LETE sand
    springs_back = float(cell.cell_pressure) / soil.reload_stiffness
    assert float(deepest.rut) == pytest.approx(float(deepest.sinkage) - springs_back, rel=1e-9)
    shorter = history.case.shoe.length
    assert soil.sinkage(float(cell.cell_pressure), shorter) == pytest.approx(float(deepest.sinkage), rel=0.02)


@pytest.mark.parametrize("name", CASES)
def test_cells_at_a_chosen_time_are_those_of_a_run_that_ends_then(histories, name):
    history = histories[name]
    ended = simulate(history.case, 0.01, False)
    then = history.dataset.isel(ground_time=1)
    assert float(then.ground_time) == ended.duration
    pressed = (then.cell_sinkage_then > 0.0).values
    for one in ("sinkage", "pressure"):
        np.testing.assert_array_equal(then[f"cell_{one}_then"][pressed], ended.dataset[f"cell_{one}"])
    # a history whose run was not asked to keep it has the undersides' depth alone
    maps = [(one, ground_map(one, (0.01,))) for one in (ended, history)]
    assert np.isnan(maps[0][1].sinkage_then).all()
    labels = [pictures.map_figure(*one, 0.01).axes[1].get_ylabel() for one in maps]
    assert labels == ["greatest depth so far in mm", "greatest sinkage in mm until then"]


@pytest.mark.parametrize("name", CASES)
def test_undersides_have_been_as_deep_as_cells_remember(histories, name):
    history = histories[name]
    found = ground_map(history)
    rows = np.array([0, history.time.size - 1])
    depth = pressed_depths(history, rows, found.x.values, found.y.values, found.height.values)
    assert (depth[1] >= depth[0]).all()
    below = depth[1] > 0.0
    # all but cells that a shoe covers less than half of
    assert below.mean() > 0.85
    # cells at the edges of tilted shoes are pressed where these cover them, not at their middles
    error = np.abs(depth[1] - found.sinkage.values)[below]
    assert np.median(error) < 2e-5
    assert error.max() < 0.1 * float(found.sinkage.max())


def test_rock_keeps_no_rut():
    case = small_case().on_cells(RockFloor.hard_floor())
    found = ground_map(simulate(case, 4e-3, False, ground_times=(2e-3,)), (2e-3,))
    assert float(found.sinkage_then.max()) > 0.0
    assert float(found.rut_then.max()) == 0.0
    assert 0.0 < float(found.sinkage.max()) < 2e-3
    assert float(found.rut.max()) == 0.0


def test_scenes_show_the_surface_lowered_where_shoes_stand(histories):
    history = histories["dragged"]
    both = track.instants(history, [0.0, history.duration])
    ground = {one.name: one for one in track.track_scene(both, 0.0).solids}["ground"]
    (colouring,) = ground.colourings
    assert colouring.title == "height of the ground in mm"
    heights = ground.points[:, 2] + ground.bend[:, 0, :, 2]
    assert colouring.values[:, 0] == pytest.approx(1e3 * heights)
    assert (heights[1] <= heights[0]).all()
    # the ridge stands ahead of the track, and the middle of a shoe is on the ground that it has pressed in
    assert ground.points[:, 2].max() == pytest.approx(0.05, abs=1e-3)
    middle = history.position.isel(time=-1).sel(shoe=7).values
    nearest = np.abs(ground.points[:, :2] - middle[:2]).sum(axis=1).argmin()
    sinkage = float(history.contacts_by_shoe().penetration.isel(time=-1).sel(shoe=7))
    assert heights[1, nearest] == pytest.approx(-sinkage, rel=0.05)
    now = History(both.case, both.dataset.isel(time=[1]))
    section, rest = (pictures.ground_section(now, at_rest) for at_rest in (False, True))
    assert (section.points[:, 2] <= rest.points[:, 2]).all()
    assert rest.points[:, 2].max() == pytest.approx(0.05, abs=1e-3)


def test_films_figures_and_tables_are_of_cells(histories):
    for history in histories.values():
        picture = TrackPicture(history, ground_scale(history))
        assert picture.image(history.duration).std() > 0.0
        assert "height of the ground in mm" in [ax.get_ylabel() for ax in picture.figure.axes]
        assert "sinkage in m" in curves(run_figures(history, [1])["sinkage and friction torque"])
        assert "total terrain deformation from equilibrium" not in history_series(history)
        drawn = pictures.map_figure(history, ground_map(history))
        assert {one.get_text() for one in drawn.axes[0].texts} == {str(shoe) for shoe in history.shoe.values}
        assert drawn.axes[1].get_ylabel() == "greatest sinkage in mm"
        named = extremes(history).set_index("variable").loc["penetration", "greatest_of"]
        assert named.removeprefix("shoe ").isdigit()
        assert "deepest penetration" in key_results(history).result.values


def test_reports_and_comparisons_are_of_cells(folder, histories, tmp_path):
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert 'alt="greatest sinkage, flexible"' in page
    assert "height of the ground in mm" in page
    two = {name: histories[name] for name in ("dragged", "flexible")}
    assert "<td>penetration</td>" in write_comparison(two, tmp_path / "both.html").read_text(encoding="utf-8")


def test_paraview_has_the_ground_as_a_surface(folder, histories):
    history = histories["flexible"]
    (*_, last) = sorted((folder / "track_parts").glob("terrain_*.vtu"))
    surface = meshio.read(last)
    assert {one.type for one in surface.cells} == {"quad"}
    sinkage, height = surface.point_data["sinkage"], surface.point_data["height"]
    assert height == pytest.approx(surface.points[:, 2])
    assert height == pytest.approx(-sinkage, abs=1e-12)
    assert sinkage.max() == pytest.approx(float(history.cell_sinkage.max()), rel=0.02)
