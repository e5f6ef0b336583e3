"""What pictures show in parallel projection: surfaces with values and arrows, and the direction of a view."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

HIDDEN = 0.002
"""m by which something has to lie before a point to hide it."""


@dataclass(frozen=True)
class View:
    """Direction of a parallel projection.

    Attributes
    ----------
    right, up : array (3,)
        Unit vectors that lie rightward and upward in the picture.
    """

    right: NDArray
    up: NDArray

    @classmethod
    def seen_from(cls, azimuth: float, elevation: float) -> Self:
        """View of somebody who stands at an azimuth about z from +x and an elevation, degrees."""
        around, above = np.radians([azimuth, elevation])
        right = np.array([-np.sin(around), np.cos(around), 0.0])
        toward = np.array(
            [np.cos(above) * np.cos(around), np.cos(above) * np.sin(around), np.sin(above)],
        )
        return cls(right, np.cross(toward, right))

    @property
    def toward(self) -> NDArray:
        """Unit vector from the scene to the viewer."""
        return np.cross(self.right, self.up)

    def project(self, points: NDArray) -> NDArray:
        """Points (n, 3) as right, up and toward the viewer: array (n, 3), m."""
        return points @ np.column_stack((self.right, self.up, self.toward))


@dataclass(frozen=True)
class Body:
    """Surface in one colour that lets the rest of a scene be seen through it.

    Attributes
    ----------
    points : array (n, 3)
        m.
    triangles : int array (m, 3)
        Corners in outward sense.
    colour : str
    opacity : float
    """

    points: NDArray
    triangles: NDArray
    colour: str
    opacity: float


@dataclass(frozen=True)
class Scene:
    """Surface coloured by nodal values, arrows, and bodies before or behind it.

    Attributes
    ----------
    points : array (n, 3)
        m.
    triangles : int array (m, 3)
        Corners in outward sense.
    values : array (n,)
    arrows : array (k, 2, 3)
        Tail and head of each, m.
    bodies : tuple of Body
    """

    points: NDArray
    triangles: NDArray
    values: NDArray
    arrows: NDArray
    bodies: tuple[Body, ...] = ()

    @classmethod
    def joined(cls, parts: "list[Scene]") -> Self:
        """One scene of several."""
        starts = np.cumsum([0, *(len(part.points) for part in parts[:-1])])
        return cls(
            np.concatenate([part.points for part in parts]),
            np.concatenate([part.triangles + start for part, start in zip(parts, starts, strict=True)]),
            np.concatenate([part.values for part in parts]),
            np.concatenate([part.arrows for part in parts]),
            tuple(body for part in parts for body in part.bodies),
        )

    def shows(self, point: int, view: View) -> bool:
        """Whether a point of the surface is seen, or something lies before it."""
        projected = view.project(self.points)
        here = projected[point]
        others = projected[self.triangles[(self.triangles != point).all(axis=1)]]
        around = (others.min(axis=1) <= here) & (others.max(axis=1) >= here)
        others = others[around[:, :2].all(axis=1)]
        origin = others[:, 0, :2]
        sides = np.stack((others[:, 1, :2] - origin, others[:, 2, :2] - origin), axis=-1)
        shares = np.linalg.pinv(sides) @ (here[:2] - origin)[:, :, None]
        u, v = shares[:, 0, 0], shares[:, 1, 0]
        depth = others[:, 0, 2] * (1.0 - u - v) + others[:, 1, 2] * u + others[:, 2, 2] * v
        covers = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
        return not bool((covers & (depth > here[2] + HIDDEN)).any())

    def without_arrows(self) -> "Scene":
        """Same surface alone."""
        return replace(self, arrows=self.arrows[:0])

    def moved(self, shift: NDArray) -> "Scene":
        """Same scene elsewhere; shift (3,), m."""
        bodies = tuple(replace(body, points=body.points + shift) for body in self.bodies)
        return replace(self, points=self.points + shift, arrows=self.arrows + shift, bodies=bodies)
