"""Spread between runs that could stand for each other: ranges, and verdicts that follow."""

import numpy as np
import pytest

from exudyn_crawler.results.life.life import relative_spread
from exudyn_crawler.results.stress.hot_spots import hot_spot_table
from exudyn_crawler.results.stress.recovery import StressResults
from exudyn_crawler.spread_run import FIRST, spread_of
from fem.trust import HELD, LIMITED, VERDICTS


@pytest.fixture(scope="module")
def first(flexible_run):
    return StressResults(*flexible_run[1:], {}, whole=None)


@pytest.fixture(scope="module")
def found(first):
    peak = first.dataset.peak_von_mises
    others = {"start 2": 1.2 * peak, "start 3": 0.9 * peak, "law by area": 1.3 * peak}
    return spread_of(first, others, 3)


def test_spread_is_the_range_of_starts_and_choice_what_is_beyond(first, found):
    peak = first.dataset.peak_von_mises
    assert found.dataset.run.values.tolist() == [FIRST, "start 2", "start 3", "law by area"]
    assert found.dataset.peak_spread.values == pytest.approx(0.3 * peak.values)
    assert found.dataset.peak_choice.values == pytest.approx(0.1 * peak.values)
    assert relative_spread(found.dataset).values == pytest.approx(np.full(peak.shape, 0.4))
    within = spread_of(first, {"start 2": 1.2 * peak, "law by area": 1.1 * peak}, 2)
    assert not within.dataset.peak_choice.any()


def test_verdicts_follow(first, found):
    before, after = first.dataset.peak_verdict.values, found.dataset.peak_verdict.values
    assert ((after == before) | (before < LIMITED)).all()
    open_ = (before >= 0) & (before < LIMITED)
    assert open_.any()
    least = VERDICTS.index("good to 40 %")
    assert (after[open_] > least).all()
    assert (after[(before == HELD)] == HELD).all()
    for table in found.hot_spots.values():
        assert table["spread"].to_numpy() == pytest.approx(0.3 * table["value"].to_numpy())
        shown = hot_spot_table(table, found.dataset)
        assert shown["choice in MPa"].to_numpy() == pytest.approx(1e-7 * table["value"].to_numpy())
        own = [name for name in shown.columns if not name.startswith("share of ") and name != "region"]
        assert own[:3] == ["rank", "von Mises in MPa", "verdict"]


def test_a_row_a_shoe_tells_all_runs(first, found):
    table = found.by_shoe()
    assert table["shoe"].tolist() == first.dataset.shoe.values.tolist()
    assert table["spread in %"].to_numpy() == pytest.approx(30.0)
    assert (table["start 2 in MPa"] / table["start 1 in MPa"]).to_numpy() == pytest.approx(1.2)
