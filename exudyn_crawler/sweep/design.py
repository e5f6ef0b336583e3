"""Designs: which values the runs of a sweep have."""

import itertools
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from exudyn_crawler.sweep.vary import Vary

Design = Literal["grid", "list", "latin_hypercube", "sobol", "saltelli"]
"""Names of the designs."""
SAMPLED = ("latin_hypercube", "sobol", "saltelli")
"""Those that draw points between bounds."""

Row = tuple[Any, ...]
"""Values of a run, one of every `Vary`."""


def design_rows(design: Design, varied: Sequence[Vary], runs: int | None, seed: int) -> list[Row]:
    """Values of all runs.

    Parameters
    ----------
    design : str
        "grid": every value with every other; "list": the first values of all, the second ones and so on;
        "latin_hypercube" and "sobol": points of `scipy.stats.qmc`; "saltelli": those by which Sobol indices
        are estimated best (Saltelli 2002, of SALib), `runs` points and as many again for every `Vary` and
        once more.
    runs : int, optional
        Points that are drawn; None for grids and lists.
    seed : int
        Of the random numbers: the same gives the same points.

    Raises
    ------
    ValueError
        If the number of runs does not fit the design.
    """
    if design in SAMPLED:
        if runs is None:
            raise ValueError(f"runs must be given with design {design!r}")
        points = _points(design, len(varied), runs, seed)
        return [tuple(one.at(u) for one, u in zip(varied, point, strict=True)) for point in points.tolist()]
    if runs is not None:
        raise ValueError(f"runs must be left out with design {design!r}, whose values make its runs")
    levels = [one.levels() for one in varied]
    if design == "grid":
        return list(itertools.product(*levels))
    lengths = {one.label: len(values) for one, values in zip(varied, levels, strict=True)}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {count}" for name, count in lengths.items())
        raise ValueError(f"lists must have as many values each with design 'list', got {told}")
    return list(zip(*levels, strict=True))


def _points(design: Design, dimensions: int, runs: int, seed: int) -> NDArray:
    """Points in the unit cube: array (points, dimensions)."""
    if design == "latin_hypercube":
        return qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(runs)
    if runs & (runs - 1):
        lower = 1 << (runs.bit_length() - 1)
        raise ValueError(
            f"runs must be a power of 2 with design {design!r}, such as {lower} or {2 * lower}, got {runs}"
        )
    if design == "sobol":
        return qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random(runs)
    from SALib.sample.sobol import sample  # not everybody who plans a sweep has it

    return sample(salib_problem(dimensions), runs, calc_second_order=False, seed=seed)


def salib_problem(dimensions: int) -> dict[str, Any]:
    """What is varied as SALib takes it, in the unit cube."""
    return {
        "num_vars": dimensions,
        "names": [str(k) for k in range(dimensions)],
        "bounds": [[0.0, 1.0]] * dimensions,
    }
