"""The report of a folder: what it holds, and how it answers in a browser.

The browser is a Chromium found on the machine, driven without a display; nothing may leave the page.
"""

import base64
import json
import re
import shutil

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from exudyn_crawler import History
from exudyn_crawler.results.contacts import contacts_of
from exudyn_crawler.views.report.data import quantities, thinned
from exudyn_crawler.views.report.page import case_rows, hot_spot_tables, report_page, write_report
from exudyn_crawler.views.stress_pictures import write_stress_pictures
from exudyn_crawler.views.tables import write_table
from studies.comparison import comparison_table
from studies.forces import study as forces_study
from studies.kinematics import study as kinematics_study
from studies.reported import reported_values

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
LIMIT = 15e6
"""Bytes that the report of a stress study may have."""


def data_of(page):
    return json.loads(re.search(r'id="report-data">(.*?)</script>', page, re.DOTALL)[1])


def unpacked(text, kind):
    return np.frombuffer(base64.b64decode(text), dtype=f"<{kind}")


def series_of(data, case, label, item, axis):
    """Times and values that the page draws."""
    packed = data["cases"][case]
    quantity = next(q for q in packed["quantities"] if q["label"] == label)
    index, values = quantity["series"][quantity["items"].index(item)][quantity["axes"].index(axis)]
    times = unpacked(packed["times"][quantity["time"]], "f4")
    return times[unpacked(index, quantity["index"])], unpacked(values, "f4")


@pytest.fixture(scope="module")
def stress_folder(flexible_run, tmp_path_factory):
    """Folder as the stress study leaves it, of a short run."""
    history, stress, hot_spots = flexible_run
    folder = tmp_path_factory.mktemp("stress")
    history.save(folder / "history.nc")
    stress.to_netcdf(folder / "stress.nc", engine="h5netcdf")
    for shoe, table in hot_spots.items():
        write_table(table, folder / f"hot_spots_shoe_{shoe}.csv")
    reported = reported_values("stress")
    # within, without verdict and outside; the rest was not computed
    computed = [value * (1.0 if row % 3 else 10.0) for row, value in enumerate(reported["value"])]
    write_table(comparison_table(reported, [*computed[:-1], np.nan]), folder / "comparison.csv")
    write_stress_pictures(stress, history, folder, backend="plain")
    (folder / "run.json").write_text('{"wall time": "<1 s"}')
    return folder


@pytest.fixture(scope="module")
def stress_page(stress_folder):
    return report_page(stress_folder)


@given(arrays(np.float64, st.integers(1, 500), elements=st.floats(-1e6, 1e6)), st.integers(10, 300))
def test_a_thinned_series_keeps_ends_and_extremes(values, points):
    kept = thinned(values, points)
    assert np.all(np.diff(kept) > 0)
    assert {0, len(values) - 1} <= set(kept.tolist())
    assert values[kept].min() == values.min()
    assert values[kept].max() == values.max()
    assert len(kept) <= max(points, 3)
    if len(values) <= points:
        assert len(kept) == len(values)


def test_a_short_spike_survives_anywhere():
    for place in range(0, 20_000, 611):
        values = np.sin(np.arange(20_000) * 1e-3)
        values[place] = 7.0
        assert place in thinned(values, 900)


def test_series_on_the_page_are_those_of_the_history(flexible_run, stress_page):
    history, stress, _ = flexible_run
    data = data_of(stress_page)
    time, velocity = series_of(data, "stress", "velocity", "shoe 13", "x")
    assert time == pytest.approx(history.time.values, rel=1e-6)
    assert velocity == pytest.approx(history.velocity.sel(shoe=13, axis="x").values, rel=1e-6)
    _, force = series_of(data, "stress", "contact force", "shoe 7", "z")
    contacts = contacts_of(history.dataset).contact_force.sel(shoe=7, axis="z")
    assert force == pytest.approx(contacts.values, rel=1e-6)
    _, highest = series_of(data, "stress", "highest von Mises stress", "shoe 7", "")
    assert highest == pytest.approx(stress.highest_von_mises.sel(shoe=7).values / 1e6, rel=1e-6)
    _, pin = series_of(data, "stress", "pin force", "link 12-13 left", "x")
    assert pin == pytest.approx(history.pin_force.sel(joint=12, pin="left", axis="x").values, rel=1e-6)


