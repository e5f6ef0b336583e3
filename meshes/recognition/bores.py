"""Round through holes of a body, found on its boundary triangles without a CAD kernel.

A candidate is a region that bends only inwards. A fitted cylinder, joined by all other faces on it, shows
whether the hole is round and complete. Cross holes and chamfers may divide it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from fem.body.mesh import Floats, Integers
from meshes.recognition.triangles import Triangles

INWARD_BEND = np.radians(65.0)
"""Greatest angle between neighbouring faces of a hole with six or more faces, rad."""
OUTWARD_BENDS = np.radians((30.0, 12.0, 1.0))
"""Tolerances of outward bends, rad: the first search finds badly cut bores complete, the last stops at
filleted rims."""
FEWEST_FACES = 6
LEAST_SPREAD = 0.10
FLAT_SPREAD = 0.25
"""Spread of a hole's normals: greatest share along the axis, and least one along either direction across
it."""
NEAR = 0.08
"""Greatest radial deviation of corners of a hole's faces, such as those on chords, fraction of the radius."""
NEAREST = 0.01
"""The same deviation if a pocket breaks into a hole, since the pocket's wall faces the axis too."""
LOOKS = 0.75
ALONG = 0.35
"""Least cosine between a face's normal and the direction to the axis, and greatest one with the axis."""
OFF_ROUND = 0.05
"""Greatest root mean square deviation of a hole's corners, fraction of the radius."""
GREATEST_GAP = np.radians(100.0)
"""Greatest angle around the axis without a corner, rad: a groove is no hole."""
LEAST_AREA = 0.6
GREATEST_AREA = 1.3
"""Range of a hole's area over its cylinder's; cross holes take a part away."""
ROUNDS = 4
"""Number of fits without the outliers: corners of cross holes lie on chords."""
SPREAD = 3.0
"""Outlier limit of a fit, in median errors."""
EXACT = 1e-7
"""Rounding error, fraction of the size."""


@dataclass(frozen=True, eq=False)
class Bore:
    """Round hole in the axes of its triangles.

    Attributes
    ----------
    axis, point : array (3,)
        Unit vector, and a point on the axis.
    radius : float
    ends : tuple of float
        Ends along the axis from the point.
    faces : int array
        Triangles of the bore.
    off_round : float
        Root mean square deviation of the corners from the cylinder, in the unit of the triangles.
    """

    axis: Floats
    point: Floats
    radius: float
    ends: tuple[float, float]
    faces: Integers
    off_round: float

    @property
    def middle(self) -> Floats:
        """Middle of the bore's axis: array (3,)."""
        return self.point + 0.5 * sum(self.ends) * self.axis


def across(places: Floats, axis: Floats, point: Floats) -> Floats:
    """Return the vectors (..., 3) from an axis to points (..., 3), at right angles to it."""
    off = places - point
    return np.asarray(off - np.multiply.outer(off @ axis, axis))


def find_bores(triangles: Triangles) -> list[Bore]:
    """Find all round through holes, the largest first."""
    bores: list[Bore] = []
    used = np.zeros(len(triangles.faces), dtype=bool)
    for outward in OUTWARD_BENDS:
        linked = (triangles.bends > -INWARD_BEND) & (triangles.bends < outward)
        for seed in _round_regions(triangles, triangles.labels(linked)):
            if used[seed].any():
                continue
            guess = fit_bore(triangles, seed, whole=False)
            if guess is None:
                continue
            for whole in _whole_bores(triangles, guess, used):
                bores.append(whole)
                used[whole.faces] = True
    return sorted(bores, key=lambda bore: -bore.radius * (bore.ends[1] - bore.ends[0]))


def _whole_bores(triangles: Triangles, guess: Bore, used: np.ndarray) -> list[Bore]:
    """Return the complete bores among the faces on a guess's cylinder that are not `used`: booleans (k,)."""
    for near in (NEAR, NEAREST):
        parts = triangles.connected_regions(on_cylinder(triangles, guess, near=near) & ~used)
        fits = [fit_bore(triangles, part) for part in parts if len(part) >= FEWEST_FACES]
        if whole := [bore for bore in fits if bore is not None]:
            return whole
    return []


def _round_regions(triangles: Triangles, label: Integers) -> list[Integers]:
    """Return the triangles of each region with normals around an axis, judged by their spread."""
    areas = triangles.areas
    moments = np.zeros((label.max() + 1, 3, 3))
    for a in range(3):
        for b in range(3):
            products = areas * triangles.normals[:, a] * triangles.normals[:, b]
            moments[:, a, b] = np.bincount(label, products, len(moments))
    spread = np.linalg.eigvalsh(moments / np.maximum(np.bincount(label, areas), 1e-300)[:, None, None])
    is_round = (spread[:, 0] < LEAST_SPREAD) & (spread[:, 1] > FLAT_SPREAD)
    is_round &= np.bincount(label) >= FEWEST_FACES
    numbers = np.flatnonzero(is_round[label])
    order = numbers[np.argsort(label[numbers], kind="stable")]
    return [part for part in np.split(order, np.flatnonzero(np.diff(label[order])) + 1) if len(part)]


