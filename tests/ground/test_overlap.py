"""Overlap of an underside with a unit: closed forms, brute-force quadrature, gradients."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from exudyn_crawler.ground.overlap import GRADIENT, overlap, overlap_workspace, write_gradient

HALF = 3.5
LENGTH, WIDTH = 0.655742, 3.505


def rectangle(x, y, yaw=0.0, depth=0.06, slope_x=0.0, slope_y=0.0, length=LENGTH, width=WIDTH):
    """Corners of an underside whose middle is at (x, y, depth), deeper by the slopes (1) along x and y."""
    across = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.5 * np.array([length, width])
    c, s = math.cos(yaw), math.sin(yaw)
    offset = across @ np.array([[c, s], [-s, c]])
    return np.column_stack((offset + np.array([x, y]), depth + offset @ [slope_x, slope_y]))


def overlapped(corners, half=HALF):
    """Overlap of corners (4, 3) with a square unit, and the polygon that it leaves.

    Of the polygon's corners the fourth number is a function that is linear over the underside.
    """
    work = overlap_workspace()
    work[0, :4, :3] = corners
    work[0, :4, 3] = corners[:, 0] + 0.3 * corners[:, 1]
    part = overlap(work, half, half)
    return part, work[1 if part.cut else 0]


def clipped(corners, half=HALF):
    part, _ = overlapped(corners, half)
    width = min(part.high_xi - part.low_xi, part.high_eta - part.low_eta)
    return part.area, part.xi, part.eta, part.depth, width


def quadrature(corners, cells=1500):
    """Area, centroid of the volume and mean depth over it, by the midpoint rule on the rectangle."""
    s = (np.arange(cells) + 0.5) / cells
    u, v = np.meshgrid(s, s, indexing="ij")
    origin, edge_u, edge_v = corners[0], corners[1] - corners[0], corners[3] - corners[0]
    x, y, d = (origin[k] + u * edge_u[k] + v * edge_v[k] for k in range(3))
    cell = abs(edge_u[0] * edge_v[1] - edge_u[1] * edge_v[0]) / cells**2
    within = (np.abs(x) < HALF) & (np.abs(y) < HALF) & (d > 0.0)
    volume = np.sum(d[within])
    return cell * within.sum(), *(np.sum((k * d)[within]) / volume for k in (x, y, d))


INSIDE = 0.5 * LENGTH - 0.1
A, B = 0.5 * LENGTH - 0.2, 0.5 * WIDTH - 1.0
WEDGE = 2.0 / 3.0 * LENGTH
CLOSED_FORMS = {
    "whole": (rectangle(0.4, -1.1), (LENGTH * WIDTH, 0.4, -1.1, 0.06, LENGTH), 1e-12),
    "beside": (rectangle(HALF + 0.1, 0.0), (INSIDE * WIDTH, HALF - 0.5 * INSIDE, 0.0, 0.06, INSIDE), 1e-12),
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


APART = {
    "beside": rectangle(HALF + LENGTH, 0.0),
    "beside across": rectangle(0.0, 6.0),
    "above": rectangle(0.0, 0.0, depth=-0.001),
    "looking up": rectangle(0.4, -1.1)[::-1],
}


@pytest.mark.parametrize("corners", APART.values(), ids=APART)
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
    area, *middle, depth, _ = clipped(corners)
    expected = quadrature(corners)
    assert (area, depth) == pytest.approx(expected[::3], rel=2e-3)
    assert middle == pytest.approx(expected[1:3], abs=1e-3)


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
def test_the_two_units_under_a_straddling_shoe_share_all_of_it(**place):
    corners = rectangle(**place)
    parts = [clipped(corners + np.array([shift, 0.0, 0.0])) for shift in (HALF, -HALF)]
    assert sum(part[0] for part in parts) == pytest.approx(clipped(corners, 50.0)[0], rel=1e-9, abs=1e-9)


@settings(max_examples=100, deadline=None)
@given(**places, dx=st.floats(-20.0, 20.0), dy=st.floats(-20.0, 20.0))
def test_moving_all_together_changes_nothing(dx, dy, **place):
    corners = rectangle(**place)
    here, there = (clipped(corners + np.array(by), 50.0) for by in ((0.0, 0.0, 0.0), (dx, dy, 0.0)))
    assert there[0] == pytest.approx(here[0], rel=1e-9, abs=1e-12)
    if here[0] > 1e-6:
        # a sliver's centroid is a ratio of small numbers
        assert there[1:4] == pytest.approx((here[1] + dx, here[2] + dy, here[3]), rel=1e-6, abs=1e-6)
        assert there[4] == pytest.approx(here[4], rel=1e-6)


CORNERS = {
    "side": {"x": HALF - 0.1, "y": 0.2},
    "other side": {"x": -HALF + 0.1, "y": 0.2, "slope_x": 0.03},
    "side, yawed and tilted": {"x": HALF - 0.05, "y": -1.2, "yaw": 0.1, "slope_x": 0.05, "slope_y": 0.01},
    "side across": {"x": 0.3, "y": HALF - 1.0, "yaw": -0.06, "slope_y": 0.01},
    "corner": {"x": HALF - 0.1, "y": -HALF + 0.5, "yaw": 0.2, "slope_x": -0.02, "slope_y": 0.015},
    "corner far away": {"x": -HALF - 0.1, "y": HALF + 0.7, "yaw": -0.15, "slope_x": 0.02, "slope_y": 0.01},
    "side, half out of the ground": {"x": HALF - 0.1, "y": 0.2, "yaw": 0.03, "depth": 0.0, "slope_y": 0.03},
    "half out of the ground": {"x": 0.3, "y": 0.2, "yaw": 0.1, "depth": 0.01, "slope_x": 0.08},
}


def values(part) -> np.ndarray:
    """What `write_gradient` gives the changes of."""
    first = [part.volume * one for one in (1.0, part.xi, part.eta, part.depth)]
    widths = part.high_xi - part.low_xi, part.high_eta - part.low_eta
    return np.array([part.area, *first, part.side_x, part.side_y, *widths])


@pytest.mark.parametrize("place", CORNERS.values(), ids=CORNERS)
def test_the_gradient_of_an_overlap_is_that_of_central_differences(place):
    corners, gradient = rectangle(**place), np.zeros((GRADIENT, 3))
    part, polygon = overlapped(corners)
    slopes = place.get("slope_x", 0.0), place.get("slope_y", 0.0)
    write_gradient(polygon, part.cut, part, HALF, HALF, *slopes, gradient)
    # depth is against z
    steps = 1e-6 * np.diag([1.0, 1.0, -1.0])
    ends = [[values(overlapped(corners + sign * u)[0]) for sign in (1.0, -1.0)] for u in steps]
    expected = np.array([(ahead - behind) / 2e-6 for ahead, behind in ends]).T
    # the area vector is what volume changes by
    assert (part.side_x, part.side_y, part.area) == pytest.approx(-expected[1], rel=1e-6, abs=1e-8)
    # widths of polygons with slanted ends change by more than the side, which is left out
    kept = slice(0, 9 if place.get("yaw", 0.0) == 0.0 else 7)
    assert gradient[kept] == pytest.approx(expected[kept], rel=1e-6, abs=1e-7)


def test_within_a_unit_no_side_is_within_the_shoe():
    part, _ = overlapped(rectangle(0.4, -1.1, slope_x=0.03))
    assert (part.side_x, part.side_y, part.cut) == (0.0, 0.0, 0)
