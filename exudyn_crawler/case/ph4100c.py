"""Numbers of the P&H 4100C BOSS and of the papers on its crawler track, once, in SI units.

K-chapter and K-paper are those on kinematics, F-paper that on forces, S-paper that on stress. Values
that they do not state are assumed here and marked so. Pitch, pins and outline of the shoe are in
`meshes.geometry`, from which its mesh is made. A mapping holds the values of one parameter class by the names
of its fields.
"""

import math
from collections.abc import Mapping
from typing import Any

from meshes.geometry import COM_HEIGHT, FRONT_PIN_X, PIN_HEIGHT, PITCH, TRACK_PIN_Y, TRACK_Y, ShoeDimensions

GRAVITY = 9.81  # m/s2; the K-paper's two-body figures close with no other

STRESS_SHOE_MASS = 4489.63  # kg, of every shoe in the stress study, flexible or rigid (S-paper, table 2)
SHOE: Mapping[str, Any] = {
    "mass": 4681.67,  # kg: 0.5966 m3 at 7847.25 kg/m3
    # kg m2, xx, yy, zz, yz, xz, xy. Not printed (CAD): those of the shoe in `meshes/`, scaled from the mesh's
    # mass to this one; products of inertia (0.1 %) left out, so that the shoe is even about its middle plane
    "inertia": (3995.7, 176.0, 4026.4, 0.0, 0.0, 0.0),
    "com_height": COM_HEIGHT,  # m above the underside: z of the COMs, with the undersides at z = 0
    "length": ShoeDimensions.plate_length,  # m, of the underside. Not printed: that of the shoe in `meshes/`
    "width": ShoeDimensions.width,  # m, of the underside
    "underside_center": (0.0, 0.0),
    "load_point": (0.0, 0.0, 0.2014),  # m from the COM. Not printed: the mesh's top face at its centroid
}
"""Shoe of the rigid studies (K-chapter and K-paper, tables of shoe properties and COMs)."""
FINGERED_UNDERSIDE: Mapping[str, Any] = {
    # m. The F-paper's shoe 7 has three contacts with unit 7 (x < 14 m) from 4.1 to 5.3 s and one before: by
    # the drive its rear edge is 0.344 m behind its COM and the last 0.117 m are three fingers. Chosen here:
    # it is as long as the pitch, so that shoes tile the ground, and the fingers fill the width but for the
    # lugs about the pins, whose faces the S-paper's hot spots show at y = 8.59, 8.76, 9.95 and 10.11 m
    "length": PITCH,
    "underside_center": (0.5 * PITCH - 0.344, 0.0),
    "finger_length": 0.117,
    "finger_sides": (
        *(-0.5 * ShoeDimensions.width, 8.59 - TRACK_Y, 8.76 - TRACK_Y),
        *(9.95 - TRACK_Y, 10.11 - TRACK_Y, 0.5 * ShoeDimensions.width),
    ),
}
"""Underside of the shoe in the rigid studies."""
UNEVENNESS = 0.165
"""m, of the underside's middle beside the COM and the load. Fitted: a track that is so uneven flutters in the
turn as the K-paper reports; its mean roll asks for more (`docs/validation.md`)."""
RAILS: Mapping[str, Any] = {
    "rear": ShoeDimensions.beam_center_x - 0.5 * ShoeDimensions.top_length,  # m
    "front": ShoeDimensions.beam_center_x + 0.5 * ShoeDimensions.top_length,
    "right": -ShoeDimensions.rail_center_y,
    "left": ShoeDimensions.rail_center_y,
    "width": ShoeDimensions.rail_width,
    "height": ShoeDimensions.rail_height - COM_HEIGHT,
}
"""Rails of the roller path. No paper prints them: those of the shoe in `meshes/`."""

