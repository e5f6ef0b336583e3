"""Words of a report's headline: weight of the whole machine, ground as engineers call it."""

import pytest

from exudyn_crawler import Case
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.views.pages.first_screen import ground_words


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
    assert ground_words(Case.shovel()).startswith("elastic ground of separate units")
