"""Wheels of a closed track that are no rollers: drive tumbler and idler."""

import math

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import base, track
from exudyn_crawler.case.parameters.base import Errors, Parameters, option, quantity

DEEPER, TRIED = 10.0, 500  # greatest depth in place of another, and values tried, of teeth that would do
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
        pitch = chain.pitch
        radius = self.radius(chain.pitch)
        center = radius + self.depth
        middle = chain.pin_ahead - 0.5 * pitch
        height = math.sqrt(max(0.0, radius**2 - 0.25 * pitch**2))
        farthest = 0.0
        # beside the middle between the shoe's pins, z into the loop
        for x, z in [(x - middle, z - chain.pin_height) for x, z in self.lugs] or [(-0.5 * pitch, 0.0)]:
            far = math.hypot(x, height - z)
            angle = math.atan2(x, height - z)
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
            flank = math.degrees(self._flank(chain))
            free = 90.0 - 180.0 / teeth
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
