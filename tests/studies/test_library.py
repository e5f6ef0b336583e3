"""Motion of the library's machines over the commanded one, in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import StepProfile
from exudyn_crawler.case import Drive
from studies.library import case_files, motion

TIME = np.linspace(0.0, 2.0, 201)
RAMP = StepProfile(times=(0.0, 1.0), values=(0.0, 0.5))
REST = StepProfile.constant(0.0)


def moved(drive, way=0.0, yaw=0.0):
    """History of a machine with a way (m) and a yaw (rad) over time, and a tension of 3 kN at most."""
    zero = np.zeros_like(TIME)
    place, angles = ([*columns] for columns in ((way + zero, zero, zero), (zero, zero, yaw + zero)))

    def array(columns):
        return xr.DataArray(np.column_stack(columns), dims=("time", "axis"), coords={"axis": [*"xyz"]})

    return SimpleNamespace(
        case=SimpleNamespace(drive=drive),
        duration=2.0,
        time=xr.DataArray(TIME, dims="time"),
        side_frame_displacement=array(place),
        side_frame_angles=array(angles),
        quantity=lambda _name: xr.DataArray([1e3, 3e3]),
    )


def test_ratios_after_the_start_leave_out_what_was_lost_in_it():
    """Nine tenths of the commanded motion, less 0.1 m or rad that the start took."""
    start = 0.1 * np.minimum(TIME, 1.0)
    commanded = RAMP.integral(TIME)
    straight = moved(Drive(speed=RAMP), way=0.9 * commanded - start)
    turn = moved(Drive(speed=REST, turn_rate=RAMP), yaw=np.angle(np.exp(1j * (0.8 * commanded - start))))
    row = motion(straight, turn)
    assert row["distance in m"] == pytest.approx(0.9 * 0.75 - 0.1)
    assert row["commanded turn in rad"] == pytest.approx(0.75)
    assert row["distance over the commanded after the start"] == pytest.approx(0.9)
    assert row["turn over the commanded after the start"] == pytest.approx(0.8)
    assert row["greatest tension in kN, turn"] == 3.0


def test_unknown_machines_are_refused():
    with pytest.raises(ValueError, match=r"machines must be among cat315c, .*, got tank"):
        case_files(["tank"])
