"""Whether a mesh of a flexible shoe fits its track and its rigid neighbours."""

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Rails, Shoe, Track
from fem import Interface, Mesh
from meshes.checks import check_extent
from meshes.rails import rail_outline

PIN_TOLERANCE = 1e-3
"""m, between the axis of a bore and the pin."""
UNDERSIDE_TOLERANCE = 5e-3
"""m, between the mesh's underside and that of the rigid shoes, on which all shoes meet the ground."""


def pin_interfaces(mesh: Mesh, name: str, track: Track) -> list[Interface]:
    """Interfaces of a shoe at the joint centres of its track, each tied to its bore.

    Parameters
    ----------
    name : str
        Of the mesh, for what is refused.

    Raises
    ------
    ValueError
        If the mesh is in other units, or has no bore where a pin is.
    """
    check_extent(mesh, name)
    interfaces = []
    for joint, center in track.joint_centers.items():
        if f"bore {joint}" not in mesh.surfaces:
            raise ValueError(
                f"the mesh {name!r} must have the surface 'bore {joint}', it has {sorted(mesh.surfaces)}"
            )
        nodes = mesh.nodes_of(f"bore {joint}")
        bore = mesh.nodes[nodes]
        off = 0.5 * (bore.min(axis=0) + bore.max(axis=0)) - center
        # a bore is as long as its lug is wide, of which the joint centre need not be the middle
        if np.hypot(off[0], off[2]) > PIN_TOLERANCE or abs(off[1]) > 0.5 * np.ptp(bore[:, 1]):
            raise ValueError(
                f"the mesh {name!r} must meet the track's pins within {PIN_TOLERANCE} m: "
                f"its bore {joint!r} is off the pin by {off.round(4).tolist()} m"
            )
        interfaces.append(Interface(joint, center, nodes))
    return interfaces


def check_footprint(mesh: Mesh, name: str, shoe: Shoe) -> None:
    """Refuse a mesh whose underside is not that of the rigid shoes.

    Raises
    ------
    ValueError
        With both.
    """
    under = mesh.nodes[mesh.nodes_of("underside")]
    low, high = under.min(axis=0), under.max(axis=0)
    found = np.array([low[0], high[0], low[1], high[1], low[2]])
    if np.abs(found - shoe.footprint).max() > UNDERSIDE_TOLERANCE:
        raise ValueError(
            f"the mesh {name!r} must have the underside of the case's shoes within {UNDERSIDE_TOLERANCE} m, "
            f"{_rectangle(shoe.footprint)}; it has {_rectangle(found)}. "
            f"Shoe.from_mesh({name!r}) is a shoe as the mesh has it"
        )


def check_rails(mesh: Mesh, name: str, rails: Rails) -> None:
    """Refuse a mesh whose rails are not those of the rigid shoes.

    Raises
    ------
    ValueError
        With both, or with what the mesh lacks.
    """
    try:
        found = rail_outline(mesh)
    except ValueError as error:
        raise ValueError(f"flexible.mesh {name!r} does not go with an undercarriage: {error}") from error
    off = {key: value - getattr(rails, key) for key, value in found._asdict().items()}
    far = {key: round(value, 4) for key, value in off.items() if abs(value) > UNDERSIDE_TOLERANCE}
    if far:
        raise ValueError(
            f"the mesh {name!r} must have the rails of shoe.rails within {UNDERSIDE_TOLERANCE} m, "
            f"they are off by {far} m"
        )


def _rectangle(footprint: NDArray) -> str:
    """Footprint for reading."""
    x0, x1, y0, y1, z = footprint
    return f"x {x0:.4g}..{x1:.4g}, y {y0:.4g}..{y1:.4g}, z {z:.4g} m"
