"""Law file of a fitted soil, and the table of its parameters."""

from pathlib import Path

import pandas as pd

from exudyn_crawler.files import whole_file
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.results.measured.soil_fit import SoilFit
from exudyn_crawler.settings import fields

HEADS = ("parameter", "unit", "value", "95 % from", "95 % to", "from")
SCATTER = {True: "how tests scatter", False: "how points scatter"}


def parameter_table(fit: SoilFit) -> pd.DataFrame:
    """Return the parameters of the law in its own units: value, interval and origin."""
    rows = []
    for name, field in BekkerSoil.model_fields.items():
        if not fields.has_unit(field):
            continue
        value = getattr(fit.law, name)
        unit = fields.unit_of(field)
        result = next((result for result in fit.parts if name in result.names), None)
        if result is not None:
            source = f"{result.points} points, {SCATTER[result.by_tests]}"
            rows.append((name, unit, value, *result.span(name), source))
        elif field.is_required():
            source = "base" if name in fit.taken else "none: zero"
            rows.append((name, unit, value, float("nan"), float("nan"), source))
    return pd.DataFrame(rows, columns=[*HEADS])


def correlation_table(fit: SoilFit) -> pd.DataFrame:
    """Return the correlations of parameters from tests of one kind: columns parameter, with, correlation."""
    rows = [
        (result.names[a], result.names[b], float(result.correlation[a, b]))
        for result in fit.parts
        for a in range(len(result.names))
        for b in range(a)
    ]
    return pd.DataFrame(rows, columns=["parameter", "with", "correlation"])


def write_law(fit: SoilFit, path: Path, sources: list[str], overwrite: bool = False) -> Path:
    """Write a law file for `read_law`, with the intervals as remarks; raise as `whole_file`."""
    lines = [f"# Soil fitted to {' and '.join(sources)}; intervals of 95 %.", 'model = "bekker"']
    lines[1:1] = [f"# {remark}" for remark in fit.remarks]
    for _, row in parameter_table(fit).iterrows():
        span = f"{row['95 % from']:.4g} to {row['95 % to']:.4g}, {row['from']}"
        remark = span if row["95 % from"] == row["95 % from"] else row["from"]
        unit = f"{row['unit']}; " if row["unit"] else ""
        lines.append(f"{row['parameter']} = {float(row['value'])!r} # {unit}{remark}")
    unmeasured = ("shear_viscosity", "damping")
    lines += [f"{name} = {getattr(fit.law, name)!r} # not measured" for name in unmeasured]
    with whole_file(path, overwrite) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
