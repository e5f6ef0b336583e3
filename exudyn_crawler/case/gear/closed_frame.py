"""Side frame of a closed track: its parameters and the positions of its wheels."""

import math
from typing import Literal

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.base import WheelLabel, Whole
from exudyn_crawler.case.gear.running_gear import RunningGear, overlap_errors
from exudyn_crawler.case.parameters import base
from exudyn_crawler.case.parameters.closed_track import Idler, Play, Tumbler, Wheel
from exudyn_crawler.case.parameters.track import SIDES, Shoe, Track
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, option, quantity

MAKERS_SAG = 0.025
"""Default sag of a chain, fraction of the free span between idler and carrier (chosen here)."""
DEEPEST = 0.1
"""Greatest sag from which a search for a pretension starts, fraction of the span."""
LEAST_SAG, GREATEST_SAG = 0.007, 0.04
"""Least and greatest sag that makers ask for, fraction of the span.

They ask for 5 to 15 mm (excavator of 2.7 t) and 10 to 30 mm (of 12 to 21 t; Komatsu PC27MR, PC118MR-8 and
PC210-11), 50 mm (dozers of Caterpillar), 25 to 63 and 38 to 76 mm (crawler cranes Manitowoc 2250 and 16000).
None of these texts gives the span; 0.7, 1.2, 1.3 and 1.9 m are assumed.
"""


