"""The page `comparison.md`: the `comparison.csv` of the studies as tables.

``python -m docs.comparison results`` writes it again from the folder that holds the studies' folders.
"""

import sys
from pathlib import Path

import pandas as pd

PAGE = Path(__file__).with_suffix(".md")
HEAD = """# Every number of the papers beside the computed one

The `comparison.csv` of the studies as tables (`make kinematics`, `make forces`, `make stress`, then
`python -m docs.comparison results`; 2 ms steps). [validation.md](validation.md) explains the classes and
why some numbers fall outside. Rows without a verdict are lateral, or the run does not reach them.
"""
STUDIES = {
    "kinematics": "Kinematics, straight and turning",
    "forces": "Forces, straight and turning",
    "stress": "Stress, propel and loading",
}
COLUMNS = ["case", "quantity", "statistic", "unit", "paper", "computed", "ratio", "class", "within"]


def page(results: Path) -> str:
    """Text of the page."""
    parts = [HEAD]
    for study, title in STUDIES.items():
        table = pd.read_csv(results / study / "comparison.csv", dtype={"within": str})[COLUMNS]
        lines = [f"## {title}\n", _row(COLUMNS), _row(["---"] * len(COLUMNS))]
        lines += [_row([_cell(value) for value in row]) for row in table.itertuples(index=False)]
        parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


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


if __name__ == "__main__":
    PAGE.write_text(page(Path(sys.argv[1])), encoding="utf-8")
