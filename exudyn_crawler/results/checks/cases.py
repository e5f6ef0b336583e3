"""Check cases of a shoe: forces of treads, pressures and pins on one-sided ground, with a ready list.

Places are in the shoe's frame: x along the travel, y to the left, z up, origin at its nominal centre of mass.
"""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from pydantic import AliasChoices

from exudyn_crawler.case import Case, Track, ph4100c, statics
from exudyn_crawler.case.parameters import base
from exudyn_crawler.case.parameters.base import Place, Two
from exudyn_crawler.case.parameters.track import COUPLING, FlexibleShoes, PinCoupling
from exudyn_crawler.machines.case_files import read_case
from exudyn_crawler.results.life.duty import FatigueMaterial
from exudyn_crawler.settings import parameters, reading
from exudyn_crawler.settings.parameters import Name, Parameters, option, quantity
from fem import Mesh
from meshes.geometry import ShoeDimensions
from meshes.rails import RailOutline, rail_outline

SAND, ROCK, STONE = 1e8, 1e9, 10.0
"""Stiffness of two grounds, N/m3, and ratio of a stone's stiffness to the ground's; assumed, no source."""
PLAUSIBLE_GROUND = (0.0, 1e11)
"""Plausible stiffness of ground, N/m3, from a hole to ten times a stone in rock."""
MEAN, PASS, DIGGING = 388e3, 574e3, 761e3
"""Forces on a rail, N: mean and greatest of a straight pass, and greatest in digging (rollers study)."""
PULL, SIDE, STRIKE = 2.6e6, 0.26e6, 1e6
"""Pull of a chain in a turn on the spot, its side force on a shoe, and a unit strike, N."""
BLOW = 25e3
"""Energy of a blow, J: a dipper of 50 t at 1 m/s; mass and speed are assumed, no source."""
WING = 0.07
"""Width of the wing at the left end, fraction of the shoe's width."""
DIGITS = 9  # digits of a size over that of the papers' shoe; further ones are rounding of a mesh
UNDER_A_SIDE = 0.05  # margin of a pressure's box beyond the loaded face, m

Side = Literal["left", "right"]
Facing = Literal["front", "rear", "left", "right", "up", "down"]
Pin = Literal["front left", "front right", "rear left", "rear right"]
PINS: tuple[Pin, ...] = get_args(Pin)


class TreadForce(Parameters):
    """Downward force of a roller's tread on one of the rails."""

    side: Side = option("rail: left (+y) or right")
    force: float = quantity("N", "downward force of a tread", (1e3, 5e6), gt=0.0, le=1e10)
    end: Literal["front", "rear"] | None = option(
        "end of the rail from which `x` is measured inward; none: from its middle", default=None
    )
    x: Place = quantity(
        "m", "distance ahead of the rail's middle, or inward of its end", (-1.0, 1.0), default=0.0
    )
    width: float | None = quantity(
        "m", "width of the contact across the rail; none: the whole tread", gt=0, le=10, default=None
    )
    across: Place = quantity("m", "outward distance from the rail's middle line", (-0.5, 0.5), default=0.0)
    length: float = quantity(
        "m", "length of the contact along the rail; shorter at an end", gt=1e-3, le=10, default=0.1
    )


class Pressure(Parameters):
    """Force spread evenly over the surface with one facing inside of a box."""

    facing: Facing = option("direction of the loaded faces")
    low: base.Three = quantity("m", "least x, y, z of the box", (-5.0, 5.0))
    high: base.Three = quantity("m", "greatest x, y, z of the box", (-5.0, 5.0))
    round: bool = option("load only on the disc or ellipse inside the box's outline", default=False)
    force: base.Vector = quantity("N", "total force", (-1e7, 1e7))


class PinForce(Parameters):
    """Force of a link pin at one joint centre."""

    pin: Pin = option("joint centre")
    force: base.Vector = quantity("N", "force of the pin on the shoe", (-1e7, 1e7))


