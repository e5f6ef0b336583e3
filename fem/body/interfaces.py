"""Interfaces: groups of nodes tied to a joint centre by a rigid or an averaging spider.

The motion of a joint centre has six components: translation along and small rotation about the
body's x, y, z, in m and rad.

The nodes of a rigid spider (RBE2) move with the centre only: it stiffens the bore and distorts the
stress beside it. The centre of an averaging spider (RBE3) moves as the weighted mean of its nodes. It
spreads a load over them without stiffening (NASTRAN's RBE3 with equal weights). A spider of a pin in contact
is an averaging one, to which `pin_contact` adds the pressures of the pin.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_array, hstack, identity

from fem.body.elastic_body import rigid_modes
from fem.body.mesh import Floats, Integers, Mesh

Spider = Literal["rigid", "averaging", "contact"]
COLLINEAR = 1e-6
"""Least ratio of a node group's second to its greatest extent; below it the nodes are collinear."""


@dataclass(frozen=True, eq=False)
class Interface:
    """Attachment point of a body.

    Parameters
    ----------
    name : str
    center : array (3,)
        Position of the joint centre in body axes in m.
    nodes : int array (k,)
        Numbers of the nodes tied to it.
    spider : str
        "rigid" (RBE2), "averaging" (RBE3), or "contact": averaging, with a pin that presses on one side.

    Raises
    ------
    ValueError
        If the centre is not three finite numbers, there is no node or no such spider.
    """

    name: str
    center: Floats
    nodes: Integers
    spider: Spider = "rigid"

    def __post_init__(self) -> None:
        center = np.asarray(self.center, dtype=np.float64)
        nodes = np.unique(np.asarray(self.nodes, dtype=np.int64))
        if center.shape != (3,) or not np.isfinite(center).all():
            raise ValueError(
                f"interface {self.name!r}: center must be three finite numbers, got {self.center}"
            )
        if len(nodes) == 0:
            raise ValueError(f"interface {self.name!r}: nodes must be at least one, got none")
        if self.spider not in get_args(Spider):
            raise ValueError(
                f"interface {self.name!r}: spider must be one of {get_args(Spider)}, got {self.spider!r}"
            )
        object.__setattr__(self, "center", center)
        object.__setattr__(self, "nodes", nodes)


def check_interfaces(mesh: Mesh, interfaces: Sequence[Interface]) -> None:
    """Check that interfaces fit a mesh.

    Raises
    ------
    ValueError
        If there is none, a name appears twice, nodes do not exist, are collinear, or belong to two
        interfaces.
    """
    if not interfaces:
        raise ValueError("interfaces must be at least one, got none")
    names = [interface.name for interface in interfaces]
    double = sorted({name for name in names if names.count(name) > 1})
    if double:
        raise ValueError(f"names of interfaces must be different, got {double} twice")
    owner: dict[int, str] = {}
    for interface in interfaces:
        nodes = interface.nodes
        name = interface.name
        if nodes[0] < 0 or nodes[-1] >= len(mesh.nodes):
            raise ValueError(
                f"interface {name!r}: nodes must lie in 0..{len(mesh.nodes) - 1}, got {nodes[0]}..{nodes[-1]}"
            )
        spread = np.linalg.svd(mesh.nodes[nodes] - mesh.nodes[nodes].mean(axis=0), compute_uv=False)
        if len(nodes) < 3 or spread[1] <= COLLINEAR * spread[0]:
            raise ValueError(
                f"interface {name!r}: nodes must not lie on a line, about which they can take no moment, "
                f"got {len(nodes)} that do"
            )
        for node in nodes.tolist():
            if node in owner:
                raise ValueError(
                    f"nodes must belong to one interface, got {node} in {owner[node]!r} and {name!r}"
                )
            owner[node] = name


def averaging_rows(positions: Floats, weights: Floats, center: Floats) -> Floats:
    """Return rows (6, 3k) that give the weighted-mean rigid motion of k nodes, seen at a centre.

    The motion is the weighted least-squares fit of a rigid motion. The transpose spreads a force and a
    moment at the centre over the nodes.

    Parameters
    ----------
    positions : array (k, 3)
        In m.
    weights : array (k,)
        Not negative.
    center : array (3,)
        In m.
    """
    modes = rigid_modes(positions, center)
    weighted = modes * np.repeat(weights, 3)[:, None]
    return np.asarray(np.linalg.solve(modes.T @ weighted, weighted.T), dtype=np.float64)


