"""Stress at one node by unit loads: of a body and its static fields, or of their files, read in part.

Which of the two is asked makes no difference to the numbers.
"""

import json
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import h5py
import numpy as np

from fem.elasticity import Material
from fem.hdf5 import REDUCED_BODY, STATIC_FIELDS, read_whole
from fem.mesh import Floats, Integers
from fem.stress import stress_at_node

if TYPE_CHECKING:
    from fem.fields import StaticFields
    from fem.reduced import ReducedBody


class Places(NamedTuple):
    """Nodes of a body.

    Attributes
    ----------
    nodes : array (n, 3)
        Positions in m, body axes.
    spider_nodes : int array
        Numbers of those inside joints' spiders, ascending.
    """

    nodes: Floats
    spider_nodes: Integers


class _Body(NamedTuple):
    """What the file of a reduction says: mesh and material, and (m, 6) stress at one node by its m modes."""

    nodes: Floats
    elements: Integers
    material: Material
    frequencies: Floats
    stress: Floats


def unit_stress(body: "ReducedBody", fields: "StaticFields | None", node: int) -> Floats:
    """Stress (k, 6) in Pa at a node by a unit of each of the k loads of static fields beside a body's modes.

    Without fields, by a unit of each of the body's coordinates.
    """
    modes = body.stress_modes[node].T
    if fields is None:
        return modes
    about = stress_at_node(body.nodes, body.mesh.elements, body.material, fields.displacements, node)
    return fields.held(body.frequencies) @ modes + about.T


def places_in(reduction: Path) -> Places:
    """Nodes of the body in a file of `save_reduced`; errors are those of `hdf5.read_whole`."""

    def read(file: h5py.File) -> Places:
        spiders = [entry["nodes"][()] for entry in file["interfaces"].values()]
        return Places(file["mesh/nodes"][()], np.unique(np.concatenate(spiders)))

    return read_whole(reduction, REDUCED_BODY, read)


def unit_stress_in(reduction: Path, fields: Path | None, node: int) -> Floats:
    """Same as `unit_stress`, of files of `save_reduced` and `save_fields`, of which the node's rows are read.

    The checksums of these rows are proved, the digests of the whole files are not.

    Raises
    ------
    FileNotFoundError, ValueError
        As of `hdf5.read_whole`.
    """

    def read_body(file: h5py.File) -> _Body:
        return _Body(
            file["mesh/nodes"][()],
            file["mesh/elements"][()],
            Material(**json.loads(file.attrs["material"])),
            file["frequencies"][()],
            file["stress_modes"][node].T,
        )

    body = read_whole(reduction, REDUCED_BODY, read_body)
    if fields is None:
        return body.stress

    def read_fields(file: h5py.File) -> Floats:
        about = stress_at_node(body.nodes, body.elements, body.material, file["displacements"], node)
        held: Floats = file["work"][()] / (2.0 * np.pi * body.frequencies) ** 2
        return held @ body.stress + about.T

    return read_whole(fields, STATIC_FIELDS, read_fields)
