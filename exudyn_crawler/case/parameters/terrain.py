"""Oil-sand terrain as a grid of units on spring-dampers."""

import math
from collections.abc import Callable
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import (
    Density,
    Errors,
    Parameters,
    Place,
    Slope,
    Two,
    option,
    quantity,
)

STEEPEST = 0.2
"""Greatest slope of a profile: gaps between the units' faces are half its square of their length, 2 %."""


class Sloping(Parameters):
    """Ground that leans as a whole: its axes lean with it, and gravity leans in them."""

    grade: Slope = quantity("1", "rise over horizontal run along x; + is uphill", (-0.3, 0.3), default=0.0)
    side_slope: Slope = quantity("1", "the same along y; + rises to the left", (-0.3, 0.3), default=0.0)

    @property
    def down(self) -> np.ndarray:
        """Direction of gravity: unit vector (3,) in the ground's axes.

        An axis whose ground rises by s over a horizontal run of 1 points up by the sine s / sqrt(1 + s**2).
        """
        x, y = (slope / math.hypot(1.0, slope) for slope in (self.grade, self.side_slope))
        # adding zero makes plain zeros of negative ones
        return np.array([-x, -y, -math.sqrt(1.0 - x**2 - y**2)]) + 0.0


class Terrain(Sloping):
    """Grid of rigid units, each with heave and one tilt on spring-dampers normal to the ground.

    Units count along y first, from 1. Their top faces lie at z = 0 while the springs are free. All places and
    directions are in the ground's own axes: on a slope gravity leans, and z stays normal to the ground.
    """

    model: Literal["units"] = option("units: blocks on springs, as the papers'", "units")
    origin: Two = quantity("m", "global x and y of the corner of the top face at unit 1", default=(0.0, 0.0))
    columns: int = quantity("1", "units along x", ge=1, le=10_000)
    rows: int = quantity("1", "units along y", ge=1, le=10_000)
    unit_length: float = quantity("m", "side of a unit in x", (0.1, 50.0), ge=1e-2, le=1e4)
    unit_width: float = quantity("m", "side of a unit in y", (0.1, 50.0), ge=1e-2, le=1e4)
    unit_height: float = quantity("m", "height of a unit", (0.1, 50.0), ge=1e-3, le=1e4)
    density: Density = quantity("kg/m3", "density of the units", (500.0, 4000.0))
    springs_per_unit: Literal[1, 2] = quantity("1", "vertical spring-dampers under each unit")
    spring_stiffness: float = quantity("N/m", "stiffness of each spring", (1e5, 1e11), ge=1.0, le=1e15)
    spring_damping: float = quantity("N s/m", "damping of each spring-damper", (0.0, 1e10), ge=0, le=1e15)
    spring_offset: float = quantity("m", "of each of two springs from the unit's centre", ge=0, le=1e4)
    column_tilt: bool = quantity("", "whether each spring resists tilting like the soil column it stands for")
    tilt: Literal["pitch", "roll"] = quantity("", "tilt that units keep: pitch (about y) or roll (about x)")
    heights: tuple[Place, ...] | None = quantity(
        "m",
        "height of every unit's top face above even ground, units counting along y first; None: all even. "
        "The units' centres, masses and springs stay as they are",
        (-20.0, 20.0),
        default=None,
    )
    profile: tuple[Place, ...] | None = quantity(
        "m",
        "height of the ground at the edges of the columns along x, the same across y, for a smooth ground: "
        "units are moved and pitched so that their faces meet; None: even",
        (-20.0, 20.0),
        default=None,
    )

    def _errors(self) -> Errors:
        if self.heights is not None and len(self.heights) != self.unit_count:
            yield f"heights must name every unit ({self.unit_count}), got {len(self.heights)}"
        if self.profile is None:
            return
        if len(self.profile) != self.columns + 1:
            yield f"profile must name every edge of columns ({self.columns + 1}), got {len(self.profile)}"
        if self.heights is not None:
            yield "heights must be None where a profile is given, got both"
        if self.tilt != "pitch":
            yield f"tilt must be 'pitch' where a profile is given, got {self.tilt!r}"
        steepest = float(self.slopes[np.abs(self.slopes).argmax()])
        if abs(steepest) > STEEPEST:
            yield (
                f"profile must not rise or fall by more than {STEEPEST:g} m a metre, got {steepest:g}, "
                "which the model's small gaps and tilts would not hold for; terrain.grade leans all of it"
            )

    @classmethod
    def kinematics(cls) -> Self:
        """50 units of 7 x 7 x 2 m (K-chapter, K-paper and F-paper).

        They roll on springs below their edges, as the F-paper's steady lateral force on shoe 10 shows; the
        papers' words leave both open (`docs/validation.md`).
        """
        return cls(**ph4100c.COARSE_TERRAIN)

    @classmethod
    def stress(cls, seams: Literal["margin", "fitted"] = "margin") -> Self:
        """247 units of 1 x 1 x 1 m (S-paper): one spring of k = E A / L = 20 MN/m per unit.

        Open in the paper and chosen here: the spring stands at the unit's centre and, being a column of oil
        sand as wide as the unit (E = 20 MPa), resists tilting with E I / L, without which a row could fold.
        Its place is open too: by the margins about the track, or fitted to the contact forces in loading.
        """
        terrain = cls(**ph4100c.FINE_TERRAIN)
        return terrain if seams == "margin" else terrain.with_({"origin[0]": ph4100c.FITTED_SEAMS_X})

    def with_step(self, x: float, height: float) -> Self:
        """Copy with all units whose centres lie beyond `x` (m) higher by `height` (m)."""
        return self._raised(np.where(self.centers[:, 0] > x, height, 0.0))

    def with_ramp(self, x0: float, x1: float, height: float) -> Self:
        """Copy that rises from `x0` to `x1` (m) by `height` (m), unit by unit, and stays up beyond.

        Each unit is raised by the ramp's height at its centre and stays level: a ramp of many small steps.

        Raises
        ------
        ValueError
            If `x1` is not beyond `x0`.
        """
        if not x1 > x0:
            raise ValueError(f"x1 must be greater than x0 = {x0}, got {x1}")
        return self._raised(height * np.clip((self.centers[:, 0] - x0) / (x1 - x0), 0.0, 1.0))

    def with_roughness(self, standard_deviation: float, seed: int) -> Self:
        """Copy with normally distributed random heights (m) of the units added; same seed, same heights.

        Raises
        ------
        ValueError
            If `standard_deviation` is negative or not finite.
        """
        if not 0.0 <= standard_deviation < math.inf:
            raise ValueError(f"standard_deviation must be finite and not negative, got {standard_deviation}")
        return self._raised(np.random.default_rng(seed).normal(0.0, standard_deviation, self.unit_count))

    def with_profile(self, height: Callable[[np.ndarray], ArrayLike]) -> Self:
        """Copy with a smooth ground whose height (m) is a function of x (m, array), straight along each unit.

        Its units pitch.

        Raises
        ------
        ValueError
            If it is too steep, or the units already have heights.
        """
        heights = np.broadcast_to(np.asarray(height(self.edges), dtype=float), self.edges.shape)
        return self.with_(profile=tuple(heights.tolist()), tilt="pitch")

    def _raised(self, change: np.ndarray) -> Self:
        return self.with_(heights=tuple((self.top_heights + change).tolist()))

    @property
    def top_heights(self) -> np.ndarray:
        """Height of the middle of every unit's top face, with the springs free: array (units,), m."""
        if self.profile is not None:
            edges = np.array(self.profile)
            return np.repeat(0.5 * (edges[:-1] + edges[1:]), self.rows)
        return np.zeros(self.unit_count) if self.heights is None else np.array(self.heights)

    @property
    def edges(self) -> np.ndarray:
        """Places of the edges of the columns: array (columns + 1,), m, global x."""
        return self.origin[0] + self.unit_length * np.arange(self.columns + 1)

    @property
    def slopes(self) -> np.ndarray:
        """Rise over run along x of every unit's top face, with the springs free: array (units,)."""
        if self.profile is None:
            return np.zeros(self.unit_count)
        return np.repeat(np.diff(self.profile) / self.unit_length, self.rows)

    @property
    def tilts(self) -> np.ndarray:
        """Tilt of every unit with the springs free: array (units,), rad; positive lowers the front."""
        return -np.arctan(self.slopes)

    def profile_along(self, x: np.ndarray) -> np.ndarray:
        """Height of the profile at places x (m): array of their shape, m; zero without a profile."""
        return np.zeros_like(x) if self.profile is None else np.interp(x, self.edges, self.profile)

    @property
    def unit_count(self) -> int:
        """Number of units."""
        return self.columns * self.rows

    @property
    def units(self) -> np.ndarray:
        """Unit numbers 1..n."""
        return np.arange(1, self.unit_count + 1)

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and greatest x, least and greatest y of the whole terrain, m, global."""
        x, y = self.origin
        return (x, x + self.columns * self.unit_length), (y, y + self.rows * self.unit_width)

    @property
    def middles(self) -> np.ndarray:
        """Middles of the units' top faces with the springs free: array (units, 2), m, global x and y."""
        column, row = np.divmod(np.arange(self.unit_count), self.rows)
        sides = np.array([self.unit_length, self.unit_width])
        return np.array(self.origin) + (np.column_stack((column, row)) + 0.5) * sides

    @property
    def centers(self) -> np.ndarray:
        """Unit centres with the springs free: array (units, 3), m, global."""
        places = np.column_stack((self.middles, np.full(self.unit_count, -0.5 * self.unit_height)))
        if self.profile is not None:
            places[:, 0] -= 0.5 * self.unit_height * np.sin(self.tilts)
            places[:, 2] = self.top_heights - 0.5 * self.unit_height * np.cos(self.tilts)
        return places

    @property
    def tilt_axis(self) -> int:
        """Axis that units tilt about: 0 for roll about x, 1 for pitch about y."""
        return 0 if self.tilt == "roll" else 1

    @property
    def tilt_length(self) -> float:
        """Side of a unit across its tilt axis, m."""
        return self.unit_length if self.tilt == "pitch" else self.unit_width

    @property
    def unit_mass(self) -> float:
        """Mass of a unit, kg."""
        return self.density * self.unit_length * self.unit_width * self.unit_height

    @property
    def unit_inertia(self) -> np.ndarray:
        """Principal moments of inertia of a unit (a solid box): array (3,), kg m2."""
        x, y, z = self.unit_length, self.unit_width, self.unit_height
        return self.unit_mass / 12.0 * np.array([y**2 + z**2, x**2 + z**2, x**2 + y**2])

    @property
    def heave_stiffness(self) -> float:
        """Stiffness of a unit's support against heave, N/m."""
        return self.springs_per_unit * self.spring_stiffness

    @property
    def column_tilt_stiffness(self) -> float:
        """Resistance of one spring itself against tilting, N m: k L**2 / 12, or none."""
        return self.spring_stiffness * self.tilt_length**2 / 12.0 if self.column_tilt else 0.0

    @property
    def tilt_stiffness(self) -> float:
        """Stiffness of a unit's support against its tilt, N m."""
        offset = self.spring_offset if self.springs_per_unit == 2 else 0.0
        return self.springs_per_unit * (self.spring_stiffness * offset**2 + self.column_tilt_stiffness)

    @property
    def damping_time(self) -> float:
        """Damping over stiffness of the support, s, the same for heave and tilt."""
        return self.spring_damping / self.spring_stiffness
