"""Random changes of a valid case: whatever comes, the command ends in plain lines and a known exit code."""

import random
import re
import signal
import sys

import pytest

from exudyn_crawler import Case, CaseFile, LoadCycle
from exudyn_crawler.__main__ import main
from exudyn_crawler.case import Outputs
from exudyn_crawler.case.case_file import case_text

SEED = 20160316
NUMBERS = ("0", "-1", "1e300", "-1e300", "1e-300", "nan", "inf", "99999999999999999999")
ODD = (*NUMBERS, "true", '""', "[]", "{}", "x")
PROGRESS = re.compile(r"^(compiling .*|.*: \d+ s so far)\n", re.MULTILINE)
LONGEST = 120.0
"""s, after which a change hangs: 300 of them take about two minutes."""
FACTORS = (0.0, 1e-6, 1e-3, 0.5, 0.9, 1.1, 2.0, 1e3, 1e6, -1.0)


def short(case, columns, rows, **outputs):
    """Two shoes of a case on a few units for two steps: a run that takes a moment, and leaves little."""
    size = {"track.shoe_count": 2, "terrain.columns": columns, "terrain.rows": rows}
    case = case.with_(
        size | {"solver.maximum_iterations": 20, "solver.minimum_step": 2e-4}, loads=LoadCycle.propel(2)
    )
    outputs = Outputs(figures=False, tables=False, forces=False, page=False, **outputs)
    return CaseFile(case=case, duration=0.004, outputs=outputs)


def tiny():
    return short(Case.translation(), 4, 3)


def tiny_flexible():
    """With the stress study's parameters and a flexible front shoe of the coarse mesh."""
    case = Case.stress("coarse").with_({"flexible.shoes": (2,), "flexible.static_fields": False})
    return short(case, 8, 9, pictures=False, paraview=False)


@pytest.fixture
def nothing_hangs():
    """What takes longer than `LONGEST` from one call on to the next fails."""

    def hangs(_number, _frame):
        raise TimeoutError(f"nothing came of it in {LONGEST:g} s")

    before = signal.signal(signal.SIGALRM, hangs)
    yield lambda: signal.setitimer(signal.ITIMER_REAL, LONGEST)
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


def changed_line(line, dice):
    """Line of a case file with its value made odd, scaled, doubled, left out or misspelt."""
    key, equals, rest = line.partition(" = ")
    if not equals:
        return dice.choice((line, "", line.replace("[", "[x")))
    value, mark, comment = rest.partition(" # ")
    kind = dice.choice(("odd", "scaled", "scaled", "scaled", "doubled", "left out", "misspelt"))
    if kind == "odd":
        value = dice.choice(ODD)
    elif kind == "scaled":
        try:
            value = repr(dice.choice(FACTORS) * float(value))
        except ValueError:
            value = dice.choice(ODD)
    elif kind == "doubled":
        value = f"[{value}, {value}]"
    elif kind == "left out":
        return ""
    else:
        place = dice.randrange(len(key))
        key = key[:place] + key[place + 1 :]
    return f"{key} = {value}{mark}{comment}"


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("base", "count"),
    [
        (tiny, 40),
        pytest.param(tiny, 300, marks=pytest.mark.slow),
        pytest.param(tiny_flexible, 300, marks=pytest.mark.slow),
    ],
)
@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_no_change_of_a_case_ends_in_a_traceback(base, count, tmp_path, monkeypatch, capsys, nothing_hangs):
    dice = random.Random(SEED)
    lines = case_text(base()).splitlines()
    monkeypatch.chdir(tmp_path)
    ends = {0: 0, 2: 0, 3: 0}
    for number in range(count):
        own = list(lines)
        for _ in range(dice.choice((1, 1, 1, 2))):
            at = dice.randrange(len(own))
            own[at] = changed_line(own[at], dice)
        (tmp_path / "case.toml").write_text("\n".join(own) + "\n", encoding="utf-8")
        monkeypatch.setattr(sys, "argv", ["exudyn-crawler", "run", "case.toml", "--out", f"run{number}"])
        nothing_hangs()
        with pytest.raises(SystemExit) as end:
            main()
        told = PROGRESS.sub("", capsys.readouterr().err)
        what = f"change {number}: exit {end.value.code}, {told}, {set(own) - set(lines)}"
        assert end.value.code in ends, what
        ends[end.value.code] += 1
        assert "Traceback" not in told, what
        assert "unexpected" not in told, what
        assert all(line.startswith(("error: ", "warning: ")) for line in told.splitlines()), what
        assert bool(told) or end.value.code == 0, what
    # it is not the refusals alone that were tried
    assert min(ends[0], ends[2]) > count // 10, ends
