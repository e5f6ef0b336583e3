"""Terrain: a grid of units on spring-dampers, or cells with permanent sinkage and a soil law."""

import json
import math
from functools import cache
from importlib.metadata import entry_points
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, SerializeAsAny, ValidationError, ValidationInfo

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import Slope, Two
from exudyn_crawler.case.parameters.heights import Heights
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.error_lines import error_lines
from exudyn_crawler.settings.parameters import Errors, File, Parameters, option, quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CREEP = 0.05  # m, greatest motion of a shoe on the ground before it rests
STEEPEST = 0.2
"""Greatest slope along units; it opens gaps of slope^2 / 2 of a unit's length, 2 %, between their faces."""
ACROSS = 1e-6  # m, greatest difference of heights across y


class Ground(Parameters):
    """Parameters of every ground: heights before any shoe came, in axes that lean with it, unlike gravity."""

    grade: Slope = quantity("1", "rise over horizontal run along x; + is uphill", (-0.3, 0.3), default=0.0)
    side_slope: Slope = quantity(
        "1", "rise over horizontal run along y; + rises to the left", (-0.3, 0.3), default=0.0
    )
    relief: Heights = option("heights of the undisturbed ground", Heights())

    @property
    def is_even(self) -> bool:
        """True if the ground has no relief."""
        return self.relief == Heights()

    @property
    def down(self) -> np.ndarray:
        """Direction of gravity: unit vector (3,) in the ground's axes.

        The ground rises by s along an axis over a horizontal run of 1. The axis then points up with the sine
        s / sqrt(1 + s**2).
        """
        x, y = (slope / math.hypot(1.0, slope) for slope in (self.grade, self.side_slope))
        # adding zero turns negative zeros into positive ones
        return np.array([-x, -y, -math.sqrt(1.0 - x**2 - y**2)]) + 0.0

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and greatest x, least and greatest y, m."""
        raise NotImplementedError

    def reach_errors(self, corners: np.ndarray, time: float) -> Errors:
        """Yield an error for each axis along which a track's corners (4, 2), m, leave the ground."""
        for name, places, (least, greatest) in zip("xy", corners.T, self.bounds, strict=True):
            low = places.min()
            high = places.max()
            if low < least or high > greatest:
                track = f"at t = {time:.3g} s the track reaches {name} = {low:.3f}..{high:.3f} m"
                reach = f"the terrain {least:g}..{greatest:g} m"
                yield f"terrain must carry the track over the whole drive: {track}, {reach}"

    def map_errors(self, corners: np.ndarray) -> Errors:
        """Yield an error if measured heights do not cover a track's corners over time (times, 4, 2), m."""
        yield from ()


SAME_PLACE = 1e-9  # m


