"""How far to trust a stress: its uncertainty from the mesh, and one plain verdict per peak or node.

The mesh's part is estimated after O. C. Zienkiewicz and J. Z. Zhu, A simple error estimator and adaptive
procedure for practical engineering analysis, Int. J. Numer. Meth. Engng. 24 (1987) 337-357: the stress
averaged at the nodes is better than the elements' stress. The difference of both over the elements around a
node, relative to the stress there, shows how well the elements resolve it.
"""

import operator
from dataclasses import dataclass
from functools import reduce

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from fem.body.elasticity import Material
from fem.body.element_stress import element_deviator
from fem.body.mesh import Floats, Integers, Mesh
from fem.body.shapes import Columns, Shapes, combined, lengths
from fem.stress.low_rank import ModalHistory, segments

SAFETY = 1.5
"""Error of the nodal stress over the relative difference around it, at a bore of known solution."""
MESH_LIMIT = 0.2
"""Error of the mesh over the stress beyond which refinement comes before any use. At a shoe's fillets it lies
between a mesh whose peaks are a tenth low at most and one where they are a third low (`docs/fem.md`)."""
JUMP_LIMIT = 0.5
"""Disagreement of neighbouring elements over the stress beyond which the mesh makes the peak."""
GRADES = (5, 10, 15, 20, 25, 30, 40, 50)
"""Per cent of uncertainty up to which a stress counts as good."""
VERDICTS = (
    *(f"good to {grade} %" for grade in GRADES),
    f"uncertain by more than {GRADES[-1]} %",
    "mesh-limited: refine here",
    "beside a rigid pin coupling: do not use",
)
"""Verdicts by their numbers, from 0."""
OPEN, LIMITED, HELD = range(len(GRADES), len(GRADES) + 3)
"""Numbers of the verdicts that are not grades."""
IN_SPIDER = "in spider"
"""Flag of a node that a rigid spider holds."""
LEFT_OUT = 1e-2
"""Part of a history's stress, in the mean square, that the few fields of its estimate may leave out."""


@dataclass(frozen=True)
class Resolution:
    """How far a mesh resolves the stress at its n nodes, over one field of displacement or several.

    Sums of squares over the fields; those of further fields are added.

    Parameters
    ----------
    off, stress : array (n,)
        Integrals over the elements of a node: of averaged stress minus the elements' stress, and of the
        latter, both taken as linear in an element.
    jump, size : array (n,)
        In Pa2: of the greatest von Mises stress of the difference between an element's stress and the nodal
        one, which is zero where the elements agree, and of the nodal von Mises stress.
    """

    off: Floats
    stress: Floats
    jump: Floats
    size: Floats

    def __add__(self, other: "Resolution") -> "Resolution":
        """That of the fields of both."""
        return Resolution(
            self.off + other.off, self.stress + other.stress, self.jump + other.jump, self.size + other.size
        )

    @property
    def error(self) -> Floats:
        """Estimated error of the nodal von Mises stress over itself, (n,)."""
        return SAFETY * _root_ratio(self.off, self.off + self.stress)

    @property
    def relative_jump(self) -> Floats:
        """Disagreement of the elements over the nodal von Mises stress, (n,)."""
        return _root_ratio(self.jump, self.size)


def _root_ratio(part: Floats, whole: Floats) -> Floats:
    """Root of a part over the whole, zero where there is none."""
    return np.sqrt(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0))


def resolution(mesh: Mesh, material: Material, displacement: Floats) -> Resolution:
    """How far a mesh resolves the stress of a displacement (n, 3) in m."""
    return _resolution(mesh.nodes, mesh.elements, element_deviator(mesh, material, displacement))


