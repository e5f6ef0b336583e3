"""What commands print on a terminal: no number is cut at any width, and a run ends with its answer."""

import re
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

import exudyn_crawler
from exudyn_crawler import Case
from exudyn_crawler.cli.commands import show_answers
from exudyn_crawler.results.stress.recovery import StressResults, recover_stresses
from exudyn_crawler.views.tables import cell_text
from studies.comparison import comparison_table, reported_values
from studies.ground import PAPERS, row
from studies.sliding_modes import COORDINATES
from tests.test_cli import SWEEP

WIDTHS = [80, 120]
PLACES = {
    "region": ["lugs", "roller path"],
    "node": [146, 13_772],
    **{f"{axis} in the shoe in m": [-0.283571, 1.25] for axis in "xyz"},
}
LIFE = pd.DataFrame(
    PLACES
    | {
        "life in h that 90 % survive": [3.009e5, 412.7],
        "life in h at least": [3.009e5, 0.04392],
        "life in h at most": [float("inf"), 4321.7],
        "verdict": ["beside a pin coupling: do not use", "good to 15 %"],
        "worst place": [5, 6],
        "life in h there": [0.07561, 2.0e9],
        "main part": ["propel: constant", "digging: crowd"],
        "its share": [1.0, 0.73],
        "main load": ["pins", "rollers"],
        "life in h, critical plane": [1432.0, 5.0],
    }
)
SPOTS = pd.DataFrame(
    {"rank": [1, 2], "von Mises in MPa": [133.94821, 32.24158], "time in s": [33.526, 0.134]}
    | PLACES
    | {
        **{f"{axis} in the track at t = 0 in m": [13.879852, 9.942141] for axis in "xyz"},
        "jump in MPa": [15.8658, 3.43212],
        "error in MPa": [9.6184, 9.0107],
        "flag": ["", ""],
        "verdict": ["mesh too coarse: refine here", "good to 15 %"],
        "contribution of pins": [1.009, 0.991],
    }
)
SPREAD = pd.DataFrame([{"shoe": 13, "node": 146}]).assign(
    **{f"{run} in MPa": 133.94821 for run in ("as it is", "start 2", "start 3", "area")},
    **{"spread in %": 12.345, "choice in %": 12.345, "verdict": "good to 15 %"},
)
HAND = pd.DataFrame(
    [("reaction", "N", -2.146e6, -2.1460003e6, 3.0e-9)], columns=["quantity", "unit", "hand", "engine", "off"]
)
RESULTS = pd.DataFrame(
    [("greatest contact force on a shoe", 655.13, "kN", "shoe 13", 33.526)],
    columns=["result", "value", "unit", "of", "at"],
)

CYCLES = pd.DataFrame(
    [("rest", "stones below the edge, rock", "roller path", 412_345.6, 16.4938)],
    columns=["from", "to", "region", "cycles to a crack", "an hour"],
)
# 0.1 s of the closed tracks
LOOP = pd.DataFrame(
    [
        ["tension, upper run", 792.3111593, 798.7858901, 803.0139462],
        ["teeth on a shoe", 0.0, 457.7414457, 526.4],
    ],
    columns=["of", "least in kN", "mean in kN", "greatest in kN"],
)
TORQUE = pd.DataFrame(
    [(0.3, 86.1357474, 86.1325946, 86.1301254, 54.6769849)],
    columns=["cut ahead of the axis in m"]
    + [f"{name} in kN m" for name in ("torque", "by moments", "by work", "by means of tension")],
)
LOADS = {"ground on a shoe": 993.9217, "wheels on a shoe": 1196.3726, "link": 989.0346}
PEAKS = pd.DataFrame(
    {"case": ["rolled at the closed tension"]}
    | {f"{size} {of} in kN": value for of, value in LOADS.items() for size in ("greatest", "mean")}
)
TURNS = pd.DataFrame(
    [
        ("closed", 629.90385, 805.02955, 1.9251287, 1.0533892, 42.3964246, 0.0, 526.41676, 86.2105, 0.491876),
        (
            "turn about the left track",
            685.97988,
            910.01603,
            2.6135,
            1.1145,
            116.25968,
            0.0,
            546.1,
            94.56,
            2.3,
        ),
    ],
    columns=[
        *("case", "least tension in kN", "greatest tension in kN", "link across, greatest in kN"),
        *("link across, rms in kN", "yaw and roll moment of a link in kN m", "flange on a shoe in kN"),
        *("teeth on a shoe in kN", "mean torque, right tumbler, in kN m", "ground across a shoe, mean in kN"),
    ],
).assign(**{"mean torque, left tumbler, in kN m": [float("nan"), 88.6904646]})
PLATES = pd.DataFrame(
    [{"run": 9, "top_plate": 0.054, "spring_stiffness": 4e7, "life_of_roller_path": 7.9123456e7}]
).assign(life_of_shoe=8.5e5, highest_stress=7.61234e7, peak_pin_force=5.284567e5)
PLATES = PLATES.assign(folder="1a2b", status="done", reason="", wall_time_s=35.1234567)
GROWTH = dict.fromkeys(("even", "7 m units", "1 m units"), "+12.34 at 20.5 Hz (11)")
MODES = pd.DataFrame([{"mode": 1, "frequency, Hz": 20.512345, "growth rate, 1/s": 1.84212345}]).assign(
    **{"damping ratio": -0.0142934, "shoe": 13}, **dict.fromkeys(COORDINATES, 0.98765432)
)


