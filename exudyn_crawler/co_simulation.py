"""Machine on its track as a unit of co-simulation (FMU, FMI 2.0), stepped by another program.

pythonfmu builds and runs the unit: the host program needs this package in its Python. Its library (0.7) frees
memory twice in three places, and some processes then end in "corrupted double-linked list":

- after an exception has left a method of the unit: no exception leaves one here,
- for the names of the unit's script, to which it has no reference: `hold` keeps one,
- for its own state as the process ends, whatever the unit did: `_release_at_exit` is earlier.
"""

import atexit
import ctypes
import logging
import math
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from pythonfmu import DefaultExperiment, Fmi2Causality, Fmi2Slave, FmuBuilder, Real
from pythonfmu.enums import Fmi2Status
from threadpoolctl import threadpool_limits

from exudyn_crawler import errors, files
from exudyn_crawler.case import Case, MachineCycle, MachinePhase, statics
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.machines import CaseFile, read_case, write_case
from exudyn_crawler.model import diagnostics
from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.results.history import History, states
from exudyn_crawler.results.history.catalogue import QUANTITIES, lacking
from exudyn_crawler.run.solve import simulation

AXES = "xyz"
COMMANDS = ("speed", "turn_rate", *(f"{part}.{axis}" for part in ("force", "moment") for axis in AXES))
"""Names of the inputs."""
STEP = 0.01  # s, communication step that a unit proposes
CASE, SCRIPT = "case.toml", "machine_on_track"
"""Files within a unit: the case, and the module that pythonfmu loads."""
LINES = f"from {__name__} import MachineOnTrack, hold\n\nhold(globals())\n"


class Meaning(NamedTuple):
    """Unit and meaning of a variable."""

    unit: str  # name in `UNITS`
    words: str


DRIVES = {
    "drive_moment": Meaning("N.m", "drive moment on the tumbler"),
    "drive_pull": Meaning("N", "pull of the drive on the chain"),
}
"""Quantities of the drive of a machine."""
FRAME = {
    "position": Meaning("m", "position of the side frame's origin"),
    "velocity": Meaning("m/s", "velocity of this origin"),
    "angles": Meaning("rad", "roll, pitch and yaw of the side frame"),
    "angular_velocity": Meaning("rad/s", "angular velocity of the side frame"),
}
UNITS = {
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
}
"""Exponents of the SI base units in the units of variables, with the names of FMI."""

SAME_TIME = 1e-9
"""Tolerance (s, and fraction of the time) between the time of the host and that of the unit."""

logger = logging.getLogger("exudyn_crawler")

_held: list[dict[str, object]] = []
_libraries: dict[str, ctypes.CDLL] = {}


def hold(names: dict[str, object]) -> None:
    """Keep what pythonfmu 0.7 frees too early: the names of a unit's script, and Python's thread state.

    The thread of a host that is not Python has a state only during each call. But Exudyn's library (pybind11)
    remembers the state with which it was imported, and uses it in later calls.
    """
    _held.append(names)
    ctypes.pythonapi.PyGILState_Ensure()  # never released
    if sys.platform == "linux":
        _release_at_exit()


def _release_at_exit() -> None:
    """Let the libraries of units in this process release their state before the process ends.

    Each library has its state in a static pointer, which `exit` destroys. A function that runs at the
    unloading of a library then releases it once more. `dlclose` would run that function first, but never
    unloads a library with unique symbols such as this one. So a count in freed memory is lowered by 1, where
    the heap has a link of its lists of free blocks. The release as Python ends
    comes before both, which then find an empty pointer.
    """
    maps = Path("/proc/self/maps").read_text(encoding="utf-8", errors="surrogateescape")
    paths = {fields[5] for line in maps.splitlines() if len(fields := line.split(maxsplit=5)) == 6}
    for path in paths:
        if Path(path).name != f"{MachineOnTrack.__name__}.so" or path in _libraries:
            continue
        _libraries[path] = ctypes.CDLL(path)
        atexit.register(_libraries[path].finalizePythonInterpreter)


class StepRefusedError(ValueError):
    """Error of a requested step that is not taken; the state is unchanged."""


