"""Named surfaces of a shoe in its own axes: bores, underside, top and rails, and the joints' positions."""

from dataclasses import dataclass

import numpy as np

from fem.body.mesh import Floats, Integers
from meshes.recognition.axes import Question, ShoeAxes, Sole
from meshes.recognition.bands import SAME_HEIGHT, level_parts, outline, two_rails
from meshes.recognition.pins import PinLine
from meshes.recognition.triangles import Triangles

PLATE = 0.01
"""Least area of a part of the plate, which grousers may divide, fraction of the largest level part below."""
SOLE = 0.005
"""Least area that can stand on the ground, fraction of the whole surface."""
TOP = 0.01
"""Least area of a part of the top, fraction of the largest level part below."""
LUG = 0.2
"""Tolerance of a flat on a lug, fraction of the bore's radius along x and of its length along y."""
MIRRORED = 0.02
"""Greatest difference between right and left lugs, fraction of the outer reach."""
PARTED = 1e-3
"""Distance from the middle, m, beyond which a bore across it is divided into right and left."""
SIDES = ("right", "left")
ENDS = ("rear", "front")


@dataclass(frozen=True, eq=False)
class ShoeSurfaces:
    """Surfaces of a shoe and the data of its chain, in its axes, m.

    Attributes
    ----------
    triangles : Triangles
    faces : dict of str to int array
        Numbers of the triangles of each named surface.
    joint_y : tuple of float
        y of the right and of the left joint.
    footprint : str
        "plate" or "tips".
    footprint_area : float
        Area of the underside, m2.
    remarks : tuple of str
    questions : tuple of Question
    """

    triangles: Triangles
    faces: dict[str, Integers]
    joint_y: tuple[float, float]
    footprint: Sole
    footprint_area: float
    remarks: tuple[str, ...]
    questions: tuple[Question, ...]

    def box(self, name: str) -> Floats:
        """Return the least and greatest x, y, z of a surface: array (2, 3), m."""
        return outline(self.triangles, self.faces[name])


def find_surfaces(triangles: Triangles, axes: ShoeAxes, footprint: Sole | None) -> ShoeSurfaces:
    """Find the named surfaces of a shoe.

    Raises
    ------
    ValueError
        If an end has no bores on one side, or no level face looks down.
    """
    local = triangles.moved(axes.origin, axes.rows, axes.scale)
    remarks: list[str] = []
    lines = dict(zip(ENDS, axes.pins.lines, strict=True))
    spans = {end: _spans(axes, line) for end, line in lines.items()}
    every = np.concatenate(list(spans.values()))
    middle = 0.5 * float(every.min() + every.max())
    faces: dict[str, Integers] = {}
    for end, line in lines.items():
        faces |= _sides_of_bores(local, end, line, middle)
        if ((spans[end][:, 0] < middle - PARTED) & (spans[end][:, 1] > middle + PARTED)).any():
            remarks.append(
                f"a {end} bore reaches over y = {middle:.4g} m: it is divided there into right and left"
            )
        off = np.abs(np.sort(2.0 * middle - spans[end].ravel()) - spans[end].ravel()).max()
        if off > MIRRORED * np.ptp(every):
            remarks.append(
                f"the {end} lugs are not alike on the right and on the left, by {1e3 * off:.3g} mm: check "
                "whether the picture has all of their bores"
            )
    joint_y, words = _joints(local, faces)
    remarks += words
    sole, area, questions = _underside(local, faces, footprint)
    faces |= _top(local, axes, faces, remarks)
    return ShoeSurfaces(local, faces, joint_y, sole, area, tuple(remarks), tuple(questions))


def _spans(axes: ShoeAxes, line: PinLine) -> Floats:
    """Return the ends (bores, 2) of a line's bores along y, m."""
    return np.asarray((line.spans(axes.rows[1]) - axes.origin @ axes.rows[1]) * axes.scale)


def _sides_of_bores(local: Triangles, end: str, line: PinLine, middle: float) -> dict[str, Integers]:
    """Return the bores of an end on the right and on the left."""
    y = local.middles[line.faces, 1]
    sides = {f"bore {end} {side}": line.faces[(y >= middle) == (side == "left")] for side in SIDES}
    if empty := [name for name, chosen in sides.items() if not len(chosen)]:
        raise ValueError(
            f"each end must have bores right and left of y = {middle:.4g} m, none is {empty[0]!r}"
        )
    return sides


def _joints(local: Triangles, faces: dict[str, Integers]) -> tuple[tuple[float, float], list[str]]:
    """Return y of the joints, the middle of the overlap or gap of both ends' bores on a side, and remarks."""
    places = []
    gaps = []
    for side in SIDES:
        boxes = [outline(local, faces[f"bore {end} {side}"])[:, 1] for end in ENDS]
        low = max(box[0] for box in boxes)
        high = min(box[1] for box in boxes)
        places.append(float(0.5 * (low + high)))
        gaps.append(low - high)
    remarks = []
    if max(gaps) > 0.0:
        remarks.append(
            f"front and rear lugs stand beside each other: joints act in the gap of {1e3 * max(gaps):.3g} mm "
            f"between them, at y = {places[0]:.4g} and {places[1]:.4g} m"
        )
    return (places[0], places[1]), remarks