class GroundPart(Parameters):
    """Rectangle or disc of different ground; a later one covers an earlier one."""

    low: Two = quantity("m", "least x and y", (-5.0, 5.0))
    high: Two = quantity("m", "greatest x and y", (-5.0, 5.0))
    round: bool = option("only the disc or ellipse inside the rectangle", default=False)
    height: Place = quantity("m", "height above the surrounding ground", (-0.5, 0.5), default=0.0)
    stiffness: float = quantity(
        "N/m3", "ground pressure over depth; 0: a hole", PLAUSIBLE_GROUND, ge=0, le=1e14, default=SAND
    )


class OneSidedGround(Parameters):
    """Ground of one-sided springs below the underside."""

    stiffness: float = quantity(
        "N/m3", "ground pressure over depth; 0: a hole", PLAUSIBLE_GROUND, ge=0, le=1e14, default=SAND
    )
    parts: tuple[GroundPart, ...] = option("areas of different ground", default=())


class CheckCase(Parameters):
    """Balanced loads on a shoe: alone, with ground below, or held by some of its pins."""

    name: Name = option("name of the case")
    treads: tuple[TreadForce, ...] = option("forces on the rails", default=())
    pressures: tuple[Pressure, ...] = option("forces on other parts of the surface", default=())
    pins: tuple[PinForce, ...] = option("forces of link pins", default=())
    energy: float | None = quantity(
        "J",
        "energy of a blow by the pressures, whose forces grow until shoe and ground have stored it; "
        "none: forces as given",
        gt=0,
        le=1e9,
        default=None,
    )
    held_by: tuple[Name, ...] = option(
        "pins and axes, such as 'rear left x', that balance the loads by their least forces", default=()
    )
    ground: OneSidedGround | None = option(
        "ground below the shoe; none: the shoe hangs from its pins", default=None
    )
    hand_moment: base.Component | None = quantity(
        "N m",
        "bending moment at y = 0 by hand calculation, positive with the underside in tension",
        default=None,
    )

    def _errors(self) -> parameters.Errors:
        if not (self.treads or self.pressures or self.pins):
            yield "treads, pressures or pins must be given: the shoe has no load"
        lacking = self.ground is None or not self.pressures or not self.treads or self.held_by
        if self.energy is not None and lacking:
            yield "energy must be given with treads, pressures and ground, and without held_by"


class RollerForce(Parameters):
    """Level of the force on a rail for the ready cases."""

    name: Name = option("name of the force level")
    force: float = quantity("N", "force on each rail", (1e4, 5e6), gt=0.0, le=1e10)


LEVELS = tuple(
    RollerForce(name=name, force=force)
    for name, force in {"mean": MEAN, "pass": PASS, "digging": DIGGING}.items()
)


class ShoeCheck(Parameters):
    """Shoe, its material, and its checks."""

    name: Name = option("name of the check", default="shoe")
    mesh: str = option("mesh: coarse, study or fine, or the path of a file", default="study", min_length=1)
    dimensions: dict[str, float] = option(
        "changed values of `meshes.ShoeDimensions`; netgen makes a mesh as fine as `mesh`",
        default={},
    )
    material: FatigueMaterial = option(
        "material with its cyclic strength", default=FatigueMaterial.cast_nicrmo()
    )
    track: Track | None = option("chain whose pins hold the shoe; none: the papers'", default=None)
    machine: float = quantity(
        "1",
        "scale of pulls and blows: those of the machine over those of the papers'",
        (0.001, 3.0),
        gt=0,
        le=1e3,
        default=1.0,
    )
    pins: PinCoupling = option(
        "coupling of pins and bores",
        default=COUPLING,
        validation_alias=AliasChoices("pins", "spider"),  # the second: files of earlier versions
    )
    roller_radius: base.Length = quantity(
        "m", "radius of the rollers' treads", (0.05, 1.5), default=ph4100c.ROLLER_RADIUS
    )
    tread_width: base.Length = quantity(
        "m", "width of a tread in full contact", (0.02, 1.0), default=ph4100c.TREAD_WIDTH
    )
    hours: float = quantity(
        "h", "required machine hours without a crack", (0.1, 1e6), gt=0, le=1e9, default=25_000.0
    )
    levels: tuple[RollerForce, ...] = option("force levels of the ready cases; (): none", default=LEVELS)
    cases: tuple[CheckCase, ...] = option("further cases", default=())

    def _errors(self) -> parameters.Errors:
        names = [case.name for case in self.cases]
        if double := sorted({name for name in names if names.count(name) > 1}):
            yield f"cases: names must differ, got {double} twice"


