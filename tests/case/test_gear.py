"""Gear of a case: its kinds in files, keys of older files, and what a kind gives."""

import json

import numpy as np
import pytest

from exudyn_crawler import Case, CaseFile, MachineCycle, read_case, write_case
from exudyn_crawler.case import CarBody, Closed, Dragged, Machine, Rolled
from exudyn_crawler.case.gear.running_gear import Bogie
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines import saved_case

KINDS = {
    "dragged": Case.translation(),
    "rolled": Case.rolled(),
    "closed": Case.closed(),
    "machine": Case.shovel(),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_case_keeps_its_gear_in_files(kind, tmp_path):
    case = KINDS[kind]
    assert case.gear.kind == kind
    whole = CaseFile(case=case, duration=0.1)
    assert read_case(write_case(whole, tmp_path / "case.toml")) == whole
    assert saved_case(case.model_dump_json()) == case
    assert json.loads(case.model_dump_json())["gear"]["kind"] == kind


@pytest.mark.parametrize(
    ("text", "gear"),
    [
        ('base = "translation"\n', Dragged()),
        ('base = "rolled"\n[gear]\nend_tension = "1 MN"\n', Rolled.ph4100c().with_(end_tension=1e6)),
        ('base = "closed"\n[gear.idler]\nslack = 0.01\n', Closed.ph4100c().with_({"idler.slack": 0.01})),
        (
            'base = "shovel"\n[gear]\nkind = "machine"\n[gear.car_body]\nslew = 0.5\n',
            Machine.ph4100c().with_({"car_body.slew": 0.5}),
        ),
        # a gear of another kind starts from its own base
        (
            'base = "rolled"\nloads = 1e5\n[gear]\nkind = "dragged"\n',
            Dragged(),
        ),
    ],
)
def test_a_file_gives_a_gear_what_differs_from_its_base(read, text, gear):
    assert read(f"duration = 0.1\n{text}").case.gear == gear


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[undercarriage]\nmass = 4e5\n", "undercarriage: is now [gear] with kind = 'rolled'"),
        (
            '[closed_track]\nsupport = "posts"\n',
            "closed_track: is now [gear] with kind = 'closed', or 'machine' for two tracks",
        ),
        (
            "[car_body]\nslew = 0.1\n",
            "car_body: is now [gear.car_body] of a [gear] with kind = 'machine'",
        ),
        (
            'undercarriage = "none"\ncar_body = "none"\nwheels = 3\n',
            "undercarriage is now [gear] with kind = 'rolled'; "
            "car_body is now [gear.car_body] of a [gear] with kind = 'machine'",
        ),
        (
            'car_body = "none"\n',
            "car_body: is now [gear.car_body] of a [gear] with kind = 'machine'",
        ),
        (
            '[gear]\nkind = "wheeled"\n',
            "gear.kind: must be 'dragged' or 'rolled' or 'closed' or 'machine', got 'wheeled'",
        ),
        ("[gear]\nslew = 0.1\n", "gear.slew: unknown key; allowed are kind"),
    ],
)
def test_keys_of_older_files_and_other_kinds_are_refused(refused, text, told):
    (fault,) = refused(f'base = "translation"\nduration = 1.0\n{text}')
    assert fault == told


def test_a_changed_value_of_an_older_key_is_refused(read):
    with pytest.raises(ValueError, match=r"closed_track: is now \[gear\] with kind = 'closed'"):
        read('base = "closed"\nduration = 1.0\n', ["closed_track.idler.slack=0.01"])


def test_what_a_case_does_not_have_is_refused_by_its_kind():
    with pytest.raises(ValueError, match=r"gear\.kind must be 'closed' or 'machine', got 'rolled'"):
        KINDS["rolled"].part(Closed)
    with pytest.raises(ValueError, match=r"gear\.kind must be 'rolled', got 'machine'"):
        KINDS["machine"].part(Rolled)
    with pytest.raises(ParameterError, match=r"machine must be none with gear\.kind 'dragged'"):
        KINDS["dragged"].with_(machine=MachineCycle.shovel())


def test_a_machine_is_two_of_its_tracks():
    """Bodies, wheels and rows of the start are those of both tracks by themselves."""
    case, tracks = KINDS["machine"], [KINDS["machine"].of_track(side) for side in ("right", "left")]
    assert case.gear.single == tracks[0].gear == tracks[1].gear
    assert Machine.of(tracks[0].gear, CarBody.ph4100c()) == case.gear
    assert case.gear.bodies == ("side frame", "right tumbler", "left tumbler")
    assert len(case.gear.wheel_names) == 2 * len(tracks[0].gear.wheel_names)
    beside = np.concatenate([one.gear.shoe_reference(one) for one in tracks])
    np.testing.assert_allclose(case.gear.shoe_reference(case), beside, rtol=0.0, atol=1e-12)


BOGIE = """
[[gear.bogies]]
rollers = [2, 3]
pivot = [{pivot}, 0.1]
mass = "1.2 t"
inertia = [60, 400, 400, 0, 0, 0]
"""


def middle(gear, rear):
    """X of the middle between a roller, from 1, and the next."""
    return 0.5 * (gear.rollers[rear - 1] + gear.rollers[rear])


@pytest.mark.parametrize("base", ["rolled", "closed", "shovel"])
def test_a_file_names_the_bogies_of_any_running_gear(base, read, tmp_path):
    gear = read(f'duration = 0.1\nbase = "{base}"\n').case.gear
    whole = read(f'duration = 0.1\nbase = "{base}"\n' + BOGIE.format(pivot=middle(gear, 2)))
    (bogie,) = whole.case.gear.bogies
    assert bogie.rollers == (2, 3)
    assert bogie.mass == 1200.0
    assert read_case(write_case(whole, tmp_path / "again.toml")) == whole


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (
            {"rollers": (2, 4)},
            r"rollers must be two neighbours, rear to front, such as \[2, 3\], got \[2, 4\]",
        ),
        ({"rollers": (7, 8)}, r"gear.bogies\[1\].rollers must be in 1..7, got \[7, 8\]"),
        ({"rollers": (3, 4)}, r"gear.bogies\[1\].rollers must not be those of another.*\[0\] has roller 3"),
        (
            {"pivot": (9.0, 0.1)},
            r"gear.bogies\[1\].pivot must be between its rollers at x = .* got \[9.0, 0.1\]",
        ),
    ],
)
def test_bogies_that_cannot_be_are_refused(changes, told):
    gear = Closed.ph4100c()
    first, second = (
        Bogie(rollers=(k, k + 1), pivot=(middle(gear, k), 0.1), mass=1e3, inertia=(60, 400, 400, 0, 0, 0))
        for k in (2, 4)
    )
    with pytest.raises(ParameterError, match=told):
        Case.closed().with_({"gear.bogies": (first, second.with_(changes))})


def test_bogies_of_implausible_inertia_are_told():
    gear = Closed.ph4100c()
    bogie = Bogie(rollers=(2, 3), pivot=(middle(gear, 2), 0.1), mass=1e3, inertia=(9e3, 9e3, 9e3, 0, 0, 0))
    case = Case.closed().with_({"gear.bogies": (bogie,)})
    assert "gear.bogies[0].inertia" in " ".join(case.gear.implausible(case.shoe, case.track))