SHOE_COUNT = 13  # shoes 1..13 = Parts 2..14
TRACK: Mapping[str, Any] = {
    "shoe_count": SHOE_COUNT,
    "first_com": (10.1291, TRACK_Y),  # m, x and y of the COM of shoe 1
    "pitch": PITCH,  # m, spacing of the COMs: (17.9980 - 10.1291) / 12
    "pin_ahead": FRONT_PIN_X,  # m, x ahead of the COM: link 1 at x = 10.4379, shoe 1 at 10.1291
    "pin_height": PIN_HEIGHT,  # m above the COM: pins at z = 0.25, COMs at 0.2025
    "spherical_y": TRACK_PIN_Y["right"],  # m
    "parallel_y": TRACK_PIN_Y["left"],
}
"""Track (K-chapter and K-paper, tables of COMs and joints)."""


_OIL_SAND: Mapping[str, Any] = {
    "density": 1600.0,  # kg/m3
    "spring_stiffness": 20e6,  # N/m, of every spring-damper; of the S-paper E A / L with E = 20 MPa
    "spring_damping": 120e3,  # N s/m, of every spring-damper
}
"""Units on springs (all papers)."""
COARSE_TERRAIN: Mapping[str, Any] = {
    **_OIL_SAND,
    "columns": 10,
    "rows": 5,
    "unit_length": 7.0,  # m
    "unit_width": 7.0,
    "unit_height": 2.0,
    # not stated in the papers; the F-paper's shoe 10 has a normal force without x and with a steady y of
    # 0.0015 of it, so that its unit rolls and does not pitch
    "tilt": "roll",
    "springs_per_unit": 2,
    # m from the unit's centre. Not stated in the papers; at the unit's edges that y force comes out as
    # 0.0019 of the normal force, and anywhere within them as more
    "spring_offset": 3.5,
    "column_tilt": False,
}
"""Terrain of the rigid studies (K-chapter, K-paper and F-paper)."""
FINE_TERRAIN: Mapping[str, Any] = {
    **_OIL_SAND,
    "columns": 19,
    "rows": 13,
    "unit_length": 1.0,  # m
    "unit_width": 1.0,
    "unit_height": 1.0,
    "tilt": "pitch",  # chosen here
    "springs_per_unit": 1,
    "spring_offset": 0.0,
    "column_tilt": True,
    # m. Chosen: before and behind the track the same margin halfway through the drive (4.7 m; "4 to 5 m" in
    # the S-paper), and a seam below the track's middle. The pair law knows no area: with a row of units below
    # the middle the outermost 0.25 m of a shoe would push as hard as a whole unit; with the seam there are
    # four rows, of which the narrowest carries 0.75 m. The margins beside the track are 4.2 and 5.2 m
    "origin": (5.044, 3.2901),
}
"""Terrain of the S-paper."""
FITTED_SEAMS_X = 5.394
"""m, x of the same terrain. Fitted: with its seams here, or within 2 cm of here, the range of contact forces
at rest under the loads of the cycle is the S-paper's within 10 %."""

PAIR_CONTACT: Mapping[str, Any] = {
    "stiffness": 1.0e8,  # N/m^e, k of the IMPACT law
    "exponent": 2.0,  # e of the IMPACT law
    "damping": 1.0e4,  # N s/m, c_max of the IMPACT law
    "damping_depth": 1.0e-4,  # m, d of the IMPACT law
    "static_friction": 0.4,  # mu_s
    "dynamic_friction": 0.3,  # mu_d
    "stiction_speed": 0.01,  # m/s, V_st
    "friction_speed": 0.1,  # m/s, V_d
    "edge_width": 0.01,  # m. Chosen here: 0.05 m changes means by less than 1 %
}
"""Steel shoe on oil sand (all papers, contact table)."""
SPHERE_CONTACT: Mapping[str, Any] = {
    "spheres_x": 4,  # chosen here: four along a shoe resist its pitch within 6 % of an even support
    "spheres_y": 5,  # chosen here
    "radius": 0.2,  # m. Chosen here: it bounds the step between units that a track can climb
    "reference_stiffness": PAIR_CONTACT["stiffness"],
    "reference_exponent": PAIR_CONTACT["exponent"],
    "damping": PAIR_CONTACT["damping"],
    # the papers' friction falls from mu_s at V_st to mu_d at V_d; a track at full propel slips at V_d
    "friction": PAIR_CONTACT["dynamic_friction"],
    "friction_speed": PAIR_CONTACT["stiction_speed"],
}
"""Spheres under a shoe on oil sand."""

