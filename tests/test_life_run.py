"""Lives over runs, in Python and by the command, and what a run repeated into its folder makes of them."""

import dataclasses
import json

import meshio
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import Case, CaseFile, Duty, History, SphereContact, life, read_case, read_duty
from exudyn_crawler.case_run import run_case
from exudyn_crawler.errors import ImplausibleWarning
from exudyn_crawler.life_run import FILES
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import COARSE, for_reading, life_of, life_words, relative_spread
from exudyn_crawler.spread_run import NUDGE, ONE_TIME, laws_beside, nudged, spread
from exudyn_crawler.views.pages import signed
from exudyn_crawler.views.pages.life import life_lines, life_solid, write_life_page
from exudyn_crawler.views.tables import cell_text
from fem.stress.trust import LIMITED, VERDICTS
from tests.small_shoe import SMALL_SHOE
from tests.stress_results import WEAK

DUTY = """
plane_nodes = 0
survivals = [0.9]

[material]
base = "a36"
fatigue_strength = 90e6

[[runs]]
name = "propel"
folder = "run"
share = 0.1
"""


@pytest.fixture(scope="module")
def pit(history, tmp_path_factory):
    """Folder with a duty file, its run and its life."""
    folder = tmp_path_factory.mktemp("pit")
    (folder / "run").mkdir()
    history.save(folder / "run" / "history.nc")
    (folder / "digging.toml").write_text(DUTY)
    return folder, life(folder / "digging.toml", folder / "life")


def test_everything_is_written_and_agrees(pit):
    folder, found = pit[0] / "life", pit[1]
    assert {path.name for path in folder.iterdir()} == set(FILES)
    with xr.open_dataset(folder / "life.nc", engine="h5netcdf") as saved:
        assert saved.life.values == pytest.approx(found.dataset.life.values, nan_ok=True)
        assert Duty.model_validate_json(saved.attrs["duty"]) == read_duty(pit[0] / "digging.toml")
    fields = meshio.read(folder / "life.vtu").point_data
    assert fields["life in h, 90 % survive"] == pytest.approx(found.dataset.life[0].values, nan_ok=True)
    assert {"damage an hour, place 7", "damage an hour, propel: constant"} <= set(fields)
    table = pd.read_csv(folder / "shortest_lives.csv")
    assert table["node"].tolist() == found.table["node"].tolist()
    first = int(table["node"][0])
    growth = pd.read_csv(folder / "damage_histories.csv").query(f"node == {first}")
    last = growth.groupby(["run", "shoe"])["damage an hour"].last().sum()
    assert last == pytest.approx(float(found.dataset.damage_an_hour[0, first]), rel=1e-3)
    matrices = pd.read_csv(folder / "rainflow_matrices.csv")
    assert set(matrices["node"]) == set(table["node"])
    assert (matrices["cycles an hour"] > 0.0).all()


def test_the_report_to_sign_has_lines_and_lives_of_the_page(pit):
    report = signed.stored(pit[0] / "life")
    assert list(report.lines) == life_lines(pit[1])
    lives = for_reading(pit[1].table)["life in h that 90 % survive"].iloc[0]
    assert report.answers.rows[0][:2] == (pit[1].table["region"].iloc[0], cell_text(lives))
    assert [name.rpartition("/")[2] for name, _ in report.checksums[:2]] == ["digging.toml", "history.nc"]
    assert ("runs[0].share", "0.1") in report.given
    assert 2 <= len(signed.typeset(report, "png")) <= 4


def test_the_page_shows_life_table_and_duty(pit):
    page = (pit[0] / "life" / "life.html").read_text()
    for words in ("Life in 3D", "stays at place 13", "fatigue_strength", "of the machine hours: propel 10 %"):
        assert words in page
    assert "http://" not in page.split("<main>")[0]
    # what is inside a spider is not to be used, and does not stand at the head
    found = pit[1]
    held = found.table.assign(flag=["in spider", *[""] * (len(found.table) - 1)])
    line = life_lines(dataclasses.replace(found, table=held))[0]
    assert f"at the worst node ({held['region'][1]};" in line


