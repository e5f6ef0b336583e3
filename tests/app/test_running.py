"""Curves of runs on the page, from the files in their folders."""

import asyncio
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

pytest.importorskip("nicegui", reason="the extra `app` is not installed")

from nicegui import ui
from nicegui.testing import user_simulation

from exudyn_crawler import History
from exudyn_crawler.app.document import Document
from exudyn_crawler.app.running import LIVE, RunPanel, joined_curves, shown_run
from exudyn_crawler.files import HISTORY
from exudyn_crawler.results.history.summary import greatest_over_time
from exudyn_crawler.run.folder.queue import DONE, RESULTS, RUNNING, STOPPED, Runs
from exudyn_crawler.run.folder.record import CASE, RECORD


def test_a_finished_run_has_the_curves_of_its_whole_history(translation, tmp_path):
    translation.save(tmp_path / HISTORY)
    # a stage of a run that was killed while it removed them
    (tmp_path / "checkpoints").mkdir()
    (tmp_path / "checkpoints" / "stage_0001.npz").write_bytes(b"half")
    parts = {}
    curves = joined_curves(tmp_path, parts)
    wanted = greatest_over_time(translation, LIVE)
    assert curves.keys() == wanted.keys() == {"greatest contact force on a shoe"}
    for title, values in curves.items():
        xr.testing.assert_allclose(values, wanted[title])
        assert values.time[-1] == translation.time[-1]
    assert joined_curves(tmp_path, parts).keys() == curves.keys()
    assert len(parts) == 1


def test_a_history_that_is_written_anew_is_read_anew(translation, tmp_path):
    translation.save(tmp_path / HISTORY)
    parts = {}
    before = joined_curves(tmp_path, parts)
    half = translation.dataset.isel(time=slice(0, translation.time.size // 2))
    History(translation.case, half).save(tmp_path / HISTORY, overwrite=True)
    after = joined_curves(tmp_path, parts)
    for title, values in after.items():
        assert values.time.size == half.time.size < before[title].time.size
        assert np.isfinite(values).all()


def test_no_curves_of_a_damaged_or_an_absent_history(tmp_path):
    assert joined_curves(tmp_path, {}) == {}
    (tmp_path / HISTORY).write_bytes(b"half")
    assert joined_curves(tmp_path, {}) == {}


def test_the_run_at_work_comes_before_the_newest_that_has_a_history(tmp_path):
    def made(name, status, has_history):
        folder = tmp_path / name
        folder.mkdir()
        if has_history:
            (folder / HISTORY).touch()
        return SimpleNamespace(name=name, status=status, folder=folder)

    stopped, newer, older = made("a", STOPPED, False), made("b", DONE, True), made("c", DONE, True)
    assert shown_run([stopped, newer, older]) is newer
    at_work = made("d", RUNNING, False)
    assert shown_run([stopped, newer, older, at_work]) is at_work
    assert shown_run([stopped]) is None
    assert shown_run([]) is None


def test_every_page_that_opens_draws_the_finished_run(translation, tmp_path):
    folder = tmp_path / RESULTS / "short"
    folder.mkdir(parents=True)
    translation.save(folder / HISTORY)
    (folder / CASE).write_text('base = "translation"\n')
    (folder / RECORD).write_text('{"status": "done"}')
    panels = []

    def root():
        panels.append(RunPanel(Document(tmp_path), Runs(tmp_path), lambda _name: None))

    async def opened_twice():
        async with user_simulation(root=root) as user:
            ui.page("/")(root)
            for _ in range(2):
                await user.open("/")
                with panels[-1].curves:
                    await panels[-1].refresh()

    asyncio.run(opened_twice())
    assert len(panels) == 2
    for panel in panels:
        assert panel.drawn == "short"
        (plot,) = panel.plots.values()
        assert max(plot.figure["data"][0]["x"]) == pytest.approx(float(translation.time[-1]))
