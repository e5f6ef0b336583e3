"""The report of a folder: what the page holds."""

import json
import re
import shutil

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import Case, History, recover_stresses, simulate
from exudyn_crawler.case.ph4100c import STRESS_SHOE_MASS
from exudyn_crawler.results.history.summary import HELD, key_results, start_ends
from exudyn_crawler.run.folder.record import note_file
from exudyn_crawler.views.figures import history_series
from exudyn_crawler.views.pages.first_screen import first_screen
from exudyn_crawler.views.pages.page import Section, page, paragraph
from exudyn_crawler.views.pages.report import LONGEST_TABLE, provenance, report_page, write_report
from exudyn_crawler.views.scenes.shoes import first_frame, frame_titles
from exudyn_crawler.views.tables import write_table
from studies.comparison import comparison_table, reported_values
from tests.views.test_figures import BANDS, PHASES
from tests.views.test_packing import data_of, unpacked

LIMIT = 20e6
"""Bytes that the report of a stress study may have."""


def series_of(data, case, label, item, axis):
    """Times and values that the page draws."""
    packed = data["cases"][case]
    quantity = next(q for q in packed["quantities"] if q["label"] == label)
    index, values = quantity["series"][quantity["items"].index(item)][quantity["axes"].index(axis)]
    times = unpacked(packed["time"], "f4")
    return times[unpacked(index, packed["index"])], unpacked(values, "f4")


@pytest.fixture(scope="module")
def stress_page(stress_report):
    return stress_report.read_text(encoding="utf-8")


def test_series_on_the_page_are_those_of_the_history(history, stress, stress_page):
    data = data_of(stress_page)
    time, velocity = series_of(data, "stress", "velocity", "shoe 13", "x")
    assert time == pytest.approx(history.time.values, rel=1e-6)
    assert velocity == pytest.approx(history.velocity.sel(shoe=13, axis="x").values, rel=1e-6)
    _, force = series_of(data, "stress", "contact force", "shoe 7", "z")
    contact = history.contacts_by_shoe().contact_force.sel(shoe=7, axis="z")
    assert force == pytest.approx(1e-3 * contact.values, rel=1e-6)
    _, highest = series_of(data, "stress", "highest von Mises stress", "shoe 7", "")
    assert highest == pytest.approx(stress.highest_von_mises.sel(shoe=7).values / 1e6, rel=1e-6)
    _, pin = series_of(data, "stress", "pin force", "link 12-13 left", "x")
    assert pin == pytest.approx(1e-3 * history.pin_force.sel(joint=12, pin="left", axis="x").values, rel=1e-6)


def test_the_page_knows_the_phases_of_each_case_that_has_several(phased, translation, tmp_path):
    for name, history in (("own", phased), ("constant", translation)):
        (tmp_path / name).mkdir()
        history.save(tmp_path / name / "history.nc")
    cases = data_of(report_page(tmp_path))["cases"]
    spans = zip(PHASES, [*BANDS[:-1], (0.084, pytest.approx(0.12))], strict=True)
    expected = [{"name": name, "begin": begin, "end": end} for name, (begin, end) in spans]
    assert cases["phased"]["phases"] == expected
    assert cases["translation"]["phases"] == []


def test_rigid_links_have_no_pins_to_pick(history, stress):
    found = history_series(history, stress)
    pins = set(found["pin force"].values["item"].values.tolist())
    assert pins == {f"link {link} {side}" for link in ("6-7", "7-8", "12-13") for side in ("right", "left")}


def test_the_page_has_every_section_and_its_numbers(stress_folder, stress_page):
    for heading in ("Paper against computed", "Time histories", "Hot spots", "Flexible shoes in 3D"):
        assert f"<h2>{heading}</h2>" in stress_page
    table = pd.read_csv(stress_folder / "comparison.csv", keep_default_na=False)
    for verdict, name in (("yes", "within"), ("no", "outside"), ("", "none")):
        assert stress_page.count(f'<tr class="{name}">') == (table["within"] == verdict).sum() > 0
    spots = pd.read_csv(stress_folder / "hot_spots_shoe_13.csv")
    assert f">{spots['von Mises in MPa'][0]:.5g}</td>" in stress_page
    assert stress_page.count("data:image/webp;base64,") == 2
    assert "{&#34;wall time&#34;: &#34;&lt;1 s&#34;, " in stress_page
    assert "Every stored time is drawn." in stress_page


def test_the_page_opens_with_key_results_versions_and_dates(stress_page, history, stress):
    head = stress_page.split("<main>")[0]
    assert f"stress: 0.06 s, {history.time.size} stored times" in head
    assert f"exudyn-crawler {history.dataset.attrs['exudyn_crawler_version']}; exudyn 1." in head
    assert "done 2026-03-01 10:20 UTC after 81 s; page made 20" in head
    highest = f'<td class="number">{float(stress.highest_von_mises.max()) / 1e6:.4g} MPa</td>'
    assert f"<td>highest von Mises stress</td>{highest}<td>shoe 13, t = " in head