OF_CASES = {"base", "flexible", "gear", "terrain", "datasheet"}
"""Keys of case files: a case file has at least one of them, a check file none."""
OF_DUTIES = {"runs", "survivals", "stages", "plane_nodes"}
"""Keys of duty files: a duty has at least one of them, a check file none."""


def check_of(case: Case) -> ShoeCheck:
    """Return the check of a case's flexible shoes on its own track, with forces in proportion to its load.

    ValueError if the case has no flexible shoes.
    """
    machine = statics.mean_load(case) / ph4100c.PROPEL_LOAD
    machine = float(f"{machine:.3g}") if machine > 0.0 else 1.0
    levels = tuple(level.with_(force=machine * level.force) for level in LEVELS)
    shoes = case.part(FlexibleShoes)
    return ShoeCheck(
        name=case.name, mesh=shoes.mesh, pins=shoes.pins, track=case.track, machine=machine, levels=levels
    )


def read_check(path: str | Path) -> ShoeCheck:
    """Read the file of a check or of a case; a mesh's file is relative to it; raise as their readers."""
    path = Path(path)
    with reading.errors_named(path, ShoeCheck):
        content = reading.toml_content(path, "check file") if path.suffix == ".toml" else {}
    if content.keys() & OF_CASES:
        case = read_case(path).case
        if case.flexible is None:
            raise ValueError(
                f"{path}: [flexible] must be given, since its mesh is checked; or check the file of a mesh"
            )
        return check_of(case)
    if content.keys() & OF_DUTIES:
        raise ValueError(f"{path} is a duty, for the command life; a check has mesh, levels and cases")
    named = {"name": path.stem}
    check = reading.read_parameters(path, ShoeCheck, "check file", lambda content: named | content)
    beside = path.parent / check.mesh
    return check.with_(mesh=str(beside)) if beside.is_file() else check


class ShoeOutline(NamedTuple):
    """Outline of a shoe for the ready cases: rails, if any, and extents, m."""

    rails: RailOutline | None
    low: np.ndarray  # (3,), least x, y, z of the underside
    high: np.ndarray  # (3,), greatest x, y, z of the underside
    top: float  # z of the highest point
    bearing: np.ndarray  # (2, 3), least and greatest x, y, z of the loaded surface of a shoe without rails
    wing: float  # z of the highest point at the left end

    @classmethod
    def of(cls, mesh: Mesh) -> "ShoeOutline":
        """Return the outline of a shoe's mesh; raise as `rail_outline` if the mesh names a roller path."""
        under = mesh.nodes[mesh.nodes_of("underside")]
        carries = mesh.nodes[mesh.nodes_of("top")] if "top" in mesh.surfaces else mesh.nodes
        bearing = np.stack((carries.min(axis=0), carries.max(axis=0)))
        highest = float(mesh.nodes[:, 2].max())
        low = under.min(axis=0)
        high = under.max(axis=0)
        at_end = mesh.nodes[:, 1] > high[1] - WING * (high[1] - low[1])
        return cls(_rails_of(mesh), low, high, highest, bearing, float(mesh.nodes[at_end, 2].max()))

    @property
    def along(self) -> float:
        """Length of the underside over that of the papers' shoe; distances along x scale with it."""
        return float(f"{(self.high[0] - self.low[0]) / ShoeDimensions.plate_length:.{DIGITS}g}")

    @property
    def beside(self) -> float:
        """Width of the underside over that of the papers' shoe; distances along y scale with it."""
        return float(f"{(self.high[1] - self.low[1]) / ShoeDimensions.width:.{DIGITS}g}")


def _rails_of(mesh: Mesh) -> RailOutline | None:
    """Return the rails of a mesh; None if it has no roller path and its top is not two bands."""
    try:
        return rail_outline(mesh)
    except ValueError:
        if "roller path" in mesh.surfaces:
            raise
        return None


Loads = Iterator[dict[str, Any]]
"""Fields of check cases that differ from those of a machine above the middle of a shoe on even sand."""


