"""Life over a duty of short runs: its sums and causes, what must not change it; spread between runs."""

import numpy as np
import pytest
import rainflow

from exudyn_crawler import Duty, FatigueMaterial, History
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.duty_runs import BETWEEN, node_lives, used_runs
from exudyn_crawler.results.life.life import (
    BEYOND,
    CHOICE_OF_PINS,
    in_words,
    life_hours,
    life_of,
    life_words,
    relative_spread,
)
from exudyn_crawler.results.stress.basis import TOLERANCE
from exudyn_crawler.results.stress.hot_spots import REGIONS, hot_spot_table
from exudyn_crawler.results.stress.recovery import StressResults, node_stress
from exudyn_crawler.spread_run import FIRST as START, spread_of
from exudyn_crawler.views.tables import cell_text
from fem.body.element_stress import von_mises
from fem.stress.trust import HELD, LIMITED, OPEN, VERDICTS
from tests.stress_results import WEAK

HALF = 0.03
FIRST = DutyRun(name="first", folder=".", end=HALF, an_hour=1000.0)
SECOND = DutyRun(name="second", folder=".", begin=HALF, share=0.1)


def duty(*runs: DutyRun, **more) -> Duty:
    return Duty(runs=runs, **{"material": WEAK, "plane_nodes": 3} | more)


@pytest.fixture(scope="module")
def found(history):
    return life_of(duty(FIRST, SECOND), [history, history])


@pytest.mark.slow
def test_damage_is_the_mean_over_places_and_the_sum_of_parts(found):
    data = found.dataset
    assert data.shoe.values.tolist() == [7, 13]
    known = data.damage_an_hour.notnull()
    np.testing.assert_allclose(data.damage_an_hour, data.place_damage.mean("shoe", skipna=False), rtol=1e-6)
    parts = data.part_damage.sum("part").where(known[-1])
    np.testing.assert_allclose(parts, data.damage_an_hour[-1], rtol=1e-9)
    assert data.part.values.tolist() == ["first: constant", "second: constant", BETWEEN]
    assert (data.part_damage.max("node") > 0.0).all()
    assert np.diff(data.damage_an_hour.values[:, known[-1].values], axis=0).min() >= 0.0
    assert data.life.values == pytest.approx(life_hours(data.damage_an_hour.values), nan_ok=True)
    inside = np.setdiff1d(data.node.values, found.whole.mesh.surface_nodes)
    assert data.life.sel(node=inside).isnull().all()


def test_damage_at_a_place_is_that_of_its_history(history, found):
    """Counted again from the modal coordinates, each run as often as the duty says."""
    node = int(found.table["node"][0])
    chosen = int(found.whole.mesh.surface_nodes[5])
    only = life_of(duty(FIRST, nodes=(chosen,), plane_nodes=0), [history])
    assert only.table["node"].tolist() == list(only.nodes)
    assert chosen in only.nodes
    run = node_lives(only.duty, only.runs, {node: WEAK.curve()})[node].cycles.query("shoe == 13")
    again = float(only.dataset.place_damage.sel(shoe=13, node=node)[-1])
    assert 2.0 * run["damage an hour"].sum() == pytest.approx(again, rel=1e-3)
    assert run["times an hour"].unique() == pytest.approx([500.0])  # half of all hours at this place


def test_damage_is_that_of_another_rainflow_library(history, found):
    """Cycles by the library rainflow, FKM's mean stress and Miner's rule by hand, at the worst node."""
    node = int(found.table["node"][0])
    stress = node_stress(history, 13, node=node).stress.values
    signal = np.where(stress[:, :3].sum(axis=1) < 0.0, -1.0, 1.0) * von_mises(stress)
    signal = signal[history.time.values <= HALF * (1.0 + 1e-9)]
    start = int(signal.argmax())
    once = np.append(np.roll(signal, -start), signal[start])
    ranges, means, counts = np.array([one[:3] for one in rainflow.extract_cycles(once)]).T
    amplitude, curve = 0.5 * ranges, WEAK.curve()
    M, part = curve.mean_sensitivity, np.clip(means / amplitude, -1.0, 3.0)
    beyond = (1.0 + M) / (1.0 + M / 3.0) * (1.0 + M / 3.0 * part)
    equal = amplitude * np.where(part <= 1.0, 1.0 + M * part, beyond)
    damage = counts @ (equal / curve.strength_at(0.975)) ** curve.slope / curve.knee
    first = duty(FIRST)
    counted = node_lives(first, used_runs(first, [history]), {node: curve})
    cycles = counted[node].cycles.query("shoe == 13")
    # every other hour a shoe is at this place; left-out static fields change a stress by up to 0.01 MPa
    assert cycles["damage an hour"].sum() == pytest.approx(1000.0 / 2.0 * damage, rel=1e-3)


