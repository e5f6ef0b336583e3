"""Pages on screens of any width, in a browser: all of it is seen, and nothing lies over the other."""

from itertools import pairwise

import numpy as np
import pytest

from exudyn_crawler.views.pages.life import write_life_page
from exudyn_crawler.views.tables import cell_text
from fem.stress.trust import LIMITED, VERDICTS
from tests.views.browser import Reader

VIEW = "#life-view"
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}

SEEN = """([place, bodies]) => {
  const { data, _fullLayout: { scene } } = document.querySelector(place);
  const { glplot, dataScale } = scene._scene;
  const { model, view, projection } = glplot.cameraParams;
  const times = (m, v) => [0, 1, 2, 3].map((r) => v.reduce((sum, one, k) => sum + m[r + 4 * k] * one, 0));
  const range = { x: [1, -1], y: [1, -1] };
  const meshes = data.filter(({ name, type }) => type === "mesh3d" && new RegExp(bodies).test(name));
  const eight = ({ range: ends }, bit) => [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => ends[(corner >> bit) & 1]);
  const axes = { x: eight(scene.xaxis, 0), y: eight(scene.yaxis, 1), z: eight(scene.zaxis, 2) };
  for (const { x, y, z } of bodies ? meshes : [axes]) {
    for (let k = 0; k < x.length; k++) {
      const at = [x[k], y[k], z[k]].map((value, axis) => value * dataScale[axis]);
      const [u, v, , w] = times(projection, times(view, times(model, [...at, 1])));
      range.x = [Math.min(range.x[0], u / w), Math.max(range.x[1], u / w)];
      range.y = [Math.min(range.y[0], v / w), Math.max(range.y[1], v / w)];
    }
  }
  return [...range.x, ...range.y];
}"""
"""Least and greatest place of bodies, or of the axes, across and up a 3D view with edges at -1 and 1."""

BOXES = "(found) => [...document.querySelectorAll(found)].map((one) => one.getBoundingClientRect().toJSON())"


def seen(reader, place, bodies):
    """Extent of bodies by their names, or of the axes, in a 3D view as its last frame shows it."""
    reader.page.locator(place).scroll_into_view_if_needed()
    reader.page.wait_for_function(f"() => document.querySelector('{place}')._fullLayout?.scene?._scene")
    reader.page.wait_for_timeout(1000)
    return np.array(reader.page.evaluate(SEEN, [place, bodies]))


def assert_on_screen(extent, width):
    """What is seen is on the screen as a whole, and not lost on it."""
    assert np.abs(extent).max() < 1.0
    assert extent[1] - extent[0] > width


def overlap(one, other):
    across = min(one["right"], other["right"]) - max(one["left"], other["left"])
    return across > 0.5 and min(one["bottom"], other["bottom"]) - max(one["top"], other["top"]) > 0.5


@pytest.fixture(scope="module")
def phone(browser, stress_report):
    reader = Reader(browser, stress_report, **PHONE)
    assert reader.page.evaluate("matchMedia('(hover: none)').matches")
    yield reader
    assert reader.errors == []


@pytest.mark.slow
def test_a_narrow_screen_needs_no_scrolling_sideways(phone):
    assert phone.page.evaluate("document.documentElement.scrollWidth") <= 390
    table = "document.querySelector('#case .wide')"
    assert phone.page.evaluate(f"{table}.scrollWidth <= {table}.clientWidth")
    assert max(cell["right"] for cell in phone.page.evaluate(BOXES, "#case td")) <= 390


@pytest.mark.slow
def test_a_narrow_screen_shows_all_of_the_track(phone):
    for camera in ("isometric", "above", "side"):
        phone.page.locator(f"[data-camera={camera}]").click()
        assert_on_screen(seen(phone, "#track-view", "shoes"), 1.2)
    assert_on_screen(seen(phone, "#shoe-view", "shoe"), 1.0)


@pytest.mark.slow
def test_nothing_on_a_narrow_screen_lies_over_the_other(phone):
    for place in ("#plot-0", "#plot-1"):
        names = phone.page.evaluate(BOXES, f"{place} .legend .traces")
        titles = phone.page.evaluate(BOXES, f"{place} .xtitle, {place} .xtick")
        assert len(names) == 2 or place == "#plot-1"
        assert not any(overlap(one, other) for one in names for other in titles)
    for place in ("#plot-0", "#plot-1", "#track-view", "#shoe-view"):
        phone.page.locator(place).scroll_into_view_if_needed()
        phone.page.wait_for_selector(f"{place} .legend .traces")
        tools = phone.page.evaluate(BOXES, f"{place} .modebar-group")
        names = phone.page.evaluate(BOXES, f"{place} .legend .traces, {place} .nsewdrag")
        assert len(tools) > 2
        assert not any(overlap(one, other) for one in names for other in tools)