class SteppedRun:
    """Run of a machine on its track from rest, step by step, with speed and load as inputs.

    Over a step both inputs change linearly from their last values to those at its end: they are late by a
    step at most, and have no jumps. The case is rolled or closed; its own drive and machine do not count.
    `wrench` (6,) is force (N) and moment (N m) on the side frame's origin beside its weight, global, at rest.

    Raises ValueError if the case has no machine, or the machine tips; EquilibriumError if the track finds no
    rest.
    """

    def __init__(self, case: Case, wrench: np.typing.ArrayLike) -> None:
        case.part(RunningGear)
        force, moment = np.asarray(wrench, dtype=float).reshape(2, 3).tolist()
        if any((*force, *moment)) or case.machine is not None:
            phase = MachinePhase(name="rest", end=0.0, force=tuple(force), moment=tuple(moment))
            case = case.with_(machine=MachineCycle(phases=(phase,)))
        system = simulation.started(case, progress=False)
        assert isinstance(system, CompiledSystem)  # of a case with rollers
        self.case = system.case
        self._system = system
        self._system.timed_inputs.commands = self._at
        self._settings = simulation.solver_settings(case.solver)
        self._span = (0.0, 1.0)
        self._before = self._after = np.array([0.0, 0.0, *force, *moment])
        self._settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = True
        self.time = 0.0
        self.travel = 0.0
        # a step at rest before the start computes the forces at the start
        self.advance(case.solver.step, 0.0, wrench)
        self.time = 0.0

    def _at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return speed and turn rate (2,), and the wrench (6,) at a time (s) within the step."""
        start, end = self._span
        share = min(max((time - start) / (end - start), 0.0), 1.0)
        values = (1.0 - share) * self._before + share * self._after
        return values[:2], values[2:]

    @threadpool_limits.wrap(limits=1, user_api="blas")
    def advance(self, step: float, speed: float, wrench: np.typing.ArrayLike, turn_rate: float = 0.0) -> None:
        """Integrate a step (s) to a speed (m/s), a wrench (6,) and, on two tracks, a turn rate (rad/s).

        Raises StepRefusedError if a value is not finite, the step is below the solver's least one, or the
        rollers would leave the track; SimulationStopped if a step fails at the least one, which ends the run.
        """
        least = self.case.solver.minimum_step
        if not least <= step < math.inf:
            raise StepRefusedError(
                f"the step must be finite and at least solver.minimum_step = {least:g} s, got {step:g} s"
            )
        after = np.array([speed, turn_rate, *np.asarray(wrench, dtype=float)])
        for name, value in zip(COMMANDS, after.tolist(), strict=True):
            if not math.isfinite(value):
                raise StepRefusedError(f"{name} must be finite, got {value}")
        end = self.time + step
        travel = self.travel + 0.5 * step * (self._after[0] + speed)
        for error in self.case.gear.reach_errors(self.case.track, travel, end):
            raise StepRefusedError(error)
        self._span = (self.time, end)
        self._before = self._after
        self._after = after
        next_end = simulation.set_times(self._settings, self.case.solver, self.time, end)
        try:
            self._system.solve(self._settings, next_end)
        except diagnostics.NewtonError as failed:
            reason = f"Newton's method failed at the least step; {failed.fault(self._system.layout)}"
            raise errors.SimulationStopped(self.time, reason, self.history()) from None
        self.time = end
        self.travel = travel
        self._system.set_state(self._system.state())

    def history(self) -> History:
        """Return a history of the present instant."""
        return states.system_history(self._system, self._system.state()[None])


def outputs(history: History) -> dict[str, float]:
    """Return the outputs of a unit at an instant by name: drive, frame, links and ground under every shoe."""
    data = history.dataset.isel(time=-1)
    ground = history.contacts_by_shoe().contact_force.isel(time=-1).transpose("shoe", "axis")
    arrays = [
        data[_drive_name(history.case)],
        *(data[f"side_frame_{name}"] for name in FRAME),
        data.joint_force,
        ground,
    ]
    values = np.concatenate([np.ravel(array) for array in arrays]).tolist()
    return dict(zip(_output_names(history.case), values, strict=True))


def _drive_name(case: Case) -> str:
    """Return the name of the drive's quantity in the case."""
    return next(name for name in DRIVES if not lacking(QUANTITIES[name], case))


