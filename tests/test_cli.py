"""The command as a user meets it: help, exit codes, errors in one line."""

import importlib.metadata
import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
import zipfile
from contextlib import closing
from pathlib import Path
from unittest.mock import Mock

import imageio_ffmpeg
import pandas as pd
import pytest
import tomlkit

from exudyn_crawler import Case, History, cli
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.cli import application, commands
from exudyn_crawler.machines import CaseFile, read_case
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.results.checks.cases import read_check
from exudyn_crawler.run.folder import progress
from exudyn_crawler.settings.fields import case_rows
from exudyn_crawler.sweep.scatter import read_scatter
from studies.commands import app as studies
from tests.test_release import read

STUDIES = {
    *("kinematics", "forces", "stress", "uneven", "rollers", "closed", "grounds", "shovel-life"),
    *("plate-sweep", "sliding-modes", "verify", "measurements", "library", "pins", "variants", "order"),
    *("mechanisms", "play"),
}
COMMANDS = {
    *(
        "demo",
        "scatter",
        "schema",
        "fmu",
        "check",
        "init",
        "shoe",
        "run",
        "info",
        "report",
        "animate",
        "node-stress",
    ),
    *(
        "pin-forces",
        "shoe-loads",
        "compare",
        "drawbar",
        "fit-soil",
        "soil-stress",
        "ground",
        "life",
        "spread",
        "sweep",
        "machine",
        "machines",
        "assess",
        "app",
        "wear",
    ),
}


@pytest.fixture
def short(tmp_path):
    """Case file of a run that takes a moment."""
    path = tmp_path / "short.toml"
    path.write_text('base = "translation"\nname = "short"\nduration = 0.02\n[outputs]\nfigures = false\n')
    return path


@pytest.mark.parametrize(
    ("app", "words", "commands", "program"),
    [(cli.app, (), COMMANDS, "exudyn-crawler"), (studies, ("studies",), STUDIES, "python -m studies")],
)
def test_every_command_is_listed_and_its_help_shows_an_example(told, app, words, commands, program):
    assert {one.callback.__name__.replace("_", "-") for one in app.registered_commands} == commands
    listed = told(*words, "--help")
    for name in commands:
        assert name in listed
        out = told(*words, name, "--help")
        assert f"Example: {program} {name}" in out
        assert "--debug" in out, name


def test_all_figures_of_a_datasheet_are_listed_with_what_they_may_be(told, refused):
    listed = told("machine", "--keys")
    for name in Datasheet.model_fields:
        assert f"│ {name} " in listed
    assert "excavator, dozer, loader" in " ".join(listed.split())
    assert "FILE must be given" in refused("machine")


@pytest.mark.simulation
@pytest.mark.slow
def test_the_handbooks_check_file_is_checked(told, refused, tmp_path):
    """As it stands it is read; with the coarse ready shoe, without the ready cases, its own one is solved."""
    block = read("docs/check-cases.md").partition("```toml\n")[2].partition("```")[0]
    name = block.partition("\n")[0].removeprefix("# ")
    (tmp_path / name).write_text(block)
    asked = read_check(tmp_path / name)
    assert asked.dimensions == {"rail_overhang": 0.132, "wear": 0.025}
    content = tomllib.loads(block) | {"mesh": "coarse", "levels": []}
    del content["dimensions"]
    (tmp_path / name).write_text(tomlkit.dumps(content))
    out = told("check", name, "--out", "checked", "--no-pictures")
    assert "two stones" in out
    assert "section moments" in out
    peaks = pd.read_csv(tmp_path / "checked" / "peaks.csv")
    assert set(peaks["case"]) == {"two stones"}
    assert peaks["von Mises in MPa"].max() > 50.0
    assert (pd.read_csv(tmp_path / "checked" / "hertz.csv")["force in kN"] == 574.0).all()
    assert "exists" in refused("check", name, "--out", "checked", "--no-pictures")
    content["cases"][0]["ground"]["stiffness"] = "soft"
    (tmp_path / name).write_text(tomlkit.dumps(content))
    err = refused("check", name, "--out", "other")
    assert name in err
    assert "cases[0].ground.stiffness" in err


