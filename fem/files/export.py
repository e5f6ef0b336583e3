"""Export to other programs: VTU for ParaView, input decks for CalculiX and Abaqus."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import meshio
import numpy as np

from fem.body.elastic_body import ElasticBody
from fem.body.elasticity import Material
from fem.body.element_stress import von_mises
from fem.body.interfaces import Interface, rigid_motion_of_centers, spread_loads
from fem.body.mesh import Floats, Integers, Mesh
from fem.body.reduced import ReducedBody
from fem.body.shapes import Shapes

Program = Literal["calculix", "abaqus"]
PROGRAMS: tuple[Program, ...] = ("calculix", "abaqus")
"""Finite-element programs with a writer for decks of loads."""
BALANCE = 1e-9
"""Greatest sum of balanced loads, fraction of the sum of their magnitudes."""


def write_vtu(path: str | Path, mesh: Mesh, fields: Mapping[str, Floats]) -> None:
    """Write nodal fields (n,), (n, 3) or (n, 6) on a mesh, for ParaView."""
    meshio.write(path, vtu_content(mesh, fields), file_format="vtu")


def vtu_content(mesh: Mesh, fields: Mapping[str, Floats], nodes: Floats | None = None) -> meshio.Mesh:
    """Return a mesh for meshio with nodal fields (n,), (n, 3) or (n, 6); `nodes` (n, 3) replaces its own."""
    kind = "tetra" if mesh.order == 1 else "tetra10"
    return meshio.Mesh(
        mesh.nodes if nodes is None else nodes,
        # node numbers of half the size halve the time of compression
        [(kind, mesh.elements.astype(np.int32))],
        point_data={name: np.ascontiguousarray(field) for name, field in fields.items()},
    )


def write_modes_vtu(path: str | Path, body: ReducedBody, modes: Sequence[int]) -> None:
    """Write modes (counted from 0) with their stress: fields "mode k f Hz" and "stress k"."""
    fields = {}
    for k in modes:
        fields[f"mode {k} {body.frequencies[k]:.2f} Hz"] = body.modes[:, :, k]
        fields[f"stress {k}"] = body.stress_modes[:, :, k]
    write_vtu(path, body.mesh, fields)


def write_frame_vtu(path: str | Path, body: Shapes, q: Floats) -> None:
    """Write displacement (m), stress (Pa) and von Mises stress (Pa) of coordinates (m,)."""
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
        Number of free-free modes to compute, the rigid ones included; the result has their shapes.
    forces : array (n, 3), optional
        Nodal forces in N of a static step, in place of frequencies.
    fixed : int array, optional
        Numbers of the degrees of freedom (3 node + axis) that hold the body in a static step.

    Raises
    ------
    ValueError
        If neither or both of frequencies and a static step are given.
    """
    if (frequencies is None) == (forces is None or fixed is None):
        raise ValueError("frequencies, or both forces and fixed, must be given, got both or neither")
    lines = [*_mesh_lines(body.mesh.nodes, body.mesh), *_material_lines(body.material), "*STEP"]
    if frequencies is not None:
        lines += ["*FREQUENCY", f"{frequencies}", "*NODE FILE", "U"]
    elif forces is not None:
        lines += ["*STATIC", *_held_lines(np.asarray(fixed))]
        lines += ["*CLOAD", *_load_lines(forces), "*NODE PRINT, NSET=ALL", "U", "*NODE FILE", "S"]
    lines.append("*END STEP")
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_load_deck(
    path: str | Path,
    body: ElasticBody,
    interfaces: Sequence[Interface],
    forces: Floats,
    center_loads: Floats,
    *,
    program: Program = "calculix",
    remarks: Sequence[str] = (),
) -> None:
    """Write a static step of a free body under balanced loads, in SI units; nodes and elements count from 1.

    The nodes of a rigid interface are a rigid body; its reference node at the centre takes force and moment.
    Loads on other interfaces are forces on their nodes, as an averaging spider spreads them.
    Six degrees of freedom away from the interfaces hold the body; their reactions are zero.

    Parameters
    ----------
    path : str or Path
        File to write (`.inp`).
    body : ElasticBody
    interfaces : sequence of Interface
        i of them.
    forces : array (n, 3)
        Nodal forces in N.
    center_loads : array (i, 6)
        Force and moment on each centre in N and N m.
    program : str
        "calculix" or "abaqus": they name the rotations of a rigid body differently.
    remarks : sequence of str
        Lines for the reader at the top.

    Raises
    ------
    ValueError
        If the loads are not in balance or the program is unknown.
    """
    if program not in PROGRAMS:
        raise ValueError(f"program must be one of {PROGRAMS}, got {program!r}")
    _check_balance(body, interfaces, forces, center_loads)
    mesh = body.mesh
    stiff = np.array([interface.spider == "rigid" for interface in interfaces])
    forces = forces + spread_loads(mesh, interfaces, np.where(stiff[:, None], 0.0, center_loads))
    interfaces = [interface for interface in interfaces if interface.spider == "rigid"]
    center_loads = center_loads[stiff]
    count = len(interfaces)
    n = len(mesh.nodes)
    centers = np.array([interface.center for interface in interfaces]).reshape(-1, 3)
    # CalculiX turns a rigid body by the displacements of a node of its own, Abaqus by its reference node
    turned = program == "calculix"
    lines = [f"** {remark}" for remark in remarks]
    lines += _mesh_lines(np.vstack((mesh.nodes, centers, *([centers] if turned else []))), mesh)
    lines += _material_lines(body.material)
    for row, interface in enumerate(interfaces):
        name = interface.name.upper().replace(" ", "_")
        lines += [f"*NSET, NSET={name}", *(f"{node + 1}," for node in interface.nodes.tolist())]
        tied = f"NSET={name}" if turned else f"TIE NSET={name}"
        turn = f", ROT NODE={n + count + row + 1}" if turned else ""
        lines.append(f"*RIGID BODY, {tied}, REF NODE={n + row + 1}{turn}")
    held = np.concatenate([np.zeros(0, dtype=int), *(interface.nodes for interface in interfaces)])
    away = np.setdiff1d(np.arange(n), held)
    lines += ["*STEP", "*STATIC", *_held_lines(body.determinate_of(away)), "*CLOAD", *_load_lines(forces)]
    lines += _load_lines(center_loads[:, :3], n)
    lines += _load_lines(center_loads[:, 3:], n + count) if turned else _load_lines(center_loads[:, 3:], n, 3)
    if turned:
        lines += ["*NODE FILE", "U, RF", "*EL FILE", "S"]
    else:
        lines += ["*OUTPUT, FIELD", "*NODE OUTPUT", "U, RF", "*ELEMENT OUTPUT, POSITION=NODES", "S"]
    lines.append("*END STEP")
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def _check_balance(
    body: ElasticBody, interfaces: Sequence[Interface], forces: Floats, center_loads: Floats
) -> None:
    """Raise `ValueError` for loads whose sum exceeds rounding of the sum of their magnitudes."""
    at_centers = rigid_motion_of_centers(interfaces, body.center_of_mass)
    off = body.rigid_modes.T @ forces.ravel() + at_centers.T @ center_loads.ravel()
    size = float(np.abs(forces).sum() + np.abs(center_loads).sum())
    if np.abs(off).max() > BALANCE * max(size, 1.0):
        raise ValueError(f"loads must be in balance, got sums {off.tolist()} of forces (N) and moments (N m)")


