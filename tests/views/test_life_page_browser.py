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
from tests.views.test_report_screens import seen

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


def chosen(reader, words):
    """Choose colours from the list above the shoe."""
    reader.page.locator("#life-colouring").select_option(words)


def drawn(reader):
    """Colours of the nodes that are drawn; what is not known is left out."""
    values = reader.shown("Array.from(full[0].intensity, (one) => Number.isNaN(one) ? null : one)", VIEW)
    return np.array(values, dtype=float)


def test_the_shoe_is_coloured_by_its_life_and_by_trust(reader, found):
    data, used = found.dataset, np.unique(found.dataset.triangle.values)
    life = np.log10(data.life[-1].values[used])
    assert drawn(reader) == pytest.approx(life, abs=1e-3, nan_ok=True)
    assert reader.shown("full[0].colorbar.title.text", VIEW) == "life in h"
    chosen(reader, "how far to trust it")
    reader.wait("full[0].colorbar.title.text === 'verdict'", VIEW)
    beyond = data.life[-1].values[used] >= 1e9
    numbers = np.where(
        data.verdict.values[used] < 0, np.nan, np.where(beyond, len(VERDICTS), data.verdict.values[used])
    )
    assert set(drawn(reader)[np.isfinite(drawn(reader))]) <= set(numbers[np.isfinite(numbers)])
    assert "inside a spider: do not use" in reader.shown("full[0].colorbar.ticktext", VIEW)
    assert "long: life beyond 1e9 h" in reader.shown("full[0].colorbar.ticktext", VIEW)
    chosen(reader, "stays at place 13")
    reader.wait("full[0].colorbar.title.text === 'life in h'", VIEW)
    at_place = 1.0 / np.maximum(data.place_damage.sel(shoe=13)[-1].values[used], 1e-9)
    assert drawn(reader) == pytest.approx(np.log10(at_place), abs=1e-3, nan_ok=True)


def test_the_page_tells_range_and_verdict(reader, found):
    row = found.table.iloc[0]
    leads = " ".join(reader.page.locator("p.lead").all_text_contents())
    assert f"stress {row['verdict']}" in leads
    assert f"{cell_text(float(row['life in h at least']))} to" in leads
    cells = reader.page.locator("#shortest table").first.text_content()
    assert row["verdict"] in cells


def test_the_page_says_which_strengths_are_the_dutys_own(reader):
    leads = " ".join(reader.page.locator("p.lead").all_text_contents())
    assert "fatigue_strength as the duty gives; all else: ASTM A36" in leads


def test_all_of_the_shoe_is_seen_and_its_bores_are_round(reader, found):
    extent = seen(reader, VIEW, "shoe")
    assert np.abs(extent).max() < 1.0
    assert extent[1] - extent[0] > 1.0
    # the nodes in the middle of the sides of elements are drawn, too
    assert found.dataset.sizes["face"] == 4 * len(found.whole.mesh.boundary)
