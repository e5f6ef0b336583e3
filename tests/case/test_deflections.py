"""Stiffnesses and dampings that no gear has: depth under the weight, and the critical damping."""

import math
from pathlib import Path

import pytest

from exudyn_crawler import Case, read_case
from exudyn_crawler.case.gear.deflections import SHALLOWEST, LoadedContact
from exudyn_crawler.case.parameters.checks import implausible
from exudyn_crawler.machines import datasheet

CLOSED = Case.closed()
LIBRARY = Path(datasheet.__file__).parent / "library"
M113 = read_case("studies/m113.toml").case
EXCAVATOR = read_case(LIBRARY / "pc300lc.toml").case
CARRIER = read_case(LIBRARY / "m113.toml").case


@pytest.mark.parametrize(
    ("case", "changes", "words"),
    [
        (
            CLOSED,
            {"gear.stiffness": 1e6},
            "gear.stiffness: a roller's tread gives way by 0.369 m under half of its even share of the "
            "weight, 369 kN, more than 0.05 of its radius, 0.02 m; it is in N/m",
        ),
        (Case.rolled(), {"gear.stiffness": 1e6}, "gear.stiffness: a roller's tread gives way by 0.386 m"),
        (
            CLOSED,
            {"gear.stiffness": 1e12},
            "gear.stiffness: a roller's tread gives way by 3.69e-07 m under half of its even share of "
            "the weight, 369 kN, less than 1e-06 m, the least of steel on steel; it is in N/m",
        ),
        (
            EXCAVATOR,
            {"gear.damping": 9e6},
            "gear.damping: 9e+06 N s/m is 18 times the critical one of 928.7 kg",
        ),
        (
            CLOSED,
            {"gear.tumbler.stiffness": 1e7},
            "gear.tumbler.stiffness: a tooth gives way by 0.129 m under a pull of half the weight on its "
            "track, on both sides, 1.29 MN, more than 0.5 of a lug's radius, 0.045 m; it is in N/m",
        ),
        (
            M113,
            {"gear.tumbler.lugs": ((-0.0535, 0.0), (-0.061, 0.0))},
            "gear.tumbler.lugs: lugs of 15 mm radius stand 7.5 mm apart and overlap",
        ),
        (
            EXCAVATOR,
            {"gear.tumbler.damping": 9e6},
            "gear.tumbler.damping: 9e+06 N s/m is 41.3 times the critical",
        ),
        (
            CLOSED,
            {"gear.guide_stiffness": 1e5},
            "gear.guide_stiffness: a roller's flange gives way by 2.22 m under 0.3 of its roller's even "
            "share of the weight, 222 kN, more than gear.offset_limit, where shoes come off, 0.1 m",
        ),
        (
            M113,
            {"gear.guide_damping": 1e7},
            "gear.guide_damping: 1e+07 N s/m is 1.18e+03 times the critical one",
        ),
        (
            M113,
            {"gear.idler.tensioner.stiffness": 1e5},
            "gear.idler.tensioner.stiffness: its preload of 270 kN presses the spring by 2.7 m, more than "
            "5 pitches",
        ),
        (
            EXCAVATOR,
            {"gear.idler.recoil.stiffness": 9e8},
            "presses the spring by 0.000193 m, less than 0.001 m: it stands as on shims",
        ),
        (
            EXCAVATOR,
            {"gear.idler.recoil.damping": 3e6},
            "gear.idler.recoil.damping: 3e+06 N s/m is 33.9 times the critical one of 1564 kg",
        ),
        (
            CARRIER,
            {"gear.arms[0].torque": 3e4},
            "gear.arms[0]: under an even share of the weight, 8.96 kN, it turns down by 1.1 rad, more "
            "than 0.5",
        ),
        (
            CARRIER,
            {"gear.arms[1].stop_stiffness": 1.2e4},
            "gear.arms[1].stop_stiffness: 12000 N m/rad is softer than the spring's 25000, so that it "
            "stops nothing",
        ),
        (
            CARRIER,
            {"gear.arms[2].damping": 9e5},
            "gear.arms[2].damping: 900000 N m s/rad is 327 times the critical",
        ),
    ],
)
def test_stiffness_or_damping_of_no_machine_is_told(case, changes, words):
    lines = list(implausible(case.with_(changes)))
    assert words in lines[0]
    assert {line.split(":")[0] for line in lines} == {lines[0].split(":")[0]}


@pytest.mark.parametrize("path", sorted(LIBRARY.glob("*.toml")), ids=lambda path: path.stem)
def test_machines_of_the_library_are_plausible(path):
    assert list(implausible(read_case(path).case)) == []


def test_depth_is_that_at_which_the_contact_carries_its_load():
    contact = LoadedContact("", "", 5e4, "", 3e8, 1.4, 0.0, 1.0)
    assert contact.stiffness * contact.depth**contact.exponent == pytest.approx(contact.load, rel=1e-12)


@pytest.mark.parametrize("ratio", [0.999, 1.001])
def test_bounds_are_depth_and_critical_damping(ratio):
    """Beyond the bounds alone: a linear contact of 1 MN/m with 1 kN at 1 mm, and 10 kg on it."""
    stiffness = 1e6
    critical = 2.0 * math.sqrt(stiffness * 10.0)
    damped = LoadedContact("a.", "it", 1e3, "it", stiffness, 1.0, 10.0 * ratio * critical, 10.0)
    assert bool(list(damped.implausible(1.0, ""))) == (ratio > 1.0)
    undamped = damped._replace(damping=0.0)
    assert bool(list(undamped.implausible(1e-3 / ratio, "its size"))) == (ratio > 1.0)
    stiff = undamped._replace(stiffness=1e3 / SHALLOWEST * ratio)
    assert bool(list(stiff.implausible(1.0, ""))) == (ratio > 1.0)