def resolution_at(body: Shapes, q: Floats, nodes: Integers) -> Resolution:
    """How far a body's mesh resolves single stresses, each from the elements around its node alone.

    Parameters
    ----------
    body : Shapes
    q : array (k, m)
        Coordinates of the body's columns, of one field each.
    nodes : int array (k,)
        Number of the node of each.

    Returns
    -------
    Resolution
        Of k nodes: that of `resolution` to rounding.
    """
    places = [_resolution_at_node(body, row, node) for row, node in zip(q, nodes.tolist(), strict=True)]
    return Resolution(
        np.array([place.off for place in places]),
        np.array([place.stress for place in places]),
        np.array([place.jump for place in places]),
        np.array([place.size for place in places]),
    )


def _resolution_at_node(body: Shapes, q: Floats, node: int) -> Resolution:
    """How far a body's mesh resolves the stress of coordinates (m,) at a node; numbers in place of arrays."""
    mesh = body.mesh
    about = (mesh.elements == node).any(axis=1)
    reached = np.zeros(len(mesh.nodes), dtype=bool)
    reached[mesh.elements[about]] = True
    # the averages at the nodes of its elements take all elements that these nodes have
    elements = np.flatnonzero(reached[mesh.elements].any(axis=1))
    used, local = np.unique(mesh.elements[elements], return_inverse=True)
    displacement = np.zeros_like(mesh.nodes)
    displacement[used] = combined(body.modes, q, used)[0]
    stress = element_deviator(mesh, body.material, displacement, elements)
    near = _resolution(mesh.nodes[used], local.reshape(len(elements), -1), stress)
    place = int(np.searchsorted(used, node))
    return Resolution(near.off[place], near.stress[place], near.jump[place], near.size[place])


def _resolution(nodes: Floats, elements: Integers, stress: Floats) -> Resolution:
    """How far elements (e, a) between nodes (n, 3) resolve their stress (e, a, 5), see `element_deviator`."""
    flat = elements.ravel()
    n = len(nodes)
    count = np.bincount(flat, minlength=n)
    sums = [np.bincount(flat, stress[..., k].ravel(), n) for k in range(stress.shape[-1])]
    averaged = np.stack(sums, axis=1) / count[:, None]
    off = averaged[elements] - stress
    a, b, c, d = np.moveaxis(nodes[elements[:, :4]], 1, 0)
    volume = np.einsum("ei,ei->e", np.cross(b - a, c - a), d - a) / 6.0
    squares: list[Floats] = []
    for field in (off[:, :4], stress[:, :4]):
        total = field.sum(axis=1)
        of_element = volume * (np.einsum("ack,ack->a", field, field) + np.einsum("ak,ak->a", total, total))
        squares.append(np.asarray(np.bincount(flat, np.repeat(of_element, elements.shape[1]), n)))
    jump = np.zeros(n)
    np.maximum.at(jump, flat, np.einsum("ack,ack->ac", off, off).ravel())
    return Resolution(squares[0], squares[1], jump, np.einsum("nk,nk->n", averaged, averaged))


def resolution_over(body: Shapes, q: ModalHistory) -> Resolution:
    """How far a body's mesh resolves the stress of a history (t, m), in the mean square over its times.

    The squares are those of the few fields that make nearly all of the history's stress.
    """
    squares = np.zeros(2 * body.stress_modes.shape[2:])
    times = 0
    for rows in segments(q):
        squares = squares + rows.T @ rows
        times = times + len(rows)
    fields = _main_directions(body.stress_modes, squares / times)
    return reduce(
        operator.add,
        (resolution(body.mesh, body.material, displacement) for displacement in body.displacement(fields)),
    )


def _main_directions(stress_modes: Columns, squares: Floats) -> Floats:
    """Coordinates (r, m) of few fields with the mean squares of a history, whose products are (m, m)."""
    weights = lengths(stress_modes)
    weights[weights == 0.0] = 1.0  # modes without stress
    values, directions = np.linalg.eigh(squares * np.outer(weights, weights))
    sizes = np.sqrt(np.maximum(values[::-1], 0.0))
    beyond = np.append(np.cumsum(sizes[::-1] ** 2)[::-1], 0.0)
    rank = max(1, int(np.flatnonzero(beyond <= LEFT_OUT**2 * beyond[0])[0]))
    return sizes[:rank, None] * directions[:, ::-1][:, :rank].T / weights


