"""Positions of the pins and dimensions of the crawler shoe.

Shoe axes: x along the propel direction, y lateral, z up; origin at the nominal centre of mass.
"""

import math
from dataclasses import asdict, dataclass

SHOE_SIZES = ("coarse", "study", "fine")
"""Ready meshes of the shoe."""

VOLUMES = {"coarse": 0.5738718647896, "study": 0.5733535400234, "fine": 0.5733501852505}
"""Volumes of the ready meshes, m3, for the mass without reading files."""
NODES = {"coarse": 13773, "study": 26494, "fine": 65481}
"""Numbers of nodes of the ready meshes, for the same reason."""

PITCH = 0.655742
"""Distance between the pins of neighbouring shoes, m (distance of the papers' centres of mass)."""

COM_HEIGHT = 0.2025
"""Nominal height of the centre of mass above the underside in m."""

PIN_HEIGHT = 0.0475
"""z of all pin axes in m, in shoe axes (pins 0.25 m above the underside)."""

FRONT_PIN_X = 0.3088
"""x of the front pin axis in m, in shoe axes."""

REAR_PIN_X = FRONT_PIN_X - PITCH
"""x of the rear pin axis, m, in shoe axes; the front pin of the neighbour behind coincides with it."""

TRACK_Y = 9.2901
"""y of the track's centres of mass in m, in the papers' global axes."""

TRACK_PIN_Y = {"right": 8.68, "left": 10.03}
"""y of the track's joint centres in m, in the papers' global axes."""

PIN_Y = {side: y - TRACK_Y for side, y in TRACK_PIN_Y.items()}
"""y of the joint centres, m; left is +y for a viewer along +x."""

JOINT_CENTERS: dict[str, tuple[float, float, float]] = {
    f"{end} {side}": (x, y, PIN_HEIGHT)
    for end, x in (("front", FRONT_PIN_X), ("rear", REAR_PIN_X))
    for side, y in PIN_Y.items()
}
"""Joint centres in shoe axes in m, by interface name."""


GREATEST_LENGTH = 10.0
"""Upper limit of any dimension of a shoe, m."""

MAY_BE_ZERO = ("rail_overhang", "core_wall", "wear")
"""Dimensions that are zero for a shoe without this feature."""


@dataclass(frozen=True)
class ShoeDimensions:
    """Dimensions of the shoe in m; heights are above the underside unless said otherwise.

    A rail stands on a solid block that ends `rail_overhang` before both rail ends; the overhanging rail is
    `rail_depth` thick, from its unworn top down. With a `core_wall` the beam has closed pockets: walls of
    this thickness around and between them, and `core_roof` of steel from the unworn top of the rails down.
    `wear` is the height lost by the rails. No drawing shows which of these features a real 4100C has.

    Raises
    ------
    ValueError
        If a dimension has a wrong sign or exceeds any shoe (the message names it), if plates fill the height
        of the shoe, or if an overhang, a core or wear leaves no rail or no beam.
    """

    width: float = 3.505
    plate_length: float = 0.63
    plate_thickness: float = 0.036
    beam_length: float = 0.336
    beam_center_x: float = 0.0043
    beam_height: float = 0.396
    plateau_half_width: float = 1.0
    wing_tip_length: float = 0.17
    wing_tip_height_right: float = 0.4085
    wing_tip_height_left: float = 0.3915
    top_length: float = 0.60
    top_thickness: float = 0.042
    front_notch_margin: float = 0.03
    rear_notch_margin: float = 0.085
    notch_fillet: float = 0.04
    rail_center_y: float = 0.24
    rail_width: float = 0.22
    rail_height: float = 0.426
    rail_overhang: float = 0.0
    rail_depth: float = 0.072
    core_wall: float = 0.0
    core_roof: float = 0.1
    wear: float = 0.0
    bore_radius: float = 0.065
    rear_lug_width: float = 0.165
    rear_lug_radius: float = 0.12
    rear_root_fillet: float = 0.04
    rear_edge_fillet: float = 0.02
    cheek_width: float = 0.09
    cheek_radius: float = 0.11
    cheek_root_fillet: float = 0.03
    throat_fillet: float = 0.02
    side_clearance: float = 0.0125
    nose_clearance: float = 0.012

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            least = "positive or zero" if name in MAY_BE_ZERO else "a positive length in m"
            wrong = value < 0.0 or (value == 0.0 and name not in MAY_BE_ZERO)
            if not math.isfinite(value) or (wrong and name != "beam_center_x"):
                raise ValueError(f"{name} must be {least}, got {value}")
            if abs(value) > GREATEST_LENGTH:
                raise ValueError(f"{name} must be at most {GREATEST_LENGTH:g} m, got {value}")
        lowest = min(self.beam_height, self.wing_tip_height_right, self.wing_tip_height_left)
        if self.top_thickness + self.plate_thickness >= lowest:
            raise ValueError(
                f"top_thickness must be less than the {lowest - self.plate_thickness:.4g} m that are above "
                f"plate_thickness = {self.plate_thickness} up to the top's lowest edge, "
                f"got {self.top_thickness}"
            )
        limits = {
            "rail_overhang": 0.5 * (self.top_length - self.beam_length),
            "wear": self.rail_height - self.beam_height,
            "core_wall": 0.25 * self.beam_length,
            "core_roof": self.rail_height - self.plate_thickness - self.core_wall,
            "rail_depth": self.rail_height - self.plate_thickness,
        }
        for name, most in limits.items():
            rest = 1e-9 if name == "rail_overhang" else -1e-9
            if getattr(self, name) > max(most + rest, 0.0):
                words = "at most" if rest > 0.0 else "less than"
                raise ValueError(f"{name} must be {words} {most:.4g} m here, got {getattr(self, name)}")

    @property
    def path_height(self) -> float:
        """Height of the worn top of the rails in m."""
        return self.rail_height - self.wear

    @property
    def rear_face(self) -> float:
        """X of the beam's rear face, m, at the roots of the rear lugs."""
        return self.beam_center_x - self.beam_length / 2

    @property
    def front_face(self) -> float:
        """X of the beam's front face, m, at the roots of the forks."""
        return self.beam_center_x + self.beam_length / 2

    @property
    def fork_gap(self) -> float:
        """Width of the gap between the cheeks of a fork in m."""
        return self.rear_lug_width + 2 * self.side_clearance

    @property
    def fork_width(self) -> float:
        """Width of a fork over both cheeks in m."""
        return self.fork_gap + 2 * self.cheek_width
