"""Numbers of the P&H 4100C BOSS and of the papers on its crawler track, once, in SI units.

K-chapter and K-paper are those on kinematics, F-paper that on forces, S-paper that on stress. What they leave
open and is chosen here is marked so. Pitch, pins and outline of the shoe stand in `meshes.geometry`, which
makes its mesh of them.
"""

import math
from typing import Final

from meshes.geometry import (
    COM_HEIGHT,
    FRONT_PIN_X,
    PIN_HEIGHT,
    PITCH,
    TRACK_PIN_Y,
    TRACK_Y,
    ShoeDimensions,
)

GRAVITY = 9.81
"""m/s2; the K-paper's two-body figures close with no other."""

# shoe (K-chapter and K-paper, tables of shoe properties and COMs)
SHOE_MASS = 4681.67
"""kg: 0.5966 m3 at 7847.25 kg/m3."""
STRESS_SHOE_MASS = 4489.63
"""kg, of every shoe in the stress study, flexible or rigid (S-paper, table 2)."""
COM_NODE = (0.0, 0.0485, 0.0009)
"""m in the shoe's frame: shoe 13's "moved COM" (17.998, 9.3386, 0.2034) less its COM (S-paper, table 4)."""
SHOE_INERTIA = (3995.7, 176.0, 4026.4, 0.0, 0.0, 0.0)
"""kg m2, xx, yy, zz, yz, xz, xy. Not printed (CAD): those of the shoe in `meshes/`, scaled from the mesh's
mass to this one; products of inertia (0.1 %) left out, so that the shoe is even about its middle plane."""
SHOE_COM_HEIGHT = COM_HEIGHT
"""m above the underside: z of the COMs, with the undersides at z = 0."""
SHOE_LENGTH = ShoeDimensions.plate_length
"""m, of the underside. Not printed: that of the shoe in `meshes/`."""
SHOE_WIDTH = ShoeDimensions.width
"""m, of the underside."""
SHOE_LOAD_HEIGHT = 0.2014
"""m above the COM, of the load point. Not printed: the mesh's top face at its centroid."""

# track (K-chapter and K-paper, tables of COMs and joints)
SHOE_COUNT = 13
"""Shoes 1..13 = Parts 2..14."""
FIRST_COM = (10.1291, TRACK_Y)
"""m, x and y of the COM of shoe 1."""
TRACK_PITCH = PITCH
"""m, spacing of the COMs: (17.9980 - 10.1291) / 12."""
PIN_AHEAD = FRONT_PIN_X
"""m, x of the front pin ahead of the COM: link 1 at x = 10.4379, shoe 1 at 10.1291."""
PIN_ABOVE_COM = PIN_HEIGHT
"""m: pins at z = 0.25, COMs at 0.2025."""
SPHERICAL_Y, PARALLEL_Y = TRACK_PIN_Y["right"], TRACK_PIN_Y["left"]
"""m, y of the spherical and of the parallel-axes joints."""

# terrain of the rigid studies (K-chapter, K-paper and F-paper)
SOIL_DENSITY = 1600.0
"""kg/m3, of oil sand (all papers)."""
SPRING_STIFFNESS = 20e6
"""N/m, of every spring-damper (all papers); of the S-paper E A / L with E = 20 MPa."""
SPRING_DAMPING = 120e3
"""N s/m, of every spring-damper (all papers)."""
COARSE_COLUMNS, COARSE_ROWS = 10, 5
"""Units along x and along y: 70 x 35 m."""
COARSE_UNIT = (7.0, 7.0, 2.0)
"""m, sides of a unit along x, y, z."""
COARSE_SPRINGS: Final = 2
"""Under each unit."""
COARSE_SPRING_OFFSET = COARSE_UNIT[0] / (2.0 * math.sqrt(3.0))
"""m from the unit's centre. Chosen here: the Gauss points of its length, where two springs resist heave and
pitch exactly as an evenly spread support of the same stiffness does."""

# terrain of the S-paper
FINE_COLUMNS, FINE_ROWS = 19, 13
"""Units along x and along y."""
FINE_UNIT = (1.0, 1.0, 1.0)
"""m, sides of a unit along x, y, z."""
FINE_SPRINGS: Final = 1
"""Under each unit."""
FINE_ORIGIN = (5.044, 2.7901)
"""m, corner at unit 1. Chosen here: the same margin on both sides of the track and, halfway through the
drive, before and behind it, 4.7 m and 4.7 m ("4 to 5 m" in the paper)."""

# contact (all papers, contact table)
CONTACT_STIFFNESS = 1.0e8
"""N/m^e, k of the IMPACT law."""
CONTACT_EXPONENT = 2.0
"""e of the IMPACT law."""
CONTACT_DAMPING = 1.0e4
"""N s/m, c_max of the IMPACT law."""
DAMPING_DEPTH = 1.0e-4
"""m, d of the IMPACT law."""
STATIC_FRICTION, DYNAMIC_FRICTION = 0.4, 0.3
"""mu_s and mu_d."""
STICTION_SPEED, FRICTION_SPEED = 0.01, 0.1
"""m/s, V_st and V_d."""
EDGE_WIDTH = 0.01
"""m. Chosen here: 0.05 m changes means by less than 1 %."""
SPHERES = (4, 5)
"""Along and across a shoe. Chosen here: four along a shoe resist its pitch within 6 % of an even support."""
SPHERE_RADIUS = 0.2
"""m. Chosen here: it bounds the step between units that a track can climb."""

# drive
PROPEL_SPEED, PROPEL_RISE = 0.1, 5.0
"""m/s and s (K-chapter eq. 27 to 29): 0.012 t2 - 0.0016 t3 up to this speed and time."""
TURN_RATE = math.radians(1.0)
"""rad/s (K-chapter): 0.12 t2 - 0.016 t3 deg/s up to 1 deg/s, in the same time."""
BRAKE_START, REST_START = 10.0, 15.0
"""s (S-paper): the speed falls from the first time to rest at the second, when the drive is switched off."""

# loads
PROPEL_LOAD = 386.4e3
"""N on every shoe during propel (F-paper): the weight of the machine less the shoes, evenly spread."""
DIPPER_LOAD = 445e3
"""N of dipper load per track (S-paper)."""
MIDDLE_SHOE = 7
"""Shoe whose loads the S-paper prints."""
DIG_LOAD, SWING_LOAD, DUMP_LOAD = 384e3, 732e3, 541e3
"""N on the middle shoe at the ends of dig, swing and dump (S-paper)."""
PROPEL_END, DIG_END, SWING_END, DUMP_END, RETURN_END = REST_START, 22.5, 30.0, 33.5, 40.0
"""s, ends of the phases (S-paper)."""

# flexible shoes (S-paper)
FLEXIBLE_SHOES = (6, 7, 8, 11, 12, 13)
"""Middle and front shoes."""
YOUNGS_MODULUS = 200e9
"""Pa."""
POISSONS_RATIO = 0.3
STEEL_DENSITY = 7847.25
"""kg/m3."""
RECOVERED_MODES = 76
"""Fixed-interface modes."""
INTEGRATED_MODES = 10
"""Fixed-interface modes that answer dynamically. Chosen here: the others follow without inertia."""
DAMPING_FREQUENCIES, DAMPING_RATIOS = (1000.0, 10000.0), (0.005, 1.0)
"""Hz and 1, modal damping: 0.005 up to the first frequency, a STEP to 1 at the second."""
