"""Page of the library's machines."""

import pytest

from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.views.pages import machines


@pytest.mark.parametrize("name", ["m113", "d155ax"])
def test_page_draws_a_machine_with_its_figures_and_sources(name):
    case_file = read_case(library.machines()[name])
    html = machines.machines_page({name: case_file})
    assert html.count("data:image/png") == 1
    assert case_file.datasheet.source in html
    assert "weight of all parts" in html
    assert f"init mine --machine {name}" in html
    assert "Remembered, not seen: gauge" in html


@pytest.mark.slow
def test_all_machines_are_one_picture():
    figure = machines.library_figure([read_case(path) for path in library.machines().values()])
    titles = {ax.get_title(loc="left") for ax in figure.axes}
    # of an odd number the last place is empty
    assert len(titles - {""}) == len(library.machines())
