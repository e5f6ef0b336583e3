"""What no machine and no ground has: told with its likely cause, refused where nothing is meant or held."""

import time
import warnings

import pytest

from exudyn_crawler import Case, CaseFile, FlexibleShoes, LoadCycle, Phase, SphereContact, simulate
from exudyn_crawler.case.parameters.checks import implausible, warn_implausible
from exudyn_crawler.errors import ImplausibleWarning, ParameterError
from exudyn_crawler.machines.case_file import check_size, machine_memory
from exudyn_crawler.settings.fields import plausible_range, walk

STRAIGHT = Case.translation()
SPHERES = STRAIGHT.with_(contact=SphereContact.oil_sand())


def two_phases(loads, **values):
    """Even loads in a first phase, others at the end of a second one."""
    even = Phase(name="first", end=1.0, loads=(386e3,) * 13)
    return LoadCycle(phases=(even, Phase(name="second", end=2.0, loads=loads, **values)))


@pytest.mark.parametrize(
    "loads",
    [
        two_phases((0.0, 0.0, *[600e3] * 11)),
        two_phases((2e3, 50e3, 100e3, *[500e3] * 10)),
        two_phases((386e3,) * 13, side_shift=0.58),
        two_phases((0.0,) * 12 + (5e6,)),
    ],
)
def test_loads_that_fall_to_nothing_or_lean_are_plausible(loads):
    assert list(implausible(STRAIGHT.with_(loads=loads), 10.0)) == []


@pytest.mark.parametrize("case", [STRAIGHT, Case.turning(), Case.stress(), SPHERES])
def test_the_papers_cases_are_plausible(case):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_implausible(case, 10.0)


CONSTANT = [
    (386.4, "13 shoes carry 5.023 kN in all; loads are in N"),
    (0.0, "13 shoes carry nothing, so that the ground carries the shoes alone"),
    (1e9, "13 shoes carry 13 GN in all; loads are in N"),
    ([386e3] * 12 + [-386e3], "-386 kN at the end of 'constant' lifts shoe 13; loads press down"),
    (-5e3, "-5 kN at the end of 'constant' lifts shoe 1; loads press down"),
]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        *(({"loads": LoadCycle.constant(one)}, f"loads.phases[0].loads: {told}") for one, told in CONSTANT),
        (
            {"loads": two_phases((386e3, *[-1.0, 386e3] * 6))},
            "loads.phases[1].loads: -1 N at the end of 'second' lifts shoe 2; loads press down",
        ),
        (
            {"loads": two_phases((386e3,) * 13, side_shift=-0.9)},
            "loads.phases[1].side_shift: -0.9 m at the end of 'second' is beyond a sixth of the shoe's "
            "width, 0.584 m",
        ),
        ({"gravity": 0.0}, "gravity: 0 m/s2 is outside of 9.7 to 9.9 m/s2"),
        (
            {"contact.static_friction": 4.0},
            "contact.static_friction: 4 is outside of 0.02 to 1.5; is it in %? It has to be a fraction of 1",
        ),
        ({"contact.dynamic_friction": 0.0}, "contact.dynamic_friction: 0 is outside of 0.02 to 1.5"),
        ({"solver.step": 0.5}, "solver.step: 0.5 s is longer than the run of 0.1 s"),
        ({"terrain.density": 1.6}, "is it in t/m3? It has to be in kg/m3"),
        ({"terrain.spring_stiffness": 20.0}, "is it in MN/m? It has to be in N/m"),
        ({"terrain.spring_stiffness": 2e5}, "a unit sinks by 4.93 m under itself and one shoe"),
        ({"terrain.grade": 8.0 / 12.0}, "terrain.grade: 0.6667 is outside of -0.3 to 0.3"),
        ({"shoe.mass": 4.68}, "shoe.mass: 4.68 kg is outside of 5 to 20000 kg; is it in t?"),
        ({"shoe.inertia": (4e9, 2e8, 4e9, 0, 0, 0)}, "gives radii of gyration of 207 to 924 m"),
        ({"contact.stiffness": 1e5}, "contact: a shoe sinks by 2.08 m under its mean load of 432.3 kN"),
        (
            {"contact.stiffness": 1e18},
            "contact: a shoe sinks by 6.58e-07 m under its mean load of 432.3 kN, less than 1e-05 m",
        ),
        (
            {"flexible": FlexibleShoes.ph4100c().with_(youngs_modulus=200e3)},
            "flexible.youngs_modulus: 200000 Pa is outside of 5e+10 to 5e+11 Pa; is it in MPa? "
            "It has to be in Pa",
        ),
    ],
)
def test_what_no_machine_has_is_told_with_its_likely_cause(changes, told):
    with pytest.warns(ImplausibleWarning) as caught:
        warn_implausible(STRAIGHT.with_(changes), 0.1)
    lines = [str(one.message) for one in caught]
    assert any(told in line for line in lines), lines


