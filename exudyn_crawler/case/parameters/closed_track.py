"""A closed track: drive tumbler, idler, rollers and guides in the side frame, and where its shoes start."""

import math
from contextlib import suppress
from functools import lru_cache
from typing import Literal, NamedTuple, Self

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import assembly, base, sizes, track, undercarriage
from exudyn_crawler.case.parameters.base import Errors, Parameters, option, quantity

CLEARANCE = 0.5  # m, between the lowest shoes of a frame on posts and the ground
SLIDE_MARGIN = 0.02  # m, by which a round line of a slide touches a rail beyond the rail's ends, at most
MOST_SAG = 0.5  # of the upper run's length: how far it may sag
TAKE_UPS = 81  # tried of the idler's range
DEEPER, TRIED = 10.0, 500  # greatest depth in place of another, and values tried, of teeth that would do
MAKERS_SAG = 0.025
"""Sag over the free span between idler and carrier that a chain has where no file says more: chosen here."""
LEAST_SAG, GREATEST_SAG = 0.007, 0.04
"""The same that makers ask for, least and greatest.

They ask for 5 to 15 mm (excavator of 2.7 t) and 10 to 30 mm (of 12 to 21 t; Komatsu PC27MR, PC118MR-8 and
PC210-11), 50 mm (dozers of Caterpillar), 25 to 63 and 38 to 76 mm (crawler cranes Manitowoc 2250 and 16000).
Spans stand in none of these texts; 0.7, 1.2, 1.3 and 1.9 m are assumed.
"""
Wheel = tuple[base.Place, base.Place]


