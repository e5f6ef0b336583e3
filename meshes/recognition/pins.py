"""Pins of a shoe among all round holes: the two lines of bores by which shoes make a chain.

The next shoe's rear pin is this one's front pin. Its lugs stand between this one's: the bores of both lines
lie beside each other along the pin, never over each other, and yet within reach. Holes for bolts, grease and
lightness come in pairs that lie over each other.
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
"""Least cosine between axes that are parallel: those of short, coarse bores."""
SAME_LINE = 0.15
"""Of the radius: greatest distance of the axes of holes on one line."""
SAME_RADIUS = 0.15
"""Of the radius of most of a line: other holes on it are counterbores or for other parts."""
EQUAL_RADII = 2e-3
"""Of the radius: greatest difference of bores that are equal, by a coarse mesh."""
OVERLAP = 0.05
"""Of the shorter line's length: greatest part over which bores of both lines lie over each other."""
REACH = 0.6
"""Of the same length: greatest gap between all bores of one line and all of the other."""
LEAST_PITCH = 0.5
GREATEST_PITCH = 1.0
"""Of the shoe's extent from pin to pin."""
RADII = 2.0
"""Greatest ratio of the radii of both lines."""
COARSE = 0.25
"""Of the radius: how far corners of a bore of five facets are off it, where cross holes cut its chords."""
HALF_ROUND = np.radians(200.0)
"""Greatest gap around an axis of faces that are a part of a bore."""
CLOSE = 0.5
"""Of the best pair's score: from which another pair is worth a question."""


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
        """Sum of the lengths of its bores."""
        return float(np.diff(self.spans(self.axis), axis=1).sum())

    @cached_property
    def radius(self) -> float:
        """Mean radius, by length."""
        lengths = [bore.ends[1] - bore.ends[0] for bore in self.bores]
        return float(np.average([bore.radius for bore in self.bores], weights=lengths))

    @property
    def has_equal_radii(self) -> bool:
        """True for bores of one radius, within what their corners are off round."""
        radii = [bore.radius for bore in self.bores]
        slack = EQUAL_RADII * max(radii) + 2.0 * max(bore.off_round for bore in self.bores)
        return max(radii) - min(radii) <= slack

    @property
    def faces(self) -> Integers:
        """Triangles of all of its bores."""
        return np.concatenate([bore.faces for bore in self.bores])

    @property
    def off_round(self) -> float:
        """Root mean square of how far corners are off the bores' cylinders."""
        return float(np.sqrt(np.mean([bore.off_round**2 for bore in self.bores])))

    def spans(self, axis: Floats) -> Floats:
        """Ends of its bores along a direction, the lowest first: array (bores, 2)."""
        ends = []
        for bore in self.bores:
            heights = (bore.point + np.multiply.outer(bore.ends, bore.axis)) @ axis
            ends.append((heights.min(), heights.max()))
        return np.array(sorted(ends))


@dataclass(frozen=True, eq=False)
class PinPair:
    """Two lines of bores by which shoes make a chain.

    Attributes
    ----------
    lines : tuple of two PinLine
    axis : array (3,)
        Along the pins.
    ahead : array (3,)
        From the first line to the second, at right angles to the pins.
    pitch : float
    score : float
        By which pairs are ordered.
    """

    lines: tuple[PinLine, PinLine]
    axis: Floats
    ahead: Floats
    pitch: float
    score: float


def pin_lines(holes: list[Bore]) -> list[PinLine]:
    """Holes by the line that they lie on, those of other radii than most of it left out."""
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
    """Pairs of lines that make a chain, the likeliest first."""
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
    """True for spans (k, 2) and (m, 2) that lie beside each other, within reach."""
    least = min(np.diff(a, axis=1).sum(), np.diff(b, axis=1).sum())
    reach = min(a.max(), b.max()) - max(a.min(), b.min())
    return overlap(a, b) < OVERLAP * least and reach > -REACH * least


def overlap_of_spans(a: Floats, b: Floats) -> Floats:
    """Lengths (k, m) over which each of the spans (k, 2) and each of (m, 2) lie over each other."""
    low = np.maximum(a[:, None, 0], b[None, :, 0])
    high = np.minimum(a[:, None, 1], b[None, :, 1])
    return np.maximum(high - low, 0.0)


def overlap(a: Floats, b: Floats) -> float:
    """Length over which spans (k, 2) and (m, 2) lie over each other."""
    return float(overlap_of_spans(a, b).sum())


def refined(triangles: Triangles, pair: PinPair) -> PinPair:
    """Pair of pins with parts of their bores that the search had lost, and axes fitted to all corners.

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
        raise ValueError("the axes of the front and the rear pins must be parallel, they are not")
    return PinPair((first, second), axis, ahead / pitch, pitch, pair.score)


def _whole_line(triangles: Triangles, line: PinLine, axis: Floats) -> PinLine:
    """Line with all faces on its cylinder, its axis fitted to the corners of all of its bores."""
    guess = Bore(*_fitted(triangles, line.bores, axis), line.radius, (0.0, 0.0), line.faces, 0.0)
    on_line = triangles.patches(bores.on_cylinder(triangles, guess, along=1.0))
    fits = [bores.fit_bore(triangles, part) for part in on_line if len(part) >= bores.FEWEST_FACES]
    members = [bore for bore in fits if bore is not None]
    there = np.concatenate([bore.faces for bore in members]) if members else line.faces[:0]
    # a bore of another radius than the others is none of these parts
    members += [bore for bore in line.bores if not np.isin(bore.faces, there).any()]
    _refuse_broken(triangles, guess, members)
    fitted_axis, point = _fitted(triangles, members, axis)
    return PinLine(fitted_axis, point, tuple(members))


def _refuse_broken(triangles: Triangles, guess: Bore, members: Sequence[Bore]) -> None:
    """Refuse a pin on whose cylinder faces go round that are no whole bore: without them a fork is none."""
    left = bores.on_cylinder(triangles, guess, along=1.0, near=COARSE)
    left[np.concatenate([bore.faces for bore in members])] = False
    for part in triangles.patches(left):
        places = triangles.points[np.unique(triangles.faces[part])]
        if bores.greatest_gap(places, guess.axis, guess.point) < HALF_ROUND:
            place = places.mean(axis=0).round(4).tolist()
            raise ValueError(
                "bores on the axes of the pins must be whole and round, one of radius "
                f"{guess.radius:.4g} near {place} is too coarse or broken: mesh bores with at "
                "least 12 elements around them"
            )


def _fitted(triangles: Triangles, members: Sequence[Bore], axis: Floats) -> tuple[Floats, Floats]:
    """Axis of bores, and a place on it at the middle of their corners."""
    groups = [triangles.points[np.unique(triangles.faces[bore.faces])] for bore in members]
    direction = members[0].axis * np.sign(members[0].axis @ axis)
    fitted_axis, point, _, _ = bores.fit_axis(groups, direction)
    return fitted_axis, point
