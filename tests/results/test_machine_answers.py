"""Answers on a machine in the words of undercarriages, against its history and statics."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import History, simulate
from exudyn_crawler.assessment.run_forces import forces_of_run
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.results.history.catalogue import rotation_matrices
from exudyn_crawler.results.history.machine import machine_answers, together
from exudyn_crawler.results.history.side_frame import pins_in_frame
from exudyn_crawler.results.history.tension import hanging_chains
from exudyn_crawler.results.wear.work import run_work

SHEET = Datasheet(
    operating_weight=35371.0,
    gauge=2.59,
    length_on_ground=4.03,
    crawler_length=4.955,
    shoe_width=0.8,
    shoes=48,
)


@pytest.fixture(scope="module")
def history():
    """Begin of a run of an excavator."""
    return simulate(derived(SHEET).case, 0.06, progress=False)


def test_answers_are_those_of_the_history_and_of_statics(history):
    table = machine_answers(history)
    values = table.groupby("result").value.first()
    data = history.dataset
    static = history.of_track("right").quantity("link_tension").isel(time=0)
    assert values["static tension, mean"] == pytest.approx(float(static.mean()) / 1e3)
    assert values["tension of the slack run"] <= values["tension of the taut run"]
    late = data.isel(time=data.time >= 0.5 * history.duration)
    rollers = [name for name in data.wheel.values if "roller" in name]
    force = np.linalg.norm(
        late.wheel_force.sel(wheel=rollers).transpose("time", "wheel", "axis").values, axis=-1
    )
    assert values["load of a lower roller, mean"] == pytest.approx(force.mean() / 1e3)
    # rollers carry all but the shoes below them: parts, sprockets and the upper run
    carried = values["load of a lower roller, mean"] * len(rollers)
    weight = 9.81e-3 * sum(part.mass for part in history.case.gear.frame_parts)
    assert weight < carried < 9.81e-3 * SHEET.operating_weight
    torque, power = values["torque of the drive, mean"], values["power of the drive, mean"]
    right = late.tumbler_speed.transpose("time", ...).values[:, 0]
    assert min(right) <= power / torque <= max(right)
    assert values["pressure below loaded shoes, mean"] <= values["pressure below a shoe, greatest"]


def yawed(history, angle):
    """History turned about the vertical, on the level and with ground that looks alike from all sides."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    angles = ("angles", "side_frame_angles")
    vectors = ("position", "joint_force", "wheel_force", "normal_force", "friction_force")
    data = history.dataset
    changed = {name: data[name].transpose(..., "axis") for name in (*vectors, "side_frame_position")}
    changed = {name: values.copy(data=values.values @ turn.T) for name, values in changed.items()}
    changed |= {name: data[name] + xr.DataArray([0.0, 0.0, angle], {"axis": data.axis}) for name in angles}
    return History(history.case, data.assign(changed))


@pytest.mark.parametrize("angle", [0.5, 0.5 * np.pi, np.pi])
def test_answers_do_not_depend_on_the_heading(history, angle):
    turned = yawed(history, angle)
    first, last = (pins_in_frame(of.case, of.dataset) for of in (history, turned))
    np.testing.assert_allclose(last, first, atol=1e-12)
    wanted, found = (forces_of_run(of, "run", 0.0) for of in (history, turned))
    for name, value in wanted._asdict().items():
        if isinstance(value, float | np.ndarray):
            np.testing.assert_allclose(getattr(found, name), value, rtol=1e-9, atol=1e-9, err_msg=name)
    work, other = (run_work(of, 0.02, 20.0) for of in (history, turned))
    assert other.by_tensions == pytest.approx(work.by_tensions, rel=1e-9)
    state, after = (of.dataset.isel(time=-1) for of in (history, turned))
    for chain, same in zip(*(hanging_chains(history.case, one) for one in (state, after)), strict=True):
        assert same == (same.side, *(pytest.approx(value) for value in chain[1:4]), chain.carrier)


def test_tension_at_the_tumbler_is_that_of_the_links_at_its_ends(history):
    """The links beside the tumbler's lowest and highest point, found by hand in the last state."""
    data = history.dataset.isel(time=[-1])
    case = history.case
    turn = rotation_matrices(data.angles.transpose("time", "shoe", "axis").values)[0]
    pins = data.position.transpose("time", "shoe", "axis").values[0] + turn @ [
        case.track.pin_ahead,
        0.0,
        case.track.pin_height,
    ]
    centre = data.tumbler_position.transpose("time", "track", "axis").values[0]
    tension = history.link_tension.transpose("time", "joint").values[-1]
    radius = case.gear.tumbler.radius(case.track.pitch)
    each = len(pins) // 2
    wanted = []
    for track in range(2):
        own = slice(track * each, (track + 1) * each)
        for sign in (-1.0, 1.0):
            end = centre[track] + [0.0, 0.0, sign * radius]
            wanted.append(tension[own][np.linalg.norm((pins[own] - end)[:, ::2], axis=1).argmin()])
    found = forces_of_run(History(case, data), "run", 0.0)
    assert found.taut == pytest.approx(max(wanted))


def test_sides_of_a_machine_stand_together_where_they_agree():
    rows = [
        ("tension of the taut run", 50.0, "kN", "right track"),
        ("torque of the drive, mean", -10.0, "kN m", "right"),
        ("tension of the taut run", 50.4, "kN", "left track"),
        ("torque of the drive, mean", 12.0, "kN m", "left"),
        ("sinkage, greatest", 8.0, "mm", ""),
    ]
    table = together(pd.DataFrame(rows, columns=["result", "value", "unit", "of"]))
    assert [*table.itertuples(index=False, name=None)] == [
        ("tension of the taut run", 50.4, "kN", "both sides, within 1 %"),
        rows[1],
        rows[3],
        rows[4],
    ]
