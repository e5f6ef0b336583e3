"""Datasheet of a machine on two tracks: makers' figures; any subset that determines the machine is enough."""

from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator

from exudyn_crawler.case.parameters import base
from exudyn_crawler.case.parameters.track import mesh_beside
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines.datasheet import makers
from exudyn_crawler.machines.datasheet.typical import Typical, row_of
from exudyn_crawler.origins import Ruled
from exudyn_crawler.settings import fields, parameters
from exudyn_crawler.settings.parameters import Errors, Parameters, option, quantity

Kind = Literal["excavator", "dozer", "loader", "shovel", "crane", "drill", "paver", "vehicle"]
ShoeKind = Literal["single grouser", "double grouser", "triple grouser", "plain", "mining"]
LEAST_GAPS = 7.0
GREATEST_GAPS = 30.0
OF_RUN = ("travel", "speed", "grade", "shoe_mesh")
"""Values of a datasheet that do not change the machine."""


class DatasheetError(ParameterError):
    """Error of a datasheet that contradicts itself or gives no machine: a line in its own terms."""


class LiftPoint(Parameters):
    """Entry of a lift chart: a load at a radius."""

    radius: base.Length = quantity("m", "of the load from the swing axis", (1.0, 60.0))
    load: base.Mass = quantity("kg", "that the chart prints there, limited by tipping", (50.0, 1e6))


class LiftChart(Parameters):
    """Loads limited by tipping at one height and direction: those printed without an asterisk."""

    over: Literal["side", "front"] = option("direction of the boom: side, or front along the tracks", "side")
    tipping_share: float = quantity(
        "1", "of the tipping load that is printed", (0.6, 0.9), gt=0, le=1, default=0.75
    )
    points: parameters.Several[LiftPoint]

    def _errors(self) -> Errors:
        if len({point.radius for point in self.points}) < 2:
            yield f"points must have two or more radii, got {[point.radius for point in self.points]}"