def compared(study):
    reported = reported_values(study)
    return comparison_table(reported, [1.0234 * value for value in reported["value"]])


def result(*found):
    """What takes the place of a function that would run for minutes."""
    return lambda *_arguments, **_options: found[0] if len(found) == 1 else found


ANSWER = SimpleNamespace(label="joint force", better="less")
SAMPLE = SimpleNamespace(answers=(ANSWER,), columns=(), is_sampled=True, fleet=None)


def swept(name, value):
    """Sweep of ten runs with one answer."""
    table = pd.DataFrame({"run": range(7, 17), "folder": "1a2b", "status": "done", ANSWER.label: value})
    table.attrs = {"units": {ANSWER.label: "N"}}
    return SimpleNamespace(table=table, sweep=SAMPLE, folder=Path("results") / name, check_answers=lambda: "")


POWERS = pd.DataFrame(
    [{"ground": "oil sand, soft end, springs back, undamped", "distance travelled in m": 2.75}]
).assign(
    **{"pull beyond rolling in kN": 93.734, "taken by pressure in kN": 13.131, "taken by shear in kN": 83.257}
)
VALUES = pd.DataFrame({"value": [133.94821e6]})
STRESSES = SimpleNamespace(hot_spots={13: VALUES}, dataset=None)
HISTORY = SimpleNamespace(case=Case.translation(), duration=10.0)
CHECK = SimpleNamespace(name="ready", hours=25_000.0, material=SimpleNamespace(name="A36"))
RUN = SimpleNamespace(recovered=lambda: STRESSES, history=None)
FAKES = {
    "studies kinematics": {"studies.kinematics.study": result({}, compared("kinematics"))},
    "studies forces": {"studies.forces.study": result({}, compared("forces"))},
    "studies variants rigid": {
        "studies.variants.study": result(compared("forces"), compared("forces")),
        "studies.variants.counts": result(HAND),
    },
    "studies stress --mesh coarse": {
        "studies.stress.study": result(RUN, compared("stress")),
        "exudyn_crawler.results.stress.hot_spots.hot_spot_table": result(SPOTS),
        "studies.stress.highest_in_propel_and_loading": result(SPREAD),
    },
    "studies library d11": {
        "studies.library.study": result(
            {},
            pd.DataFrame(
                [{"machine": "d11", "turn in rad": 0.4021234, "greatest tension in kN, turn": 350.71}]
            ),
        )
    },
    "studies shovel-life": {"studies.life.study": result({}, LIFE.assign(propel_and_material="dragged_a36"))},
    "studies rollers": {"studies.rollers.study": result({}, SPOTS.assign(case="rolled", shoe=7))},
    "studies closed": {"studies.closed.study": result({}, LOOP, TORQUE, PEAKS, TURNS)},
    "studies grounds --powers": {"studies.ground.power_study": result(POWERS)},
    "studies plate-sweep": {"studies.plate_sweep.study": result(SimpleNamespace(table=PLATES))},
    "studies sliding-modes": {
        "studies.sliding_modes.study": result(
            ("modes", MODES), ("growth over friction", pd.DataFrame([{"friction": 0.15} | GROWTH]))
        )
    },
    "studies rollers --choices": {"studies.rollers.open_choices": result(compared("stress"))},
    "studies stress --choices": {"studies.stress.open_choices": result(compared("stress"))},
    "studies verify": {"studies.two_bodies.study": result(HAND, compared("kinematics"))},
    "info": {},
    "info stress": {},
    "life duty.toml": {
        "exudyn_crawler.results.life.duty.read_duty": result(SimpleNamespace(name="digging")),
        "exudyn_crawler.life_run.life": result(SimpleNamespace(table=LIFE)),
        "exudyn_crawler.views.pages.life.life_lines": result(["90 % of the shoes see no crack"]),
    },
    "check shoe.toml": {
        "exudyn_crawler.life_run.check_cases": result(
            SimpleNamespace(worst_cycles=CYCLES, by_region=CYCLES, check=CHECK)
        ),
        "exudyn_crawler.views.pages.life.check_lines": result(["first to crack: wings"]),
    },
    "scatter sample.toml": {"exudyn_crawler.sweep.running.run_sweep": result(swept("sample", 1.2345678e6))},
    "spread .": {"exudyn_crawler.spread_run.spread": result(SimpleNamespace(by_shoe=lambda: SPREAD))},
    "run case.toml": {
        "exudyn_crawler.case_run.run_case": result(SimpleNamespace(history=HISTORY, stresses=STRESSES)),
        "exudyn_crawler.results.history.summary.key_results": result(RESULTS),
        "exudyn_crawler.results.stress.hot_spots.peak_spots": result({"peak stress": (7, SPOTS)}),
        "exudyn_crawler.results.stress.hot_spots.hot_spot_table": result(SPOTS),
    },
    "sweep sweep.toml --dry-run": {},
    "sweep sweep.toml": {"exudyn_crawler.sweep.running.run_sweep": result(swept("sweep", 7e5))},
}
"""Commands that print a table, and what takes the place of their work."""
FAKES["run case.toml --no-page"] = FAKES["run case.toml"]
NUMBERS = {
    "studies closed": ["803", "54.68", "1196", "116.3"],
    "studies grounds --powers": ["93.73", "13.13", "83.26"],
    "studies plate-sweep": ["79 120 000", "40 000 000"],
    "studies sliding-modes": ["1.842", "-0.01429"],
    "studies shovel-life": ["300 900", "0.04392"],
    "studies rollers": ["133.9", "33.53"],
    "life duty.toml": ["300 900", "0.04392"],
    "check shoe.toml": ["412 300", "16.49"],
    "scatter sample.toml": ["1235", "kN"],
    "spread .": ["133.9", "12.35"],
    "studies verify": ["-2 146 000", "3e-09"],
    "run case.toml": ["655.1", "33.53"],
    "studies stress --mesh coarse": ["133.9", "33.53", "386.4"],
    "sweep sweep.toml --dry-run": ["10 MN/m", "30 MN/m"],
    "sweep sweep.toml": ["700", "kN", "1a2b"],
    "info": ["100"],
}
"""Of them, as they are written, that have to be seen at any width."""