# drive
PROPEL_SPEED, PROPEL_RISE = 0.1, 5.0
"""m/s and s (K-chapter eq. 27 to 29): 0.012 t2 - 0.0016 t3 up to this speed and time."""
TURN_RATE = math.radians(1.0)  # rad/s (K-chapter): 0.12 t2 - 0.016 t3 deg/s up to 1 deg/s, in the same time
BRAKE_START, REST_START = 10.0, 15.0
"""s (S-paper): the speed falls from the first time to rest at the second, when the drive is switched off."""

# loads
PROPEL_LOAD = 386.4e3
"""N on every shoe during propel (F-paper): the weight of the machine less the shoes, evenly spread."""
DIPPER_LOAD = 445e3  # N of dipper load per track (S-paper)
MIDDLE_SHOE = 7  # shoe whose loads the S-paper prints
DIG_LOAD, SWING_LOAD, DUMP_LOAD = 384e3, 732e3, 541e3
"""N on the middle shoe at the ends of dig, swing and dump (S-paper)."""
PROPEL_END, DIG_END, SWING_END, DUMP_END, RETURN_END = REST_START, 22.5, 30.0, 33.5, 40.0
"""s, ends of the phases (S-paper)."""

# rolling propel
MACHINE_MASS, SHOES_ON_GROUND = 1_410_184.0, 16  # kg, and shoes of a track that touch the ground (K-chapter)
CRAWLER_LENGTH, GAUGE = 11.6, 12.8 - ShoeDimensions.width
"""m (K-chapter): length of a crawler; gauge, from the width over both tracks."""
_CARRIED = 0.5 * MACHINE_MASS - SHOES_ON_GROUND * SHOE["mass"]
ROLLER_RADIUS, TREAD_WIDTH = 0.4, 0.18
"""m. Assumed; treads are within the rails."""
UNDERCARRIAGE: Mapping[str, Any] = {
    "mass": _CARRIED,  # kg: mass on one track without the shoes that touch the ground
    # kg m2. Assumed: radii of gyration of 1.5 m in roll, which the other track resists, and 4 m in pitch and
    # yaw
    "inertia": (_CARRIED * 1.5**2, _CARRIED * 4.0**2, _CARRIED * 4.0**2, 0.0, 0.0, 0.0),
    "com": (0.0, 0.0, 0.5),  # m. Assumed: where the car body rests on the side frame
    "start": 15.8,  # m. Chosen here: the whole frame is over shoes
    "ends": (-0.5 * CRAWLER_LENGTH, 0.5 * CRAWLER_LENGTH),
    # m. Assumed: no public source has number, spacing and radius of the lower rollers; 8 over 8.75 m
    "rollers": tuple(1.25 * (k - 3.5) for k in range(8)),
    "radius": ROLLER_RADIUS,
    "tread_width": TREAD_WIDTH,
    # N/m. Assumed: of the order of Hertz's line contact; the local indentation is beyond the shoe's mesh
    "stiffness": 1.0e9,
    "damping": 3.0e5,  # N s/m. Chosen here: a tenth of critical for a shoe under one roller
    "damping_depth": 1.0e-4,  # m. Chosen here
    "rolling_resistance": 0.03,  # Assumed: a few per cent
    "resistance_speed": 5.0e-3,  # m/s. Chosen here: a twentieth of the propel speed
    "tumbler": -5.0,  # m. Assumed: at the rear
    # N. Assumed: an open chain without tension may fold up under the rollers, where a machine's is
    # held by its wheels
    "end_tension": 5.0e5,
}
"""Side frame, lower rollers and drive of one track."""

