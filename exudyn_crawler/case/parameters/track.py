"""Chain of shoes on the ground: shoe, rails and track, and the flexible shoes."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, ValidationInfo

import fem
from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import base, drive
from exudyn_crawler.case.parameters.base import Length, Place
from exudyn_crawler.case.parameters.pin import LinkPin
from exudyn_crawler.settings import fields, parameters
from exudyn_crawler.settings.parameters import Errors, Parameters, option, quantity
from meshes import SHOE_SIZES

UNEVENNESS: float = ph4100c.UNEVENNESS  # m, lateral offset of the underside's middle from the COM
STEEL_DENSITY: float = ph4100c.FLEXIBLE_SHOES["density"]  # kg/m3
ORIGIN_TOLERANCE = 0.01  # m, between the origin of a mesh and its COM
MOST_SHOES = 1000
SIDES = ("right", "left")
"""Sides of a link's pins: the spherical joint (right) and the parallel-axes joint (left)."""
MIDWAY = "middle"
"""Position in the middle between both pins of a link."""


class Rails(base.PH4100C, values=ph4100c.RAILS):
    """Two level rails of a shoe, in its frame."""

    rear: Place = quantity("m", "x of the rear ends", (-1.0, 0.0))
    front: Place = quantity("m", "x of the front ends", (0.0, 1.0))
    right: Place = quantity("m", "y of the middle of the right rail", (-1.5, 0.0))
    left: Place = quantity("m", "y of the middle of the left rail", (0.0, 1.5))
    width: Length = quantity("m", "width of a rail", (0.02, 1.0))
    height: Place = quantity("m", "z of the rails' tops", (0.0, 1.0))

    def _errors(self) -> Errors:
        if self.front <= self.rear:
            yield f"front must be greater than rear = {self.rear}, got {self.front}"
        if self.left - self.right < self.width:
            yield f"left must be beyond right = {self.right} by the width {self.width}, got {self.left}"

    @property
    def middles(self) -> tuple[float, float]:
        """Lateral positions y of the middles of the right and the left rail, m."""
        return self.right, self.left