class Tumbler(base.PH4100C, values=ph4100c.TUMBLER):
    """Drive tumbler: even gaps between its teeth are concave arcs, into which round lugs of the shoes run."""

    place: Wheel = quantity("m", "x and z of the axis in the frame", (-20.0, 20.0))
    teeth: int = quantity("1", "number of teeth, and of gaps between them", (6, 30), ge=4, le=200)
    mass: float = quantity("kg", "mass", (20.0, 2e5), ge=0.1, le=1e8)
    inertia: base.Inertia = quantity("kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy about its centre (tensor)")
    pitch_radius: base.Length | None = quantity(
        "m", "of the pins on it; none: that of a new chain, pitch / (2 sin(pi / teeth))", default=None
    )
    depth: base.Length = quantity("m", "of the arcs' centres beyond the pins' circle", (0.01, 0.5))
    reach: base.Extent = quantity("m", "of the addendum circle beyond the pins' circle", (0.005, 0.4))
    lug_radius: base.Length = quantity("m", "radius of the lugs", (0.005, 0.3))
    lugs: tuple[base.Two, ...] = quantity(
        "m", "x and z of the lugs in a shoe; none: about its rear pins, which front ones turn in", default=()
    )
    backlash: base.Extent = quantity("m", "radius of a gap beyond a lug's seat without play", default=0.0)
    stiffness: base.Stiffness = quantity("N/m^exponent", "of a tooth's contact", (1e6, 1e11))
    exponent: base.Exponent = quantity("1", "exponent of the depth", (1.0, 1.6), default=1.0)
    damping: base.Damping = quantity("N s/m", "greatest damping of a contact", (0.0, 1e8))
    damping_depth: base.Depth = quantity("m", "depth at which the damping is full", (1e-7, 1e-2))

    def radius(self, pitch: float) -> float:
        """Radius (m) of the circle of the pins, of a chain that has this pitch (m) when it is new."""
        return self.pitch_radius or pitch / (2.0 * math.sin(math.pi / self.teeth))

    @property
    def pitch(self) -> float | None:
        """Pitch (m) of the chain that its pins' circle is of; None: of that which is on it."""
        return self.pitch_radius and 2.0 * self.pitch_radius * math.sin(math.pi / self.teeth)

    def profile(self, chain: track.Track) -> tuple[float, float, float, float, float]:
        """Number of gaps; radii of the arcs' centres, arcs, addendum circle and lugs, m.

        A seated shoe is a side of the polygon of the tumbler, whose gaps are at its corners. Without backlash
        the arcs leave no play to the one of its lugs that is farthest from the arc's centre next to it.
        """
        pitch, radius = chain.pitch, self.radius(chain.pitch)
        center, middle = radius + self.depth, chain.pin_ahead - 0.5 * pitch
        height, farthest = math.sqrt(max(0.0, radius**2 - 0.25 * pitch**2)), 0.0
        # beside the middle between the shoe's pins, z into the loop
        for x, z in [(x - middle, z - chain.pin_height) for x, z in self.lugs] or [(-0.5 * pitch, 0.0)]:
            far, angle = math.hypot(x, height - z), math.atan2(x, height - z)
            off = angle - math.copysign(math.pi / self.teeth, x)
            farthest = max(farthest, math.hypot(far * math.cos(off) - center, far * math.sin(off)))
        arc = farthest + self.lug_radius + self.backlash
        return float(self.teeth), center, arc, radius + self.reach, self.lug_radius

    def tooth_errors(self, chain: track.Track) -> Errors:
        """Teeth of which leaving lugs could not get free, or none at all; with the values that would do."""
        teeth, center, arc, addendum, _ = self.profile(chain)
        if not abs(center - arc) < addendum < center + arc:
            arcs = f"the arcs of {arc:.4g} m about {center:.4g} m, got {self.reach}"
            remedies = self._remedies(chain)
            yield f"tumbler.reach must let the addendum circle of {addendum:.4g} m meet {arcs}; {remedies}"
            return
        if not self._frees_lugs(chain):
            flank, free = math.degrees(self._flank(chain)), 90.0 - 180.0 / teeth
            ends = f"the flank of a tooth ends {flank:.1f} degrees beside its gap's middle"
            less = f"it must be less than 90 - 180 / teeth = {free:.1f}: leaving lugs hook under it"
            yield f"tumbler: {ends}, {less}; {self._remedies(chain)}"
        if not self._has_teeth(chain):
            remedies = self._remedies(chain)
            yield f"tumbler: neighbouring gaps overlap, so that no tooth is between them; {remedies}"

    def _flank(self, chain: track.Track) -> float:
        """Angle (rad) beside a gap's middle, about its arc's centre, where the flank ends; NaN: nowhere."""
        _, center, arc, addendum, _ = self.profile(chain)
        cosine = (center**2 + arc**2 - addendum**2) / (2.0 * center * arc)
        return math.acos(cosine) if -1.0 < cosine < 1.0 else math.nan

    def _frees_lugs(self, chain: track.Track) -> bool:
        """True where leaving lugs do not hook under the teeth."""
        return self._flank(chain) < 0.5 * math.pi - math.pi / self.teeth

    def _has_teeth(self, chain: track.Track) -> bool:
        """True where a tooth is left between neighbouring gaps."""
        _, _, arc, addendum, _ = self.profile(chain)
        return arc * math.sin(self._flank(chain)) <= addendum * math.sin(math.pi / self.teeth)

    def _remedies(self, chain: track.Track) -> str:
        """Nearest values of one parameter each with which the teeth would do, for reading."""
        words = []
        for name, far in (
            ("reach", 0.0),
            ("depth", DEEPER * self.depth),
            ("backlash", self.backlash + self.lug_radius),
            ("backlash", 0.0),
            ("lug_radius", 0.0),
        ):
            here = getattr(self, name)
            for value in np.linspace(here, far, TRIED)[1:].tolist():
                tried = self.model_copy(update={name: float(f"{value:.4g}")})
                if tried._frees_lugs(chain) and tried._has_teeth(chain):
                    words.append(f"{name} = {value:.4g} m")
                    break
        return f"{' or '.join(words)} would do" if words else "it needs other teeth or lugs"


