"""Pins of a shoe among all round holes: the two lines of bores that join shoes to a chain.

The next shoe's rear pin is this shoe's front pin, and its lugs stand between this shoe's. The bores of both
lines therefore lie side by side along the pin, without overlap, and within reach. Holes for bolts, grease and
lightness come in pairs that overlap.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.body.mesh import Floats, Integers
from meshes.recognition import bores
from meshes.recognition.bores import Bore
from meshes.recognition.triangles import Triangles

PARALLEL = np.cos(np.radians(3.0))
"""Least cosine between parallel axes of short, coarse bores."""
SAME_LINE = 0.15
"""Greatest distance between the axes of holes on one line, fraction of the radius."""
SAME_RADIUS = 0.15
"""Tolerance of the radii on a line, fraction of its main radius; other holes are counterbores or for other
parts."""
EQUAL_RADII = 2e-3
"""Greatest difference of equal bores in a coarse mesh, fraction of the radius."""
OVERLAP = 0.05
"""Greatest overlap of the bores of both lines, fraction of the shorter line's length."""
REACH = 0.6
"""Greatest gap between the bores of both lines, fraction of the same length."""
LEAST_PITCH = 0.5
GREATEST_PITCH = 1.0
"""Range of the pitch, fraction of the shoe's extent from pin to pin."""
RADII = 2.0
"""Greatest ratio of the radii of both lines."""
COARSE = 0.25
"""Deviation of corners of a bore of five facets where cross holes cut its chords, fraction of the radius."""
HALF_ROUND = np.radians(200.0)
"""Greatest gap around an axis in the faces of a partial bore, rad."""
CLOSE = 0.5
"""Score above which another pair raises a question, fraction of the best pair's score."""


@dataclass(frozen=True, eq=False)
class PinLine:
    """Bores of a pin, on one axis.

    Attributes
    ----------
    axis, point : array (3,)
    bores : tuple of Bore
    """

    axis: Floats
    point: Floats
    bores: tuple[Bore, ...]

    @property
    def length(self) -> float:
        """Sum of the lengths of the bores."""
        return float(np.diff(self.spans(self.axis), axis=1).sum())

    @cached_property
    def radius(self) -> float:
        """Mean radius, weighted by length."""
        lengths = [bore.ends[1] - bore.ends[0] for bore in self.bores]
        return float(np.average([bore.radius for bore in self.bores], weights=lengths))

    @property
    def has_equal_radii(self) -> bool:
        """True if all bores have one radius, within the deviation of their corners."""
        radii = [bore.radius for bore in self.bores]
        slack = EQUAL_RADII * max(radii) + 2.0 * max(bore.off_round for bore in self.bores)
        return max(radii) - min(radii) <= slack

    @property
    def faces(self) -> Integers:
        """Triangles of all bores of the line."""
        return np.concatenate([bore.faces for bore in self.bores])

    @property
    def off_round(self) -> float:
        """Root mean square deviation of the corners from the bores' cylinders."""
        return float(np.sqrt(np.mean([bore.off_round**2 for bore in self.bores])))

    def spans(self, axis: Floats) -> Floats:
        """Return the ends of the bores along a direction, the lowest first: array (bores, 2)."""
        ends = []
        for bore in self.bores:
            heights = (bore.point + np.multiply.outer(bore.ends, bore.axis)) @ axis
            ends.append((heights.min(), heights.max()))
        return np.array(sorted(ends))


@dataclass(frozen=True, eq=False)
class PinPair:
    """Two lines of bores that join shoes to a chain.

    Attributes
    ----------
    lines : tuple of two PinLine
    axis : array (3,)
        Direction of the pins.
    ahead : array (3,)
        Direction from the first line to the second, at right angles to the pins.
    pitch : float
    score : float
        Rank of the pair.
    """

    lines: tuple[PinLine, PinLine]
    axis: Floats
    ahead: Floats
    pitch: float
    score: float


def pin_lines(holes: list[Bore]) -> list[PinLine]:
    """Group holes by their line; leave out holes that differ from the main radius of a line."""
    groups: list[list[Bore]] = []
    for hole in holes:
        for group in groups:
            first = group[0]
            off = bores.across(hole.point + np.mean(hole.ends) * hole.axis, first.axis, first.point)
            if abs(first.axis @ hole.axis) > PARALLEL and np.linalg.norm(off) < SAME_LINE * first.radius:
                group.append(hole)
                break
        else:
            groups.append([hole])
    return [_of_one_radius(group) for group in groups]


def _of_one_radius(group: list[Bore]) -> PinLine:
    lengths = np.array([hole.ends[1] - hole.ends[0] for hole in group])
    radii = np.array([hole.radius for hole in group])
    alike = np.abs(radii[:, None] - radii) < SAME_RADIUS * radii
    most = alike[:, int(np.argmax(lengths @ alike))]
    members = tuple(hole for hole, is_in in zip(group, most, strict=True) if is_in)
    longest = members[int(np.argmax(lengths[most]))]
    return PinLine(longest.axis, longest.point, members)