def test_rigid_links_have_no_pins_to_pick(flexible_run):
    history, stress, _ = flexible_run
    found = {quantity.label: quantity for quantity in quantities(history.dataset, stress)}
    pins = set(found["pin force"].values["item"].values.tolist())
    assert pins == {f"link {link} {side}" for link in ("6-7", "7-8", "12-13") for side in ("right", "left")}


def test_the_page_has_every_section_and_its_numbers(stress_folder, stress_page):
    for heading in ("Paper against computed", "Time histories", "Hot spots", "Flexible shoes in 3D"):
        assert f"<h2>{heading}</h2>" in stress_page
    table = pd.read_csv(stress_folder / "comparison.csv", keep_default_na=False)
    for verdict, name in (("yes", "within"), ("no", "outside"), ("", "none")):
        assert stress_page.count(f'<tr class="{name}">') == (table["within"] == verdict).sum() > 0
    spots = pd.read_csv(stress_folder / "hot_spots_shoe_13.csv")
    assert f"<td>{spots['value'][0] / 1e6:.5g}</td>" in stress_page
    assert stress_page.count("data:image/webp;base64,") == 2
    assert "{&#34;wall time&#34;: &#34;&lt;1 s&#34;}" in stress_page
    assert "Every stored time is drawn." in stress_page


def test_places_of_hot_spots_are_given_in_the_shoe_whatever_the_table_has(flexible_run, tmp_path):
    history, stress, hot_spots = flexible_run
    history.save(tmp_path / "history.nc")
    stress.to_netcdf(tmp_path / "stress.nc", engine="h5netcdf")
    local = hot_spots[7].copy()
    local[["x", "y", "z"]] = stress.node_position.values[local["node"]]
    in_track = local.assign(x=local["x"] + 13.8)
    write_table(local, tmp_path / "hot_spots_shoe_7.csv")
    write_table(in_track, tmp_path / "hot_spots_shoe_13.csv")
    of_shoe, of_track = (table["html"] for table in hot_spot_tables(tmp_path, stress))
    x, y, z = local.loc[0, ["x", "y", "z"]]
    for html in (of_shoe, of_track):
        assert f"<td>{x:.4f}, {y:.4f}, {z:.4f}</td>" in html
    assert f"<td>{x + 13.8:.4f}, {y:.4f}, {z:.4f}</td>" in of_track
    assert "at t = 0" not in of_shoe


def test_the_case_is_listed_with_units(flexible_run):
    history, _, _ = flexible_run
    rows = {row["name"]: row for row in case_rows(history.case)}
    assert rows["shoe.mass"] == {
        "name": "shoe.mass", "value": "4681.67", "unit": "kg", "meaning": "mass",
    }  # fmt: skip
    assert rows["flexible.youngs_modulus"]["value"] == "2e+11"
    assert rows["flexible.shoes"]["value"] == "7, 13"
    assert rows["loads.constant"]["value"] == ", ".join(["386400"] * 13)
    assert rows["drive.speed"]["unit"] == "m/s"