class Tensioner(Parameters):
    """Spring-damper between side frame and idler, which slides along the frame and does not spin."""

    mass: float = quantity("kg", "of the idler with its slide", (5.0, 2e4), ge=0.1, le=1e8)
    stiffness: base.Stiffness = quantity("N/m", "of the spring", (1e5, 1e9))
    preload: float = quantity("N", "its push on the idler without take-up", (1e3, 1e7), ge=0, le=1e10)
    damping: base.Damping = quantity("N s/m", "of the damper", (0.0, 1e7), default=0.0)

    def inertia_tensor(self, radius: float) -> np.ndarray:
        """Of the idler as a disc of this radius (m), about its centre: array (3, 3), kg m2."""
        return self.mass * radius**2 * np.diag([0.25, 0.5, 0.25])


class Idler(base.PH4100C, values=ph4100c.IDLER):
    """Front idler: shims hold it where the chain has its tension at rest, or a tensioner pushes it.

    The tension is given as a sag or as a pretension, for the machine that stands level; a run solves for the
    take-up that gives it. Neither: the sag that makers ask for. `take_up` or `slack` say where the idler is.
    """

    place: Wheel = quantity("m", "x and z of the axis in the frame without take-up", (-20.0, 20.0))
    radius: base.Length = quantity("m", "radius of its treads", (0.05, 2.0))
    sag: base.Length | None = quantity(
        "m", "of the chain at rest between idler and carrier; none: makers' 2.5 % of the span", default=None
    )
    pretension: float | None = quantity(
        "N",
        "of the chain at rest: half of its push on the idler; none: by the sag",
        gt=0,
        le=1e10,
        default=None,
    )
    take_up: float | None = quantity(
        "m", "of the shims, forward; none: what gives the tension at rest", ge=-5, le=5, default=None
    )
    slack: base.Extent | None = quantity(
        "m", "by which it stands back from a taut chain; none: by the tension", (0.0, 0.1), default=None
    )
    range: base.Two = quantity("m", "least and greatest take-up", (-1.0, 1.0))
    tensioner: Tensioner | None = option("spring-damper that pushes it forward; none: shims hold it", None)

    def _errors(self) -> Errors:
        if self.range[0] >= self.range[1]:
            yield f"range must be least and greatest take-up in this order, got {self.range}"
        tension = {name: getattr(self, name) for name in ("sag", "pretension")}
        named = [name for name, value in tension.items() if value is not None]
        if self.tensioner is not None and named:
            yield f"{named[0]} must be none with a tensioner, whose preload and stiffness give the tension"
        places = {"take_up": self.take_up, "slack": self.slack}
        named += [name for name, value in places.items() if value is not None]
        if len(named) > 1:
            yield f"{' and '.join(named)} must not be given together: each says where the idler is"

    @property
    def is_set_by_tension(self) -> bool:
        """True where the take-up is what gives the tension at rest."""
        return self.take_up is None and self.slack is None and self.tensioner is None