def pin_pairs(triangles: Triangles, lines: list[PinLine]) -> list[PinPair]:
    """Return the pairs of lines that make a chain, the likeliest first."""
    pairs = []
    for first, second in itertools.combinations(lines, 2):
        if abs(first.axis @ second.axis) < PARALLEL:
            continue
        ahead = bores.across(second.point, first.axis, first.point)
        pitch = float(np.linalg.norm(ahead))
        if pitch <= first.radius + second.radius:
            continue
        extent = float(np.ptp(triangles.points @ (ahead / pitch)))
        radii = sorted((first.radius, second.radius))
        least = min(first.length, second.length)
        beside = interleaved(first.spans(first.axis), second.spans(first.axis))
        if beside and radii[1] < RADII * radii[0] and LEAST_PITCH < pitch / extent < GREATEST_PITCH:
            pairs.append(PinPair((first, second), first.axis, ahead / pitch, pitch, least * pitch))
    return sorted(pairs, key=lambda pair: -pair.score)


def interleaved(a: Floats, b: Floats) -> bool:
    """Return True if spans (k, 2) and (m, 2) lie side by side, within reach."""
    least = min(np.diff(a, axis=1).sum(), np.diff(b, axis=1).sum())
    reach = min(a.max(), b.max()) - max(a.min(), b.min())
    return overlap(a, b) < OVERLAP * least and reach > -REACH * least


def overlap_of_spans(a: Floats, b: Floats) -> Floats:
    """Return the overlap (k, m) of each of the spans (k, 2) with each of (m, 2)."""
    low = np.maximum(a[:, None, 0], b[None, :, 0])
    high = np.minimum(a[:, None, 1], b[None, :, 1])
    return np.maximum(high - low, 0.0)


def overlap(a: Floats, b: Floats) -> float:
    """Return the total overlap of spans (k, 2) and (m, 2)."""
    return float(overlap_of_spans(a, b).sum())


def refined(triangles: Triangles, pair: PinPair) -> PinPair:
    """Return the pair of pins with the missed parts of their bores, and axes fitted to all corners.

    Raises
    ------
    ValueError
        If the axes of both lines are not parallel.
    """
    first, second = (_whole_line(triangles, line, pair.axis) for line in pair.lines)
    sense = np.sign(first.axis @ second.axis)
    axis = first.length * first.axis + sense * second.length * second.axis
    axis /= np.linalg.norm(axis)
    ahead = bores.across(second.point, axis, first.point)
    pitch = float(np.linalg.norm(ahead))
    if abs(first.axis @ second.axis) < PARALLEL:
        raise ValueError("the axes of the front and the rear pins must be parallel, but they are not")
    return PinPair((first, second), axis, ahead / pitch, pitch, pair.score)


def _whole_line(triangles: Triangles, line: PinLine, axis: Floats) -> PinLine:
    """Return a line with all faces on its cylinder; its axis is fitted to the corners of all bores."""
    guess = Bore(*_fitted(triangles, line.bores, axis), line.radius, (0.0, 0.0), line.faces, 0.0)
    on_line = triangles.connected_regions(bores.on_cylinder(triangles, guess, along=1.0))
    fits = [bores.fit_bore(triangles, part) for part in on_line if len(part) >= bores.FEWEST_FACES]
    members = [bore for bore in fits if bore is not None]
    there = np.concatenate([bore.faces for bore in members]) if members else line.faces[:0]
    # a bore of a different radius is not among these parts
    members += [bore for bore in line.bores if not np.isin(bore.faces, there).any()]
    _refuse_broken(triangles, guess, members)
    fitted_axis, point = _fitted(triangles, members, axis)
    return PinLine(fitted_axis, point, tuple(members))


def _refuse_broken(triangles: Triangles, guess: Bore, members: Sequence[Bore]) -> None:
    """Raise `ValueError` if faces around a pin's cylinder form no complete bore, which hides a fork."""
    left = bores.on_cylinder(triangles, guess, along=1.0, near=COARSE)
    left[np.concatenate([bore.faces for bore in members])] = False
    for part in triangles.connected_regions(left):
        places = triangles.points[np.unique(triangles.faces[part])]
        if bores.greatest_gap(places, guess.axis, guess.point) < HALF_ROUND:
            place = places.mean(axis=0).round(4).tolist()
            raise ValueError(
                "bores on the axes of the pins must be whole and round, one of radius "
                f"{guess.radius:.4g} near {place} is too coarse or broken: mesh bores with at "
                "least 12 elements around them"
            )


def _fitted(triangles: Triangles, members: Sequence[Bore], axis: Floats) -> tuple[Floats, Floats]:
    """Return the axis of bores, and a point on it at the middle of their corners."""
    groups = [triangles.points[np.unique(triangles.faces[bore.faces])] for bore in members]
    direction = members[0].axis * np.sign(members[0].axis @ axis)
    fitted_axis, point, _, _ = bores.fit_axis(groups, direction)
    return fitted_axis, point
