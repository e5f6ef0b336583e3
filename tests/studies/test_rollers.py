"""Studies of rolling propel: passes and digging, lives of a duty, and a sweep over top plates."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import CaseFile, FatigueMaterial, History, LoadCycle, Phase, Shoe, StepProfile, read_duty
from exudyn_crawler.model.flexible_shoes import check_shoe
from exudyn_crawler.results.checks.cases import LEVELS, ShoeOutline, ready_cases
from exudyn_crawler.results.life.duty_runs import check_cases_of
from exudyn_crawler.sweep.running import run_sweep
from meshes import mesh_named, shoe_path
from meshes.rails import rail_outline
from studies import life as life_study, rollers
from studies.plate_sweep import FLEXIBLE, lives_figure, passing_case, plate_sweep


@pytest.fixture(scope="module")
def coarse():
    return rollers.study_cases("coarse")


def test_pass_begins_behind_the_flexible_shoes_and_ends_beyond_them(coarse):
    whole = coarse["pass"]
    case, frame = whole.case, whole.case.gear
    places = case.track.first_com[0] + (np.array(rollers.FLEXIBLE) - 1) * case.track.pitch
    rails = case.shoe.rails
    assert frame.start + frame.rollers[-1] < places[0] + rails.rear
    assert frame.start + case.drive.travel(whole.duration) + frame.rollers[0] > places[-1] + rails.front


@pytest.mark.parametrize(("name", "lower"), [*zip(rollers.OVERHANG, (0.0, 0.025), strict=True)])
def test_machine_passes_and_digs_over_shoes_whose_rails_overhang(name, lower, coarse):
    assert [own for own in coarse if own.split(" ", 1)[1:] == [name]] == [f"pass {name}"]
    ready, case = coarse["pass"].case, coarse[f"pass {name}"].case
    assert case.shoe.rails.height == pytest.approx(ready.shoe.rails.height - lower, abs=1e-6)
    assert 0.9 < case.shoe.mass / ready.shoe.mass < 0.95
    check_shoe(case)
    # wherever it stands, some of its rollers are above flexible shoes, all of them on one of its stands
    middles = case.track.first_com[0] + (np.array(rollers.FLEXIBLE) - 1) * case.track.pitch
    above = []
    for part in rollers.STANDS:
        frame = coarse[f"loading {name} {part}"].case.gear
        under = frame.start + np.array(frame.rollers)
        low, high = middles[0] - 0.5 * case.track.pitch, middles[-1] + 0.5 * case.track.pitch
        above.append((under > low) & (under < high))
    assert np.any(above, axis=0).all()
    assert np.sum(above, axis=1).min() >= 2


def test_machine_digs_above_the_flexible_shoes(coarse):
    case = coarse["loading"].case
    middle = case.track.first_com[0] + (np.mean(rollers.FLEXIBLE) - 1) * case.track.pitch
    assert case.gear.start == pytest.approx(middle, abs=0.1)
    assert case.machine.phases[0].end == 0.0


def test_open_choices_differ_from_what_is_chosen_by_one_thing():
    cases = rollers.choices()
    for name in (rollers.FIRM_SPRINGS, rollers.FIRM_CONTACT):
        assert cases.pop(name).gear == cases["as it is"].gear
    chosen = cases.pop("as it is").gear.model_dump()
    for name, case in cases.items():
        changed = [key for key, value in case.gear.model_dump().items() if value != chosen[key]]
        assert len(changed) == 1, name


@pytest.mark.slow
@pytest.mark.simulation
def test_reduced_study_finds_stresses_in_all_regions():
    runs, regions = rollers.study(None, "coarse", duration=0.3, progress=False)
    assert list(runs) == ["pass", "loading", "dragged", *rollers.overhang_cases()]
    assert set(regions["region"]) == {"roller path", "notches", "lugs", "web", "wings"}
    assert (regions["von Mises in MPa"] > 0.0).all()
    assert regions.filter(like="contribution of ").sum(axis=1).to_numpy() == pytest.approx(1.0, abs=1e-9)
    share = regions.set_index("case")["contribution of rollers"]
    assert (share["dragged"] == 0.0).all()
    assert (share["pass"] == 0.0).all()  # they have not reached the flexible shoes
    assert share["loading"].abs().max() > 0.1
    highest = rollers.highest_by_region(runs["loading"])
    assert highest["node"].tolist() == regions.query("case == 'loading'")["node"].tolist()


@pytest.fixture
def stress_of_a_moment(history, tmp_path):
    """Folder as the stress study leaves it, of a propel of 0.03 s and as much digging."""
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
        assert dataset.part.values.tolist() == ["dragged propel: propel", "dig cycle: dig", "between runs"]
    assert (out / "dragged_a36" / "life.html").is_file()
    assert len(pd.read_csv(out / "summary.csv")) == 1
    with pytest.raises(FileExistsError, match="exists"):
        life_study.study(out, stress_of_a_moment)


def test_rolled_runs_are_those_of_the_rollers_study(tmp_path):
    duty = life_study.digging_duty("rolled", tmp_path / "pass", tmp_path / "loading", FatigueMaterial.a36())
    folders = [Path(run.folder) for run in duty.runs]
    assert {folder.name for folder in folders} < set(rollers.study_cases("coarse"))
    assert {folder.parent for folder in folders} == {tmp_path}
    wears = life_study.overhang_duty(tmp_path, FatigueMaterial.a36())
    assert [Path(run.folder).name for run in wears.runs] == [*rollers.overhang_cases()]
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
    assert set(check_cases_of(duty)) <= {f"{name}, {level.name}" for name in names for level in LEVELS}


def test_machine_rolls_by_the_distance_of_two_rollers_over_the_flexible_shoe():
    whole = passing_case()
    case, frame = whole.case, whole.case.gear
    begin = case.drive.speed.times[-1]
    way = case.drive.travel(whole.duration) - case.drive.travel(begin)
    assert way == pytest.approx(np.diff(frame.rollers)[0])
    place = case.track.first_com[0] + (FLEXIBLE - 1) * case.track.pitch
    for time in (begin, whole.duration):
        rollers = frame.start + case.drive.travel(time) + np.array(frame.rollers)
        # two rollers and more before and behind it: no end of the machine passes
        assert (rollers < place).sum() >= 2
        assert (rollers > place).sum() >= 2


@pytest.mark.simulation
def test_rigid_shoes_of_a_top_plate_weigh_what_its_mesh_does():
    path = shoe_path("coarse")
    sweep = plate_sweep({0.042: path}, (1e7, 2e7))
    assert sweep.table()["top_plate"].tolist() == [0.042, 0.042]
    case = sweep.case_of(sweep.rows[1])[0].case
    own = Shoe.from_mesh(str(path))
    assert case.flexible.mesh == str(path)
    assert (case.shoe.mass, case.shoe.inertia) == (own.mass, own.inertia)
    assert case.shoe.rails == sweep.case.case.shoe.rails
    assert case.terrain.spring_stiffness == 2e7
    assert sweep.units()["life_of_roller_path"] == "h"


def test_picture_has_a_curve_a_top_plate_for_both_lives():
    axes = {"top_plate": [0.03, 0.042, 0.054], "spring_stiffness": [1e7, 2e7]}
    lives = xr.DataArray(np.geomspace(1e6, 1e8, 6).reshape(3, 2), coords=axes)
    figure = lives_figure(xr.Dataset({"life_of_roller_path": lives, "life_of_shoe": 0.1 * lives}))
    for ax, name in zip(figure.axes, ("roller path", "shoe"), strict=True):
        assert ax.get_title() == f"life of {name}"
        assert [line.get_label() for line in ax.lines] == [f"top plate {one} mm" for one in (30, 42, 54)]
        np.testing.assert_allclose(ax.lines[0].get_xdata(), [10.0, 20.0])


@pytest.mark.slow
def test_reduced_sweep_has_lives_and_stresses(tmp_path):
    quick = passing_case().case.with_({"drive.speed": StepProfile(times=(0.0, 0.1), values=(0.0, 0.1))})
    sweep = plate_sweep({0.042: shoe_path("coarse")}, (2e7,), CaseFile(case=quick, duration=0.6))
    run = run_sweep(sweep, tmp_path, workers=1, progress=False)
    assert run.table["status"].tolist() == ["done"]
    found = run.table.iloc[0]
    assert found["life_of_shoe"] <= found["life_of_roller_path"]
    assert found["highest_stress"] > 1e6
    assert found["peak_pin_force"] > 1e4
