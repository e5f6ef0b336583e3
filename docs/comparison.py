"""The page `comparison.md`: the `comparison.csv` of the studies as tables, and what each row says.

``python -m docs.numbers results`` writes it again from the folder that holds the studies' folders.
"""

from pathlib import Path

import pandas as pd

from studies.comparison import with_evidence

PAGE = Path(__file__).with_suffix(".md")
HEAD = """# Every number of the papers beside the computed one

The `comparison.csv` of the studies as tables (`make kinematics`, `make forces`, `make stress`, then
`python -m docs.numbers results`; 2 ms steps). [validation.md](validation.md) explains the classes and
why some numbers fall outside. Rows without a verdict are lateral, or the run does not reach them.

*Computed* is one run. *Median*, *least* and *greatest* are of runs from starts that differ by rounding, 16 of
the rigid studies and 8 of the stress study (`python -m studies variants`). The value of one more start lies
between least and greatest with a probability of 15/17 or 7/9. *Variants* is the number of variants in which
the row is within its limit (a lateral row within a factor of 2). Some of them are plainly wrong, such as no
friction: a row that is within in all of them is an input. It says nothing about the model.

Shoe 7's stresses count "yes" at another place than the paper's: here the highest is in the bottom plate of a
wing, the paper's at the faces of the lugs.
"""
STUDIES = {
    "kinematics": "Kinematics, straight and turning",
    "forces": "Forces, straight and turning",
    "stress": "Stress, propel and loading",
}
COLUMNS = ["case", "quantity", "statistic", "unit", "paper", "computed", "ratio", "class", "within"]
COLUMNS += ["variants", "median", "least", "greatest"]


def page(results: Path) -> str:
    """Text of the page."""
    parts = [HEAD]
    for study, title in STUDIES.items():
        table = compared(results, study)[COLUMNS]
        lines = [f"## {title}\n", _row(COLUMNS), _row(["---"] * len(COLUMNS))]
        lines += [_row([_cell(value) for value in row]) for row in table.itertuples(index=False)]
        parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


def compared(results: Path, study: str) -> pd.DataFrame:
    """Comparison of a study from its folder, with the evidence that is kept now."""
    table = pd.read_csv(results / study / "comparison.csv", dtype={"within": str})
    return with_evidence(table.drop(columns=COLUMNS[-4:], errors="ignore"))


def printed(study: str) -> pd.DataFrame:
    """Rows of a study as the page prints them, all text: columns as in `COLUMNS`."""
    text = PAGE.read_text(encoding="utf-8").split(f"## {STUDIES[study]}\n")[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("|")]
    return pd.DataFrame([[cell.strip() for cell in row] for row in rows[2:]], columns=COLUMNS)


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.4g}"
    return str(value)
