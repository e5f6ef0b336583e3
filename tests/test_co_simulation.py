"""A case as a unit of co-simulation: the same numbers as a plain run, late by a step of communication."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu

from exudyn_crawler import Case, CaseFile, Drive, StepProfile, simulate
from exudyn_crawler.case import MachineCycle, MachinePhase
from exudyn_crawler.co_simulation import (
    CASE,
    MachineOnTrack,
    SteppedRun,
    StepRefusedError,
    outputs,
    write_fmu,
)
from exudyn_crawler.machines import write_case
from exudyn_crawler.results.history.tension import hanging_chains
from exudyn_crawler.run.solve.standing import standing
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

WRENCH = np.array([0.0, 0.0, -5e5, 0.0, 4e5, 0.0])
SPEED, DURATION = 0.03, 0.2
RISEN = StepProfile(times=(0.0, DURATION), values=(0.0, SPEED))


@pytest.fixture(scope="module")
def loaded():
    phase = MachinePhase(name="digging", end=0.0, force=tuple(WRENCH[:3]), moment=tuple(WRENCH[3:]))
    return Case.rolled().with_(machine=MachineCycle(phases=(phase,)), drive=Drive(speed=RISEN))


@pytest.fixture(scope="module")
def plain(loaded):
    return outputs(simulate(loaded, DURATION, progress=False))


@pytest.fixture(scope="module")
def unit(loaded, tmp_path_factory):
    return write_fmu(CaseFile(case=loaded, duration=DURATION), tmp_path_factory.mktemp("unit") / "mine.fmu")


def stepped(unit, step):
    """Last outputs of a unit in a host that asks for the drive's speed at the begin of each step."""
    time = np.linspace(0.0, DURATION, round(DURATION / step) + 1)
    inputs = np.rec.fromarrays([time, RISEN.value(time)], names=["time", "speed"])
    names = [one.name for one in read_model_description(unit).modelVariables if one.causality == "output"]
    run = simulate_fmu(
        unit, stop_time=DURATION, step_size=step, output_interval=step, input=inputs, output=names
    )
    return dict(zip(names, run[-1].tolist()[1:], strict=True))


def test_a_unit_gives_the_numbers_of_a_run_late_by_a_step(unit, plain):
    coarse, fine = stepped(unit, 0.02), stepped(unit, 0.01)
    assert coarse.keys() == fine.keys() == plain.keys()
    for run, step in ((coarse, 0.02), (fine, 0.01)):
        late = plain["side_frame_position.x"] - run["side_frame_position.x"]
        speeds = RISEN.value(np.arange(0.0, DURATION - 0.5 * step, step))
        by_hand = RISEN.integral(DURATION) - np.trapezoid(speeds, dx=step)
        np.testing.assert_allclose(late, by_hand, atol=1e-6)  # m, the integration's
        # a step's way, but for the curve of the speed within the steps
        np.testing.assert_allclose(late, step * SPEED, rtol=2e-2)
    for name in ("side_frame_position.z", "joint_force[18].x", "ground_force[10].z", "side_frame_angles.y"):
        errors = [abs(one[name] - plain[name]) for one in (coarse, fine)]
        assert errors[0] < 0.01 * abs(plain[name]), name
        # half the step, half the error: within a third, since rounding joins in
        assert errors[1] < 0.67 * errors[0] + 1e-6 * abs(plain[name]), name


def test_steps_of_constant_load_are_those_of_a_run(loaded):
    still = loaded.with_(drive=Drive(speed=StepProfile.constant(0.0)))
    run = SteppedRun(still, WRENCH)
    for _ in range(5):
        run.advance(0.01, 0.0, WRENCH)
    same, other = outputs(run.history()), outputs(simulate(still, 0.05, progress=False))
    for name in ("side_frame_position.z", "side_frame_angles.y", "joint_force[18].x", "ground_force[10].z"):
        np.testing.assert_allclose(same[name], other[name], rtol=2e-3, err_msg=name)


def at_rest(case):
    """Run without a load and its first outputs; it starts at rest, and under a load the ground has it."""
    run, under = SteppedRun(case, 0.0 * WRENCH), SteppedRun(case, WRENCH)
    free, rest = outputs(run.history()), outputs(under.history())
    carried = [sum(one[f"ground_force[{shoe}].z"] for shoe in case.track.shoes) for one in (free, rest)]
    np.testing.assert_allclose(carried[1] - carried[0], -WRENCH[2], rtol=2e-2)
    return run, free


def test_a_unit_starts_at_rest_under_its_load_and_sinks_under_more(loaded):
    run, free = at_rest(loaded)
    for _ in range(5):
        run.advance(0.02, 0.0, WRENCH)
    assert outputs(run.history())["side_frame_position.z"] < free["side_frame_position.z"] - 1e-4


