"""Bouncing is told where the contact forces' spectrum shows it, and nowhere else."""

import numpy as np
import pytest

from exudyn_crawler import History
from exudyn_crawler.results.history.summary import bouncing


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