def center_loads(interfaces: Sequence[Interface], forces: Mapping[str, ArrayLike]) -> Floats:
    """Assemble forces on joint centres for `reduction.Partition.static_response`.

    Parameters
    ----------
    interfaces : sequence of Interface
    forces : mapping of str to array (3,)
        In N, body axes, by name of the interface; zero for interfaces that are not named.

    Returns
    -------
    array (6 i, 1)
        Force and moment on each joint centre in N and N m; the moments are zero.

    Raises
    ------
    KeyError
        If there is no such interface.
    """
    names = [interface.name for interface in interfaces]
    unknown = sorted(set(forces) - set(names))
    if unknown:
        raise KeyError(f"forces must be on interfaces of {names}, got {unknown}")
    loads = np.zeros((len(names), 6))
    for name, force in forces.items():
        loads[names.index(name), :3] = force
    return loads.reshape(-1, 1)


def spread_loads(mesh: Mesh, interfaces: Sequence[Interface], center_loads: Floats) -> Floats:
    """Return the nodal forces (n, 3), N, as which averaging spiders spread loads (i, 6) on their centres."""
    forces = np.zeros_like(mesh.nodes)
    for interface, load in zip(interfaces, center_loads, strict=True):
        positions = mesh.nodes[interface.nodes]
        rows = averaging_rows(positions, np.ones(len(positions)), interface.center)
        forces[interface.nodes] += (load @ rows).reshape(-1, 3)
    return forces


def rigid_motion_of_centers(interfaces: Sequence[Interface], origin: Floats) -> Floats:
    """Return the joint centres' motions (6 i, 6) in rigid motions of the body; `origin` is the pivot."""
    motion = np.zeros((len(interfaces), 6, 6))
    for k, interface in enumerate(interfaces):
        motion[k, :3] = rigid_modes(interface.center[None], origin)
        motion[k, 3:, 3:] = np.eye(3)
    return motion.reshape(-1, 6)


def spider_transformation(mesh: Mesh, interfaces: Sequence[Interface]) -> tuple[csr_array, csr_array]:
    """Return the matrices of all displacements that the spiders allow: u = Tq q + Tr r.

    Returns
    -------
    Tq : sparse array (3n, 6 i)
        For the joint centres' motions q.
    Tr : sparse array (3n, r)
        For the remaining free displacements; Tr r leaves all q at zero.
    """
    size = 3 * len(mesh.nodes)
    free = np.ones(size, dtype=bool)
    parts: list[tuple[Integers, Integers, Floats]] = []
    columns: list[tuple[Integers, Floats]] = []
    for interface in interfaces:
        dofs = (3 * interface.nodes[:, None] + np.arange(3)).ravel()
        positions = mesh.nodes[interface.nodes]
        if interface.spider == "rigid":
            free[dofs] = False
            columns.append((dofs, rigid_modes(positions, interface.center)))
            continue
        rows = averaging_rows(positions, np.ones(len(positions)), interface.center)
        _, _, order = scipy.linalg.qr(rows, mode="economic", pivoting=True)
        dependent = np.sort(order[:6])
        independent = np.sort(order[6:])
        free[dofs[dependent]] = False
        inverse = np.asarray(np.linalg.inv(rows[:, dependent]), dtype=np.float64)
        columns.append((dofs[dependent], inverse))
        parts.append((dofs[dependent], dofs[independent], -inverse @ rows[:, independent]))
    tq = [
        coo_array(
            (block.ravel(), (np.repeat(dofs, 6), np.tile(np.arange(6), len(dofs)))),
            shape=(size, 6),
        )
        for dofs, block in columns
    ]
    tr = csr_array(identity(size, format="csr"))[:, np.flatnonzero(free)]
    number = np.cumsum(free) - 1
    for dependent, independent, block in parts:
        tr = tr + coo_array(
            (
                block.ravel(),
                (np.repeat(dependent, len(independent)), np.tile(number[independent], len(dependent))),
            ),
            shape=tr.shape,
        )
    return csr_array(hstack(tq)), csr_array(tr)
