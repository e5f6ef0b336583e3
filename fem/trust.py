"""How far to trust a stress: what the mesh leaves open of it, and one plain verdict a peak.

The mesh's part is estimated after O. C. Zienkiewicz and J. Z. Zhu, A simple error estimator and adaptive
procedure for practical engineering analysis, Int. J. Numer. Meth. Engng. 24 (1987) 337-357: the stress
averaged at the nodes is better than the elements' own, so that the difference of both over the elements about
a node, against the stress there, tells how far the elements are from resolving it.
"""

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from fem.elasticity import Material
from fem.mesh import Floats, Mesh
from fem.recovery import DEVIATOR
from fem.stress import element_stress

SAFETY = 1.5
"""Error of the nodal stress over the relative difference about it, at a bore whose solution is known."""
MESH_LIMIT = 0.2
"""Error of the mesh over the stress beyond which refinement comes before any use. At a shoe's fillets it lies
between a mesh whose peaks are a tenth low at most and one where they are a third low (`docs/fem.md`)."""
JUMP_LIMIT = 0.5
"""Disagreement of neighbouring elements over the stress beyond which the mesh makes the peak."""
GRADES = (5, 10, 15, 20, 25, 30, 40, 50)
"""Per cent to which a stress may be called good."""
IN_SPIDER = "in spider"
"""Flag of a node that a rigid spider holds."""


def mesh_error(mesh: Mesh, material: Material, displacement: Floats) -> Floats:
    """Estimate by how much von Mises stress at the nodes is off because of the mesh.

    Parameters
    ----------
    mesh : Mesh
    material : Material
    displacement : array (n, 3)
        In m.

    Returns
    -------
    array (n,)
        In Pa: `SAFETY` times the nodal von Mises stress times ``sqrt(e / (e + s))``, with the mean squares
        over the elements of the node, e of averaged stress less the elements' own and s of the latter, taken
        as linear in an element.
    """
    own = element_stress(mesh, material, displacement) @ DEVIATOR.T
    flat, n = mesh.elements.ravel(), len(mesh.nodes)
    count = np.bincount(flat, minlength=n)
    sums = [np.bincount(flat, own[..., k].ravel(), n) for k in range(len(DEVIATOR))]
    averaged = np.stack(sums, axis=1) / count[:, None]
    at_corners = averaged[mesh.elements[:, :4]]
    a, b, c, d = np.moveaxis(mesh.nodes[mesh.elements[:, :4]], 1, 0)
    volume = np.einsum("ei,ei->e", np.cross(b - a, c - a), d - a) / 6.0
    squares = []
    for field in (at_corners - own[:, :4], own[:, :4]):
        of_element = volume * ((field**2).sum(axis=(1, 2)) + (field.sum(axis=1) ** 2).sum(axis=1))
        squares.append(np.bincount(flat, np.repeat(of_element, mesh.elements.shape[1]), n))
    off, whole = squares[0], squares[0] + squares[1]
    part = np.sqrt(np.divide(off, whole, out=np.zeros(n), where=whole > 0.0))
    return np.asarray(SAFETY * part * np.linalg.norm(averaged, axis=1))


def judged(
    table: pd.DataFrame,
    truncation: float | None = None,
    spread: ArrayLike = 0.0,
    choice: ArrayLike = 0.0,
) -> pd.DataFrame:
    """Add one plain verdict to each peak of a table of hot spots.

    All that is known to be open of a stress is added up.

    Parameters
    ----------
    table : pandas.DataFrame
        Of `hot_spots`.
    truncation : float, optional
        In Pa, by which modes that were left out may change a stress; not known if left out, which the verdict
        then says.
    spread : array (rows,) or float
        In Pa, between runs whose starts differ by rounding.
    choice : array (rows,) or float
        In Pa, between laws of contact that could stand for the same ground.

    Returns
    -------
    pandas.DataFrame
        The table with a column verdict: "inside a spider: do not use"; "mesh-limited: refine here", where
        the mesh leaves more than `MESH_LIMIT` open or elements disagree by more than `JUMP_LIMIT`; "good to
        10 %" and the like; or "open by more than 50 %".

    Raises
    ------
    ValueError
        If one of the errors is negative or not finite.
    """
    given = {"truncation": 0.0 if truncation is None else truncation, "spread": spread, "choice": choice}
    size = table["value"].abs().to_numpy()
    total = table["error"].to_numpy().copy()
    for name, error in given.items():
        values = np.broadcast_to(np.asarray(error, dtype=float), size.shape)
        if not (np.isfinite(values) & (values >= 0.0)).all():
            raise ValueError(f"{name} must be finite and not negative, got {error}")
        total += values
    size = np.maximum(size, np.finfo(float).tiny)
    by_mesh = (table["error"] > MESH_LIMIT * size) | (table["jump"] > JUMP_LIMIT * size)
    uncounted = " but for truncation" if truncation is None else ""
    verdicts = []
    for flag, limited, part in zip(table["flag"], by_mesh, 100.0 * total / size, strict=True):
        if flag == IN_SPIDER:
            verdicts.append("inside a spider: do not use")
        elif limited:
            verdicts.append("mesh-limited: refine here")
        else:
            grade = next((grade for grade in GRADES if part <= grade), None)
            good = f"open by more than {GRADES[-1]} %" if grade is None else f"good to {grade} %"
            verdicts.append(good + uncounted)
    return table.assign(verdict=verdicts)