def test_a_step_that_is_refused_has_done_nothing(loaded):
    """A step of 1e-9 s gave a joint 307 MN: what closes a gap within it divides by its square."""
    run = SteppedRun(loaded, WRENCH)
    before = outputs(run.history())
    refused = {
        "the step must be finite and at least solver.minimum_step = 1e-06 s, got 1e-09 s": {"step": 1e-9},
        "the step must be .* got -0.01 s": {"step": -0.01},
        "the step must be .* got nan s": {"step": np.nan},
        "force.y must be finite, got nan": {"wrench": WRENCH * [1.0, np.nan, 1.0, 1.0, 1.0, 1.0]},
        "speed must be finite, got inf": {"speed": np.inf},
    }
    for told, changes in refused.items():
        with pytest.raises(StepRefusedError, match=f"^{told}$"):
            run.advance(**{"step": 0.01, "speed": 0.0, "wrench": WRENCH} | changes)
    assert outputs(run.history()) == before
    assert run.time == 0.0


def test_the_least_step_changes_no_force(loaded):
    run = SteppedRun(loaded, WRENCH)
    before = outputs(run.history())
    run.advance(loaded.solver.minimum_step, 0.0, WRENCH)
    after = outputs(run.history())
    for name in ("joint_force[18].x", "ground_force[10].z", "drive_pull"):
        assert after[name] == pytest.approx(before[name], rel=1e-3), name


LATE = """
#include <stdlib.h>

__attribute__((destructor)) static void take_all(void)
{
    for (int number = 0; number < 5000; number++) {
        volatile void *block = malloc(128);
        (void)block;
    }
}
"""
"""Library that takes all free blocks of a size as it is unloaded, after a unit that was loaded before it."""


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    """The libraries to load after a unit, by `LATE`; none where there is no compiler."""
    compiler = shutil.which("cc")
    if compiler is None or sys.platform != "linux":
        return []
    folder = tmp_path_factory.mktemp("late")
    (folder / "late.c").write_text(LATE)
    subprocess.run([compiler, "-shared", "-fPIC", "-o", folder / "late.so", folder / "late.c"], check=True)
    return [folder / "late.so"]


def sorted_heap():
    """Environment in which a block that is given back stands in a list that is checked as it is used."""
    return os.environ | {"GLIBC_TUNABLES": "glibc.malloc.tcache_count=0"}


HOST = """
import ctypes
import sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

description = read_model_description(sys.argv[1])
folder = extract(sys.argv[1])
numbers = {one.name: one.valueReference for one in description.modelVariables}


def asked(call, *arguments):
    try:
        call(*arguments)
        print("-> ok")
    except Exception as error:
        print("->", str(error).rpartition("(")[2].strip(")."))


def scatter(malloc, free):
    # leave free blocks of the unit's size between others, with which they do not grow together
    malloc.restype = ctypes.c_void_p
    blocks = []
    for number in range(400):
        blocks.append(malloc(128))
        malloc(24)
    for block in blocks:
        free(ctypes.c_void_p(block))


if sys.argv[2:]:
    library = ctypes.CDLL(None)
    scatter(library.malloc, library.free)
for number in range(2):
    unit = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="u",
    )
    unit.instantiate(loggingOn=True)
    unit.setupExperiment(startTime=5.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    asked(unit.doStep, 5.0, 0.01)
    asked(unit.doStep, 5.02, 0.01)
    asked(unit.doStep, 5.01, 1e-9)
    unit.setReal([numbers["force.z"]], [float("nan")])
    asked(unit.doStep, 5.01, 0.01)
    unit.setReal([numbers["force.z"]], [0.0])
    unit.setReal([numbers["drive_pull"]], [1.0])
    asked(unit.doStep, 5.01, 0.01)
    asked(unit.getReal, [98765])
    asked(unit.doStep, 5.01, 0.01)
    asked(unit.doStep, 5.01, 0.01)
    unit.setReal([numbers["force.z"]], [1e30])
    asked(unit.doStep, 5.02, 0.01)
    print("z", unit.getReal([numbers["side_frame_position.z"]]))
    asked(unit.doStep, 5.02, 0.01)
    unit.terminate()
    unit.freeInstance()
    print("freed")
for path in sys.argv[2:]:
    ctypes.CDLL(path)
"""


