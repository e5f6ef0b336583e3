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

    radius: base.Length = quantity("m", "radius of the load from the swing axis", (1.0, 60.0))
    load: base.Mass = quantity("kg", "load of the chart at this radius, limited by tipping", (50.0, 1e6))


class LiftChart(Parameters):
    """Loads limited by tipping at one height and direction: those printed without an asterisk."""

    over: Literal["side", "front"] = option("direction of the boom: side, or front along the tracks", "side")
    tipping_share: float = quantity(
        "1", "loads of the chart, fraction of the tipping load", (0.6, 0.9), gt=0, le=1, default=0.75
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

    kind: Kind = option("kind of machine; it selects the typical values", "excavator")
    operating_weight: base.Mass = quantity("kg", "operating weight of the whole machine", (1e3, 2e6))
    length_on_ground: base.Length | None = quantity(
        "m",
        "distance between the axes of sprocket and idler, or of the outer road wheels",
        (1.0, 15.0),
        default=None,
    )
    sprocket_to_idler: base.Length | None = quantity(
        "m",
        "distance between the axes of sprocket and idler, if it is not the length on ground",
        (1.0, 15.0),
        default=None,
    )
    sprocket_height: base.Length | None = quantity(
        "m",
        "height of the sprocket's axis above the ground; none: the least that the rollers allow",
        (0.1, 3.0),
        default=None,
    )
    idler_height: base.Length | None = quantity(
        "m",
        "height of the idler's axis above the ground; none: the least that the rollers allow",
        (0.1, 3.0),
        default=None,
    )
    first_roller: base.Length | None = quantity(
        "m",
        "distance from the sprocket's axis to that of the adjacent roller or road wheel",
        (0.1, 3.0),
        default=None,
    )
    roller_diameter: base.Length | None = quantity(
        "m", "diameter of the treads of lower rollers or road wheels", (0.06, 1.5), default=None
    )
    idler_diameter: base.Length | None = quantity(
        "m", "diameter of the idler's treads", (0.1, 2.5), default=None
    )
    carrier_diameter: base.Length | None = quantity(
        "m", "diameter of the carrier rollers' treads", (0.04, 1.0), default=None
    )
    crawler_length: base.Length | None = quantity(
        "m", "length of one crawler over its shoes", (1.2, 20.0), default=None
    )
    gauge: base.Length | None = quantity(
        "m", "distance between the middles of both tracks", (0.8, 15.0), default=None
    )
    width_over_shoes: base.Length | None = quantity(
        "m", "width over both crawlers, in place of the gauge", (1.2, 20.0), default=None
    )
    shoe_width: base.Length = quantity("m", "width of a shoe", (0.2, 4.0))
    shoes: int | None = quantity("1", "number of shoes of one track", (25, 120), ge=10, le=500, default=None)
    pitch: base.Length | None = quantity("m", "pitch of the chain", (0.08, 1.0), default=None)
    shoe_weight: base.Mass | None = quantity(
        "kg", "mass of a shoe with its link, pin and bush", (2.0, 1e4), default=None
    )
    shoe_kind: Literal["single grouser", "double grouser", "triple grouser", "plain", "mining"] | None = (
        option(
            "kind of the ready shoe that the command `shoe` fits to the machine; none: that of the kind "
            "of machine",
            None,
        )
    )
    shoe_mesh: Annotated[str, AfterValidator(mesh_beside)] | None = option(
        "mesh of the shoes, from which mass, pins and rails follow; none: plate and links as boxes",
        None,
    )
    grouser_height: base.Extent | None = quantity("m", "height of the grousers", (0.0, 0.15), default=None)
    lower_rollers: int | None = quantity(
        "1", "number of lower rollers of one track", (4, 20), ge=2, le=60, default=None
    )
    bogies: int = quantity(
        "1",
        "number of bogies of one track, each with two of its lower rollers, from the front",
        (0, 6),
        ge=0,
        le=30,
        default=0,
    )
    suspension: Literal["rigid", "arms"] | None = option(
        "suspension of lower rollers or road wheels: rigid in the frame, or sprung arms; none: that "
        "of the kind",
        None,
    )
    arm_pivot: base.Two | None = quantity(
        "m",
        "distance of an arm's pivot ahead of its road wheel's axis, and above it; negative: behind",
        default=None,
    )
    arm_weight: base.Mass | None = quantity(
        "kg", "mass of an arm with its road wheel", (10.0, 2e3), default=None
    )
    torsion_bar: base.Stiffness | None = quantity(
        "N m/rad", "stiffness of the spring of an arm", (1e3, 1e6), default=None
    )
    arm_damping: base.Damping | None = quantity(
        "N m s/rad", "damping coefficient of an arm", (0.0, 1e5), default=None
    )
    recoil_spring: bool | None = option(
        "recoil spring behind the idler; none: as usual for the kind of machine", None
    )
    recoil_force: makers.Force | None = quantity(
        "N", "force of the recoil spring as installed", (1e4, 1e7), gt=0, le=1e10, default=None
    )
    carrier_rollers: int | None = quantity(
        "1", "number of carrier rollers of one track", (0, 8), ge=0, le=60, default=None
    )
    sprocket_gaps: float | None = quantity(
        "1",
        "shoes that pass in one turn of the sprocket: its teeth, or half of them on a half-pitch sprocket",
        (9.0, 14.0),
        ge=LEAST_GAPS,
        le=GREATEST_GAPS,
        default=None,
    )
    sprocket: Literal["rear", "front"] = option("end of the track with the sprocket", "rear")
    ground_pressure: makers.Pressure | None = quantity(
        "Pa", "mean ground pressure below both tracks, as printed", (1e4, 5e5), ge=1e3, le=1e7, default=None
    )
    contact_area: float | None = quantity(
        "m2",
        "contact area of both tracks with the ground, as printed",
        (0.3, 100.0),
        ge=0.01,
        le=1e4,
        default=None,
    )
    drawbar_pull: makers.Force | None = quantity(
        "N", "greatest drawbar pull of both tracks", (1e3, 1e7), ge=1.0, le=1e9, default=None
    )
    travel_speed: base.Speed | None = quantity(
        "m/s", "greatest travel speed on level ground", (0.1, 20.0), default=None
    )
    gradeability: makers.Slope | None = quantity(
        "1", "steepest grade that the machine climbs, rise over run", (0.1, 1.0), gt=0, le=2, default=None
    )
    power: float | None = quantity(
        "W", "power of the engine or of the travel drives", (1e4, 3e6), ge=1.0, le=1e9, default=None
    )
    motor_speed: float | None = quantity(
        "rad/s", "greatest speed of a travel motor", (20.0, 800.0), ge=0.1, le=1e4, default=None
    )
    motor_torque: float | None = quantity(
        "N m", "greatest torque of a travel motor", (10.0, 3e4), ge=0.1, le=1e7, default=None
    )
    gear_ratio: float | None = quantity(
        "1", "speed of the travel motor over that of the sprocket", (5.0, 500.0), ge=1.0, le=1e4, default=None
    )
    ground_clearance: base.Length | None = quantity(
        "m", "clearance of the car body above the ground", (0.1, 3.0), default=None
    )
    upper_weight: base.Mass | None = quantity(
        "kg",
        "mass of the upper structure with its front, or of all parts above the track frames",
        (100.0, 1.5e6),
        default=None,
    )
    upper_com: base.Three | None = quantity(
        "m", "COM of the upper structure with its front straight ahead", (-20.0, 20.0), default=None
    )
    com_ahead: base.Place | None = quantity(
        "m",
        "distance of the whole machine's COM ahead of the middle of the length on ground",
        (-3.0, 3.0),
        default=None,
    )
    lift_chart: LiftChart | None = option(
        "loads over radii, from which mass and COM of the front follow; none: no chart", None
    )
    sag: base.Length | None = quantity(
        "m", "sag of the upper run at rest that the maker requires", default=None
    )
    chain_tension: makers.Force | None = quantity(
        "N", "tension of the chain at rest, in place of a sag", (1e3, 1e7), gt=0, le=1e10, default=None
    )
    travel: Literal["straight", "backward", "on the spot"] = option(
        "motion of the machine in a run", "straight"
    )
    grade: makers.Slope = quantity(
        "1",
        "grade of the ground in a run, positive uphill in the direction of travel",
        (-0.3, 0.3),
        gt=-1,
        lt=1,
        default=0.0,
    )
    speed: base.Speed | None = quantity(
        "m/s", "speed of the chains in a run; none: slow travel", (0.01, 5.0), default=None
    )
    source: str = option("source of the figures", "")
    began_as: str | None = option(
        "machine of the library whose values the file began with; none: the one with the same source, if any",
        None,
    )
    remembered: tuple[str, ...] = option(
        "names of figures that were not seen in a source; they are shown as assumed", ()
    )
    typical: Typical = option("typical values that replace those of the table", Typical())

    def _errors(self) -> Errors:
        if self.gauge is None and self.width_over_shoes is None:
            yield "gauge or width_over_shoes must be given"
        elif self.gauge is not None and self.width_over_shoes is not None:
            yield "gauge and width_over_shoes must not be given together"
        if self.track_gauge <= self.shoe_width:
            got = f"{self.track_gauge:g} m with shoes of {self.shoe_width:g} m"
            yield f"gauge must be greater than shoe_width, otherwise both tracks overlap, got {got}"
        free = self.sprocket_to_idler is not None
        needed = ("shoes", "pitch", "idler_diameter", "sprocket_gaps", "length_on_ground", "first_roller")
        if free and (missing := [name for name in needed if getattr(self, name) is None]):
            yield f"{', '.join(missing)} must be given with sprocket_to_idler, to determine the chain's path"
        motor = [name for name in ("motor_speed", "motor_torque") if getattr(self, name) is not None]
        if motor and self.gear_ratio is None:
            yield f"gear_ratio must be given with {' and '.join(motor)}, to get the torque of the sprocket"
        if self.suspension != "arms" and self.kind != "vehicle":
            arm = [
                name
                for name in ("arm_pivot", "arm_weight", "torsion_bar", "arm_damping")
                if getattr(self, name)
            ]
            if arm:
                yield f"{', '.join(arm)} must be left out, or suspension must be 'arms'"
        if self.arm_pivot is not None and self.arm_pivot[0] == 0.0:
            yield f"arm_pivot must be ahead of the wheel's axis or behind it, got {list(self.arm_pivot)}"
        if self.recoil_spring is False and self.recoil_force is not None:
            yield "recoil_force must be left out with recoil_spring = false"
        if self.sag is not None and self.chain_tension is not None:
            yield "sag and chain_tension must not be given together: each determines the tension at rest"
        no_figures = ("remembered", "typical", "source", "began_as")
        known = [name for name in type(self).model_fields if name not in no_figures]
        unknown = [name for name in self.remembered if name not in known]
        if unknown:
            yield f"remembered must contain keys of the datasheet, got {fields.shown(unknown)}"
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