class Shoe(base.PH4100C, values=ph4100c.SHOE):
    """Rigid crawler shoe.

    Places are given in the shoe's frame: origin at the COM, x in the propel direction, y lateral, z up.
    """

    mass: float = quantity("kg", "mass of a shoe", (5.0, 2e4), ge=0.1, le=1e7)
    inertia: base.Inertia = quantity("kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of a shoe about its COM (tensor)")
    com_height: Length = quantity("m", "height of the COM above the underside", (0.01, 1.0))
    length: Length = quantity("m", "length of the flat underside in x", (0.01, 2.0))
    width: Length = quantity("m", "width of the flat underside in y", (0.2, 6.0))
    underside_center: base.Two = quantity(
        "m", "x and y of the underside's centre in the shoe's frame", (-1.0, 1.0)
    )
    finger_length: base.Extent = quantity(
        "m",
        "length of the rear fingers between the front lugs of the shoe behind; 0: no fingers",
        (0.0, 0.5),
        default=0.0,
    )
    finger_sides: tuple[Place, ...] = quantity(
        "m", "y of the right and the left side of every finger, from right to left", (-3.0, 3.0), default=()
    )
    ground_share: float = quantity(
        "1",
        "fraction of the underside's rectangle that touches the ground",
        (0.02, 1.0),
        gt=0,
        le=1,
        default=1.0,
    )
    strip_length: base.Extent = quantity(
        "m",
        "length in x of each contact strip, such as a grouser's tip; 0: no strips",
        (0.0, 0.5),
        default=0.0,
    )
    load_point: base.Three = quantity(
        "m", "point of action of the load: centroid of the top face", (-3.0, 3.0)
    )
    rails: Rails | None = option("rails for the rollers", None)

    def _errors(self) -> Errors:
        sides = self.finger_sides
        (low, high) = self.footprint[2:4]
        if (self.finger_length > 0.0) != bool(sides):
            got = f"{self.finger_length:g} m and {len(sides)} sides"
            yield f"finger_length must be positive with finger_sides, and zero without them, got {got}"
        if self.finger_length >= self.length:
            yield f"finger_length must be less than the length {self.length:g} m, got {self.finger_length:g}"
        if self.strip_length > self.length:
            yield f"strip_length must not exceed the length {self.length:g} m, got {self.strip_length:g}"
        beyond = sides and (sides[0] < low - 1e-9 or sides[-1] > high + 1e-9)
        if len(sides) % 2 or np.any(np.diff(sides) <= 0.0) or beyond:
            within = f"stay within the underside from {low:g} to {high:g} m, got {list(sides)}"
            yield f"finger_sides must be two values for each finger, rise from right to left and {within}"

    @classmethod
    def kinematics(cls) -> Self:
        """Return the rigid studies' shoe, with rear edge and fingers deduced from the F-paper's contacts."""
        return cls.ph4100c().with_(**ph4100c.FINGERED_UNDERSIDE)

    @classmethod
    def uneven(cls, unevenness: float = UNEVENNESS) -> Self:
        """Return the rigid studies' shoe with its underside `unevenness` (m) to the right of COM and load."""
        even = cls.kinematics()
        x, y = even.underside_center
        sides = tuple(side - unevenness for side in even.finger_sides)
        return even.with_(underside_center=(x, y - unevenness), finger_sides=sides)

    @classmethod
    def from_mesh(
        cls, mesh: "str | Path | fem.Mesh", density: float = STEEL_DENSITY, load_surface: str = "whole top"
    ) -> Self:
        """Return the shoe of a mesh: mass, inertia, underside and load point; density in kg/m3.

        The mesh, in shoe axes and m, is coarse, study or fine, a path, or a mesh. It needs the surfaces
        "underside" and `load_surface`, see `FlexibleShoes`. Raises `FileNotFoundError` for a missing mesh and
        `MeshError` for an incomplete one. Raises `ValueError` if it is larger than any shoe, lacks a surface,
        or its origin is not its COM.
        """
        # a slow import that a case without a mesh does not need
        from meshes import STEEL, checks, mesh_named, undersides, with_load_surfaces

        name = str(mesh) if isinstance(mesh, str | Path) else ""
        if isinstance(mesh, str | Path):
            shoe_mesh = mesh_named(name)
        else:
            shoe_mesh = with_load_surfaces(mesh)
            checks.check_whole(shoe_mesh)
        checks.check_extent(shoe_mesh, name)
        checks.check_surfaces(shoe_mesh, load_surface, name)
        body = fem.ElasticBody(shoe_mesh, replace(STEEL, density=density))
        off = body.center_of_mass
        if np.abs(off).max() > ORIGIN_TOLERANCE:
            com = f"its COM is at {off.round(4).tolist()} m"
            raise ValueError(
                f"{checks.the_mesh(name)} must have its origin at its COM within {ORIGIN_TOLERANCE} m, {com}"
            )
        low, high, level, share, strip_length = undersides.ground_outline(shoe_mesh)
        weights = body.surface_weights(load_surface)
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia.tolist()
        return cls(
            mass=body.mass,
            inertia=(xx, yy, zz, yz, xz, xy),
            com_height=-level,
            length=high[0] - low[0],
            width=high[1] - low[1],
            underside_center=tuple((0.5 * (low + high)).tolist()),
            ground_share=share,
            strip_length=strip_length,
            load_point=tuple((weights @ shoe_mesh.nodes / weights.sum()).tolist()),
            rails=_rails_of(shoe_mesh),
        )

    def of_mass(self, mass: float) -> Self:
        """Return a shoe of the same shape with another mass (kg), and its inertia in proportion."""
        ratio = mass / self.mass
        return self.with_(mass=mass, inertia=tuple(ratio * value for value in self.inertia))

    @property
    def roller_path(self) -> Rails:
        """Rails that wheels roll on; raises `ValueError` for a shoe without rails."""
        if self.rails is None:
            raise ValueError("shoe.rails must be given: wheels roll on them")
        return self.rails

    @property
    def inertia_tensor(self) -> np.ndarray:
        """Inertia tensor about the COM, array (3, 3), kg m2."""
        return base.inertia_tensor(self.inertia)

    @property
    def fingers(self) -> np.ndarray:
        """Right and left side of every finger: array (fingers, 2), m, y in the shoe's frame."""
        return np.array(self.finger_sides, dtype=float).reshape(-1, 2)

    @property
    def ground_area(self) -> float:
        """Area of the underside that bears on the ground, m2."""
        return self.length * self.width * self.ground_share

    @property
    def ground_breadth(self) -> float:
        """Least side of the bearing area or of one of its strips, m; sinkage depends on it."""
        return min(self.strip_length or self.length, self.width)

    @property
    def footprint(self) -> np.ndarray:
        """Underside in the shoe's frame: least and greatest x, least and greatest y, z; m."""
        cx, cy = self.underside_center
        x, y = 0.5 * self.length, 0.5 * self.width
        return np.array([cx - x, cx + x, cy - y, cy + y, -self.com_height])


