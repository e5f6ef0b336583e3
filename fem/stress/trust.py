"""Trust in a stress: its discretization error, and one plain verdict per peak or node.

The error is estimated after O. C. Zienkiewicz and J. Z. Zhu, A simple error estimator and adaptive
procedure for practical engineering analysis, Int. J. Numer. Meth. Engng. 24 (1987) 337-357. The nodal
average of the stress is better than the elements' stress. The difference of both over the elements around
a node, relative to the stress there, shows how well the elements resolve the stress.
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
"""Relative error of the nodal stress over the relative difference around it, at a bore of known solution."""
MESH_LIMIT = 0.2
"""Relative error of the mesh above which a stress must not be used before refinement. At a shoe's fillets it
separates a mesh with peaks at most a tenth low from one with peaks a third low (`docs/fem.md`)."""
JUMP_LIMIT = 0.5
"""Relative disagreement of neighbouring elements above which the peak comes from the mesh."""
GRADES = (5, 10, 15, 20, 25, 30, 40, 50)
"""Uncertainties up to which a stress counts as good, per cent."""
VERDICTS = (
    *(f"good to {grade} %" for grade in GRADES),
    f"uncertain by more than {GRADES[-1]} %",
    "mesh too coarse: refine here",
    "beside a pin coupling: do not use",
)
"""Verdicts in order of their numbers, from 0."""
OPEN, LIMITED, HELD = range(len(GRADES), len(GRADES) + 3)
"""Numbers of the verdicts that are not grades."""
IN_SPIDER = "in spider"
"""Flag of a node that a coupling holds."""
BORES = 0.18
"""Least relative error of the stress at a bore with a pin in contact: facets, friction (`docs/fem.md`)."""
LEFT_OUT = 1e-2
"""Root-mean-square stress that the few fields of an estimate may drop, fraction of the history's."""


@dataclass(frozen=True)
class Resolution:
    """Resolution of the stress at n nodes by a mesh, over one or several displacement fields.

    It holds sums of squares over the fields; further fields are added.

    Parameters
    ----------
    off, stress : array (n,)
        Squares integrated over the elements of a node: of averaged stress minus the elements' stress, and
        of the elements' stress. Both are taken as linear in an element.
    jump, size : array (n,)
        Squares in Pa2. `jump` is of the greatest von Mises stress of the difference between an element's
        stress and the nodal one; it is zero if the elements agree. `size` is of the nodal von Mises stress.
    """

    off: Floats
    stress: Floats
    jump: Floats
    size: Floats

    def __add__(self, other: "Resolution") -> "Resolution":
        """Return the resolution over the fields of both."""
        return Resolution(
            self.off + other.off, self.stress + other.stress, self.jump + other.jump, self.size + other.size
        )

    @property
    def error(self) -> Floats:
        """Estimated relative error of the nodal von Mises stress, (n,)."""
        return SAFETY * _root_ratio(self.off, self.off + self.stress)

    @property
    def relative_jump(self) -> Floats:
        """Disagreement of the elements, fraction of the nodal von Mises stress, (n,)."""
        return _root_ratio(self.jump, self.size)


def _root_ratio(part: Floats, whole: Floats) -> Floats:
    """Return the square root of a part over the whole; zero where the whole is zero."""
    return np.sqrt(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0))


def resolution(mesh: Mesh, material: Material, displacement: Floats) -> Resolution:
    """Measure how well a mesh resolves the stress of a displacement (n, 3) in m."""
    return _resolution(mesh.nodes, mesh.elements, element_deviator(mesh, material, displacement))


def resolution_at(body: Shapes, q: Floats, nodes: Integers) -> Resolution:
    """Measure how well a body's mesh resolves single stresses, each from its node's own elements.

    Parameters
    ----------
    body : Shapes
    q : array (k, m)
        Coordinates of the body's columns, one field per row.
    nodes : int array (k,)
        Number of each field's node.

    Returns
    -------
    Resolution
        Resolution at k nodes, equal to that of `resolution` up to rounding.
    """
    resolutions = [_resolution_at_node(body, row, node) for row, node in zip(q, nodes.tolist(), strict=True)]
    return Resolution(
        np.array([each.off for each in resolutions]),
        np.array([each.stress for each in resolutions]),
        np.array([each.jump for each in resolutions]),
        np.array([each.size for each in resolutions]),
    )


