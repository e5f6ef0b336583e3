"""Rules of undercarriages against figures of makers and calculations by hand."""

import math

import numpy as np
import pytest

from exudyn_crawler.machines.datasheet import rules, typical
from exudyn_crawler.machines.datasheet.chain import chain_of
from exudyn_crawler.machines.datasheet.sheet import Datasheet

N, GAPS, DEPTH, G = 45, 10.5, 0.3, 0.02
"""Shoes, gaps of the sprocket, depth of the plate below the pins in pitches, height of grousers in m."""
CIRCLE = 1.0 / math.sin(math.pi / GAPS)
"""Diameter of the pins' circle, pitches."""


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
    for depth, grouser in ((0.44, 0.0), (0.275, 0.036)):
        pitch = rules.closing_pitch(
            48, lambda p, d=depth, g=grouser: (4.03, 4.955 - 4.03 - 2.0 * (d * p + g))
        )
        assert pitch == pytest.approx(0.2159, rel=1e-3)


LENGTHS = {
    "length_on_ground crawler_length": lambda c, whole: (
        (2.0 * c + math.pi * (whole - c - 2.0 * G)) / (N + 2.0 * math.pi * DEPTH)
    ),
    "length_on_ground": lambda c, _whole: 2.0 * c / (N - math.pi * CIRCLE),
    "crawler_length": lambda _c, whole: (
        2.0 * (whole - 2.0 * G) / (N + 4.0 * DEPTH - (math.pi - 2.0) * CIRCLE)
    ),
}
"""Pitch by the closed forms of the table of rules."""


@pytest.mark.parametrize("given", LENGTHS)
def test_pitch_of_a_number_of_shoes_is_the_closed_form_of_its_rule_and_closes_the_loop(given):
    lengths = {"length_on_ground": 3.1, "crawler_length": 3.9}
    values = {"operating_weight": 30e3, "gauge": 2.5, "shoe_width": 0.6, "shoes": N, "grouser_height": G}
    values |= {name: lengths[name] for name in given.split()}
    sheet = Datasheet(**values, sprocket_gaps=GAPS, typical={"plate_depth": DEPTH})
    chain = chain_of(sheet, 9.81)
    assert chain.pitch == pytest.approx(LENGTHS[given](*lengths.values()), rel=1e-12)
    assert rules.loop_length(chain.on_ground, chain.diameter) == pytest.approx(N * chain.pitch, rel=1e-12)


def test_pitch_of_a_printed_area_counts_a_share_of_the_ends():
    values = {"operating_weight": 30e3, "gauge": 2.5, "shoe_width": 0.6, "shoes": N, "grouser_height": G}
    sheet = Datasheet(**values, contact_area=4.2, sprocket_gaps=GAPS, typical={"plate_depth": DEPTH})
    chain = chain_of(sheet, 9.81)
    share = sheet.typical_value("pressure_share")
    counted = rules.ground_length(chain.on_ground, chain.over_shoes, share)
    assert counted == pytest.approx(4.2 / 1.2, rel=1e-12)
    assert rules.loop_length(chain.on_ground, chain.diameter) == pytest.approx(N * chain.pitch, rel=1e-12)
    ends = chain.over_shoes - chain.on_ground
    assert rules.pitch_of_ends(ends, GAPS, DEPTH, G) == pytest.approx(chain.pitch, rel=1e-12)


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
