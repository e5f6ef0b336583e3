"""Peaks and extremes of recovered histories against brute force."""

import numpy as np
import pytest

import fem
from fem.stress import CRITERIA, evaluate


@pytest.mark.parametrize("criterion", CRITERIA)
def test_peaks_against_brute_force(
    small: fem.ReducedBody, history: np.ndarray, criterion: fem.stress.Criterion
) -> None:
    values = evaluate(criterion, small.stress(history))
    least = criterion == "least principal"
    at = values.argmin(axis=0) if least else values.argmax(axis=0)
    blocks = iter([history[:100], history[100:101], history[101:]])
    for q in (history, blocks):
        peaks = fem.recover_peaks(small.stress_modes, q, criterion)
        np.testing.assert_array_equal(peaks.time_indices, at)
        expected = np.take_along_axis(values, at[None], axis=0)[0]
        np.testing.assert_allclose(peaks.values, expected, rtol=1e-9)


def test_a_peak_splits_into_the_shares_of_its_modes(small: fem.ReducedBody, history: np.ndarray) -> None:
    whole = small.von_mises(history[5], np.array([17]))[0, 0]
    parts = fem.shares(small.stress_modes, history[5], 17)
    assert parts.shape == (26,)
    assert parts.sum() == pytest.approx(whole, rel=1e-9)
    # a mode's share is how the whole grows with it
    more = small.von_mises(history[5] * (1.0 + 1e-6 * np.eye(26)), np.array([17]))[:, 0]
    np.testing.assert_allclose((more - whole) / 1e-6, parts, atol=1e-4 * np.abs(parts).max())


def test_unknown_criterion(small: fem.ReducedBody, history: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"criterion must be one of .* got 'tresca'"):
        fem.recover_peaks(small.stress_modes, history, "tresca")  # type: ignore[arg-type]
