"""File of an assessment: its machine, and data of work, ground, drive and pins that a case does not have."""

from pathlib import Path
from typing import Any, Literal

from exudyn_crawler.assessment.grounds import ground
from exudyn_crawler.case.parameters import base
from exudyn_crawler.machines import CaseFile, case_of, read_case
from exudyn_crawler.results.life.duty import FatigueMaterial
from exudyn_crawler.settings import fields, parameters
from exudyn_crawler.settings.fields import NONE
from exudyn_crawler.settings.parameters import Errors, Name, Parameters, option, quantity
from exudyn_crawler.settings.reading import errors_named, from_content, stated, toml_content

MACHINE = "machine"  # key of the case of an assessment
CLAY = "clay"  # end of the names of clays
Part = float | None


class WorkSettings(Parameters):
    """Work of the upper structure."""

    payload: Part = quantity(
        "kg",
        "payload in the dipper or on the hook, or attachment beside the upper structure; none: unknown",
        (0.0, 2e5),
        ge=0,
        le=1e7,
        default=None,
    )
    reach: Part = quantity(
        "m",
        "distance of the payload ahead of the swing axis; none: unknown",
        (0.0, 60.0),
        ge=0,
        le=100,
        default=None,
    )
    least_reach: Part = quantity(
        "m", "least reach of the payload; none: half of the reach", ge=0, le=100, default=None
    )
    height: base.Extent = quantity("m", "height of the payload above the ground", (0.0, 60.0), default=0.0)
    digging: base.Two | None = quantity(
        "N",
        "force of the bank on the dipper at the reach: away from the machine, and up; none: unknown",
        (-5e6, 5e6),
        default=None,
    )
    slew_rate: float = quantity(
        "rad/s", "slewing rate of the upper structure", (0.0, 1.5), ge=0, le=5, default=0.0
    )
    grade: float = quantity("1", "permitted grade, rise over run", (0.0, 0.7), ge=0, lt=2, default=0.1)
    side_slope: float = quantity(
        "1", "permitted side slope, rise over run", (0.0, 0.5), ge=0, lt=2, default=0.05
    )
    wind_pressure: float = quantity(
        "Pa",
        "greatest wind pressure in service; 250: 20 m/s, FEM 1.001 (remembered)",
        (0.0, 1500.0),
        ge=0,
        le=5e3,
        default=250.0,
    )
    wind_area: Part = quantity(
        "m2", "area exposed to the wind; none: unknown", (0.0, 1e3), ge=0, le=1e5, default=None
    )
    wind_height: base.Extent = quantity(
        "m", "height of the centre of the wind area above the ground", (0.0, 40.0), default=0.0
    )


class GroundSettings(Parameters):
    """Ground below the machine: a named one or that of the case, which also gives values that are none."""

    name: str | None = option(
        "name of a listed ground; none: ground of the case, with unknown allowed pressure", None
    )
    allowed_pressure: Part = quantity(
        "Pa",
        "allowed ground pressure; none: that of the named ground",
        (2e4, 1e7),
        gt=0,
        le=1e9,
        default=None,
    )
    friction: Part = quantity(
        "1",
        "coefficient of traction, also in turns: traction over load",
        (0.1, 1.2),
        gt=0,
        le=3,
        default=None,
    )
    rolling: Part = quantity(
        "1",
        "coefficient of motion resistance in straight travel; sinkage into the case's ground is extra",
        (0.01, 0.15),
        ge=0,
        le=1,
        default=None,
    )
    undrained_strength: Part = quantity(
        "Pa", "undrained shear strength c_u of clay", (1e4, 1e6), gt=0, le=1e8, default=None
    )
    cohesion: Part = quantity("Pa", "cohesion c, beside the friction", (0.0, 1e5), ge=0, le=1e7, default=None)

    def _errors(self) -> Errors:
        if self.name is not None:
            ground(self.name)
            if self.undrained_strength is not None and not self.name.endswith(CLAY):
                yield f"undrained_strength must be left out for ground that is not clay, got {self.name!r}"


class DriveSettings(Parameters):
    """Drive of the tracks, and their chains."""

    torque: Part = quantity(
        "N m",
        "greatest torque of each tumbler; none: that of the case or an assumption",
        (1e3, 5e6),
        gt=0,
        le=1e9,
        default=None,
    )
    efficiency: float = quantity(
        "1", "efficiency of the chain on its tumbler", (0.8, 1.0), gt=0, le=1, default=0.9
    )
    power: Part = quantity("W", "power for travel of both chains", (1e4, 1e7), gt=0, le=1e9, default=None)
    rest_tension: Part = quantity("N", "tension of the chain at rest", (1e3, 3e6), ge=0, le=1e9, default=None)
    breaking_tension: Part = quantity(
        "N", "breaking tension of the chain", (1e5, 5e7), gt=0, le=1e10, default=None
    )


