"""How the report answers in a browser; nothing may leave the page."""

import json

import numpy as np
import pytest

from exudyn_crawler import History
from exudyn_crawler.views.pages.packing import SceneArrays
from exudyn_crawler.views.pages.report import packed_track, write_report
from exudyn_crawler.views.scenes.gear import wheel_solids
from exudyn_crawler.views.scenes.shoes import STRESS, TRUST
from fem.stress.trust import VERDICTS
from tests.views.browser import Reader
from tests.views.test_figures import BANDS, NAMES, PHASES


@pytest.fixture(scope="module")
def reader(browser, stress_report):
    reader = Reader(browser, stress_report)
    assert reader.page.title() == "Crawler track: stress"
    yield reader
    # after all that the tests did to the page
    assert reader.errors == []
    assert reader.requests == [stress_report.as_uri()]


def test_quantities_axes_and_shoes_can_be_picked(reader, history):
    plot = reader.page.locator("#plot-0")
    plot.get_by_label("quantity").select_option(label="displacement from equilibrium in m")
    assert reader.shown("data.map((trace) => trace.name)") == [f"shoe {n}" for n in (1, 4, 7, 10, 13)] * 3
    plot.locator(".axes input[value=y]").uncheck()
    plot.locator(".items").get_by_text("none").click()
    assert reader.shown("data.length") == 0
    plot.locator('.items input[value="shoe 12"]').check()
    curves = reader.shown("data.map((trace) => [trace.name, trace.yaxis])")
    assert curves == [["shoe 12", "y"], ["shoe 12", "y2"]]
    assert reader.shown("layout.yaxis2.title.text").startswith("z displacement")
    position = history.position.sel(shoe=12, axis="z")
    assert reader.shown("Array.from(data[1].y)") == pytest.approx(
        (position - position[0]).values, rel=1e-5, abs=1e-12
    )
    plot.locator(".items").get_by_text("all").click()
    assert reader.shown("data.length") == 26
    plot.get_by_label("quantity").select_option(label="spherical joint reaction in kN")
    links = [f"link {n}-{n + 1}" for n in (1, 4, 7, 9, 12)]
    assert reader.shown("data.map((trace) => trace.name)")[:5] == links
    # an axis that was left out stays so for the next quantity of shoes
    plot.locator(".axes input[value=y]").uncheck()
    plot.get_by_label("quantity").select_option(label="acceleration in m/s²")
    assert reader.shown("new Set(data.map((trace) => trace.yaxis)).size") == 2


def test_dragging_zooms_and_a_double_click_shows_everything(reader):
    reader.page.locator("#plot-1").scroll_into_view_if_needed()
    area = reader.page.locator("#plot-1 .figure .nsewdrag").first
    box = area.bounding_box()
    x, y = box["x"] + 0.25 * box["width"], box["y"] + 0.5 * box["height"]
    before = reader.shown("layout.xaxis.range", "#plot-1 .figure")
    for _ in range(5):
        # a page still busy with its other plots loses a drag
        reader.page.mouse.move(x, y)
        reader.page.mouse.down()
        reader.page.mouse.move(x + 0.5 * box["width"], y, steps=5)
        reader.page.mouse.up()
        reader.page.wait_for_timeout(1000)
        if reader.shown("layout.xaxis.range[0] > 0.01", "#plot-1 .figure"):
            break
    low, high = reader.shown("layout.xaxis.range", "#plot-1 .figure")
    span = before[1] - before[0]
    assert low == pytest.approx(before[0] + 0.25 * span, abs=0.02 * span)
    assert high == pytest.approx(before[0] + 0.75 * span, abs=0.02 * span)
    reader.page.mouse.dblclick(x, y)
    reader.wait("layout.xaxis.range[0] < 0.001", "#plot-1 .figure")


@pytest.mark.slow
def test_phases_stand_behind_the_curves(browser, phased, translation, tmp_path):
    """A band each; a name is left out where its band has no room, and comes as the time is zoomed."""
    for history in (phased, translation):
        folder = tmp_path / history.case.name
        folder.mkdir()
        history.save(folder / "history.nc")
    reader = Reader(browser, write_report(tmp_path))
    bands = reader.shown("layout.shapes.map(({ x0, x1, layer }) => [x0, x1, layer])")
    assert [pytest.approx(band[:2]) for band in bands] == list(map(list, BANDS))
    assert {band[2] for band in bands} == {"below"}
    written = "[...document.querySelectorAll('#plot-0 .annotation-text')].map((one) => one.textContent)"
    assert reader.shown(written) == NAMES
    plot = "document.querySelector('#plot-0 .figure')"
    reader.page.evaluate(f"Plotly.relayout({plot}, {{ 'xaxis.range': [0.076, 0.09] }})")
    zoomed = json.dumps(PHASES[1:], separators=(",", ":"))
    reader.page.wait_for_function(f"() => JSON.stringify({written}) === '{zoomed}'")
    reader.page.locator("#plot-0").get_by_label("case").select_option("translation")
    assert reader.shown("[layout.shapes, layout.annotations]") == [[], []]
    assert reader.shown(written) == []
    assert reader.errors == []


