"""Grounds of cells that the machine rolls over: every one carries it, and the harder ones tilt shoes less."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import Case, CaseFile, simulate
from exudyn_crawler.results.life.life import BEYOND
from exudyn_crawler.results.stress.hot_spots import REGIONS
from studies import ground
from studies.ground import AGAIN, PAPERS, SOFT
from studies.running import study_runs

PAGE, ROLLED = (
    (Path(__file__).parents[2] / "docs" / name).read_text(encoding="utf-8")
    for name in ("cells.md", "rolled.md")
)
COLUMNS = {
    "mean pull, kN": "mean pull in kN",
    "greatest tilt, mrad": "greatest tilt of a shoe in mrad",
    "mean sinkage, mm": "mean sinkage in mm",
    "heave, mm": "heave of the frame in mm",
    "greatest force on a rail, kN": "greatest force on a rail in kN",
}
"""Columns of the page's table, and of the study's."""
STRESSED = {"roller path": ["roller path"], "lugs": ["lugs"], "web": ["web", "notches"], "wings": ["wings"]}
"""Columns of the page's table, and regions of the study's of which they have the highest stress."""
CASES = {name: one.case.with_(flexible=None) for name, one in ground.study_cases(duration=1.0).items()}


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
        kept = ground.retained_work(SimpleNamespace(case=case), *cells, share)
        assert kept == pytest.approx(count * loop, rel=2e-3)


def test_work_is_kept_on_the_covered_part_of_cells_and_not_in_gaps_and_beside_edges(over_sand):
    share, case = ground.covered(over_sand), over_sand.case
    area, cell = case.track.shoe_count * case.shoe.length * case.shoe.width, case.terrain.cell
    assert share.sum() * cell**2 == pytest.approx(area, rel=0.01)
    assert share.min() >= 0.0
    assert share.max() < 1.0 + 1e-9
    assert area < 0.96 * share.size * cell**2


def test_second_passes_start_in_the_ruts_of_the_first(tmp_path):
    cases = ground.study_cases(duration=1.0, out=tmp_path)
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
    frame, shoes = case.gear, case.track.shoe_count
    weight = (frame.mass + shoes * case.shoe.mass) * case.gravity
    # what is still falling into its place takes less than a hundredth
    np.testing.assert_allclose(carried, weight, rtol=0.01)
    found = ground.row(SimpleNamespace(history=history))
    assert found["greatest tilt of a shoe in mrad"] < 300.0
    if name == "hard floor":
        assert f"{found['mean sinkage in mm']:.1f}" == printed("mean pull")["mean sinkage, mm"][name]


def printed(head, page=PAGE):
    """Texts of a table of a page, by ground and column; the head is how it begins."""
    lines = page[page.index(f"| ground | {head}") :].split("\n\n")[0].splitlines()
    names, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    return pd.DataFrame(rows, columns=names).set_index("ground")


def test_the_page_has_the_rows_and_columns_of_the_study(tmp_path, over_sand):
    pulls, lives = printed("mean pull"), printed("roller path")
    for table in (pulls, lives):
        assert sorted(table.index) == sorted(ground.study_cases(out=tmp_path))
    assert list(pulls) == [*COLUMNS, *STRESSED]
    assert set(COLUMNS.values()) <= set(ground.row(SimpleNamespace(history=over_sand)))
    assert {one for parts in STRESSED.values() for one in parts} == set(REGIONS) - {"bores"} == set(lives)


@pytest.mark.slow
@pytest.mark.simulation
def test_lives_on_a_floor_are_those_of_the_page(tmp_path):
    """Of the others `make ground` writes the same table."""
    name = "hard floor"
    with study_runs(tmp_path, {name: ground.study_cases()[name]}, progress=False) as runs:
        found = ground.lives_by_region(runs[name]).set_index("region")
    for region, text in printed("roller path").loc[name].items():
        hours = found.loc[region, ["life in h at least", "life in h at most"]]
        for word, life in zip(text.split(" to "), hours, strict=True):
            # the page has two digits
            expected = pytest.approx(life / 1e6, rel=0.06)
            assert word == "beyond 1000" if life >= BEYOND else float(word) == expected, region


def test_what_the_page_says_of_pulls_follows_from_its_table():
    pulls, text = printed("mean pull")["mean pull, kN"].astype(float), " ".join(PAGE.split())
    frame, gravity = CASES[PAPERS].gear, CASES[PAPERS].gravity
    resistance = frame.rolling_resistance * frame.mass * gravity / 1e3
    assert f"the rolling resistance is {resistance:.1f} kN ({frame.rolling_resistance} of" in text
    assert f"weight of {frame.mass * gravity / 1e6:.2f} MN" in text
    assert pulls["hard floor"] == pytest.approx(resistance, abs=1.0)
    back, again = "LETE sand, springs back", f"LETE sand, {AGAIN}"
    for name, words in {
        PAPERS: "The ground adds {} kN on the papers' units",
        "LETE sand": "of the pull; {} kN on LETE sand",
        SOFT: "{} kN at the soft end of oil sand",
        again: "resistance is {} kN in place of 52",
        f"{SOFT}, {AGAIN}": "At the soft end of oil sand it is {} kN in place of 145",
        back: "tenth of the work is lost, takes {} kN",
        f"{SOFT}, springs back": "At the soft end it takes {} kN in place of 145",
    }.items():
        beyond = pulls[name] - resistance
        assert any(words.format(round(beyond + by)) in text for by in (-0.5, 0.5)), words.format(beyond)
    rolled, tilts = printed("greatest tilt", ROLLED), printed("mean pull")["greatest tilt, mrad"]
    for name, (tilt, beyond, _) in rolled.iterrows():
        same = name.replace(" in the same rut", "").replace(" that springs", ", springs")
        assert tilt == tilts[same], name
        assert float(beyond) == pytest.approx(pulls[same] - resistance, abs=0.8), name


@pytest.mark.slow
def test_the_page_has_the_numbers_of_the_whole_study(tmp_path, monkeypatch):
    """Twelve runs of a minute, without their figures: ten minutes."""
    off = dict.fromkeys(("figures", "pictures", "paraview", "tables", "forces", "page"), False)
    whole = ground.study_cases(out=tmp_path)
    cases = {name: one.with_(outputs=one.outputs.with_(**off)) for name, one in whole.items()}
    monkeypatch.setattr("studies.ground.study_cases", lambda *_: cases)
    _, table, regions, _ = ground.study(tmp_path)
    found, page = table.set_index("ground"), printed("mean pull").astype(float)
    stress = regions.pivot(index="ground", columns="region", values="von Mises in MPa")
    for name, texts in page.iterrows():
        values = {column: found.loc[name, key] for column, key in COLUMNS.items()}
        values |= {column: stress.loc[name, parts].max() for column, parts in STRESSED.items()}
        # rollers and shoes strike over ridges: how far starts 1e-10 to 1e-9 m apart go is on the page
        apart = 0.1 if "ridges" in name else 0.01
        for column, value in values.items():
            assert value == pytest.approx(texts[column], rel=apart, abs=0.6), (name, column)


def test_what_pull_sinking_and_chain_give_the_ground_takes(over_sand):
    kilonewtons = list(ground.powers_over_way(over_sand).values())
    given, taken, left = sum(kilonewtons[:4]), sum(kilonewtons[4:7]), kilonewtons[7]
    assert given > 100.0
    assert given == pytest.approx(taken + left, rel=1e-12)
    assert abs(left) < 5e-4 * given
    assert kilonewtons[:2] == pytest.approx(list(ground.work_balance(over_sand).values())[:2], rel=1e-3)


def test_cases_of_powers_have_rigid_shoes_and_differ_in_their_soil(tmp_path):
    cases = ground.power_cases(out=tmp_path)
    first, again = (cases[name] for name in ("LETE sand", f"LETE sand, {AGAIN}"))
    assert again.case.terrain.ruts == tmp_path / first.case.name / "history.nc"
    assert again.case.with_({"name": "LETE sand", "terrain.ruts": None}) == first.case
    assert [one.duration for one in cases.values()] == [60.0, 60.0, 30.0, *5 * [20.0]]
    assert first.case.with_(name="LETE sand") == CASES["LETE sand"]
    for name in set(cases) - {"LETE sand", f"LETE sand, {AGAIN}"}:
        law = cases[name].case.contact.law
        assert cases[name].case == Case.rolled().on_cells(law).with_(name=name)


def test_the_table_of_powers_has_a_row_a_case(monkeypatch, tmp_path, over_sand):
    case = CaseFile(case=over_sand.case, duration=0.05)
    monkeypatch.setattr("studies.ground.power_cases", lambda *_: {"here": case, "there": case})
    table = ground.power_study()
    assert list(table["ground"]) == ["here", "there"]
    run = replace(over_sand, dataset=over_sand.dataset.sel(time=slice(0.0, 0.0501)))
    name = "taken by shear in kN"
    assert table[name][0] == pytest.approx(ground.powers_over_way(run)[name])
