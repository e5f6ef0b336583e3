"""Contact of spheres under the shoes with the units' top faces (Exudyn's `GeneralContact`)."""

from typing import Literal, Self

from exudyn_crawler.case.base import Parameters, quantity


class GeneralContact(Parameters):
    """Spheres under each shoe, touching the underside from within, at the middle of equal parts of it.

    Their stiffness is no parameter: `Case.sphere_stiffness` makes a shoe under its mean load settle as deep,
    with the same force, as by the pair law. The force is linear in the depth, so that about this state
    the stiffness against bouncing is the pair law's over its exponent; friction has one coefficient, without
    the hump of static friction.
    """

    spheres_x: int = quantity("1", "spheres along a shoe; two are needed to balance it", ge=2)
    spheres_y: int = quantity("1", "spheres across a shoe; two are needed to balance it", ge=2)
    radius: float = quantity("m", "radius of the spheres", gt=0)
    damping: float = quantity("N s/m", "damping along the normal of all spheres of a shoe together", ge=0)
    friction: float = quantity("1", "coefficient of friction", ge=0)
    friction_speed: float = quantity("m/s", "slip speed at which friction is full", gt=0)
    faces: Literal["whole", "drawn_back"] = quantity(
        "",
        "whole: as large as the units, each of which pushes a sphere over their seam by its own law, as in "
        "the pair law; drawn_back: short of the seams, so that both push it about as hard as one would",
        default="whole",
    )

    @classmethod
    def oil_sand(cls) -> Self:
        """Shoe on oil sand.

        Damping and the slip speed of full friction are the papers' c_max and V_st. The papers' friction
        falls from mu_s = 0.4 at 0.01 m/s to mu_d = 0.3 at 0.1 m/s; a track at full propel slips at 0.1 m/s,
        hence mu_d. Chosen here: 4 x 5 spheres, of which the four along a shoe resist its pitch within 6 % of
        an even support; the radius bounds the step between units that a track can climb.
        """
        return cls(spheres_x=4, spheres_y=5, radius=0.2, damping=1.0e4, friction=0.3, friction_speed=0.01)
