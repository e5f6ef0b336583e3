"""Wheels of a closed track other than rollers: drive tumbler and idler."""

import math

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import base, track
from exudyn_crawler.case.parameters.tooth_profile import ToothProfile
from exudyn_crawler.settings.parameters import Errors, Parameters, option, quantity

DEEPER, TRIED = 10.0, 500  # in a search for valid teeth: greatest factor of the depth, number of values
SETTLING = 2e-3
"""Least ratio of damping to stiffness of a recoil spring, s.

Without it the stops alone would bring the idler to rest within a step, by forces that grow as the step falls.
"""
Wheel = tuple[base.Place, base.Place]
TIPS = 0.036
"""Height of a sprocket's tips beyond the pins' circle, in pitches: 7.75 mm of 215.9 mm (Case CX350B)."""


class Tumbler(base.PH4100C, values=ph4100c.TUMBLER):
    """Drive tumbler: even gaps between its teeth are concave arcs, into which round lugs of the shoes run.

    Without a `depth` the profile follows from pitch, teeth and lugs. Arcs with centres on the pins' circle
    seat the lugs; straight flanks go on to the tips, with a slope that frees leaving lugs.
    """

    place: Wheel = quantity("m", "x and z of the axis in the frame", (-20.0, 20.0))
    teeth: int = quantity("1", "number of teeth", (6, 30), ge=4, le=200)
    gaps_per_shoe: int = quantity(
        "1",
        "tooth gaps from pin to pin: 2 for a half-pitch sprocket, whose chain uses every second gap",
        ge=1,
        le=2,
        default=1,
    )
    mass: float = quantity("kg", "mass of the tumbler", (20.0, 2e5), ge=0.1, le=1e8)
    inertia: base.Inertia = quantity(
        "kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of the tumbler about its centre (tensor)"
    )
    pitch_radius: base.Length | None = quantity(
        "m",
        "radius of the pins' circle on the tumbler; none: new chain, pitch / (2 sin(pi gaps_per_shoe "
        "/ teeth))",
        default=None,
    )
    depth: base.Length | None = quantity(
        "m",
        "distance of the arcs' centres outside the pins' circle; none: centres on it, then straight flanks",
        (0.01, 0.5),
        default=None,
    )
    reach: base.Extent | None = quantity(
        "m",
        "distance of the addendum circle outside the pins' circle; none: 0.036 pitches",
        (0.002, 0.4),
        default=None,
    )
    flank: float = quantity(
        "1",
        "angle of straight flanks over the angle at which leaving lugs hook",
        (0.6, 0.95),
        gt=0,
        lt=1,
        default=0.85,
    )
    lug_radius: base.Length = quantity("m", "radius of the lugs", (0.005, 0.3))
    lugs: tuple[base.Two, ...] = quantity(
        "m",
        "x and z of the lugs in a shoe; none: about its rear pins, in which the front pins turn",
        default=(),
    )
    backlash: base.Extent = quantity(
        "m", "radius of a tooth gap less the radius of a lug that fits without play", default=0.0
    )
    stiffness: base.Stiffness = quantity("N/m^exponent", "contact stiffness of a tooth", (1e6, 1e11))
    exponent: base.Exponent = quantity("1", "exponent of the penetration", (1.0, 1.6), default=1.0)
    damping: base.Damping = quantity("N s/m", "greatest damping coefficient of a tooth's contact", (0.0, 1e8))
    damping_depth: base.Depth = quantity("m", "penetration at which the damping is full", (1e-7, 1e-2))

    def radius(self, pitch: float) -> float:
        """Return the radius (m) of the pins' circle for a chain with a new pitch (m)."""
        return self.pitch_radius or pitch / (2.0 * math.sin(math.pi / self.shoes_per_turn))

    @property
    def shoes_per_turn(self) -> float:
        """Number of shoes that pass in one turn; of a half-pitch sprocket half of the teeth, such as 10.5."""
        return self.teeth / self.gaps_per_shoe

    def tip_radius(self, pitch: float) -> float:
        """Return the radius (m) of the teeth's tips for a chain of a pitch (m)."""
        return self.radius(pitch) + (TIPS * pitch if self.reach is None else self.reach)

    @property
    def free_angle(self) -> float:
        """Greatest angle (rad) of an arc from its gap's middle at which leaving lugs do not hook."""
        return 0.5 * math.pi - math.pi / self.shoes_per_turn

    @property
    def pitch(self) -> float | None:
        """Pitch (m) of the chain that fits `pitch_radius`; None: it follows the chain."""
        return self.pitch_radius and 2.0 * self.pitch_radius * math.sin(math.pi / self.shoes_per_turn)

    def profile(self, chain: track.Track) -> ToothProfile:
        """Return the gaps between the teeth, for a chain.

        A seated shoe is a side of the tumbler's polygon, with gaps at its corners. Without backlash, the arcs
        leave no play to the lug with the greatest distance from the nearest arc's centre.
        """
        pitch = chain.pitch
        radius = self.radius(chain.pitch)
        center = radius + (self.depth or 0.0)
        middle = chain.pin_ahead - 0.5 * pitch
        height = math.sqrt(max(0.0, radius**2 - 0.25 * pitch**2))
        farthest = 0.0
        # from the middle between the shoe's pins, z into the loop
        for x, z in [(x - middle, z - chain.pin_height) for x, z in self.lugs] or [(-0.5 * pitch, 0.0)]:
            far = math.hypot(x, height - z)
            angle = math.atan2(x, height - z)
            off = angle - math.copysign(math.pi / self.shoes_per_turn, x)
            farthest = max(farthest, math.hypot(far * math.cos(off) - center, far * math.sin(off)))
        arc = farthest + self.lug_radius + self.backlash
        tips = self.tip_radius(pitch)
        profile = ToothProfile(float(self.teeth), center, arc, tips, self.lug_radius, tips, 0.0)
        return profile if self.depth is not None else profile.with_flanks(self.flank * self.free_angle)

    def tooth_errors(self, chain: track.Track) -> Errors:
        """Yield an error for teeth that hook leaving lugs, and for missing teeth, with valid values."""
        profile = self.profile(chain)
        center, arc, addendum = profile.center, profile.arc, profile.addendum
        if not abs(center - arc) < profile.rim < center + arc:
            arcs = f"the arcs of {arc:.4g} m about {center:.4g} m, got {self.reach}"
            remedies = self._remedies(chain)
            yield f"tumbler.reach must let the addendum circle of {addendum:.4g} m meet {arcs}; {remedies}"
            return
        if not self._frees_lugs(chain):
            flank = math.degrees(profile.flank_angle)
            free = math.degrees(self.free_angle)
            per_shoe = "180" if self.gaps_per_shoe == 1 else f"{180 * self.gaps_per_shoe}"
            ends = f"the flank of a tooth ends {flank:.1f} degrees beside its gap's middle"
            less = f"it must be less than 90 - {per_shoe} / teeth = {free:.1f}: leaving lugs hook under it"
            yield f"tumbler: {ends}, {less}; {self._remedies(chain)}"
        if not self._has_teeth(chain):
            remedies = self._remedies(chain)
            yield f"tumbler: neighbouring gaps overlap and leave no tooth between them; {remedies}"

    def _frees_lugs(self, chain: track.Track) -> bool:
        """Return whether leaving lugs do not hook under the teeth."""
        return self.profile(chain).flank_angle < self.free_angle

    def _has_teeth(self, chain: track.Track) -> bool:
        """Return whether neighbouring gaps leave a tooth between them."""
        profile = self.profile(chain)
        return profile.half_width <= profile.addendum * math.sin(math.pi / self.teeth)

    def longest_reach(self, chain: track.Track) -> float:
        """Return the greatest reach (m) up to the present one at which a tooth's flanks do not meet."""
        here = self.tip_radius(chain.pitch) - self.radius(chain.pitch)
        reaches = np.linspace(here, 0.0, TRIED).tolist()
        return next((r for r in reaches if self.model_copy(update={"reach": r})._has_teeth(chain)), here)

    def _remedies(self, chain: track.Track) -> str:
        """Describe the nearest values, each of one parameter, that give valid teeth."""
        words = []
        reach = self.tip_radius(chain.pitch) - self.radius(chain.pitch)
        deepest = None if self.depth is None else DEEPER * self.depth
        for name, here, far in (
            ("reach", reach, 0.0),
            ("depth", self.depth, deepest),
            ("backlash", self.backlash, self.backlash + self.lug_radius),
            ("backlash", self.backlash, 0.0),
            ("lug_radius", self.lug_radius, 0.0),
        ):
            if here is None or far is None:
                continue
            for value in np.linspace(here, far, TRIED)[1:].tolist():
                tried = self.model_copy(update={name: float(f"{value:.4g}")})
                if tried._frees_lugs(chain) and tried._has_teeth(chain):
                    words.append(f"{name} = {value:.4g} m")
                    break
        return f"{' or '.join(words)} would do" if words else "it needs other teeth or lugs"


