"""What goes wrong around a run: bad files and values, full disks, folders that cannot be written, kills."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import time

import pytest
import tomlkit
from hypothesis import HealthCheck, example, given, settings, strategies as st

from exudyn_crawler import Case, History, LoadCycle, run_case, simulate
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.machines import CaseFile, read_case
from exudyn_crawler.machines.case_file import Outputs, case_text
from fem.files.hdf5 import HEAD, HEAP
from studies.stress import study as stress_study
from tests.case.strategies import TOML
from tests.small_shoe import SMALL_SHOE

SAME_FOLDER = settings(
    deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
SHORT = 'base = "translation"\nduration = 0.05\n[outputs]\nfigures = false\n'
VALID = case_text(CaseFile(case=Case.turning()))
SEED = 20160316
NUMBERS = ("0", "-1", "1e300", "-1e300", "1e-300", "nan", "inf", "99999999999999999999")
ODD = (*NUMBERS, "true", '""', "[]", "{}", "x")
PROGRESS = re.compile(r"^(compiling .*|.*: \d+ s so far.*)\n", re.MULTILINE)
LONGEST = 120.0
"""s, after which a change hangs: 300 of them take about two minutes."""
FACTORS = (0.0, 1e-6, 1e-3, 0.5, 0.9, 1.1, 2.0, 1e3, 1e6, -1.0)


def kill_when(ready, line, cwd, patience=60.0):
    """Start a process and kill it as soon as it has come so far."""
    with subprocess.Popen(line, cwd=cwd) as run:
        try:
            end = time.monotonic() + patience
            while not ready():
                assert time.monotonic() < end
                assert run.poll() is None
                time.sleep(0.02)
        finally:
            run.send_signal(signal.SIGKILL)


def read_or_refused(path):
    """A file is either a case or refused in lines that name it; anything else is raised."""
    refusal = None
    try:
        return read_case(path)
    except CaseFileError as error:
        refusal = error
    assert refusal.errors
    assert str(refusal).splitlines() == [f"{path}: {fault}" for fault in refusal.errors]
    return None


@pytest.mark.simulation
@SAME_FOLDER
@given(content=TOML, head=st.sampled_from(["", 'base = "translation"\n', 'base = "turning"\n']))
@example(content={"loads": {"phases": {}}}, head='base = "translation"\n')
def test_any_table_is_a_case_or_refused(tmp_path, content, head):
    path = tmp_path / "case.toml"
    if head:
        content.pop("base", None)
    path.write_text(head + tomlkit.dumps(content), encoding="utf-8")
    read_or_refused(path)


@SAME_FOLDER
@given(st.binary(max_size=200) | st.text(st.characters(exclude_categories=["Cs"])).map(str.encode))
def test_any_bytes_are_a_case_or_refused(tmp_path, content):
    path = tmp_path / "case.toml"
    path.write_bytes(content)
    assert read_or_refused(path) is None


@pytest.mark.simulation
@SAME_FOLDER
@given(st.data())
def test_a_mangled_case_file_is_a_case_or_refused(tmp_path, data):
    path = tmp_path / "case.toml"
    start = data.draw(st.integers(0, len(VALID)))
    end = data.draw(st.integers(start, min(len(VALID), start + 40)))
    new = data.draw(
        st.sampled_from(["", "1", "-1", "0", "nan", "1e300", "-1e-300", '"', "[", "{}", "9" * 5000])
    )
    path.write_text(VALID[:start] + new + VALID[end:], encoding="utf-8")
    read_or_refused(path)


@pytest.mark.parametrize("text", ["a = ", 'base = "x"', "[shoe]\nmass = {}", "a = 0x" + "f" * 9999])
def test_a_bad_case_file_never_shows_a_traceback(tmp_path, call, text):
    (tmp_path / "case.toml").write_text(text)
    code, _, err = call("run", "case.toml")
    assert code == 2
    told = err.splitlines()
    assert told
    assert all(line.startswith("error: case.toml: ") for line in told)


FULL_DISK = """
import resource, signal, sys
import matplotlib.font_manager  # keeps a cache, which has to be there
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)),) * 2)
from exudyn_crawler.__main__ import main
main()
"""


@pytest.mark.simulation
@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process are those of Unix")
@pytest.mark.parametrize(
    "limit", [pytest.param(100, marks=pytest.mark.slow), 1000, pytest.param(100_000, marks=pytest.mark.slow)]
)
def test_a_file_that_finds_no_room_is_one_line_and_leaves_nothing_half(tmp_path, limit):
    (tmp_path / "case.toml").write_text(SHORT)
    line = [sys.executable, "-c", FULL_DISK, str(limit), "run", "case.toml", "--out", "out"]
    done = subprocess.run(line, capture_output=True, text=True, cwd=tmp_path, timeout=120, check=False)
    assert done.returncode == 1, done.stderr
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    assert "could not be written: File too large" in done.stderr
    names = {path.name for path in (tmp_path / "out").rglob("*")}
    assert names <= {".lock", "case.toml", "run.json", "run.log", "checkpoints"}
    if "case.toml" in names:
        assert read_case(tmp_path / "out" / "case.toml").duration == 0.05


@pytest.mark.parametrize("place", ["file", "file/below", "/proc/nowhere"])
def test_a_folder_that_cannot_be_written_is_refused_before_the_run(tmp_path, refused, place):
    if place.startswith("/proc") and not os.path.isdir("/proc/self"):
        pytest.skip("no /proc here")
    (tmp_path / "file").touch()
    (tmp_path / "case.toml").write_text(SHORT)
    for words in (("run", "case.toml"), ("studies", "kinematics", "--duration", 0.01)):
        assert refused(*words, "--out", place).startswith(f"error: output folder {place} ")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_a_killed_run_leaves_a_folder_that_the_next_one_takes_over(tmp_path, call, refused):
    (tmp_path / "case.toml").write_text(SHORT.replace("0.05", "20.0"))
    line = [sys.executable, "-m", "exudyn_crawler", "run", "case.toml", "--out", "out"]
    log = tmp_path / "out" / "run.log"
    kill_when(lambda: log.exists() and "simulate: begins" in log.read_text(), line, tmp_path)
    assert json.loads((tmp_path / "out" / "run.json").read_text())["status"] == "running"
    (tmp_path / "case.toml").write_text(SHORT)
    assert "is the case of another run" in refused("run", "case.toml", "--out", "out")
    code, _, err = call("run", "case.toml", "--out", "out", "--overwrite")
    assert code == 0, err
    assert "error" not in err  # a first run on a machine tells of compiling there
    assert History.load(tmp_path / "out" / "history.nc").duration == pytest.approx(0.05, rel=1e-9)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_a_killed_study_goes_on_too(tmp_path):
    script = (
        "import sys\nfrom pathlib import Path\n"
        "from exudyn_crawler import Case\nfrom studies.stress import study\n"
        "parts = {'solver.checkpoint_interval': 0.1, 'flexible.shoes': (13,), 'flexible.fixed_modes': 4}\n"
        "case = Case.stress('coarse').with_(parts)\n"
        "run, _ = study(Path(sys.argv[1]), case, duration=0.4, say=print)\n"
    )
    line = [sys.executable, "-c", script]
    checkpoints = tmp_path / "out" / "cycle" / "checkpoints"
    kill_when(lambda: list(checkpoints.glob("stage_*.npz")), [*line, "out"], tmp_path, patience=120.0)
    assert not (tmp_path / "out" / "cycle" / "history.nc").exists()
    told = subprocess.run([*line, "out"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert "stress: going on from the checkpoint at t = " in told
    assert json.loads((tmp_path / "out" / "run.json").read_text())["status"] == "done"
    assert (tmp_path / "out" / "comparison.csv").exists()
    subprocess.run([*line, "whole"], cwd=tmp_path, capture_output=True, check=True)
    resumed, unbroken = (
        History.load(tmp_path / name / "cycle" / "history.nc").dataset for name in ("out", "whole")
    )
    assert resumed.identical(unbroken)


@pytest.fixture(scope="module")
def short_file(tmp_path_factory):
    history = simulate(Case.translation(), 0.01)
    path = history.save(tmp_path_factory.mktemp("file") / "history.nc")
    return path.read_bytes(), path


@pytest.mark.simulation
def test_a_history_whose_heap_is_broken_is_refused_and_not_read_for_ever(tmp_path, short_file):
    """HDF5 goes round an object of no size, which the end of too small a free space looks like."""
    content = bytearray(short_file[0])
    heap = content.index(HEAP)
    place = heap + HEAD
    while content[place : place + 2] != bytes(2):
        place += HEAD + -(-int.from_bytes(content[place + 8 : place + HEAD], "little") // 8) * 8
    size = int.from_bytes(content[place + 8 : place + HEAD], "little")
    content[place + 8 : place + HEAD] = (size - 39).to_bytes(8, "little")
    path = tmp_path / "broken.nc"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=f"must hold a history: its heap at byte {heap} is broken"):
        History.load(path)


@pytest.mark.simulation
@SAME_FOLDER
@given(st.data())
def test_a_broken_history_is_refused_by_name(tmp_path, short_file, data):
    content = bytearray(short_file[0])
    if data.draw(st.booleans()):
        content = content[: data.draw(st.integers(0, len(content) - 1))]
    else:
        for _ in range(data.draw(st.integers(1, 10))):
            content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    path = tmp_path / "translation.nc"
    path.write_bytes(content)
    message = ""
    try:
        history = History.load(path)
    except ValueError as error:
        message = str(error)
    assert not message or message.startswith(f"{path} must hold a history: ")
    assert len(message.splitlines()) <= 1
    assert path.read_bytes() == content
    if not message:
        assert history.case == Case.translation()
        whole = History.load(short_file[1]).dataset
        for name in history.dataset.variables.keys() & whole.variables.keys():
            assert history.dataset[name].values.tobytes() == whole[name].values.tobytes(), name


@pytest.mark.simulation
def test_reusing_a_broken_history_is_one_line_and_runs_nothing(tmp_path, refused, short_file):
    (tmp_path / "case.toml").write_text(SHORT)
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "history.nc").write_bytes(short_file[0][:5000])
    err = refused("run", "case.toml", "--out", "out", "--reuse", "old")
    assert err.startswith("error: old/history.nc must hold a history: ")
    assert not (tmp_path / "out").exists()


def test_a_mesh_that_does_not_fit_is_refused_before_anything_is_written(tmp_path):
    case = Case.stress(SMALL_SHOE)
    off = case.with_({"track.pin_height": case.track.pin_height + 0.1})
    with pytest.raises(ValueError, match="must meet the track's pins"):
        run_case(CaseFile(case=off, duration=0.01), tmp_path / "run")
    with pytest.raises(ValueError, match="must meet the track's pins"):
        stress_study(tmp_path / "study", off, duration=0.01)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.simulation
def test_a_case_name_is_no_path_markup_or_formula(tmp_path, told):
    odd = Case.translation().with_(name=r"../[red]../x/[/] $\frac$")
    outputs = Outputs(shoes=(1,), page=False)
    run_case(CaseFile(case=odd, duration=0.01, outputs=outputs), tmp_path / "out", progress=False)
    assert {path.name for path in tmp_path.iterdir()} == {"out"}
    told("info", "out/case.toml")


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
    case = Case.stress(SMALL_SHOE).with_({"flexible.shoes": (2,), "flexible.static_fields": False})
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
        (tiny, 15),
        pytest.param(tiny, 300, marks=pytest.mark.slow),
        pytest.param(tiny_flexible, 300, marks=pytest.mark.slow),
    ],
)
@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.UnbalancedWarning")
def test_no_change_of_a_case_ends_in_a_traceback(base, count, call, tmp_path, nothing_hangs):
    dice = random.Random(SEED)
    lines = case_text(base()).splitlines()
    ends = {0: 0, 2: 0, 3: 0}
    for number in range(count):
        own = list(lines)
        for _ in range(dice.choice((1, 1, 1, 2))):
            at = dice.randrange(len(own))
            own[at] = changed_line(own[at], dice)
        (tmp_path / "case.toml").write_text("\n".join(own) + "\n", encoding="utf-8")
        nothing_hangs()
        code, _, err = call("run", "case.toml", "--out", f"run{number}")
        told = PROGRESS.sub("", err)
        what = f"change {number}: exit {code}, {told}, {set(own) - set(lines)}"
        assert code in ends, what
        ends[code] += 1
        assert "Traceback" not in told, what
        assert "unexpected" not in told, what
        assert all(line.startswith(("error: ", "warning: ")) for line in told.splitlines()), what
        assert bool(told) or code == 0, what
    # it is not the refusals alone that were tried
    assert min(ends[0], ends[2]) > count // 10, ends