class Datasheet(Parameters):
    """Maker's figures of a machine on two tracks; missing ones are derived or typical.

    Positions start at the middle of the length on ground, x to the front of the machine, z from the ground.
    """

    listed_by: ClassVar[str] = "exudyn-crawler machine --keys"

    kind: Kind = option("of machine, whose typical values it has", "excavator")
    operating_weight: base.Mass = quantity("kg", "of the whole machine", (1e3, 2e6))
    length_on_ground: base.Length | None = quantity(
        "m",
        "between the axes of sprocket and idler, or of the outer road wheels",
        (1.0, 15.0),
        default=None,
    )
    sprocket_to_idler: base.Length | None = quantity(
        "m", "between their axes, where it is not the length on ground", (1.0, 15.0), default=None
    )
    sprocket_height: base.Length | None = quantity(
        "m", "of its axis above the ground; none: as low as the rollers let it", (0.1, 3.0), default=None
    )
    idler_height: base.Length | None = quantity(
        "m",
        "of the idler's axis above the ground; none: as low as the rollers let it",
        (0.1, 3.0),
        default=None,
    )
    first_roller: base.Length | None = quantity(
        "m",
        "from the sprocket's axis to that of the roller or road wheel next to it",
        (0.1, 3.0),
        default=None,
    )
    roller_diameter: base.Length | None = quantity(
        "m", "of the treads of lower rollers or road wheels", (0.06, 1.5), default=None
    )
    idler_diameter: base.Length | None = quantity("m", "of the idler's treads", (0.1, 2.5), default=None)
    carrier_diameter: base.Length | None = quantity("m", "of the carriers' treads", (0.04, 1.0), default=None)
    crawler_length: base.Length | None = quantity(
        "m", "over the shoes of one crawler", (1.2, 20.0), default=None
    )
    gauge: base.Length | None = quantity("m", "between the tracks' middles", (0.8, 15.0), default=None)
    width_over_shoes: base.Length | None = quantity(
        "m", "over both crawlers, in place of the gauge", (1.2, 20.0), default=None
    )
    shoe_width: base.Length = quantity("m", "of a shoe", (0.2, 4.0))
    shoes: int | None = quantity("1", "shoes of one track", (25, 120), ge=10, le=500, default=None)
    pitch: base.Length | None = quantity("m", "of the chain", (0.08, 1.0), default=None)
    shoe_weight: base.Mass | None = quantity(
        "kg", "of a shoe with its link, pin and bush", (2.0, 1e4), default=None
    )
    shoe_kind: Literal["single grouser", "double grouser", "triple grouser", "plain", "mining"] | None = (
        option("of the ready shoe that the command `shoe` fits to it; none: as its kind has", None)
    )
    shoe_mesh: Annotated[str, AfterValidator(mesh_beside)] | None = option(
        "mesh of its shoes, which have its mass, pins and rails; none: plate and links as boxes",
        None,
    )
    grouser_height: base.Extent | None = quantity("m", "of the grousers", (0.0, 0.15), default=None)
    lower_rollers: int | None = quantity(
        "1", "lower rollers of one track", (4, 20), ge=2, le=60, default=None
    )
    bogies: int = quantity(
        "1",
        "bogies of one track, each with two of its lower rollers, from the front",
        (0, 6),
        ge=0,
        le=30,
        default=0,
    )
    suspension: Literal["rigid", "arms"] | None = option(
        "of lower rollers or road wheels: fixed in the frame, or on sprung arms; none: as its kind has", None
    )
    arm_pivot: base.Two | None = quantity(
        "m", "pivot of a road wheel's arm ahead of its axis and above it; behind it: negative", default=None
    )
    arm_weight: base.Mass | None = quantity("kg", "of an arm with its road wheel", (10.0, 2e3), default=None)
    torsion_bar: base.Stiffness | None = quantity(
        "N m/rad", "of the spring of an arm", (1e3, 1e6), default=None
    )
    arm_damping: base.Damping | None = quantity("N m s/rad", "of an arm", (0.0, 1e5), default=None)
    recoil_spring: bool | None = option(
        "true where the idler gives way on a spring; none: as machines of its kind have it", None
    )
    recoil_force: makers.Force | None = quantity(
        "N", "of the recoil spring as it is installed", (1e4, 1e7), gt=0, le=1e10, default=None
    )
    carrier_rollers: int | None = quantity(
        "1", "carrier rollers of one track", (0, 8), ge=0, le=60, default=None
    )
    sprocket_gaps: float | None = quantity(
        "1",
        "shoes that a whole turn of the sprocket moves: half of its teeth where they mesh every other time",
        (9.0, 14.0),
        ge=LEAST_GAPS,
        le=GREATEST_GAPS,
        default=None,
    )
    sprocket: Literal["rear", "front"] = option("end at which the sprocket is", "rear")
    ground_pressure: makers.Pressure | None = quantity(
        "Pa", "mean below both tracks, as printed", (1e4, 5e5), ge=1e3, le=1e7, default=None
    )
    contact_area: float | None = quantity(
        "m2", "of both tracks on the ground, as printed", (0.3, 100.0), ge=0.01, le=1e4, default=None
    )
    drawbar_pull: makers.Force | None = quantity(
        "N", "greatest pull of both tracks", (1e3, 1e7), ge=1.0, le=1e9, default=None
    )
    travel_speed: base.Speed | None = quantity("m/s", "greatest, on the level", (0.1, 20.0), default=None)
    gradeability: makers.Slope | None = quantity(
        "1", "steepest grade that it climbs, rise over run", (0.1, 1.0), gt=0, le=2, default=None
    )
    power: float | None = quantity(
        "W", "of the engine or of the travel drives", (1e4, 3e6), ge=1.0, le=1e9, default=None
    )
    motor_speed: float | None = quantity(
        "rad/s", "greatest, of a travel motor", (20.0, 800.0), ge=0.1, le=1e4, default=None
    )
    motor_torque: float | None = quantity(
        "N m", "greatest, of a travel motor", (10.0, 3e4), ge=0.1, le=1e7, default=None
    )
    gear_ratio: float | None = quantity(
        "1", "speed of the travel motor over that of the sprocket", (5.0, 500.0), ge=1.0, le=1e4, default=None
    )
    ground_clearance: base.Length | None = quantity("m", "of the car body", (0.1, 3.0), default=None)
    upper_weight: base.Mass | None = quantity(
        "kg",
        "of the upper structure with its front, or of what is above the track frames",
        (100.0, 1.5e6),
        default=None,
    )
    upper_com: base.Three | None = quantity(
        "m", "COM of the upper structure with its front straight ahead", (-20.0, 20.0), default=None
    )
    com_ahead: base.Place | None = quantity(
        "m", "COM of the whole machine ahead of the middle", (-3.0, 3.0), default=None
    )
    lift_chart: LiftChart | None = option(
        "loads over radii, of which front and COM follow; none: no chart", None
    )
    sag: base.Length | None = quantity("m", "of the upper run at rest, as its maker asks for", default=None)
    chain_tension: makers.Force | None = quantity(
        "N", "of the chain at rest, in place of a sag", (1e3, 1e7), gt=0, le=1e10, default=None
    )
    travel: Literal["straight", "backward", "on the spot"] = option("what a run does", "straight")
    grade: makers.Slope = quantity(
        "1", "of the ground of a run, uphill as it travels", (-0.3, 0.3), gt=-1, lt=1, default=0.0
    )
    speed: base.Speed | None = quantity(
        "m/s", "of the chains in a run; none: slow travel", (0.01, 5.0), default=None
    )
    source: str = option("where its values are printed", "")
    began_as: str | None = option(
        "machine of the library whose values the file began with; none: that of the same source, if any", None
    )
    remembered: tuple[str, ...] = option("values of it that were not seen in a source: shown as assumed", ())
    typical: Typical = option("typical values in place of those of the table", Typical())

    def _errors(self) -> Errors:
        if self.gauge is None and self.width_over_shoes is None:
            yield "gauge must be given, or width_over_shoes, of which it is the rest less a shoe"
        elif self.gauge is not None and self.width_over_shoes is not None:
            yield "gauge and width_over_shoes must not be given together"
        if self.track_gauge <= self.shoe_width:
            got = f"{self.track_gauge:g} m with shoes of {self.shoe_width:g} m"
            yield f"gauge must be greater than the shoes' width, or both tracks are one, got {got}"
        free = self.sprocket_to_idler is not None
        needed = ("shoes", "pitch", "idler_diameter", "sprocket_gaps", "length_on_ground", "first_roller")
        if free and (missing := [name for name in needed if getattr(self, name) is None]):
            yield f"{', '.join(missing)} must be given with sprocket_to_idler: all set the chain's path"
        motor = [name for name in ("motor_speed", "motor_torque") if getattr(self, name) is not None]
        if motor and self.gear_ratio is None:
            yield f"gear_ratio must be given with {' and '.join(motor)}: the sprocket is behind it"
        if self.suspension != "arms" and self.kind != "vehicle":
            arm = [
                name
                for name in ("arm_pivot", "arm_weight", "torsion_bar", "arm_damping")
                if getattr(self, name)
            ]
            if arm:
                yield f"{', '.join(arm)} must be left out, or suspension = 'arms' given"
        if self.arm_pivot is not None and self.arm_pivot[0] == 0.0:
            yield f"arm_pivot must be ahead of the wheel's axis or behind it, got {list(self.arm_pivot)}"
        if self.recoil_spring is False and self.recoil_force is not None:
            yield "recoil_force must be left out where recoil_spring is false"
        if self.sag is not None and self.chain_tension is not None:
            yield "sag and chain_tension must not be given together: each is the tension at rest"
        no_figures = ("remembered", "typical", "source", "began_as")
        known = [name for name in type(self).model_fields if name not in no_figures]
        unknown = [name for name in self.remembered if name not in known]
        if unknown:
            yield f"remembered must be names of the datasheet's values, got {fields.shown(unknown)}"
        on_track = (self.length_on_ground, self.crawler_length, self.contact_area, self.ground_pressure)
        if not any(on_track) and self.shoes is None:
            yield (
                "length_on_ground must be given, or one of crawler_length, contact_area, ground_pressure and "
                "shoes, of which it follows"
            )

    @property
    def track_gauge(self) -> float:
        """Distance between the tracks' middles, m."""
        if self.gauge is not None:
            return self.gauge
        assert self.width_over_shoes is not None
        return self.width_over_shoes - self.shoe_width

    def typical_value(self, name: str) -> float:
        """Return a typical value: the datasheet's own, else that of its kind of machine."""
        own = getattr(self.typical, name)
        return row_of(name, self.kind).value if own is None else float(own)

    def counted_length(self, gravity: float) -> Ruled | None:
        """Return the length of a track (m) that counts as its contact.

        It follows from the printed area, or else from the printed pressure; None without these.
        """
        if self.contact_area is not None:
            return Ruled(self.contact_area / (2.0 * self.shoe_width), "contact area")
        if self.ground_pressure is not None:
            force = self.operating_weight * gravity
            return Ruled(force / (2.0 * self.shoe_width * self.ground_pressure), "ground pressure")
        return None

    @property
    def has_arms(self) -> bool:
        """True if lower rollers or road wheels are on sprung arms."""
        return (self.suspension or ("arms" if self.kind == "vehicle" else "rigid")) == "arms"

    @property
    def has_road_wheels(self) -> bool:
        """True for a vehicle on arms: sprocket and idler lie beyond its outer road wheels."""
        return self.kind == "vehicle" and self.has_arms


FIGURES = tuple(
    name for name, field in Datasheet.model_fields.items() if fields.has_unit(field) and name not in OF_RUN
)
"""Names of the maker's figures: all quantities of the machine itself."""