@pytest.mark.slow
def test_colour_bars_of_a_narrow_screen_are_as_wide_as_it(phone):
    for place in ("#track-view", "#shoe-view"):
        phone.page.locator(place).scroll_into_view_if_needed()
        phone.page.wait_for_selector(f"{place} .colorbar .cbfills rect, {place} .colorbar .cbfills path")
        (bar,) = phone.page.evaluate(BOXES, f"{place} .colorbar .cbfills")
        assert bar["width"] > 250
        (whole,) = phone.page.evaluate(BOXES, f"{place} .colorbar")
        (view,) = phone.page.evaluate(BOXES, place)
        (canvas,) = phone.page.evaluate(BOXES, f"{place} .gl-container > div")
        assert view["left"] <= whole["left"] < whole["right"] <= view["right"]
        assert canvas["bottom"] - 1.0 <= whole["top"] < whole["bottom"] <= view["bottom"] + 1.0
    # the words of the verdicts have room, too
    phone.page.locator("#shoe-colouring").select_option(index=1)
    words = phone.page.evaluate(BOXES, "#shoe-view .colorbar .cbaxis text")
    assert len(words) == 3
    assert all(view["left"] <= word["left"] < word["right"] <= view["right"] for word in words)
    assert not any(overlap(one, other) for one, other in pairwise(words))
    phone.page.locator("#shoe-colouring").select_option(index=0)


@pytest.mark.slow
def test_views_step_back_as_a_screen_becomes_narrow(browser, stress_report):
    """The axes, which hold all that is drawn, and their labels have room at any width."""
    reader = Reader(browser, stress_report)
    for width in (1400, 390, 800):
        reader.page.set_viewport_size({"width": width, "height": 900})
        for place in ("#track-view", "#shoe-view"):
            extent = seen(reader, place, None)
            (canvas,) = reader.page.evaluate(BOXES, f"{place} .gl-container > div")
            beside = 0.5 * canvas["width"] * (1.0 - np.abs(extent[:2]).max())
            below = 0.5 * canvas["height"] * (1.0 + extent[2])
            assert beside > 25.0
            assert below > 40.0
    assert reader.errors == []


@pytest.fixture(scope="module")
def reader(browser, worn, tmp_path_factory):
    path = write_life_page(worn, tmp_path_factory.mktemp("page") / "life.html")
    reader = Reader(browser, path, ready=f"{VIEW} canvas")
    yield reader
    assert reader.errors == []
    assert reader.requests == [path.as_uri()]


def choose(reader, words, title):
    """Choose colours from the list above the shoe."""
    reader.page.locator("#life-colouring").select_option(words)
    reader.wait(f"full[0].colorbar.title.text === '{title}'", VIEW)


@pytest.mark.slow
def test_the_shoe_is_coloured_by_its_life_and_by_trust(reader, worn):
    data, used = worn.dataset, np.unique(worn.dataset.triangle.values)
    coarse = data.verdict.values[used] == LIMITED
    life = np.where(coarse, np.nan, np.log10(data.life[-1].values[used]))
    assert reader.drawn(VIEW) == pytest.approx(life, abs=1e-3, nan_ok=True)
    assert reader.shown("full[0].colorbar.title.text", VIEW) == "life in h"
    choose(reader, "how far to trust it", "verdict")
    beyond, verdict = data.life[-1].values[used] >= 1e9, data.verdict.values[used]
    numbers = np.where(verdict < 0, np.nan, np.where(beyond, len(VERDICTS), verdict))
    drawn = reader.drawn(VIEW)
    assert set(drawn[np.isfinite(drawn)]) <= set(numbers[np.isfinite(numbers)])
    words = reader.shown("full[0].colorbar.ticktext", VIEW)
    assert {"beside a pin coupling: do not use", "long: life beyond 1e9 h"} <= set(words)
    choose(reader, "stays at place 13", "life in h")
    at_place = 1.0 / np.maximum(data.place_damage.sel(shoe=13)[-1].values[used], 1e-9)
    shown = np.where(coarse, np.nan, np.log10(at_place))
    assert reader.drawn(VIEW) == pytest.approx(shown, abs=1e-3, nan_ok=True)


@pytest.mark.slow
def test_the_page_tells_range_verdict_and_the_dutys_own_strengths(reader, worn):
    row = worn.table.iloc[0]
    leads = " ".join(reader.page.locator("p.lead").all_text_contents())
    if row["verdict"] == VERDICTS[LIMITED]:
        assert "no machine hours: the mesh is too coarse" in leads
    else:
        assert f"{cell_text(float(row['life in h at least']))} to" in leads
    assert row["verdict"] in reader.page.locator("#shortest table").first.text_content()
    assert "fatigue_strength as the duty gives; all else: ASTM A36" in leads


@pytest.mark.slow
def test_all_of_the_shoe_is_seen_and_its_bores_are_round(reader, worn):
    assert_on_screen(seen(reader, VIEW, "shoe"), 1.0)
    # the nodes in the middle of the sides of elements are drawn, too
    assert worn.dataset.sizes["face"] == 4 * len(worn.whole.mesh.boundary)