def mesh_error(mesh: Mesh, material: Material, displacement: Floats) -> Floats:
    """Estimate the error of the von Mises stress at the nodes from the mesh.

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
        over the elements of the node, e of averaged stress minus the elements' stress and s of the latter,
        taken as linear in an element.
    """
    resolved = resolution(mesh, material, displacement)
    return resolved.error * np.sqrt(resolved.size)


def verdict_numbers(part: ArrayLike, error: ArrayLike, jump: ArrayLike, held: ArrayLike) -> NDArray[np.int8]:
    """Numbers of the verdicts of stresses, array (n,); -1 if the uncertainty is not a number.

    Parameters
    ----------
    part : array (n,)
        Whole uncertainty of each, over the stress.
    error, jump : array (n,)
        Estimated error of the mesh and disagreement of the elements, over the stress.
    held : array (n,) of bool
        Whether a rigid spider holds the node.
    """
    part = np.asarray(part, dtype=float)
    numbers = np.searchsorted(np.array(GRADES), 100.0 * part)
    numbers[(np.asarray(error) > MESH_LIMIT) | (np.asarray(jump) > JUMP_LIMIT)] = LIMITED
    numbers[np.asarray(held, dtype=bool)] = HELD
    return np.where(np.isnan(part), -1, numbers).astype(np.int8)


def verdict_words(numbers: ArrayLike, truncation_known: bool = True) -> list[str]:
    """Verdicts of their numbers, "not known" for -1; those without truncation say so."""
    uncounted = "" if truncation_known else " but for truncation"
    words = [word + uncounted * (k <= OPEN) for k, word in enumerate(VERDICTS)]
    return ["not known" if number < 0 else words[number] for number in np.asarray(numbers)]


def judged(
    table: pd.DataFrame,
    truncation: float | None = None,
    spread: ArrayLike = 0.0,
    choice: ArrayLike = 0.0,
) -> pd.DataFrame:
    """Add one plain verdict to each peak of a table of hot spots.

    It is that of the sum of all known errors of a stress.

    Parameters
    ----------
    table : pandas.DataFrame
        Of `hot_spots`.
    truncation : float, optional
        In Pa, greatest change of a stress by left-out modes; unknown if None, which the verdict then says.
    spread : array (rows,) or float
        In Pa, range of runs whose starts differ by rounding.
    choice : array (rows,) or float
        In Pa, difference between contact laws that could describe the same ground.

    Returns
    -------
    pandas.DataFrame
        The table with a column verdict: "beside a rigid pin coupling: do not use"; "mesh-limited: refine
        here" if the error of the mesh is above `MESH_LIMIT` or elements disagree by more than `JUMP_LIMIT`;
        "good to 10 %" and the like; or "uncertain by more than 50 %".

    Raises
    ------
    ValueError
        If one of the errors is negative or not finite.
    """
    errors = {"truncation": 0.0 if truncation is None else truncation, "spread": spread, "choice": choice}
    size = table["value"].abs().to_numpy()
    total = table["error"].to_numpy().copy()
    for name, error in errors.items():
        values = np.broadcast_to(np.asarray(error, dtype=float), size.shape)
        if not (np.isfinite(values) & (values >= 0.0)).all():
            raise ValueError(f"{name} must be finite and not negative, got {error}")
        total += values
    size = np.maximum(size, np.finfo(float).tiny)
    numbers = verdict_numbers(
        total / size, table["error"] / size, table["jump"] / size, table["flag"] == IN_SPIDER
    )
    return table.assign(verdict=verdict_words(numbers, truncation is not None))