def _output_names(case: Case) -> dict[str, Meaning]:
    """Return names and meanings of `outputs`; of two closed tracks the right one's drive comes first."""
    name = _drive_name(case)
    named = {name: DRIVES[name]}
    if case.gear.tracks > 1:
        named = {
            f"drive_moment[{track}]": Meaning("N.m", f"drive moment on the tumbler of track {track}")
            for track in (1, 2)
        }
    vectors = {f"side_frame_{name}": meaning for name, meaning in FRAME.items()}
    for link in case.gear.joints(case.track):
        vectors[f"joint_force[{link}]"] = Meaning(
            "N", f"force of the joint ahead of shoe {link} on this shoe"
        )
    for shoe in case.track.shoes:
        vectors[f"ground_force[{shoe}]"] = Meaning("N", f"force of the ground on shoe {shoe}")
    return named | {f"{name}.{axis}": vector for name, vector in vectors.items() for axis in AXES}


class _Variable(Real):
    """Real variable with a unit, which pythonfmu lacks."""

    def __init__(self, name: str, meaning: Meaning, **about: object) -> None:
        super().__init__(name, description=meaning.words, **about)
        self._unit = meaning.unit

    def to_xml(self) -> Element:
        """Return the element of the variable in the model description."""
        element = super().to_xml()
        element[0].set("unit", self._unit)
        return element


