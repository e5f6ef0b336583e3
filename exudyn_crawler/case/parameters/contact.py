"""Contact of a shoe with a terrain unit: by the pair law, or by spheres under the shoes."""

from typing import Literal, Self

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import base
from exudyn_crawler.settings.parameters import Errors, Parameters, option, quantity


class PairContact(Parameters):
    """One contact a volume in which shoe and unit overlap: ADAMS IMPACT, Coulomb friction (`ground.laws`)."""

    model: Literal["pair"] = option(
        "contact model: pair, one contact for each pair of shoe and unit; spheres, for uneven ground", "pair"
    )
    stiffness: base.Stiffness = quantity("N/m^exponent", "contact stiffness k")
    exponent: base.Exponent = quantity("1", "exponent e of the penetration", (1.0, 3.0))
    damping: base.Damping = quantity("N s/m", "greatest damping coefficient c_max", (0.0, 1e8))
    damping_depth: base.Depth = quantity("m", "penetration d at which the damping is full", (1e-6, 0.02))
    static_friction: base.Coefficient = quantity(
        "1", "static friction coefficient mu_s, at the stiction speed", (0.02, 1.5)
    )
    dynamic_friction: base.Coefficient = quantity(
        "1", "dynamic friction coefficient mu_d, beyond the friction speed", (0.02, 1.5)
    )
    stiction_speed: base.Speed = quantity(
        "m/s", "slip speed V_st at which friction has its peak", (1e-5, 0.2)
    )
    friction_speed: float = quantity(
        "m/s", "slip speed V_d beyond which friction is dynamic", (1e-4, 2.0), ge=1e-9, le=1000
    )
    sharing: Literal["pair", "area"] = option(
        "force of a pair of shoe and unit: pair, the whole law; area, in proportion to the contact area"
    )
    edge_width: base.Width = quantity(
        "m",
        "overlap at which a pair has its full force; it grows from zero by the function STEP",
        (1e-4, 0.5),
    )
    normal: Literal["face", "area"] = option(
        "direction of the force: normal of the top face, or of the area of faces below a shoe, which "
        "tilts at edges",
        "face",
    )
    penetration: Literal["centroid", "closest"] = option(
        "penetration at the overlap's centroid, or of the closest points there, smaller on a narrow overlap",
        "centroid",
    )

    def _errors(self) -> Errors:
        static = self.static_friction
        dynamic = self.dynamic_friction
        if dynamic > static:
            yield f"dynamic_friction must not exceed static_friction = {static}, got {dynamic}"
        stiction = self.stiction_speed
        full = self.friction_speed
        if full <= stiction:
            yield f"friction_speed must exceed stiction_speed = {stiction}, got {full}"

    @classmethod
    def oil_sand(cls, sharing: Literal["pair", "area"] = "pair") -> Self:
        """Return a steel shoe on oil sand (all papers, contact table); sharing, edge width: chosen here."""
        return cls(**ph4100c.PAIR_CONTACT, sharing=sharing)

    @classmethod
    def adams(cls) -> Self:
        """Return ADAMS' contact on units larger than a shoe, as deduced from the rigid studies' numbers.

        ADAMS documents no direction of the normal. At a unit's edge, the area vector gives the F-paper's mean
        forces, and the depth at the centroid gives its penetrations (`docs/validation.md`).
        """
        return cls.oil_sand().with_(normal="area")


class SphereContact(Parameters):
    """Spheres under each shoe in Exudyn's `GeneralContact`, at the middle of equal parts of the underside.

    They touch the underside from within. Their stiffness is not a parameter: with that of `case.statics`, a
    shoe under its mean load settles as deep as under the IMPACT law of the reference values. The force is
    linear in the depth, so the tangent stiffness is that of this law over its exponent. Friction has one
    coefficient.
    """

    model: Literal["spheres"] = option(
        "contact model: spheres, for uneven ground; pair, one contact for each pair of shoe and unit",
        "spheres",
    )
    spheres_x: int = quantity("1", "spheres along a shoe; at least two balance it", ge=2, le=100)
    spheres_y: int = quantity("1", "spheres across a shoe; at least two balance it", ge=2, le=100)
    radius: base.Length = quantity("m", "radius of the spheres", (0.02, 2.0))
    reference_stiffness: base.Stiffness = quantity(
        "N/m^exponent", "stiffness k of the IMPACT law that sets the penetration"
    )
    reference_exponent: base.Exponent = quantity("1", "exponent e of this law", (1.0, 3.0))
    damping: base.Damping = quantity(
        "N s/m", "normal damping coefficient of all spheres of a shoe together", (0.0, 1e8)
    )
    friction: base.Coefficient = quantity("1", "coefficient of friction", (0.02, 1.5))
    friction_speed: base.Speed = quantity("m/s", "slip speed at which friction is full", (1e-5, 0.2))
    faces: Literal["whole", "drawn_back"] = option(
        "force over a seam: whole, both units push a sphere; drawn_back, about the force of one unit", "whole"
    )

    @classmethod
    def oil_sand(cls) -> Self:
        """Return a shoe on oil sand; friction is the papers' mu_d, valid at the slip of a full propel."""
        return cls(**ph4100c.SPHERE_CONTACT)

    def size_errors(self, depth: float, side: float) -> Errors:
        """Yield an error for a radius below the most loaded shoe's `depth`, or too large for a `side`, m.

        `side` is the side of a unit.
        """
        if self.radius <= depth:
            least = f"settled penetration of the most loaded shoe, {depth:.4g} m"
            yield f"contact.radius must exceed the {least}, got {self.radius}"
        if self.radius > 0.25 * side:
            quarter = f"a quarter of a unit's side, {0.25 * side:.4g} m"
            yield f"contact.radius must not exceed {quarter}, got {self.radius}"

    @property
    def count(self) -> int:
        """Number of spheres under one shoe."""
        return self.spheres_x * self.spheres_y


def impact_depth(load: np.typing.ArrayLike, stiffness: float, exponent: float) -> np.ndarray:
    """Return the penetration (m) of an evenly loaded shoe by an IMPACT law for each load (N); 0 if lifted."""
    return (np.maximum(load, 0.0) / stiffness) ** (1.0 / exponent)