def ready_cases(outline: ShoeOutline, force: float, machine: float = 1.0) -> list[CheckCase]:
    """Return the ready check cases of a shoe with a force (N) on each rail; without rails both on the top.

    `machine` is the ratio of its pulls and strikes to those of the papers' machine. Distances are those of
    the papers' shoe in proportion to the size of the shoe.
    """
    carried: dict[str, Any] = {"ground": OneSidedGround()}
    carried |= {"treads": _rolled(force)} if outline.rails else {"pressures": [_on_top(outline, force)]}
    if outline.rails is None:
        kinds = [
            _supports(outline, force),
            _turns(outline, force, machine),
            _strikes(outline, force, machine),
        ]
    else:
        kinds = [
            _supports(outline, force),
            _rail_ends(outline, outline.rails, force),
            _turns(outline, force, machine),
        ]
        kinds += [_drives(outline, outline.rails, machine), _strikes(outline, force, machine)]
    return [CheckCase(**carried | loads) for kind in kinds for loads in kind]


def _rolled(force: float, **place: Any) -> list[TreadForce]:
    """Return the treads of a roller on both rails."""
    return [TreadForce(side=side, force=force, **place) for side in get_args(Side)]


def _on_top(outline: ShoeOutline, force: float) -> Pressure:
    """Return the force of two rails spread over the top."""
    low, high = outline.bearing + UNDER_A_SIDE * np.array([[-1.0], [1.0]])
    return Pressure.model_validate(
        {"facing": "up", "low": tuple(low), "high": tuple(high), "force": (0, 0, -2 * force)}
    )


def _supports(outline: ShoeOutline, force: float) -> Loads:
    """Yield cases of ground that bears on all or parts of the underside, or of a load on one rail."""
    (x0, y0, _) = outline.low
    (x1, y1, _) = outline.high
    along = outline.along
    beside = outline.beside
    rails = outline.rails
    half = 0.5 * (y1 - y0)
    arm = None if rails is None else 0.5 * (rails.left - rails.right)

    def case(name: str, stiffness: float, lever: float | None = None, *parts: GroundPart) -> dict[str, Any]:
        # a hand calculation exists if two rails carry the force
        by_hand = None if lever is None or arm is None else force * (lever - arm)
        ground = OneSidedGround(stiffness=stiffness, parts=parts)
        return {"name": name, "ground": ground, "hand_moment": by_hand}

    def part(low: Two, high: Two, stiffness: float, **shape: Any) -> GroundPart:
        return GroundPart(low=low, high=high, stiffness=stiffness, **shape)

    def stone(y: float, ground: float) -> GroundPart:
        x = x1 - 0.045 * along
        size = 0.15 * along
        low = (x - size, y - size)
        high = (x + size, y + size)
        return part(low, high, STONE * ground, round=True, height=0.05 * along)

    yield case("even, sand", SAND, half / 2)
    yield case("even, rock", ROCK, half / 2)
    for w in (0.2 * beside, 0.5 * beside):
        hole = part((x0, y0 + w), (x1, y1 - w), 0.0)
        yield case(f"both ends {w:.3g} m", SAND, half - w / 2, hole)
    middle = 0.5 * (y0 + y1)
    w = 0.2 * beside
    yield case(f"ridge {2 * w:.3g} m", 0.0, w / 2, part((x0, middle - w), (x1, middle + w), SAND))
    a, b = 0.3 * along, 0.3 * beside
    corners = part((x1 - a, y1 - b), (x1, y1), ROCK), part((x0, y0), (x0 + a, y0 + b), ROCK)
    yield case(f"diagonal corners {b:.3g} m", 0.0, half - b / 2, *corners)
    yield case("stone at the edge, rock", ROCK, None, stone(middle + 1.3 * beside, ROCK))
    yield case("stone at the edge, sand", SAND, None, stone(middle + 1.6 * beside, SAND))
    if rails is not None:
        yield {"name": "one rail", "treads": [TreadForce(side="left", force=2.0 * force)]}


def _rail_ends(outline: ShoeOutline, rails: RailOutline, force: float) -> Loads:
    """Yield cases of a roller at the ends of the rails, on their whole width and on their outer third."""
    third = rails.width / 3
    widths = {"": {}, ", outer third": {"width": third, "across": third}}
    near = 0.02 * outline.along
    for end, x, (words, width) in itertools.product(("front", "rear"), (0.0, near), widths.items()):
        name = f"roller {1e3 * x:.3g} mm from the {end} end{words}"
        yield {"name": name, "treads": _rolled(force, end=end, x=x, **width)}


