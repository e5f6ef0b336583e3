"""Words of a report's headline: weight of the whole machine, ground as engineers call it."""

import re
from types import SimpleNamespace

import pytest

from exudyn_crawler import Case
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.views.pages.first_screen import ground_words, shown_name, value_and_place


def test_the_weight_of_a_machine_is_that_of_all_its_parts():
    case = read_case(library.machines()["pc300lc"]).case
    assert case.gear.whole_mass(case) == pytest.approx(35371.0)
    assert case.gear.words(case) == "Machine of 35.37 t on two closed tracks of 48 shoes each"
    shovel = Case.shovel()
    assert shovel.gear.words(shovel).startswith("Machine of 1410 t on two")
    # half of it: frame with its wheels, without the chain
    closed = Case.closed()
    mass = closed.gear.whole_mass(closed) - 38 * closed.shoe.mass
    assert closed.gear.words(closed).startswith(f"Side frame of {mass / 1e3:.4g} t with its wheels on")


def test_ground_has_an_engineers_words():
    assert ground_words(read_case(library.machines()["pc300lc"]).case) == "soil by Bekker's law"
    assert ground_words(Case.shovel()).startswith("elastic ground of blocks on springs")


def test_names_and_places_have_words_of_makers():
    row = SimpleNamespace(
        result="deepest penetration, start", value=6.9051, unit="mm", of="track left", at=1.0
    )
    assert shown_name(row.result) == "deepest sinkage, start"
    assert shown_name("greatest tension of the chain") == "greatest tension of the chain"
    assert value_and_place(row) == ("6.905 mm", "left track, t = 1 s")
    assert value_and_place(SimpleNamespace(**vars(row) | {"of": "wheel right roller 1"}))[1] == (
        "right roller 1, t = 1 s"
    )
    assert value_and_place(SimpleNamespace(**vars(row) | {"of": "link 3-4"}))[1] == "link 3-4, t = 1 s"


@pytest.mark.parametrize("word", ["spider", "mesh-limited", "dragged", "units"])
def test_a_page_has_no_words_of_the_program(word, stress_page_words):
    assert word not in stress_page_words


@pytest.fixture(scope="module")
def stress_page_words(stress_report):
    """Words that a reader of the report sees: no scripts, no keys of the case, no files as they are."""
    html = stress_report.read_text(encoding="utf-8").partition('<section id="case"')[0]
    body = html.partition("<body")[2]
    return re.sub(r"<[^>]*>", " ", re.sub(r"<(script|style).*?</\1>", " ", body, flags=re.DOTALL))
