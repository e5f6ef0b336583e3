"""A run in stages: no jump between them, and a killed run gives the numbers of one that was not."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from itertools import product

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from exudyn_crawler import Case, Drive, SphereContact, simulate
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.model.state import VERSION
from exudyn_crawler.run.folder.checkpoints import Checkpoints
from exudyn_crawler.run.solve.stages import stage_times
from tests.rolled import small_case
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

INTERVAL = 0.05
SCRIPT = """
import sys
from exudyn_crawler import Case, simulate
from exudyn_crawler.run.folder.checkpoints import Checkpoints

case = Case.model_validate_json(sys.argv[1])
simulate(case, 60.0, checkpoints=Checkpoints(sys.argv[2]))
"""


def staged(interval=INTERVAL):
    return Case.translation().with_({"solver.checkpoint_interval": interval})


def test_stages_end_at_multiples_where_the_drive_goes_off_and_at_the_end():
    case = staged(0.5)
    assert stage_times(case, 1.2) == [0.0, 0.5, 1.0, 1.2]
    off = case.with_(drive=Drive.to_rest().with_(on=((0.0, 0.7),)))
    assert stage_times(off, 1.0) == [0.0, 0.5, 0.7, 1.0]


def test_a_staged_run_is_the_unstaged_one(translation):
    """Only the algorithmic acceleration, that of a quarter of a step before, starts anew."""
    assert translation.case.solver.checkpoint_interval > translation.duration
    whole, parts = translation.dataset, simulate(staged(), translation.duration).dataset
    assert parts.time.values == pytest.approx(whole.time.values, abs=1e-12)
    for name in ("position", "velocity", "acceleration", "joint_force", "normal_force"):
        a, b = whole[name].values, parts[name].values
        assert np.sqrt(np.mean((a - b) ** 2)) < 1e-3 * np.sqrt(np.mean(a**2)), name


def test_a_killed_run_goes_on_and_gives_the_same_numbers(tmp_path):
    case = staged()
    arguments = [sys.executable, "-c", SCRIPT, case.model_dump_json(), str(tmp_path)]
    process = subprocess.Popen(arguments, env=os.environ | {"PYTHONWARNINGS": "ignore"})
    deadline = time.monotonic() + 120.0
    while len(list(tmp_path.glob("checkpoints/stage_*.npz"))) < 3 and time.monotonic() < deadline:
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = len(Checkpoints(tmp_path).load(case))
    assert kept >= 3
    duration = (kept + 1.5) * INTERVAL
    resumed = simulate(case, duration, checkpoints=Checkpoints(tmp_path))
    assert resumed.dataset.identical(simulate(case, duration).dataset)


def flexible():
    return Case.stress(SMALL_SHOE).with_({"flexible.shoes": (7, 13), "flexible.fixed_modes": 4})


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(
            lambda: Case.translation().with_(contact=SphereContact.oil_sand()),
            id="spheres",
            marks=pytest.mark.slow,
        ),
        pytest.param(Case.turning, id="turning"),
        # each has what two others have between them
        pytest.param(flexible, id="flexible", marks=pytest.mark.slow),
        pytest.param(lambda: flexible().with_(formulation="engine"), id="engine", marks=pytest.mark.slow),
        pytest.param(
            lambda: Case.translation().on_cells(BekkerSoil.lete_sand()), id="cells", marks=pytest.mark.slow
        ),
        pytest.param(
            lambda: flexible().on_cells(BekkerSoil.lete_sand()),
            id="flexible on cells",
            marks=pytest.mark.slow,
        ),
        pytest.param(lambda: small_case().on_cells(BekkerSoil.lete_sand()), id="rolled on cells"),
    ],
)
def test_a_run_that_goes_on_from_checkpoints_gives_the_same_numbers(tmp_path, case):
    case = case().with_({"solver.checkpoint_interval": INTERVAL / 5})
    # of ground that remembers: in a stage that is there, at the end of it, and in one that is computed anew
    times = tuple(share * INTERVAL / 5 for share in (0.5, 1.0, 1.5))
    whole = simulate(case, 3 * INTERVAL / 5, None, Checkpoints(tmp_path), times)
    (tmp_path / "checkpoints" / "stage_0001.npz").unlink()
    resumed = simulate(case, 3 * INTERVAL / 5, None, Checkpoints(tmp_path), times)
    assert resumed.dataset.identical(whole.dataset)
    assert whole.has("cell_sinkage_then") == (case.terrain.model == "cells")


@pytest.fixture(scope="module")
def three_stages(tmp_path_factory):
    """Folder of the checkpoints of a run of three stages, and its history."""
    folder = tmp_path_factory.mktemp("checkpoints")
    return folder, simulate(staged(), 3 * INTERVAL, checkpoints=Checkpoints(folder)).dataset


@pytest.fixture
def copied(three_stages, tmp_path):
    folder = tmp_path / "copied"
    shutil.copytree(three_stages[0], folder)
    return folder


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_checkpoints_of_other_parameters_are_refused(copied):
    with pytest.raises(ValueError, match="belongs to another case"):
        simulate(staged().with_(gravity=9.0), 2 * INTERVAL, checkpoints=Checkpoints(copied))


def flipped(path, array):
    """Flip a bit in the middle of an array of a file, or in the shape that it states."""
    content = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        start = content.index(b"\x93NUMPY", archive.getinfo(f"{array}.npy").header_offset)
        content[start + archive.getinfo(f"{array}.npy").file_size // 2] ^= 1
    path.write_bytes(content)


def emptied(path, array):
    """Remove an array from a file."""
    arrays = dict(np.load(path))
    del arrays[array]
    np.savez(path, **arrays)


@pytest.mark.parametrize(
    ("change", "array"),
    [
        *product([flipped], ["state", "history position", "time", "layout"]),
        *product([emptied], ["state", "history position"]),
    ],
)
def test_an_altered_checkpoint_is_computed_anew_from_the_last_good_one(three_stages, copied, change, array):
    said = []
    path = copied / "checkpoints" / "stage_0001.npz"
    change(path, array)
    resumed = simulate(staged(), 3 * INTERVAL, checkpoints=Checkpoints(copied, said.append))
    assert resumed.dataset.identical(three_stages[1])
    assert said[0].startswith(f"checkpoint {path} cannot be read: ")
    assert "removed, computing again" in said[0]
    assert said[-1].endswith(f"going on from the checkpoint at t = {INTERVAL:g} s")
    assert len(Checkpoints(copied).load(staged())) == 2


def test_an_altered_first_checkpoint_is_refused_by_name(copied):
    path = copied / "checkpoints" / "stage_0000.npz"
    whole = path.read_bytes()
    flipped(path, "state")
    for content in (path.read_bytes(), b"PK\x03\x04 broken", b"", whole[:-100]):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"stage_0000\.npz cannot be read: .*to start again"):
            Checkpoints(copied).load(staged())


@given(st.data())
@settings(deadline=None, max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_checkpoint_with_flipped_bytes_gives_the_same_or_is_refused(three_stages, copied, data):
    content = bytearray((three_stages[0] / "checkpoints" / "stage_0000.npz").read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    (copied / "checkpoints" / "stage_0000.npz").write_bytes(content)
    message = ""
    try:
        state = Checkpoints(copied).load(staged())[0].read().state
    except ValueError as error:
        message = str(error)
    assert not message or message.startswith(f"checkpoint {copied / 'checkpoints' / 'stage_0000.npz'} ")
    assert message or state.tobytes() == Checkpoints(three_stages[0]).load(staged())[0].read().state.tobytes()


def test_a_checkpoint_in_the_place_of_another_is_left_out(copied):
    shutil.copy(copied / "checkpoints" / "stage_0000.npz", copied / "checkpoints" / "stage_0001.npz")
    said = []
    assert len(Checkpoints(copied, said.append).load(staged())) == 1
    assert "stage_0001.npz belongs to stage 0: removed" in said[0]


def test_states_of_another_layout_are_refused_by_name(copied):
    """Same parameters, but a program that lays its states out otherwise."""
    with np.load(copied / "checkpoints" / "stage_0000.npz") as kept:
        assert kept["time"] == pytest.approx(INTERVAL)
        layout = str(kept["layout"])
    for change in ({"terrain": 16}, {"version": VERSION + 1}):
        other = json.dumps(json.loads(layout) | change)
        told = r"stage_0000\.npz has states of another layout; delete .*checkpo"
        with pytest.raises(ValueError, match=told):
            Checkpoints(copied).load(staged(), other)


@pytest.mark.slow
def test_a_longer_run_on_cells_goes_on_behind_one_of_two_stages(tmp_path):
    case = staged(INTERVAL / 5).on_cells(BekkerSoil.lete_sand())
    checkpoints = Checkpoints(tmp_path)
    times = tuple(share * INTERVAL / 5 for share in (0.5, 1.2, 2.0))
    simulate(case, 1.5 * INTERVAL / 5, None, checkpoints, times)
    checkpoints.hand_over(tmp_path / "history.nc")
    checkpoints.settle(case)
    longer = simulate(case, 2.5 * INTERVAL / 5, None, checkpoints, times)
    # cells and what they remember among all else, also at times of the shorter run's end
    assert longer.cell_sinkage.size > 0
    assert longer.ground_time.values == pytest.approx(times, abs=case.solver.step)
    assert longer.dataset.identical(simulate(case, 2.5 * INTERVAL / 5, ground_times=times).dataset)


def test_an_altered_checkpoint_of_a_run_that_has_ended_is_refused_by_a_longer_one(copied):
    Checkpoints(copied).hand_over(copied / "history.nc")
    Checkpoints(copied).settle(staged())
    assert {path.name for path in copied.iterdir()} == {"history.nc", "checkpoint.npz"}
    assert float(np.load(copied / "checkpoint.npz")["time"]) == pytest.approx(2 * INTERVAL)
    flipped(copied / "checkpoint.npz", "state")
    told = r"checkpoint\.npz cannot be read: .*delete .*checkpoint\.npz to start"
    with pytest.raises(ValueError, match=told):
        simulate(staged(), 4.5 * INTERVAL, checkpoints=Checkpoints(copied))
