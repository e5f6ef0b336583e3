"""How the page of a life answers in a browser; nothing may leave the page."""

import numpy as np
import pytest

from exudyn_crawler import Duty, FatigueMaterial
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.views.pages.life import write_life_page
from exudyn_crawler.views.tables import cell_text
from fem.trust import VERDICTS
from tests.views.browser import Reader
from tests.views.test_report_screens import assert_on_screen, seen

VIEW = "#life-view"


@pytest.fixture(scope="module")
def found(flexible_run):
    material = FatigueMaterial.a36().with_(fatigue_strength=90e6)
    run = DutyRun(name="propel", folder=".", share=0.1)
    duty = Duty(runs=(run,), material=material, plane_nodes=0, survivals=(0.9,))
    return life_of(duty, [flexible_run[0]])


@pytest.fixture(scope="module")
def reader(browser, found, tmp_path_factory):
    path = write_life_page(found, tmp_path_factory.mktemp("page") / "life.html")
    reader = Reader(browser, path, ready=f"{VIEW} canvas")
    yield reader
    assert reader.errors == []
    assert reader.requests == [path.as_uri()]


def choose(reader, words, title):
    """Choose colours from the list above the shoe."""
    reader.page.locator("#life-colouring").select_option(words)
    reader.wait(f"full[0].colorbar.title.text === '{title}'", VIEW)


def test_the_shoe_is_coloured_by_its_life_and_by_trust(reader, found):
    data, used = found.dataset, np.unique(found.dataset.triangle.values)
    life = np.log10(data.life[-1].values[used])
    assert reader.drawn(VIEW) == pytest.approx(life, abs=1e-3, nan_ok=True)
    assert reader.shown("full[0].colorbar.title.text", VIEW) == "life in h"
    choose(reader, "how far to trust it", "verdict")
    beyond, verdict = data.life[-1].values[used] >= 1e9, data.verdict.values[used]
    numbers = np.where(verdict < 0, np.nan, np.where(beyond, len(VERDICTS), verdict))
    drawn = reader.drawn(VIEW)
    assert set(drawn[np.isfinite(drawn)]) <= set(numbers[np.isfinite(numbers)])
    words = reader.shown("full[0].colorbar.ticktext", VIEW)
    assert {"inside a spider: do not use", "long: life beyond 1e9 h"} <= set(words)
    choose(reader, "stays at place 13", "life in h")
    at_place = 1.0 / np.maximum(data.place_damage.sel(shoe=13)[-1].values[used], 1e-9)
    assert reader.drawn(VIEW) == pytest.approx(np.log10(at_place), abs=1e-3, nan_ok=True)


def test_the_page_tells_range_verdict_and_the_dutys_own_strengths(reader, found):
    row = found.table.iloc[0]
    leads = " ".join(reader.page.locator("p.lead").all_text_contents())
    assert f"stress {row['verdict']}" in leads
    assert f"{cell_text(float(row['life in h at least']))} to" in leads
    assert row["verdict"] in reader.page.locator("#shortest table").first.text_content()
    assert "fatigue_strength as the duty gives; all else: ASTM A36" in leads


def test_all_of_the_shoe_is_seen_and_its_bores_are_round(reader, found):
    assert_on_screen(seen(reader, VIEW, "shoe"), 1.0)
    # the nodes in the middle of the sides of elements are drawn, too
    assert found.dataset.sizes["face"] == 4 * len(found.whole.mesh.boundary)