class Play(Parameters):
    """Play of the pins of a chain in their bores.

    A pin presses on its bore, and a lug on its neighbour's end face, by one law: a stiffness and a damping
    that rise with the penetration to their full values.
    """

    radial: base.Extent | None = quantity(
        "m",
        "radius of a bore less that of its pin; none: the wear that makes the chain's pitch grow",
        (0.0, 0.01),
        default=None,
    )
    axial: base.Extent = quantity("m", "way of a lug to either side until the faces meet", (0.0, 0.02))
    stiffness: base.Stiffness = quantity("N/m", "stiffness of a pin in its bore", (1e8, 1e11))
    damping: base.Damping = quantity("N s/m", "greatest damping coefficient", (0.0, 1e8))
    damping_depth: base.Depth = quantity(
        "m", "penetration at which stiffness and damping are full", (1e-7, 1e-3), default=1e-5
    )


class Slide(Parameters):
    """Idler that slides along its side frame, pushed by a spring with a damper, and does not spin."""

    mass: float = quantity("kg", "mass of the idler with its slide", (5.0, 2e4), ge=0.1, le=1e8)
    stiffness: base.Stiffness = quantity("N/m", "stiffness of the spring", (1e5, 1e9))
    damping: base.Damping = quantity("N s/m", "damping coefficient of the damper", (0.0, 1e7), default=0.0)

    def inertia_tensor(self, radius: float) -> np.ndarray:
        """Return the inertia tensor of the idler as a disc of a radius (m): array (3, 3), kg m2."""
        return self.mass * radius**2 * np.diag([0.25, 0.5, 0.25])

    @property
    def relaxation(self) -> float:
        """Damping over stiffness, s."""
        return self.damping / self.stiffness


