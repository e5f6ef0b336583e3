"""Hot spots on a body small enough to check."""

import numpy as np
import pytest

import fem


def test_hot_spots_rank_flag_and_separate(small: fem.ReducedBody, history: np.ndarray) -> None:
    times = 0.001 * np.arange(len(history))
    table = fem.hot_spots(small, times, history, 10)
    assert list(table["rank"]) == list(range(1, 11))
    assert table["value"].is_monotonic_decreasing
    top = table.iloc[0]
    row = round(top["time"] / 0.001)
    assert small.von_mises(history[row])[0, top["node"]] == pytest.approx(top["value"])
    assert small.von_mises(history).max() == pytest.approx(top["value"])
    inside = np.isin(table["node"], small.spider_nodes)
    assert (inside == (table["flag"] == "in spider")).all()

    apart = fem.hot_spots(small, times, history, 4, separation=fem.Apart(0.2))
    places = apart[["x", "y", "z"]].to_numpy()
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(len(apart), 1)]
    assert (gaps > 0.2).all()

    window = (times >= 0.1) & (times <= 0.2)
    free = fem.hot_spots(small, times[window], history[window], 5, nodes=small.nodes_away_from_spiders)
    assert (free["flag"] == "").all()
    assert free["time"].between(0.1, 0.2).all()


def test_regions_have_one_peak_each(small: fem.ReducedBody) -> None:
    # pure bending is greatest at opposite faces, with a calm core in between
    mode = np.zeros(len(small.frequencies))
    mode[0] = 1.0
    table = fem.hot_spots(small, [0.0], mode, 10, separation=fem.OneARegion(0.7))
    assert len(table) == 2


def test_bad_requests(small: fem.ReducedBody, history: np.ndarray) -> None:
    times = np.arange(len(history))
    with pytest.raises(ValueError, match="got 0 times and"):
        fem.hot_spots(small, times[:0], history[:0])
    with pytest.raises(ValueError, match="got 700 times and 0 nodes"):
        fem.hot_spots(small, times, history, nodes=np.array([], dtype=int))
    with pytest.raises(ValueError, match="count must be at least 1, got 0"):
        fem.hot_spots(small, times, history, 0)
    with pytest.raises(ValueError, match="times must be as many as the rows of q, got 699 and 700"):
        fem.hot_spots(small, times[1:], history)
    peaks = fem.recover_peaks(small.stress_modes, history, "greatest shear")
    with pytest.raises(ValueError, match="peaks must be of 'von mises' at all"):
        fem.hot_spots(small, times, history, peaks=peaks)
    with pytest.raises(ValueError, match="radius must be positive, got 0"):
        fem.Apart(0.0)
    with pytest.raises(ValueError, match=r"fraction must lie inside \(0, 1\), got 1"):
        fem.OneARegion(1.0)
