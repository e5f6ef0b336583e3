"""Shoe of a chain of links, built with OpenCASCADE: a plate with grousers below, two links with rails above.

Each link ends in a lug behind and in a fork in front, which takes the lug of the next shoe. Bores, rails and
underside have the names of the papers' shoe. Real links are forged with bosses side by side; here they are a
block on the plate, with a rail that overhangs fork and lug.
"""

import math
from dataclasses import dataclass
from typing import Any

from fem.body.mesh import Mesh
from meshes import build_shoe, mesher
from meshes.geometry import PITCH
from meshes.solid import box, lug, notch_cutter, polygon, throat_cutter

REFERENCE = PITCH
"""Pitch of the built solids, m, so that elements and tolerances are those of the papers' shoe."""
PLACES: dict[int, tuple[float, ...]] = {0: (), 1: (0.38,), 2: (-0.3, 0.3), 3: (-0.36, 0.0, 0.36)}
"""Positions of the grousers for each number of grousers: pitches ahead of the plate's middle."""
STOUTNESS = {1: (0.08, 0.16), 2: (0.07, 0.14), 3: (0.07, 0.13)}
"""Thickness of a grouser's tip and root for each number of grousers, pitches (assumed, no source)."""
PLATE = 0.98  # length of the plate and of a rail, pitches
THICKNESSES = 0.03, 0.16
"""Range of plate thicknesses, pitches (assumed): 6 to 34 mm at a pitch of 216 mm."""
BLOCK = 0.27  # half of the length of a link's block, pitches
LUG, LUG_OF_DEPTH = 0.17, 0.62  # radius of lugs, pitches, and its upper limit, fraction of the pin height
CHEEK = 0.92  # radius of a fork's cheeks over a lug's; they end before the rounded rim of the throat
BORE = 0.54  # radius of the bores over a lug's
RAIL_DEPTH = 0.1  # depth of a rail's overhang, pitches
PLAY = 0.01  # clearance between a lug and the plate, and a lug and its fork, pitches
LEAST_PLAY = 0.005  # clearance between the fillets of lugs and a plate without notches, pitches
LEAST_NOTCH = 0.03  # least depth of a notch, pitches
OF_RAIL = {"rear": 0.36, "cheek": 0.19, "beside": 0.03, "fillet": 0.08}
"""Dimensions over a rail's width: rear lug, cheek, gap beside the lug, and radius of the root fillets."""


PLATE_TOP = "plate top"
"""Name of the plate's upper faces, which belong to the whole top."""
SURFACES = {
    "underside": ("underside",),
    "roller path": ("roller path",),
    "top": ("roller path",),
    "whole top": ("roller path", PLATE_TOP),
}
"""Named surfaces and their faces. Grousers sink into the ground: the plate between them is the underside."""


@dataclass(frozen=True)
class GrouserShoe:
    """Dimensions of a shoe of links; lengths in pitches, heights above the plate's underside.

    Attributes
    ----------
    width : float
    grousers : int
        0 to 3.
    grouser_height : float
    plate_thickness : float
    pin_height : float
    rail_height : float
    rail_center : float
        Distance of a rail from the middle.
    rail_width : float

    Raises
    ------
    ValueError
        If links stand beside the plate, if it is too thin or too thick, or if lugs reach up to the rails.
    """

    width: float
    grousers: int
    grouser_height: float
    plate_thickness: float
    pin_height: float
    rail_height: float
    rail_center: float
    rail_width: float

    def __post_init__(self) -> None:
        reach = 2.0 * self.rail_center + self.rail_width
        if reach > self.width:
            raise ValueError(f"a shoe {self.width:.3g} pitches wide has no place for rails over {reach:.3g}")
        if self.grousers not in PLACES:
            raise ValueError(f"grousers must be in 0..3, got {self.grousers}")
        least, most = THICKNESSES
        if not least <= self.plate_thickness <= min(most, self.pin_height):
            raise ValueError(
                f"plate_thickness must be {least:g} to {most:g} pitches and below the pins, got "
                f"{self.plate_thickness:.3g}"
            )
        if self.rail_depth <= 0.0:
            raise ValueError(f"rail_height must be above the lugs, got {self.rail_height:.3g} pitches")

    @property
    def lug_radius(self) -> float:
        """Radius of the lugs about the pins."""
        return min(LUG, LUG_OF_DEPTH * self.pin_height)

    @property
    def bore_radius(self) -> float:
        """Radius of the bores."""
        return BORE * self.lug_radius

    @property
    def notch_floor(self) -> float | None:
        """Height of the plate's notches below the lugs; None if the lugs clear the full plate.

        The floor lies below the fillets of the lugs: steps of a millimetre would need elements as small.
        """
        free = self.pin_height - self.lug_radius - OF_RAIL["fillet"] * self.rail_width
        if self.plate_thickness <= free - LEAST_PLAY:
            return None
        return min(free - PLAY, self.plate_thickness - LEAST_NOTCH)

    @property
    def rail_depth(self) -> float:
        """Depth of a rail where it overhangs lugs."""
        return min(RAIL_DEPTH, self.rail_height - self.pin_height - self.lug_radius - PLAY)


def pins_of(shoe: GrouserShoe) -> dict[str, tuple[float, float, float]]:
    """Return the joint centres, m, at the pitch `REFERENCE`, from the middle of the plate's underside."""
    return {
        f"{end} {side}": (x * REFERENCE, y * REFERENCE, shoe.pin_height * REFERENCE)
        for end, x in (("front", 0.5), ("rear", -0.5))
        for side, y in (("right", -shoe.rail_center), ("left", shoe.rail_center))
    }


