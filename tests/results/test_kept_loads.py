"""Looks at nodes of a saved history: the same numbers as in memory, from what an earlier look has kept."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from exudyn_crawler import History, node_stress
from exudyn_crawler.model.reductions import reductions_in
from exudyn_crawler.results.loads.kept_loads import SUFFIX
from exudyn_crawler.results.stress.node_look import look, look_into

LOOK = """
import sys
sys.argv = ["exudyn-crawler", "node-stress", sys.argv[1], "--shoe", "13", "--node", "201"]
from exudyn_crawler.cli import main
try: main()
except SystemExit as end: assert not end.code, end.code
heavy = {"xarray", "pandas", "numba", "exudyn"} & set(sys.modules)
sys.exit(str(heavy) if heavy else 0)
"""


@pytest.fixture
def saved(flexible_run, tmp_path):
    return flexible_run[0].save(tmp_path / "history.nc")


@pytest.fixture
def folder(tmp_path):
    """A folder of reductions of its own, without anything."""
    with reductions_in(tmp_path / "kept"):
        yield tmp_path / "kept"


@pytest.fixture
def no_history(monkeypatch):
    """From now on no history is read."""

    def fail(*_args):
        raise AssertionError("the history was read")

    return lambda: monkeypatch.setattr(History, "load", fail)


def test_a_further_look_reads_no_history_and_has_the_same_numbers(saved, no_history):
    history = History.load(saved)
    first = look_into(saved, 13, near=(0.2, -0.3, 0.1))
    no_history()
    for place in ({"near": (0.2, -0.3, 0.1)}, {"node": 200}):
        found, expected = look_into(saved, 13, **place), look(history, 13, **place)
        np.testing.assert_array_equal(found.time, expected.time)
        np.testing.assert_allclose(found.stress, expected.stress, rtol=1e-12, atol=1e-3)
        assert (found.node, found.in_spider) == (expected.node, expected.in_spider)
        assert found.distance == expected.distance
    assert first.node == look_into(saved, 13, near=(0.2, -0.3, 0.1)).node
    np.testing.assert_array_equal(
        node_stress(saved, 13, node=200).stress, look_into(saved, 13, node=200).stress
    )
    with pytest.raises(ValueError, match=r"node must be in 0\.\.\d+, got 1000000"):
        look_into(saved, 13, node=10**6)
    with pytest.raises(AssertionError, match="was read"):
        look_into(saved, 7, node=200)


def test_another_history_has_loads_of_its_own(flexible_run, tmp_path):
    history = flexible_run[0]
    stronger = History(history.case, history.dataset.assign(modal_coordinate=1.1 * history.modal_coordinate))
    paths = [one.save(tmp_path / f"{k}.nc") for k, one in enumerate((history, stronger))]
    one, other = (look_into(path, 7, node=200) for path in paths)
    assert not np.allclose(one.stress, other.stress)


def test_without_static_fields_the_modes_alone_answer(flexible_run, tmp_path):
    history = flexible_run[0]
    flexible = history.case.flexible_shoes().with_(static_fields=False)
    alone = History(history.case.with_(flexible=flexible), history.dataset)
    path = alone.save(tmp_path / "alone.nc")
    for _ in range(2):
        found = look_into(path, 13, node=200)
        np.testing.assert_allclose(found.stress, look(alone, 13, node=200).stress, rtol=1e-12, atol=1e-3)


def test_what_was_kept_and_is_broken_or_gone_is_made_anew(saved, folder, caplog):
    expected = look_into(saved, 13, node=200).stress
    (loads,) = folder.glob(f"*{SUFFIX}.h5")
    whole = loads.read_bytes()
    times = whole.index(History.load(saved).time.values.tobytes())
    loads.write_bytes(whole[: times + 8] + bytes(8) + whole[times + 16 :])
    np.testing.assert_array_equal(look_into(saved, 13, node=200).stress, expected)
    assert "the file of shoe 13's loads is made anew" in caplog.text
    assert loads.read_bytes() == whole
    for other in set(folder.glob("*.h5")) - {loads}:
        other.unlink()
    np.testing.assert_allclose(look_into(saved, 13, node=200).stress, expected, rtol=1e-9, atol=1.0)


def test_loads_that_are_too_large_are_not_kept(saved, folder, monkeypatch):
    monkeypatch.setattr("exudyn_crawler.results.loads.kept_loads.MOST_KEPT", 1000)
    look_into(saved, 13, node=200)
    assert not list(folder.glob(f"*{SUFFIX}.h5"))


def test_a_further_look_loads_nothing_heavy(saved):
    look_into(saved, 13, node=200)
    line = [sys.executable, "-c", LOOK, str(saved)]
    done = subprocess.run(line, capture_output=True, text=True, cwd=Path(__file__).parents[2], check=False)
    assert done.returncode == 0, done.stderr
    assert "greatest von Mises stress" in done.stdout


def test_what_is_no_history_or_has_no_mesh_is_named(flexible_run, tmp_path):
    with pytest.raises(FileNotFoundError, match="no history at"):
        node_stress(tmp_path / "none.nc", 13, node=0)
    (tmp_path / "text.nc").write_text("no history")
    with pytest.raises(ValueError, match=r"text\.nc does not hold a history"):
        node_stress(tmp_path / "text.nc", 13, node=0)
    history = flexible_run[0]
    flexible = history.case.flexible_shoes().with_(mesh=str(tmp_path / "gone.msh"))
    moved = History(history.case.with_(flexible=flexible), history.dataset).save(tmp_path / "moved.nc")
    with pytest.raises(FileNotFoundError, match="no mesh file"):
        node_stress(moved, 13, node=0)