def _resolution_at_node(body: Shapes, q: Floats, node: int) -> Resolution:
    """Measure how well a body's mesh resolves the stress of coordinates (m,) at a node, in plain numbers."""
    mesh = body.mesh
    about = (mesh.elements == node).any(axis=1)
    reached = np.zeros(len(mesh.nodes), dtype=bool)
    reached[mesh.elements[about]] = True
    # the averages at the nodes of its elements need all elements of these nodes
    elements = np.flatnonzero(reached[mesh.elements].any(axis=1))
    used, local = np.unique(mesh.elements[elements], return_inverse=True)
    displacement = np.zeros_like(mesh.nodes)
    displacement[used] = combined(body.modes, q, used)[0]
    stress = element_deviator(mesh, body.material, displacement, elements)
    near = _resolution(mesh.nodes[used], local.reshape(len(elements), -1), stress)
    place = int(np.searchsorted(used, node))
    return Resolution(near.off[place], near.stress[place], near.jump[place], near.size[place])


def _resolution(nodes: Floats, elements: Integers, stress: Floats) -> Resolution:
    """Measure how well elements (e, a) of nodes (n, 3) resolve a stress (e, a, 5) of `element_deviator`."""
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
    """Measure how well a body's mesh resolves the stress of a history (t, m), in the mean square over time.

    The squares come from the few fields that carry nearly all of the history's stress.
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
    """Find coordinates (r, m) of few fields with a history's mean squares, given its products (m, m)."""
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
        In Pa: `SAFETY` times the nodal von Mises stress times ``sqrt(e / (e + s))``. The mean squares over
        the elements of the node are e of averaged stress minus the elements' stress, and s of the elements'
        stress. Both are taken as linear in an element.
    """
    resolved = resolution(mesh, material, displacement)
    return resolved.error * np.sqrt(resolved.size)


def with_bores(error: Floats, body: Shapes, nodes: Integers | None = None) -> Floats:
    """Return relative errors (n or len(nodes),) of at least `BORES` at bores with a pin in contact."""
    numbers = np.arange(len(body.nodes)) if nodes is None else nodes
    return np.where(np.isin(numbers, body.pressed_nodes), np.maximum(error, BORES), error)


def verdict_numbers(part: ArrayLike, error: ArrayLike, jump: ArrayLike, held: ArrayLike) -> NDArray[np.int8]:
    """Return the numbers (n,) of the verdicts on stresses; -1 if an uncertainty is not a number.

    Parameters
    ----------
    part : array (n,)
        Total uncertainty, fraction of the stress.
    error, jump : array (n,)
        Estimated error of the mesh and disagreement of the elements, fractions of the stress.
    held : array (n,) of bool
        True if the stress is that of a coupling, see `Shapes.held_nodes`.
    """
    part = np.asarray(part, dtype=float)
    numbers = np.searchsorted(np.array(GRADES), 100.0 * part)
    numbers[(np.asarray(error) > MESH_LIMIT) | (np.asarray(jump) > JUMP_LIMIT)] = LIMITED
    numbers[np.asarray(held, dtype=bool)] = HELD
    return np.where(np.isnan(part), -1, numbers).astype(np.int8)


def verdict_words(numbers: ArrayLike, truncation_known: bool = True) -> list[str]:
    """Return the words of verdicts by number, "not known" for -1; they say if truncation is unknown."""
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

    The verdict is on the sum of all known errors of a stress.

    Parameters
    ----------
    table : pandas.DataFrame
        Result of `hot_spots`.
    truncation : float, optional
        Greatest change of a stress by truncated modes, in Pa; unknown if None, and the verdict says so.
    spread : array (rows,) or float
        Range of runs with starts that differ by rounding, in Pa.
    choice : array (rows,) or float
        Difference between contact laws that could describe the same ground, in Pa.

    Returns
    -------
    pandas.DataFrame
        The table with a column verdict: "beside a pin coupling: do not use"; "mesh too coarse: refine
        here" if the error of the mesh is above `MESH_LIMIT` or elements disagree by more than `JUMP_LIMIT`;
        "good to 10 %" and the like; or "uncertain by more than 50 %".

    Raises
    ------
    ValueError
        If an error is negative or not finite.
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