def test_a_host_gets_discard_and_the_reason_and_lives_on(tmp_path, late):
    """After an exception that left the unit, pythonfmu freed it twice: one process in four ended in that.

    As a process ended, its library once more lowered a count in memory that it had given back. There the heap
    has a link of its lists: taking the block, or giving back its neighbour, ended in "corrupted double-linked
    list". Here all such blocks are taken, so that each process ends in it, whatever it asked of the unit.
    """
    unit = write_fmu(CaseFile(case=small_case(), duration=DURATION), tmp_path / "small.fmu")
    command = [sys.executable, "-c", HOST, unit, *late]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=sorted_heap())
    assert done.returncode == 0, done.stderr
    answers = [line for line in done.stdout.splitlines() if line.startswith(("->", "z", "freed"))]
    whole = ["-> ok", *["-> discard"] * 4, "-> ok", "-> discard", "-> ok", "-> discard", "z [nan]"]
    assert answers == [*whole, "-> discard", "freed"] * 2
    reasons = [line.partition("u: ")[2] for line in done.stderr.splitlines() if "u: " in line]
    expected = (
        r"the step at 5.02 s is refused: it must start where the last one ended, at 5.01 s",
        r"the step at 5.01 s is refused: the step must be finite and at least solver.minimum_step = 1e-06 s",
        r"the step at 5.01 s is refused: force.z must be finite, got nan",
        r"drive_pull must not be set: it is an output",
        r"there is no variable of value reference 98765",
        r"the unit ends: the simulation stopped at t = 0.02 s: Newton's method failed at the least step",
        r"the unit has ended: the simulation stopped",
    )
    assert len(reasons) == 2 * len(expected)
    for told, start in zip(reasons, expected * 2, strict=True):
        assert told.startswith(start)
        assert told in done.stdout  # the host's log


C_HOST = """
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct { void *logger, *allocate, *release, *finished, *environment; } Callbacks;

static void log_message(void *host, const char *name, int status, const char *kind, const char *message)
{
    printf("u: %s\\n", message);
}

int main(int count, char **arguments)
{
    void *blocks[400];
    for (int number = 0; number < 400; number++) {
        blocks[number] = malloc(128);
        volatile void *between = malloc(24);
        (void)between;
    }
    for (int number = 0; number < 400; number++)
        free(blocks[number]);
    void *library = dlopen(arguments[1], RTLD_NOW);
    void *(*instantiate)(const char *, int, const char *, const char *, Callbacks *, int, int)
        = dlsym(library, "fmi2Instantiate");
    int (*setup)(void *, int, double, double, int, double) = dlsym(library, "fmi2SetupExperiment");
    int (*enter)(void *) = dlsym(library, "fmi2EnterInitializationMode");
    int (*leave)(void *) = dlsym(library, "fmi2ExitInitializationMode");
    int (*step)(void *, double, double, int) = dlsym(library, "fmi2DoStep");
    void (*release)(void *) = dlsym(library, "fmi2FreeInstance");
    static Callbacks callbacks;
    callbacks.logger = log_message;
    callbacks.allocate = calloc;
    callbacks.release = free;
    void *unit = instantiate("u", 1, arguments[2], arguments[3], &callbacks, 0, 1);
    printf("%d\\n", setup(unit, 0, 0.0, 0.0, 0, 0.0));
    printf("%d\\n", enter(unit));
    printf("%d\\n", leave(unit));
    printf("%d\\n", step(unit, 0.0, 0.01, 1));
    printf("%d\\n", step(unit, 0.02, 0.01, 1));
    release(unit);
    dlclose(library);
    dlopen(arguments[4], RTLD_NOW);
    puts("freed");
    return 0;
}
"""


@pytest.mark.slow
def test_a_host_that_is_not_python_steps_a_unit_and_ends_well(tmp_path, late):
    """A host's call ended in Exudyn: pybind11 asked for the state of its thread, which was freed by then."""
    python = Path(sysconfig.get_config_var("LIBDIR")) / sysconfig.get_config_var("LDLIBRARY")
    if not late or python.suffix == ".a":
        pytest.skip("needs a C compiler and Python as a library")
    unit = write_fmu(CaseFile(case=small_case(), duration=DURATION), tmp_path / "small.fmu")
    shutil.unpack_archive(unit, tmp_path / "unpacked", "zip")
    (tmp_path / "host.c").write_text(C_HOST)
    subprocess.run(["cc", "-w", "-o", tmp_path / "host", tmp_path / "host.c", "-ldl"], check=True)
    paths = os.pathsep.join(path for path in (os.environ.get("PYTHONPATH"), *sys.path) if path)
    embedded = {"LD_PRELOAD": str(python), "PYTHONPATH": paths, "PYTHONHOME": sys.base_prefix}
    library = tmp_path / "unpacked" / "binaries" / "linux64" / "MachineOnTrack.so"
    resources = (tmp_path / "unpacked" / "resources").as_uri()
    command = [tmp_path / "host", library, read_model_description(unit).guid, resources, *late]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=sorted_heap() | embedded)
    assert done.returncode == 0, done.stderr
    gap = "u: the step at 0.02 s is refused: it must start where the last one ended, at 0.01 s"
    assert done.stdout.splitlines() == ["0", "0", "0", "0", gap, "2", "freed"]


