"""Short runs of the papers' cases, shared by the tests: a run costs more than what is asked of it."""

import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable, Generator
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr
from hypothesis import settings

from exudyn_crawler import Case, Duty, History, LoadCycle, Phase, simulate
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.model.exudyn import exu
from exudyn_crawler.model.reductions import VARIABLE
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import LifeResults, life_of
from tests.rolled import small_case, small_flexible_case
from tests.stress_results import WEAK, by_modes_alone, short_run, stress_results

# the same examples in every run
settings.register_profile("reproducible", derandomize=True)
settings.load_profile("reproducible")

RUNS = {
    *("translation", "phased", "turning", "constrained", "longer", "flexible_run", "reduced"),
    *("rigid_folders", "rolled", "bent", "over_sand", "ran"),
}
"""Fixtures that simulate, or reduce a shoe for a run."""


def pytest_configure(config: pytest.Config) -> None:
    """Keep reductions in a folder that all processes of this run of the tests share, and no other."""
    if not hasattr(config, "workerinput"):
        os.environ[VARIABLE] = tempfile.mkdtemp(prefix="exudyn-crawler-tests-")


def pytest_unconfigure(config: pytest.Config) -> None:
    """Remove that folder."""
    if not hasattr(config, "workerinput"):
        shutil.rmtree(os.environ[VARIABLE], ignore_errors=True)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what simulates or takes as long by its fixtures; its modules go first: processes end alike."""
    for item in items:
        if RUNS & set(getattr(item, "fixturenames", ())):
            item.add_marker("simulation")
    long = {item.path for item in items if item.get_closest_marker("simulation")}
    items.sort(key=lambda item: item.path not in long)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Keep `make check` fast: a test that simulates in this process, or whose fixtures do, has its mark."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        if not (item.get_closest_marker("simulation") or item.get_closest_marker("slow")):
            refused = "this test simulates: mark it with pytest.mark.simulation"
            for name in ("SolveDynamic", "SolveStatic"):
                monkeypatch.setattr(exu.MainSystem, name, lambda *_, **__: pytest.fail(refused))
        return (yield)


@pytest.fixture(scope="session")
def translation() -> History:
    return simulate(Case.translation(), 0.4)


@pytest.fixture(scope="session")
def phased() -> History:
    """A cycle of own phases; the third is shorter than its name, the last goes on as the run ends."""
    ends = {"propel <b>": 0.04, "first $dig": 0.08, "let the machine settle": 0.084, "swing & back": 1.0}
    loads = [386.4e3, 400e3, 390e3, 386.4e3]
    cycle = LoadCycle(
        phases=tuple(
            Phase(name=name, end=end, loads=(load,) * 13)
            for (name, end), load in zip(ends.items(), loads, strict=True)
        )
    )
    return simulate(Case.translation().with_(name="phased", loads=cycle), 0.12, progress=False)


@pytest.fixture(scope="session")
def turning() -> History:
    return simulate(Case.turning(), 0.4)


@pytest.fixture(scope="session")
def constrained() -> History:
    return simulate(Case.translation().with_(terrain_formulation="constrained"), 0.1)


@pytest.fixture(scope="session")
def longer() -> History:
    """Long enough to slip, stick and bounce."""
    return simulate(Case.translation(), 3.0)


@pytest.fixture(scope="session")
def flexible_run() -> tuple[History, xr.Dataset, dict[int, pd.DataFrame]]:
    """Two flexible shoes pulled for a moment: history, stresses at two chosen times, hot spots by shoe."""
    history = short_run(0.06)
    return history, *stress_results(history, [0.0, 0.06])


@pytest.fixture(scope="session")
def history(flexible_run: tuple[History, xr.Dataset, dict[int, pd.DataFrame]]) -> History:
    """History of that run."""
    return flexible_run[0]


@pytest.fixture(scope="session")
def stress(flexible_run: tuple[History, xr.Dataset, dict[int, pd.DataFrame]]) -> xr.Dataset:
    """Stresses of that run."""
    return flexible_run[1]


@pytest.fixture(scope="session")
def modes_alone(history: History) -> History:
    """That history, whose stresses have no static fields."""
    return by_modes_alone(history)


@pytest.fixture(scope="session")
def worn(history: History) -> LifeResults:
    """Life over that run, a tenth of all hours."""
    run = DutyRun(name="propel", folder=".", share=0.1)
    return life_of(Duty(runs=(run,), material=WEAK, plane_nodes=0, survivals=(0.9,)), [history])


@pytest.fixture(scope="session")
def rolled() -> History:
    """A fifth of a second of a side frame over rigid shoes, in which it moves by 75 mm."""
    return simulate(small_case(), 0.2, progress=False)


@pytest.fixture(scope="session")
def bent() -> History:
    """The same over two flexible shoes, shorter."""
    return simulate(small_flexible_case(), 0.06, progress=False)


@pytest.fixture(scope="session")
def over_sand() -> History:
    """The side frame over rigid shoes on LETE sand, for longer."""
    return simulate(small_case().on_cells(BekkerSoil.lete_sand()), 0.3, progress=False)


@pytest.fixture
def interruptible() -> Generator[None, None, None]:
    """A process in the background of a shell would ignore interrupts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def call(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Callable[..., tuple[object, str, str]]:
    """Call the command, or that of studies, in an empty folder: exit code, output and errors."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: object) -> tuple[object, str, str]:
        from exudyn_crawler import cli
        from studies.commands import app as studies

        of_studies = arguments[:1] == ("studies",)
        monkeypatch.setattr(sys, "argv", ["program", *map(str, arguments[of_studies:])])
        with pytest.raises(SystemExit) as end:
            cli.call(studies if of_studies else cli.app)
        told = capsys.readouterr()
        return end.value.code, told.out, told.err

    return call


@pytest.fixture
def refused(call: Callable[..., tuple[object, str, str]]) -> Callable[..., str]:
    """Call what has to end with an exit code and one line of errors: that line."""

    def refused(*arguments: object, code: int = 2) -> str:
        ended, _, err = call(*arguments)
        assert ended == code, err
        assert err.startswith("error: ")
        assert err.count("\n") == 1
        return err

    return refused


@pytest.fixture
def told(call: Callable[..., tuple[object, str, str]]) -> Callable[..., str]:
    """Call what has to succeed without an error or a warning: its output."""

    def told(*arguments: object) -> str:
        code, out, err = call(*arguments)
        assert (code, err) == (0, "")
        return out

    return told