def test_figures_of_a_machine_come_first_and_all_values_where_they_are_asked_for(told, refused, tmp_path):
    told("init", "mine", "--machine", "pc300lc")
    out = told("machine", "mine.toml")
    assert out.startswith("Komatsu PC300LC-8: its figures") or "its figures" in out.splitlines()[0]
    assert len(out.splitlines()) < 25
    assert "values determine these figures: exudyn-crawler machine mine.toml --all" in out
    listed = told("machine", "mine.toml", "--all")
    values = [line.split("│")[2] for line in listed.splitlines() if line.count("│") == 5]
    assert len(values) > 60
    digits = [number for value in values for number in re.findall(r"\d+\.\d+", value)]
    assert max(len(number.replace(".", "").lstrip("0")) for number in digits) <= 4
    told("machine", "mine.toml", "--out", "values.csv")
    values = pd.read_csv(tmp_path / "values.csv").set_index("key")
    assert {"derived", "assumed"} <= {*values["origin"]}
    assert "values.csv exists" in refused("machine", "mine.toml", "--out", "values.csv")


def test_a_law_of_the_ground_is_drawn_from_its_file(told, refused, tmp_path):
    (tmp_path / "sand.toml").write_text('model = "bekker"\nbase = "lete_sand"\ncohesion = 2e3\n')
    assert "sand.png" in told("ground", "sand.toml")
    assert (tmp_path / "sand.png").stat().st_size > 10_000
    for text, words in (
        ('model = "clay"', ("law.toml", "model", "'bekker' or 'rock'", "'clay'")),
        ("k_c = 1e5", ("law.toml: model must be given: 'bekker' or 'rock'",)),
        ("model = {}", ("law.toml", "model: must be 'bekker' or 'rock'", "got {}")),
        ('model = "rock"\nbase = "hard_floor"\nfriction = -1.0', ("law.toml", "friction", "-1")),
        ('model = "bekker"\nbase = "hard_floor"', ("law.toml", "base", "'oil_sand_low'")),
    ):
        (tmp_path / "law.toml").write_text(text)
        err = refused("ground", "law.toml")
        assert all(word in err for word in words), err


