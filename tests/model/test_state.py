"""Layout of a state: parts by name, what is refused, and that it is the engine's."""

import dataclasses
import json

import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.exudyn import exu
from exudyn_crawler.model.state import RATES, VERSION, StateLayout, pin_name
from tests.states import row_of

LAYOUT = StateLayout(
    shoes=3,
    terrain=4,
    flexible_shoes=(2, 3),
    modes=5,
    multipliers=(("right pin of link 1", 6), ("left pin of link 1", 6), ("drive", 1)),
    contact=6,
)
COUNT = 18 + 4 + 10


def test_what_is_put_into_a_row_is_found_by_name():
    assert LAYOUT.coordinate_count == COUNT
    assert LAYOUT.equation_count == COUNT + 13
    assert LAYOUT.size == 1 + 3 * COUNT + 13 + 18
    names = ["time", "multipliers", "contact"]
    names += [f"{part}{rate}" for part in ("shoes", "terrain", "modes") for rate in RATES]
    rng = np.random.default_rng(3)
    parts = {name: rng.random(LAYOUT.part(np.zeros(LAYOUT.size), name).shape) for name in names}
    row = row_of(LAYOUT, parts)
    for name, values in parts.items():
        assert np.array_equal(LAYOUT.part(row, name), values)
    assert np.array_equal(LAYOUT.part(row, "drive"), parts["multipliers"][-1:])
    assert np.array_equal(LAYOUT.part(row, "coordinates rate")[18:22], parts["terrain rate"])
    assert len(np.unique(row)) == LAYOUT.size  # nothing lies over anything else


def test_parts_of_many_states_are_views():
    rows = np.zeros((7, LAYOUT.size))
    modes = LAYOUT.part(rows, "modes acceleration")
    assert modes.shape == (7, 2, 5)
    modes[3, 1, 4] = 2.0
    assert (rows != 0.0).sum() == 1
    assert LAYOUT.part(rows, "time").shape == (7,)


def test_bad_parts_are_refused_by_name():
    with pytest.raises(ValueError, match="a state has no part 'tracks'"):
        LAYOUT.part(np.zeros(LAYOUT.size), "tracks")
    with pytest.raises(ValueError, match=f"must have {LAYOUT.size} numbers, got 5"):
        LAYOUT.part(np.zeros(5), "time")


def test_equations_have_names():
    of_coordinates = [LAYOUT.equation(k) for k in (2, 16, 18)]
    assert of_coordinates == ["shoe 1 (z)", "shoe 3 (rotation about y)", "terrain (coordinate 1)"]
    assert [LAYOUT.equation(k) for k in (22, 31)] == ["modes of shoe 2 (mode 1)", "modes of shoe 3 (mode 5)"]
    multipliers = [LAYOUT.equation(COUNT + k) for k in (5, 6, 12)]
    assert multipliers == ["right pin of link 1", "left pin of link 1", "drive"]
    bodies = StateLayout(shoes=3, terrain=12, terrain_bodies=True)
    assert bodies.equation(18 + 6 + 3) == "unit 2 (rotation about x)"


def test_the_text_of_a_layout_tells_its_version_and_all_its_sizes():
    text = json.loads(LAYOUT.to_json())
    assert text.pop("version") == VERSION
    fields = [field.name for field in dataclasses.fields(LAYOUT)]
    assert list(text) == fields
    assert (text["terrain"], text["multipliers"]) == (4, [list(one) for one in LAYOUT.multipliers])


@pytest.mark.parametrize("case", [Case.turning(), Case.turning().with_(terrain_formulation="constrained")])
def test_the_layout_is_the_engines(case):
    """Of a shoe's seven coordinates and one equation it has six and none; of a pin's equations five."""
    system = ExudynSystem(case)
    layout, data, shoes = system.layout, system.mbs.systemData, case.track.shoe_count
    assert layout.coordinate_count == len(data.GetODE2Coordinates()) - shoes == system.contact.size
    multipliers = layout.equation_count - layout.coordinate_count
    assert multipliers == len(data.GetAECoordinates()) - shoes - (shoes - 1)
    names = [name for name, _ in layout.multipliers]
    assert len(set(names)) == len(names)
    assert names[: shoes + 1] == [*(pin_name("right", link) for link in range(1, shoes)), "drive", "turn"]
    own = compiled_system(case.with_(terrain_formulation="reduced")).layout
    assert layout.multipliers[: shoes + 1] == own.multipliers


def test_a_state_that_is_set_is_read_again():
    """Through whole turns of pitch, too, whose number Euler parameters do not keep."""
    case = Case.turning()
    system = ExudynSystem(case)
    layout, rng = system.layout, np.random.default_rng(4)
    parts = {f"coordinates{rate}": rng.normal(size=layout.coordinate_count) for rate in RATES}
    turned = parts["coordinates"][: 6 * case.track.shoe_count].reshape(-1, 6)
    turned[:, 3] *= 0.3
    turned[:, 4:] *= 10.0
    row = row_of(layout, parts)
    system.set_state(row)
    data, initial = system.mbs.systemData, exu.ConfigurationType.Initial
    data.SetODE2Coordinates(data.GetODE2Coordinates(initial))
    data.SetODE2Coordinates_t(data.GetODE2Coordinates_t(initial))
    data.SetODE2Coordinates_tt(data.GetODE2Coordinates_tt(initial))
    assert system.state() == pytest.approx(row, rel=1e-9, abs=1e-9)