@pytest.mark.slow
def test_order_of_runs_does_not_matter(history, found):
    other = life_of(duty(SECOND, FIRST), [history, history])
    damage, expected = (one.dataset.damage_an_hour.values for one in (other, found))
    assert damage == pytest.approx(expected, rel=1e-9, abs=1e-15, nan_ok=True)
    assert other.table["node"].tolist() == found.table["node"].tolist()


def test_life_is_the_same_however_its_runs_are_cut(history, found):
    """Both runs cut into rows by their rates, in another order."""
    rows = [
        run.with_(name=f"{run.name} {part}", **{rate: part * getattr(run, rate)})
        for part in (0.3, 0.7)
        for run, rate in ((SECOND, "share"), (FIRST, "an_hour"))
    ]
    cut = life_of(duty(*rows, plane_nodes=0), [history] * 4)
    damage, expected = (one.dataset.damage_an_hour.values for one in (cut, found))
    assert damage == pytest.approx(expected, rel=1e-9, abs=1e-12, nan_ok=True)


def test_table_has_every_region_and_the_shortest_first(found):
    table, data = found.table, found.dataset
    assert set(table["region"]) == set(REGIONS)
    last = "life in h that 97.5 % survive"
    is_held = table["flag"] == "in spider"
    usable, held = table[~is_held], table[is_held]
    assert usable[last].is_monotonic_increasing
    assert held[last].is_monotonic_increasing
    # lives that are not to be used stand last
    assert table["node"].tolist() == [*usable["node"], *held["node"]]
    assert table[last].min() == pytest.approx(float(np.nanmin(data.life[-1])))
    for _, row in table.iterrows():
        shares = [row[name] for name in table.columns if name.startswith("contribution of ")]
        assert np.nansum(shares) == pytest.approx(1.0, abs=1e-6)
        assert 0.0 < row["its share"] <= 1.0
        assert row["life in h there"] <= row[last] * (1.0 + 1e-9)
    assert set(table["main load"]) <= {"pins", "machine load", "ground", "drive", "inertia"}
    assert set(table["flag"]) <= {"", "in spider", "beside spider"}


def test_every_life_has_a_range_and_a_verdict(found):
    """An error of x in the stress is one of (1 + x)^slope in life; a coarse mesh is caught."""
    data, table = found.dataset, found.table
    known = data.life[-1].notnull().values
    assert (data.verdict.values >= 0).tolist() == known.tolist()
    assert data.stress_error.notnull().values.tolist() == known.tolist()
    # rigid pins make lugs uncertain, too: most beside the bores
    own, chosen = data.life_factor.values**0.2 - 1.0 - data.stress_error.values, CHOICE_OF_PINS["rigid"]
    at_lugs = np.isin(found.regions, ["lugs", "bores"])
    assert own[known & ~at_lugs] == pytest.approx(0.0, abs=1e-9)
    parts = own[known & at_lugs]
    assert (np.isclose(parts, chosen[0]) | np.isclose(parts, chosen[1])).all()
    assert np.isclose(own[known & data.in_spider.values], chosen[1]).all()
    held = known & data.in_spider.values
    assert (data.verdict.values[held] == HELD).all()
    assert (data.verdict.values[known & ~held] != HELD).all()
    for _, row in table.iterrows():
        own = data.sel(node=row["node"])
        damage, factor = float(own.damage_an_hour[-1]), float(own.life_factor)
        assert row["life in h at least"] == pytest.approx(min(1.0 / (damage * factor), BEYOND))
        assert row["life in h at most"] == pytest.approx(min(factor / damage, BEYOND))
        assert row["verdict"] == VERDICTS[int(own.verdict)]
    assert "mesh too coarse: refine here" in set(table["verdict"])


def test_the_widest_spread_of_the_runs_is_in_the_verdict(history, found):
    """Parts of one run have its spread once."""
    spread = 0.0 * found.dataset.place_damage[:, 0].fillna(0.0) + 0.3
    both = duty(FIRST, SECOND, plane_nodes=0)
    wide = life_of(both, [history, history], spreads=[spread, 0.5 * spread]).dataset
    known = found.dataset.stress_error.notnull().values
    more = (wide.stress_error - found.dataset.stress_error).values[known]
    assert more == pytest.approx(np.full(known.sum(), 0.3))
    before, after = found.dataset.verdict.values, wide.verdict.values
    good = (before >= 0) & (before < OPEN)
    assert good.any()
    assert (after[good] > before[good]).all()


