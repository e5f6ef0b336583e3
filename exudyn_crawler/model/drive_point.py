"""The point of the front shoe that the drive moves, as a function of the shoe's coordinates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.rotations import rotation_matrices
from fem import Mesh, ReducedBody


@dataclass(frozen=True)
class DrivePoint:
    """Point of a shoe, with a body of m modes; none for a rigid shoe.

    Attributes
    ----------
    place : array (3,)
        Where it is in the undeformed shoe, m, the shoe's frame.
    rows : array (3, m)
        Its displacement by each mode; transposed, they turn a force on it into modal loads.
    """

    place: NDArray
    rows: NDArray

    def arm(self, angles: NDArray, modal: NDArray) -> NDArray:
        """From the frame's origin to the point, global: array (..., 3), m.

        Parameters
        ----------
        angles : array (..., 3)
            Successive rotations about x, y, z, rad.
        modal : array (..., m)
            Modal coordinates.
        """
        local = self.place + modal @ self.rows.T
        return np.einsum("...ij,...j->...i", rotation_matrices(angles), local)


def pulled_node(case: Case, mesh: Mesh) -> int | None:
    """Node of the flexible shoes' mesh that has all of the drive's force; None where none has."""
    flexible = case.flexible
    if flexible is None or case.track.shoe_count not in flexible.shoes or case.drive.point != "com node":
        return None
    return int(np.argmin(np.linalg.norm(mesh.nodes - np.array(flexible.com_node), axis=1)))


def drive_point(case: Case, reduced: ReducedBody | None) -> DrivePoint:
    """Point at which a case's drive moves its front shoe.

    Parameters
    ----------
    reduced : ReducedBody, optional
        Body and modes of the front shoe; None for a rigid one, whose COM is in place of a node.
    """
    at = case.drive.point
    front = [name for name in case.track.joint_centers if name.startswith("front")]
    if reduced is None:
        pins = np.mean([case.track.joint_centers[name] for name in front], axis=0)
        return DrivePoint(pins if at == "front pins" else np.zeros(3), np.zeros((3, 0)))
    node = pulled_node(case, reduced.mesh)
    if node is not None:
        return DrivePoint(reduced.nodes[node], reduced.modes[node])
    if at == "front pins":
        chosen = [k for k, interface in enumerate(reduced.interfaces) if interface.name in front]
        place = np.mean([reduced.interfaces[k].center for k in chosen], axis=0)
        return DrivePoint(place, reduced.pilots[chosen, :3].mean(axis=0))
    # the frame moves with the body as a whole: its modes are orthogonal to that
    return DrivePoint(np.zeros(3), np.zeros((3, len(reduced.frequencies))))
