"""Grounds of cells that the machine rolls over: every one carries it, and the harder ones tilt shoes less."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import Case, CaseFile, simulate
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from studies.ground import (
    AGAIN,
    PAPERS,
    SOFT,
    covered,
    kept_work,
    power_cases,
    power_study,
    powers_over_way,
    row,
    study_cases,
    work_balance,
)
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


@pytest.fixture(scope="module")
def over_sand():
    return simulate(small_case().on_cells(BekkerSoil.lete_sand()), 0.3, False)


@pytest.mark.simulation
def test_what_pull_sinking_and_chain_give_the_ground_takes(over_sand):
    kilonewtons = list(powers_over_way(over_sand).values())
    given, taken, left = sum(kilonewtons[:4]), sum(kilonewtons[4:7]), kilonewtons[7]
    assert given > 100.0
    assert given == pytest.approx(taken + left, rel=1e-12)
    assert abs(left) < 5e-4 * given
    assert kilonewtons[:2] == pytest.approx(list(work_balance(over_sand).values())[:2], rel=1e-3)


def test_cases_of_powers_have_rigid_shoes_and_differ_in_their_soil(tmp_path):
    cases = power_cases(out=tmp_path)
    first, again = (cases[name] for name in ("LETE sand", f"LETE sand, {AGAIN}"))
    assert again.case.terrain.ruts == tmp_path / first.case.name / "history.nc"
    assert again.case.with_({"name": "LETE sand", "terrain.ruts": None}) == first.case
    assert [one.duration for one in cases.values()] == [60.0, 60.0, 30.0, *5 * [20.0]]
    assert first.case.with_(name="LETE sand") == CASES["LETE sand"]
    for name in set(cases) - {"LETE sand", f"LETE sand, {AGAIN}"}:
        law = cases[name].case.contact.law
        assert cases[name].case == Case.rolled().on_cells(law).with_(name=name)


@pytest.mark.simulation
def test_the_table_of_powers_has_a_row_a_case(monkeypatch, tmp_path, over_sand):
    case = CaseFile(case=over_sand.case, duration=0.05)
    monkeypatch.setattr("studies.ground.power_cases", lambda *_: {"here": case, "there": case})
    table = power_study()
    assert list(table["ground"]) == ["here", "there"]
    run = replace(over_sand, dataset=over_sand.dataset.sel(time=slice(0.0, 0.0501)))
    assert table["taken by shear in kN"][0] == pytest.approx(powers_over_way(run)["taken by shear in kN"])
