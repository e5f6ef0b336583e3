"""Shoes of known pins as solids of netgen's CAD kernel, mm: x ahead, y along the pins, z up."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from meshes.recognition.solids import netgen_module
from meshes.recognition.triangles import Triangles

Span = tuple[float, float]


@dataclass(frozen=True)
class Pins:
    """What is known of a shoe's pins: their distance and height, mm; radii of bores; the bores along y."""

    pitch: float
    height: float
    radii: Span  # of front and rear bores
    front: Sequence[Span]
    rear: Sequence[Span]


PLATE = Pins(200.0, 60.0, (15.0, 15.0), ((-160, -120), (120, 160)), ((-115, -75), (75, 115)))
MINING = Pins(
    480.0,
    165.0,
    (36.0, 40.0),
    ((-530, -470), (-360, -300), (300, 360), (470, 530)),
    ((-460, -370), (370, 460)),
)
INTERLEAVED = Pins(250.0, 65.0, (18.0, 18.0), ((-195, -125), (-35, 35), (125, 195)), ((-115, -45), (45, 115)))
LINKS = Pins(216.0, 68.0, (24.0, 33.0), ((-134, -98), (98, 134)), ((-96, -60), (60, 96)))
FOUR_LUGS = Pins(
    310.0,
    52.0,
    (23.0, 20.0),
    ((-210, -150), (-90, -30), (30, 90), (150, 210)),
    ((-146, -94), (-26, 26), (94, 146)),
)


def occ() -> Any:
    """Module of netgen's CAD kernel, or a skipped test."""
    pytest.importorskip("netgen.occ")
    return netgen_module("occ", "a solid")


def box(x: Span, y: Span, z: Span) -> Any:
    steps = occ()
    return steps.Box(steps.Pnt(x[0], y[0], z[0]), steps.Pnt(x[1], y[1], z[1]))


def rod(start: tuple[float, float, float], along: str, radius: float, length: float) -> Any:
    """Cylinder from a place along X, Y or Z."""
    steps = occ()
    return steps.Cylinder(steps.Pnt(*start), getattr(steps, along), radius, length)


def with_lugs(body: Any, pins: Pins, nose: float, root: float, foot: float, rail: float = 0.0) -> Any:
    """Body with lugs from x = -root or root to round noses about the pins, bored; on links up to a rail."""
    holes = []
    top = rail or pins.height + nose
    for x, inner, radius, spans in (
        (0.5 * pins.pitch, -root, pins.radii[0], pins.front),
        (-0.5 * pins.pitch, root, pins.radii[1], pins.rear),
    ):
        for y in spans:
            body += rod((x, y[0], pins.height), "Y", nose, y[1] - y[0])
            body += box((min(x, inner), max(x, inner)), y, (foot, top))
            holes.append(rod((x, y[0] - 1.0, pins.height), "Y", radius, y[1] - y[0] + 2.0))
    for hole in holes:
        body -= hole
    return body


def plate() -> Any:
    """Plate with a grouser; outer lugs ahead, inner ones behind; bolt holes through the plate."""
    body = box((-95, 95), (-300, 300), (0, 20)) + box((-60, -40), (-300, 300), (-45, 0))
    body = with_lugs(body, PLATE, 30.0, 80.0, 5.0)
    for x in (-20, 20):
        for y in (-230, 230):
            body -= rod((x, y, -50.0), "Z", 10.0, 80.0)
    return body


def mining() -> Any:
    """Forks ahead, web, flange and two rails; holes along all axes, some across the bores."""
    body = box((-230, 230), (-900, 900), (0, 30)) + box((-110, 110), (-700, 700), (30, 270))
    body += box((-200, 200), (-600, 600), (250, 285))
    for y in ((-260, -120), (120, 260)):
        body += box((-200, 200), y, (285, 310))
    body = with_lugs(body, MINING, 70.0, -100.0, 95.0)
    for x in (-55, 55):
        body -= rod((x, -701.0, 90.0), "Y", 30.0, 1402.0)
    for y in (-620, 0, 620):
        body -= rod((-300.0, y, 150.0), "X", 36.0, 600.0)
    for x in (-190, 190):
        for y in (-800, -650, 650, 800):
            body -= rod((x, y, -1.0), "Z", 18.0, 40.0) + rod((x, y, 20.0), "Z", 32.0, 20.0)
    for sign in (-1.0, 1.0):
        body -= rod((240.0, sign * 330.0, 165.0), "Z", 8.0, 100.0)
        body -= rod((-400.0, sign * 415.0, 165.0), "X", 6.0, 160.0)
    return body