class ClosedTrack(undercarriage.RunningGear):
    """A track that is closed round a side frame: what guides, drives and tightens it.

    The tumbler is at the rear. On posts the frame is held above the ground; on the ground its y and yaw are
    held.
    """

    support: Literal["ground", "posts"] = option("what carries the frame", "ground")
    mass: base.Mass = quantity(
        "kg",
        "mass on one track without shoes, tumbler and sliding idler; the frame's with a car_body",
        (1e2, 2e6),
    )
    tumbler: Tumbler
    idler: Idler
    roller_radius: base.Length = quantity("m", "radius of the rollers' treads", (0.05, 1.5))
    carriers: tuple[Wheel, ...] = quantity(
        "m", "x and z of carrier rollers under the upper run, rear to front; none: it hangs", default=()
    )
    carrier_radius: base.Length = quantity("m", "radius of their treads", (0.03, 1.0), default=0.25)
    slides: tuple[base.Three, ...] = quantity(
        "m", "x of rear and front end, z of the top of slides under the upper run, rear to front", default=()
    )
    slide_step: base.Length = quantity(
        "m", "of the lines across a slide on which rails rub, so round as carriers", (0.1, 2.0), default=0.45
    )
    slide_friction: base.Coefficient = quantity(
        "1", "of rails on slides, 0 at rest as rolling is", (0.05, 0.8), default=ph4100c.SLIDE_FRICTION
    )
    guide_play: base.Extent = quantity("m", "a shoe's way to each side of a flange", (0.0, 0.1))
    guide_height: base.Depth = quantity("m", "of the flanges above a tread", (0.005, 0.3))
    guide_stiffness: base.Stiffness = quantity(
        "N/m", "of the flanges of a wheel, of the tumbler", (1e5, 1e10)
    )
    guide_damping: base.Damping = quantity("N s/m", "of these", (0.0, 1e8))
    pitch_growth: float = quantity("1", "of the chain by wear", (0.0, 0.05), ge=-0.1, le=0.2, default=0.0)
    compliance: float = quantity(
        "m/N", "of a pin sideways, in rad/(N m) in yaw and roll", (1e-12, 1e-8), gt=0, le=1e-3, default=1e-10
    )
    tension_limit: float | None = quantity(
        "N", "of a link, beyond which it breaks and the run ends; none: no limit", gt=0, le=1e12, default=None
    )
    fold_limit: float = quantity(
        "rad", "of neighbours, where the chain folds and the run ends", (0.3, 1.6), gt=0, le=3, default=1.0
    )
    offset_limit: base.Length = quantity(
        "m", "beside frame or neighbour, where a shoe comes off and the run ends", (0.02, 0.5), default=0.1
    )
    torque_limit: float | None = quantity(
        "N m", "greatest of the drive; none: what its speed takes", gt=0, le=1e12, default=None
    )
    torque_speed: base.Speed = quantity(
        "rad/s", "lag of the tumbler at which it has 0.7 of this torque", (1e-5, 1.0), default=0.01
    )

    def _errors(self) -> Errors:
        yield from undercarriage.overlap_errors("rollers", self.rollers, self.roller_radius)
        yield from undercarriage.overlap_errors(
            "carriers", [x for x, _ in self.carriers], self.carrier_radius
        )
        ends = [x for rear, front, _ in self.slides for x in (rear, front)]
        if np.any(np.diff(ends) <= 0.0):
            yield f"slides must have a length and stand in order, rear to front, got {list(self.slides)}"
        turn = 2.0 * math.pi / self.tumbler.teeth
        if self.fold_limit <= turn:
            yield f"fold_limit must be greater than 2 pi / teeth = {turn:.4g} rad, got {self.fold_limit}"
        if not self.tumbler.place[0] < self.rollers[0] < self.rollers[-1] < self.idler.place[0]:
            yield "the tumbler must be behind the rollers and the idler in front of them"

    def track_errors(self, shoe: track.Shoe, chain: track.Track) -> Errors:
        """What of a shoe with rails, and of the track, does not go with a closed track, or fit round it."""
        rails = shoe.rails
        assert rails is not None
        if rails.height <= chain.pin_height:
            yield f"shoe.rails.height must be above the pins at {chain.pin_height} m, got {rails.height}"
        x, length = np.sort([x for x, _ in self.upper.values()]), rails.front - rails.rear
        if self.slides and np.any(x[2:] - x[:-2] < length + SLIDE_MARGIN):
            yield (
                f"slide_step, slides and carriers must leave every rail, which is {length:g} m long, on two "
                f"of their lines at once, got lines at {np.round(x, 3).tolist()}"
            )
        yield from self.tumbler.tooth_errors(chain)
        try:
            start = assembled(self, shoe, chain)
        except assembly.MisfitError as error:
            yield f"closed_track: {error}"
            return
        yield from (f"closed_track: {error}" for error in self._overlaps(chain, start.take_up))

    def _overlaps(self, chain: track.Track, take_up: float) -> Errors:
        """Rollers, idler and carriers in each other, or in what of the tumbler is within its gaps."""
        _, center, arc, _, _ = self.tumbler.profile(chain)
        labelled = zip(self.wheel_labels, self.wheels(take_up).tolist(), strict=True)
        wheels = [sizes.Round(label.words, *wheel) for label, wheel in labelled if label.kind != "slide"]
        yield from sizes.overlap_errors([sizes.Round("tumbler", *self.tumbler.place, center - arc), *wheels])

    @classmethod
    def ph4100c(cls) -> Self:
        """Closed track of the P&H 4100C BOSS; `case.ph4100c` says what is open."""
        return cls(tumbler=Tumbler.ph4100c(), idler=Idler.ph4100c(), **ph4100c.CLOSED_TRACK)

    @property
    def upper(self) -> dict[undercarriage.WheelLabel, Wheel]:
        """X and z of the axes of carriers, and of the lines of slides on which rails rub, m."""
        label = undercarriage.WheelLabel
        found = {label("carrier", number): place for number, place in enumerate(self.carriers, start=1)}
        for number, (rear, front, top) in enumerate(self.slides, start=1):
            x = np.linspace(rear, front, 1 + max(1, math.floor((front - rear) / self.slide_step + 1e-9)))
            z = top - self.carrier_radius
            lines = enumerate(x.tolist(), start=1)
            found |= {label("slide", number, line): (place, z) for line, place in lines}
        return found

    @property
    def resistances(self) -> np.ndarray:
        """As of `RunningGear`."""
        rolling = len(self.rollers) + 1 + len(self.carriers)
        rubbing = len(self.upper) - len(self.carriers)
        return np.repeat([self.rolling_resistance, self.slide_friction], [rolling, rubbing])

    def wheels(self, take_up: float) -> np.ndarray:
        """Lower rollers, idler, carriers, lines of slides: x and z in the frame, radius, (wheels, 3), m."""
        x, z = self.idler.place
        rollers = [(place, 0.0, self.roller_radius) for place in self.rollers]
        upper = [(*place, self.carrier_radius) for place in self.upper.values()]
        return np.array([*rollers, (x + take_up, z, self.idler.radius), *upper])

    def lugs(self, chain: track.Track) -> list[tuple[str, np.ndarray]]:
        """Joint centre that is next to each lug of a shoe on its side, and place (3,), m, of the lug."""
        found, middle = [], chain.pin_ahead - 0.5 * chain.pitch
        for side in track.SIDES:
            rear = np.array(chain.joint_centers[f"rear {side}"])
            worn = rear - [self.pitch_growth * chain.pitch, 0.0, 0.0]
            places = [np.array([x, rear[1], z]) for x, z in self.tumbler.lugs] or [worn]
            found += [(f"{'rear' if one[0] < middle else 'front'} {side}", one) for one in places]
        return found

    @property
    def upper_spans(self) -> np.ndarray:
        """Distances along x from tumbler to idler, without take-up, by what carries the upper run, m."""
        supports = [self.tumbler.place[0], *(x for x, _ in self.upper.values()), self.idler.place[0]]
        return np.diff(np.sort(supports))

    @property
    def wanted_sag(self) -> float:
        """Sag (m) of the chain at rest between idler and carrier where no pretension says it."""
        return self.idler.sag or MAKERS_SAG * float(self.upper_spans[-1])

    def estimated_slack(self, shoe: track.Shoe, chain: track.Track) -> float:
        """Way (m) by which the idler stands back from a taut chain, about where the tension gives it.

        All spans of the upper run hang with one pull H as parabolas: w l^2 / (8 H) deep, and longer than
        straight by w^2 l^3 / (24 H^2), of which the idler takes half up.
        """
        if self.idler.slack is not None or not self.idler.is_set_by_tension:
            return self.idler.slack or 0.0
        spans = self.upper_spans
        hanging = 8.0 * self.wanted_sag / spans[-1] ** 2  # w / H
        if self.idler.pretension is not None:
            weight = shoe.mass * ph4100c.GRAVITY / chain.pitch
            # of the two runs the upper one pulls harder, by the weight of the chain between them
            apart = 2.0 * self.idler.radius
            hanging = weight / (self.idler.pretension + 0.5 * weight * apart)
        return 0.5 * float(np.sum(spans**3)) * hanging**2 / 24.0

    def idler_circle(self, take_up: float, rise: float, pitch: float) -> tuple[Wheel, float]:
        """Axis of the idler in the frame, and radius of the pins about it, m: rails touch between pins."""
        axis = self.idler.place[0] + take_up, self.idler.place[1]
        return axis, math.hypot(self.idler.radius + rise, 0.5 * pitch)

    @property
    def wheel_labels(self) -> list[undercarriage.WheelLabel]:
        """Kinds and numbers of lower rollers, idler, carriers and lines of slides."""
        return [*super().wheel_labels, undercarriage.WheelLabel("idler"), *self.upper]

    def chain_pitch(self, chain: track.Track) -> float:
        """Distance of the pins of a shoe, m."""
        return chain.pitch * (1.0 + self.pitch_growth)

    def travel_per_angle(self, chain: track.Track) -> float:
        """Travel of the chain for each radian of the tumbler, m."""
        return self.tumbler.teeth * self.chain_pitch(chain) / (2.0 * math.pi)


