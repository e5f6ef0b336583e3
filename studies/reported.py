"""Numbers that the four papers report, and how close a sound model should come to each.

The values are in `reported.csv` beside this module, one number a row, each with its source. The class of a
row says what governs it, and so how close to come:

============  ======================================  ==========================
class         what governs it                         within
============  ======================================  ==========================
exact         algebra of the equations                0.01 %
prescribed    the drive                               1 %
statics       equilibrium and the friction law        10 %
structural    the shoe's geometry, not published      25 %, frequencies 10 %
              in full
fluctuation   bouncing, step size, solver damping     a factor of 2
lateral       asymmetry and noise in their contact    no verdict
============  ======================================  ==========================
"""

import re
from importlib.resources import files
from typing import Literal

import pandas as pd

Verdict = Literal["yes", "no", "not reached", ""]

ENDS = {
    "kinematics": {"translation": 10.0, "turning": 10.0},
    "forces": {"translation": 10.0, "turning": 10.0},
    "stress": {"modal": 0.0, "propel": 15.0, "loading": 40.0, "hot spots": 40.0},
}
"""s by study and case: ends of the papers' runs."""

RELATIVE = {"exact": 1e-4, "prescribed": 0.01, "statics": 0.10, "structural": 0.25}
FREQUENCY = 0.10
FACTOR = 2.0


def reported_values(study: str) -> pd.DataFrame:
    """Rows of one study: kinematics, forces, stress or verification.

    Columns: study, case, quantity, statistic, unit, value, class, source.
    """
    with files("studies").joinpath("reported.csv").open() as file:
        table = pd.read_csv(file)
    chosen = table[table["study"] == study]
    if chosen.empty:
        raise ValueError(f"study must be one of {sorted(table['study'].unique())}, got {study!r}")
    return chosen.reset_index(drop=True)


def needed_time(study: str, case: str, statistic: str) -> float:
    """Time (s) that a run has to reach before a row can be compared with it."""
    named = re.fullmatch(r"(?:at t=|mean over )(\d+) s", statistic)
    return float(named[1]) if named else ENDS[study][case]


def verdict(paper: float, computed: float, kind: str, unit: str) -> Verdict:
    """Whether a computed value is within its class of the paper's: yes, no, or no verdict."""
    if kind == "lateral" or computed != computed:
        return ""
    ratio = computed / paper
    if kind == "fluctuation":
        return "yes" if 1.0 / FACTOR <= ratio <= FACTOR else "no"
    allowed = FREQUENCY if kind == "structural" and unit == "Hz" else RELATIVE[kind]
    return "yes" if abs(ratio - 1.0) <= allowed else "no"