def _underside(
    local: Triangles, faces: dict[str, Integers], footprint: Sole | None
) -> tuple[Sole, float, list[Question]]:
    """Name the underside: the plate, or the tips of grousers below it."""
    parts = level_parts(local, -1.0)
    if not parts:
        raise ValueError("the shoe must have a level underside, but no level face is directed down")
    areas = np.array([local.areas[part].sum() for part in parts])
    heights = np.array([local.middles[part, 2].mean() for part in parts])
    stands = (areas > SOLE * local.areas.sum()) | (np.arange(len(parts)) == 0)
    tips = np.abs(heights - heights[stands].min()) < SAME_HEIGHT
    plate = np.abs(heights - heights[0]) < SAME_HEIGHT
    plate &= (areas > PLATE * areas[0]) | tips
    plate |= _beyond_plate(local, parts, plate)
    drop = float(heights[0] - heights[stands].min())
    asked: list[Question] = []
    has_grousers = drop > SAME_HEIGHT
    sole: Sole = footprint or "plate"
    if has_grousers:
        words = (
            f"grousers reach {1e3 * drop:.3g} mm below the plate: the underside may be the plate of "
            f"{areas[plate].sum():.4g} m2 or their tips of {areas[tips].sum():.4g} m2"
        )
        if footprint is None:
            asked.append(Question("--footprint tips", f"{words}; the plate was chosen"))
    else:
        sole = "plate"
    chosen = tips if sole == "tips" or not has_grousers else plate
    faces["underside"] = np.concatenate([part for part, is_in in zip(parts, chosen, strict=True) if is_in])
    area = float(areas[chosen].sum())
    return sole, area, asked


def _beyond_plate(local: Triangles, parts: list[Integers], plate: np.ndarray) -> np.ndarray:
    """Return True for level parts below the plate, (parts,), that reach over its outline: edge grousers."""
    boxes = np.array([outline(local, part) for part in parts])
    low = boxes[plate, 0].min(axis=0)
    high = boxes[plate, 1].max(axis=0)
    beside = ((boxes[:, 0, :2] < low[:2] - PARTED) | (boxes[:, 1, :2] > high[:2] + PARTED)).any(axis=1)
    areas = np.array([local.areas[part].sum() for part in parts])
    return np.asarray(beside & (boxes[:, 1, 2] < low[2] - SAME_HEIGHT) & (areas > PLATE * areas[0]))


def _top(
    local: Triangles,
    axes: ShoeAxes,
    faces: dict[str, Integers],
    remarks: list[str],
) -> dict[str, Integers]:
    """Return the top, and rails on it if there are two: level parts that face up above the pins, no lugs."""
    parts = level_parts(local, 1.0)
    least = TOP * local.areas[faces["underside"]].sum()
    bores = [outline(local, chosen) for name, chosen in faces.items() if name.startswith("bore")]
    height = max(float(axes.place_of(line)[2]) for line in axes.pins.lines)
    large = [part for part in parts if local.areas[part].sum() > least]
    above = [part for part in large if local.middles[part, 2].mean() > height + SAME_HEIGHT]
    pitch = axes.pins.pitch * axes.scale
    others = [part for part in above if not any(_is_on_lug(outline(local, part), box) for box in bores)]
    # on shoes of links the rails lie on the lugs, and nothing is higher
    if others and not _is_highest(local, others, above) and two_rails(local, above, pitch)[0] is not None:
        others = above
    above = others or above
    if not above:
        above = [part for part in large if local.middles[part, 2].mean() > local.points[:, 2].min()]
        if not above:
            return {}
        remarks.append("no level part is above the pins: the top is made of all level faces that look up")
    named = {"top": np.concatenate(above)}
    rails, why = two_rails(local, above, pitch)
    if rails is not None:
        named["roller path"] = rails
    else:
        area = float(local.areas[named["top"]].sum())
        remarks.append(f"no rails: {why}; the machine presses on all of the top, {area:.3g} m2")
    return named


def _is_highest(local: Triangles, parts: list[Integers], every: list[Integers]) -> bool:
    """Return True if one of some level parts is as high as the highest of all."""
    heights = [max(float(local.middles[part, 2].mean()) for part in chosen) for chosen in (parts, every)]
    return heights[0] > heights[1] - SAME_HEIGHT


def _is_on_lug(part: Floats, bore: Floats) -> bool:
    """Return True for a part that ends above a pin and is as wide as the lug or fork of a bore; outlines."""
    (x0, y0, _), (x1, y1, _) = bore
    slack = LUG * (y1 - y0)
    pin = 0.5 * (x0 + x1)
    radius = 0.5 * (x1 - x0)
    reaches = part[0, 0] - LUG * radius < pin < part[1, 0] + LUG * radius
    return bool(reaches and y0 - slack < part[0, 1] and part[1, 1] < y1 + slack)
