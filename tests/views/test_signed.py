"""The report to sign: the numbers of the page on two to four sheets."""

import re
from dataclasses import replace

import pytest

from exudyn_crawler import write_signed
from exudyn_crawler.cli import looking
from exudyn_crawler.results.history import summary
from exudyn_crawler.views.pages import signed, signed_run
from exudyn_crawler.views.pages.first_screen import sentence, shown_name
from exudyn_crawler.views.pages.report import report_page
from exudyn_crawler.views.pages.signed import Rows, SignedReport

typst = pytest.importorskip("typst", reason="typst is not installed (extra 'report')")

ORIGINS = """key,value,origin,how
shoe.width,0.8 m,of the library's machine,sales sheet
shoe.mass,58.879467 kg,derived,by density
gear.rolling_resistance,0.0312345 1,assumed,0.02 to 0.06
solver.step,0.002 s,assumed,"of all machines, chosen: no datasheet says it"
"""
HARMLESS = SignedReport(
    kind="Run",
    title="a # machine",
    facts=(("machine", "*of* #panic()"),),
    question="$x < y$ [or] @not?",
    lines=("`code`",),
    answers=Rows(("answer",), (("1 \\ 2",),)),
    given_words="",
    given=(),
    assumed_words="",
    assumed=(),
    validity=("One.", "Two.", "Three."),
    checksums=(("a.toml", "0" * 64),),
)


@pytest.fixture(scope="module")
def folder(translation, tmp_path_factory):
    """Folder of a run with a ledger."""
    made = tmp_path_factory.mktemp("run")
    translation.save(made / "history.nc")
    (made / "origins.csv").write_text(ORIGINS)
    (made / "case.toml").write_text("name = 'translation'\n")
    return made


def test_a_run_has_the_answers_of_its_page(folder, translation):
    found = signed_run.run_report(folder)
    html = report_page(folder)
    shown = re.findall(r"<dt>(.*?)</dt><dd><b>(.*?)</b>", html)
    assert [row[:2] for row in found.answers.rows[: len(shown)]] == shown
    results = summary.key_results(translation)
    assert {row[0] for row in found.answers.rows} == {
        shown_name(name) for name in results["result"] if not name.endswith(summary.START)
    }
    assert found.lines == (sentence(translation, results),)
    assert translation.case.gear.words(translation.case) in dict(found.facts).values()


def test_what_is_given_and_assumed_is_told_apart(folder):
    found = signed_run.run_report(folder)
    assert found.given == (("shoe.width", "0.8 m"),)
    assert found.assumed == (("gear.rolling_resistance", "0.03123 1"),)
    assert "Of 4 values 1 are given" in found.given_words
    assert "1 typical values" in found.assumed_words
    assert "1 further values are the same for all machines" in found.assumed_words


def test_inputs_have_their_checksums(folder):
    sums = dict(signed_run.run_report(folder).checksums)
    assert [*sums] == ["case.toml", "origins.csv", "history.nc"]
    before = sums["case.toml"]
    (folder / "case.toml").write_text("name = 'other'\n")
    found = signed_run.run_report(folder)
    assert dict(found.checksums)["case.toml"] != before
    assert dict(found.checksums)["case.toml"][:16] in dict(found.facts)["revision"]


def test_a_run_fills_two_to_four_pages(folder, tmp_path):
    pdf = write_signed(folder, tmp_path / "signed.pdf")
    assert pdf.read_bytes().startswith(b"%PDF-")
    pages = signed.typeset(signed_run.run_report(folder), "png")
    assert 2 <= len(pages) <= 4
    assert all(page.startswith(b"\x89PNG") for page in pages)
    with pytest.raises(FileExistsError, match=r"signed\.pdf"):
        write_signed(folder, pdf)


def test_flexible_shoes_have_their_stress_with_its_verdict(stress_folder):
    found = signed_run.run_report(stress_folder)
    name, value, _, verdict = found.answers.rows[0]
    assert name == "highest von Mises stress"
    assert value.endswith("MPa")
    assert verdict


def test_few_values_leave_the_figures_on_the_second_page():
    picture = signed.picture(signed_run.style.Figure(figsize=(6.0, 1.0)))
    short = replace(HARMLESS, figures={"Drawn": picture})
    assert len(signed.typeset(short, "png")) == 2
    assert len(signed.typeset(replace(short, assumed=(("a", "1"),) * 20), "png")) == 1


def test_no_text_is_read_as_markup():
    (pdf,) = signed.typeset(HARMLESS)
    assert pdf.startswith(b"%PDF-")


def test_a_stored_report_is_read_as_it_was(tmp_path):
    picture = signed.picture(signed_run.style.Figure())
    (tmp_path / "drawn.png").write_bytes(picture)
    signed.store(HARMLESS, tmp_path, {"Drawn": "drawn.png"})
    assert signed.stored(tmp_path) == replace(HARMLESS, figures={"Drawn": picture})
    assert write_signed(tmp_path) == tmp_path / signed.PDF
    (tmp_path / "drawn.png").unlink()
    with pytest.raises(ValueError, match=r"drawn\.png"):
        signed.stored(tmp_path)


@pytest.mark.parametrize("text", ["[]", "{", '{"figures": {}}'])
def test_a_damaged_record_is_named(text, tmp_path):
    (tmp_path / signed.STORED).write_text(text)
    with pytest.raises(ValueError, match=r"report\.json"):
        write_signed(tmp_path)


def test_the_command_makes_a_report_of_each_folder(folder, told, refused, tmp_path, monkeypatch):
    said = told("report", str(folder), "--pdf", "--overwrite")
    assert f"{folder / signed.PDF}: print and sign it" in said
    assert "one folder, got 2" in refused("report", str(folder), str(tmp_path), "--out", "a.pdf")
    assert "holds neither" in refused("report", str(tmp_path), "--pdf")
    monkeypatch.setattr(looking, "find_spec", lambda _: None)
    assert 'pip install "exudyn-crawler[report]"' in refused("report", str(folder), "--pdf")
