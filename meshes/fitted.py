"""Ready shoes fitted to a pitch, a width and a mass: shoes of links with grousers, and the mining shoe.

The plate thickness sets the mass; all other dimensions scale with pitch and width.
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
"""Range of a mining shoe's thicknesses of bottom plate and top flange, fraction of the papers' (assumed)."""
NARROWEST = 2.1
"""Least width with room for the lugs at the papers' pitch, m; narrower shoes are compressed along y."""
WITHIN = 1e-3  # tolerance of the solid's mass, fraction of the target mass
TRIES = 4


class ShoeSize(NamedTuple):
    """Target dimensions of a shoe: lengths in m, heights above the plate's underside, mass in kg."""

    pitch: float
    width: float
    mass: float
    pin_height: float
    rail_height: float
    rail_center: float
    rail_width: float
    grouser_height: float


class FittedShoe(NamedTuple):
    """Mesh of a shoe in its own axes, m, and the thickness of its plate, m."""

    mesh: Mesh
    plate_thickness: float


class ThicknessError(ValueError):
    """Error for a mass that no plausible plate gives.

    Attributes
    ----------
    thickness : float
        Needed thickness, m.
    thicknesses, masses : tuple of two floats
        Values of the thinnest and the thickest plate, m and kg.
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
    """Mesh a ready shoe of a kind with the target pitch, width and mass.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    size : ShoeSize
        Target dimensions. The mining shoe has its own heights and rails, which scale with pitch and width.
    fineness : str
        "coarse", "study" or "fine".
    density : float
        Density of the steel, kg/m3.

    Raises
    ------
    ModuleNotFoundError
        If netgen is not installed.
    ThicknessError
        If no plausible plate gives the mass.
    ValueError
        If kind or fineness is unknown, or the dimensions allow no such shoe.
    """
    if kind not in KINDS:
        raise ValueError(f"kind must be one of {', '.join(KINDS)}, got {kind!r}")
    if fineness not in build_shoe.SIZES:
        raise ValueError(f"size must be one of {', '.join(build_shoe.SIZES)}, got {fineness!r}")
    occ = build_shoe.netgen_kernel()
    return (_mining if kind == "mining" else _links)(occ, kind, size, fineness, density)


def _links(occ: Any, kind: Kind, size: ShoeSize, fineness: str, density: float) -> FittedShoe:
    """Fit a shoe of links."""
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
    """Fit the papers' shoe to pitch, width and mass; thicknesses of plate and flange scale together.

    A narrow shoe is compressed along y, so that its bores stay round.
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
    """Return a mesh stretched along its axes, with its origin at the COM in x and z.

    The y coordinate keeps its zero at the middle of the track, which the COM of a shoe may miss.
    """
    nodes = mesh.nodes * stretch
    x, _, z = centroid(nodes, mesh.elements)
    return Mesh(nodes - (x, 0.0, z), mesh.elements, mesh.surfaces)


def _fitting(
    mass_of: Callable[[float], float], bounds: tuple[float, float], mass: float, unit: float
) -> float:
    """Return the size that gives a mass which grows almost linearly with it; `unit` converts to m."""
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
    # a notch that begins at some thickness makes the mass jump: no plate gives the masses between
    return min(tried, key=lambda thickness: abs(tried[thickness] - mass))
