"""How the page of a life answers in a browser; nothing may leave the page."""

import numpy as np
import pytest

from exudyn_crawler import Duty, FatigueMaterial
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.views.life_page import write_life_page
from tests.views.browser import Reader

VIEW = "#plot-life"


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
    """Choose a view from the list beside the shoe."""
    reader.page.locator(f"{VIEW} .updatemenu-header").click()
    reader.page.locator(f"{VIEW} .updatemenu-dropdown-button", has_text=words).click()


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
    reader.wait("full[0].colorbar.title.text === 'stress'", VIEW)
    numbers = np.where(data.verdict.values < 0, np.nan, data.verdict.values)[used]
    assert drawn(reader) == pytest.approx(numbers, nan_ok=True)
    assert "inside a spider: do not use" in reader.shown("full[0].colorbar.ticktext", VIEW)
    chosen(reader, "stays at place 13")
    reader.wait("full[0].colorbar.title.text === 'life in h'", VIEW)
    at_place = 1.0 / np.maximum(data.place_damage.sel(shoe=13)[-1].values[used], 1e-9)
    assert drawn(reader) == pytest.approx(np.log10(at_place), abs=1e-3, nan_ok=True)


def test_the_page_tells_range_and_verdict(reader, found):
    row = found.table.iloc[0]
    leads = " ".join(reader.page.locator("p.lead").all_text_contents())
    assert f"stress {row['verdict']}" in leads
    assert f"{row['life in h at least']:.4g} to" in leads
    cells = reader.page.locator("#shortest table").first.text_content()
    assert row["verdict"] in cells
