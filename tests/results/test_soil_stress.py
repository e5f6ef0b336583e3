"""Pressure in the ground: closed forms of rectangle, circle and strip, equilibrium, and a run."""

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler.results.measured import soil_stress
from exudyn_crawler.results.measured.soil_stress import Pressed, Sensor, line_density, sensor_pressure

LOAD = 300e3
"""N, on one underside."""


def underside(size=(0.6, 3.5), offset=(0.0, 0.0), turned=0.0, force=LOAD):
    """Load of one shoe, whose underside's middle is at (2, 1)."""
    along = np.array([np.cos(turned), np.sin(turned)])
    return Pressed(
        force=np.array([[force]]),
        middle=np.array([[[2.0, 1.0]]]),
        along=along[None, None],
        offset=np.array(offset)[None, None],
        size=size,
    )


def stress(load, x, y, depth, concentration=3.0):
    return sensor_pressure(load, Sensor(x, y, depth), concentration)[0]


def below_corner(length, width, depth):
    """Stress below the corner of a rectangle with a pressure of 1, by Boussinesq (Holl, 1940)."""
    r1 = np.hypot(length, depth)
    r2 = np.hypot(width, depth)
    r3 = np.sqrt(length**2 + width**2 + depth**2)
    angle = np.arctan(length * width / (depth * r3))
    return (angle + length * width * depth / r3 * (1.0 / r1**2 + 1.0 / r2**2)) / (2.0 * np.pi)


@pytest.mark.parametrize("depth", [0.05, 0.3, 1.0, 4.0])
def test_below_a_rectangle_it_is_the_closed_form_of_boussinesq(depth):
    length, width = 0.6, 3.5
    pressure = LOAD / (length * width)
    middle = 4.0 * pressure * below_corner(0.5 * length, 0.5 * width, depth)
    assert stress(underside(), 2.0, 1.0, depth) == pytest.approx(middle, rel=2e-4)
    corner = pressure * below_corner(length, width, depth)
    assert stress(underside(), 2.3, 2.75, depth) == pytest.approx(corner, rel=2e-3)


def test_below_a_long_strip_it_is_the_closed_form():
    width, depth = 0.6, 0.5
    long = underside(size=(width, 60.0), force=1e3 * width * 60.0)
    angle = 2.0 * np.arctan(0.5 * width / depth)
    assert stress(long, 2.0, 1.0, depth) == pytest.approx(1e3 / np.pi * (angle + np.sin(angle)), rel=1e-3)


@pytest.mark.parametrize("concentration", [3.0, 4.0, 5.0, 6.0])
def test_below_a_circle_it_is_the_closed_form_of_froehlich(concentration):
    radius, depth, rings = 0.4, 0.3, 4000
    away = radius * (np.arange(rings) + 0.5) / rings
    forces = 2.0 * np.pi * away * radius / rings  # of a pressure of 1
    summed = soil_stress.vertical_stress(forces, away, depth, concentration).sum()
    closed = 1.0 - (1.0 + (radius / depth) ** 2) ** (-0.5 * concentration)
    assert summed == pytest.approx(closed, rel=1e-6)


@pytest.mark.parametrize("concentration", [3.0, 5.0])
def test_the_ground_bears_the_load_at_every_depth(concentration):
    load = underside(offset=(0.05, 0.4), turned=0.3)
    away = np.arange(-10.0, 11.0)
    summed = sum(stress(load, 2.0 + a, 1.0 + b, 1.0, concentration) for a in away for b in away)
    # a square of 10 m to all sides has all but some thousandths
    assert summed == pytest.approx(LOAD, rel=5e-3)


@pytest.mark.parametrize("offset", [-0.29, -0.1, -0.02, 0.0, 0.09, 0.11, 0.2])
def test_pressure_along_a_shoe_keeps_force_and_moment(offset):
    place = np.linspace(-0.3, 0.3, 60_001)
    density = line_density(place, 0.6, offset)
    assert density.min() >= 0.0
    assert np.trapezoid(density, place) == pytest.approx(1.0, rel=1e-4)
    assert np.trapezoid(place * density, place) == pytest.approx(offset, abs=1e-4)


def test_at_the_surface_it_is_the_pressure_below_the_shoe():
    even = LOAD / (0.6 * 3.5)
    assert stress(underside(), 2.29, 2.7, 0.0) == pytest.approx(even)
    assert stress(underside(), 2.31, 1.0, 0.0) == 0.0
    assert stress(underside(offset=(0.1, 0.0)), 2.3, 1.0, 0.0) == pytest.approx(2.0 * even)
    assert stress(underside(turned=np.pi / 2), 2.0 + 1.7, 1.0, 0.0) == pytest.approx(even)


def test_little_below_the_surface_it_is_that_of_the_surface():
    shifted = underside(offset=(0.05, 0.5))
    assert stress(shifted, 2.1, 1.3, 0.05, 4.0) == pytest.approx(stress(shifted, 2.1, 1.3, 0.0), rel=0.01)


def test_sensors_that_cannot_be_are_refused():
    for depth in (-0.1, 0.01):
        with pytest.raises(ValueError, match=f"depth must be 0 or at least 0.05 m, got {depth:g} m"):
            stress(underside(), 2.0, 1.0, depth)
    with pytest.raises(ValueError, match="concentration must be greater than zero, got 0"):
        stress(underside(), 2.0, 1.0, 0.5, 0.0)
    for text in ("1", "1,2,3,4", "1;2", "a,b"):
        with pytest.raises(ValueError, match="sensor must be x, y and depth in m with commas"):
            soil_stress.read_sensor(text)
    assert soil_stress.read_sensor("1, 2") == Sensor(1.0, 2.0)


def test_peaks_and_mean_are_of_the_passage():
    way = np.linspace(0.0, 10.0, 1001)
    over = (way > 2.0) & (way < 8.0)
    wave = np.where(over, 200e3 - 100e3 * np.cos(np.pi * way), 0.0)
    name = Sensor(5.0, 0.0).name
    row = soil_stress.passage_table(pd.DataFrame({"time in s": way, "distance in m": way, name: wave})).iloc[
        0
    ]
    assert row["sensor"] == "x 5 y 0 depth 0"
    assert row["mean in Pa"] == pytest.approx(200e3, rel=0.01)
    assert (row["peaks"], row["peaks over mean"]) == (3, pytest.approx(1.5, rel=0.01))


def test_shoes_of_a_run_press_with_their_normal_forces(rolled):
    load = soil_stress.pressed(rolled)
    forces = rolled.contacts_by_shoe().normal_force.sel(axis="z").transpose("time", "shoe").values
    assert load.force == pytest.approx(np.maximum(forces, 0.0), rel=1e-6, abs=1e-3)
    time, shoe = np.unravel_index(load.force.argmax(), load.force.shape)
    x, y = load.middle[time, shoe]
    under = sensor_pressure(load, Sensor(x, y))[time]
    assert under == pytest.approx(load.force[time, shoe] / np.prod(load.size), rel=0.5)
    # far below, all shoes together are one force at their centre
    deep = sensor_pressure(load, Sensor(x, y, 300.0), 3.0)[time]
    assert deep == pytest.approx(3.0 * load.force[time].sum() / (2.0 * np.pi * 300.0**2), rel=2e-3)