def test_a_stress_that_is_not_to_be_used_stands_behind_the_first_answer(history, stress):
    held = int(np.flatnonzero(stress.in_spider.values)[5])
    raised = stress.peak_von_mises.copy()
    raised.loc[{"shoe": 13, "node": held}] = 3.0 * raised.max()
    higher = stress.assign(peak_von_mises=raised)
    head = str(first_screen(history, key_results(history, higher), higher))
    verdict = "beside a pin coupling: do not use"
    assert head.index("highest von Mises stress") < head.index(HELD) < head.index(verdict)
    assert head.count(verdict) == 1
    assert verdict not in str(first_screen(history, key_results(history, stress), stress))


def test_the_first_screen_says_what_was_simulated_and_answers(stress_page, history, stress):
    head = stress_page.split("<main>")[0]
    assert "Track of 13 shoes, pulled at its front shoe; 2 flexible: " in head
    assert f" m in {history.duration:.4g} s on elastic ground of blocks on springs." in head
    assert "Extremes are one draw: " in head
    highest = f"<b>{float(stress.highest_von_mises.max()) / 1e6:.4g} MPa</b>"
    assert f"<dt>highest von Mises stress</dt><dd>{highest} shoe 13, t = " in head
    assert head.count("<dt>") == 5
    assert 'alt="stress from the right"' in head
    start = history.dataset.isel(time=0)
    carried = float((start.normal_force + start.friction_force).sel(axis="z").sum())
    force = history.over_time(["contact_force"])["contact_force"]
    after = force.sel(time=slice(start_ends(history), None))
    greatest = float(after.pipe(np.linalg.norm, axis=-1).max())
    assert f"{100.0 * greatest / carried:.3g} % of the load on the ground at the start" in head


def test_answers_of_a_closed_track_say_each_thing_once():
    """The force of a link is there the tension of the chain; pressure and torque come before it."""
    case = Case.closed().with_({"gear.torque_limit": 2e6})
    history = simulate(case, 0.004, progress=False)
    results = key_results(history)
    head = str(first_screen(history, results))
    names = re.findall("<dt>(.*?)</dt>", head)
    assert names[:4] == [
        "greatest tension of the chain",
        "greatest force on a roller",
        "greatest ground pressure below a shoe",
        "greatest torque of the drive",
    ]
    assert len(names) == 5
    torque = results.set_index("result").loc["greatest torque of the drive", "value"]  # kN m
    assert f"{100.0 * torque / 2e3:.3g} % of the drive" in head


@pytest.mark.parametrize(
    "record", ["", "[]", "{", '{"finished": 3}', '{"finished": "soon", "status": "done"}']
)
def test_a_broken_record_is_refused_by_name(history, tmp_path, record):
    (tmp_path / "run.json").write_text(record)
    with pytest.raises(ValueError, match=r"run\.json cannot be read: "):
        provenance(tmp_path, {"stress": history})


def test_the_head_has_the_date_and_commit_of_a_record_that_has_them(history, tmp_path):
    histories = {"stress": history}
    _, no_record = provenance(tmp_path, histories)
    assert "page made" in no_record
    assert "after" not in no_record
    for commit in ("0123456789ab, changed", ""):
        (tmp_path / "run.json").write_text(json.dumps({"commit": commit}))
        _, line = provenance(tmp_path, histories)
        assert ("commit 0123456789ab, changed" in line) if commit else ("commit" not in line)


def test_the_peak_is_shown_first_and_named_after_the_phases(history, stress):
    assert frame_titles(stress) == ["t = 0 s, begin", "t = 0.06 s, end of constant"]
    results = recover_stresses(history)
    highest = results.dataset.highest_von_mises.max("shoe")
    peak = float(history.time[int(highest.values.argmax())])
    at = first_frame(results.dataset)
    assert float(results.dataset.frame[at]) == pytest.approx(peak)
    assert "peak" in frame_titles(results.dataset)[at].split(", ")
    shown = results.dataset.frame_von_mises.isel(frame=at).where(~results.dataset.at_load).max()
    assert float(shown) == pytest.approx(float(highest.max()), rel=1e-6)
    assert first_frame(stress) == int(stress.frame_von_mises.max(["shoe", "node"]).values.argmax())


def test_long_tables_are_left_to_the_plots(history, tmp_path):
    history.save(tmp_path / "history.nc")
    for name, rows in (("short", LONGEST_TABLE), ("long", LONGEST_TABLE + 1)):
        write_table(pd.DataFrame({"time in s": np.arange(rows)}), tmp_path / f"{name}.csv")
    page = report_page(tmp_path)
    assert "<summary>short.csv</summary>" in page
    assert "long.csv" not in page


def test_the_case_is_listed_with_units(stress_page):
    for row in (
        ("shoe.mass", f"{STRESS_SHOE_MASS} kg", "mass of a shoe"),
        ("flexible.youngs_modulus", "200 GPa", "Young&#39;s modulus E"),
        ("flexible.shoes", "7, 13", "numbers of the flexible shoes"),
        ("loads.phases[0].loads", "13 x 386.4 kN", "downward loads on shoes 1 to n at the phase&#39;s end"),
    ):
        assert "<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" in stress_page