@pytest.fixture
def terminal(monkeypatch, told, tmp_path):
    """Call a command, of which the work is faked, in a terminal of some width: lines of its output."""
    (tmp_path / "case.toml").write_text('base = "translation"\n')
    (tmp_path / "sweep.toml").write_text(SWEEP)
    sample = SWEEP.replace("count = 3\n", "")
    (tmp_path / "sample.toml").write_text(f'design = "sobol"\nruns = 16\n{sample}')

    def lines(words, width):
        for name, fake in FAKES.get(words, {}).items():
            # a public name is remembered where it is first asked for, which must not be a fake
            if (public := name.split(".")[-1]) in exudyn_crawler.__all__:
                monkeypatch.setattr(exudyn_crawler, public, fake)
            monkeypatch.setattr(name, fake)
        for name, value in {"COLUMNS": width, "TTY_COMPATIBLE": 1, "NO_COLOR": 1}.items():
            monkeypatch.setenv(name, str(value))
        return re.sub(r"\x1b\[[0-9;]*m", "", told(*words.split())).splitlines()

    return lines


def check_tables(lines, width, numbers):
    rules = [line for line in lines if line[:1] in "┏┡└┌"]
    assert rules
    # tables have their right edge
    assert all(line[-1] in "┓┩┘┐" and len(line) <= width for line in rules)
    told = "\n".join(lines)
    assert "…" not in told
    for number in numbers:
        assert re.search(rf"[│ ]{re.escape(number)}[ ,]", told)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("words", FAKES)
