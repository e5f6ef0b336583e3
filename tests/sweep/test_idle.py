"""What is called idle changes nothing, and does where it is not: by runs."""

import numpy as np
import pytest

from exudyn_crawler import simulate
from exudyn_crawler.sweep.idle import IDLE, idle
from exudyn_crawler.sweep.paths import change_at, checked_case, content_of, place_of
from tests.sweep.cases import small_case


def case_with(**values):
    content = content_of(small_case())
    for path, value in values.items():
        change_at(content, place_of(path.replace("__", ".")), lambda _, value=value: value)
    return checked_case(content).case


PAIRS = (
    ("contact.edge_width", 0.01, 0.3, {"contact__sharing": "area"}),
    ("contact.damping_depth", 1e-3, 1.5e-2, {"contact__damping": 0.0}),
    (
        "contact.stiction_speed",
        1e-4,
        2e-2,
        {"contact__static_friction": 0.0, "contact__dynamic_friction": 0.0},
    ),
    (
        "contact.friction_speed",
        0.05,
        1.0,
        {"contact__static_friction": 0.0, "contact__dynamic_friction": 0.0},
    ),
    ("terrain.spring_offset", 0.5, 2.0, {"terrain__springs_per_unit": 1, "terrain__column_tilt": True}),
    ("solver.quiet_step", 2e-3, 8e-3, {"drive__on": None}),
)


def test_every_idle_value_is_tried():
    assert [path for path, *_ in IDLE] == [path for path, *_ in PAIRS]


@pytest.mark.simulation
@pytest.mark.parametrize(("path", "one", "other", "given"), PAIRS, ids=[path for path, *_ in PAIRS])
def test_idle_values_change_nothing(path, one, other, given):
    cases = [case_with(**given | {path.replace(".", "__"): value}) for value in (one, other)]
    assert [len(list(idle([path], case))) for case in cases] == [1, 1]
    first, second = (simulate(case, 0.01).dataset for case in cases)
    assert all(np.array_equal(first[name], second[name], equal_nan=True) for name in first.data_vars)


def test_what_counts_is_not_idle():
    case = small_case().case
    paths = [path for path, *_ in IDLE if path != "solver.quiet_step"]
    assert list(idle([*paths, "terrain.spring_stiffness"], case)) == []
