"""Sweep over top plates: what its runs are, and a reduced one."""

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import CaseFile, Shoe, StepProfile
from exudyn_crawler.sweep.running import run_sweep
from meshes import shoe_path
from studies.plate_sweep import FLEXIBLE, lives_figure, passing_case, plate_sweep


def test_machine_rolls_by_the_distance_of_two_rollers_over_the_flexible_shoe():
    whole = passing_case()
    case, frame = whole.case, whole.case.undercarriage
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
    speed = StepProfile(times=(0.0, 0.1), values=(0.0, 0.1))
    quick = passing_case().case.with_({"drive.speed": speed})
    sweep = plate_sweep({0.042: shoe_path("coarse")}, (2e7,), CaseFile(case=quick, duration=0.6))
    run = run_sweep(sweep, tmp_path, workers=1, progress=False)
    assert run.table["status"].tolist() == ["done"]
    found = run.table.iloc[0]
    assert found["life_of_shoe"] <= found["life_of_roller_path"]
    assert found["highest_stress"] > 1e6
    assert found["peak_pin_force"] > 1e4
