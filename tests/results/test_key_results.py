"""The numbers that are asked for first."""

import numpy as np
import pytest

from exudyn_crawler.results.key_results import key_results


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


def test_the_highest_stress_comes_first(flexible_run):
    history, stress, _ = flexible_run
    first = key_results(history, stress).iloc[0]
    assert first["result"] == "highest von Mises stress"
    assert first["value"] == pytest.approx(float(stress.highest_von_mises.max()) / 1e6)
    assert first["unit"] == "MPa"