def test_only_what_is_wrong_is_told():
    assert list(implausible(STRAIGHT.with_({"solver.step": 0.03}), 10.0)) == [
        "solver.step: 0.03 s is outside of 1e-05 to 0.02 s; is it in ms? It has to be in s"
    ]


def test_what_cannot_be_meant_is_refused_with_its_likely_cause():
    told = r"^contact\.static_friction: must be less than or equal to 10, got 40\.0; is it in %\? "
    with pytest.raises(ParameterError, match=told + r"It has to be a fraction of 1$"):
        STRAIGHT.with_({"contact.static_friction": 40.0})


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("terrain.unit_height", 1e300),
        ("terrain.density", 1e-300),
        ("terrain.columns", 10**10),
        ("terrain.origin", (1e300, 0.0)),
        ("solver.step", 1e300),
        ("solver.residual", 1e300),
        ("solver.checkpoint_interval", 1e-323),
        ("solver.maximum_iterations", 2**40),
        ("track.shoe_count", 10**9),
        ("shoe.inertia", (1e300, 1e300, 1e300, 0, 0, 0)),
        ("flexible.youngs_modulus", 1e300),
        ("flexible.recovered_modes", 2**63),
    ],
)
def test_what_numbers_cannot_hold_is_refused_by_its_bound(path, value):
    with pytest.raises(ParameterError, match=rf"^{path}.*must be (less|greater) than or equal to"):
        Case.stress().with_({path: value})


@pytest.mark.parametrize("name", ["", "n" * 100_000])
def test_names_are_neither_empty_nor_endless(name):
    with pytest.raises(ParameterError, match=r"must have at (least|most)"):
        STRAIGHT.with_(name=name)


def test_plausible_ranges_lie_within_what_is_allowed():
    for base in (Case.stress(), SPHERES):
        for entry in walk(base):
            plausible = plausible_range(entry.field)
            for bound in entry.field.metadata:
                if plausible is not None:
                    assert plausible[0] >= getattr(bound, "ge", plausible[0]), entry.path
                    assert plausible[1] <= getattr(bound, "le", plausible[1]), entry.path


def ground(columns, rows):
    return STRAIGHT.with_({"terrain.columns": columns, "terrain.rows": rows})


WIDE = ground(10_000, 10_000)


@pytest.mark.parametrize(
    ("case", "duration", "told"),
    [
        (WIDE, 10.0, "terrain: 100000000 units would take 1.28e+09 GB of memory"),
        (WIDE.with_(contact=SphereContact.oil_sand()), 10.0, "100000000 units would take 2e+03 GB of memory"),
        (STRAIGHT, 1e12, "duration: 1e+12 s would store 4.32e+06 TB, allowed is 1 TB"),
    ],
)
def test_what_no_machine_holds_is_refused_at_once(case, duration, told):
    begun = time.perf_counter()
    for refuse in (
        lambda: check_size(case, duration),
        lambda: simulate(case, duration),
        lambda: CaseFile(case=case, duration=duration),
    ):
        with pytest.raises(ValueError, match=told.replace("+", r"\+")):
            refuse()
    assert time.perf_counter() - begun < 2.0


def test_what_machines_hold_is_not_refused():
    """An hour of duty, and ground as fine as any of the papers'."""
    assert machine_memory() > 1e8
    check_size(Case.stress(), 3600.0)
    check_size(ground(50, 20), 10.0)
