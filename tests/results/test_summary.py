"""The numbers that are asked for first, and bouncing where the contact forces' spectrum shows it."""

import numpy as np
import pytest

from exudyn_crawler import History
from exudyn_crawler.results.history.summary import bouncing, key_results


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
    assert found.loc["deepest penetration", "value"] == pytest.approx(
        1e3 * float(translation.penetration.max())
    )
    assert found.loc["way", "value"] == pytest.approx(
        float(np.linalg.norm(translation.position.values[-1, -1] - translation.position.values[0, -1]))
    )
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
    moved = rolled.side_frame_position.values[[0, -1]]
    assert found.loc["way", "value"] == pytest.approx(np.linalg.norm(moved[1] - moved[0]))
    start, case = found.loc["out of balance at the start"], rolled.case
    shoes = case.shoe.mass * np.linalg.norm(rolled.acceleration.values[0], axis=-1)
    frame = case.undercarriage.mass * np.linalg.norm(rolled.side_frame_acceleration.values[0])
    greatest = {f"shoe {shoes.argmax() + 1}": shoes.max(), "side frame": frame}
    assert start["of"] == max(greatest, key=greatest.get)
    assert 1e3 * start["value"] == pytest.approx(max(greatest.values()))


def shaken(history, forces):
    """History over other times, whose shoes have these vertical contact forces (times,), 2 ms apart."""
    count = len(forces)
    dataset = history.dataset.isel(time=np.zeros(count, dtype=int)).assign_coords(
        time=2e-3 * np.arange(count)
    )
    normal = dataset.normal_force * 0.0
    first = np.unique(dataset.contact_shoe.values, return_index=True)[1]
    normal[:, first, 2] = forces[:, None]
    return History(
        history.case, dataset.assign(normal_force=normal, friction_force=dataset.friction_force * 0.0)
    )


def test_an_oscillation_is_found_with_its_frequency_and_size(translation):
    time = 2e-3 * np.arange(2001)
    found = bouncing(shaken(translation, 4e5 * (1.0 + 0.1 * np.sin(2.0 * np.pi * 8.0 * time))))
    assert found.frequency == pytest.approx(8.0, abs=0.26)
    assert found.size == pytest.approx(0.1 / np.sqrt(2.0), rel=0.05)
    assert found.share > 0.9


def test_noise_slow_loads_and_small_swings_are_not_bouncing(translation):
    time = 2e-3 * np.arange(2001)
    noise = np.random.default_rng(1).normal(size=len(time))
    for swing in (
        0.1 * noise,
        0.3 * np.sin(2.0 * np.pi * 0.5 * time),
        1e-3 * np.sin(2.0 * np.pi * 8.0 * time),
    ):
        assert bouncing(shaken(translation, 4e5 * (1.0 + swing))) is None


def test_a_run_too_short_for_a_spectrum_tells_nothing(translation):
    assert bouncing(translation) is None


@pytest.mark.simulation
def test_a_driven_track_begins_to_bounce(longer):
    found = bouncing(longer)
    assert 4.0 < found.frequency < 10.0