def test_a_line_that_repeats_a_broken_file_loses_its_middle(refused, tmp_path):
    (tmp_path / "shoe.stl").write_text(
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex " + "[" * 5000 + " 0 0\n"
    )
    err = refused("shoe", "shoe.stl")
    assert err.startswith("error: shoe.stl must be an STL file that can be read: ")
    assert "[[[ ... [[[" in err
    assert len(err.strip()) < 600


@pytest.mark.filterwarnings("default::exudyn_crawler.errors.ImplausibleWarning")
def test_a_law_that_no_ground_has_is_drawn_with_a_warning(call, tmp_path):
    text = 'model = "bekker"\nbase = "lete_sand"\nk_phi = 5e12\nfriction_angle = 0.0\n'
    (tmp_path / "law.toml").write_text(text)
    code, out, err = call("ground", "law.toml")
    assert code == 0
    assert "law.png" in out
    assert "law.toml: k_phi: 5e+12" in err
    assert "law.toml: friction_angle: 0 deg is outside of 5 to 50 deg" in err


ENGINE_AND_FIGURES = {"exudyn", "numba", "matplotlib", "skfem", "pypardiso", "dask", "distributed"}
TABLES = {"xarray", "pandas"}
NUMBERS = {"numpy", "scipy"} | TABLES


LINES = [
    ("exudyn_crawler --help", ENGINE_AND_FIGURES | NUMBERS | {"pydantic"}),
    ("exudyn_crawler --version", ENGINE_AND_FIGURES | NUMBERS),
    ("exudyn_crawler run --help", ENGINE_AND_FIGURES | NUMBERS),
    ("exudyn_crawler sweep --help", ENGINE_AND_FIGURES | NUMBERS),
    ("exudyn_crawler report nowhere", ENGINE_AND_FIGURES | NUMBERS),
    ("exudyn_crawler animate nowhere", ENGINE_AND_FIGURES | NUMBERS),
    ("studies kinematics --duration=-1", ENGINE_AND_FIGURES | NUMBERS),
    ("exudyn_crawler info", ENGINE_AND_FIGURES | TABLES),
    ("exudyn_crawler info uneven", ENGINE_AND_FIGURES | TABLES),
    # the weight of its flexible shoes is that of their mesh
    ("exudyn_crawler info stress", (ENGINE_AND_FIGURES | TABLES) - {"skfem"}),
    ("exudyn_crawler run nowhere.toml", ENGINE_AND_FIGURES - {"skfem"}),
    ("exudyn_crawler init own --study opera", ENGINE_AND_FIGURES - {"skfem"}),
]
"""Commands, and what none of them and of those before it may load."""
LOADED = """
import contextlib, runpy, sys
for line, heavy in {lines}:
    sys.argv = line.split()
    with contextlib.suppress(SystemExit):
        runpy.run_module(sys.argv[0], run_name="__main__")
    if loaded := heavy & set(sys.modules):
        sys.exit(f"{{line}}: {{loaded}}")
"""


def test_help_a_case_and_a_refusal_load_nothing_heavy():
    script = LOADED.format(lines=LINES)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_versions_are_told(told):
    version = importlib.metadata.version("exudyn-crawler")
    assert told("--version").startswith(f"exudyn-crawler {version}, exudyn 1.")


def test_names_with_letters_that_a_console_lacks_are_told(tmp_path):
    (tmp_path / "own.toml").write_text('base = "turning"\nname = "\u571f"\n', encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "exudyn_crawler", "info", "own.toml"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONIOENCODING": "cp1252"},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"\\u571f" in done.stdout


INTERRUPTED = "error: interrupted; run the same command again to continue\n"
EARLY = """
import sys
class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[1]:
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupting())
from exudyn_crawler.__main__ import main
main()
"""


@pytest.mark.parametrize("module", ["typer", "exudyn_crawler.cli.commands"])
def test_an_interrupt_while_the_command_loads_is_told_in_a_line(module):
    line = [sys.executable, "-c", EARLY, module]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, INTERRUPTED)


def test_a_reader_of_the_package_as_a_command_who_has_had_enough_is_no_error():
    line = f"{sys.executable} -m exudyn_crawler info stress | head -1"
    done = subprocess.run(line, shell=True, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("stress: 0 of ")
    assert done.stderr == ""


def test_info_marks_what_differs_from_the_base(told, tmp_path):
    (tmp_path / "own.toml").write_text('base = "turning"\n[contact]\nstatic_friction = 0.55\n')
    out = told("info", "own.toml")
    assert "1 of " in out
    assert "values differ from the case 'turning'" in out
    row = next(line for line in out.splitlines() if "contact.static_friction" in line)
    assert "0.55" in row
    assert str(Case.turning().part(PairContact).static_friction) in row


@pytest.mark.slow
@pytest.mark.simulation
def test_stress_and_pin_forces_are_asked_of_a_run(told, refused, history, tmp_path):
    (tmp_path / "run").mkdir()
    history.save(tmp_path / "run" / "history.nc")
    out = told("node-stress", "run", "--shoe", "13", "--near", "0.2", "-0.3", "0.1")
    assert "m from the given point" in out
    assert "greatest von Mises stress" in out
    (written,) = (tmp_path / "run").glob("stress_shoe_13_node_*.csv")
    assert pd.read_csv(written)["von Mises in MPa"].gt(0.0).all()
    err = refused("node-stress", "run", "--shoe", "5", "--node", "1")
    assert "shoe must be a flexible one of the history, of [7, 13], got 5" in err
    told("pin-forces", "run/history.nc", "--shoe", "7")
    assert len(pd.read_csv(tmp_path / "run" / "pin_forces_shoe_7.csv").columns) == 25
    err = refused("pin-forces", "run", "--shoe", "7")
    assert re.search(r"pin_forces_shoe_7\.csv exists.*--overwrite", err)
    out = told("shoe-loads", "run", "--shoe", "13", "--program", "abaqus")
    (deck,) = (tmp_path / "run").glob("loads_shoe_13_0.*s_abaqus.inp")
    assert str(deck.relative_to(tmp_path)) in out
    assert "*RIGID BODY, TIE NSET=FRONT_RIGHT" in deck.read_text()
    (table,) = (tmp_path / "run").glob("loads_shoe_13_0.*s.csv")
    assert pd.read_csv(table)["kind"].iloc[-1] == "sum"
    told("shoe-loads", "run", "--shoe", "5", "--time", "0.03")
    assert "time must be given for shoe 5" in refused("shoe-loads", "run", "--shoe", "5")
    assert "shoe must be in 1..13, got 14" in refused("shoe-loads", "run", "--shoe", "14")


@pytest.mark.slow
@pytest.mark.simulation
def test_two_runs_are_compared(told, refused, translation, turning, tmp_path):
    for name, history in (("straight", translation), ("turning", turning)):
        (tmp_path / name).mkdir()
        history.save(tmp_path / name / "history.nc")
    out = told("compare", "straight", "turning")
    assert "A is straight, B is turning" in out
    assert "drive.turn_rate" in out
    assert (tmp_path / "straight_turning.html").is_file()
    assert "angular_velocity" in set(pd.read_csv(tmp_path / "straight_turning.csv")["quantity"])
    out = told("compare", "straight", "straight", "--out", "same.html")
    assert "Nothing differs in the cases." in out
    assert "Nothing that both runs have differs in the results" in out
    assert "quantity" not in out
    (tmp_path / "turning" / "stress.nc").write_bytes(b"\x89HDF\r\n\x1a\n broken")
    broken = refused("compare", "straight", "turning", "--overwrite")
    assert f"{Path('turning', 'stress.nc')} cannot be read" in broken
    assert "no folder nowhere" in refused("compare", "straight", "nowhere")


def test_a_study_of_several_runs_names_them(refused, tmp_path):
    for name in ("straight", "turning"):
        (tmp_path / "study" / name).mkdir(parents=True)
        (tmp_path / "study" / name / "history.nc").touch()
    names = "no history at study/history.nc; name one of study/straight, study/turning"
    assert names in refused("animate", "study")


def test_files_of_studies_are_started_from(told, tmp_path):
    told("init", "m113")
    case = read_case(tmp_path / "m113.toml").case
    assert (case.track.shoe_count, case.track.pitch, case.name) == (63, 0.154, "m113")
    told("init", "carrier", "--study", "m113")
    assert read_case(tmp_path / "carrier.toml").case == case.with_(name="carrier")
    told("init", "weak", "--study", "duty_scatter")
    assert read_scatter(tmp_path / "weak.toml") == read_scatter(application.study_files()["duty_scatter"])


@pytest.mark.parametrize("command", ["run", "assess", "machine", "info", "check", "shoe", "fmu", "drawbar"])
def test_a_name_of_the_library_where_a_file_is_wanted_says_how_to_begin_from_it(refused, command):
    begin = (
        "begin from it with exudyn-crawler init my_pc300lc --machine pc300lc, which writes my_pc300lc.toml"
    )
    assert f"pc300lc is a machine of the library: {begin}" in refused(command, "PC300LC")


def test_a_name_of_a_study_or_without_its_end_says_which_file_is_meant(refused, tmp_path):
    assert "exudyn-crawler init my_demo --study demo" in refused("run", "demo")
    assert "exudyn-crawler init my_scatter --study scatter" in refused("scatter", "scatter")
    assert "not a study: start from it with --machine pc300lc" in refused("init", "pc300lc")
    assert "demo is a study: --study demo" in refused("init", "mine", "--machine", "demo")
    (tmp_path / "mine.toml").touch()
    assert "there is no file mine; did you mean mine.toml?" in refused("run", "mine")


def test_init_refuses_unknown_names_with_the_known_ones(refused, tmp_path):
    known = "study must be one of closed, demo, duty, duty_scatter, forces, grounds, "
    assert known in refused("init", "m114")
    assert "got 'm114'; give 'm114' one to start from, such as --study kinematics" in refused("init", "m114")
    assert "got 'duty'" in refused("info", "duty")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.simulation
def test_a_case_is_written_changed_run_and_shown(call, told, tmp_path):
    assert "exudyn-crawler run soft.toml" in told("init", "soft", "--study", "kinematics")
    path = tmp_path / "soft.toml"
    wanted = CaseFile(case=Case.translation().with_(name="soft"), duration=10.0)
    # as read by people: digits that are rounding alone are not written
    assert case_rows(read_case(path)) == case_rows(wanted)
    text = path.read_text().replace("duration = 10.0", "duration = 0.02")
    path.write_text(text.replace('spring_stiffness = "20 MN/m"', 'spring_stiffness = "10 MN/m"'))

    code, out, err = call("run", "soft.toml", "--no-page")
    # a machine that needs more than ten seconds says how far it is
    assert (code, [line for line in err.splitlines() if not line.startswith("soft: ")]) == (0, [])
    assert "results/soft" in out
    history = History.load(tmp_path / "results" / "soft" / "history.nc")
    assert history.case.terrain.heave_stiffness == 20e6
    assert history.duration == pytest.approx(0.02, rel=1e-9)

    out = told("info", "results/soft/case.toml")
    for words in ("terrain.spring_stiffness", "10 MN/m", "stiffness of each spring", "simulated time"):
        assert words in out


@pytest.mark.parametrize(
    ("study", "duration"),
    [
        *[("kinematics", 10.0), ("forces", 10.0), ("stress", 40.0), ("uneven", 10.0), ("rollers", 10.0)],
        *[("demo", 3.5), ("closed", 10.0), ("shovel", 10.0), ("grounds", 10.0)],
    ],
)
def test_every_study_has_a_case_to_start_from(told, refused, tmp_path, study, duration):
    told("init", "own", "--study", study)
    found = read_case(tmp_path / "own.toml")
    assert (found.case.name, found.duration) == ("own", duration)
    assert (found.case.flexible is not None) == (study in ("stress", "demo"))
    assert found.case.terrain.is_even == (study != "uneven")
    told("info", study)
    assert "own.toml exists" in refused("init", "own", "--study", study)
    # the name of a study alone means its case
    told("init", study)
    assert read_case(tmp_path / f"{study}.toml") == found.with_({"name": study})


@pytest.mark.simulation
def test_a_run_takes_a_history_that_fits_and_no_other(call, refused, short, tmp_path):
    assert call("run", short, "--out", "first", "--no-page")[0] == 0
    code, out, _ = call("run", short, "--out", "second", "--reuse", "first", "--no-page")
    assert code == 0
    assert "reusing the history in first" in out
    first, second = (History.load(tmp_path / name / "history.nc") for name in ("first", "second"))
    assert first.dataset.identical(second.dataset)
    short.write_text(short.read_text() + "[contact]\nstiffness = 2e8\n")
    err = refused("run", short, "--out", "third", "--reuse", "first")
    assert "contact.stiffness is 100 MN/m^exponent, not 200 MN/m^exponent" in err
    assert not (tmp_path / "third").exists()


@pytest.mark.simulation
@pytest.mark.slow
def test_a_track_of_another_length_has_all_figures(call, tmp_path):
    (tmp_path / "case.toml").write_text(
        'base = "translation"\nduration = 0.01\n[track]\nshoe_count = 3\n'
        '[[loads.phases]]\nname = "constant"\nend = 0\nloads = [4e5, 4e5, 4e5]\n'
        '[outputs]\nfigure_format = "svg"\n'
    )
    assert call("run", "case.toml", "--out", "out")[0] == 0
    assert len(list((tmp_path / "out").glob("*.svg"))) == 14
    assert (tmp_path / "out" / "report.html").stat().st_size > 1e6
    assert "report.html" in json.loads((tmp_path / "out" / "run.json").read_text())["files"]
    table = pd.read_csv(tmp_path / "out" / "extremes.csv").set_index(["variable", "axis"])
    load = table.loc[("shoe_load", float("nan"))]
    assert (load["least"], load["greatest"], load["unit"]) == (4e5, 4e5, "N")
    loads = pd.read_csv(tmp_path / "out" / "loads.csv")
    assert loads["shoe"].tolist() == ["1", "2", "3", "sum"]
    assert list(loads.columns[1:]) == ["begin (0 s) in N", "constant (0.01 s) in N"]


@pytest.mark.simulation
def test_a_run_that_stops_early_keeps_what_there_is(refused, tmp_path):
    # two iterations that may not cut the step: enough while the track creeps, not when it slips
    (tmp_path / "case.toml").write_text(
        'base = "translation"\n[solver]\nmaximum_iterations = 2\nminimum_step = 1.5e-3\n'
    )
    err = refused("run", "case.toml", "--out", "out", code=3)
    assert err.startswith("error: the simulation stopped at t = ")
    assert "what was computed is in its folder" in err
    history = History.load(tmp_path / "out" / "history_stopped.nc")
    assert 0.0 < history.duration < 10.0
    assert not (tmp_path / "out" / "history.nc").exists()


DURATION = "error: Invalid value for '--duration': duration must be positive and finite, got"


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("run nowhere.toml", "there is no case file nowhere.toml"),
        ("info nowhere.toml", "there is no case file nowhere.toml"),
        ("run .", ". is a folder, not a case file"),
        ("life .", ". is a folder, not a duty file"),
        ("info stres", "case must be a case file or a study of ['closed', 'demo', 'forces', "),
        ("studies kinematics --duration -1", f"{DURATION} -1.0 s"),
        ("studies kinematics --duration 0", f"{DURATION} 0.0 s"),
        ("studies kinematics --duration nan", f"{DURATION} nan s"),
        ("studies kinematics --duration 1000", "error: terrain must carry the track"),
        ("studies kinematics --duration soon", "Invalid value for '--duration'"),
        ("studies kinematics --case sideways", "'sideways'"),
        ("studies forces --reuse nowhere --duration 1", "no history at nowhere/history.nc"),
        ("studies stress --mesh lost", "no mesh file lost"),
        ("studies stress --modes loud", "modes must be like"),
        ("studies stress --cycle nowhere.toml", "no load cycle nowhere.toml"),
        ("studies stress --duration 0", f"{DURATION} 0.0 s"),
        ("studies uneven hill", "'hill'"),
        ("studies uneven ramp --duration nan", f"{DURATION} nan s"),
        ("report nowhere", "no folder nowhere"),
        ("animate nowhere.nc", "no history at nowhere.nc"),
        ("init", "Missing argument 'NAME'"),
        ("init own --study opera", "study must be one of closed, demo, duty, "),
        ("init nowhere/closed", "nowhere/closed.toml"),
        ("run a.toml --out ''", "no value may be empty, got ['run', 'a.toml', '--out', '']"),
        ("studies stress --out=", "no value may be empty, got ['stress', '--out=']"),
        ("run ''", "no value may be empty, got ['run', '']"),
        ("sing", "No such command 'sing'"),
        ("run a.toml --fast", "No such option"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(refused, tmp_path, line, words):
    assert words in refused(*shlex.split(line))
    assert list(tmp_path.iterdir()) == []


def test_a_bad_case_file_is_a_line_a_fault(call, tmp_path):
    (tmp_path / "case.toml").write_text('base = "translation"\n[shoe]\nmas = 1\nwidth = "wide"\n')
    code, _, err = call("run", "case.toml")
    assert code == 2
    assert err.splitlines() == [
        "error: case.toml: shoe.width: must be a number in m, or such as '1 mm', got 'wide'",
        "error: case.toml: shoe.mas: unknown key; did you mean shoe.mass?",
    ]
    assert not (tmp_path / "results").exists()


@pytest.mark.simulation
@pytest.mark.slow
def test_overwriting_a_run_removes_report_and_films_of_the_earlier_one(call, short, tmp_path):
    out = tmp_path / "out"
    assert call("run", short, "--out", "out", "--set", "animation=true")[0] == 0
    with closing(imageio_ffmpeg.read_frames(str(out / "track.mp4"))) as film:
        assert next(film)["size"][0] > 100
    assert call("animate", "out", "--out", "out/track.gif")[0] == 0
    (out / "notes.html").write_text("mine")
    record = json.loads((out / "run.json").read_text())
    assert record["status"] == "done"
    assert {"report.html", "track.gif", "track.mp4", "history.nc"} <= set(record["files"])
    assert call("run", short, "--out", "out", "--overwrite", "--no-page")[0] == 0
    left = {path.name for path in out.iterdir()}
    assert not {"report.html", "track.gif", "track.mp4"} & left
    assert {"notes.html", "history.nc"} <= left


def test_a_traceback_is_for_debugging(call):
    assert "Traceback" not in call("run", "nowhere.toml")[2]
    code, _, err = call("run", "nowhere.toml", "--debug")
    assert code == 2
    assert err.startswith("Traceback")
    assert err.endswith("error: there is no case file nowhere.toml\n")


def of_an_interrupt():
    """What a library has made of an interrupt."""
    error = ValueError("no history")
    error.__cause__ = SystemError("returned a result with an exception set")
    error.__cause__.__context__ = KeyboardInterrupt()
    return error


UNEXPECTED = "error: ZeroDivisionError: division by zero (unexpected; --debug shows where)\n"


@pytest.mark.parametrize("function", ["studies.kinematics.study", "typer.core.TyperGroup.get_command"])
@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (of_an_interrupt(), 130, INTERRUPTED),
        (ZeroDivisionError("division by\nzero"), 1, UNEXPECTED),
        (OSError("disk is full"), 1, "error: disk is full\n"),
        (KeyboardInterrupt(), 130, INTERRUPTED),
    ],
)
def test_all_else_is_one_line_too(call, monkeypatch, function, error, code, line):
    monkeypatch.setattr(function, Mock(side_effect=error))
    assert call("studies", "kinematics") == (code, "", line)


@pytest.mark.filterwarnings("default::exudyn_crawler.errors.ImplausibleWarning")
def test_what_no_machine_has_is_told_in_one_line_before_a_run(call, tmp_path):
    (tmp_path / "kn.toml").write_text('base = "translation"\ngravity = 1.62\n')
    code, out, err = call("info", "kn.toml")
    assert (code, err) == (0, "warning: gravity: 1.62 m/s2 is outside of 9.7 to 9.9 m/s2\n")
    assert "gravity" in out


def test_info_says_what_rigid_and_flexible_shoes_weigh(told, tmp_path):
    (tmp_path / "own.toml").write_text('base = "stress"\n[flexible]\nmesh = "coarse"\n')
    out = " ".join(told("info", "own.toml").split())
    assert "rigid ones weigh 4.49 t each, flexible ones 4.503 t (+0.3 %)" in out


def test_a_value_can_be_set_on_the_command_line(told, refused, short):
    out = told("info", short, "--set", "terrain.spring_stiffness=1e7", "--set", "sharing=area")
    assert "terrain.spring_stiffness │ 10 MN/m" in " ".join(out.split())
    assert "contact.sharing │ area" in " ".join(out.split())
    err = refused("run", short, "--set", "terrain.spring_stifness=1e7")
    assert "unknown key; did you mean terrain.spring_stiffness?" in err
    assert "--set must go with a case file" in refused("info", "kinematics", "--set", "duration=1")


SWEEP = """
[case]
base = "translation"
duration = 0.02
[[answers]]
quantity = "joint_force"
[[vary]]
key = "terrain.spring_stiffness"
low = 1e7
high = 3e7
count = 3
"""
"""Sweep file of three short runs."""


@pytest.fixture
def soils(tmp_path):
    path = tmp_path / "soils.toml"
    path.write_text(SWEEP)
    return path


def test_a_dry_run_of_a_sweep_shows_its_runs_and_leaves_nothing(told, soils, tmp_path):
    out = told("sweep", soils.name, "--dry-run", "--workers", 2)
    assert "3 runs; spring_stiffness" in out
    assert "MN/m" in out
    assert "3 runs: 0 done, 3 to run\n3 runs of about " in out
    assert {path.name for path in tmp_path.iterdir()} == {"soils.toml"}


@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        (("spring_stiffness", "spring_stifness"), (), "terrain.spring_stifness: unknown key; did you mean"),
        (("count = 3", "runs = 3"), (), "vary[0].runs: unknown key"),
        (("", ""), ("--scheduler", "none.json"), "the scheduler none.json does not answer"),
        (("", ""), ("--scheduler", "a.json", "--workers", "2"), "--workers must be left out with"),
    ],
)
def test_what_is_wrong_with_a_sweep_is_told_in_a_line(refused, soils, change, options, words):
    soils.write_text(SWEEP.replace(*change))
    assert words in refused("sweep", soils.name, *options)