def test_cycles_of_a_node_make_its_matrix_and_history(found):
    for node in found.nodes.values():
        cycles = node.cycles
        times = cycles["times an hour"].sum()
        assert node.rainflow_matrix()["cycles an hour"].sum() == pytest.approx(times)
        last = node.damage_history().groupby(["run", "shoe"])["damage an hour"].last()
        each = cycles.groupby(["run", "shoe"])["damage an hour"].sum()
        assert last.to_numpy() == pytest.approx(each.reindex(last.index).to_numpy())
        own = node.by_criterion[found.duty.criterion]
        assert own == pytest.approx(cycles["damage an hour"].sum(), rel=1e-9)


def test_castings_change_the_life_of_their_region_alone(modes_alone):
    sound = life_of(duty(FIRST, plane_nodes=0), [modes_alone])
    wings = {"region": "wings", "residual_stress": 60e6, "defect_size": 5e-4}
    material = WEAK.with_(castings=(wings, {"region": "web", "defect_size": 5e-3}))
    cast = life_of(duty(FIRST, plane_nodes=0, material=material), [modes_alone])
    before, after = sound.table.set_index("region"), cast.table.set_index("region")
    last = "life in h that 97.5 % survive"
    assert after.loc["wings", last] < before.loc["wings", last]
    others = [region for region in before.index if region != "wings"]
    assert after.loc[others, last].to_numpy() == pytest.approx(before.loc[others, last].to_numpy(), rel=1e-3)
    assert after.loc["wings", "residual stress in MPa"] == 60.0
    assert after.loc[["wings", "web"], "defect in mm"].tolist() == [0.5, 5.0]
    assert after["life in h, defect"].isna().tolist() == [one not in ("wings", "web") for one in after.index]
    # counted again: cycles of the node, with its residual stress, by the sound surface: its defect sleeps
    node = int(after.loc["wings", "node"])
    cycles = cast.nodes[node].cycles
    begin, end = (cycles[f"{one} in Pa"].to_numpy(dtype=float) for one in ("begin", "end"))
    of_cycles = material.curve("elementary", "wings").damage
    each = of_cycles(0.5 * np.abs(end - begin), 0.5 * (begin + end), (0.975,))[0]
    damage = float(each @ cycles["times an hour"])
    assert after.loc["wings", "life in h, defect"] == pytest.approx(min(1.0 / damage, BEYOND), rel=1e-6)


def test_no_damage_is_a_life_beyond_what_is_told(modes_alone, found):
    strong = FatigueMaterial.a36().with_(tensile_strength=1e10, fatigue_strength=1e10, mean_sensitivity=0.0)
    good = (found.dataset.verdict >= 0) & (found.dataset.verdict < OPEN)
    chosen = np.flatnonzero(good)[:5]
    long = life_of(Duty(runs=(FIRST,), material=strong, nodes=tuple(chosen.tolist())), [modes_alone])
    assert float(long.dataset.life.max()) == float(long.dataset.life.min()) == BEYOND
    assert set(in_words(long.table)["life in h that 50 % survive"]) == {"beyond 1e9"}
    assert [cell_text(life_words(life)) for life in (300_912.3, np.nan)] == ["300 900", "not known"]
    assert (long.table["main part"] == "").all()
    numbers = long.dataset.verdict.sel(node=long.table["node"].to_numpy()).values
    good = (numbers >= 0) & (numbers < OPEN)
    assert {one.split(" % ")[-1] for one in long.table["verdict"][good]} == {"but for truncation"}


def test_what_a_drive_pulls_at_a_node_is_not_known(stress, found):
    at_load = stress.at_load.sel(shoe=13).values & found.dataset.place_damage.sel(shoe=7)[-1].notnull().values
    unknown = found.dataset.place_damage.sel(shoe=13)[-1].isnull().values
    unknown[np.setdiff1d(found.dataset.node.values, found.whole.mesh.surface_nodes)] = False
    assert (unknown == at_load).all()


