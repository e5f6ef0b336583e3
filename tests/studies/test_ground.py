"""Grounds of cells that the machine rolls over: every one carries it, and the harder ones tilt shoes less."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import simulate
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from studies.ground import AGAIN, PAPERS, SOFT, covered, kept_work, row, study_cases
from tests.rolled import small_case

CASES = {name: one.case.with_(flexible=None) for name, one in study_cases(duration=1.0).items()}


def test_grounds_differ_in_nothing_but_the_ground():
    papers = CASES[PAPERS]
    for name, case in CASES.items():
        assert case.with_(name=PAPERS, terrain=papers.terrain, contact=papers.contact) == papers, name


def test_work_that_cells_keep_is_the_area_of_a_loop_of_loading_and_unloading():
    case, deepest = CASES["LETE sand"], 0.03
    depths = np.concatenate((np.linspace(0.0, deepest, 2001), np.linspace(deepest, 0.0, 2001)))
    pressure, _ = case.contact.law.drive(depths, np.zeros_like(depths), case.shoe.length)
    cells = [xr.DataArray(np.full(3, one)) for one in (deepest, pressure.max())]
    loop = case.terrain.cell**2 * np.trapezoid(pressure, depths)
    # the curve begins with a parabola over 1 mm
    for share, count in ((1.0, 3.0), (np.array([1.0, 0.5, 0.1]), 1.6)):
        assert kept_work(SimpleNamespace(case=case), *cells, share) == pytest.approx(count * loop, rel=2e-3)


@pytest.mark.simulation
def test_work_is_kept_on_the_covered_part_of_cells_and_not_in_gaps_and_beside_edges():
    history = simulate(small_case().on_cells(BekkerSoil.lete_sand()), 0.05, False)
    share, shoe, cell = covered(history), history.case.shoe, history.case.terrain.cell
    area = history.case.track.shoe_count * shoe.length * shoe.width
    assert share.sum() * cell**2 == pytest.approx(area, rel=0.01)
    assert share.min() >= 0.0
    assert share.max() < 1.0 + 1e-9
    assert area < 0.96 * share.size * cell**2


def test_second_passes_start_in_the_ruts_of_the_first(tmp_path):
    cases = study_cases(duration=1.0, out=tmp_path)
    assert {name for name in cases if AGAIN in name} == {f"{name}, {AGAIN}" for name in ("LETE sand", SOFT)}
    for name in ("LETE sand", SOFT):
        again = cases[f"{name}, {AGAIN}"].case
        assert again.terrain.ruts == tmp_path / name / "history.nc"
        assert again.with_({"name": name, "terrain.ruts": None}) == cases[name].case
    assert not [name for name in CASES if AGAIN in name]


@pytest.mark.simulation
@pytest.mark.parametrize("name", [name for name in CASES if name != PAPERS])
def test_every_ground_carries_the_machine(name):
    case = CASES[name]
    history = simulate(case, 0.05, False)
    carried = (history.normal_force + history.friction_force).sum("contact").values[:, 2]
    frame, shoes = case.undercarriage, case.track.shoe_count
    weight = (frame.mass + shoes * case.shoe.mass) * case.gravity
    # what is still falling into its place takes less than a hundredth
    np.testing.assert_allclose(carried, weight, rtol=0.01)
    assert row(type("Run", (), {"history": history}))["greatest tilt of a shoe in mrad"] < 300.0