def test_hours_on_a_mesh_that_is_too_coarse_are_not_shown_as_hours(pit):
    found = pit[1]
    coarse, good = VERDICTS[LIMITED], "good to 15 %"
    last = "life in h that 90 % survive"
    count = len(found.table)
    usable = found.table.assign(flag="", verdict=[coarse, *[good] * (count - 1)])
    first, second, *_ = usable[last].map(life_words).map(cell_text)
    lines = life_lines(dataclasses.replace(found, table=usable))
    assert lines[0].startswith("no machine hours: the mesh is too coarse at the worst node")
    assert f"shortest life that the mesh resolves: {second} h" in " ".join(lines)
    assert first not in " ".join(lines)
    assert for_reading(usable)[last].tolist()[:2] == [COARSE, life_words(usable[last].iloc[1])]
    solid = life_solid(found)
    used = np.unique(found.dataset.triangle.values)
    limited = found.dataset.verdict.values[used] == LIMITED
    assert limited.any()
    assert np.isnan(solid.colourings[0].values[0, 0][limited]).all()
    # of a mesh that is good everywhere the hours are told
    told = life_lines(dataclasses.replace(found, table=usable.assign(verdict=good)))
    assert told[0].startswith(f"{first} machine hours until a crack")
    assert f"stress {good}" in told[1]


def test_no_name_is_markup_or_script_of_a_lifes_page(pit, history, tmp_path):
    """Names of the duty, of what happens, of phases and of the material are a user's, or from elsewhere."""
    tag = "<img src=x onerror=alert(1)></script><script>alert(2)</script>"
    asked = read_duty(pit[0] / "digging.toml")
    runs = tuple(run.with_(name=tag) for run in asked.runs)
    tagged = asked.with_(name=tag, runs=runs, material=asked.material.with_(name=tag))
    found = life_of(tagged, [history])
    page = write_life_page(found, tmp_path / "life.html", roller_paths={tag: found.table.assign(note=tag)})
    text = page.read_text()
    assert "Life of the shoes: &lt;img src=x" in text
    assert "<img src=x" not in text
    assert "<script>alert" not in text


@pytest.mark.slow
def test_the_command_tells_shortest_lives_and_faults(pit, call, refused, tmp_path):
    code, out, _ = call("life", pit[0] / "digging.toml")
    assert code == 0
    assert "shortest lives by region" in out
    assert (tmp_path / "results" / "digging" / "life.html").is_file()
    assert "life.nc exists; allow overwriting" in refused("life", pit[0] / "digging.toml")
    wrong = pit[0] / "wrong.toml"
    wrong.write_text(DUTY.replace('folder = "run"', 'folder = "rum"'))
    assert "run 'propel': no history at" in refused("life", wrong)
    assert not (tmp_path / "results" / "wrong").exists()


def test_implausible_materials_are_warned_of_before_anything_is_counted(tmp_path):
    (tmp_path / "odd.toml").write_text(DUTY.replace("90e6", "1e6\nslope = 50\nscatter = 10"))
    with (
        pytest.warns(ImplausibleWarning) as caught,
        pytest.raises(FileNotFoundError, match="run 'propel': no history"),
    ):
        life(tmp_path / "odd.toml")
    assert [str(one.message).partition("; ")[0] for one in caught] == [
        "material.slope: 50 is outside of 3 to 15",
        "material.scatter: 10 is outside of 1 to 2",
        "material.fatigue_strength: 1e+06 Pa is outside of 5e+07 to 1e+09 Pa",
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of a run with one flexible shoe."""
    case = Case.stress(SMALL_SHOE).with_({"flexible.shoes": (13,)})
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
    run = DutyRun(name="propel", folder=str(folder), share=0.1)
    duty = Duty(runs=(run,), material=WEAK, plane_nodes=0)
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


@pytest.mark.simulation
def test_the_command_refuses_what_cannot_be_repeated(folder, refused, tmp_path):
    for words, told in (
        ((tmp_path / "none",), "no folder"),
        ((folder, "--starts", "0"), "starts must be at least 1, got 0"),
        ((folder, "--starts", "1", "--no-laws"), "starts must be at least 2, got 1"),
    ):
        assert told in refused("spread", *words)


def test_laws_that_could_stand_for_the_same_ground():
    case = Case.stress(SMALL_SHOE)
    by_area = laws_beside(case)["law by area"]
    assert list(laws_beside(by_area)) == ["law by pair"]
    assert laws_beside(by_area)["law by pair"] == case
    assert laws_beside(case.with_(flexible=None, contact=SphereContact.oil_sand())) == {}
    assert laws_beside(Case.rolled()) == {}
