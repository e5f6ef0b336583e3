"""Answers on a machine in the words of undercarriages, against its history and statics."""

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler import simulate
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.results.history.machine import machine_answers, together

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
