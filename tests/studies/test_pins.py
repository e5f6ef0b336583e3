"""Friction of pins in a lap: the path of the pins is that of the chain at any speed, without rattle."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import run_case
from studies.pins import RATTLE, RUNS, START, case_file, densities, lap


def test_runs_cover_whole_pitches_at_constant_speed():
    for run in RUNS.values():
        file = case_file(run)
        speed = file.case.drive.speed
        pitches = (speed.integral(file.duration) - speed.integral(START)) / file.case.track.pitch
        assert speed.value(START) == run.speed
        assert float(pitches) == pytest.approx(5.0)
        assert file.case.track.pin.kind == run.kind


def test_densities_hold_the_mean_square_of_a_series():
    time = np.arange(0.0, 4.0, 0.004)
    wave = 3e3 * np.sin(2.0 * np.pi * 31.25 * time)
    array = xr.DataArray(wave, dims="time", coords={"time": time})
    history = SimpleNamespace(
        time=array.time, drive_moment=array, quantity=lambda _name: array.expand_dims("joint", 1)
    )
    for _, frequency, density in densities(history):
        above = frequency >= RATTLE
        assert density[above].sum() * frequency[1] == pytest.approx(4.5, rel=1e-3)


@pytest.mark.slow
def test_friction_leaves_the_path_of_the_pins_and_takes_the_rattle():
    laps = {
        name: lap(run_case(case_file(RUNS[name]), progress=False).history) for name in RUNS if name != "dry"
    }
    greased, ideal = laps["greased"], laps["ideal"]
    path = greased["whole path in kJ"]
    assert ideal["whole path in kJ"] > 2.0 * path
    # found 0.99 and 1.00 at half and at a sixth of the speed
    for name in ("greased, half speed", "greased, slow"):
        assert laps[name]["whole path in kJ"] == pytest.approx(path, rel=0.05)
    # both tracks; where hinges turn slowly, below rollers, there is not all of the friction
    case = case_file(RUNS["greased"]).case
    length = case.track.shoe_count // 2 * case.track.pitch
    power = 2.0 * 0.12 * path * (case.track.shoe_count // 2) * RUNS["greased"].speed / length
    assert 0.9 * power < greased["pins in kW"] < power
    for name in ("torque in kN m", "tension in kN"):
        rattle = f"{name} above {RATTLE:g} Hz, rms"
        assert greased[rattle] < 0.5 * ideal[rattle]
    # shoes tilt on sand below each roller, not on a hard floor
    assert laps["greased, hard floor"]["lower run in kJ"] < 0.5 * greased["lower run in kJ"]