class Assembled(NamedTuple):
    """Where a closed track starts."""

    take_up: float  # of the idler, m
    sag: float  # of the upper run, m
    frame: np.ndarray  # (3,): origin of the side frame, m, global
    shoes: np.ndarray  # (shoes, 6): COMs (m, global) and angles (rad), of which pitch falls
    tumbler: np.ndarray  # (6,): the same of the tumbler


@lru_cache(maxsize=64)
def assembled(closed: ClosedTrack, shoe: track.Shoe, chain: track.Track) -> Assembled:
    """Closed chain about its wheels, its first shoe's COM at `first_com`; raises `assembly.MisfitError`."""
    rails = shoe.rails
    assert rails is not None
    pitch = closed.chain_pitch(chain)
    take_up, sag, pieces = _closed(closed, shoe, chain)
    places = assembly.pins_along(pieces, pitch, chain.shoe_count)
    pins = np.array([assembly.point_at(pieces, place) for place in places])
    # the rearmost shoe of which the pins have passed the first roller comes first
    first = next(k for k, place in enumerate(places) if place >= 2.0)
    apart, middles = np.diff(pins, axis=0), 0.5 * (pins[1:] + pins[:-1])
    angles = np.unwrap(np.arctan2(-apart[:, 1], apart[:, 0]))
    angles = angles - 2.0 * math.pi * np.round(angles[0] / (2.0 * math.pi))
    middle = np.array([chain.pin_ahead - 0.5 * pitch, chain.pin_height])
    c, s = np.cos(angles), np.sin(angles)
    coms = middles - np.column_stack((c * middle[0] + s * middle[1], c * middle[1] - s * middle[0]))
    coms, angles = np.roll(coms, -first, axis=0), np.roll(angles, -first)
    if first:
        angles[-first:] -= 2.0 * math.pi
    height = closed.roller_radius + rails.height + shoe.com_height
    height += CLEARANCE if closed.support == "posts" else 0.0
    frame = np.array([chain.first_com[0] - coms[0, 0], chain.first_com[1], height])
    shoes = np.zeros((chain.shoe_count, 6))
    shoes[:, :3] = frame + np.column_stack((coms[:, 0], np.zeros(len(coms)), coms[:, 1]))
    shoes[:, 4] = angles - 2.0 * math.pi * round(angles[0] / (2.0 * math.pi))
    x, z = closed.tumbler.place
    gap = math.atan2(pins[0, 1] - z, pins[0, 0] - x)
    tumbler = np.array([*(frame + np.array([x, 0.0, z])), 0.0, -gap, 0.0])
    return Assembled(take_up, sag, frame, shoes, tumbler)