class Terrain(Ground):
    """Grid of rigid units, each with heave and one tilt on spring-dampers normal to the ground.

    Units count along y first, from 1. With free springs, their top faces are at z = 0 or follow a relief
    along x. Each face is straight; units are moved and pitched so that their faces meet. All places and
    directions are in the ground's own axes: on a slope gravity leans, and z stays normal to the ground.
    """

    model: Literal["units"] = option("terrain model: units, blocks on springs as in the papers", "units")
    origin: Two = quantity("m", "global x and y of the corner of the top face at unit 1", default=(0.0, 0.0))
    columns: int = quantity("1", "number of units along x", ge=1, le=10_000)
    rows: int = quantity("1", "number of units along y", ge=1, le=10_000)
    unit_length: float = quantity("m", "side of a unit in x", (0.1, 50.0), ge=1e-2, le=1e4)
    unit_width: float = quantity("m", "side of a unit in y", (0.1, 50.0), ge=1e-2, le=1e4)
    unit_height: float = quantity("m", "height of a unit", (0.1, 50.0), ge=1e-3, le=1e4)
    density: float = quantity("kg/m3", "density of the units", (500.0, 4000.0), ge=1e-3, le=1e6)
    springs_per_unit: Literal[1, 2] = quantity("1", "number of vertical spring-dampers below each unit")
    spring_stiffness: float = quantity("N/m", "stiffness of each spring", (1e5, 1e11), ge=1.0, le=1e15)
    spring_damping: float = quantity("N s/m", "damping of each spring-damper", (0.0, 1e7), ge=0, le=1e15)
    spring_offset: float = quantity(
        "m", "distance of each of two springs from the unit's centre", ge=0, le=1e4
    )
    column_tilt: bool = quantity("", "tilt stiffness of the soil column below each spring")
    tilt: Literal["pitch", "roll"] = quantity("", "tilt of the units: pitch (about y) or roll (about x)")

    def _errors(self) -> Errors:
        half = 0.5 * self.tilt_length
        if self.springs_per_unit == 2 and self.spring_offset > half + SAME_PLACE:
            within = f"half of a unit's side of {self.tilt_length:g} m across its tilt axis"
            yield f"spring_offset must be at most {half:g} m, {within}, got {self.spring_offset:g}"
        if self.is_even:
            return
        tops = self._tops
        if not np.isfinite(tops).all():
            yield f"relief must have heights over the whole terrain: {self._gap}"
            return
        if np.ptp(tops, axis=1).max() > ACROSS:
            got = f"heights that differ by {np.ptp(tops, axis=1).max():.3g} m; model 'cells' takes any"
            yield f"relief must be the same across y where units lie in rows, got {got}"
        if self.tilt != "pitch" and np.ptp(tops) > ACROSS:
            yield f"tilt must be 'pitch' on a relief, along which units pitch, got {self.tilt!r}"
        steepest = float(self.slopes[np.abs(self.slopes).argmax()])
        if abs(steepest) > STEEPEST:
            got = f"{steepest:.3g}; terrain.grade leans all of it, model 'cells' takes steeper reliefs"
            yield f"relief must not rise or fall by more than {STEEPEST:g} m a metre along units, got {got}"

    @classmethod
    def kinematics(cls) -> Self:
        """Return 50 units of 7 x 7 x 2 m (K-chapter, K-paper and F-paper).

        They roll on springs below their edges, as deduced from the F-paper's steady lateral force on shoe 10.
        The papers state neither the tilt nor the places of the springs (`docs/validation.md`).
        """
        return cls(**ph4100c.COARSE_TERRAIN)

    @classmethod
    def stress(cls, seams: Literal["margin", "fitted"] = "margin") -> Self:
        """Return 247 units of 1 x 1 x 1 m (S-paper): one spring of k = E A / L = 20 MN/m per unit.

        The paper does not give the following, which is chosen here. The spring is at the unit's centre; it is
        a column of oil sand as wide as the unit (E = 20 MPa). It resists tilting with E I / L, without which
        a row could fold. `seams` sets the place of the terrain: by the margins about the track, or fitted to
        the contact forces in loading.
        """
        terrain = cls(**ph4100c.FINE_TERRAIN)
        return terrain if seams == "margin" else terrain.with_({"origin[0]": ph4100c.FITTED_SEAMS_X})

    @property
    def _gap(self) -> str:
        """Reason why measured heights do not cover the terrain, and a remedy."""
        corners = np.array([[x, y] for x, y in product(*self.bounds)])[[0, 2, 3, 1]]
        measured = self.relief.measured
        return "" if measured is None else measured.misfit(corners[None], self.bounds)

    @property
    def _tops(self) -> np.ndarray:
        """Heights of the relief at edges of columns, in the middle of every row: (columns + 1, rows), m."""
        y = self.origin[1] + self.unit_width * (np.arange(self.rows) + 0.5)
        return self.relief.sample(*np.meshgrid(self.edges, y, indexing="ij"))[..., 0]

    @property
    def top_heights(self) -> np.ndarray:
        """Height of the middle of every unit's top face, with the springs free: array (units,), m."""
        return np.ravel(0.5 * (self._tops[:-1] + self._tops[1:]))

    @property
    def edges(self) -> np.ndarray:
        """Positions of the columns' edges: array (columns + 1,), m, global x."""
        return self.origin[0] + self.unit_length * np.arange(self.columns + 1)

    @property
    def slopes(self) -> np.ndarray:
        """Rise over run along x of every unit's top face, with the springs free: array (units,)."""
        return np.ravel(np.diff(self._tops, axis=0) / self.unit_length)

    @property
    def tilts(self) -> np.ndarray:
        """Tilt of every unit with the springs free: array (units,), rad; positive lowers the front."""
        return -np.arctan(self.slopes)

    def surface(self, x: np.ndarray) -> np.ndarray:
        """Return the height of the units' faces at places x (m) with free springs: array like `x`, m."""
        return np.interp(x, self.edges, self._tops[:, 0])

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
        half = 0.5 * self.unit_height
        (x, y) = self.middles.T
        x = x - half * np.sin(self.tilts)
        return np.column_stack((x, y, self.top_heights - half * np.cos(self.tilts)))

    @property
    def even_centers(self) -> np.ndarray:
        """Unit centres on even ground: array (units, 3), m, global; a relief moves only the faces."""
        return np.column_stack((self.middles, np.full(self.unit_count, -0.5 * self.unit_height)))

    @property
    def tilt_axis(self) -> int:
        """Axis of the units' tilt: 0 for roll about x, 1 for pitch about y."""
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
        """Tilting stiffness of a single spring, N m/rad: k L**2 / 12 of a column, else zero."""
        return self.spring_stiffness * self.tilt_length**2 / 12.0 if self.column_tilt else 0.0

    @property
    def tilt_stiffness(self) -> float:
        """Stiffness of a unit's support against its tilt, N m/rad."""
        offset = self.spring_offset if self.springs_per_unit == 2 else 0.0
        return self.springs_per_unit * (self.spring_stiffness * offset**2 + self.column_tilt_stiffness)

    @property
    def damping_time(self) -> float:
        """Damping over stiffness of the support, s, the same for heave and tilt."""
        return self.spring_damping / self.spring_stiffness


SOIL_LAWS = "exudyn_crawler.soil_laws"
"""Group of entry points: functions that return classes of soil laws.

Laws with compiled code are in rooms above this one, or in other packages.
"""