def test_a_long_stress_study_stays_below_the_limit(flexible_run, stress_folder, tmp_path):
    """20 000 stored times of all shoes with many wiggles, eight chosen times of six shoes."""
    history, stress, _ = flexible_run
    count = 20_000
    back_and_forth = np.abs(np.arange(count) % (2 * (history.dataset.sizes["time"] - 1)) - 30)
    time = 0.002 * np.arange(count)
    longer = history.dataset.isel(time=back_and_forth).assign_coords(time=time)
    History(history.case, longer).save(tmp_path / "history.nc")
    shoes = np.tile(stress.shoe.values, 3)
    over_time = stress[["highest_von_mises"]].isel(time=back_and_forth).assign_coords(time=time)
    at_frames = stress.drop_dims("time").isel(frame=np.arange(8) % 2).assign_coords(frame=5.0 * np.arange(8))
    wide = xr.merge([over_time, at_frames]).sel(shoe=shoes)
    wide.to_netcdf(tmp_path / "stress.nc", engine="h5netcdf")
    for picture in stress_folder.glob("stress_*.png"):
        for number in range(4):
            shutil.copy(picture, tmp_path / f"stress_{number}{picture.stem[-7:]}.png")
    path = write_report(tmp_path)
    assert path.stat().st_size < LIMIT
    page = path.read_text(encoding="utf-8")
    assert "Of the 20000 stored times each curve keeps the least and the greatest value" in page
    _, force = series_of(data_of(page), "stress", "velocity", "shoe 1", "x")
    assert 200 <= len(force) < 2000
    values = history.velocity.sel(shoe=1, axis="x")
    assert force.max() == pytest.approx(float(values.max()), rel=1e-6)
    assert force.min() == pytest.approx(float(values.min()), rel=1e-6)


@pytest.fixture(scope="module")
def rigid_folders(tmp_path_factory):
    """What short runs of the two rigid studies leave."""
    kinematics, forces = (tmp_path_factory.mktemp(name) for name in ("kinematics", "forces"))
    kinematics_study(kinematics, duration=0.02)
    forces_study(forces, duration=0.02, reuse=kinematics)
    return kinematics, forces


def test_rigid_studies_are_reported_too(rigid_folders):
    for folder in rigid_folders:
        page = write_report(folder).read_text(encoding="utf-8")
        assert list(data_of(page)["cases"]) == ["translation", "turning"]
        assert "<h2>Paper against computed</h2>" in page
        assert "Stress pictures" not in page
    for table in ("turning_ratios.csv", "turning/extremes.csv"):
        assert table in page
    time, _ = series_of(data_of(page), "turning", "total terrain deformation from equilibrium", "track", "")
    assert time[-1] == pytest.approx(0.02)


def test_a_studys_page_shows_the_flexible_shoes_of_its_run(stress_folder, tmp_path):
    shutil.copytree(stress_folder, tmp_path / "cycle", ignore=shutil.ignore_patterns("comparison.csv"))
    shutil.copy(stress_folder / "comparison.csv", tmp_path)
    page = report_page(tmp_path)
    for heading in ("Paper against computed", "Time histories", "Hot spots", "Flexible shoes in 3D"):
        assert f"<h2>{heading}</h2>" in page
    assert page.count("data:image/webp;base64,") == 2
    assert data_of(page)["shoes"] == data_of(report_page(stress_folder))["shoes"]


def test_a_comparison_alone_is_a_report_even_if_nothing_was_judged(tmp_path):
    reported = reported_values("kinematics")
    write_table(comparison_table(reported, [np.nan] * len(reported)), tmp_path / "comparison.csv")
    page = write_report(tmp_path).read_text(encoding="utf-8")
    assert page.count('<tr class="none">') == len(reported)
    assert "<h2>Time histories</h2>" not in page
    assert len(page) < 100_000