def test_runs_that_do_not_fit_are_refused(history, translation):
    flexible = history.case.flexible
    one, two = (DutyRun(name=name, folder=".", an_hour=1.0) for name in ("one", "two"))
    with pytest.raises(ValueError, match="run 'two' must have flexible shoes"):
        life_of(duty(one, two), [history, translation])
    for change, words in (
        ({"shoes": (7,)}, r"shoes of 'one' is \(7, 13\), of 'two' \(7,\)"),
        ({"mesh": "study"}, "same shoes: mesh of 'one' is"),
        ({"youngs_modulus": 7e10}, "youngs_modulus of 'one' is 2"),
        ({"pins": "averaging"}, "pins of 'one' is rigid, of 'two' averaging"),
    ):
        other = History(history.case.with_(flexible=flexible.with_(**change)), history.dataset)
        with pytest.raises(ValueError, match=words):
            life_of(duty(one, two), [history, other])
    for run, words in (
        (DutyRun(name="short", folder=".", begin=0.0585, an_hour=1.0), "at least 3 stored times from 0.0585"),
        (DutyRun(name="far", folder=".", end=1.0, an_hour=1.0), "must reach its end = 1 s"),
        (DutyRun(name="often", folder=".", an_hour=1e5), "more than all machine hours"),
    ):
        with pytest.raises(ValueError, match=words):
            life_of(duty(run), [history])
    with pytest.raises(ValueError, match=r"nodes must be on the surface, got \[100000000\]"):
        life_of(duty(one, nodes=(10**8,)), [history])


@pytest.mark.slow
def test_static_fields_are_counted_with_the_modes(history):
    """Their stress is what the run's own results show, and their families of loads share the damage."""
    assert history.case.flexible.static_fields
    found = life_of(duty(FIRST), [history])
    node = int(found.table["node"][0])
    stresses = [node_stress(history, shoe, node=node).von_mises for shoe in (7, 13)]
    peaks = [float(one.sel(time=slice(0.0, HALF + 1e-9)).max()) for one in stresses]
    ends = found.nodes[node].cycles[["begin in Pa", "end in Pa"]].abs().to_numpy()
    # a part of a run has other directions of its fields than the whole: either leaves this out
    assert ends.max() == pytest.approx(max(peaks), abs=2.0 * TOLERANCE)
    loads = found.nodes[node].load_shares
    assert sum(loads.values()) == pytest.approx(1.0)
    assert {"pins", "machine load", "ground"} <= set(loads)


@pytest.fixture(scope="module")
def first(flexible_run):
    return StressResults(*flexible_run[1:], {}, whole=None)


@pytest.fixture(scope="module")
def beside(first):
    peak = first.dataset.peak_von_mises
    others = {"start 2": 1.2 * peak, "start 3": 0.9 * peak, "law by area": 1.3 * peak}
    return spread_of(first, others, 3)


def test_spread_is_the_range_of_starts_and_choice_what_is_beyond(first, beside):
    peak, found = first.dataset.peak_von_mises, beside.dataset
    assert found.run.values.tolist() == [START, "start 2", "start 3", "law by area"]
    assert found.peak_spread.values == pytest.approx(0.3 * peak.values)
    assert found.peak_choice.values == pytest.approx(0.1 * peak.values)
    assert relative_spread(found).values == pytest.approx(np.full(peak.shape, 0.4))
    within = spread_of(first, {"start 2": 1.2 * peak, "law by area": 1.1 * peak}, 2)
    assert not within.dataset.peak_choice.any()


def test_verdicts_follow(first, beside):
    before, after = first.dataset.peak_verdict.values, beside.dataset.peak_verdict.values
    assert ((after == before) | (before < LIMITED)).all()
    open_ = (before >= 0) & (before < LIMITED)
    assert open_.any()
    assert (after[open_] > VERDICTS.index("good to 40 %")).all()
    assert (after[(before == HELD)] == HELD).all()
    for table in beside.hot_spots.values():
        assert table["spread"].to_numpy() == pytest.approx(0.3 * table["value"].to_numpy())
        shown = hot_spot_table(table, beside.dataset)
        assert shown["choice in MPa"].to_numpy() == pytest.approx(1e-7 * table["value"].to_numpy())
        own = [name for name in shown.columns if not name.startswith("contribution of ") and name != "region"]
        assert own[:3] == ["rank", "von Mises in MPa", "verdict"]


def test_a_row_a_shoe_tells_all_runs(first, beside):
    table = beside.by_shoe()
    assert table["shoe"].tolist() == first.dataset.shoe.values.tolist()
    assert table["spread in %"].to_numpy() == pytest.approx(30.0)
    assert (table["start 2 in MPa"] / table["start 1 in MPa"]).to_numpy() == pytest.approx(1.2)
