"""The numbers that are asked for first."""

import numpy as np
import pytest

from exudyn_crawler.results.history.summary import key_results


def test_they_are_those_of_the_history(translation):
    found = key_results(translation).set_index("result")
    speed = np.linalg.norm(translation.velocity.values, axis=-1)
    row = found.loc["greatest speed"]
    assert row["value"] == pytest.approx(speed.max())
    time, shoe = np.unravel_index(speed.argmax(), speed.shape)
    assert row["of"] == f"shoe {shoe + 1}"
    assert row["at"] == pytest.approx(float(translation.time[time]))
    link = found.loc["greatest force of a link"]
    assert link["value"] == pytest.approx(np.linalg.norm(translation.joint_force.values, axis=-1).max() / 1e3)
    assert link["of"].startswith("link ")
    depth = 1e3 * float(translation.penetration.max())
    assert found.loc["deepest penetration", "value"] == pytest.approx(depth)
    begin, end = translation.position.values[[0, -1], -1]
    assert found.loc["way", "value"] == pytest.approx(np.linalg.norm(end - begin))
    assert "highest von Mises stress" not in found.index
    # units that roll push shoes aside, which friction holds only once they slip
    carried = 13 * translation.case.mean_load
    assert 1e3 * found.loc["out of balance at the start", "value"] < 2e-4 * carried


def test_the_highest_stress_comes_first(flexible_run):
    history, stress, _ = flexible_run
    first = key_results(history, stress).iloc[0]
    assert first["result"] == "highest von Mises stress"
    assert first["value"] == pytest.approx(float(stress.highest_von_mises.max()) / 1e6)
    assert first["unit"] == "MPa"


def test_a_rolled_track_is_asked_for_rollers_and_pull(rolled):
    found = key_results(rolled).set_index("result")
    assert "greatest force of the drive" not in found.index
    forces = np.linalg.norm(rolled.roller_force.values, axis=-1)
    row = found.loc["greatest force of a roller on the rails of a side"]
    assert row["value"] == pytest.approx(forces.max() / 1e3)
    _, roller, rail = np.unravel_index(forces.argmax(), forces.shape)
    assert row["of"] == f"roller {roller + 1}, rail {rolled.rail.values[rail]}"
    pull = found.loc["greatest pull of the drive"]
    assert pull["value"] == pytest.approx(float(rolled.drive_pull.max()) / 1e3)
    assert found.loc["way", "of"] == "side frame"
    begin, end = rolled.side_frame_position.values[[0, -1]]
    assert found.loc["way", "value"] == pytest.approx(np.linalg.norm(end - begin))
    start, case = found.loc["out of balance at the start"], rolled.case
    shoes = case.shoe.mass * np.linalg.norm(rolled.acceleration.values[0], axis=-1)
    frame = case.undercarriage.mass * np.linalg.norm(rolled.side_frame_acceleration.values[0])
    greatest = {f"shoe {shoes.argmax() + 1}": shoes.max(), "side frame": frame}
    assert start["of"] == max(greatest, key=greatest.get)
    assert 1e3 * start["value"] == pytest.approx(max(greatest.values()))