def test_a_message_with_a_percent_sign_is_a_format_of_printf(tmp_path):
    write_case(CaseFile(case=small_case(), duration=DURATION), tmp_path / CASE)
    unit = MachineOnTrack(instance_name="u", resources=str(tmp_path))
    unit.do_step(0.0, 0.01)
    unit._refuse("5 % more")
    assert [entry.msg for entry in unit.log_queue] == [
        "the unit has ended: it was not initialized",
        "5 %% more",
    ]


def test_refuses_what_has_no_machine_and_rollers_off_the_track(tmp_path, loaded):
    with pytest.raises(ValueError, match=r"gear\.kind must be .*, got 'dragged'"):
        write_fmu(CaseFile(case=Case.translation(), duration=1.0), tmp_path / "none.fmu")
    with pytest.raises(ValueError, match=r"gear\.kind must be .*, got 'dragged'"):
        SteppedRun(Case.translation(), WRENCH)
    with pytest.raises(ValueError, match="track must be long enough"):
        SteppedRun(loaded, WRENCH).advance(100.0, 1.0, WRENCH)


def test_a_closed_track_is_at_rest_as_tense_in_a_run_by_steps_in_a_unit_and_standing(tmp_path):
    """Its take-up is not stated: in a unit link 1 had 1.5 times the tension of a run."""
    still = Case.closed().with_(drive=Drive(speed=StepProfile.constant(0.0)))
    step = still.solver.step
    whole = simulate(still, step, progress=False)
    by_steps = SteppedRun(still, 0.0 * WRENCH).history()
    unit = MachineOnTrack(
        instance_name="mine", resources=write_case(CaseFile(case=still, duration=1.0), tmp_path / CASE).parent
    )
    unit.exit_initialization_mode()
    of_unit = [unit.vars[k].name for k in unit.vars]
    of_unit = dict(zip(of_unit, unit.get_real(list(unit.vars)), strict=True))
    of_run, of_steps = outputs(whole), outputs(by_steps)
    assert by_steps.case.gear.idler.take_up == whole.case.gear.idler.take_up is not None
    for name in ("side_frame_position.z", "joint_force[1].x", "joint_force[30].x", "drive_moment"):
        assert of_steps[name] == of_unit[name]
        assert of_steps[name] == pytest.approx(of_run[name], rel=1e-3), name
    for link in (1, 20, 38):
        tension = [float(one.link_tension.sel(joint=link).isel(time=-1)) for one in (whole, by_steps)]
        assert tension[0] == pytest.approx(tension[1], rel=1e-3)
    chains = [tension_of(one) for one in (whole, by_steps, standing(still).history)]
    assert chains == pytest.approx([chains[0]] * 3, rel=1e-3)


def tension_of(history):
    (chain,) = hanging_chains(history.case, history.dataset.isel(time=-1))
    return chain.pretension


def test_variables_of_a_unit_have_units(unit):
    """Their dimensions are those of what they are: by SI's base units, which fmpy reads."""
    description = read_model_description(unit, validate=True)
    units = {one.name: one.baseUnit for one in description.unitDefinitions}
    dimensions = {
        "force": (1, 1, -2, 0),
        "moment": (1, 2, -2, 0),
        "pull": (1, 1, -2, 0),
        "position": (0, 1, 0, 0),
        "velocity": (0, 1, -1, 0),
        "speed": (0, 1, -1, 0),
        "angles": (0, 0, 0, 1),
        "angular_velocity": (0, 0, -1, 1),
    }
    for variable in description.modelVariables:
        name = variable.name.split("[")[0].split(".")[0]
        quantity = max((key for key in dimensions if name.endswith(key)), key=len)
        base = units[variable.unit]
        assert (base.kg, base.m, base.s, base.rad) == dimensions[quantity], variable.name
        assert (base.factor, base.offset) == (1.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("base", [Case.closed, Case.shovel])
def test_closed_tracks_are_units_too(base, tmp_path):
    """Pushed down from outside they bear more, and the drive's speed reaches the tumblers."""
    case = base()
    unit = write_fmu(CaseFile(case=case, duration=DURATION), tmp_path / "closed.fmu")
    variables = read_model_description(unit).modelVariables
    names = {one.name for one in variables if one.causality == "output"}
    run, free = at_rest(case)
    assert names == free.keys()
    for end in np.arange(0.01, 0.11, 0.01):
        run.advance(0.01, float(end), 0.0 * WRENCH, 0.1 * float(end) * (case.gear.tracks - 1))
    speed = np.atleast_1d(run.history().tumbler_speed.values[0])
    expected = (0.1 - 0.01 * case.gear.middles) / case.gear.travel_per_angle(case.track)
    np.testing.assert_allclose(speed, expected, rtol=1e-6)
    assert ("turn_rate" in {one.name for one in variables}) == (case.gear.tracks == 2)