def _mesh_lines(nodes: Floats, mesh: Mesh) -> list[str]:
    """Return the lines of nodes, those of the mesh first, and of elements."""
    kind = "C3D4" if mesh.order == 1 else "C3D10"
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(nodes, 1)]
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=BODY")
    lines += [
        f"{i}, " + ", ".join(str(node) for node in corners)
        for i, corners in enumerate((mesh.elements + 1).tolist(), 1)
    ]
    return lines


def _material_lines(material: Material) -> list[str]:
    return [
        "*MATERIAL, NAME=STEEL",
        "*ELASTIC",
        f"{material.youngs_modulus:.12g}, {material.poissons_ratio:.12g}",
        "*DENSITY",
        f"{material.density:.12g}",
        "*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL",
    ]


def _held_lines(fixed: Integers) -> list[str]:
    """Return the lines that hold degrees of freedom (3 node + axis)."""
    return ["*BOUNDARY", *(f"{dof // 3 + 1}, {dof % 3 + 1}" for dof in fixed.tolist())]


def _load_lines(loads: Floats, before: int = 0, axes_before: int = 0) -> list[str]:
    """Return the lines of loads (k, 3); nodes and axes count from `before` and `axes_before`."""
    return [
        # CalculiX cuts a number after 20 characters: its exponent must not be cut off
        f"{before + node + 1}, {axes_before + axis + 1}, {loads[node, axis]:.13g}"
        for node, axis in np.argwhere(loads)
    ]
