"""Measured series beside runs: what is made of a run comes back with the errors that were put in."""

import numpy as np
import pytest

from exudyn_crawler.errors import ImplausibleWarning
from exudyn_crawler.results.measured import series

FACTOR, OFFSET, SHIFT = 1.25, 3.0, 0.02


@pytest.fixture(scope="module")
def pull(rolled):
    """Times (s), distance (m) and pull (kN) of the run."""
    distance = rolled.side_frame_position.sel(axis="x").values
    return rolled.time.values, distance - distance[0], 1e-3 * rolled.drive_pull.values


def write(path, head, *columns):
    rows = zip(*columns, strict=True)
    path.write_text("\n".join([head, *(",".join(f"{value:.12g}" for value in row) for row in rows)]))
    return path


def test_shift_bias_and_peaks_come_back(rolled, pull, tmp_path):
    time, _, force = pull
    wanted = (force[5:-5] - OFFSET) / FACTOR
    path = write(tmp_path / "a.csv", "time in ms,drive_pull in kN", 1e3 * (time[5:-5] - SHIFT), wanted)
    (beside,) = series.compare(rolled, path, SHIFT)
    assert beside.run == pytest.approx(force[5:-5], rel=1e-6)
    assert beside.bias == pytest.approx(np.mean(force[5:-5] - wanted), rel=1e-6)
    assert beside.rms == pytest.approx(np.sqrt(np.mean((force[5:-5] - wanted) ** 2)), rel=1e-6)
    assert beside.peak_ratio(True) == pytest.approx(force[5:-5].max() / wanted.max(), rel=1e-6)


def test_series_over_the_distance(rolled, pull, tmp_path):
    _, distance, force = pull
    path = write(tmp_path / "a.csv", "distance [mm],drive_pull [N]", 1e3 * distance[10:], 1e3 * force[10:])
    (beside,) = series.compare(rolled, path)
    assert beside.rms < 1e-3 * np.abs(force).max()
    assert beside.bias == pytest.approx(0.0, abs=1e-3 * np.abs(force).max())


def test_columns_say_which_axis_link_or_wheel(rolled):
    assert series.chosen(rolled, "side_frame_displacement x").dims == ("time",)
    force = series.chosen(rolled, "joint_force 3 z")
    assert force.values.tolist() == rolled.joint_force.sel(joint=3, axis="z").values.tolist()
    on_rail = series.chosen(rolled, "roller_force 2 right y")
    assert (
        on_rail.values.tolist() == rolled.roller_force.sel(roller=2, rail="right", axis="y").values.tolist()
    )


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ("side_frame_displacement in m", "must name its axis: x, y, z"),
        ("drive_pul in N", "the nearest is 'drive_pull'"),
        ("drive_pull in m", r"column 'drive_pull': unit must be one of N, got 'm'"),
        ("drive_pull x in N", "drive_pull has no 'x'"),
        ("cell_sinkage in m", "cell_sinkage"),
    ],
)
def test_series_that_the_run_does_not_have_are_refused(rolled, tmp_path, head, words):
    path = write(tmp_path / "a.csv", f"time in s,{head}", np.linspace(0.0, 0.1, 5), np.ones(5))
    with pytest.raises(ValueError, match=words):
        series.compare(rolled, path)


def test_a_channel_may_have_values_at_some_times_alone(rolled, pull, tmp_path):
    time, _, force = pull
    slow = [f"{value:.12g}" if k % 5 == 0 else ("", "NaN")[k % 2] for k, value in enumerate(force)]
    rows = [f"{at:.12g},{value:.12g},{gap}" for at, value, gap in zip(time, force, slow, strict=True)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["time in s,drive_pull in kN,drive_pull in kN", *rows]))
    fast, gapped = series.compare(rolled, path)
    assert len(fast.place) == len(time)
    assert gapped.measured == pytest.approx(force[::5])
    assert gapped.rms < 1e-6
    path.write_text("\n".join(["time in s,drive_pull in kN", *(f"{at:.12g}," for at in time)]))
    with pytest.raises(ValueError, match=r"0 points of 'drive_pull' are within the run.*: time has none"):
        series.compare(rolled, path)


def test_heads_are_read_as_programs_write_them_or_told_how(rolled, pull, tmp_path):
    time, _, force = pull
    rows = [f"{k},{at:.12g},{value:.12g}" for k, (at, value) in enumerate(zip(time, force, strict=True))]
    path = tmp_path / "a.csv"
    for heads in (["index,Time_s_,drive_pull_kN_"], [",Time,drive_pull", ",s,kN"]):
        path.write_text("\n".join([*heads, *rows]))
        (beside,) = series.compare(rolled, path)
        assert beside.rms < 1e-6
    path.write_text("\n".join([",time,drive_pull", *rows]))
    with pytest.raises(
        ValueError, match="column 'time': the unit is missing in its head, such as 'time in s' or"
    ):
        series.compare(rolled, path)


def test_a_turned_sign_is_asked_about(rolled, pull, tmp_path):
    time, _, force = pull
    path = write(tmp_path / "a.csv", "time in s,drive_pull in kN", time, -force)
    with pytest.warns(
        ImplausibleWarning, match=r"a\.csv: drive_pull: measured from .*: is its sign turned\?"
    ):
        series.compare(rolled, path)


def test_series_beyond_the_run_are_refused(rolled, tmp_path):
    path = write(tmp_path / "a.csv", "time in s,drive_pull in N", np.linspace(7.0, 9.0, 5), np.ones(5))
    with pytest.raises(
        ValueError, match="0 points of 'drive_pull' are within the run, at least 3 must be: time is 7 to 9 s"
    ):
        series.compare(rolled, path)
    path = write(tmp_path / "a.csv", "drive_pull in N,time in s", np.ones(5), np.ones(5))
    with pytest.raises(ValueError, match="first column 'time in s' or 'distance in m'"):
        series.compare(rolled, path)


@pytest.mark.parametrize(
    ("head", "places", "told"),
    [
        ("time in s", [0.0, 0.02, -0.04, 0.06], "time in s must rise .*, got 0.02 in row 2 .* then -0.04"),
        ("time in s", [0.0, 6.0, 0.04, 0.06], "time in s must rise from row to row, got 6 in row 2"),
        (
            "distance in mm",
            [9.0, 8.0, 8.0, 8.5, 7.0],
            "distance in mm must fall .*, got 8 in row 3 .* then 8.5",
        ),
    ],
)
def test_places_of_a_series_go_one_way(rolled, tmp_path, head, places, told):
    path = write(tmp_path / "a.csv", f"{head},drive_pull in N", np.array(places), np.ones(len(places)))
    with pytest.raises(ValueError, match=told):
        series.compare(rolled, path)


def test_the_command_compares_a_run_with_a_table(rolled, pull, told, refused, tmp_path):
    time, _, force = pull
    (tmp_path / "run").mkdir()
    rolled.save(tmp_path / "run" / "history.nc")
    write(
        tmp_path / "lab.csv",
        "time in s,drive_pull in kN,side_frame_displacement x in mm",
        time,
        force,
        0.0 * force,
    )
    out = told("compare", "run", "lab.csv", "--shift", "0.01")
    assert "lab.csv, shifted by 0.01 s, beside run" in out
    assert "rms difference" in (tmp_path / "run_lab.csv").read_text()
    assert (tmp_path / "run_lab.png").stat().st_size > 1000
    assert "--shift must go with measured series" in refused("compare", "run", "run", "--shift", "0.01")
