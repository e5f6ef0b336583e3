"""What varies: levels, factors, and what does not fit the case."""

import pytest

from exudyn_crawler import CaseFile
from exudyn_crawler.settings.fields import parse_path, with_value
from exudyn_crawler.sweep.vary import Vary, checked_case
from tests.sweep.cases import STIFFNESS, small_case

BOUNDS = {"low": 1.0, "high": 2.0}


def applied(vary, value):
    return checked_case(vary.applied(small_case().model_dump(mode="json"), value), CaseFile).case


def test_levels_lie_evenly_or_in_equal_ratios():
    assert Vary(key=STIFFNESS, low=1e6, high=3e6, count=3).levels() == (1e6, 2e6, 3e6)
    levels = Vary(key=STIFFNESS, low=5e6, high=80e6, count=5, scale="log").levels()
    assert levels == pytest.approx([5e6 * 2.0**k for k in range(5)])
    assert (levels[0], levels[-1]) == (5e6, 80e6)


def test_portions_lead_from_low_to_high_and_through_values():
    assert Vary(key=STIFFNESS, low=1.0, high=3.0).at(0.25) == 1.5
    values = Vary(key="flexible.mesh", values=("coarse", "study"))
    assert [values.at(u) for u in (0.0, 0.49, 0.5, 1.0)] == ["coarse", "coarse", "study", "study"]


def test_factors_multiply_what_the_base_has_everywhere():
    friction = Vary(
        key=("contact.static_friction", "contact.dynamic_friction"), values=(0.5, 1.0), factor=True
    )
    before, after = small_case().case.contact, applied(friction, 0.5).contact
    assert after.static_friction == 0.5 * before.static_friction
    assert after.dynamic_friction == 0.5 * before.dynamic_friction
    loads = Vary(key="loads.phases[*].loads", low=0.5, high=2.0, factor=True)
    assert applied(loads, 2.0).loads.phases[0].loads == (900e3,) * 3


def test_a_value_may_stand_for_one_of_each_path():
    plate = Vary(
        name="top_plate",
        unit="m",
        key=("shoe.mass", "shoe.load_point"),
        values=(0.03, 0.05),
        settings=((4400.0, (0.0, 0.0, 0.19)), (4600.0, (0.0, 0.0, 0.2))),
    )
    assert (plate.label, plate.levels(), plate.unit_in(small_case())) == ("top_plate", (0.03, 0.05), "m")
    plate.check(small_case())
    for one in (plate, Vary.model_validate_json(plate.model_dump_json())):
        shoe = applied(one, 0.05).shoe
        assert (shoe.mass, shoe.load_point) == (4600.0, (0.0, 0.0, 0.2))
    wrong = plate.with_(settings=((4400.0, (0.0, 0.0, 0.19)), (-1.0, (0.0, 0.0, 0.2))))
    with pytest.raises(ValueError, match=r"shoe\.mass: .* greater than or equal to 0\.1 kg, got -1"):
        wrong.check(small_case())