def test_a_click_in_the_legend_hides_a_shoe_on_all_axes(reader):
    plot = reader.page.locator("#plot-1")
    names = reader.shown("data.map((trace) => trace.name)", "#plot-1 .figure")
    assert reader.shown("full.every((trace) => trace.visible === true)", "#plot-1 .figure")
    plot.locator(".legendtoggle").first.click()
    reader.wait("full[0].visible === 'legendonly'", "#plot-1 .figure")
    hidden = reader.shown("full.map((trace) => trace.visible === 'legendonly')", "#plot-1 .figure")
    assert hidden == [name == names[0] for name in names]


def show(reader, name):
    """Bring the 3D view of the track or of the shoes on the screen, once it is drawn: its place."""
    place = f"#{name}-view"
    reader.page.locator(place).scroll_into_view_if_needed()
    reader.page.wait_for_function(f"() => report.views.{name} && document.querySelector('{place}').data")
    return place


@pytest.mark.slow
def test_the_whole_track_moves(reader, history):
    """Boxes of rigid and flexible shoes stand where the history has them, and go on when it is played."""
    view = show(reader, "track")
    names = reader.shown("data.map((trace) => trace.name)", view)
    assert names == ["rigid shoes", "flexible shoes", "ground", "contact forces", "contact forces"]
    assert reader.shown("[data[0].x.length, data[1].x.length]", view) == [11 * 8, 2 * 8]
    x0, x1, y0, y1, z0 = history.case.shoe.footprint
    middle = 0.5 * np.array([x0 + x1, y0 + y1, z0 + history.case.shoe.load_point[2]])
    count = reader.page.evaluate("report.views.track.scene.titles.length")
    for number in (0, count - 1):
        reader.page.locator("#track-time").fill(str(number))
        now = history.dataset.isel(time=0 if number == 0 else -1).sel(shoe=[7, 13])
        # the pitch is small, and the middle of a box is near the COM
        places = reader.places(view, 1).reshape(2, 8, 3).mean(axis=1)
        assert places == pytest.approx(now.position.values + middle, abs=5e-3)
    reader.page.locator("#track-time").fill(str(count - 3))
    reader.page.locator("#track-play").click()
    ended = f"report.views.track.now() === {count - 1} && !report.views.track.playing"
    reader.page.wait_for_function(f"() => {ended}")
    reader.page.locator("#track-forces").uncheck()
    assert reader.shown("data.length", view) == 3
    reader.page.locator("[data-camera=above]").click()
    reader.wait("layout.scene.camera.up.y === 1", view)


def test_rollers_stand_where_the_frame_has_them(reader, rolled):
    """What the page's script makes of a packed solid is what pictures draw."""
    shared = SceneArrays()
    track = packed_track(rolled, shared)
    packed = next(one for one in track["solids"] if one["name"] == "rollers")
    drawn = reader.page.evaluate(
        """([solid, arrays, time]) => {
          const own = data.arrays;
          data.arrays = arrays;
          unpacked.clear();
          const { nodes, corners } = solidMesh(solid, time);
          data.arrays = own;
          unpacked.clear();
          return [...nodes, ...corners].map((one) => Array.from(one));
        }""",
        [packed, shared.packed, len(track["titles"]) - 1],
    )
    treads, _ = wheel_solids(History(rolled.case, rolled.dataset.isel(time=[-1])))
    surface = treads.at()
    assert np.transpose(drawn[:3]) == pytest.approx(surface.points, abs=1e-5)
    triangles = np.transpose(drawn[3:])
    assert (np.sort(triangles.ravel()) == np.sort(surface.triangles.ravel())).all()
    assert set(map(tuple, triangles.tolist())) == set(map(tuple, surface.triangles.tolist()))


@pytest.mark.slow
def test_the_time_of_the_shoes_can_be_chosen(reader, stress):
    used = np.unique(stress.triangle.values)
    step = float(stress.frame_von_mises.max()) / 1e6 / 65535  # a page holds stresses as whole numbers of it
    view = show(reader, "shoe")
    pictures, titles = [], ["t = 0 s, begin", "t = 0.06 s, end of constant"]
    # the highest stress is shown first
    first = int(stress.frame_von_mises.max(["shoe", "node"]).values.argmax())
    assert reader.page.evaluate("report.views.shoe.scene.first") == first
    for number, frame in enumerate(stress.frame.values):
        reader.page.locator("#shoe-time").fill(str(number))
        assert reader.page.locator("#shoe-time-shown").text_content() == titles[number]
        for place, shoe in enumerate((7, 13)):
            expected = stress.frame_von_mises.sel(shoe=shoe, frame=frame).values / 1e6
            assert reader.drawn(view, place) == pytest.approx(expected[used], abs=0.51 * step)
            assert reader.shown(f"data[{place}].name", view) == f"shoe {shoe}: {expected.max():.1f} MPa"
        reader.page.wait_for_timeout(1000)
        pictures.append(reader.page.locator(view).screenshot())
    assert pictures[0] != pictures[1]
    high = reader.page.evaluate("report.views.shoe.scene.solids[0].colourings[0].high")
    assert reader.shown("[data[0].cmax, data[1].cmax]", view) == [high] * 2