def on_cylinder(triangles: Triangles, bore: Bore, along: float = ALONG, near: float = NEAR) -> np.ndarray:
    """Return True for triangles (k,) with corners on a bore's cylinder that face its axis.

    `along` is the greatest cosine between normal and axis, `near` the greatest deviation of corners, fraction
    of the radius.
    """
    away = np.linalg.norm(across(triangles.points, bore.axis, bore.point), axis=1)
    is_near = np.abs(away - bore.radius) < near * bore.radius
    chosen = is_near[triangles.faces].all(axis=1)
    ways = across(triangles.middles, bore.axis, bore.point)
    facing = -np.einsum("kc,kc->k", triangles.normals, ways)
    chosen &= facing > LOOKS * np.linalg.norm(ways, axis=1)
    return np.asarray(chosen & (np.abs(triangles.normals @ bore.axis) < along))


def fit_bore(triangles: Triangles, faces: Integers, whole: bool = True) -> Bore | None:
    """Fit a cylinder about a void to faces; return None if it is not round or, on request, not `whole`."""
    share = triangles.areas[faces] / triangles.areas[faces].sum()
    normals = triangles.normals[faces]
    spread, directions = np.linalg.eigh(np.einsum("f,fa,fb->ab", share, normals, normals))
    if spread[0] > LEAST_SPREAD or spread[1] < FLAT_SPREAD:
        return None
    places = triangles.points[np.unique(triangles.faces[faces])]
    axis, point, radii, off = fit_axis([places], directions[:, 0])
    radius = float(radii[0])
    off_round = float(np.sqrt(np.mean(off**2)))
    ways = across(triangles.middles[faces], axis, point)
    facing = -share @ (np.einsum("fc,fc->f", normals, ways) / np.linalg.norm(ways, axis=1))
    if off_round > OFF_ROUND * radius or facing < 0.9:
        return None
    along = (places - point) @ axis
    ends = float(along.min()), float(along.max())
    area = triangles.areas[faces].sum() / (2.0 * np.pi * radius * max(ends[1] - ends[0], 1e-300))
    gapped = greatest_gap(places, axis, point) > GREATEST_GAP
    if whole and (gapped or not LEAST_AREA < area < GREATEST_AREA):
        return None
    return Bore(axis, point, radius, ends, faces, off_round)


def greatest_gap(places: Floats, axis: Floats, point: Floats) -> float:
    """Return the greatest angle (rad) around an axis without a point."""
    u, v = np.linalg.svd(axis[None])[2][1:]
    ways = across(places, axis, point)
    angles = np.sort(np.arctan2(ways @ v, ways @ u))
    return float(np.diff(np.append(angles, angles[0] + 2.0 * np.pi)).max())


def fit_axis(groups: list[Floats], direction: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Fit cylinders with one common axis to groups of points, each with its own radius.

    Outliers on chords of coarse holes are left out of the last fits.

    Parameters
    ----------
    groups : list of array (n, 3)
    direction : array (3,)
        Approximate direction of the axis.

    Returns
    -------
    axis, point : array (3,)
    radii : array (groups,)
    off : array (places,)
        Deviation of each point from its cylinder.
    """
    places = np.concatenate(groups)
    owner = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    middle = places.mean(axis=0)
    size = float(np.ptp(places, axis=0).max())
    local = (places - middle) / size
    across_axis = np.linalg.svd(direction[None])[2][1:]

    def cylinder(values: Floats) -> tuple[Floats, Floats]:
        axis = direction + values[:2] @ across_axis
        return axis / np.linalg.norm(axis), values[2:4] @ across_axis

    def errors(values: Floats, chosen: np.ndarray) -> Floats:
        away = np.linalg.norm(across(local[chosen], *cylinder(values)), axis=1)
        return np.asarray(away - values[4:][owner[chosen]])

    values = _circle_guess(local @ across_axis.T, owner)
    every = np.ones(len(places), dtype=bool)
    chosen = every
    for _ in range(ROUNDS):
        values = least_squares(errors, values, args=(chosen,), method="trf", x_scale="jac").x
        off = np.abs(errors(values, every))
        closest = off <= max(SPREAD * np.median(off), EXACT)
        if (closest == chosen).all() or closest.sum() < 3 * len(groups) + 4:
            break
        chosen = closest
    axis, point = cylinder(values)
    return axis, middle + size * point, size * values[4:], size * errors(values, every)


def _circle_guess(flat: Floats, owner: Integers) -> Floats:
    """Return the start of a fit: no tilt, common centre of circles through points (n, 2), and radii."""
    count = owner.max() + 1
    # x^2 + y^2 = 2 a x + 2 b y + c of every group, by least squares
    terms = np.column_stack((2.0 * flat, np.eye(count)[owner]))
    solved = np.linalg.lstsq(terms, (flat**2).sum(axis=1), rcond=None)[0]
    radii = np.sqrt(np.maximum(solved[2:] + solved[0] ** 2 + solved[1] ** 2, 1e-12))
    return np.concatenate(([0.0, 0.0], solved[:2], radii))