SHOVEL: Mapping[str, Any] = {
    # kg: the machine without the shoes that touch the ground; what is in no part below is on the swing axis
    "mass": 2.0 * _CARRIED,
    "upper": 800e3,  # kg. Assumed: machinery deck with counterweight, without the front
    "upper_place": (-2.5, 4.0),  # m ahead of the swing axis and above the rollers' axes. Assumed
    "front": 130e3,  # kg at the dipper. Assumed: dipper, handle and their part of the boom
    "lower_height": 0.5,  # m above the rollers' axes: what is on the swing axis. Assumed
}
"""Masses of the shovel and their places."""
_PAYLOAD = 2.0 * DIPPER_LOAD / GRAVITY  # kg: the dipper's load on both tracks
SHOVEL_POSES: tuple[tuple[Any, ...], ...] = (
    # end in s (S-paper); swing in rad, reach and height in m, payload in kg, force of the bank in N: assumed
    ("propel", PROPEL_END, 0.0, 14.0, 6.0, 0.0),
    ("dig", DIG_END, 0.0, 17.0, 4.0, 0.5 * _PAYLOAD, (-4e5, -4e5)),
    ("hoist and swing", SWING_END, 0.5 * math.pi, 15.0, 9.0, _PAYLOAD),
    ("dump", DUMP_END, 0.5 * math.pi, 15.0, 9.0, 0.0),
    ("return", RETURN_END, 0.0, 14.0, 6.0, 0.0),
)
"""Upper structure at the ends of the phases of a cycle."""

# closed track
CLOSED_SHOES = 38  # Assumed: 38 of this pitch go round wheels 9 m apart, which the crawler's length leaves
_TUMBLER_TEETH = 10
_TUMBLER_MASS = 20e3
_PIN_CIRCLE = PITCH / (2.0 * math.sin(math.pi / _TUMBLER_TEETH))
_RAIL_RISE = RAILS["height"] - PIN_HEIGHT  # m, of the rails above the pins
_LOWER_PINS = -(UNDERCARRIAGE["radius"] + _RAIL_RISE)  # m, of the lower run below the rollers' axes
TUMBLER: Mapping[str, Any] = {
    # m. x: the crawler's length (K-chapter) less the shoes' outside, all that is known; z assumed: its lowest
    # pins are 0.15 m above those under the rollers
    "place": (-4.5, _LOWER_PINS + 0.15 + _PIN_CIRCLE),
    "teeth": _TUMBLER_TEETH,  # Assumed
    "mass": _TUMBLER_MASS,  # kg. Assumed
    # kg m2. Assumed: a ring on the pins' circle, half of it
    "inertia": tuple(share * _TUMBLER_MASS * _PIN_CIRCLE**2 for share in (0.3, 0.5, 0.3, 0.0, 0.0, 0.0)),
    "depth": 0.2,  # m. Assumed, as the three below: teeth that leaving lugs get free of
    "reach": 0.12,  # m
    "lug_radius": 0.09,  # m
    "backlash": 0.0,  # m
    "stiffness": 2.5e8,  # N/m. Assumed: 3.4 mm under 1.7 MN on both sides
    "damping": 1.0e6,  # N s/m. Chosen here
    "damping_depth": 2.0e-4,  # m. Chosen here
}
"""Drive tumbler."""
IDLER: Mapping[str, Any] = {
    "place": (4.5, _LOWER_PINS + 0.06 + 0.9 + _RAIL_RISE),  # m. x by the crawler's length; z assumed
    "radius": 0.9,  # m. Assumed
    # the shims leave no slack. Assumed: tensions at rest follow from it, 0.6 to 0.8 MN on the papers' ground
    "range": (-0.4, 0.4),  # m. Assumed
}
"""Front idler on shims."""
SLIDE_FRICTION = 0.42
"""Hard steel sliding dry on hard steel (Marks' Standard Handbook for Mechanical Engineers, table of friction;
greasy 0.03 to 0.12). Assumed for rails of a shovel, as are the places of slides."""
_CARRIER_RADIUS = 0.25
CLOSED_TRACK: Mapping[str, Any] = {
    "mass": 0.5 * MACHINE_MASS - CLOSED_SHOES * SHOE["mass"] - _TUMBLER_MASS,  # kg
    "inertia": UNDERCARRIAGE["inertia"],
    "com": UNDERCARRIAGE["com"],
    "rollers": tuple(0.95 * (k - 3.0) for k in range(7)),  # m. Assumed: 7 between tumbler and idler
    "roller_radius": UNDERCARRIAGE["radius"],
    # m. Assumed: without carriers 9 m of chain would hang with 1.4 MN for 0.5 m of sag
    "carriers": tuple(
        (1.8 * (k - 1.5), TUMBLER["place"][1] + _PIN_CIRCLE + 0.03 - _RAIL_RISE - _CARRIER_RADIUS)
        for k in range(4)
    ),
    "carrier_radius": _CARRIER_RADIUS,  # m. Assumed
    **{name: UNDERCARRIAGE[name] for name in ("tread_width", "stiffness", "damping", "damping_depth")},
    **{name: UNDERCARRIAGE[name] for name in ("rolling_resistance", "resistance_speed")},
    "guide_play": 0.01,  # m. Assumed, as all of the guides
    "guide_height": 0.05,  # m
    "guide_stiffness": 1.0e8,  # N/m
    "guide_damping": 1.0e6,  # N s/m
}
"""Side frame with its wheels in a closed track."""

