"""Parameters of the soil law `BekkerSoil` from tests: plate sinkage, its unloading, and shear.

Pressure over sinkage follows Wong's procedure, with all plates together. It minimizes the sum of ``p**2 (ln p
- ln p_law)**2``; the weights p**2 give every stress the same error (Wong, J. of Terramechanics 17 (1980)
13-41; Theory of Ground Vehicles, chapter 2). For shear Wong weights ``ln(1 - tau / tau_max)`` with ``(1 - tau
/ tau_max)**2``. To first order this minimizes the sum of the squared stresses; the fit here uses the stresses
themselves, together with the strength over the pressure.
"""

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.shear import COHESION_PRESSURE
from exudyn_crawler.results.measured.least_squares import Parameter, PartFit, Problem, fit, part
from exudyn_crawler.results.measured.soil_tests import (
    OFF,
    PULLS,
    Loop,
    PlateTests,
    ShearTests,
    read_plates,
    read_shear,
)
from exudyn_crawler.settings import fields

SAME = 1.2
"""Ratio of widths, pressures or sinkages below which they count as the same. Chosen here."""
FACTOR = 3.0
"""Greatest factor between the value of a determined positive parameter and an end of its interval. Chosen
here."""
CLOSE = 0.99
"""Correlation above which two parameters are hard to distinguish. Chosen here."""

ONE_WIDTH = (
    "k_c and k_phi cannot be separated by plates of one width: k_c = 0, and k_phi holds for {:.4g} mm alone"
)
ONE_PRESSURE = "cohesion and friction cannot be separated by shear under one pressure: cohesion = 0 is taken"
ONE_DEPTH = "reload_stiffness and reload_growth cannot be separated by unloading from one sinkage: growth = 0"


@dataclass(frozen=True)
class SoilFit:
    """Law fitted to tests, with intervals and remarks."""

    law: BekkerSoil
    parts: tuple[PartFit, ...]
    taken: tuple[str, ...]  # parameters without tests, taken from the base
    remarks: tuple[str, ...]  # uncertainties that the tests leave
    plates: PlateTests
    shear: ShearTests | None


def named_soil(name: str) -> BekkerSoil:
    """Return the soil of a name, such as "lete_sand"; ValueError for an unknown name."""
    soils = fields.named_values(BekkerSoil)
    if name not in soils:
        raise ValueError(f"base must be one of {', '.join(soils)}, got {name!r}")
    return BekkerSoil(**dict(soils[name]()))


def _spread(values: Sequence[float] | np.ndarray) -> float:
    """Return the ratio of the greatest to the least of positive values; 1 without values."""
    return float(np.max(values) / max(np.min(values), 1e-300)) if len(values) else 1.0


def _require(part_fit: PartFit, name: str, why: str) -> None:
    """Raise ValueError if a positive parameter's interval is wider than `FACTOR` to a side."""
    value = part_fit.number(name)
    low, high = part_fit.span(name)
    if low <= 0.0 or high > FACTOR * value or value > FACTOR * low:
        raise ValueError(f"{name} is not determined: {value:.4g}, 95 % from {low:.4g} to {high:.4g}; {why}")


def fit_plates(tests: PlateTests) -> tuple[PartFit, list[str]]:
    """Fit Bekker's modulus and exponent to points of first loading; return them with remarks.

    ``p = p_0 (1 + s (b_0 / b - 1)) (z / z_0)**n`` has nearly independent parameters: the pressure p_0 at a
    middle sinkage z_0 and width b_0, and the share s of k_c in it. ValueError if exponent or modulus is not
    determined, or k_phi would not be positive.
    """
    if len(tests.sinkage) < 4:
        raise ValueError(f"plates must have at least 4 points of first loading, got {len(tests.sinkage)}")
    z_0 = math.exp(np.average(np.log(tests.sinkage), weights=tests.pressure))
    b_0 = 1.0 / np.mean(1.0 / tests.width)
    several = _spread(tests.widths) > SAME
    remarks = [] if several else [ONE_WIDTH.format(1e3 * float(tests.width.mean()))]

    def residuals(theta: np.ndarray, data: PlateTests) -> np.ndarray:
        share = 1.0 + theta[2] * (b_0 / data.width - 1.0) if len(theta) == 3 else 1.0
        law = theta[0] + theta[1] * np.log(data.sinkage / z_0) + np.log(np.maximum(share, 1e-12))
        return data.pressure * (np.log(data.pressure) - law)

    def outputs(theta: np.ndarray) -> np.ndarray:
        logarithm = theta[0] - theta[1] * math.log(z_0)
        if len(theta) == 2:
            return np.array([logarithm, theta[1]])
        rest = max(1.0 - theta[2], 1e-12)
        return np.array([theta[2] * b_0 * math.exp(logarithm), logarithm + math.log(rest), theta[1]])

    def fitted(with_width: bool) -> PartFit:
        names = [Parameter("k_c")] * with_width + [Parameter("k_phi", True), Parameter("exponent")]
        start = np.array([math.log(np.interp(z_0, *_sorted(tests))), 1.0, *[0.0] * with_width])

        def rest(data: PlateTests) -> bool:
            return len(data.widths) == len(tests.widths)

        return fit(Problem(residuals, outputs, names), tests, start, rest)

    result = fitted(several)
    if several and result.number("k_c") < 0.0:
        low, high = result.span("k_c")
        remarks.append(
            f"k_c would be negative ({low:.4g} to {high:.4g}), wider plates carry more: the law has k_c = 0 "
            "and lies between the plates; those about as wide as the shoe would fit it better"
        )
        result = fitted(False)
    elif several and result.span("k_c")[0] <= 0.0:
        remarks.append("k_c does not differ from zero within its interval")
    if result.number("k_phi") < 1e-6 * max(1.0, result.value[0]):
        raise ValueError("k_phi must be greater than zero, the plates give none: k_c alone carries them")
    remarks += _far_points(result, tests)
    wider = "a wider range of sinkages would determine it"
    _require(result, "exponent", wider)
    _require(result, "k_phi", "more sizes of plates, or a wider range of sinkages, would determine it")
    return result, remarks