def test_no_number_is_cut_in_any_table(terminal, words, width):
    check_tables(terminal(words, width), width, NUMBERS.get(words, ()))


@pytest.mark.parametrize(
    ("words", "columns", "file"),
    [
        ("studies kinematics", "quantity statistic unit paper computed within", "kinematics/comparison.csv"),
        ("life duty.toml", "region life least most verdict", "duty/shortest_lives.csv"),
    ],
)
def test_where_not_all_columns_fit_a_line_says_where_they_are(terminal, words, columns, file):
    lines = terminal(words, 80)
    assert f"all columns: results/{file}" in lines
    heads = [line for line in lines if line.startswith("┃")]
    assert all(name in " ".join(heads) for name in columns.split())


def test_a_run_names_its_page_or_how_to_make_it(terminal):
    assert terminal("run case.toml", 80)[-1] == "results/case/report.html: open it in a browser"
    assert terminal("run case.toml --no-page", 80)[-1].endswith("exudyn-crawler report results/case")


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.simulation
def test_two_runs_are_compared_in_any_terminal(terminal, monkeypatch, translation, turning, tmp_path, width):
    monkeypatch.setattr("exudyn_crawler.views.pages.runs.write_comparison", result(None))
    for name, history in (("straight", translation), ("turning", turning)):
        (tmp_path / name).mkdir()
        history.save(tmp_path / name / "history.nc")
    lines = terminal("compare straight turning", width)
    assert all(len(line) <= width for line in lines if line[:1] in "┏│└")
    assert ("all columns: straight_turning.csv" in lines) == (width == 80)


@pytest.mark.simulation
def test_a_flexible_run_ends_with_its_greatest_values_and_the_place_of_its_peak(flexible_run, capsys):
    history, stress, hot_spots = flexible_run
    show_answers(SimpleNamespace(history=history, stresses=StressResults(stress, hot_spots, {}, whole=None)))
    told = " ".join(capsys.readouterr().out.split())
    highest = float(stress.highest_von_mises.max()) / 1e6
    assert f"peak stress: {highest:.4g} MPa at t = " in told
    assert "in shoe 13, " in told
    for name in (
        "contact force on a shoe",
        "force of a link",
        "force of the drive",
        "penetration",
        "distance travelled",
    ):
        assert name in told
    assert hot_spots[13]["verdict"].iloc[0] in told


@pytest.fixture(scope="module")
def grounds(bent):
    """Runs of two grounds, whose tables the study makes itself."""
    stresses = recover_stresses(bent, [0.0, 0.06], peak=False)
    run = SimpleNamespace(history=bent, folder=None, recovered=lambda: stresses)
    return {PAPERS: run, "hard floor, stones under the edges": run}


@pytest.mark.slow
@pytest.mark.parametrize("width", WIDTHS)
def test_tables_of_the_grounds_are_read_in_any_terminal(terminal, monkeypatch, grounds, width):
    monkeypatch.setattr("studies.ground.study_runs", lambda *_, **__: nullcontext(grounds))
    Path("results/ground").mkdir(parents=True)
    pull = row(grounds[PAPERS])["mean pull in kN"]
    check_tables(terminal("studies grounds", width), width, [cell_text(pull)])