class ClosedFrame(RunningGear):
    """Side frame of a closed track with what guides, drives and tightens the chain.

    The tumbler is at the rear. On posts the frame is held above the ground; on the ground its y and yaw are
    held.
    """

    support: Literal["ground", "posts"] = option(
        "support of the frame: the ground through its track, or posts", "ground"
    )
    mass: base.Mass = quantity(
        "kg",
        "mass on one track without shoes, tumbler and sliding idler; kind 'machine': the side frame's",
        (1e2, 2e6),
    )
    tumbler: Tumbler
    idler: Idler
    roller_radius: base.Length = quantity("m", "radius of the rollers' treads", (0.03, 1.5))
    carriers: tuple[Wheel, ...] = quantity(
        "m",
        "x and z of the carrier rollers below the upper run, rear to front; none: a free upper run",
        default=(),
    )
    carrier_radius: base.Length = quantity(
        "m", "radius of the carrier rollers' treads", (0.02, 1.0), default=0.25
    )
    slides: tuple[base.Three, ...] = quantity(
        "m",
        "x of rear and front end and z of the top of slides below the upper run, rear to front",
        default=(),
    )
    slide_step: base.Length = quantity(
        "m",
        "spacing of the contact lines of rails on a slide; they have a carrier's radius",
        (0.1, 2.0),
        default=0.45,
    )
    slide_friction: base.Coefficient = quantity(
        "1",
        "friction coefficient of rails on slides; 0 at rest, like the rolling resistance",
        (0.05, 0.8),
        default=ph4100c.SLIDE_FRICTION,
    )
    guide_play: base.Extent = quantity("m", "clearance of a shoe to each side of a flange", (0.0, 0.1))
    guide_height: base.Depth = quantity("m", "height of the flanges above a tread", (0.005, 0.3))
    guide_stiffness: base.Stiffness = quantity(
        "N/m", "contact stiffness of the flanges of a wheel, and of the tumbler's", (1e5, 1e10)
    )
    guide_damping: base.Damping = quantity("N s/m", "contact damping of these flanges", (0.0, 1e8))
    pitch_growth: float = quantity(
        "1",
        "growth of the chain's pitch by wear, fraction of the pitch",
        (0.0, 0.05),
        ge=-0.1,
        le=0.2,
        default=0.0,
    )
    compliance: float = quantity(
        "m/N",
        "lateral compliance of a pin; in rad/(N m) also its compliance in yaw and roll",
        (1e-12, 1e-8),
        gt=0,
        le=1e-3,
        default=1e-10,
    )
    play: Play | None = option("play of the pins in their bores; none: ideal joints", None)
    tension_limit: float | None = quantity(
        "N", "tension at which a link breaks and the run ends; none: no limit", gt=0, le=1e12, default=None
    )
    fold_limit: float = quantity(
        "rad",
        "angle between neighbouring shoes at which the chain folds and the run ends",
        (0.3, 1.6),
        gt=0,
        le=3,
        default=1.0,
    )
    offset_limit: base.Length = quantity(
        "m",
        "lateral offset from frame or neighbour at which a shoe comes off and the run ends",
        (0.02, 0.5),
        default=0.1,
    )
    torque_limit: float | None = quantity(
        "N m",
        "greatest torque of the drive; none: any torque that the speed requires",
        gt=0,
        le=1e12,
        default=None,
    )
    torque_speed: base.Speed = quantity(
        "rad/s",
        "speed deficit of the tumbler at which the drive has 0.7 of its greatest torque; a tenth of the speed"
        " at most, and nearly none at rest",
        (1e-5, 1.0),
        default=0.01,
    )

    def _errors(self) -> Errors:
        yield from overlap_errors("rollers", self.rollers, self.roller_radius)
        yield from overlap_errors("carriers", [x for x, _ in self.carriers], self.carrier_radius)
        ends = [x for rear, front, _ in self.slides for x in (rear, front)]
        if np.any(np.diff(ends) <= 0.0):
            got = fields.shown(list(self.slides))
            yield f"slides must have a positive length and be in order, rear to front, got {got}"
        if self.play is not None and self.play.radial is None and self.pitch_growth < 0.0:
            yield f"play.radial must be given with a pitch_growth below zero, got {self.pitch_growth}"
        turn = 2.0 * math.pi / self.tumbler.shoes_per_turn
        if self.fold_limit <= turn:
            angle = f"{2 * self.tumbler.gaps_per_shoe} pi / teeth = {turn:.4g} rad"
            yield f"fold_limit must be greater than {angle}, got {self.fold_limit}"
        if not self.tumbler.place[0] < self.rollers[0] < self.rollers[-1] < self.idler.place[0]:
            yield "the tumbler must be behind the rollers and the idler in front of them"

    @property
    def upper(self) -> dict[WheelLabel, Wheel]:
        """Positions x and z of the carriers' axes and of the slides' contact lines, m, by label."""
        places = {WheelLabel("carrier", number): place for number, place in enumerate(self.carriers, start=1)}
        for number, (rear, front, top) in enumerate(self.slides, start=1):
            x = np.linspace(rear, front, 1 + max(1, math.floor((front - rear) / self.slide_step + 1e-9)))
            z = top - self.carrier_radius
            lines = enumerate(x.tolist(), start=1)
            places |= {WheelLabel("slide", number, line): (place, z) for line, place in lines}
        return places

    @property
    def resistances(self) -> np.ndarray:
        """Resistance coefficients of a track's wheels: rolling resistance, or friction on lines of slides."""
        rolling = len(self.rollers) + 1 + len(self.carriers)
        rubbing = len(self.upper) - len(self.carriers)
        return np.repeat([self.rolling_resistance, self.slide_friction], [rolling, rubbing])

    @property
    def length(self) -> float:
        """Distance of the axes of tumbler and idler without take-up, m."""
        return self.idler.place[0] - self.tumbler.place[0]

    def wheels(self, take_up: float) -> np.ndarray:
        """Return x and z in the frame, and the radius, of all wheels: array (wheels, 3), m.

        Their order is lower rollers, idler, carriers, lines of slides.
        """
        x, z = self.idler.place
        rollers = [(place, 0.0, self.roller_radius) for place in self.rollers]
        upper = [(*place, self.carrier_radius) for place in self.upper.values()]
        return np.array([*rollers, (x + take_up, z, self.idler.radius), *upper])

    def lugs(self, chain: Track) -> list[tuple[str, np.ndarray]]:
        """Return for each lug of a shoe the nearest joint centre on its side, and the lug's place (3,), m."""
        lugs = []
        middle = chain.pin_ahead - 0.5 * chain.pitch
        for side in SIDES:
            rear = np.array(chain.joint_centers[f"rear {side}"])
            grown = 0.0 if self.takes_play_from_wear else self.pitch_growth
            worn = rear - [grown * chain.pitch, 0.0, 0.0]
            places = [np.array([x, rear[1], z]) for x, z in self.tumbler.lugs] or [worn]
            lugs += [(f"{'rear' if place[0] < middle else 'front'} {side}", place) for place in places]
        return lugs

    @property
    def carried_mass(self) -> float:
        """Mass that the shoes carry, without their own, kg; it includes tumblers and sliding idlers."""
        idlers = 0.0 if self.idler.slide is None else self.tracks * self.idler.slide.mass
        return super().carried_mass + self.tracks * self.tumbler.mass + idlers

    def first_loads(self, case: Whole) -> np.ndarray:
        """Return the loads on the shoes, without their weight, at t = 0: array (shoes,), N.

        Shoes that are not below the rollers hang on the frame; their weight acts on the shoes below it.
        """
        under = self.standing(case)
        weight = case.shoe.mass * case.gravity
        hanging = np.where(under, np.sum(~under) / max(1, under.sum()), -1.0) * weight
        return super().first_loads(case) + hanging

    @property
    def is_set_by_tension(self) -> bool:
        """True if the chain's tension at rest determines the idler's take-up."""
        return self.idler.is_set_by_tension

    @property
    def upper_spans(self) -> np.ndarray:
        """Spans of the upper run along x, from tumbler over its supports to the idler, without take-up, m."""
        supports = [self.tumbler.place[0], *(x for x, _ in self.upper.values()), self.idler.place[0]]
        return np.diff(np.sort(supports))

    @property
    def wanted_sag(self) -> float:
        """Target sag of the chain at rest between idler and carrier if no pretension is given, m."""
        return self.idler.sag or MAKERS_SAG * float(self.upper_spans[-1])

    @property
    def sinks(self) -> bool:
        """True if arms carry all lower rollers, so that a tight chain pulls the frame down on its springs."""
        return {arm.roller for arm in self.arms} == set(range(1, len(self.rollers) + 1))

    def arms_lifted(self, height: float) -> np.ndarray:
        """Return the motion of the arms of a track for a lift of their rollers (m): array (arms, 2).

        The columns are the rollers' displacement along x, m, and the arms' angle about y, rad.
        """
        lifted = [arm.lifted(self.rollers[arm.roller - 1], height) for arm in self.arms]
        return np.reshape(lifted, (len(self.arms), 2))

    def estimated_slack(self, shoe: Shoe, chain: Track) -> float:
        """Return the idler's offset (m) back from its place with a taut chain, estimated from the tension.

        All spans l of the upper run hang as parabolas, with the weight w per length and one pull H. Their sag
        is w l^2 / (8 H), their excess length w^2 l^3 / (24 H^2). The idler takes up half of the excess.
        """
        if self.idler.slack is not None or not self.idler.is_set_by_tension:
            return self.idler.slack or 0.0
        spans = self.upper_spans
        hanging = 8.0 * self.wanted_sag / spans[-1] ** 2  # w / H
        if self.idler.pretension is not None:
            weight = shoe.mass * ph4100c.GRAVITY / chain.pitch
            # the upper run has the higher tension, by the weight of the chain between both runs
            apart = 2.0 * self.idler.radius
            hanging = weight / (self.idler.pretension + 0.5 * weight * apart)
            hanging = min(hanging, 8.0 * DEEPEST / float(spans.max()))
        return 0.5 * float(np.sum(spans**3)) * hanging**2 / 24.0

    def idler_circle(self, take_up: float, rise: float, pitch: float) -> tuple[Wheel, float]:
        """Return the idler's axis in the frame, and the radius of the pins about it, m.

        The rail touches the idler in the middle between two pins.
        """
        axis = self.idler.place[0] + take_up, self.idler.place[1]
        return axis, math.hypot(self.idler.radius + rise, 0.5 * pitch)

    @property
    def wheel_labels(self) -> list[WheelLabel]:
        """Kinds and numbers of lower rollers, idler, carriers and lines of slides."""
        return [*super().wheel_labels, WheelLabel("idler"), *self.upper]

    def chain_pitch(self, chain: Track) -> float:
        """Return the distance between the pins of a shoe in a tight chain, with wear and play, m."""
        pitch = chain.pitch * (1.0 + self.pitch_growth)
        return pitch if self.play is None or self.takes_play_from_wear else pitch + self.pin_clearance(chain)

    def pin_clearance(self, chain: Track) -> float:
        """Return the radius of a bore less that of its pin, m."""
        if self.play is None:
            return 0.0
        return self.pitch_growth * chain.pitch if self.play.radial is None else self.play.radial

    @property
    def pin_play(self) -> Play | None:
        """Play of the chain's pins; None for ideal joints."""
        return self.play

    @property
    def takes_play_from_wear(self) -> bool:
        """True if the pins have moved in their bores by the wear, instead of their joint centres."""
        return self.play is not None and self.play.radial is None

    def travel_per_angle(self, chain: Track) -> float:
        """Return the travel of the chain per radian of the tumbler, m/rad."""
        return self.tumbler.shoes_per_turn * self.chain_pitch(chain) / (2.0 * math.pi)
