"""A run in stages: no jump between them, and a killed run gives the numbers of one that was not."""

import dataclasses
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, SphereContact, simulate
from exudyn_crawler.run.checkpoints import Checkpoints
from exudyn_crawler.run.stages import stage_times

pytestmark = pytest.mark.simulation

INTERVAL = 0.05
SCRIPT = """
import sys
from exudyn_crawler import Case, simulate
from exudyn_crawler.run.checkpoints import Checkpoints

case = Case.model_validate_json(sys.argv[1])
simulate(case, 60.0, checkpoints=Checkpoints(sys.argv[2]))
"""


def staged(interval=INTERVAL):
    case = Case.translation()
    return case.with_(solver=case.solver.with_(checkpoint_interval=interval))


def test_stages_end_at_multiples_where_the_drive_goes_off_and_at_the_end():
    case = staged(0.5)
    assert stage_times(case, 1.2) == [0.0, 0.5, 1.0, 1.2]
    off = case.with_(drive=Drive.to_rest().with_(on=((0.0, 0.7),)))
    assert stage_times(off, 1.0) == [0.0, 0.5, 0.7, 1.0]


def test_a_staged_run_is_the_unstaged_one():
    """Only the algorithmic acceleration, that of a quarter of a step before, starts anew."""
    whole = simulate(staged(10.0), 0.4).dataset
    parts = simulate(staged(), 0.4).dataset
    assert parts.time.values == pytest.approx(whole.time.values, abs=1e-12)
    for name in ("position", "velocity", "acceleration", "joint_force", "normal_force"):
        a, b = whole[name].values, parts[name].values
        assert np.sqrt(np.mean((a - b) ** 2)) < 1e-3 * np.sqrt(np.mean(a**2)), name


def test_a_killed_run_goes_on_and_gives_the_same_numbers(tmp_path):
    case = staged()
    arguments = [sys.executable, "-c", SCRIPT, case.model_dump_json(), str(tmp_path)]
    process = subprocess.Popen(arguments, env=os.environ | {"PYTHONWARNINGS": "ignore"})
    deadline = time.monotonic() + 120.0
    while len(list(tmp_path.glob("stage_*.npz"))) < 3 and time.monotonic() < deadline:
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = len(Checkpoints(tmp_path).load(case))
    assert kept >= 3
    duration = (kept + 1.5) * INTERVAL
    resumed = simulate(case, duration, checkpoints=Checkpoints(tmp_path))
    straight = simulate(case, duration)
    assert resumed.dataset.identical(straight.dataset)


def test_the_second_contact_model_goes_on_from_checkpoints_too(tmp_path):
    case = staged().with_(contact=SphereContact.oil_sand())
    whole = simulate(case, 3 * INTERVAL, checkpoints=Checkpoints(tmp_path))
    (tmp_path / "stage_0001.npz").unlink()
    resumed = simulate(case, 3 * INTERVAL, checkpoints=Checkpoints(tmp_path))
    assert resumed.dataset.identical(whole.dataset)


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_checkpoints_of_other_parameters_are_refused(tmp_path):
    case = staged()
    simulate(case, 2 * INTERVAL, checkpoints=Checkpoints(tmp_path))
    other = case.with_(gravity=9.0)
    with pytest.raises(ValueError, match="other parameters"):
        simulate(other, 2 * INTERVAL, checkpoints=Checkpoints(tmp_path))


def test_a_broken_checkpoint_is_named(tmp_path):
    case = staged()
    simulate(case, 2 * INTERVAL, checkpoints=Checkpoints(tmp_path))
    (tmp_path / "stage_0000.npz").write_bytes(b"PK\x03\x04 broken")
    with pytest.raises(ValueError, match=r"stage_0000\.npz cannot be read"):
        Checkpoints(tmp_path).load(case)


def test_states_of_another_layout_are_refused_by_name(tmp_path):
    """Same parameters, but a program that lays its states out otherwise."""
    case = staged()
    simulate(case, 2 * INTERVAL, checkpoints=Checkpoints(tmp_path))
    (kept,) = Checkpoints(tmp_path).load(case)
    assert kept.time == pytest.approx(INTERVAL)
    other = dataclasses.replace(kept.layout, terrain=kept.layout.terrain + 1)
    with pytest.raises(
        ValueError, match=r"stage_0000\.npz has states of another layout: terrain is 15, not 16"
    ):
        Checkpoints(tmp_path).load(case, other)


def test_a_checkpoint_without_a_layout_or_of_another_version_is_refused(tmp_path):
    case = staged()
    simulate(case, 2 * INTERVAL, checkpoints=Checkpoints(tmp_path))
    path = tmp_path / "stage_0000.npz"
    content = dict(np.load(path))
    newer = str(content["layout"]).replace('"version": 2', '"version": 7')
    np.savez(path, **(content | {"layout": np.array(newer)}))
    with pytest.raises(ValueError, match=r"cannot be read: .*its version is 7, not 2; delete it to go on"):
        Checkpoints(tmp_path).load(case)
    del content["layout"]
    np.savez(path, **content)
    with pytest.raises(ValueError, match=r"cannot be read: .*layout.*; delete it to go on"):
        Checkpoints(tmp_path).load(case)


def test_checkpoints_can_be_removed(tmp_path):
    checkpoints = Checkpoints(tmp_path / "checkpoints")
    simulate(staged(), 2 * INTERVAL, checkpoints=checkpoints)
    assert len(checkpoints.load(staged())) == 1
    checkpoints.remove()
    assert not (tmp_path / "checkpoints").exists()