@pytest.mark.slow
def test_shoes_stand_where_the_history_has_them_and_bend_as_asked(reader, history, stress):
    view = show(reader, "shoe")
    used = np.unique(stress.triangle.values)
    reader.page.locator("#shoe-time").fill(str(len(stress.frame) - 1))
    places = {}
    for factor in (0, 100):
        reader.page.locator("#shoe-bend").fill(str(factor))
        places[factor] = reader.places(view, 1)
    now = history.dataset.isel(time=-1).sel(shoe=13)
    local = stress.node_position.values[used]
    # the pitch is small: the axes are turned by less than 0.05 rad
    assert places[0] == pytest.approx(local + now.position.values, abs=0.05)
    lengths = np.linalg.norm(places[100] - places[0], axis=1)
    bend = stress.frame_displacement.sel(shoe=13).isel(frame=-1).values[used]
    assert lengths == pytest.approx(100.0 * np.linalg.norm(bend, axis=1), abs=1e-4)


@pytest.mark.slow
def test_shoes_can_be_coloured_by_how_far_to_trust_them(reader, stress):
    """Verdicts have colours of their own, the worst of a face's nodes; low stresses are not judged."""
    used, view = np.unique(stress.triangle.values), show(reader, "shoe")
    corners = np.searchsorted(used, stress.triangle.values)
    highest = float(stress.peak_von_mises.isel(node=used).max())
    reader.page.locator("#shoe-colouring").select_option(TRUST)
    words = reader.shown("data[0].colorbar.ticktext", view)
    assert words == [*VERDICTS, "low: below 10 % of the highest"]
    assert reader.shown("data[0].intensitymode", view) == "cell"
    for place, shoe in enumerate((7, 13)):
        chosen = stress.sel(shoe=shoe).isel(node=used)
        known = np.where(chosen.peak_verdict < 0, np.nan, chosen.peak_verdict)
        judged = np.where(chosen.peak_von_mises >= 0.1 * highest, known, np.nan)
        assert 0.0 < np.isfinite(judged).mean() < 0.9
        faces = judged[corners]
        seen = np.isfinite(faces).any(axis=1)
        found = reader.drawn(view, place)
        assert found[seen] == pytest.approx(np.nanmax(faces[seen], axis=1))
        assert set(found[~seen]) <= {len(VERDICTS), np.nan}
    assert reader.shown("data[1].text[0]", view).startswith(f"shoe 13, node {used[0]}: ")
    reader.page.locator("#shoe-colouring").select_option(STRESS)
    assert "von Mises" in reader.shown("data[0].colorbar.title.text", view)


@pytest.mark.slow
def test_pictures_and_rows_can_be_chosen(reader):
    page = reader.page
    figures = page.locator("figure.picture")
    # the highest stress is shown first
    first = page.evaluate("data.first_picture")
    assert [figures.nth(k).is_visible() for k in range(2)] == [k == first for k in range(2)]
    page.locator("#picture-buttons button").nth(1 - first).click()
    assert [figures.nth(k).is_visible() for k in range(2)] == [k != first for k in range(2)]
    assert figures.nth(1 - first).locator("img").evaluate("(image) => image.naturalWidth") > 1000
    rows = page.locator("#comparison-table tbody tr")
    page.get_by_label("outside").check()
    shown = [rows.nth(k).get_attribute("class") for k in range(rows.count()) if rows.nth(k).is_visible()]
    assert set(shown) == {"outside"}
    page.get_by_label("all rows").check()
    assert all(rows.nth(k).is_visible() for k in range(rows.count()))


@pytest.mark.slow
def test_cases_can_be_compared(browser, rigid_folders, tmp_path):
    reader = Reader(browser, write_report(rigid_folders[0], tmp_path / "report.html"))
    turning = History.load(rigid_folders[0] / "turning" / "history.nc")
    reader.page.locator("#plot-0").get_by_label("case").select_option("turning")
    assert reader.shown("report.plots[0].quantity.label") == "velocity"
    drawn = reader.shown("Array.from(data[0].y)")
    assert drawn == pytest.approx(turning.velocity.sel(shoe=1, axis="x").values, rel=1e-5, abs=1e-12)
    assert reader.errors == []
    assert len(reader.requests) == 1
