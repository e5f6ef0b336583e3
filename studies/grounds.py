"""Grounds and cases of the study of uneven ground; this does not load the runs."""

from collections.abc import Callable

from exudyn_crawler import Case, PairContact, Shoe, SphereContact, Terrain

STEP_PLACE, STEP_HEIGHT = 14.0, 0.1
"""m: below the middle of the track at t = 0; height."""
RAMP_START, RAMP_END, RAMP_HEIGHT = 8.0, 20.0, 0.6
"""m: 5 % over the whole track."""
ROUGHNESS, SEED = 0.02, 1
"""m, standard deviation of the units' heights; seed of the generator."""


def strip() -> Terrain:
    """One row of 13 units below the track, 1 m long and 5 m wide, for ground that changes along it.

    Density, height, stiffness per area and tilt stiffness are those of the S-paper's units of 1 x 1 m.
    """
    width = 5.0
    square = Terrain.stress()
    return square.with_(
        columns=13,
        rows=1,
        unit_width=width,
        spring_stiffness=width * square.spring_stiffness,
        spring_damping=width * square.spring_damping,
        origin=(8.0, 6.8),
    )


GROUNDS: dict[str, Callable[[], Terrain]] = {
    "step": lambda: strip().with_step(STEP_PLACE, STEP_HEIGHT),
    "ramp": lambda: strip().with_ramp(RAMP_START, RAMP_END, RAMP_HEIGHT),
    "rough": lambda: strip().with_roughness(ROUGHNESS, SEED),
}
"""Terrains of the study by name."""


def pitching(case: Case) -> Case:
    """Case whose units pitch, on springs at the Gauss points of their length.

    There two springs resist heave and pitch exactly as an evenly spread support of the same stiffness does.
    """
    terrain = case.unit_terrain()
    return case.with_(terrain=terrain.with_(tilt="pitch", spring_offset=terrain.unit_length / 12.0**0.5))


def plain(case: Case) -> Case:
    """Case in which nothing moves a straight track sideways.

    Undersides have no fingers, forces are normal to the units' faces, and units pitch.
    """
    return pitching(case.with_(shoe=Shoe.ph4100c(), contact=PairContact.oil_sand()))


def uneven_case(ground: str) -> Case:
    """Straight propel over one of the grounds, whose faces are drawn back from the units' seams.

    Seams of units 1 m long lie under most shoes: whole faces would make the ground stiffer there and lift
    the shoes by what is not in its heights.

    Raises
    ------
    ValueError
        For an unknown ground.
    """
    if ground not in GROUNDS:
        raise ValueError(f"ground must be of {list(GROUNDS)}, got {ground!r}")
    spheres = SphereContact.oil_sand().with_(faces="drawn_back")
    # spheres know no fingers
    return Case.translation().with_(
        name=ground, shoe=Shoe.ph4100c(), terrain=GROUNDS[ground](), contact=spheres
    )
