"""A short run repeated into its folder, and what a life over it makes of that."""

import json

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import Case, CaseFile, Duty, FatigueMaterial, History, SphereContact, life, read_case
from exudyn_crawler.case_run import run_case
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import relative_spread
from exudyn_crawler.spread_run import NUDGE, ONE_TIME, laws_beside, nudged, spread

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of a run with one flexible shoe."""
    case = Case.stress("coarse").with_({"flexible.shoes": (13,)})
    out = tmp_path_factory.mktemp("runs") / "run"
    run_case(CaseFile(case=case, duration=0.02, outputs=ONE_TIME), out, progress=False)
    return out


@pytest.fixture(scope="module")
def found(folder):
    return spread(folder, 2, progress=False)


@pytest.mark.slow
def test_runs_start_a_nudge_apart_and_have_the_other_law(folder, found):
    first = read_case(folder / "case.toml").case
    second = read_case(folder / "spread" / "start_2" / "case.toml").case
    assert second.terrain.origin[0] - first.terrain.origin[0] == pytest.approx(NUDGE, rel=1e-3)
    assert second == nudged(first, 1)
    assert read_case(folder / "spread" / "law_by_area" / "case.toml").case.contact.sharing == "area"
    folders = (folder, folder / "spread" / "start_2")
    moved = [History.load(one / "history.nc").position.values for one in folders]
    assert 0.0 < np.abs(moved[0] - moved[1]).max() < 1e-6
    # before any slip the start matters little, the law does at once
    assert found.by_shoe()["spread in %"][0] < 0.1
    assert found.by_shoe()["choice in %"][0] > 0.1


@pytest.mark.slow
def test_what_is_found_is_kept_and_taken_again(folder, found):
    with xr.open_dataset(folder / "spread" / "spread.nc", engine="h5netcdf") as saved:
        assert saved.peak_choice.values == pytest.approx(found.dataset.peak_choice.values)
    assert (folder / "spread" / "hot_spots_shoe_13.csv").is_file()
    with pytest.raises(FileExistsError, match=r"spread\.nc exists"):
        spread(folder, 2)
    record = folder / "spread" / "start_2" / "run.json"
    started = json.loads(record.read_text())["started"]
    again = spread(folder, 2, overwrite=True, progress=False)
    assert json.loads(record.read_text())["started"] == started
    assert again.dataset.run_peak.values == pytest.approx(found.dataset.run_peak.values)


@pytest.mark.slow
def test_a_life_takes_the_spread_beside_its_runs(folder, found, tmp_path):
    material = FatigueMaterial.a36().with_(fatigue_strength=90e6)
    run = DutyRun(name="propel", folder=str(folder), share=0.1)
    duty = Duty(runs=(run,), material=material, plane_nodes=0)
    wide = life(duty).dataset.stress_error
    (folder / "spread" / "spread.nc").rename(tmp_path / "spread.nc")
    narrow = life(duty).dataset.stress_error
    more = relative_spread(found.dataset).sel(shoe=13)
    known = narrow.notnull().values
    assert (wide - narrow).values[known] == pytest.approx(more.values[known], abs=1e-9)
    with xr.open_dataset(tmp_path / "spread.nc", engine="h5netcdf") as saved:
        saved.assign_attrs(case="{}").to_netcdf(folder / "spread" / "spread.nc", engine="h5netcdf")
    with pytest.raises(ValueError, match="comes from another case than the run beside it"):
        life(duty)


def test_the_command_refuses_what_cannot_be_repeated(folder, call, tmp_path):
    for words, told in (
        ((tmp_path / "none",), "no folder"),
        ((folder, "--starts", "0"), "starts must be at least 1, got 0"),
        ((folder, "--starts", "1", "--no-laws"), "starts must be at least 2, got 1"),
    ):
        code, _, err = call("spread", *words)
        assert code == 2
        assert told in err


def test_laws_that_could_stand_for_the_same_ground():
    case = Case.stress("coarse")
    by_area = laws_beside(case)["law by area"]
    assert list(laws_beside(by_area)) == ["law by pair"]
    assert laws_beside(by_area)["law by pair"] == case
    assert laws_beside(case.with_(flexible=None, contact=SphereContact.oil_sand())) == {}
    assert laws_beside(Case.rolled()) == {}