@pytest.mark.slow
def test_a_long_stress_study_stays_below_the_limit(history, stress, stress_folder, tmp_path):
    """20 000 stored times of all shoes with many wiggles, eight chosen times of six shoes."""
    count = 20_000
    back_and_forth = np.abs(np.arange(count) % (2 * (history.dataset.sizes["time"] - 1)) - 30)
    time = 0.002 * np.arange(count)
    longer = history.dataset.isel(time=back_and_forth).assign_coords(time=time)
    History(history.case, longer).save(tmp_path / "history.nc")
    shoes = np.tile(stress.shoe.values, 3)
    over_time = stress[["highest_von_mises"]].isel(time=back_and_forth).assign_coords(time=time)
    at_frames = stress.drop_dims("time").isel(frame=np.arange(8) % 2).assign_coords(frame=5.0 * np.arange(8))
    wide = xr.merge([over_time, at_frames]).sel(shoe=shoes).assign_coords(shoe=1 + np.arange(len(shoes)))
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


@pytest.mark.slow
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


def test_a_studys_page_shows_the_flexible_shoes_of_its_run(stress_folder, stress_page, tmp_path):
    shutil.copytree(stress_folder, tmp_path / "cycle", ignore=shutil.ignore_patterns("comparison.csv"))
    shutil.copy(stress_folder / "comparison.csv", tmp_path)
    path = tmp_path / "cycle" / "history.nc"
    loaded = History.load(path)
    path.write_bytes(b"not read again")
    page = report_page(tmp_path, {path: loaded})
    assert re.findall("<h2>.*?</h2>", page) == re.findall("<h2>.*?</h2>", stress_page)
    assert page.count("data:image/webp;base64,") == 2
    assert data_of(page)["scenes"]["shoe"] == data_of(stress_page)["scenes"]["shoe"]


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


BROKEN = {
    "run.json": b"\xff{",
    "case.toml": b"\xff\xfe",
    "stress.nc": b"\x89HDF\r\n\x1a\n broken",
    "loads.csv": b'a,b\n1,2,3\n"4',
    "hot_spots_shoe_7.csv": b'rank,node\n1,2,3\n"4',
    "stress_000.0600s.png": b"no picture",
    "comparison.csv": b"quantity\n",
}


@pytest.mark.parametrize("name", [*BROKEN, "history.nc"])
def test_a_broken_file_is_refused_by_name(translation, tmp_path, name):
    content = translation.save(tmp_path / "history.nc").read_bytes()
    (tmp_path / name).write_bytes(BROKEN.get(name, content[: len(content) // 2]))
    problem = "must hold a history: " if name == "history.nc" else ""
    with pytest.raises(ValueError, match=f"^{re.escape(str(tmp_path / name))} {problem}"):
        write_report(tmp_path)
    assert not (tmp_path / "report.html").exists()


def test_a_report_touches_nothing_that_the_record_names(translation, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    translation.save(folder / "history.nc")
    (tmp_path / "precious.csv").write_text("mine")
    names = ["../precious.csv", str(tmp_path / "precious.csv"), "/etc/passwd", 7, None, ""]
    (folder / "run.json").write_text(json.dumps({"files": names}))
    assert "mine" not in re.sub(r"<script.*?</script>", "", report_page(folder), flags=re.DOTALL)
    note_file(write_report(folder))
    assert json.loads((folder / "run.json").read_text())["files"] == ["report.html"]
    assert (tmp_path / "precious.csv").read_text() == "mine"


def test_no_name_breaks_a_page(translation, tmp_path):
    name = "a <!--<script> </script> $x_1$ name"
    named = translation.case.model_copy(update={"name": name})
    History(named, translation.dataset).save(tmp_path / "history.nc")
    text = report_page(tmp_path)
    assert list(data_of(text)["cases"]) == [name]
    assert "<h1>Crawler track: a &lt;!--&lt;script&gt; &lt;/script&gt; $x_1$" in text
    own = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    assert "<!--" not in own


def test_sections_without_content_are_left_out():
    text = page("a title", ["lead"], [Section("a", "First", paragraph("<b>")), Section("b", "Second", "")])
    for shown in ('<section id="a">', "<h1>a title</h1>", "<p>&lt;b&gt;</p>"):
        assert shown in text
    assert "Second" not in text
    assert "plotly" not in text.lower()


def test_page_of_a_machine_from_its_datasheet_says_where_every_value_comes_from(translation, tmp_path):
    from exudyn_crawler.machines import read_case
    from exudyn_crawler.machines.datasheet import library
    from exudyn_crawler.views.outputs import write_origins

    translation.save(tmp_path / "history.nc")
    machine = read_case(library.machines()["pc300lc"])
    write_origins(machine, tmp_path)
    html = write_report(tmp_path).read_text()
    assert 'id="origins"' in html
    assert "track.pitch" in html
    assert "the chain of N shoes closes" in html
    assert "remembered: not seen in a source" in html
    assert f"{machine.datasheet.source}" in html
    # it has a section of its own
    assert "origins.csv" not in html.split("Further tables")[-1]