class SoilLaw(Parameters):
    """Parameters of a law of the cells: what each of them has."""

    model: str = option("name of the law, that of its file in ground/cells/laws")

    @staticmethod
    @cache
    def plugged_in() -> tuple[type["SoilLaw"], ...]:
        """Return the classes of all installed laws; the search takes 30 ms, so it runs once."""
        return tuple(law for point in entry_points(group=SOIL_LAWS) for law in point.load()())

    def sinkage(self, pressure: float, width: float) -> float:
        """Return the sinkage (m) of a plate of a `width` (m) under its first loading by a pressure (Pa)."""
        raise NotImplementedError

    def draw(self, pressure: "Axes", shear: "Axes") -> None:
        """Draw pressure over sinkage and shear over slip."""
        raise NotImplementedError


def law_class(model: object) -> type[SoilLaw]:
    """Return the parameter class of the soil law with a name.

    Raises
    ------
    ParameterError
        If there is no such law.
    """
    laws = {fields.tag_of(law): law for law in SoilLaw.plugged_in()}
    known = " or ".join(f"{name!r}" for name in sorted(laws))
    if model is None:
        raise ParameterError(f"model must be given: {known}")
    if not isinstance(model, str) or model not in laws:
        raise ParameterError(f"model: must be {known}, got {fields.shown(model)}")
    return laws[model]


def _law(values: Any, info: ValidationInfo) -> Any:
    """Return the law of a table by its model; any other value unchanged."""
    if not isinstance(values, dict):
        return values
    kind = law_class(values.get("model"))
    if info.mode == "python":
        return kind(**values)
    try:
        # a file may not have a text, true or false for a number
        return kind.model_validate_json(json.dumps(values), strict=True, context=info.context)
    except ValidationError as error:
        raise ParameterError("\n".join(error_lines(error, kind))) from None


class CellContact(Parameters):
    """Shoes on cells: pressure and shear of every cell by a law of the soil."""

    model: Literal["cells"] = option("contact model: cells, ground with memory", "cells")
    law: Annotated[SerializeAsAny[SoilLaw], BeforeValidator(_law)] = option("law of the soil")


class CellTerrain(Ground):
    """Field of square cells, each with a height, the sinkage that it has had and the shear that it bears."""

    model: Literal["cells"] = option("terrain model: cells, ground with memory", "cells")
    origin: Two = quantity("m", "global x and y of the field's first corner")
    length: float = quantity("m", "length of the field along x", gt=0, le=1e5)
    width: float = quantity("m", "width of the field along y", gt=0, le=1e5)
    cell: float = quantity("m", "side of a cell", plausible=(0.02, 0.2), ge=1e-3, le=10, default=0.1)
    ruts: File | None = quantity(
        "",
        "history (.nc) of an earlier run on this ground, with its ruts; none: undisturbed ground",
        default=None,
    )

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and greatest x, least and greatest y, m, global."""
        x, y = self.origin
        return (x, x + self.length), (y, y + self.width)

    @property
    def units(self) -> np.ndarray:
        """Unit numbers: none."""
        return np.zeros(0, dtype=int)

    def map_errors(self, corners: np.ndarray) -> Errors:
        """Yield an error if measured heights do not cover a track's corners over time (times, 4, 2), m."""
        measured = self.relief.measured
        if measured is None:
            return
        # a shoe reaches cells whose middles, which have the heights, are beyond its edges; it also creeps
        sides = corners - corners.mean(axis=1, keepdims=True)
        corners = corners + np.sign(sides) * (0.5 * self.cell + CREEP)
        if misfit := measured.misfit(corners, self.bounds):
            yield f"terrain.relief.measured: {misfit}"

    def surface(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the height of the ground at places (m): array of their shape, m."""
        return np.asarray(self.relief.sample(x, y)[..., 0])

    def earlier(self, law: SoilLaw) -> dict[str, np.ndarray]:
        """Return the arrays of the cells that an earlier run has compressed, by name.

        Raises `ValueError` if that run has no cells, or cells of another ground.
        """
        if self.ruts is None:
            return {}
        import xarray

        from fem.files.hdf5 import check_objects

        names = ("cell_column", "cell_row", "cell_sinkage", "cell_pressure")
        try:
            check_objects(self.ruts)
            with xarray.open_dataset(self.ruts, engine="h5netcdf") as stored:
                case = json.loads(stored.attrs["case"])
                cells = {name: stored[name].values for name in names}
        # a damaged file makes the readers raise errors of many classes
        except Exception as error:
            reason = " ".join(str(error).split())
            raise ValueError(f"terrain.ruts: {self.ruts} holds no ground of cells: {reason}") from error
        ground = self.model_dump(mode="json") | {"law": law.model_dump(mode="json")}
        its = case["terrain"] | {"law": case["contact"]["law"]}
        if others := [name for name in ("cell", "relief", "law") if its[name] != ground[name]]:
            raise ValueError(
                f"terrain.ruts: {self.ruts} is the history of a ground with another {' and '.join(others)}"
            )
        return cells