# machine on two closed tracks
SIDE_FRAME_MASS, _UPPER_MASS = 100e3, 650e3  # kg. Assumed: each side frame with its wheels; upper structure
_CAR_BODY_MASS = 2.0 * CLOSED_TRACK["mass"] - 2.0 * SIDE_FRAME_MASS - _UPPER_MASS
CAR_BODY: Mapping[str, Any] = {
    "gauge": GAUGE,
    "mass": _CAR_BODY_MASS,  # kg: what is left of the machine
    # kg m2. Assumed: radii of gyration of 3 m in yaw, 2.5 m in roll and pitch
    "inertia": (_CAR_BODY_MASS * 2.5**2, _CAR_BODY_MASS * 2.5**2, _CAR_BODY_MASS * 3.0**2, 0.0, 0.0, 0.0),
    "com": (0.0, 0.0, 0.5),  # m. Assumed
    "upper_mass": _UPPER_MASS,
    # kg m2. Assumed: radii of gyration of 4.5 m in roll, 6 m in pitch, 6.5 m in yaw
    "upper_inertia": (_UPPER_MASS * 4.5**2, _UPPER_MASS * 6.0**2, _UPPER_MASS * 6.5**2, 0.0, 0.0, 0.0),
    # m. Assumed: the counterweight outweighs an empty dipper
    "upper_com": (-1.0, 0.0, 4.5),
}
"""Car body and upper structure. The side frame's radii of gyration stay those of `UNDERCARRIAGE`."""

# flexible shoes
DAMPING_FREQUENCIES, DAMPING_RATIOS = (1000.0, 10000.0), (0.005, 1.0)
"""Hz and 1, modal damping (S-paper): 0.005 up to the first frequency, a STEP to 1 at the second."""
FLEXIBLE_SHOES: Mapping[str, Any] = {
    "shoes": (6, 7, 8, 11, 12, 13),  # middle and front
    "youngs_modulus": 200e9,  # Pa
    "pins": "rigid",  # RBE2, as in the paper's reduction
    "poissons_ratio": 0.3,
    "density": 7847.25,  # kg/m3
    "fixed_modes": 12,  # answer dynamically. Chosen here: the 12th is the last that moves the drive's node
    "recovered_modes": 76,
    # m in the shoe's frame: shoe 13's "moved COM" (17.998, 9.3386, 0.2034) less its COM (table 4)
    "com_node": (0.0, 0.0485, 0.0009),
}
"""Steel shoes of the S-paper."""
