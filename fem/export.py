"""Export to other programs: VTU for ParaView, input decks for CalculiX."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import meshio
import numpy as np

from fem.body import ElasticBody
from fem.mesh import Floats, Integers, Mesh
from fem.reduced import ReducedBody
from fem.stress import von_mises


def write_vtu(
    path: str | Path, mesh: Mesh, fields: Mapping[str, Floats], nodes: Floats | None = None
) -> None:
    """Write nodal fields (n,), (n, 3) or (n, 6) on a mesh, for ParaView; `nodes` (n, 3) puts it elsewhere."""
    kind = "tetra" if mesh.order == 1 else "tetra10"
    point_data = {name: np.ascontiguousarray(field) for name, field in fields.items()}
    meshio.write(
        path,
        meshio.Mesh(mesh.nodes if nodes is None else nodes, [(kind, mesh.elements)], point_data=point_data),
        file_format="vtu",
    )


def write_modes_vtu(path: str | Path, body: ReducedBody, modes: Sequence[int]) -> None:
    """Write modes (counted from 0) with their stress: fields "mode k f Hz" and "stress k"."""
    fields = {}
    for k in modes:
        fields[f"mode {k} {body.frequencies[k]:.2f} Hz"] = body.modes[:, :, k]
        fields[f"stress {k}"] = body.stress_modes[:, :, k]
    write_vtu(path, body.mesh, fields)


def write_frame_vtu(path: str | Path, body: ReducedBody, q: Floats) -> None:
    """Write displacement (m), stress (Pa) and von Mises stress of modal coordinates (m,)."""
    stress = body.stress(q)[0]
    write_vtu(
        path,
        body.mesh,
        {
            "displacement": body.displacement(q)[0],
            "stress": stress,
            "von mises": von_mises(stress),
        },
    )


def write_calculix(
    path: str | Path,
    body: ElasticBody,
    *,
    frequencies: int | None = None,
    forces: Floats | None = None,
    fixed: Integers | None = None,
) -> None:
    """Write a body as an input deck for CalculiX, in SI units; nodes and elements count from 1.

    Parameters
    ----------
    path : str or Path
        File to write (`.inp`).
    body : ElasticBody
    frequencies : int, optional
        Number of free-free modes to ask for, the rigid ones included, or
    forces : array (n, 3), optional
        Nodal forces in N of a static step, with
    fixed : int array, optional
        Numbers of the degrees of freedom (3 node + axis) that hold the body.

    Raises
    ------
    ValueError
        If neither or both of frequencies and a static step are given.
    """
    if (frequencies is None) == (forces is None or fixed is None):
        raise ValueError("frequencies, or both forces and fixed, must be given, got both or neither")
    mesh, material = body.mesh, body.material
    kind = "C3D4" if mesh.order == 1 else "C3D10"
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(mesh.nodes, 1)]
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=BODY")
    lines += [
        f"{i}, " + ", ".join(str(node) for node in nodes)
        for i, nodes in enumerate((mesh.elements + 1).tolist(), 1)
    ]
    lines += [
        "*MATERIAL, NAME=STEEL",
        "*ELASTIC",
        f"{material.youngs_modulus:.12g}, {material.poissons_ratio:.12g}",
        "*DENSITY",
        f"{material.density:.12g}",
        "*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL",
        "*STEP",
    ]
    if frequencies is not None:
        lines += ["*FREQUENCY", f"{frequencies}"]
    elif forces is not None:
        lines += ["*STATIC", "*BOUNDARY"]
        lines += [f"{dof // 3 + 1}, {dof % 3 + 1}" for dof in np.asarray(fixed).tolist()]
        lines.append("*CLOAD")
        lines += [f"{node + 1}, {axis + 1}, {forces[node, axis]:.15g}" for node, axis in np.argwhere(forces)]
        lines += ["*NODE PRINT, NSET=ALL", "U", "*NODE FILE", "S"]
    lines.append("*END STEP")
    Path(path).write_text("\n".join(lines) + "\n")