def test_what_cannot_be_reported_is_refused(tmp_path, stress_folder):
    with pytest.raises(NotADirectoryError, match="no folder"):
        write_report(tmp_path / "nowhere")
    with pytest.raises(FileNotFoundError, match="holds neither a history nor a comparison"):
        write_report(tmp_path)
    (tmp_path / "report.html").write_text("mine")
    with pytest.raises(FileExistsError, match=r"report\.html exists"):
        write_report(stress_folder, tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text() == "mine"
    (tmp_path / "comparison.csv").write_text("quantity\n")
    with pytest.raises(ValueError, match=r"comparison\.csv has no column 'within'"):
        write_report(tmp_path, overwrite=True)


class Reader:
    """A reader of the page: what went wrong, what was asked for, and what the plots show."""

    def __init__(self, browser, path):
        self.page = browser.new_page(viewport={"width": 1300, "height": 900})
        self.errors, self.requests = [], []
        self.page.on("console", lambda m: self.errors.append(m.text) if m.type == "error" else None)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.route("**/*", self.allow_only(path.as_uri()))
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("body[data-ready=yes]")

    def allow_only(self, address):
        """Handler of requests that notes all and lets one address through."""

        def decide(route):
            self.requests.append(route.request.url)
            if route.request.url == address:
                route.continue_()
            else:
                route.abort()

        return decide

    def shown(self, what, plot="#plot-0 .figure"):
        """Value of an expression of the plot's data and layout."""
        return self.page.evaluate(
            f"() => {{ const {{ data, _fullData: full, layout }} = document.querySelector('{plot}');"
            f" return {what}; }}"
        )

    def wait(self, what, plot="#plot-0 .figure"):
        """Wait until an expression of the plot's data and layout holds."""
        self.page.wait_for_function(
            f"() => {{ const {{ data, _fullData: full, layout }} = document.querySelector('{plot}');"
            f" return {what}; }}"
        )


@pytest.fixture(scope="module")
def browser():
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with sync_api.sync_playwright() as driver:
        # containers without user namespaces have no sandbox; 3D is drawn in software
        started = driver.chromium.launch(
            executable_path=CHROMIUM,
            args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        )
        yield started
        started.close()


@pytest.fixture(scope="module")
def reader(browser, stress_folder, tmp_path_factory):
    path = write_report(stress_folder, tmp_path_factory.mktemp("page") / "report.html")
    reader = Reader(browser, path)
    yield reader
    # after all that the tests did to the page
    assert reader.errors == []
    assert reader.requests == [path.as_uri()]


def test_the_page_opens_without_errors_or_requests(reader):
    reader.page.wait_for_timeout(500)
    assert reader.errors == []
    assert len(reader.requests) == 1
    assert reader.page.title() == "Crawler track: stress"


def test_quantities_axes_and_shoes_can_be_picked(reader, flexible_run):
    history, _, _ = flexible_run
    plot = reader.page.locator("#plot-0")
    plot.get_by_label("quantity").select_option(label="displacement from equilibrium in m")
    assert reader.shown("data.map((trace) => trace.name)") == [f"shoe {n}" for n in (1, 4, 7, 10, 13)] * 3
    plot.locator(".axes input[value=y]").uncheck()
    plot.locator(".items").get_by_text("none").click()
    assert reader.shown("data.length") == 0
    plot.locator('.items input[value="shoe 12"]').check()
    assert reader.shown("data.map((trace) => [trace.name, trace.yaxis])") == [
        ["shoe 12", "y"],
        ["shoe 12", "y2"],
    ]
    assert reader.shown("layout.yaxis2.title.text").startswith("z displacement")
    position = history.position.sel(shoe=12, axis="z")
    drawn = reader.shown("Array.from(data[1].y)")
    assert drawn == pytest.approx((position - position[0]).values, rel=1e-5, abs=1e-12)
    plot.locator(".items").get_by_text("all").click()
    assert reader.shown("data.length") == 26
    plot.get_by_label("quantity").select_option(label="spherical joint reaction in N")
    assert reader.shown("data.map((trace) => trace.name)")[:5] == [
        f"link {n}-{n + 1}" for n in (1, 4, 7, 10, 12)
    ]
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


def test_a_click_in_the_legend_hides_a_shoe_on_all_axes(reader):
    plot = reader.page.locator("#plot-1")
    names = reader.shown("data.map((trace) => trace.name)", "#plot-1 .figure")
    assert reader.shown("full.every((trace) => trace.visible === true)", "#plot-1 .figure")
    plot.locator(".legendtoggle").first.click()
    reader.wait("full[0].visible === 'legendonly'", "#plot-1 .figure")
    hidden = reader.shown("full.map((trace) => trace.visible === 'legendonly')", "#plot-1 .figure")
    assert hidden == [name == names[0] for name in names]


def test_the_time_of_the_shoes_can_be_chosen(reader, flexible_run):
    _, stress, _ = flexible_run
    used = np.unique(stress.triangle.values)
    view = "#shoe-view"
    reader.page.locator("#shoes").scroll_into_view_if_needed()
    pictures = []
    for number, frame in enumerate(stress.frame.values):
        reader.page.locator("#shoe-time").fill(str(number))
        assert reader.page.locator("#shoe-time-shown").text_content() == f"t = {frame:g} s"
        for place, shoe in enumerate((7, 13)):
            expected = stress.frame_von_mises.sel(shoe=shoe, frame=frame).values / 1e6
            drawn = reader.shown(f"Array.from(data[{place}].intensity)", view)
            assert drawn == pytest.approx(expected[used], abs=1e-3)
            assert reader.shown(f"data[{place}].name", view) == f"shoe {shoe}: {expected.max():.1f} MPa"
        reader.page.wait_for_timeout(1000)
        pictures.append(reader.page.locator("#shoe-view").screenshot())
    assert pictures[0] != pictures[1]
    assert (
        reader.shown("[data[0].cmax, data[1].cmax]", view)
        == [reader.page.evaluate("report.shoes.shoes.limit")] * 2
    )


def test_shoes_stand_where_the_history_has_them_and_bend_as_asked(reader, flexible_run):
    history, stress, _ = flexible_run
    used = np.unique(stress.triangle.values)
    last = len(stress.frame) - 1
    reader.page.locator("#shoe-time").fill(str(last))
    places = {}
    for factor in (0, 100):
        reader.page.locator("#shoe-bend").fill(str(factor))
        places[factor] = np.array(
            reader.shown("['x', 'y', 'z'].map((a) => Array.from(data[1][a]))", "#shoe-view")
        ).T
    now = history.dataset.isel(time=-1).sel(shoe=13)
    local = stress.node_position.values[used]
    # the pitch is small: the axes are turned by less than 0.05 rad
    assert places[0] == pytest.approx(local + now.position.values, abs=0.05)
    lengths = np.linalg.norm(places[100] - places[0], axis=1)
    bend = stress.frame_displacement.sel(shoe=13).isel(frame=-1).values[used]
    assert lengths == pytest.approx(100.0 * np.linalg.norm(bend, axis=1), abs=1e-4)


def test_pictures_and_rows_can_be_chosen(reader):
    page = reader.page
    figures = page.locator("figure.picture")
    assert [figures.nth(k).is_visible() for k in range(2)] == [True, False]
    page.locator("#picture-buttons button").nth(1).click()
    assert [figures.nth(k).is_visible() for k in range(2)] == [False, True]
    assert figures.nth(1).locator("img").evaluate("(image) => image.naturalWidth") > 1000
    rows = page.locator("#comparison-table tbody tr")
    page.get_by_label("outside").check()
    shown = [rows.nth(k).get_attribute("class") for k in range(rows.count()) if rows.nth(k).is_visible()]
    assert shown
    assert set(shown) == {"outside"}
    page.get_by_label("all rows").check()
    assert all(rows.nth(k).is_visible() for k in range(rows.count()))


def test_cases_can_be_compared(browser, rigid_folders, tmp_path):
    reader = Reader(browser, write_report(rigid_folders[0], tmp_path / "report.html"))
    turning = History.load(rigid_folders[0] / "turning" / "history.nc")
    reader.page.locator("#plot-0").get_by_label("case").select_option("turning")
    assert reader.shown("report.plots[0].quantity.label") == "velocity"
    drawn = reader.shown("Array.from(data[0].y)")
    assert drawn == pytest.approx(turning.velocity.sel(shoe=1, axis="x").values, rel=1e-5, abs=1e-12)
    assert reader.errors == []
    assert len(reader.requests) == 1
