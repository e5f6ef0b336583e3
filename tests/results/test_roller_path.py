"""Roller path of check cases and of runs: numbers by hand, every pass counted, stress of the structure."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler import Duty, FatigueMaterial, History
from exudyn_crawler.case import Outputs
from exudyn_crawler.life_run import roller_paths
from exudyn_crawler.results.checks.cases import CheckCase, ShoeCheck, TreadForce
from exudyn_crawler.results.checks.roller_path import MIDDLE, PRESSURE, TYPICAL, hertz_table, roller_path
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.stress.recovery import node_stress
from exudyn_crawler.views.figures import roller_path_figure
from exudyn_crawler.views.outputs import write_tables
from exudyn_crawler.views.pages.report import report_page


def test_treads_of_check_cases_have_the_pressures_of_hand_formulas():
    """p0 = sqrt(q E* / (pi R)), 0.4 m of radius: 528 MPa with 574 kN on 0.18 m, 915 on a third of it."""
    treads = (TreadForce(side="left", force=574e3), TreadForce(side="right", force=574e3, width=0.06))
    cases = [CheckCase(name="one", treads=treads), CheckCase(name="two", treads=treads)]
    found = hertz_table(ShoeCheck(), cases).set_index(["width in m", "tilt in mrad"])
    level = found.xs(0.0, level="tilt in mrad")
    assert level.loc[0.18, PRESSURE] == pytest.approx(528.1, rel=1e-3)
    assert level.loc[0.06, PRESSURE] == pytest.approx(528.1 * 3.0**0.5, rel=1e-3)
    assert level.loc[0.18, "its depth in mm"] == pytest.approx(0.786 * 3.84, rel=0.02)
    assert set(level["path"]) == {"elastic"}
    assert set(found["first case"]) == {"one"}
    of_width = found.loc[0.18]
    assert (np.diff(of_width[PRESSURE]) > 0.0).all()
    assert of_width.loc[1.0, "edge over mean"] > 2.0
    weak = hertz_table(ShoeCheck(material=ShoeCheck().material.a36()), cases)
    assert weak.set_index(["width in m", "tilt in mrad"]).loc[(0.06, 0.0), "path"] == "ratchets"


@pytest.mark.simulation
def test_every_tread_of_a_run_is_counted_by_its_place(rolled):
    table = roller_path(rolled)
    force = np.linalg.norm(rolled.tread_force.values, axis=-1).sum(axis=3)
    assert table["greatest force in kN"].max() <= force.max() / 1e3 * (1.0 + 1e-12)
    assert table[MIDDLE].is_monotonic_increasing
    assert (table[PRESSURE] >= table[TYPICAL] * (1.0 - 1e-12)).all()
    # two rails, three rollers and the shoe behind and ahead of each at most, more while they roll on
    assert table["passes"].min() >= 1
    worst = table.loc[table[PRESSURE].idxmax()]
    frame = rolled.case.undercarriage
    q = worst["greatest force in kN"] * 1e3 * worst["edge over mean"] / frame.tread_width
    modulus = 200e9 / 2.0 / 0.91
    assert worst[PRESSURE] * 1e6 == pytest.approx((q * modulus / np.pi / frame.radius) ** 0.5)
    k = 690e6 / 3.0**0.5
    assert worst["cast NiCrMo to yield"] == pytest.approx(3.106 * k / worst[PRESSURE] / 1e6, rel=5e-3)
    assert worst["cast NiCrMo to shakedown"] == pytest.approx(4.0 * k / worst[PRESSURE] / 1e6, rel=5e-3)
    assert table.filter(like="structure").empty


@pytest.mark.simulation
def test_a_life_shows_the_roller_path_of_its_rolled_runs(rolled):
    run = SimpleNamespace(basis=SimpleNamespace(history=rolled), run=SimpleNamespace(name="propel"))
    duty = Duty(runs=(DutyRun(name="propel", folder=".", share=0.1),), material=FatigueMaterial.a36())
    found = roller_paths(SimpleNamespace(duty=duty, runs=[run]))
    pd.testing.assert_frame_equal(found["propel"], roller_path(rolled, [duty.material]))
    assert "A36 to shakedown" in found["propel"]


@pytest.mark.simulation
def test_blocks_of_a_long_history_make_no_difference(rolled, monkeypatch):
    whole = roller_path(rolled)
    monkeypatch.setattr("exudyn_crawler.files.TIMES_AT_ONCE", 100)
    pd.testing.assert_frame_equal(roller_path(rolled), whole)


@pytest.mark.simulation
def test_stress_of_the_structure_is_that_of_the_node_below_the_tread(bent):
    flexible = bent.case.flexible.with_(static_fields=False)
    bent = History(bent.case.with_(flexible=flexible), bent.dataset)
    table = roller_path(bent)
    assert set(table["shoe"]) <= set(bent.case.flexible.shoes)
    row = table.loc[table[PRESSURE].idxmax()]
    stress = node_stress(bent, int(row["shoe"]), node=int(row["node"])).sel(time=row["time in s"]).stress
    for component, name in (("xx", "along"), ("yy", "across")):
        assert float(stress.sel(component=component)) / 1e6 == pytest.approx(row[f"structure {name} in MPa"])
    assert np.isfinite(table[["structure along in MPa", "structure across in MPa"]]).all(axis=None)
    # what comes and goes lowers no limit that the contact alone has, but for what it adds to the shear
    alone = 4.0 * 690.0 / 3.0**0.5 / table[PRESSURE]
    assert (table["cast NiCrMo to shakedown"] <= alone * (1.0 + 5e-3)).all()


def test_a_track_without_rollers_has_no_roller_path(translation):
    with pytest.raises(ValueError, match="undercarriage"):
        roller_path(translation)


@pytest.mark.simulation
def test_a_rolled_run_leaves_its_roller_path_and_its_page_shows_it(rolled, tmp_path):
    write_tables(rolled, None, tmp_path, Outputs())
    table = pd.read_csv(tmp_path / "roller_path.csv")
    pd.testing.assert_frame_equal(table, roller_path(rolled), check_dtype=False, rtol=1e-8)
    figure = roller_path_figure(table, "rolled")
    (ax,) = figure.axes
    drawn = ax.get_lines()[0].get_ydata()
    np.testing.assert_allclose(drawn, table.loc[table["place"] == "rail", PRESSURE])
    assert sum("shakedown of" in str(line.get_label()) for line in ax.get_lines()) == 3
    rolled.save(tmp_path / "history.nc")
    assert "Roller path" in report_page(tmp_path)
