"""Shoes of CAD solids, meshed coarse and fine, are the same in any axes and unit, or ask."""

from functools import cache

import numpy as np
import pytest

from meshes.recognition import shoe
from meshes.recognition.axes import Choices, NodesUnit
from meshes.recognition.surfaces import find_surfaces
from tests.meshes.solid_shoes import SOLIDS, surface_of
from tests.meshes.test_recognition import moved

CURVES = (0.7, 1.0, 1.5, 2.2, 3.0)
"""Edges along a bore's radius: about 6 to 24 around it, with which a motion's number goes."""
LARGEST = 60.0  # mm
MM = NodesUnit("mm", "mm", 1e-3)
ASKED = {"plate": ["--footprint tips"], "links": ["--footprint tips"], "four lugs": ["--footprint tips"]}
LOST = {"links": (0.7,)}
RAILS = ("plate", "mining", "links")


@cache
def surface(name, curves):
    make, _ = SOLIDS[name]
    return surface_of(make(), LARGEST, curves)


def is_same(name, seed):
    """True where a solid, moved by a motion, is the shoe that it is; false where it is refused."""
    of_file = surface(name, CURVES[seed % len(CURVES)])
    triangles, turn, unit = moved(of_file, seed)
    _, pins = SOLIDS[name]
    if CURVES[seed % len(CURVES)] in LOST.get(name, ()):
        # so coarse that a bore is lost, and with it the chain
        with pytest.raises(ValueError, match="bores"):
            shoe.axes_of(triangles, Choices())
        return False
    axes = shoe.axes_of(triangles, Choices())
    found = find_surfaces(triangles, axes, None)
    flags = [question.flag for question in (*axes.questions, *found.questions)]
    assert [flag for flag in flags if flag != "--unit"] == ASKED.get(name, [])
    if axes.unit != unit:
        assert "--unit" in flags
        return True
    assert axes.pins.pitch * axes.scale == pytest.approx(1e-3 * pins.pitch, abs=3e-4)
    np.testing.assert_allclose(axes.rows @ turn, np.eye(3), atol=2e-3)
    rear, front = axes.pins.lines
    assert (len(front.bores), len(rear.bores)) == (len(pins.front), len(pins.rear))
    radii = [line.radius * axes.scale for line in (front, rear)]
    assert radii == pytest.approx(1e-3 * np.array(pins.radii), abs=3e-4)
    assert ("roller path" in found.faces) == (name in RAILS)
    # unmoved, the same mesh has the same surfaces
    plain = find_surfaces(of_file, shoe.axes_of(of_file, Choices(), MM), None)
    assert found.joint_y == pytest.approx(plain.joint_y, abs=1e-4)
    assert found.footprint_area == pytest.approx(plain.footprint_area, rel=1e-3)
    np.testing.assert_allclose(found.box("underside"), plain.box("underside"), atol=1e-3)
    np.testing.assert_allclose(found.box("top"), plain.box("top"), atol=1e-3)
    return True


@pytest.mark.slow
@pytest.mark.parametrize("name", SOLIDS)
def test_a_hundred_motions_units_and_facets_of_a_solid_give_the_same_shoe(name):
    same = sum(is_same(name, seed) for seed in range(100))
    assert same == 100 - 20 * len(LOST.get(name, ()))


def test_grousers_at_the_edges_of_a_plate_are_of_its_underside():
    of_file = surface("four lugs", 1.0)
    found = find_surfaces(of_file, shoe.axes_of(of_file, Choices(), MM), None)
    np.testing.assert_allclose(np.ptp(found.box("underside"), axis=0), [0.28, 0.52, 0.035], atol=1e-9)
    assert found.footprint_area == pytest.approx((0.28 - 0.02) * 0.52, rel=1e-9)


def test_rails_on_the_lugs_of_links_are_found_beside_pads_as_high_as_pins():
    of_file = surface("links", 1.5)
    found = find_surfaces(of_file, shoe.axes_of(of_file, Choices(), MM), None)
    np.testing.assert_allclose(np.ptp(found.box("roller path"), axis=0), [0.216, 0.268, 0.0], atol=1e-6)