def _far_points(result: PartFit, tests: PlateTests) -> Iterator[str]:
    """Yield a remark on the point farthest from the law if it is off by a factor of more than `OFF`."""
    k_c = result.number("k_c") if "k_c" in result.names else 0.0
    law = (k_c / tests.width + result.number("k_phi")) * tests.sinkage ** result.number("exponent")
    # points of first contact have almost no weight, and are often far off
    matters = tests.pressure > PULLS * tests.pressure.max()
    off = np.where(matters, np.log(tests.pressure / np.maximum(law, 1e-300)), 0.0)
    row = int(np.abs(off).argmax())
    if abs(off[row]) > math.log(OFF):
        yield (
            f"{1e-3 * tests.pressure[row]:.4g} kPa at {1e3 * tests.sinkage[row]:.4g} mm of test "
            f"{str(tests.test[row])!r} is {math.exp(off[row]):.3g} times the law's pressure there; is its "
            "decimal point right?"
        )


def _sorted(tests: PlateTests) -> tuple[np.ndarray, np.ndarray]:
    """Return the sinkages in rising order, and their pressures."""
    order = np.argsort(tests.sinkage)
    return tests.sinkage[order], tests.pressure[order]


def fit_unloading(loops: Sequence[Loop]) -> tuple[PartFit, list[str]]:
    """Fit Wong's modulus of unloading ``k_0 + A_u z_u`` to loops, by linear least squares of their pressures.

    Each loop has its own pressure at its begin. A parameter that would be negative is zero in the law.
    """
    depths = np.concatenate([np.full(len(loop.sinkage), loop.deepest) for loop in loops])
    risen = depths - np.concatenate([loop.sinkage for loop in loops])
    pressure = np.concatenate([loop.pressure for loop in loops])
    which = np.repeat(np.arange(len(loops)), [len(loop.sinkage) for loop in loops])
    begins = (which[:, None] == np.arange(len(loops))).astype(float)
    slopes = {"reload_stiffness": -risen, "reload_growth": -depths * risen}
    remarks = []
    if _spread([loop.deepest for loop in loops]) <= SAME:
        remarks.append(ONE_DEPTH)
        del slopes["reload_growth"]

    def solved(names: Sequence[str]) -> PartFit:
        matrix = np.column_stack([begins, *(slopes[name] for name in names)])
        freedom = len(pressure) - matrix.shape[1]
        if freedom < 1:
            raise ValueError(
                f"unloading must have at least {matrix.shape[1] + 1} points, got {len(pressure)}"
            )
        values, *_ = np.linalg.lstsq(matrix, pressure, rcond=None)
        rest = pressure - matrix @ values
        covariance = rest @ rest / freedom * np.linalg.pinv(matrix.T @ matrix)
        scatter = float(np.sqrt(np.mean(rest**2)))
        begin = len(loops)
        parameters = [Parameter(name) for name in names]
        return part(parameters, values[begin:], covariance[begin:, begin:], freedom, scatter, len(pressure))

    result = solved([*slopes])
    for name in [name for name in slopes if result.number(name) < 0.0][:1]:
        low, high = result.span(name)
        remarks.append(f"{name} would be negative ({low:.4g} to {high:.4g}): 0 is taken, as the law allows")
        result = solved([other for other in slopes if other != name]) if len(slopes) > 1 else result
        if result.value.min() < 0.0:
            raise ValueError("the pressure must fall while a plate is unloaded, but it rises")
    return result, remarks