class Tensioner(Slide):
    """Spring-damper that always pushes the idler forward: its force gives the chain its tension."""

    preload: float = quantity("N", "push on the idler without take-up", (1e3, 1e7), ge=0, le=1e10)


class Recoil(Slide):
    """Recoil spring behind a grease cylinder: the idler gives way where the chain pushes it with more.

    The cylinder holds the idler at its take-up, which gives the tension. Beyond the spring's preload the
    idler moves back by the excess over the stiffness, at most by the stroke. It never moves forward of its
    place. The damper acts while the idler moves, and brings it to rest at both ends.
    """

    preload: float = quantity("N", "preload of the spring as installed", (1e4, 1e7), ge=0, le=1e10)
    stroke: base.Length = quantity("m", "stroke of the idler to the stop behind the spring", (0.01, 0.5))

    @property
    def relaxation(self) -> float:
        """Damping over stiffness, s; at least `SETTLING`, so that the idler comes to rest at its stops."""
        return max(super().relaxation, SETTLING)


class Idler(base.PH4100C, values=ph4100c.IDLER):
    """Front idler: shims hold it where the chain has its tension at rest, or a tensioner pushes it.

    The tension is given as a sag or a pretension of the level machine; a run solves for its take-up. Without
    both it is the sag that makers ask for. `take_up` or `slack` give the place of the idler instead.
    """

    place: Wheel = quantity("m", "x and z of the axis in the frame without take-up", (-20.0, 20.0))
    radius: base.Length = quantity("m", "radius of the idler's treads", (0.05, 2.0))
    sag: base.Length | None = quantity(
        "m",
        "sag of the chain at rest between idler and carrier; none: makers' 2.5 % of the span",
        default=None,
    )
    pretension: float | None = quantity(
        "N",
        "tension of the chain at rest, half of its push on the idler; none: from the sag",
        gt=0,
        le=1e10,
        default=None,
    )
    take_up: float | None = quantity(
        "m",
        "forward displacement of the idler by shims; none: the one that gives the tension at rest",
        ge=-5,
        le=5,
        default=None,
    )
    slack: base.Extent | None = quantity(
        "m",
        "distance of the idler behind its position with a taut chain; none: from the tension",
        (0.0, 0.1),
        default=None,
    )
    range: base.Two = quantity("m", "least and greatest take-up", (-1.0, 1.0))
    tensioner: Tensioner | None = option(
        "spring-damper that pushes the idler forward; none: shims hold it", None
    )
    recoil: Recoil | None = option("recoil spring that yields above its preload; none: rigid support", None)

    def _errors(self) -> Errors:
        if self.range[0] >= self.range[1]:
            yield f"range must be least and greatest take-up in this order, got {self.range}"
        if self.tensioner is not None and self.recoil is not None:
            yield "tensioner and recoil must not be given together: the idler has one spring"
        tension = {name: getattr(self, name) for name in ("sag", "pretension")}
        named = [name for name, value in tension.items() if value is not None]
        if self.tensioner is not None and named:
            yield f"{named[0]} must be none with a tensioner: its preload and stiffness give the tension"
        places = {"take_up": self.take_up, "slack": self.slack}
        named += [name for name, value in places.items() if value is not None]
        if len(named) > 1:
            yield f"{' and '.join(named)} must not be given together: each of them places the idler"

    @property
    def slide(self) -> Tensioner | Recoil | None:
        """Spring on which the idler slides; None if the idler is a wheel of the frame."""
        return self.tensioner or self.recoil

    @property
    def is_set_by_tension(self) -> bool:
        """True if the tension at rest determines the take-up."""
        return self.take_up is None and self.slack is None and self.tensioner is None
