"""Prescribed motion and loads over time: the papers' polynomials, the shovel's cycle, a user's own."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, LoadCycle, Phase, StepProfile
from exudyn_crawler.case import outline
from exudyn_crawler.errors import CaseFileError

EARLY = np.linspace(0.0, 5.0, 21)
LATE = np.linspace(5.0, 12.0, 15)


def test_speed_travel_and_acceleration_are_the_papers_polynomials_and_then_constant():
    speed = Drive.translation().speed
    assert speed.value(EARLY) == pytest.approx(0.012 * EARLY**2 - 0.0016 * EARLY**3, rel=1e-12)
    assert speed.value(LATE) == pytest.approx(np.full(15, 0.1), rel=1e-12)
    assert speed.integral(EARLY) == pytest.approx(0.004 * EARLY**3 - 0.0004 * EARLY**4, rel=1e-12)
    assert speed.integral(LATE) == pytest.approx(0.25 + 0.1 * (LATE - 5.0), rel=1e-12)
    assert speed.rate(EARLY) == pytest.approx(0.024 * EARLY - 0.0048 * EARLY**2, rel=1e-12, abs=1e-15)
    assert speed.rate(2.5) == pytest.approx(0.03, rel=1e-12)  # K-chapter eq. 29
    assert speed.rate(LATE) == pytest.approx(np.zeros(15), abs=1e-15)


def test_turn_rate_is_the_papers_polynomial_in_degrees():
    rate = Drive.turning().turn_rate
    assert np.degrees(rate.value(EARLY)) == pytest.approx(0.12 * EARLY**2 - 0.016 * EARLY**3, rel=1e-12)
    assert np.degrees(rate.value(LATE)) == pytest.approx(np.ones(15), rel=1e-12)
    assert math.degrees(rate.integral(10.0)) == pytest.approx(7.5, rel=1e-12)


def test_stress_paper_comes_to_rest():
    drive = Drive.to_rest()
    t = np.linspace(10.0, 15.0, 11)
    s = (t - 10.0) / 5.0
    assert drive.speed.value(t) == pytest.approx(0.1 - 0.1 * s**2 * (3 - 2 * s), rel=1e-12, abs=1e-15)
    assert drive.speed.integral(40.0) == pytest.approx(1.0, rel=1e-12)  # 0.25 + 0.5 + 0.25 m


def test_a_profile_is_constant_outside_its_times():
    profile = StepProfile(times=(1.0, 2.0, 4.0), values=(3.0, 5.0, -1.0))
    assert profile.value([0.0, 1.0, 2.0, 4.0, 9.0]).tolist() == [3.0, 3.0, 5.0, -1.0, -1.0]
    assert profile.value([1.5, 3.0]).tolist() == pytest.approx([4.0, 2.0], rel=1e-12)
    assert profile.integral(0.0) == pytest.approx(-3.0, rel=1e-12)
    assert profile.integral(5.0) == pytest.approx(4.0 + 4.0 - 1.0, rel=1e-12)
    constant = StepProfile.constant(7.5)
    assert constant.value([-1.0, 0.0, 100.0]).tolist() == [7.5, 7.5, 7.5]
    assert float(constant.rate(3.0)) == 0.0
    assert constant.integral(4.0) == pytest.approx(30.0, rel=1e-12)


def test_loads_follow_steps_between_the_ends_of_phases():
    propel = Phase(name="propel", end=15.0, loads=(386.4e3, 386.4e3))
    cycle = LoadCycle(phases=(propel, Phase(name="dig", end=22.5, loads=(384.0e3, 500.0e3))))
    expected = [[386.4e3] * 2, [386.4e3] * 2, [385.2e3, 443.2e3], [384e3, 500e3], [384e3, 500e3]]
    np.testing.assert_allclose(cycle.loads([0.0, 15.0, 18.75, 22.5, 30.0]), expected, rtol=1e-12)
    quarter = 386.4e3 + (500e3 - 386.4e3) * 0.25**2 * 2.5
    assert cycle.of_shoes[1].value(15.0 + 7.5 / 4) == pytest.approx(quarter, rel=1e-12)


def test_the_track_travels_only_while_driven():
    speed = StepProfile(times=(0.0, 0.05, 0.1, 0.15, 0.2), values=(0.0, 0.01, 0.0, 0.0, 0.02))
    case = Case.translation().with_(drive=Drive(speed=speed, on=((0.0, 0.05),)))
    assert case.outline(0.2)[0, 0] - case.outline(0.0)[0, 0] == pytest.approx(0.05 * 0.01 / 2)
    free = case.with_(drive=Drive(speed=speed, on=()))
    np.testing.assert_array_equal(
        outline.outlines(free, EARLY), np.tile(free.outline(0.0), (len(EARLY), 1, 1))
    )


def test_the_shovel_cycle_keeps_every_sum_and_the_printed_loads():
    cycle = LoadCycle.shovel_cycle()
    loads = {phase.name: np.array(phase.loads) for phase in cycle.phases}
    machine, dipper = 13 * 386.4e3, 445e3
    sums = {"propel": machine, "dig": machine + dipper, "hoist and swing": machine + dipper}
    sums |= {"dump": machine, "return": machine}
    for name, total in sums.items():
        assert loads[name].sum() == pytest.approx(total, rel=1e-12)
    printed = {"propel": 386.4e3, "dig": 384e3, "hoist and swing": 732e3, "dump": 541e3, "return": 386.4e3}
    for name, load in printed.items():
        assert loads[name][6] == pytest.approx(load, rel=1e-9)
    assert loads["dump"][[0, 12]] == pytest.approx([253.9e3, 253.9e3], rel=1e-3)
    for name in ("hoist and swing", "dump"):
        assert loads[name] == pytest.approx(loads[name][::-1], rel=1e-12)
        assert loads[name].argmax() == 6
    assert cycle.loads(18.75)[0, 6] == pytest.approx((386.4e3 + 384e3) / 2, rel=1e-12)


def test_one_number_is_a_constant_load_on_every_shoe():
    assert LoadCycle.constant(450e3) == LoadCycle.constant([450e3] * 13)
    assert LoadCycle.constant(7, 3).phases[0].loads == (7.0, 7.0, 7.0)
    assert LoadCycle.constant(np.array([1.0, 2.0])).phases[0].loads == (1.0, 2.0)


def test_a_cycle_is_read_from_toml(tmp_path):
    path = tmp_path / "cycle.toml"
    path.write_text(
        '[[phases]]\nname = "propel"\nend = 2.0\nloads = [1e5, 2e5]\n'
        '[[phases]]\nname = "dig"\nend = 4.0\nloads = [3e5, 1e5]\n'
    )
    cycle = LoadCycle.from_toml(path)
    assert cycle.loads(3.0)[0] == pytest.approx([2e5, 1.5e5])
    path.write_text("phases = 1")
    with pytest.raises(ValueError, match=r"^\S*cycle\.toml: phases: must be .*, got 1$"):
        LoadCycle.from_toml(path)
    for content in (b"[[phases", b"\xff\xfe", b"a = " + b"[" * 100_000):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"cycle\.toml: not TOML"):
            LoadCycle.from_toml(path)


EVEN = '[[phases]]\nname = "propel"\nend = 2.0\nloads = 4e5\n'
DIG = '[[phases]]\nname = "dig"\nend = 4.0\nloads = [3e5, 1e5, 2e5]\n'
ALONE = "loads.file must be the name of a load cycle, without other keys"


def test_one_number_loads_every_shoe_alike(tmp_path):
    path = tmp_path / "cycle.toml"
    path.write_text(EVEN)
    assert LoadCycle.from_toml(path).phases[0].loads == (4e5,) * 13
    path.write_text(EVEN + DIG)
    assert LoadCycle.from_toml(path, shoe_count=3).loads(0.0).tolist() == [[4e5] * 3]
    with pytest.raises(ValueError, match="every phase needs a load for every shoe"):
        LoadCycle.from_toml(path)


def test_one_number_stands_for_the_loads_of_a_case_file(read):
    text = 'base = "stress"\nflexible = "none"\nloads = 4e5\n[track]\nshoe_count = 3\n'
    assert read(text).case.loads == LoadCycle.constant([4e5] * 3)
    assert read(text, ["loads=3e5"]).case.loads == LoadCycle.constant([3e5] * 3)
    with pytest.raises(CaseFileError, match="loads: "):
        read(text, ["loads=true"])


def test_a_case_file_names_a_cycle_beside_it(read, tmp_path):
    (tmp_path / "loads").mkdir()
    (tmp_path / "loads" / "cycle.toml").write_text(EVEN + DIG)
    text = 'base = "translation"\n[track]\nshoe_count = 3\n'
    loads = read(f'{text}[loads]\nfile = "loads/cycle.toml"\n').case.loads
    assert loads == LoadCycle.from_toml(tmp_path / "loads" / "cycle.toml", 3)
    assert read(text + (EVEN + DIG).replace("[[phases]]", "[[loads.phases]]")).case.loads == loads


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ('file = "cycle.toml"\nbase = "propel"', ALONE),
        ("file = 3", ALONE),
        ('file = "nowhere.toml"', "no load cycle .*nowhere.toml"),
        ('file = "broken.toml"', "broken.toml: not TOML"),
        ('file = "empty.toml"', r"empty\.toml: phases: missing; give it, or start from"),
        ('file = "odd.toml"', r"odd\.toml: speed: unknown key"),
        ('file = "lacking.toml"', r"lacking\.toml: phases\[0\]\.loads: missing$"),
        (
            'file = "short.toml"',
            r"^\S*short\.toml: phases\[0\]\.loads: must be a list, or a load in N for all",
        ),
    ],
)
def test_cycles_that_cannot_be_are_refused_with_the_case(read, tmp_path, table, told):
    (tmp_path / "broken.toml").write_text("[[phases")
    (tmp_path / "empty.toml").write_text("# nothing yet\n")
    (tmp_path / "odd.toml").write_text("speed = 1\n" + EVEN)
    (tmp_path / "lacking.toml").write_text('[[phases]]\nname = "a"\nend = 1\n')
    (tmp_path / "short.toml").write_text(EVEN.replace("4e5", "true"))
    with pytest.raises(CaseFileError, match=told):
        read(f'base = "translation"\n[loads]\n{table}\n')
