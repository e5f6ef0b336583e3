"""Rules of undercarriages against figures of makers and calculations by hand."""

import math

import numpy as np
import pytest

from exudyn_crawler.machines.datasheet import rules, typical


def test_pins_circle_of_a_half_pitch_sprocket_is_that_of_its_service_manual():
    # Case CX350B: pitch 215.9 mm, 21 teeth of which a chain uses every second, pitch circle 732.5 mm
    assert rules.pin_circle(215.9, 10.5) == pytest.approx(732.5, abs=0.05)
    assert rules.gaps_of(215.9, 732.5) == pytest.approx(10.5, abs=1e-3)


def test_pins_on_the_circle_are_a_pitch_apart():
    gaps, pitch = 11, 0.2
    angle = 2.0 * math.pi / gaps * np.arange(2)
    place = 0.5 * rules.pin_circle(pitch, gaps) * np.array([np.cos(angle), np.sin(angle)])
    assert np.linalg.norm(place[:, 1] - place[:, 0]) == pytest.approx(pitch, rel=1e-12)


def test_pitch_that_closes_the_loop_of_a_komatsu_pc300lc_is_that_of_its_chain():
    # C = 4.030, L = 4.955 m, 48 shoes; 215.9 mm with 0.44 pitches from the pin to the tip of the grousers
    assert rules.pitch_of_loop(4.030, 4.955, 48, 0.44, 0.0) == pytest.approx(0.2159, rel=1e-3)
    assert rules.pitch_of_loop(4.030, 4.955, 48, 0.275, 0.036) == pytest.approx(0.2159, rel=1e-3)


def test_pitch_that_closes_a_loop_closes_it():
    on_ground, over, shoes, depth, grouser = 3.1, 3.9, 45, 0.3, 0.02
    pitch = rules.pitch_of_loop(on_ground, over, shoes, depth, grouser)
    circle = over - on_ground - 2.0 * (depth * pitch + grouser)
    assert rules.loop_length(on_ground, circle) == pytest.approx(shoes * pitch, rel=1e-12)
    pitch = rules.pitch_of_gaps(on_ground, shoes, 10.5)
    assert rules.loop_length(on_ground, rules.pin_circle(pitch, 10.5)) == pytest.approx(
        shoes * pitch, rel=1e-12
    )


def test_pitches_that_close_about_wheels_of_a_sprockets_size_close():
    over, shoes, gaps, depth, grouser, share = 5.2, 47, 10.5, 0.28, 0.03, 0.35
    pitch = rules.pitch_of_crawler(over, shoes, gaps, depth, grouser)
    circle = rules.pin_circle(pitch, gaps)
    on_ground = over - circle - 2.0 * (depth * pitch + grouser)
    assert rules.loop_length(on_ground, circle) == pytest.approx(shoes * pitch, rel=1e-12)
    # as long on the ground as its pressure says, which counts a share of the ends
    whole = rules.ground_length(on_ground, over, share)
    assert rules.pitch_of_whole(whole, shoes, gaps, (depth, grouser), share) == pytest.approx(
        pitch, rel=1e-12
    )
    assert rules.pitch_of_ends(over - on_ground, gaps, depth, grouser) == pytest.approx(pitch, rel=1e-12)


@pytest.mark.parametrize(("mass", "pitch"), [(13e3, 0.171), (27e3, 0.203), (35e3, 0.2159), (1.41e6, 0.6557)])
def test_pitches_of_machines_follow_from_their_mass_within_15_per_cent(mass, pitch):
    assert rules.pitch_by_mass(mass, typical.row_of("pitch_by_mass", "excavator").value) == pytest.approx(
        pitch, rel=0.15
    )


@pytest.mark.parametrize(
    ("kind", "mass", "width", "on_ground", "over", "printed"),
    [
        ("excavator", 34991.0, 0.7, 4.03, 4.955, 0.58 * 98066.5),  # Komatsu PC300LC-8
        ("excavator", 35371.0, 0.8, 4.03, 4.955, 0.51 * 98066.5),
        ("excavator", 35751.0, 0.85, 4.03, 4.955, 0.49 * 98066.5),
        ("excavator", 16100.0, 0.5, 2.88, 3.69, 50e3),  # Caterpillar 315C and 315C L
        ("excavator", 16970.0, 0.7, 3.17, 3.97, 34e3),
        ("dozer", 39500.0, 0.56, 3.275, 4.5, 106e3),  # Komatsu D155AX-6
    ],
)
def test_ground_pressures_are_those_that_makers_print(kind, mass, width, on_ground, over, printed):
    share = typical.row_of("pressure_share", kind).value
    length = rules.ground_length(on_ground, over, share)
    # printed with two digits
    assert rules.ground_pressure(mass, width, length, 9.81) == pytest.approx(printed, rel=0.025)


def test_wheels_beside_each_other_clear_by_their_play():
    way = rules.clear_of(0.3, 0.1, 0.25, 0.02)
    assert math.hypot(way, 0.25) == pytest.approx(0.3 + 0.1 + 0.02, rel=1e-12)
    assert rules.clear_of(0.3, 0.1, 0.5, 0.02) == 0.0


def test_inertias_of_boxes_and_wheels():
    assert rules.box_inertia(12.0, 1.0, 2.0, 3.0) == pytest.approx([4 + 9, 1 + 9, 1 + 4])
    assert rules.ring_inertia(2.0, 3.0)[1] == pytest.approx(0.5 * 2.0 * 9.0)


def test_torque_of_a_sprocket_gives_its_half_of_the_pull():
    torque = rules.sprocket_torque(200e3, 0.4, 0.9)
    assert 2.0 * torque * 0.9 / 0.4 == pytest.approx(200e3)


def test_every_typical_value_has_range_source_and_how_well_it_is_known():
    for row in typical.table().values():
        assert row.low <= row.value <= row.high, row
        assert row.meaning, row
        assert row.source, row
        assert row.known in {"seen", "remembered", "project", "chosen"}, row
    assert all((name, "") in typical.table() for name in typical.names())
