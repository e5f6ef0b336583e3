"""The life study on a short run that is taken for the stress study's cycle."""

from pathlib import Path

import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import FatigueMaterial, History, LoadCycle, read_duty
from exudyn_crawler.case import Phase
from exudyn_crawler.results.checks.cases import LEVELS, ShoeOutline, ready_cases
from exudyn_crawler.results.life.duty_runs import check_cases_of
from meshes import mesh_named
from meshes.rails import rail_outline
from studies import life as life_study
from studies.rollers import overhang_cases, study_cases


@pytest.fixture
def stress_of_a_moment(flexible_run, tmp_path):
    """Folder as the stress study leaves it, of a propel of 0.03 s and as much digging."""
    history = flexible_run[0]
    even = history.case.loads.phases[0].loads
    ends = {"propel": 0.03, "dig": 0.06}
    cycle = LoadCycle(phases=tuple(Phase(name=name, end=end, loads=even) for name, end in ends.items()))
    folder = tmp_path / "stress"
    (folder / "cycle").mkdir(parents=True)
    History(history.case.with_(loads=cycle), history.dataset).save(folder / "cycle" / "history.nc")
    return folder


@pytest.mark.slow
def test_lives_of_materials_stand_side_by_side(stress_of_a_moment, tmp_path, monkeypatch):
    monkeypatch.setattr(life_study, "MATERIALS", (FatigueMaterial.a36,))
    out = tmp_path / "life"
    found, summary = life_study.study(out, stress_of_a_moment)
    assert list(found) == ["dragged_a36"] == summary["propel_and_material"].tolist()
    with xr.open_dataset(out / "dragged_a36" / "life.nc") as dataset:
        parts = dataset.part.values.tolist()
    assert parts == ["dragged propel: propel", "dig cycle: dig", "between runs"]
    assert (out / "dragged_a36" / "life.html").is_file()
    assert len(pd.read_csv(out / "summary.csv")) == 1
    with pytest.raises(FileExistsError, match="exists"):
        life_study.study(out, stress_of_a_moment)


def test_rolled_runs_are_those_of_the_rollers_study(tmp_path):
    duty = life_study.digging_duty("rolled", tmp_path / "pass", tmp_path / "loading", FatigueMaterial.a36())
    folders = [Path(run.folder) for run in duty.runs]
    assert {folder.name for folder in folders} < set(study_cases("coarse"))
    assert {folder.parent for folder in folders} == {tmp_path}
    wears = life_study.overhang_duty(tmp_path, FatigueMaterial.a36())
    assert [Path(run.folder).name for run in wears.runs] == [*overhang_cases()]
    for one in wears.by_stage():
        assert one.runs[0].share == life_study.PROPEL_SHARE
        assert sum(run.an_hour for run in one.runs[1:]) == pytest.approx(life_study.CYCLES_AN_HOUR)
    assert duty.times_an_hour([137.0, 25.0]) == pytest.approx([0.07 * 3600.0 / 137.0, 70.0])


def test_the_ready_duty_has_shoes_that_wear_and_cases_that_there_are():
    duty = read_duty(Path(life_study.__file__).with_name("duty.toml"))
    stages = [mesh_named(one.check) for one in duty.by_stage()]
    heights = [rail_outline(mesh).height for mesh in stages]
    assert [heights[0] - one for one in heights] == pytest.approx([0.0, 0.0125, 0.025], abs=1e-6)
    assert sum(stage.hours for stage in duty.stages) == 25_000.0
    names = {case.name for case in ready_cases(ShoeOutline.of(stages[0]), 1e6)}
    known = {f"{name}, {level.name}" for name in names for level in LEVELS}
    assert set(check_cases_of(duty)) <= known