def test_a_unit_of_co_simulation_is_written_once(told, refused):
    told("init", "mine", "--study", "demo")
    assert told("fmu", "mine.toml").startswith("mine.fmu:")
    assert zipfile.is_zipfile("mine.fmu")
    assert "mine.fmu" in refused("fmu", "mine.toml")


@pytest.mark.filterwarnings("default::exudyn_crawler.errors.ImplausibleWarning")
def test_a_unit_of_a_case_that_there_is_none_of_is_written_with_a_warning(call, tmp_path):
    (tmp_path / "mine.toml").write_text('base = "rolled"\nduration = 1.0\n[gear]\nstiffness = 1e6\n')
    code, out, err = call("fmu", "mine.toml")
    assert (code, out[:8]) == (0, "mine.fmu")
    assert err.startswith("warning: gear.stiffness: ")


def test_a_package_that_is_not_installed_is_told_of_with_what_installs_it(refused, tmp_path, monkeypatch):
    (tmp_path / "mine.step").write_text("ISO-10303-21;")
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "netgen", None)
        words = "a STEP file needs netgen, which is not installed: pip install netgen-mesher"
        assert words in refused("shoe", "mine.step")
    for package, extra in (("pythonfmu", "[fmu]"), ("salib", "[sweep]"), ("meshio", "")):
        monkeypatch.setitem(sys.modules, package, None)
        missing = ModuleNotFoundError(f"No module named '{package}.some'", name=f"{package}.some")
        lines, code = application._lines(missing)
        assert code == application.BAD_INPUT
        assert lines == [f'the package {package} is not installed: pip install "exudyn-crawler{extra}"']
    # a module that an installed package should have is a fault of the program
    lines, code = application._lines(ModuleNotFoundError("No module named 'fem.gone'", name="fem.gone"))
    assert (code, lines[0][-31:]) == (application.OTHER, "(unexpected; --debug shows where)"[-31:])


