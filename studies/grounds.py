"""Grounds and cases of the study of uneven ground; this does not load the runs."""

from exudyn_crawler import Case, PairContact, Shoe, SphereContact, Terrain
from exudyn_crawler.case import Heights
from exudyn_crawler.case.parameters.heights import Ramp, Roughness

STEP_PLACE, STEP_HEIGHT = 14.0, 0.1  # m, position below the middle of the track at t = 0, and height
RAMP_START, RAMP_END, RAMP_HEIGHT = 8.0, 20.0, 0.6  # m, grade of 5 % over the whole track
STEP_LENGTH = 1.0  # m, length of the unit that climbs the step
ROUGHNESS = Roughness(spectrum=1.4e-3, shortest=4.0, seed=1)
"""Roughness with a standard deviation of about 20 mm, in waves that units of 1 m follow."""


def strip(relief: Heights) -> Terrain:
    """Return one row of 13 units below the track, 1 m long and 5 m wide, for a relief that varies along it.

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
        relief=relief,
    )


GROUNDS: dict[str, Heights] = {
    "step": Heights(parts=(Ramp(x=STEP_PLACE, height=STEP_HEIGHT, flank=STEP_LENGTH),)),
    "ramp": Heights(parts=(Ramp(x=RAMP_START, height=RAMP_HEIGHT, flank=RAMP_END - RAMP_START),)),
    "rough": Heights(roughness=ROUGHNESS),
}
"""Reliefs of the study by name."""


def pitching(case: Case) -> Case:
    """Return a case with units that pitch, on springs at the Gauss points of their length.

    Two springs there resist heave and pitch exactly like an evenly spread support of the same stiffness.
    """
    terrain = case.part(Terrain)
    return case.with_(terrain=terrain.with_(tilt="pitch", spring_offset=terrain.unit_length / 12.0**0.5))


def plain(case: Case) -> Case:
    """Return a case without lateral motion of a straight track: no fingers, face normals, pitching units."""
    return pitching(case.with_(shoe=Shoe.ph4100c(), contact=PairContact.oil_sand()))


def uneven_case(ground: str) -> Case:
    """Return straight propel over one of the grounds, with faces drawn back from the units' seams.

    Seams of units 1 m long lie under most shoes. Whole faces would make the ground stiffer there and lift the
    shoes above its heights. Raises `ValueError` for an unknown ground.
    """
    if ground not in GROUNDS:
        raise ValueError(f"ground must be one of {', '.join(GROUNDS)}, got {ground!r}")
    spheres = SphereContact.oil_sand().with_(faces="drawn_back")
    # contact by spheres has no fingers
    return Case.translation().with_(
        name=ground, shoe=Shoe.ph4100c(), terrain=strip(GROUNDS[ground]), contact=spheres
    )
