"""Heights of fresh ground: a plane, ridges, ruts, ramps, waves, stones, roughness, measured heights.

The heights of all parts are added. Units follow them along x. Cells allow no walls: each part rises over a
flank of some cells, and gives its slopes.
"""

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from exudyn_crawler.case.parameters.base import Place
from exudyn_crawler.case.parameters.measured import MeasuredGrid
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.settings.parameters import Errors, Name, Parameters, option, quantity

FLANK = 2.0
"""Least length of a flank, cells, so that it lifts an approaching shoe over several time steps."""
WAVE = 4.0  # least length of a wave, cells
BANDS, DIRECTIONS = 64, 16  # numbers of frequency bands and directions of the waves of a rough ground


class Ridge(Parameters):
    """Straight ridge, or rut where the height is negative: a flat top and two flanks (cubic STEPs)."""

    model: Literal["ridge"] = "ridge"
    name: Name = "ridge"
    x: Place = quantity("m", "global x of the middle of the ridge's top", default=0.0)
    y: Place = quantity("m", "global y of the middle of the ridge's top", default=0.0)
    heading: float = quantity(
        "deg", "direction of the ridge, angle from x to y", ge=-360, le=360, default=90.0
    )
    height: float = quantity("m", "height above the surrounding ground; negative: a rut", ge=-100, le=100)
    width: float = quantity("m", "width of the top", ge=0, le=1e3)
    flank: float = quantity("m", "horizontal length of each flank", gt=0, le=1e3)
    length: float = quantity("m", "length of the top along the ridge", gt=0, le=1e6, default=1e6)

    def sample(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return height and slopes, see `Heights.sample`."""
        c, s = _direction(self.heading)
        x, y = x - self.x, y - self.y
        along, along_slope = _hump(x * c + y * s, self.length, self.flank)
        across, across_slope = _hump(y * c - x * s, self.width, self.flank)
        u, v = along_slope * across, along * across_slope
        return self.height * np.stack((along * across, u * c - v * s, u * s + v * c), axis=-1)


class Ramp(Parameters):
    """Straight ramp from one level to another, or a step where it is short."""

    model: Literal["ramp"] = "ramp"
    name: Name = "ramp"
    x: Place = quantity("m", "global x of a point of the ramp's foot")
    y: Place = quantity("m", "global y of this point", default=0.0)
    heading: float = quantity("deg", "uphill direction, angle from x to y", ge=-360, le=360, default=0.0)
    height: float = quantity("m", "height of the top above the foot; negative: downhill", ge=-100, le=100)
    flank: float = quantity("m", "horizontal length of the ramp", gt=0, le=1e4)

    def sample(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return height and slopes, see `Heights.sample`."""
        c, s = _direction(self.heading)
        share = ((x - self.x) * c + (y - self.y) * s) / self.flank
        slope = ((share > 0.0) & (share < 1.0)) / self.flank
        return self.height * np.stack((np.clip(share, 0.0, 1.0), slope * c, slope * s), axis=-1)


class Waves(Parameters):
    """Hills one after another: a cosine with its troughs on the ground about it."""

    model: Literal["waves"] = "waves"
    name: Name = "waves"
    x: Place = quantity("m", "global x of a point of a trough", default=0.0)
    y: Place = quantity("m", "global y of this point", default=0.0)
    heading: float = quantity(
        "deg", "direction across the crests, angle from x to y", ge=-360, le=360, default=0.0
    )
    height: float = quantity("m", "height of the crests above the troughs", ge=-100, le=100)
    length: float = quantity("m", "wavelength", gt=0, le=1e6)

    def sample(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return height and slopes, see `Heights.sample`."""
        c, s = _direction(self.heading)
        number = 2.0 * math.pi / self.length
        phase = number * ((x - self.x) * c + (y - self.y) * s)
        slope = number * np.sin(phase)
        return 0.5 * self.height * np.stack((1.0 - np.cos(phase), slope * c, slope * s), axis=-1)


class Stone(Parameters):
    """Round stone, or hole where the height is negative: a flat top and a flank (cubic STEP)."""

    model: Literal["stone"] = "stone"
    name: Name = "stone"
    x: Place = quantity("m", "global x of the stone's middle")
    y: Place = quantity("m", "global y of the stone's middle")
    height: float = quantity("m", "height above the surrounding ground", ge=-100, le=100)
    width: float = quantity("m", "diameter of the top", ge=0, le=1e3, default=0.0)
    flank: float = quantity("m", "horizontal length of the flank", gt=0, le=1e3)

    def sample(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return height and slopes, see `Heights.sample`."""
        x, y = x - self.x, y - self.y
        radius = np.hypot(x, y)
        height, slope = _hump(radius, self.width, self.flank)
        slope = np.divide(slope, radius, out=np.zeros_like(radius), where=radius > 0.0)
        return self.height * np.stack((height, slope * x, slope * y), axis=-1)


class Roughness(Parameters):
    """Random isotropic roughness: along a line the spectrum ``G (n / n0)**-w``, n0 = 0.1 cycles/m (ISO 8608).

    It is a sum of waves whose directions and phases come from a seed. The height at a place does not depend
    on the size of the map. No source gives G of mine floors; ISO 8608 has 16e-6 m3 for a good road (class A)
    and 256e-6 m3 for a bad one (class C).
    """

    spectrum: float = quantity(
        "m3", "power spectral density G of the heights at 0.1 cycles/m", plausible=(1e-6, 0.02), ge=0, le=1
    )
    exponent: float = quantity(
        "1", "waviness w, exponent of the spectrum", plausible=(1.5, 3.0), gt=1, le=5, default=2.0
    )
    longest: float = quantity("m", "longest wavelength", gt=0, le=1e4, default=20.0)
    shortest: float = quantity("m", "shortest wavelength", gt=0, le=1e4, default=0.4)
    seed: int = quantity("1", "seed of the random numbers", ge=0, le=2**32 - 1, default=0)

    def _errors(self) -> Errors:
        if self.shortest >= self.longest:
            yield f"shortest must be below longest = {self.longest}, got {self.shortest}"

    def sample(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return height and slopes, see `Heights.sample`."""
        random = np.random.default_rng(self.seed)
        w = self.exponent
        ends = np.geomspace(1.0 / self.longest, 1.0 / self.shortest, BANDS + 1)
        # two-dimensional spectrum c k**-(w + 1) that gives the spectrum along a line
        beta = math.gamma(0.5) * math.gamma(w / 2.0) / math.gamma((w + 1.0) / 2.0)
        c = self.spectrum * 0.1**w / (2.0 * beta)
        variance = 2.0 * math.pi * c * (ends[:-1] ** (1.0 - w) - ends[1:] ** (1.0 - w)) / (w - 1.0)
        out = np.zeros((*np.shape(x), 3))
        for low, high, square in zip(ends[:-1], ends[1:], variance, strict=True):
            number = 2.0 * math.pi * random.uniform(low, high, DIRECTIONS)
            angle = math.pi / DIRECTIONS * (np.arange(DIRECTIONS) + random.uniform(size=DIRECTIONS))
            kx = number * np.cos(angle)
            ky = number * np.sin(angle)
            phase = np.multiply.outer(x, kx) + np.multiply.outer(y, ky)
            phase += random.uniform(0.0, 2.0 * math.pi, DIRECTIONS)
            sine = -np.sin(phase)
            sums = [wave.sum(axis=-1) for wave in (np.cos(phase), sine * kx, sine * ky)]
            out += math.sqrt(2.0 * square / DIRECTIONS) * np.stack(sums, axis=-1)
        return out


Part = Annotated[Ridge | Ramp | Waves | Stone, Field(discriminator="model")]


class Heights(Parameters):
    """Heights of a ground: a plane, and what is on it."""

    level: Place = quantity("m", "height of the plane at the origin", default=0.0)
    slope_x: float = quantity("1", "rise of the plane along x over the distance", ge=-1, le=1, default=0.0)
    slope_y: float = quantity("1", "rise of the plane along y over the distance", ge=-1, le=1, default=0.0)
    parts: tuple[Part, ...] = option("ridges, ruts, ramps, waves and stones", ())
    roughness: Roughness | None = option("random roughness; none: smooth", None)
    measured: MeasuredGrid | None = option("measured heights from a file; none: no file", None)
    scale: float = quantity("1", "factor of all heights", ge=-1e3, le=1e3, default=1.0)

    def sample(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return height (m) and slopes along x and y at places (m): (..., 3); NaN beyond measured heights."""
        z = self.level + self.slope_x * x + self.slope_y * y
        out = np.stack((z, np.full_like(z, self.slope_x), np.full_like(z, self.slope_y)), axis=-1)
        for part in (*self.parts, self.roughness, self.measured):
            if part is not None:
                out += part.sample(x, y)
        return self.scale * out

    def check_cells(self, cell: float) -> None:
        """Raise `ParameterError`, with a line a part, for parts that are too fine for cells of a size (m)."""
        sizes = [
            (f"parts[{k}].length ({part.name})", part.length, WAVE)
            if isinstance(part, Waves)
            else (f"parts[{k}].flank ({part.name})", part.flank, FLANK)
            for k, part in enumerate(self.parts)
        ]
        if self.roughness is not None:
            sizes.append(("roughness.shortest", self.roughness.shortest, WAVE))
        lines = [
            f"{name}: must be at least {least:g} cells of {cell:g} m, got {size:g} m"
            for name, size, least in sizes
            if size < least * cell
        ]
        if lines:
            raise ParameterError("\n".join(lines))


def _direction(heading: float) -> tuple[float, float]:
    """Return the components x and y of the unit vector of a heading, degrees."""
    return math.cos(math.radians(heading)), math.sin(math.radians(heading))


def _hump(distance: np.ndarray, width: float, flank: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a hump over the distance from its middle, and its derivative.

    The hump is 1 up to half of the width, and falls to zero over the flank by a cubic STEP.
    """
    s = np.clip((np.abs(distance) - 0.5 * width) / flank, 0.0, 1.0)
    return 1.0 - s * s * (3.0 - 2.0 * s), -6.0 * s * (1.0 - s) / flank * np.sign(distance)