def _grouser(occ: Any, shoe: GrouserShoe, ahead: float) -> Any:
    """Return a grouser across the plate, tapering to its tip; m."""
    tip, root = (0.5 * thickness * REFERENCE for thickness in STOUTNESS[shoe.grousers])
    x = ahead * REFERENCE
    half = 0.5 * shoe.width * REFERENCE
    low = -shoe.grouser_height * REFERENCE
    corners = [(x - root, -half, 0.0), (x + root, -half, 0.0), (x + tip, -half, low), (x - tip, -half, low)]
    return polygon(occ, corners).Extrude(occ.Vec(0, 2.0 * half, 0))


def _link(occ: Any, shoe: GrouserShoe, y: float) -> Any:
    """Return the block of a link with its rail, from the plate's underside up; m."""
    across = (y - 0.5 * shoe.rail_width * REFERENCE, y + 0.5 * shoe.rail_width * REFERENCE)
    top = shoe.rail_height * REFERENCE
    long = 0.5 * PLATE * REFERENCE
    block = box(occ, (-BLOCK * REFERENCE, BLOCK * REFERENCE), across, (0.0, top))
    return block + box(occ, (-long, long), across, (top - shoe.rail_depth * REFERENCE, top))


def build_grouser_solid(occ: Any, shoe: GrouserShoe) -> Any:
    """Build the solid of a shoe of links at the pitch `REFERENCE`, with named bore faces; m.

    `occ` is `netgen.occ`. The origin is in the middle of the plate's underside.
    """
    half = 0.5 * shoe.width * REFERENCE
    long = 0.5 * PLATE * REFERENCE
    body = box(occ, (-long, long), (-half, half), (0.0, shoe.plate_thickness * REFERENCE))
    for ahead in PLACES[shoe.grousers] if shoe.grouser_height > 0.0 else ():
        body += _grouser(occ, shoe, ahead)
    rear, cheek, beside, fillet = (part * shoe.rail_width * REFERENCE for part in OF_RAIL.values())
    fork = rear + 2.0 * beside
    floor = shoe.notch_floor
    if floor is not None:
        for pin in pins_of(shoe).values():
            half_width = 0.5 * fork + cheek + 2.0 * fillet
            root = math.copysign((BLOCK - PLAY) * REFERENCE, pin[0])
            slot = notch_cutter(occ, pin[1], half_width, root, 2.0 * pin[0], fillet)
            body -= slot.Move(occ.gp_Vec(0, 0, floor * REFERENCE))
    radius = shoe.lug_radius * REFERENCE
    bore = shoe.bore_radius * REFERENCE
    tools = []
    for side in (-1.0, 1.0):
        body += _link(occ, shoe, side * shoe.rail_center * REFERENCE)
    for name, pin in pins_of(shoe).items():
        front = name.startswith("front")
        width = fork + 2.0 * cheek if front else rear
        sense = 1.0 if front else -1.0
        nose = CHEEK * radius if front else radius
        body += lug(occ, pin, width, nose, sense * BLOCK * REFERENCE, fillet, fillet)
        x, y, z = pin
        reach = 0.55 * (fork + 2.0 * cheek)
        hole = occ.Cylinder(occ.Pnt(x, y - reach, z), occ.Dir(0, 1, 0), r=bore, h=2.0 * reach)
        hole.faces.name = f"bore {name}"
        tools.append(hole)
        if front:
            tools.append(throat_cutter(occ, pin, fork, radius + PLAY * REFERENCE, 0.5 * fillet))
    for tool in tools:
        body -= tool
    if len(body.solids) != 1 or not math.isfinite(body.mass):
        raise ValueError(f"dimensions must make one solid, got {len(body.solids)} separate ones with {shoe}")
    return body


def mesh_grouser_shoe(shoe: GrouserShoe, size: build_shoe.ElementSizes) -> Mesh:
    """Mesh a shoe of links at the pitch `REFERENCE` with quadratic tetrahedra, fine at bores and roots.

    The origin is in the middle of the plate's underside. Raise `ModuleNotFoundError` if netgen is missing.
    """
    mesher.require_netgen("meshing a shoe")
    return mesher.call(_meshed, shoe, size)


def _meshed(shoe: GrouserShoe, size: build_shoe.ElementSizes) -> Mesh:
    """Mesh a shoe of links in the mesher's process."""
    occ = build_shoe.netgen_kernel()
    body = build_grouser_solid(occ, shoe)
    heights = {"underside": 0.0, PLATE_TOP: shoe.plate_thickness, "roller path": shoe.rail_height}
    build_shoe.name_level_faces(body, {name: REFERENCE * height for name, height in heights.items()})
    fillet = OF_RAIL["fillet"] * shoe.rail_width
    for face in body.faces:
        low, high = (corner.x / REFERENCE for corner in face.bounding_box)
        if face.name is not None and face.name.startswith("bore"):
            face.maxh = size.at_bores
        elif -BLOCK - 1.5 * fillet < low and high < 0.5 * fillet - BLOCK:
            face.maxh = size.at_rear_roots
    return build_shoe.mesh_of_netgen(build_shoe.netgen_mesh(occ, body, size), SURFACES)
