"""Scenes: where solids and arrows are, and how they are painted."""

import io
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from exudyn_crawler.views.scenes.pictures import draw_arrows, paint
from exudyn_crawler.views.scenes.scene import Arrows, Colouring, Placement, Solid, View, box

ABOVE = View.seen_from(azimuth=-90.0, elevation=90.0)
"""x to the right, y up."""


def surface(points, triangles, values):
    stress = Colouring("stress", values[None, None], 0.0, 1.0, "YlOrRd")
    return Solid("surface", points, (triangles,), "white", colourings=(stress,))


WEDGE = surface(
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.6]], dtype=float),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
    np.zeros(4),
)


def picture(surfaces, view, window=(-1.0, 1.0, -1.0, 1.0), arrows=None):
    """Red, green and blue of a picture of 200 x 200 pixels, the top row first."""
    figure = Figure(figsize=(2.0, 2.0), dpi=100)
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set_axis_off()
    paint(ax, surfaces, view, window)
    if arrows is not None:
        draw_arrows(ax, [arrows], view)
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=100)
    return np.asarray(Image.open(memory).convert("RGB")).astype(float)


def at(image, x, y):
    """Colour at a place of the window -1..1."""
    return image[round(99.5 - 100 * y), round(99.5 + 100 * x)]


def square(z, value, half=0.5):
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return surface(corners, np.array([[0, 1, 2], [0, 2, 3]]), np.full(4, value))


def test_a_view_has_the_axes_of_the_one_who_looks():
    assert np.array([ABOVE.right, ABOVE.up, ABOVE.toward]) == pytest.approx(np.eye(3))
    behind = View.seen_from(azimuth=180.0, elevation=0.0)
    # from behind the track, which runs along x, y = left is at the left
    axes = np.array([behind.right, behind.up, behind.toward])
    assert axes == pytest.approx(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]))
    slanted = View.seen_from(azimuth=25.0, elevation=-30.0)
    frame = np.array([slanted.right, slanted.up, slanted.toward])
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12)
    assert slanted.toward[2] == pytest.approx(-0.5)


def test_a_solid_covers_what_its_projection_covers():
    view = View.seen_from(azimuth=20.0, elevation=35.0)
    image = picture([WEDGE], view)
    covered = image.min(axis=2) < 250.0
    y, x = np.mgrid[0.995:-1.0:-0.01, -0.995:1.0:0.01]
    expected = np.zeros_like(covered)
    for corners in view.project(WEDGE.points)[WEDGE.triangles, :2]:
        inside = [
            (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
            for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
        ]
        expected |= np.all(np.array(inside) > 0.0, axis=0)
    assert expected.mean() > 0.1
    # edges are one pixel wide
    assert (covered != expected).mean() < 0.015


def test_the_nearer_surface_hides_the_other():
    pale, dark = (at(picture([square(0.0, value)], ABOVE), 0.0, 0.0) for value in (0.0, 1.0))
    near, far = square(0.2, 1.0, half=0.3), square(-0.2, 0.0)
    for order in ([near, far], [far, near]):
        image = picture(order, ABOVE)
        assert at(image, 0.0, 0.0) == pytest.approx(dark, abs=6)
        assert at(image, 0.4, 0.0) == pytest.approx(pale, abs=6)
    assert dark[1] < 0.3 * pale[1]


def test_arrows_point_from_tail_to_head():
    head, along = np.array([[[-0.8, 0.6, 0.1]]]), np.array([[[0.0, 1.4, 0.0]]])
    arrow = Arrows("force", "#1f4fd8", head, along, 1.0)
    image = picture([square(0.2, 0.0, 0.2)], ABOVE, arrows=arrow)
    blue = image[:, :, 2] - image[:, :, 0] > 60.0
    rows, columns = np.nonzero(blue)
    assert 0.99 - rows.min() / 100 == pytest.approx(0.6, abs=0.03)
    assert 0.99 - rows.max() / 100 == pytest.approx(-0.8, abs=0.03)
    assert columns.mean() / 100 - 0.995 == pytest.approx(-0.8, abs=0.02)
    # the head is broad, the tail is not
    widths = blue.sum(axis=1)[rows.min() : rows.max()]
    assert widths[:12].max() > widths[-60:].max()


def test_a_point_behind_something_is_not_shown():
    upper, lower = square(0.2, 0.0, half=0.3), square(-0.2, 0.0)
    centre = surface(
        np.vstack((upper.points, lower.points, [[0.1, 0.05, -0.2], [0.0, 0.1, -0.2], [0.45, 0.0, -0.2]])),
        np.vstack((upper.triangles, lower.triangles + 4, [[8, 9, 10]])),
        np.zeros(11),
    )
    assert not centre.shows(8, ABOVE)
    assert centre.shows(10, ABOVE)
    assert centre.shows(8, View.seen_from(azimuth=-90.0, elevation=-90.0))


def test_copies_of_a_solid_stand_where_they_are_placed_and_lifted():
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    solid = Solid(
        "box",
        *box(np.zeros(3), np.array([2.0, 1.0, 1.0])),
        "white",
        np.array([[[5.0, 0.0, 0.0], [np.nan] * 3, [0.0, 0.0, 0.0]]]),
        np.stack([np.eye(3), np.eye(3), turned])[None],
        lift=np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.3]]),
    )
    first, second = (replace(solid, lift=solid.lift[row:]).at() for row in (0, 1))
    # the second copy is nowhere
    assert len(first.points) == 16
    assert first.points[:8].min(axis=0) == pytest.approx([5.0, 0.0, 0.0])
    assert first.points[8:].min(axis=0) == pytest.approx([-1.0, 0.0, 0.1])
    assert first.points[8:].max(axis=0) == pytest.approx([0.0, 2.0, 1.1])
    assert second.points - first.points == pytest.approx(np.repeat([[0, 0, 0], [0, 0, 0.2]], 8, axis=0))
    a, b, c = (first.points[first.triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 == pytest.approx(4.0)


def test_what_bends_is_drawn_larger_and_seen_the_same_in_its_own_axes():
    points, faces = box(-np.ones(3), np.ones(3))
    rng = np.random.default_rng(4)
    bend, heads = rng.normal(size=(1, 1, 8, 3)), rng.normal(size=(1, 1, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    solid = Solid("box", points, faces, "white", bend=bend, larger=3.0)
    assert solid.at().points == pytest.approx(points + 3.0 * bend[0, 0])
    placed = Placement(np.array([1.0, 2.0, 3.0]), turn)
    moved = replace(solid, origin=placed.origin[None, None], turn=turn[None, None])
    force = Arrows("force", "blue", placed.place(heads), heads @ turn.T, 0.5)
    view, same = ABOVE, ABOVE.on(placed)
    assert same.project(moved.at().points) == pytest.approx(view.project(solid.at().points))
    own = np.stack((0.5 * heads[0], heads[0]), axis=1)
    assert same.project(force.at()) == pytest.approx(view.project(own))