def _turns(outline: ShoeOutline, force: float, machine: float) -> Loads:
    """Yield cases of a turning chain's pull, shared by the pins; rails or pins hold the side force."""
    under = {"low": tuple(outline.low - UNDER_A_SIDE), "high": tuple(outline.high + UNDER_A_SIDE)}
    pull = machine * PULL
    push = machine * SIDE
    pushed = Pressure.model_validate({"facing": "down", "force": (0.0, push, 0.0), **under})
    carried = [] if outline.rails else [_on_top(outline, force)]
    along = [f"{pin} x" for pin in PINS]
    holds = {"two pins": ["rear left y", "rear right y", *along], "one pin": ["rear left y", *along]}
    at_rails = []
    if (rails := outline.rails) is not None:
        side = rails.left + rails.width / 2
        reach = 0.1 * outline.along
        low = (-reach, side - 0.005, rails.height - 0.025 * outline.along)
        high = (reach, side + 0.005, outline.top + 0.01)
        at_rails = [Pressure(facing="left", low=low, high=high, force=(0.0, -push, 0.0))]
        holds = {"rails": along, **holds}
    for share, (where, held) in itertools.product((0.5, 0.7, 1.0), holds.items()):
        pulls = dict(zip(PINS, (share, 1.0 - share, -share, share - 1.0), strict=True))
        yield {
            "name": f"turn {100 * share:g}/{100 - 100 * share:g}, side force at {where}",
            "pins": [PinForce(pin=pin, force=(part * pull, 0.0, 0.0)) for pin, part in pulls.items() if part],
            "pressures": [*carried, pushed, *(at_rails if where == "rails" else ())],
            "held_by": held,
        }


def _drives(outline: ShoeOutline, rails: RailOutline, machine: float) -> Loads:
    """Yield cases of a tumbler's push on the web between the rails, forward and backward."""
    inner = rails.left - rails.width / 2
    upward = outline.along
    pull = machine * PULL
    for name, facing, push, low, high in (
        ("forward", "rear", pull, outline.low[0], 0.0),
        ("back", "front", -pull, 0.0, outline.high[0]),
    ):
        box = {"low": (low, -inner, -0.1 * upward), "high": (high, inner, 0.15 * upward)}
        pressure = Pressure.model_validate({"facing": facing, "force": (push, 0.0, 0.0), **box})
        held = [*(f"{pin} x" for pin in PINS if pin.startswith(facing)), *(f"{pin} z" for pin in PINS)]
        yield {
            "name": f"drive push {name}",
            "treads": [],
            "ground": None,
            "pressures": [pressure],
            "held_by": held,
        }


def _strikes(outline: ShoeOutline, force: float, machine: float) -> Loads:
    """Yield cases of a dipper that strikes the end of a wing."""
    x1, y1, _ = outline.high
    lowest = outline.wing - 0.1 * outline.along
    carried = [] if outline.rails else [_on_top(outline, force)]
    for name, from_x in (("tip", outline.low[0]), ("edge", 0.1 * outline.along)):
        low = (from_x, y1 - 0.25 * outline.beside, lowest)
        high = (x1, y1, outline.top + 0.1)
        strike = Pressure(facing="up", low=low, high=high, force=(0.0, 0.0, -machine * STRIKE))
        size = f"{machine * STRIKE / 1e6:.3g} MN"
        yield {"name": f"strike of {size} on the wing's {name}", "pressures": [*carried, strike]}
        if outline.rails is not None:
            energy = machine * BLOW
            words = f"strike of {energy / 1e3:.3g} kJ on the wing's {name}"
            yield {"name": words, "pressures": [strike], "energy": energy}


def ready_cycles(outline: ShoeOutline) -> list[tuple[str, str]]:
    """Return cycles between two ready cases, for each level; their loaded cases have the machine's load."""
    both_ends = f"both ends {0.2 * outline.beside:.3g} m"
    return [("even, sand", both_ends), (f"ridge {0.4 * outline.beside:.3g} m", both_ends)]