def test_counts_between_bounds_are_whole_numbers():
    assert applied(Vary(key="terrain.columns", low=9, high=12), 10.6).terrain.columns == 11


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"low": 2.0, "high": 1.0}, "low must be less than high = 1, got 2"),
        ({"low": -1.0, "high": 1.0, "scale": "log"}, "low must be positive with scale 'log', got -1"),
        ({"low": 1.0}, "values, or low and high, must be given"),
        (BOUNDS | {"settings": ((1.0,),)}, "settings must be given with values, one for each"),
        ({"values": (1.0,), "settings": ((1.0,),)}, "settings must be given with a name, and without factor"),
        (
            {"values": (1.0, 2.0), "name": "a", "settings": ((1.0,), (1.0, 2.0))},
            r"settings must be 2 lists, one a value, of 1 each, one a path, got lists of \[1, 2\]",
        ),
        ({"values": (1.0,), "low": 1.0}, "low, high, count and distribution must be left out"),
        ({"values": (1.0, 1.0)}, "values must be different"),
        ({"values": ()}, "values must hold at least one value, got an empty list"),
        (BOUNDS | {"within": 0.9}, "within must be left out with distribution 'uniform', got 0.9"),
        (
            BOUNDS | {"distribution": "weibull", "low": -1.0},
            "low must be positive with distribution 'weibull', got -1",
        ),
        (BOUNDS | {"distribution": "weibull", "scale": "log"}, "scale must be left out"),
        (
            BOUNDS | {"distribution": "normal", "count": 3},
            "count must be left out with distribution 'normal'",
        ),
        ({"key": "", "values": (1.0,)}, "at least 1 character"),
        ({"key": "a..b", "values": (1.0,)}, r"a path must be like terrain\."),
    ],
)
def test_paths_and_bounds_that_make_no_sense_are_refused(given, told):
    with pytest.raises(ValueError, match=told):
        Vary(**{"key": STIFFNESS} | given)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"key": "terrain.spring_stifness", "values": (1e7,)}, "did you mean terrain.spring_stiffness?"),
        ({"key": STIFFNESS, "low": 5.0, "high": 80.0}, "is it in MN/m? It has to be in N/m"),
        ({"key": STIFFNESS, "low": 5.0, "high": 80.0, "unit": "MN/m"}, "unit must be 'N/m', got 'MN/m'"),
        (
            {"key": STIFFNESS, "low": -5.0, "high": 80e6, "unit": "N/m"},
            "greater than or equal to 1 N/m, got -5",
        ),
        ({"key": "contact.friction", "low": 0.1, "high": 0.5}, "contact.friction: unknown key"),
        (
            {"key": "contact.model", "values": ("spheres",)},
            "cannot be varied: it selects a class with other keys",
        ),
        ({"key": "terrain", "values": (1.0,)}, "terrain is a table"),
        (
            {"key": "terrain.tilt", "values": (2.0,), "factor": True},
            "factor must be applied to numbers, got 2.0 times",
        ),
        ({"key": "terrain.grade", "values": (2.0, 3.0), "factor": True}, "a factor of zero changes nothing"),
        ({"key": STIFFNESS, "values": ("soft",)}, "must be a number in N/m, or such as '1 MN/m'"),
    ],
)
def test_what_does_not_fit_the_case_is_refused(given, told):
    with pytest.raises(ValueError) as refused:  # noqa: PT011 - the words are below
        Vary(**given).check(small_case())
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)


def test_numbers_meant_in_their_unit_are_taken_and_values_that_only_others_allow_left_to_the_runs():
    Vary(key=STIFFNESS, low=5.0, high=80.0, unit="N/m").check(small_case())
    Vary(key="contact.dynamic_friction", values=(0.5,)).check(small_case())


def test_values_are_changed_in_tables_lists_and_beside_the_case():
    before = small_case()
    content = before.model_dump(mode="json")
    assert checked_case(content, CaseFile) == before
    for vary, value in (
        (Vary(key="duration", values=(2.0,), factor=True), 2.0),
        (Vary(key="loads.phases[*].loads", values=(4e5,)), 4e5),
        (Vary(key="shoe.load_point[2]", values=(0.2,)), 0.2),
    ):
        content = vary.applied(content, value)
    found = checked_case(content, CaseFile)
    assert found.duration == 2.0 * before.duration
    # one number is that of every shoe
    assert found.case.loads.phases[0].loads == (4e5, 4e5, 4e5)
    assert found.case.shoe.load_point == (*before.case.shoe.load_point[:2], 0.2)
    assert small_case().model_dump(mode="json") == before.model_dump(mode="json")


def test_the_first_of_many_faults_is_named():
    content = small_case().model_dump(mode="json")
    for name in ("spring_stiffness", "spring_damping", "density", "unit_length"):
        content = with_value(content, parse_path(f"terrain.{name}"), -1.0, CaseFile)
    with pytest.raises(ValueError, match=r"^terrain\.unit_length: [^;]*got -1"):
        checked_case(content, CaseFile)


def test_a_column_is_named_and_has_its_unit_by_the_paths_end():
    case = small_case()
    for path, label, unit in (
        ("terrain.spring_stiffness", "spring_stiffness", "N/m"),
        ("loads.phases[*].loads", "loads", "N"),
        ("loads.phases[0].loads[*]", "loads", "N"),
        ("shoe.load_point[2]", "load_point", "m"),
        ("duration", "duration", "s"),
        ("terrain.stiffness", "stiffness", ""),
    ):
        vary = Vary(key=path, values=(1.0,))
        assert (vary.label, vary.unit_in(case)) == (label, unit)