def _rails_of(mesh: "fem.Mesh") -> Rails | None:
    """Return the rails of a mesh: the two of its roller path, else the two highest areas of its top, or None.

    Raises `ValueError` if the mesh has a roller path that is not two rails.
    """
    from meshes import rails

    try:
        return Rails(**rails.rail_outline(mesh)._asdict())
    except ValueError:
        if "roller path" in mesh.surfaces:
            raise
        return None


class Track(base.PH4100C, values=ph4100c.TRACK):
    """Open chain of equal shoes, linked by pins along y; shoe 1 is the rearmost, the last the front.

    Every link is one hinge without redundant equations: a spherical joint at one pin and an axis kept
    parallel at the other. Ideal pins, those of the papers, have no friction.
    """

    shoe_count: int = quantity("1", "number of shoes on all tracks", (2, 200), ge=2, le=MOST_SHOES)
    first_com: base.Two = quantity("m", "x and y of the COM of shoe 1 at t = 0")
    pitch: Length = quantity("m", "distance in x between the COMs of neighbouring shoes", (0.08, 2.0))
    pin_ahead: Length = quantity("m", "x of the front pins ahead of the COM", (0.02, 2.0))
    pin_height: float = quantity("m", "z of the pins above the COM", (-1.0, 1.0), ge=-100, le=100)
    spherical_y: Place = quantity("m", "global y of the spherical joints at t = 0")
    parallel_y: Place = quantity("m", "global y of the parallel joints at t = 0")
    pin: LinkPin = LinkPin()

    def _errors(self) -> Errors:
        if self.pin_ahead >= self.pitch:
            yield f"pin_ahead must be less than the pitch {self.pitch}, got {self.pin_ahead}"

    def check_shoe(self, shoe: int) -> None:
        """Raise `ValueError` for a number that no shoe has."""
        if shoe not in self.shoes:
            raise ValueError(f"shoe must be in 1..{self.shoe_count}, got {shoe}")

    @property
    def shoes(self) -> np.ndarray:
        """Shoe numbers 1..n, rear to front."""
        return np.arange(1, self.shoe_count + 1)

    @property
    def joints(self) -> np.ndarray:
        """Link numbers 1..n-1; link i connects shoes i and i+1."""
        return np.arange(1, self.shoe_count)

    def com_positions(self, com_height: float) -> np.ndarray:
        """Return the COMs at t = 0 with the undersides at z = 0: array (shoes, 3), m, global."""
        along = self.first_com[0] + self.pitch * np.arange(self.shoe_count)
        return np.column_stack(np.broadcast_arrays(along, self.first_com[1], com_height))

    @property
    def front_pin(self) -> np.ndarray:
        """Spherical joint at the front of a shoe, in its frame: array (3,), m."""
        return np.array([self.pin_ahead, self.spherical_y - self.first_com[1], self.pin_height])

    @property
    def rear_pin(self) -> np.ndarray:
        """Spherical joint at the rear of a shoe, in its frame: array (3,), m."""
        return self.front_pin - np.array([self.pitch, 0.0, 0.0])

    @property
    def joint_centers(self) -> dict[str, np.ndarray]:
        """Joint centres of a shoe in its frame, m: "front right", "front left", "rear right", "rear left"."""
        across = np.array([0.0, self.parallel_y - self.spherical_y, 0.0])
        return {
            f"{end} {side}": pin + number * across
            for end, pin in (("front", self.front_pin), ("rear", self.rear_pin))
            for number, side in enumerate(SIDES)
        }


PAPER_DAMPING = drive.StepProfile(times=ph4100c.DAMPING_FREQUENCIES, values=ph4100c.DAMPING_RATIOS)
"""Modal damping ratio over frequency of the S-paper: 0.005 up to 1000 Hz, a STEP to 1 at 10 kHz."""
ADAMS_DAMPING = drive.StepProfile(times=(99.0, 101.0, 990.0, 1010.0), values=(0.01, 0.1, 0.1, 1.0))
"""Default damping of ADAMS: 1 % below 100 Hz, 10 % up to 1000 Hz, critical above; jumps are 2 % wide here."""