def fit_shear(tests: ShearTests) -> tuple[PartFit, list[str]]:
    """Fit cohesion, friction and shear deformation to shear stress over displacement under pressures.

    ValueError if friction or deformation is not determined.
    """
    several = _spread(tests.pressures) > SAME
    remarks = [] if several else [ONE_PRESSURE]

    def residuals(theta: np.ndarray, data: ShearTests) -> np.ndarray:
        cohesion = theta[2] / (data.pressure + COHESION_PRESSURE) if len(theta) == 3 else 0.0
        strength = data.pressure * (theta[0] + cohesion)
        return data.stress + strength * np.expm1(-data.displacement / math.exp(theta[1]))

    def outputs(theta: np.ndarray) -> np.ndarray:
        angle = math.degrees(math.atan(theta[0]))
        return np.array([*theta[2:], angle, theta[1]])

    def fitted(with_cohesion: bool) -> PartFit:
        names = [Parameter("cohesion")] * with_cohesion
        names += [Parameter("friction_angle"), Parameter("shear_deformation", True)]
        friction = float(np.max(tests.stress / tests.pressure))
        start = np.array([friction, math.log(0.2 * tests.displacement.max()), *[0.0] * with_cohesion])

        def rest(data: ShearTests) -> bool:
            return _spread(data.pressures) > SAME or not several

        return fit(Problem(residuals, outputs, names), tests, start, rest)

    if tests.displacement.max() <= 0.0:
        raise ValueError("displacement must be greater than zero at some point")
    result = fitted(several)
    if several and result.number("cohesion") < 0.0:
        low, high = result.span("cohesion")
        remarks.append(f"cohesion would be negative ({low:.4g} to {high:.4g} Pa): 0 is taken")
        result = fitted(False)
    _require(result, "shear_deformation", "displacements far enough for the strength would determine it")
    _require(result, "friction_angle", "more pressures would determine it")
    return result, remarks


def fit_soil(plates: PlateTests, shear: ShearTests | None = None, base: BekkerSoil | None = None) -> SoilFit:
    """Return the soil law of tests; parameters without tests are those of a `base`.

    Raises
    ------
    ValueError
        If the tests do not determine a parameter, or neither tests nor a base give one.
    """
    first, loops = plates.split()
    parts = [fit_plates(first)]
    if loops:
        parts.append(fit_unloading(loops))
    if shear is not None:
        parts.append(fit_shear(shear))
    remarks = [remark for _, of_part in parts for remark in of_part]
    results = tuple(result for result, _ in parts)
    values = {name: result.number(name) for result in results for name in result.names}
    # parameters of a kind are measured together: one that tests cannot separate is zero
    kinds = [({"k_c", "k_phi"}, True), ({"reload_stiffness", "reload_growth"}, bool(loops))]
    kinds.append(({"cohesion", "friction_angle"}, shear is not None))
    for names, measured in kinds:
        values |= dict.fromkeys(names - values.keys(), 0.0) if measured else {}
    needed = [name for name, field in BekkerSoil.model_fields.items() if field.is_required()]
    lacking = tuple(name for name in needed if name not in values)
    if lacking and base is None:
        raise ValueError(
            f"the tests do not determine {', '.join(lacking)}: give them by --base, such as --base lete_sand"
        )
    law = BekkerSoil.model_validate(values) if base is None else base.with_(**values)
    for result in results:
        remarks += _close(result)
    if loops:
        remarks += _floored(law, loops, float(np.median(first.width)))
    return SoilFit(law, results, lacking, tuple(remarks), plates, shear)


def fit_files(plates: Path, shear: Path | None = None, base: BekkerSoil | None = None) -> SoilFit:
    """Return the soil law of tables of tests, see `fit_soil`; errors name the tables, too."""
    tests = read_plates(plates)
    sheared = None if shear is None else read_shear(shear)
    try:
        return fit_soil(tests, sheared, base)
    except ValueError as error:
        tables = " and ".join(str(path) for path in (plates, shear) if path is not None)
        raise ValueError(f"{tables}: {error}") from error


def _close(result: PartFit) -> list[str]:
    """Return remarks on parameters that are hard to distinguish."""
    rows, columns = np.nonzero(np.triu(np.abs(result.correlation) > CLOSE, k=1))
    return [
        f"{result.names[a]} and {result.names[b]} are correlated by {result.correlation[a, b]:.3f}: "
        "use both together, and replace none of them alone"
        for a, b in zip(rows, columns, strict=True)
    ]


def _floored(law: BekkerSoil, loops: Sequence[Loop], width: float) -> list[str]:
    """Return a remark if the law unloads stiffer than measured: ground must not release more than it took."""
    for loop in loops:
        wanted = law.reload_stiffness + law.reload_growth * loop.deepest
        pressure = (law.k_c / width + law.k_phi) * loop.deepest**law.exponent
        least = max(1.0, law.exponent) * pressure / loop.deepest
        if wanted < least:
            return [
                f"unloading from {1e3 * loop.deepest:.4g} mm is measured softer ({wanted:.4g} Pa/m) than the "
                f"law allows ({least:.4g} Pa/m)"
            ]
    return []


def warn(result: SoilFit) -> None:
    """Warn of the uncertainties that the tests leave."""
    for remark in result.remarks:
        warnings.warn(remark, stacklevel=2)
