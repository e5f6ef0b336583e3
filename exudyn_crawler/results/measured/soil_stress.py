"""Normal pressure at sensors in the ground during the passage of a track, from the shoes' forces in a run.

At the surface it is the pressure below the shoe over the sensor. Below the surface it is that of an elastic
half-space by Boussinesq with Froehlich's concentration factor. Forces along the ground are left out.
"""

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.signal import find_peaks

from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.measured.series import distance_of

CONCENTRATION = 4.0
"""Froehlich's factor: 3 of an elastic body; by Soehne (Agricultural Engineering 39 (1958), remembered) 4 of
hard, 5 of firm and 6 of soft soil."""
LEAST_DEPTH = 0.05  # least depth of a sensor below the surface, m; a smaller one needs too many panels
PANEL_POINTS = 4  # Gauss points along a side of a panel; the side is at most the sensor's depth
BESIDE_MIDDLE = 0.49  # greatest offset of a centre of pressure, fraction of the underside's side
LOADED = 0.1  # pressure of a sensor below a track, least fraction of the sensor's greatest
RIPPLE = 0.2  # least prominence of a peak, fraction of the greatest pressure; rocking shoes make less


@dataclass(frozen=True)
class Sensor:
    """Place of a sensor: global x and y (m), and depth (m) below the undersides of the shoes."""

    x: float
    y: float
    depth: float = 0.0

    @property
    def name(self) -> str:
        """Name of the sensor's column."""
        return f"pressure x {self.x:g} y {self.y:g} depth {self.depth:g} in Pa"


def read_sensor(text: str) -> Sensor:
    """Read a sensor from a text such as ``12,0,0.5``; ValueError if it is not two or three numbers."""
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (2, 3):
        raise ValueError(f"sensor must be x, y and depth in m with commas between them, got {text!r}")
    return Sensor(*numbers)


def vertical_stress(
    force: np.ndarray | float, away: np.ndarray | float, depth: float, concentration: float
) -> np.ndarray:
    """Return the vertical normal stress (Pa) below a vertical point force (N) at a horizontal distance (m).

    ``nu F z**nu / (2 pi R**(nu + 2))`` with ``R**2 = z**2 + r**2``: Boussinesq (1885) for nu = 3, Froehlich,
    Druckverteilung im Baugrunde (1934), for other factors.
    """
    lead = concentration / (2.0 * math.pi * depth**2)
    return np.asarray(force * lead * (1.0 + (away / depth) ** 2) ** (-0.5 * concentration - 1.0))


def line_density(place: np.ndarray, size: float, offset: np.ndarray) -> np.ndarray:
    """Return the force per length over the force, 1/m, at places on a line with an offset centre of pressure.

    Places and offset count from the middle, m. The distribution is linear over the line for an offset up to a
    sixth of its `size` (m), else a triangle at its end; it is zero outside of the line. Arrays broadcast.
    """
    offset = np.clip(offset, -BESIDE_MIDDLE * size, BESIDE_MIDDLE * size)
    whole = (1.0 + 12.0 * offset * place / size**2) / size
    loaded = 3.0 * (0.5 * size - np.abs(offset))
    from_edge = 0.5 * size - np.sign(offset) * place
    ended = 2.0 / loaded * np.maximum(1.0 - from_edge / loaded, 0.0)
    inside = np.abs(place) <= 0.5 * size
    return np.where(inside, np.where(np.abs(offset) <= size / 6.0, whole, ended), 0.0)


@dataclass(frozen=True)
class Pressed:
    """Loads of shoes on the ground: undersides as rectangles, with forces and centres of pressure."""

    force: np.ndarray  # (times, shoes): downward, N
    middle: np.ndarray  # (times, shoes, 2): middle of the underside, global x and y, m
    along: np.ndarray  # (times, shoes, 2): unit vector of the shoe's x in the plane
    offset: np.ndarray  # (times, shoes, 2): centre of pressure from the middle, along and across the shoe, m
    size: tuple[float, float]  # m, length and width of an underside

    def local(self, sensor: Sensor) -> np.ndarray:
        """Return the sensor's place from the undersides' middles, along and across: (times, shoes, 2), m."""
        return _turned(np.array([sensor.x, sensor.y]) - self.middle, self.along)


