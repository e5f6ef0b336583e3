"""How much the statics rows of both papers change with the step and Newton's tolerance.

Prints the table that `docs/validation.md` keeps: python -m benchmarks.convergence
"""

import pandas as pd

from exudyn_crawler import Case, simulate
from exudyn_crawler.views.tables import print_table
from studies.comparison import compare_kinematics
from studies.forces import compare_forces

DURATION = 10.0
SETTINGS = {
    "default": {},
    "half the step": {"step": 1e-3},
    "a quarter of the step": {"step": 0.5e-3},
    "tolerance / 100": {"residual": 2e-3},
    "tolerance x 100": {"residual": 20.0},
    "twice the step": {"step": 4e-3},
}


def statics(solver: dict[str, float]) -> pd.DataFrame:
    """Statics rows of a translation run with changed solver settings."""
    case = Case.translation()
    changed = case.with_(solver=case.solver.with_(**solver))
    histories = {"translation": simulate(changed, DURATION)}
    table = pd.concat([compare_kinematics(histories), compare_forces(histories)])
    return table[(table["class"] == "statics") & (table["case"] == "translation")]


def main() -> None:
    """Print the default's values and the change with every other setting."""
    rows = {name: statics(solver) for name, solver in SETTINGS.items()}
    default = rows.pop("default")
    table = default[["quantity", "statistic", "unit", "paper", "computed"]].reset_index(drop=True)
    for name, changed in rows.items():
        change = changed["computed"].to_numpy() / default["computed"].to_numpy() - 1.0
        table[name] = [f"{value:+.2%}" for value in change]
    print_table(table, "Statics rows: default solver, and change with other settings")


if __name__ == "__main__":
    main()