WITHOUT = """
import importlib.metadata, re, runpy, sys
from importlib.machinery import PathFinder
words = importlib.metadata.requires("exudyn-crawler")
of_extras = [word for word in words if re.search("extra == .(app|fmu|report|sweep)", word)]
extras = {re.match("[A-Za-z0-9-]+", word)[0].lower() for word in of_extras}
homes = importlib.metadata.packages_distributions()
hidden = {module for module, packages in homes.items() if extras & {package.lower() for package in packages}}
assert {"nicegui", "distributed", "SALib", "pythonfmu", "typst"} <= hidden
class Without(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        return None if name.partition(".")[0] in hidden else super().find_spec(name, path, target)
sys.meta_path[sys.meta_path.index(PathFinder)] = Without
runpy.run_module(sys.argv.pop(1), run_name="__main__", alter_sys=True)
"""
OURS, STUDIES = "exudyn_crawler", "studies"


def without_extras(program, line, folder):
    """Run a command where the modules of all extras cannot be found."""
    words = [sys.executable, "-c", WITHOUT, program, *line.split()]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("program", "line", "extra"),
    [
        (OURS, "app . --no-browser", "app"),
        (OURS, "sweep sweep.toml --dry-run", "sweep"),
        (OURS, "scatter sweep.toml --dry-run", "sweep"),
        (STUDIES, "plate-sweep --workers 1", "sweep"),
        (OURS, "fmu mine.toml", "fmu"),
        (OURS, "report . --pdf", "report"),
    ],
)
def test_without_all_extras_a_command_that_needs_one_names_it(tmp_path, program, line, extra):
    for name in ("sweep.toml", "mine.toml", "history.nc"):
        (tmp_path / name).touch()
    done = without_extras(program, line, tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith(f', of the extra {extra!r}: pip install "exudyn-crawler[{extra}]"\n')
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    "line", ["--help", "machines", "info stress", "init my --machine pc300lc", "life --help"]
)
def test_without_all_extras_other_commands_work(tmp_path, line):
    done = without_extras(OURS, line, tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_shoe_that_has_an_ending_for_its_name_is_refused(refused, tmp_path):
    (tmp_path / ".step").write_text("ISO-10303-21;")
    for command in ("shoe", "check"):
        assert "must have a name before its ending, such as shoe.step" in refused(command, ".step")


def test_the_rest_before_a_run_tells_its_progress_in_a_folder_that_is_there(refused, tmp_path, monkeypatch):
    def stopped(_case):
        raise ValueError(f"noted in {[path.parent.name for path in progress._noting]}")

    monkeypatch.setattr(commands, "show_standing", stopped)
    (tmp_path / "mine.toml").write_text('base = "translation"\n')
    assert "noted in []" in refused("run", "mine.toml", "--out", "later")
    (tmp_path / "there").mkdir()
    assert "noted in ['there']" in refused("run", "mine.toml", "--out", "there")
    assert progress._noting == []