class PinSettings(Parameters):
    """Hinge joints of the shoes; lengths that are none are those of the ready shoe or follow the pitch."""

    diameter: Part = quantity("m", "diameter of a pin", (0.01, 0.3), gt=0, le=2, default=None)
    inner: Part = quantity(
        "m", "width of the inner lug, or length of the bush", (0.02, 0.5), gt=0, le=5, default=None
    )
    outer: Part = quantity("m", "width of each outer lug", (0.01, 0.3), gt=0, le=5, default=None)
    gap: Part = quantity("m", "gap between inner and outer lug", (0.0, 0.03), ge=0, le=1, default=None)
    play: base.Extent = quantity(
        "m", "diameter of a bore less the diameter of its pin; 0: no play", (0.0, 0.01), default=0.0
    )
    tensile_strength: float = quantity(
        "Pa", "tensile strength of a pin", (4e8, 2e9), gt=0, le=1e10, default=800e6
    )
    yield_strength: float = quantity(
        "Pa", "yield strength of a pin", (3e8, 1.8e9), gt=0, le=1e10, default=550e6
    )
    wear_pressure: float = quantity(
        "Pa", "pressure on diameter times width allowed for wear", (2e7, 2e8), gt=0, le=1e10, default=80e6
    )


class AssessmentSettings(Parameters):
    """Settings of an assessment beside the case of its machine."""

    name: Name = option("name of the assessment", "assessment")
    work: WorkSettings = WorkSettings()
    ground: GroundSettings = GroundSettings()
    drive: DriveSettings = DriveSettings()
    pins: PinSettings = PinSettings()
    length: Part = quantity(
        "m",
        "length of a track on the ground; none: from rollers and end wheels",
        (1.0, 15.0),
        gt=0.1,
        le=100,
        default=None,
    )
    side_edges: Literal["middle", "outside"] = option(
        "tipping edge at a side: middle of a track, or outer edge of its shoes (ISO 10567)", "middle"
    )
    rated_part: float = quantity(
        "1",
        "rated load, fraction of the tipping load (0.75: SAE J1097)",
        (0.6, 0.9),
        gt=0,
        le=1,
        default=0.75,
    )
    material: FatigueMaterial = option("material of shoes and rails", FatigueMaterial.cast_nicrmo())
    mesh: str | None = option(
        "mesh of the checked shoe: coarse, study or fine; none: no check of the shoe", "coarse"
    )
    hours: float = quantity("h", "required life of a shoe, machine hours", gt=0, le=1e9, default=25_000.0)
    travel_part: float = quantity(
        "1", "fraction of the machine hours in travel", (0.0, 0.5), ge=0, le=1, default=0.1
    )
    load_cases: parameters.File | None = option("file of load cases and factors; none: the program's", None)


class AssessmentFile(Parameters):
    """Machine and settings of an assessment, and the keys given by its files."""

    machine: CaseFile
    settings: AssessmentSettings
    given: tuple[str, ...] = option("paths of the settings that the file gives", ())
    stated: tuple[str, ...] = option("paths of the values that the machine's file states", ())


def read_assessment(path: str | Path) -> AssessmentFile:
    """Read an assessment: a file that names a `machine`, or the file of a machine itself.

    A `machine` is a case file, the name of a case, or a table of one; paths start at the file's folder. Raise
    `FileNotFoundError`, or a `CaseFileError` that names each wrong key.
    """
    path = Path(path)
    with errors_named(path, AssessmentSettings):
        content = toml_content(path, "file of an assessment")
        if not _is_of_assessment(content):
            machine = None
        else:
            entry = content.pop(MACHINE)
            machine = case_of(entry, path)
            of_machine = _stated(entry, path)
            settings = from_content(AssessmentSettings, {"name": path.stem} | content, path.parent)
    if machine is None:
        case_file = read_case(path)
        settings = AssessmentSettings(name=path.stem)
        return AssessmentFile(machine=case_file, settings=settings, stated=_stated(content, path))
    given = tuple(map(fields.path_text, stated(content)))
    return AssessmentFile(machine=machine, settings=settings, given=given, stated=of_machine)


def _stated(entry: object, path: Path) -> tuple[str, ...]:
    """Return the paths of the values stated in a machine's file or table; empty for a named case."""
    if isinstance(entry, str):
        named = path.parent / entry
        entry = toml_content(named, "case file") if named.is_file() else {}
    if not isinstance(entry, dict):
        return ()
    return tuple(fields.path_text(fields.present_path(CaseFile, place)) for place in stated(entry))


def _is_of_assessment(content: dict[str, Any]) -> bool:
    """Return True if a file names a machine; False if `machine` holds phases, as in a case, or none."""
    machine = content.get(MACHINE, NONE)
    return machine != NONE and not (isinstance(machine, dict) and "phases" in machine)
