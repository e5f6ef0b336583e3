"""Ready shoes fitted to a pitch, a width and a mass: shoes of links with grousers, and the mining shoe.

The thickness of the plate makes the mass; all other dimensions go with pitch and width.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal, NamedTuple, get_args

from fem.body.mesh import Mesh
from meshes import build_shoe
from meshes.geometry import PITCH, ShoeDimensions
from meshes.grouser import REFERENCE, THICKNESSES, GrouserShoe, build_grouser_solid, mesh_grouser_shoe
from meshes.recognition.elements import centroid
from meshes.shoe import STEEL
from meshes.solid import build_solid

Kind = Literal["single grouser", "double grouser", "triple grouser", "plain", "mining"]
KINDS: tuple[Kind, ...] = get_args(Kind)
GROUSERS: dict[Kind, int] = {"plain": 0, "single grouser": 1, "double grouser": 2, "triple grouser": 3}
STOUTNESS = 0.5, 2.2
"""Of the papers' thicknesses of bottom plate and top flange: those that a mining shoe may have, chosen."""
NARROWEST = 2.1
"""m, width at the papers' pitch on which lugs still stand; narrower shoes are pressed together along y."""
WITHIN = 1e-3  # of the mass: between the solid and what is asked for
TRIES = 4


class ShoeSize(NamedTuple):
    """Dimensions that a shoe is to have: lengths in m, heights above the plate's underside, mass in kg."""

    pitch: float
    width: float
    mass: float
    pin_height: float
    rail_height: float
    rail_center: float
    rail_width: float
    grouser_height: float


class FittedShoe(NamedTuple):
    """Mesh of a shoe in its own axes, in m, and the thickness of its plate."""

    mesh: Mesh
    plate_thickness: float


class ThicknessError(ValueError):
    """No plausible plate makes the mass.

    Attributes
    ----------
    thickness : float
        That it would take, m.
    thicknesses, masses : tuple of two floats
        Of the thinnest and the thickest plate, m and kg.
    """

    def __init__(
        self, thickness: float, thicknesses: tuple[float, float], masses: tuple[float, float]
    ) -> None:
        super().__init__(
            f"a plate of {1e3 * thicknesses[0]:.3g} to {1e3 * thicknesses[1]:.3g} mm makes a shoe of "
            f"{masses[0]:.4g} to {masses[1]:.4g} kg; it would have to be {1e3 * thickness:.3g} mm thick"
        )
        self.thickness = thickness
        self.thicknesses = thicknesses
        self.masses = masses


def fit_shoe(
    kind: Kind, size: ShoeSize, fineness: str = "coarse", density: float = STEEL.density
) -> FittedShoe:
    """Mesh a ready shoe of a kind whose pitch, width and mass are those asked for.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    size : ShoeSize
        The mining shoe has its own heights and rails, which go with pitch and width.
    fineness : str
        "coarse", "study" or "fine".
    density : float
        kg/m3.

    Raises
    ------
    ModuleNotFoundError
        If netgen is not there.
    ThicknessError
        If no plausible plate makes the mass.
    ValueError
        If there is no such kind or fineness, or the dimensions leave no such shoe.
    """
    if kind not in KINDS:
        raise ValueError(f"kind must be one of {', '.join(KINDS)}, got {kind!r}")
    if fineness not in build_shoe.SIZES:
        raise ValueError(f"size must be one of {', '.join(build_shoe.SIZES)}, got {fineness!r}")
    occ = build_shoe.netgen_kernel()
    return (_mining if kind == "mining" else _links)(occ, kind, size, fineness, density)


def _links(occ: Any, kind: Kind, size: ShoeSize, fineness: str, density: float) -> FittedShoe:
    """Shoe of links."""
    pitch = size.pitch
    scale = pitch / REFERENCE
    shoe = GrouserShoe(
        width=size.width / pitch,
        grousers=GROUSERS[kind] if size.grouser_height > 0.0 else 0,
        grouser_height=size.grouser_height / pitch,
        plate_thickness=THICKNESSES[0],
        pin_height=size.pin_height / pitch,
        rail_height=size.rail_height / pitch,
        rail_center=size.rail_center / pitch,
        rail_width=size.rail_width / pitch,
    )

    def mass_of(thickness: float) -> float:
        solid = build_grouser_solid(occ, replace(shoe, plate_thickness=thickness))
        return float(solid.mass) * density * scale**3

    thickness = _fitting(mass_of, THICKNESSES, size.mass, pitch)
    mesh = mesh_grouser_shoe(replace(shoe, plate_thickness=thickness), build_shoe.SIZES[fineness])
    return FittedShoe(_about_com(mesh, (scale, scale, scale)), pitch * thickness)


def _mining(occ: Any, kind: Kind, size: ShoeSize, fineness: str, density: float) -> FittedShoe:
    """The papers' shoe by the pitch, of another width; thicknesses of plate and flange in proportion.

    A narrow one is pressed together along y, so that its bores stay round.
    """
    scale = size.pitch / PITCH
    papers = ShoeDimensions()
    width = max(size.width / scale, NARROWEST)
    beside = size.width / width

    def of(stoutness: float) -> ShoeDimensions:
        return replace(
            papers,
            width=width,
            plate_thickness=stoutness * papers.plate_thickness,
            top_thickness=stoutness * papers.top_thickness,
        )

    def mass_of(stoutness: float) -> float:
        return float(build_solid(occ, of(stoutness)).mass) * density * scale**2 * beside

    unit = scale * papers.plate_thickness
    stoutness = _fitting(mass_of, STOUTNESS, size.mass, unit)
    mesh = build_shoe.mesh_shoe(of(stoutness), fineness)
    return FittedShoe(_about_com(mesh, (scale, beside, scale)), unit * stoutness)


def _about_com(mesh: Mesh, stretch: tuple[float, float, float]) -> Mesh:
    """Mesh stretched along its axes, with its origin at its COM along x and z.

    y stays: there the middle of the track is zero, of which a shoe that is not quite even has its COM beside.
    """
    nodes = mesh.nodes * stretch
    x, _, z = centroid(nodes, mesh.elements)
    return Mesh(nodes - (x, 0.0, z), mesh.elements, mesh.surfaces)


def _fitting(
    mass_of: Callable[[float], float], bounds: tuple[float, float], mass: float, unit: float
) -> float:
    """Size with which a solid has a mass, which grows about evenly with it; `unit` makes m of it."""
    low, high = bounds
    masses = mass_of(low), mass_of(high)
    slope = (masses[1] - masses[0]) / (high - low)
    size = low + (mass - masses[0]) / slope
    if not masses[0] <= mass <= masses[1]:
        raise ThicknessError(unit * size, (unit * low, unit * high), masses)
    tried = {low: masses[0], high: masses[1]}
    for _ in range(TRIES):
        tried[size] = mass_of(size)
        off = tried[size] - mass
        if abs(off) < WITHIN * mass:
            break
        size = min(max(size - off / slope, low), high)
    # a notch that begins at some thickness leaves masses that no plate makes
    return min(tried, key=lambda thickness: abs(tried[thickness] - mass))
