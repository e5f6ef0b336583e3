"""Meshes of a datasheet's shoes: a fitted ready shoe, and the values of a named mesh."""

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import fem
from exudyn_crawler.case.parameters.track import COUPLING, FlexibleShoes, Shoe
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet, DatasheetError, Kind, ShoeKind
from meshes.geometry import JOINT_CENTERS

if TYPE_CHECKING:
    from meshes import fitted

READY: dict[Kind, ShoeKind] = {
    "excavator": "triple grouser",
    "drill": "triple grouser",
    "dozer": "single grouser",
    "loader": "double grouser",
    "shovel": "mining",
    "crane": "plain",
    "paver": "plain",
    "vehicle": "plain",
}
"""Ready shoes of machines whose datasheet names none."""
SAME_PITCH = 1e-3  # tolerance, m, since a flexible shoe's pins have to fit its bores
SAME_WIDTH = 0.01  # tolerance, fraction of the width


class MeshShoe(NamedTuple):
    """Shoe of a mesh and positions of its pins, m, in the shoe's axes."""

    shoe: Shoe
    pitch: float
    pin_ahead: float
    pin_height: float
    joint_y: tuple[float, float]  # y of the right and of the left joint
    grouser: float  # depth below the underside
    is_covered: bool  # true if the underside has no gap in its rectangle
    surface: str  # surface that bears a load from above

    @property
    def depth(self) -> float:
        """Depth of the underside below the pins, m."""
        return float(self.pin_height + self.shoe.com_height)


@lru_cache(maxsize=8)
def shoe_of_mesh(name: str) -> MeshShoe:
    """Return the shoe of a mesh by its name or path; a `DatasheetError` says what the mesh lacks."""
    # a case without a mesh need not wait for finite elements
    from meshes import STEEL, mesh_named
    from meshes.undersides import pin_place

    try:
        mesh = mesh_named(name)
        surface = "whole top" if "whole top" in mesh.surfaces else "underside"
        shoe = Shoe.from_mesh(mesh, STEEL.density, surface)
        places = {joint: _bore(mesh, joint) for joint in JOINT_CENTERS}
    except (OSError, KeyError, ValueError) as error:
        raise DatasheetError(f"shoe_mesh {name}: {error}") from error
    front, rear = (pin_place(mesh, end) for end in ("front", "rear"))
    if abs(front[2] - rear[2]) > SAME_PITCH:
        raise DatasheetError(
            f"shoe_mesh {name} must have front and rear pins at one height, the front pins are "
            f"{1e3 * (front[2] - rear[2]):+.3g} mm higher"
        )
    return MeshShoe(
        shoe,
        float(front[0] - rear[0]),
        float(front[0]),
        float(0.5 * (front[2] + rear[2])),
        (_joint(places, "right"), _joint(places, "left")),
        float(-shoe.com_height - mesh.nodes[:, 2].min()),
        _is_covered(mesh),
        surface,
    )


def _bore(mesh: fem.Mesh, joint: str) -> np.ndarray:
    """Return the least and greatest x, y, z of a bore: array (2, 3), m."""
    nodes = mesh.nodes[mesh.nodes_of(f"bore {joint}")]
    return np.stack((nodes.min(axis=0), nodes.max(axis=0)))


def _joint(places: dict[str, np.ndarray], side: str) -> float:
    """Return y of a joint: the middle of the overlap, or of the gap, of both ends' bores, m."""
    low, high = np.stack([places[f"{end} {side}"][:, 1] for end in ("front", "rear")], axis=1)
    return float(0.5 * (low.max() + high.min()))


def _is_covered(mesh: fem.Mesh) -> bool:
    """Return True if the underside has no gap in its rectangle."""
    under = mesh.nodes[mesh.nodes_of("underside"), :2]
    try:
        fem.FlatRectangle(mesh, "underside", under.min(axis=0), under.max(axis=0))
    except ValueError:
        return False
    return True


def sheet_of_mesh(sheet: Datasheet) -> Datasheet:
    """Return a datasheet with pitch and grousers of its shoe mesh; raise `DatasheetError` if they differ."""
    if sheet.shoe_mesh is None:
        return sheet
    of_mesh = shoe_of_mesh(sheet.shoe_mesh)
    if of_mesh.shoe.rails is None:
        raise DatasheetError(
            f"shoe_mesh {sheet.shoe_mesh} must have two level rails for the rollers, "
            "in its surface 'roller path'"
        )
    if sheet.pitch is not None and abs(sheet.pitch - of_mesh.pitch) > SAME_PITCH:
        raise DatasheetError(
            f"pitch is {1e3 * sheet.pitch:.5g} mm, the bores of shoe_mesh {sheet.shoe_mesh} are "
            f"{1e3 * of_mesh.pitch:.5g} mm apart: one of them belongs to another machine"
        )
    if abs(of_mesh.shoe.width / sheet.shoe_width - 1.0) > SAME_WIDTH:
        raise DatasheetError(
            f"shoe_width is {1e3 * sheet.shoe_width:.4g} mm, shoe_mesh {sheet.shoe_mesh} is "
            f"{1e3 * of_mesh.shoe.width:.4g} mm wide: one of them belongs to another shoe"
        )
    return sheet.with_(pitch=of_mesh.pitch, grouser_height=of_mesh.grouser)


def flexible_of(sheet: Datasheet, shoe: int) -> FlexibleShoes:
    """Return the flexible shoes of a datasheet's machine: only shoe number `shoe` if the file names none."""
    if sheet.shoe_mesh is None:
        raise DatasheetError(
            "flexible shoes need shoe_mesh in the datasheet: exudyn-crawler shoe MACHINE.toml writes one"
        )
    from meshes import STEEL

    of_mesh = shoe_of_mesh(sheet.shoe_mesh)
    return FlexibleShoes.ph4100c(sheet.shoe_mesh).with_(
        shoes=(shoe,),
        pins=COUPLING,
        density=STEEL.density,
        static_fields=of_mesh.is_covered,
        load_surface=of_mesh.surface,
    )


def ready_kind(sheet: Datasheet) -> ShoeKind:
    """Return the kind of ready shoe that fits a datasheet's machine."""
    return sheet.shoe_kind or READY[sheet.kind]


def fitted_shoe(sheet: Datasheet, shoe: Shoe, chain: Chain, fineness: str) -> "fitted.FittedShoe":
    """Return a ready shoe with pitch, width and weight of a datasheet's `shoe` and `chain`.

    Raise `DatasheetError` in the datasheet's terms if no such shoe exists, `ModuleNotFoundError` if netgen is
    missing.
    """
    from meshes import fitted

    rails = shoe.roller_path
    kind = ready_kind(sheet)
    size = fitted.ShoeSize(
        pitch=chain.pitch,
        width=shoe.width,
        mass=shoe.mass,
        pin_height=chain.depth,
        rail_height=rails.height + shoe.com_height - chain.grouser,
        rail_center=rails.left,
        rail_width=rails.width,
        grouser_height=chain.grouser,
    )
    try:
        return fitted.fit_shoe(kind, size, fineness)
    except fitted.ThicknessError as error:
        raise DatasheetError(
            f"a {kind} shoe of {1e3 * chain.pitch:.4g} mm pitch and {1e3 * shoe.width:.4g} mm width cannot "
            f"weigh {shoe.mass:.4g} kg: {error}; another shoe_kind or shoe_weight, or a mesh of its own"
        ) from error
    except ValueError as error:
        raise DatasheetError(f"no {kind} shoe follows from this datasheet: {error}") from error