ROLLERS = (1, 2)
"""Numbers of the outer rollers among the wheels of a `_Loop`."""


class _Loop(NamedTuple):
    """Wheels that the pins of a closed chain lie about, and how a take-up of the idler moves them."""

    closed: ClosedTrack
    rise: float  # of the rails over the pins, m
    pitch: float  # of the chain as it is, and new, m
    new_pitch: float

    @property
    def names(self) -> list[str]:
        """Names of the wheels in their order round the loop; the last of each run alone shape it."""
        labels = self.closed.wheel_labels
        rollers = [label.words for label in labels if label.kind == "roller"]
        return ["tumbler", rollers[0], rollers[-1], "idler", *(label.words for label in self.upper_ends)]

    @property
    def upper_ends(self) -> list[undercarriage.WheelLabel]:
        """Last carriers, or lines of slides, of the upper run, front to rear."""
        upper = sorted(self.closed.upper.items(), key=lambda item: item[1])
        return [label for label, _ in upper[:: -max(1, len(upper) - 1)]]

    def circles(self, take_up: float) -> list[assembly.Circle]:
        """Circles of the pins about these wheels."""
        closed, places = self.closed, self.closed.upper
        (x, z), on_idler = closed.idler_circle(take_up, self.rise, self.pitch)
        rollers, carriers = closed.roller_radius + self.rise, closed.carrier_radius + self.rise
        wheels = [(*closed.tumbler.place, closed.tumbler.radius(self.new_pitch))]
        wheels += [(closed.rollers[k], 0.0, rollers) for k in (0, -1)]
        wheels.append((x, z, on_idler))
        return wheels + [(*places[label], carriers) for label in self.upper_ends]

    def belt(self, take_up: float, sag: float = 0.0) -> list[assembly.Piece]:
        """Belt about them; a `MisfitError` that names the wheel which lies within it, and what would do."""
        circles = self.circles(take_up)
        try:
            return assembly.belt(circles, sag)
        except assembly.WithinError as error:
            x, z, _ = circles[error.number]
            name = self.names[error.number]
            lies = f"{name} at x = {x:.4g} m, z = {z:.4g} m lies {1e3 * error.depth:.0f} mm within the chain"
            remedy = f"it touches the chain at z = {error.height:.4g} m"
            if error.number in ROLLERS:
                end = 0 if error.number == 1 else 3
                remedy = f"it touches the chain with {self.names[end]}.place at z = {self._lift(end):.4g} m"
            raise assembly.MisfitError(f"{lies} about the others; {remedy}") from error

    def _lift(self, end: int) -> float:
        """Height (m) of the axis of tumbler or idler at which its pins leave those of the rollers."""
        _, _, rollers = self.circles(0.0)[1]
        return self.circles(0.0)[end][2] - rollers

    def take_ups(self) -> tuple[float, float]:
        """Range of take-ups at which no wheel lies within the chain, or in another, about the least way."""
        tried = np.linspace(*self.closed.idler.range, TAKE_UPS)
        fit = np.array([self._fits(one) for one in tried])
        if not fit.any():
            self.belt(tried[np.abs(tried).argmin()])
        nearest = np.flatnonzero(fit)[np.abs(tried[fit]).argmin()]
        beyond = np.flatnonzero(~fit)
        first = max(beyond[beyond < nearest], default=-1) + 1
        last = min(beyond[beyond > nearest], default=len(tried)) - 1
        return float(tried[first]), float(tried[last])

    def _fits(self, take_up: float) -> bool:
        with suppress(assembly.MisfitError):
            return bool(assembly.belt(self.circles(take_up)))
        return False


def _closed(
    closed: ClosedTrack, shoe: track.Shoe, chain: track.Track
) -> tuple[float, float, list[assembly.Piece]]:
    """Take-up, sag of the upper run, m, and belt of a chain that closes."""
    assert shoe.rails is not None
    pitch, count = closed.chain_pitch(chain), chain.shoe_count
    loop = _Loop(closed, shoe.rails.height - chain.pin_height, pitch, chain.pitch)
    take_up = closed.idler.take_up
    if take_up is None:
        taut = assembly.closed_chain(loop.belt, pitch, count, loop.take_ups(), "an idler's take-up of")
        slack = closed.estimated_slack(shoe, chain)
        if not slack:
            return taut, 0.0, loop.belt(taut)
        take_up = taut - slack
    most = MOST_SAG * loop.belt(take_up)[-1].length
    fixed, what = float(take_up), f"a take-up of {take_up:.4g} m and a sag of"
    sag = assembly.closed_chain(lambda sag: loop.belt(fixed, sag), pitch, count, (0.0, most), what)
    return fixed, sag, loop.belt(fixed, sag)
