"""Overlap of an underside with a unit against closed forms and brute-force quadrature."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from exudyn_crawler.ground.overlap import overlap, overlap_workspace

HALF = 3.5
LENGTH, WIDTH = 0.655742, 3.505


def rectangle(x, y, yaw=0.0, depth=0.06, slope_x=0.0, slope_y=0.0, length=LENGTH, width=WIDTH):
    """Corners of an underside whose middle is at (x, y, depth), deeper by the slopes (1) along x and y."""
    across = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.5 * np.array([length, width])
    c, s = math.cos(yaw), math.sin(yaw)
    offset = across @ np.array([[c, s], [-s, c]])
    return np.column_stack((offset + np.array([x, y]), depth + offset @ [slope_x, slope_y]))


def clipped(corners, half_x=HALF, half_y=HALF):
    work = overlap_workspace()
    work[0, :4, :3] = corners
    part = overlap(work, half_x, half_y)
    width = min(part.high_xi - part.low_xi, part.high_eta - part.low_eta)
    return part.area, part.xi, part.eta, part.depth, width


def quadrature(corners, half_x=HALF, half_y=HALF, cells=1500):
    """Area, centroid of the volume and mean depth over it, by the midpoint rule on the rectangle."""
    s = (np.arange(cells) + 0.5) / cells
    u, v = np.meshgrid(s, s, indexing="ij")
    origin, edge_u, edge_v = corners[0], corners[1] - corners[0], corners[3] - corners[0]
    x, y, d = (origin[k] + u * edge_u[k] + v * edge_v[k] for k in range(3))
    cell = abs(edge_u[0] * edge_v[1] - edge_u[1] * edge_v[0]) / cells**2
    within = (np.abs(x) < half_x) & (np.abs(y) < half_y) & (d > 0.0)
    volume = np.sum(d[within])
    return cell * within.sum(), *(np.sum((k * d)[within]) / volume for k in (x, y, d))


INSIDE = 0.5 * LENGTH - 0.1
A, B = 0.5 * LENGTH - 0.2, 0.5 * WIDTH - 1.0
WEDGE = 2.0 / 3.0 * LENGTH
CLOSED_FORMS = {
    "whole": (rectangle(0.4, -1.1), (LENGTH * WIDTH, 0.4, -1.1, 0.06, LENGTH), 1e-12),
    "straddling": (
        rectangle(HALF + 0.1, 0.0),
        (INSIDE * WIDTH, HALF - 0.5 * INSIDE, 0.0, 0.06, INSIDE),
        1e-12,
    ),
    "corner": (rectangle(HALF + 0.2, -HALF - 1.0), (A * B, HALF - 0.5 * A, -HALF + 0.5 * B, 0.06, A), 1e-12),
    # a square on its tip that reaches 0.2 m over the edge from outside
    "triangle": (
        rectangle(HALF + math.sqrt(0.5) - 0.2, 0.3, yaw=math.pi / 4, length=1.0, width=1.0),
        (0.2**2, HALF - 0.2 / 3.0, 0.3, 0.06, 0.2),
        1e-9,
    ),
    # depth falls from 0.04 at the rear to -0.02 at the front: two thirds are in the ground; its mean, with
    # itself for weights, is that at the centroid of a triangle
    "wedge": (
        rectangle(0.0, 0.0, depth=0.01, slope_x=-0.06 / LENGTH),
        (WEDGE * WIDTH, -0.5 * LENGTH + WEDGE / 3.0, 0.0, 2.0 / 3.0 * 0.04, WEDGE),
        1e-12,
    ),
}


@pytest.mark.parametrize(("corners", "expected", "rel"), CLOSED_FORMS.values(), ids=CLOSED_FORMS)
def test_area_centroid_depth_and_width_are_those_of_the_closed_form(corners, expected, rel):
    assert clipped(corners) == pytest.approx(expected, rel=rel, abs=1e-14)


@pytest.mark.parametrize(
    "corners",
    [
        rectangle(HALF + LENGTH, 0.0),
        rectangle(0.0, 6.0),
        rectangle(0.0, 0.0, depth=-0.001),
        rectangle(0.4, -1.1)[::-1],
    ],
    ids=["beside", "beside across", "above", "looking up"],
)
def test_apart_there_is_no_overlap(corners):
    assert clipped(corners) == (0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "place",
    [
        {"x": 3.4, "y": 0.2, "yaw": 0.1, "slope_x": 0.05},
        {"x": -3.3, "y": 2.9, "yaw": -0.7, "slope_y": 0.02},
        {"x": 3.6, "y": -3.4, "yaw": 1.2, "depth": 0.01, "slope_x": 0.03, "slope_y": -0.02},
        {"x": 0.0, "y": 0.0, "yaw": 0.4, "depth": 0.0, "slope_x": 0.1, "slope_y": 0.03},
    ],
)
def test_any_overlap_is_that_of_brute_force(place):
    corners = rectangle(**place)
    # the midpoint rule on 1500 x 1500 cells errs by its cut cells, some 1e-3 of the sides at most
    area, xi, eta, depth, _ = clipped(corners)
    expected = quadrature(corners)
    assert area == pytest.approx(expected[0], rel=2e-3)
    assert (xi, eta) == pytest.approx(expected[1:3], abs=1e-3)
    assert depth == pytest.approx(expected[3], rel=2e-3)


places = {
    "x": st.floats(-0.5, 0.5),
    "y": st.floats(-1.0, 1.0),
    "yaw": st.floats(-0.5, 0.5),
    "depth": st.floats(-0.02, 0.1, allow_subnormal=False),
    "slope_x": st.floats(-0.1, 0.1, allow_subnormal=False),
    "slope_y": st.floats(-0.03, 0.03, allow_subnormal=False),
}


@settings(max_examples=200, deadline=None)
@given(**places)
def test_the_two_units_under_a_straddling_shoe_share_all_of_it(x, y, yaw, depth, slope_x, slope_y):
    corners = rectangle(x, y, yaw, depth, slope_x, slope_y)
    whole = clipped(corners, 50.0, 50.0)
    parts = [clipped(corners + np.array([shift, 0.0, 0.0])) for shift in (HALF, -HALF)]
    assert sum(part[0] for part in parts) == pytest.approx(whole[0], rel=1e-9, abs=1e-9)


@settings(max_examples=100, deadline=None)
@given(**places, dx=st.floats(-20.0, 20.0), dy=st.floats(-20.0, 20.0))
def test_moving_all_together_changes_nothing(x, y, yaw, depth, slope_x, slope_y, dx, dy):
    corners = rectangle(x, y, yaw, depth, slope_x, slope_y)
    here = clipped(corners, 50.0, 50.0)
    there = clipped(corners + np.array([dx, dy, 0.0]), 50.0, 50.0)
    assert there[0] == pytest.approx(here[0], rel=1e-9, abs=1e-12)
    if here[0] > 1e-6:
        # a sliver's centroid is a ratio of small numbers
        assert there[1:4] == pytest.approx((here[1] + dx, here[2] + dy, here[3]), rel=1e-6, abs=1e-6)
        assert there[4] == pytest.approx(here[4], rel=1e-6)