def interleaved() -> Any:
    """Three lugs ahead with chamfered bores, two behind."""
    body = box((-115, 115), (-350, 350), (0, 25)) + box((-70, 70), (-240, 240), (25, 110))
    body = with_lugs(body, INTERLEAVED, 35.0, -60.0, 20.0)
    circle = 2.0 * np.pi * INTERLEAVED.radii[0]
    rims = [edge for edge in body.edges if abs(edge.center.x - 125.0) < 1.0 and abs(edge.mass - circle) < 1.0]
    return body.MakeChamfer(rims, 3.0)


def links(pocket: str = "round") -> Any:
    """Plate of a dozer on two links with rails; pockets for nuts break into the rear bores."""
    body = box((-100, 92), (-280, 280), (-16, 0)) + box((66, 82), (-280, 280), (-80, -15))
    body = with_lugs(body, LINKS, 46.0, 21.6, 22.0, 128.0)
    for y in ((-134, -60), (60, 134)):
        body += box((-75.6, 75.6), y, (0, LINKS.height))
    # the pad between the halves of a link is bored with them, to a pin's width
    for x, radius in ((-108, 33.0), (108, 24.0)):
        for y in ((-97, -59), (59, 97)) if x < 0 else ((-135, -97), (97, 135)):
            body -= rod((x, y[0], LINKS.height), "Y", radius, y[1] - y[0])
    for sign in (-1.0, 1.0):
        for x in (-62.0, 0.0, 50.0):
            body -= rod((x, sign * 97.0, -60.0), "Z", 11.0, 90.0)
            if pocket == "round":
                body -= rod((x, sign * 97.0, 20.0), "Z", 22.0, 40.0)
            else:
                body -= box((x - 22.0, x + 22.0), (sign * 97.0 - 19.0, sign * 97.0 + 19.0), (20.0, 60.0))
    return body


def four_lugs() -> Any:
    """Four lugs ahead, three behind, three grousers below, the outer ones at the plate's edges."""
    body = box((-140, 140), (-260, 260), (0, 22))
    for x in ((-140, -120), (-10, 10), (120, 140)):
        body += box(x, (-260, 260), (-35, 0))
    body = with_lugs(body, FOUR_LUGS, 42.0, 60.0, 5.0)
    body += box((-60, 60), (-230, 230), (22, 100))
    # an oil hole into a middle bore, and a hole in the web's one side alone
    body -= rod((155.0, 60.0, 52.0), "Z", 6.0, 60.0)
    body -= rod((0.0, -231.0, 60.0), "Y", 17.0, 200.0)
    return body


SOLIDS = {
    "plate": (plate, PLATE),
    "mining": (mining, MINING),
    "interleaved": (interleaved, INTERLEAVED),
    "links": (links, LINKS),
    "four lugs": (four_lugs, FOUR_LUGS),
}


def surface_of(solid: Any, size: float, curves: float) -> Triangles:
    """Triangles of a solid's surface with edges up to a size, mm, and `curves` of them along a radius."""
    from netgen.meshing import MeshingStep

    mesh = (
        occ()
        .OCCGeometry(solid)
        .GenerateMesh(
            maxh=size,
            grading=0.4,
            curvaturesafety=curves,
            segmentsperedge=0.4,
            perfstepsend=MeshingStep.MESHSURFACE,
        )
    )
    corners = mesh.Elements2D().NumPy()["nodes"][:, :3].astype(np.int64) - 1
    return Triangles(np.array(mesh.Coordinates()), corners).outward()
