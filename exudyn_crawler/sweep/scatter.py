"""Scatter of a sampled sweep's answers: quantiles with their statistical error, and what becomes of a fleet.

The bounds of quantiles are order statistics, those of portions Clopper and Pearson's: both hold for any
distribution of independent draws. A Latin hypercube or a Sobol sequence covers the values that are drawn more
evenly than these, so that its error is less as a rule and the bounds are on the safe side.
"""

import numpy as np
import pandas as pd
from scipy.stats import binomtest, quantile_test, spearmanr

from exudyn_crawler.sweep.answers import Life
from exudyn_crawler.sweep.definition import Sweep
from exudyn_crawler.sweep.worker import DONE

PORTIONS = (0.01, 0.05, 0.1, 0.5, 0.9, 0.95, 0.99)
CONFIDENCE = 0.95
PARTS = (4, 2, 1)
"""Convergence shows quantiles of the first quarter, the first half and all of the runs."""
LEAST_RUNS = 10
"""Finished runs from which answers of a sample have a scatter."""


def drawn_answers(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of the finished runs, in the order in which they were drawn."""
    return table[table["status"] == DONE].sort_values("run")


def quantiles(sweep: Sweep, table: pd.DataFrame) -> pd.DataFrame:
    """Quantiles of every answer over the finished runs, with their bounds and those of fewer runs.

    Columns answer, unit, runs, portion below, value, least and most (of `CONFIDENCE`; NaN where so few runs
    have none), and the value of the first quarter and half of the runs.
    """
    done, rows = drawn_answers(table), []
    for answer in sweep.answers:
        values = done[answer.label].dropna().to_numpy()
        parts = [values[: max(1, len(values) // part)] for part in PARTS]
        for portion in PORTIONS if len(values) else ():
            quarter, half, value = (float(np.quantile(one, portion)) for one in parts)
            bounds = quantile_test(values, q=value, p=portion).confidence_interval(CONFIDENCE)
            first = (answer.label, answer.unit, len(values), portion, value)
            rows.append((*first, bounds.low, bounds.high, quarter, half))
    columns = ["answer", "unit", "runs", "portion below", "value", "least", "most", "of a quarter", "of half"]
    return pd.DataFrame(rows, columns=columns)


def sensitivities(sweep: Sweep, table: pd.DataFrame) -> pd.DataFrame:
    """Spearman's rank correlation of every answer with every number that was drawn, and its p value.

    The p value is how often runs that do not depend on the number would show as much.
    """
    done, rows = drawn_answers(table), []
    numeric = [name for name in sweep.columns if pd.api.types.is_numeric_dtype(done[name])]
    for answer in sweep.answers:
        known = done[done[answer.label].notna()]
        for name in numeric if known[answer.label].nunique() > 1 else ():
            found = spearmanr(known[name], known[answer.label])
            rows.append((answer.label, name, float(found.statistic), float(found.pvalue)))
    found = pd.DataFrame(rows, columns=["answer", "varied", "rank correlation", "p value"])
    order = found["rank correlation"].abs().sort_values(ascending=False, kind="stable").index
    return found.loc[order].sort_values("answer", kind="stable", ignore_index=True)


def failures(sweep: Sweep, table: pd.DataFrame) -> pd.DataFrame:
    """Shoes of a fleet that crack before a rebuild, by every answer of life, with bounds of `CONFIDENCE`.

    A run stands for a shoe. Columns answer, hours, cracked (runs of all), portion with least and most, and
    shoes a year with theirs, the mean over the years until then; a cracked shoe counts once.
    """
    done, fleet, rows = drawn_answers(table), sweep.fleet, []
    for answer in (one for one in sweep.answers if isinstance(one, Life)):
        lives = done[answer.label].dropna()
        if lives.empty:
            continue
        for hours in dict.fromkeys((min(fleet.hours_a_year, fleet.rebuild), fleet.rebuild)):
            cracked = int((lives < hours).sum())
            bounds = binomtest(cracked, len(lives)).proportion_ci(CONFIDENCE)
            portions = np.array([cracked / len(lives), bounds.low, bounds.high])
            a_year = fleet.shoes * portions * fleet.hours_a_year / hours
            rows.append((answer.label, hours, f"{cracked} of {len(lives)}", *portions, *a_year))
    names = ["portion", "least", "most", "shoes a year", "least a year", "most a year"]
    return pd.DataFrame(rows, columns=["answer", "hours", "cracked", *names])
