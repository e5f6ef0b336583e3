"""Pins of a chain's links: size, kind and the law of their moment about their axis."""

from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple

from exudyn_crawler.case.parameters import base
from exudyn_crawler.settings.parameters import Errors, Parameters, option, quantity
from exudyn_crawler.settings.rows import read_rows

KINDS = Path(__file__).with_name("pin_kinds.csv")
RADIUS, LENGTH = 0.105, 0.6
"""Radius of a pin and length of its bearing in pitches: diameter 0.20 to 0.22 (remembered), length
assumed."""
RUBBER = 1.2e5
"""Torsional stiffness of a rubber bush over the pitch cubed, N/(m2 rad) (assumed).

A sleeve of shear modulus G and length L between radii a and b has ``4 pi G L / (1/a^2 - 1/b^2)``:
1.7 kN m/rad for 1 MPa, 0.3 m, 14 and 18.5 mm at a pitch of 0.154 m. The lugs of both shoes are bushed
(remembered): each has half of the length, and both twist in series about the pin, a quarter of that.
"""

PinKind = Literal["ideal", "dry", "greased", "sealed", "needles", "rubber"]


class PinLaw(NamedTuple):
    """Law of the moment of a pin about its axis; the formula is in `model.joints.friction`."""

    lever: float  # coefficient of friction times radius of the pin, m
    fading: float  # rad/s at which there is 0.7 of the friction
    stiffness: float  # N m/rad of a rubber bush
    unloaded: float  # rad, angle of the front shoe from the rear one about y at which a bush is not twisted
    loss: float  # factor of a rubber bush


class KindOfPin(NamedTuple):
    """Row of the table of kinds: friction and loss with their ranges."""

    kind: str
    friction: float
    friction_low: float
    friction_high: float
    loss: float
    loss_low: float
    loss_high: float
    source: str
    known: str
    """State of knowledge: "remembered" values are assumed, "project" ones stated by the papers."""


@cache
def kinds() -> dict[str, KindOfPin]:
    """Return the kinds of pins by name."""
    return {row.kind: row for row in read_rows(KINDS, KindOfPin)}


class LinkPin(Parameters):
    """Pin of a link; values of a kind are assumed, with ranges and sources in `pin_kinds.csv`."""

    kind: PinKind = option("bearing: ideal (without friction), or a kind with assumed values", "ideal")
    radius: base.Length | None = quantity(
        "m", "radius of the pin; none: 0.105 pitches, as of usual pins", (5e-3, 0.15), default=None
    )
    length: base.Length | None = quantity(
        "m", "length of the bearing of pin and bush; none: 0.6 pitches", (0.02, 0.6), default=None
    )
    friction: base.Coefficient | None = quantity(
        "1", "coefficient of friction; none: by the kind", (0.002, 0.6), default=None
    )
    friction_rate: base.Speed = quantity(
        "rad/s", "turning rate of the hinge at which there is 0.7 of the friction", (1e-3, 10.0), default=0.1
    )
    stiffness: float | None = quantity(
        "N m/rad",
        "torsional stiffness of a rubber bush; none: 0.12 MPa x pitch cubed",
        (100.0, 2e4),
        ge=0,
        le=1e9,
        default=None,
    )
    unloaded_angle: float = quantity(
        "rad",
        "angle between shoes, negative on the wheels, at which a rubber bush is not twisted",
        (-0.4, 0.0),
        ge=-1.5,
        le=1.5,
        default=0.0,
    )
    loss: float | None = quantity(
        "1", "loss factor of a rubber bush; none: by the kind", (0.05, 0.3), ge=0, le=2, default=None
    )

    def _errors(self) -> Errors:
        rubber = self.kind == "rubber"
        if self.is_ideal and self.friction:
            yield f"kind must be dry, greased, sealed or needles with a friction of {self.friction:g}"
        if not rubber:
            given = {"stiffness": self.stiffness, "loss": self.loss, "unloaded_angle": self.unloaded_angle}
            for name, value in given.items():
                if value:
                    yield f"{name} must go with kind 'rubber', got kind {self.kind!r}"

    @property
    def is_ideal(self) -> bool:
        """True if no moment acts about the pin's axis."""
        return self.kind == "ideal"

    def radius_at(self, pitch: float) -> float:
        """Return the radius of the pin in a chain of a pitch, m."""
        return self.radius or RADIUS * pitch

    def length_at(self, pitch: float) -> float:
        """Return the length of the bearing of pin and bush in a chain of a pitch, m."""
        return self.length or LENGTH * pitch

    def law(self, pitch: float) -> PinLaw:
        """Return the law of the pins in a chain of a pitch, m."""
        kind = kinds()[self.kind]
        friction = kind.friction if self.friction is None else self.friction
        loss = kind.loss if self.loss is None else self.loss
        usual = RUBBER * pitch**3 if self.kind == "rubber" else 0.0
        stiffness = usual if self.stiffness is None else self.stiffness
        return PinLaw(
            friction * self.radius_at(pitch), self.friction_rate, stiffness, self.unloaded_angle, loss
        )
