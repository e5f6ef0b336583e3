"""Effect of the rigid studies' contact choices on every row of the papers, by variants.

The default follows the words and the means of the papers. Choices that only fit rows are variants.
"""

from collections.abc import Callable, Mapping, Sequence

import pandas as pd

from exudyn_crawler import Case, PairContact, Shoe, simulate
from studies import DURATION
from studies.comparison import compare_kinematics, verdict
from studies.forces import compare_forces
from studies.grounds import pitching
from studies.kinematics import CASES

Change = Callable[[Case], Case]


VARIANTS: Mapping[str, Change] = {
    "default": lambda case: case,
    "closest points": lambda case: case.with_(contact=case.part(PairContact).with_(penetration="closest")),
    "face normal": lambda case: case.with_(contact=PairContact.oil_sand()),
    "no fingers": lambda case: case.with_(shoe=Shoe.ph4100c()),
    "units pitch": pitching,
    "uneven shoe": lambda case: case.with_(shoe=Shoe.uneven()),
    "uneven shoe, closest points": lambda case: case.with_(
        shoe=Shoe.uneven(), contact=case.part(PairContact).with_(penetration="closest")
    ),
}
"""Changes of the rigid studies' cases, by name."""


def compare_variants(
    names: Sequence[str] = tuple(VARIANTS), duration: float = DURATION, progress: bool | None = None
) -> pd.DataFrame:
    """Compute every row of the rigid studies for some variants.

    Columns case, quantity, statistic, unit, class, paper, then the computed value of every variant.
    """
    columns = {}
    for name in names:
        histories = {
            case: simulate(VARIANTS[name](make()), duration, progress) for case, make in CASES.items()
        }
        table = pd.concat([compare_kinematics(histories), compare_forces(histories)], ignore_index=True)
        columns[name] = table["computed"]
    return table[["case", "quantity", "statistic", "unit", "class", "paper"]].assign(**columns)


def counts(table: pd.DataFrame) -> pd.DataFrame:
    """Count the rows of a `compare_variants` table within their class; lateral ones within a factor of 2.

    Columns variant, then one per case and class: number within, of the number of rows.
    """
    lines = []
    for name in table.columns[6:]:
        line = {"variant": name}
        for (case, kind), rows in table.groupby(["case", "class"], sort=False):
            pairs = rows[["paper", name]]
            judged = kind
            if kind == "lateral":
                pairs = pairs.abs()
                judged = "fluctuation"
            each = zip(pairs["paper"], pairs[name], rows["unit"], strict=True)
            within = [verdict(paper, value, judged, unit) for paper, value, unit in each]
            line[f"{case} {kind}"] = f"{within.count('yes')} of {len(rows)}"
        lines.append(line)
    return pd.DataFrame(lines)