class MachineOnTrack(Fmi2Slave):
    """Unit of a case; inputs are the speed of the drive and the load on the side frame beside its weight.

    A step refused for a value, a size or a gap in time changes nothing, and the host may ask again; a failed
    step ends the unit. Both answer *discard*, the only answer of pythonfmu beside *ok* and *fatal*, and log
    the reason as an error.
    """

    description = "Crawler track of a mining shovel: side frame, rollers, shoes, links and ground"

    def __init__(self, **about: object) -> None:
        super().__init__(**about)
        self._case = read_case(Path(self.resources) / CASE).case
        self._run: SteppedRun | None = None
        self._start = 0.0  # time of the host when the unit starts, s
        self._refused: list[str] = []  # reasons of refusals since the last step
        self._ended = "it was not initialized"  # reason of the end; empty while steps are possible
        self._outputs = dict.fromkeys(_output_names(self._case), 0.0)
        self.default_experiment = DefaultExperiment(start_time=0.0, step_size=STEP)
        force = Meaning("N", "force at the side frame's origin in addition to its weight")
        moment = Meaning("N.m", "moment about the side frame's origin")
        named = {f"force.{axis}": force for axis in AXES} | {f"moment.{axis}": moment for axis in AXES}
        named["speed"] = Meaning("m/s", "speed of the drive at the end of a step")
        if self._case.gear.tracks > 1:
            named["turn_rate"] = Meaning("rad/s", "turn rate of the machine to the left at the end of a step")
        wrench = np.ravel(statics.machine_wrench(self._case, 0.0)).tolist()
        self._inputs = dict.fromkeys(named, 0.0) | dict(zip(named, wrench, strict=False))
        self._register(named, self._inputs, Fmi2Causality.input)
        self._register(_output_names(self._case), self._outputs, Fmi2Causality.output)

    def to_xml(self, model_options: Mapping[str, str] = MappingProxyType({})) -> Element:
        """Return the model description with the units of the variables."""
        root = super().to_xml(dict(model_options))
        definitions = Element("UnitDefinitions")
        for name, exponents in UNITS.items():
            unit = SubElement(definitions, "Unit", {"name": name})
            SubElement(unit, "BaseUnit", {base: str(power) for base, power in exponents.items()})
        # FMI requires this order
        root.insert(1 + [child.tag for child in root].index("CoSimulation"), definitions)
        return root

    def _register(
        self, named: dict[str, Meaning], values: dict[str, float], causality: Fmi2Causality
    ) -> None:
        """Register variables by name and meaning; their values are in `values`."""
        for name, meaning in named.items():
            ways = {"getter": partial(values.__getitem__, name), "setter": partial(values.__setitem__, name)}
            variable = _Variable(name, meaning, causality=causality, **ways)
            self.register_variable(variable, nested=False)

    def _say(self, reason: str) -> None:
        """Log an error, also if the host's log is off; the host reads a message as a format of printf."""
        self.log(reason.replace("%", "%%"), Fmi2Status.error)
        logger.error("%s: %s", self.instance_name, reason)

    def _refuse(self, reason: str) -> None:
        """Log a refusal, and refuse the next step for it: pythonfmu cannot answer *error* at once."""
        self._refused.append(reason)
        self._say(reason)

    def _variables(self, references: Sequence[int], causality: Fmi2Causality | None = None) -> list[Real]:
        """Return the variables of value references; refuse unknown ones and those of another causality."""
        variables = []
        for reference in references:
            variable = self.vars.get(reference)
            if variable is None:
                self._refuse(f"there is no variable of value reference {reference}")
            elif causality is not None and variable.causality != causality:
                self._refuse(f"{variable.name} must not be set: it is an {variable.causality.name}")
            else:
                variables.append(variable)
        return variables

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return the values of variables; NaN for all if the unit lacks one of them."""
        variables = self._variables(vrs)
        if len(variables) < len(vrs):
            return [math.nan] * len(vrs)
        return [float(variable.getter()) for variable in variables]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set inputs; set none if the unit lacks one of them."""
        variables = self._variables(vrs, Fmi2Causality.input)
        if len(variables) == len(vrs):
            for variable, value in zip(variables, values, strict=True):
                variable.setter(value)

    def _refuse_kind(self, vrs: list[int], _values: object = None) -> list[int]:
        """Refuse a type that no variable of the unit has."""
        self._refuse("all variables of the unit are real numbers")
        return [0] * len(vrs)

    get_integer = set_integer = get_boolean = set_boolean = set_string = _refuse_kind

    def get_string(self, vrs: list[int]) -> list[str]:
        """Refuse texts, since the unit has none."""
        return [str(value) for value in self._refuse_kind(vrs)]

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        """Take the start time of the host; stop time and tolerance have no effect."""
        self._start = start_time

    def _commands(self) -> tuple[float, np.ndarray, float]:
        *wrench, speed, turn_rate = (*self._inputs.values(), 0.0)[:8]
        return speed, np.array(wrench), turn_rate

    def exit_initialization_mode(self) -> None:
        """Bring the track to rest under the load of the inputs; without a rest the unit ends."""
        try:
            self._run = SteppedRun(self._case, self._commands()[1])
            self._outputs.update(outputs(self._run.history()))
            self._ended = ""
        except BaseException as error:
            self._end(error)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Integrate a communication step (s); return False if it is refused or fails."""
        refused = self._refused.copy()
        self._refused.clear()
        if self._ended:
            self._say(f"the unit has ended: {self._ended}")
        if self._ended or refused:
            return False
        try:
            self._step(current_time, step_size)
        except StepRefusedError as error:
            self._say(f"the step at {current_time:g} s is refused: {error}")
            return False
        except BaseException as error:
            self._end(error)
            return False
        return True

    def _step(self, current_time: float, step_size: float) -> None:
        """Integrate a step; raise StepRefusedError for a gap in time; other errors: `SteppedRun.advance`."""
        assert self._run is not None
        ended = self._start + self._run.time
        if not abs(current_time - ended) <= SAME_TIME * max(1.0, abs(ended)):
            raise StepRefusedError(f"it must start where the last one ended, at {ended:.9g} s")
        self._run.advance(step_size, *self._commands())
        self._outputs.update(outputs(self._run.history()))

    def _end(self, error: BaseException) -> None:
        """End the unit because of an error; its outputs are NaN from now on."""
        self._ended = str(error) or type(error).__name__
        self._outputs.update(dict.fromkeys(self._outputs, math.nan))
        self._say(f"the unit ends: {self._ended}")


def write_fmu(case_file: CaseFile, path: str | Path, overwrite: bool = False) -> Path:
    """Write the unit of a case, a file with the suffix ``.fmu``, and return its path.

    Raises ValueError if the case has no machine; FileExistsError if the file exists and `overwrite` is false.
    """
    path = Path(path)
    case_file.case.part(RunningGear)
    with files.whole_file(path, overwrite) as temporary, tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / f"{SCRIPT}.py"
        script.write_text(LINES, encoding="utf-8")
        case = write_case(case_file, Path(folder) / CASE)
        made = Path(folder) / "unit.fmu"
        try:
            FmuBuilder.build_FMU(script, made, project_files={case})
        finally:
            # pythonfmu leaves the folder in the path
            sys.path[:] = [entry for entry in sys.path if entry != folder]
        temporary.write_bytes(made.read_bytes())
    return path