PinCoupling = Literal["rigid", "averaging", "contact"]
"""Ways in which a pin holds its bore: rigid (RBE2), averaging (RBE3), or averaging with a pin that presses on
one side in the stress."""
COUPLING: PinCoupling = "averaging"
"""Coupling of runs, check cases and shoes of CAD files: an averaging one does not stiffen the bore.

With a rigid one the stress at a lug's root is a fifth lower.
"""
CONSTRAINT_MODES = 24  # six for each of the four joint centres
RIGID_MODES = 6


def mesh_beside(name: str, info: ValidationInfo) -> str:
    """Return the name of a mesh, or its absolute path if the case file that is read names a file.

    Raises `ValueError` if there is no such mesh.
    """
    if info.context is None or name in SHOE_SIZES:
        return name
    # Path.is_file raises for some texts
    if not os.path.isfile(info.context / name):
        raise ValueError(f"the mesh must be one of {', '.join(SHOE_SIZES)} or a file, got {name!r}")
    return str((info.context / name).resolve())


class FlexibleShoes(Parameters):
    """Which shoes are flexible, and the finite-element model that all of them share."""

    shoes: parameters.Rising[int] = option("numbers of the flexible shoes", min_length=1)
    mesh: Annotated[str, AfterValidator(mesh_beside)] = option(
        "mesh: coarse, study or fine, or the path of a file with the same surfaces"
    )
    pins: PinCoupling = option("coupling of pins and bores", COUPLING)
    youngs_modulus: float = quantity("Pa", "Young's modulus E", (5e10, 5e11), ge=1.0, le=1e15)
    poissons_ratio: float = quantity("1", "Poisson's ratio nu", (0.0, 0.45), gt=-1, lt=0.5)
    density: float = quantity("kg/m3", "density of the material", (1000.0, 2e4), ge=1e-3, le=1e6)
    fixed_modes: int = quantity(
        "1", "number of fixed-interface modes in the integrated basis", ge=0, le=10_000
    )
    recovered_modes: int = quantity(
        "1", "number of fixed-interface modes in the basis for stress recovery", ge=0, le=10_000
    )
    load_surface: str = option(
        "surface that bears the machine load: whole top, plateau (no wings), rails, or one of the mesh",
        "whole top",
    )
    com_node: base.Three = quantity(
        "m", "point in the shoe's frame; a drive may move the nearest mesh node", default=(0.0, 0.0, 0.0)
    )
    load_mode: bool = option("static response to the machine load as a mode of both bases", False)
    static_fields: bool = option(
        "static response to all loads in the stress; only the inertia of further modes is neglected",
        True,
    )
    highest_frequency: float | None = quantity(
        "Hz",
        "highest frequency of the integrated modes; none: no limit",
        (50.0, 1e6),
        gt=0,
        le=1e12,
        default=None,
    )
    modes: parameters.Rising[int] | None = option(
        "numbers (from 1) of the integrated modes; none: all", None, min_length=1
    )
    damping: drive.StepProfile = quantity(
        "1", "modal damping ratio over frequency; `times` are frequencies in Hz", (0.0, 2.0)
    )

    def _errors(self) -> Errors:
        if min(self.damping.values) < 0.0:
            yield f"damping ratios must not be negative, got {fields.shown(self.damping.values)}"
        if min(self.damping.times) < 0.0:
            yield f"damping frequencies must not be negative, got {fields.shown(self.damping.times)} Hz"
        if self.pins == "contact" and not self.static_fields:
            yield 'pins = "contact" needs static_fields = true: no mode has the pressures of a pin'
        most = self.recovered_modes
        if self.fixed_modes > most:
            yield f"fixed_modes must not exceed recovered_modes = {most}, got {self.fixed_modes}"
        if self.modes is None:
            return
        if self.highest_frequency is not None:
            yield "modes and highest_frequency must not be given together"
        if self.modes[0] < 1 or self.modes[-1] > self.mode_count:
            yield f"modes must be in 1..{self.mode_count}, got {fields.shown(self.modes)}"

    @property
    def mode_count(self) -> int:
        """Number of integrated modes: 24 constraint modes and fixed-interface modes, less 6 rigid ones."""
        return CONSTRAINT_MODES - RIGID_MODES + self.fixed_modes + int(self.load_mode)

    @classmethod
    def ph4100c(cls, mesh: str = "study") -> Self:
        """Return the middle and front shoes of the S-paper: steel, with the paper's modal damping."""
        return cls(**ph4100c.FLEXIBLE_SHOES, mesh=mesh, damping=PAPER_DAMPING)