def _turned(vectors: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return the components of vectors (..., 2) along and across unit vectors (..., 2)."""
    across = along[..., ::-1] * np.array([-1.0, 1.0])
    return np.stack(((vectors * along).sum(axis=-1), (vectors * across).sum(axis=-1)), axis=-1)


def pressed(history: History) -> Pressed:
    """Return the loads of a run's shoes on the ground at the stored times."""
    data = history.dataset
    shoe = history.case.shoe
    normal = data.normal_force.transpose("time", "contact", "axis").values[..., 2].astype(float)
    point = data.point.transpose("time", "contact", "axis").values[..., :2].astype(float)
    numbers = history.case.track.shoes
    of_shoe = (data.contact_shoe.values[:, None] == numbers).astype(float)
    force = normal @ of_shoe
    moment = np.einsum("tci,tc,cs->tsi", point, normal, of_shoe)
    center = moment / np.where(force > 0.0, force, np.inf)[..., None]
    axes = history.quantity("axes").transpose("time", "shoe", "axis", "body_axis").values
    position = data.position.transpose("time", "shoe", "axis").values
    middle = position + axes @ np.array([*shoe.underside_center, -shoe.com_height])
    along = axes[..., :2, 0] / np.linalg.norm(axes[..., :2, 0], axis=-1, keepdims=True)
    offset = _turned(center - middle[..., :2], along) * (force > 0.0)[..., None]
    return Pressed(np.maximum(force, 0.0), middle[..., :2], along, offset, (shoe.length, shoe.width))


def sensor_pressure(load: Pressed, sensor: Sensor, concentration: float = CONCENTRATION) -> np.ndarray:
    """Return the normal pressure at a sensor: array (times,), Pa.

    Raises
    ------
    ValueError
        If the sensor is above the surface, or below it by less than `LEAST_DEPTH`, or the concentration
        factor is not above zero.
    """
    if sensor.depth != 0.0 and sensor.depth < LEAST_DEPTH:
        raise ValueError(f"depth must be 0 or at least {LEAST_DEPTH:g} m, got {sensor.depth:g} m")
    if concentration <= 0.0:
        raise ValueError(f"concentration must be greater than zero, got {concentration:g}")
    local = load.local(sensor)
    if sensor.depth == 0.0:
        densities = (
            line_density(local[..., k], load.size[k], load.offset[..., k]) for k in range(len(load.size))
        )
        return np.asarray((load.force * math.prod(densities)).sum(axis=1))
    points, weights = zip(*(_panels(size, sensor.depth) for size in load.size), strict=True)
    pressure = np.zeros(len(load.force))
    for time, force in enumerate(load.force):
        for number in np.flatnonzero(force > 0.0):
            shares = [
                weights[k] * line_density(points[k], load.size[k], load.offset[time, number, k])
                for k in range(len(points))
            ]
            gap = [local[time, number, k] - points[k] for k in range(len(points))]
            away = np.hypot(gap[0][:, None], gap[1])
            below = vertical_stress(force[number], away, sensor.depth, concentration)
            pressure[time] += shares[0] @ below @ shares[1]
    return pressure


def _panels(size: float, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the Gauss points of panels from the middle of a line, m, and their weights, m."""
    count = math.ceil(size / depth)
    place, weight = np.polynomial.legendre.leggauss(PANEL_POINTS)
    half = 0.5 * size / count
    middles = half * (2.0 * np.arange(count) + 1.0) - 0.5 * size
    return (middles[:, None] + half * place).ravel(), np.tile(half * weight, count)


def stress_table(
    history: History, sensors: list[Sensor], concentration: float = CONCENTRATION
) -> pd.DataFrame:
    """Return a table over the stored times: time, distance travelled, and pressure at each sensor, SI."""
    load = pressed(history)
    named = {sensor.name: sensor_pressure(load, sensor, concentration) for sensor in sensors}
    return pd.DataFrame({"time in s": history.time.values, "distance in m": distance_of(history), **named})


def passage_table(table: pd.DataFrame) -> pd.DataFrame:
    """Return the stresses at the sensors of a `stress_table` during the track's passage, a row each.

    Columns are the mean during the passage, the greatest pressure, number and mean of the peaks, and both
    over the mean. Rollers make the peaks; their mean is Wong's mean maximum pressure. Values are NaN without
    a passage.
    """
    rows = []
    for name in [*table.columns][2:]:
        pressure = table[name].to_numpy()
        over = np.flatnonzero(pressure > LOADED * pressure.max())
        row = {"sensor": name.removeprefix("pressure ").removesuffix(" in Pa")}
        if len(over):
            passage = pressure[over[0] : over[-1] + 1]
            mean = float(passage.mean())
            padded = np.concatenate(([0.0], passage, [0.0]))
            peaks = padded[find_peaks(padded, prominence=RIPPLE * passage.max())[0]]
            row |= {
                "mean in Pa": mean,
                "greatest in Pa": float(passage.max()),
                "peaks": len(peaks),
                "mean of peaks in Pa": float(peaks.mean()),
                "greatest over mean": float(passage.max()) / mean,
                "peaks over mean": float(peaks.mean()) / mean,
            }
        rows.append(row)
    return pd.DataFrame(rows)
