"""Meshes written as other programs write them: pieces of Abaqus' decks, gmsh's version 4.1, MED."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import h5py
import numpy as np

import fem
from fem.body.surfaces import surface_weights

SHELLS = 100_000
"""Number of the first shell of a deck."""
GMSH_TYPES = {3: 2, 4: 4, 6: 9, 10: 11}
"""gmsh's numbers of triangles and tetrahedra by their count of nodes."""
GMSH_TETRA10 = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]


def lines_of(numbers: Iterable[int], width: int = 8) -> str:
    """Numbers as lines of data of a deck."""
    entries = list(map(str, numbers))
    return "".join(", ".join(entries[k : k + width]) + ",\n" for k in range(0, len(entries), width))


def nodes_text(mesh: fem.Mesh) -> str:
    """Lines of the nodes, from number 1."""
    return "".join(f"{k}, {x!r}, {y!r}, {z!r}\n" for k, (x, y, z) in enumerate(mesh.nodes.tolist(), start=1))


def elements_text(nodes: np.ndarray, first: int = 1) -> str:
    """Lines of elements with their nodes."""
    rows = enumerate((nodes + 1).tolist(), start=first)
    return "".join(f"{number}, {', '.join(map(str, row))}\n" for number, row in rows)


def solids_text(mesh: fem.Mesh, type_: str = "C3D10") -> str:
    """Deck of nodes and solid elements."""
    return f"*NODE\n{nodes_text(mesh)}*ELEMENT, TYPE={type_}\n{elements_text(mesh.elements)}"


class Shells:
    """Shells on named surfaces, each shell once: text of their elements, and numbers by name."""

    def __init__(self, mesh: fem.Mesh, names: Sequence[str], type_: str = "STRI65") -> None:
        faces = np.concatenate([mesh.surface(name) for name in names])
        _, first, place = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True)
        counts = np.cumsum([0, *(len(mesh.surface(name)) for name in names)])
        self.text = f"*ELEMENT, TYPE={type_}\n{elements_text(faces[first], SHELLS)}"
        self.numbers = {
            name: (SHELLS + place.ravel()[begin:end]).tolist()
            for name, begin, end in zip(names, counts[:-1], counts[1:], strict=True)
        }


def element_faces(mesh: fem.Mesh, name: str) -> dict[int, list[int]]:
    """Numbers of the elements of a surface's faces, by the number of the face in Abaqus, from 1."""
    sides = {1: (0, 1, 2), 2: (0, 3, 1), 3: (1, 3, 2), 4: (2, 3, 0)}
    wanted = set(map(tuple, np.sort(mesh.surface(name)[:, :3], axis=1).tolist()))
    chosen: dict[int, list[int]] = {}
    for side, corners in sides.items():
        faces = np.sort(mesh.elements[:, corners], axis=1).tolist()
        numbers = [number for number, face in enumerate(faces, start=1) if tuple(face) in wanted]
        if numbers:
            chosen[side] = numbers
    return chosen


def areas(mesh: fem.Mesh) -> dict[str, float]:
    """Area of each named surface, m2."""
    return {name: float(surface_weights(mesh, faces).sum()) for name, faces in mesh.surfaces.items()}


def same_faces(mesh: fem.Mesh, name: str, other: fem.Mesh, other_name: str | None = None) -> bool:
    """True where two meshes have the same faces under a name; nodes in the same order."""
    pair = (mesh.surface(name), other.surface(other_name or name))
    first, second = (sorted(map(tuple, np.sort(faces, axis=1).tolist())) for faces in pair)
    return first == second


def write_msh41(
    path: Path,
    mesh: fem.Mesh,
    patches: Mapping[int, np.ndarray],
    groups: Mapping[int, Sequence[int]],
    names: Sequence[tuple[int, int, str]],
    binary: bool = False,
    parametric: bool = False,
    size: int = 8,
) -> None:
    """Write version 4.1 with geometric surfaces as gmsh does.

    Parameters
    ----------
    patches : mapping of int to int array (k, 6)
        Faces of each geometric surface by its number; the volume has number 1.
    groups : mapping of int to int
        Numbers of the physical groups of each geometric surface; 0 is the volume.
    names : tuples
        Dimension, number and name of each physical group.
    """
    pieces: list[bytes] = []

    def put(numbers: Iterable, type_: str) -> None:
        array = np.asarray(list(numbers) if not isinstance(numbers, np.ndarray) else numbers)
        if binary:
            pieces.append(np.ascontiguousarray(array, dtype=type_).tobytes())
        else:
            pieces.append((" ".join(map(repr, array.ravel().tolist())) + "\n").encode())

    count = f"u{size}"
    pieces.append(
        f"$MeshFormat\n4.1 {int(binary)} {size}\n".encode() + b"\1\0\0\0\n" * binary + b"$EndMeshFormat\n"
    )
    listed = "".join(f'{dimension} {number} "{name}"\n' for dimension, number, name in names)
    pieces.append(f"$PhysicalNames\n{len(names)}\n{listed}$EndPhysicalNames\n$Entities\n".encode())
    put([0, 0, len(patches), 1], count)
    for number in (*patches, 0):
        put([number or 1], "i4")
        put(np.concatenate((mesh.nodes.min(axis=0), mesh.nodes.max(axis=0))), "f8")
        put([len(groups.get(number, []))], count)
        put(groups.get(number, []), "i4")
        put([0], count)
    pieces.append(b"\n$EndEntities\n$Nodes\n")
    put([1, len(mesh.nodes), 1, len(mesh.nodes)], count)
    put([2 if parametric else 3, 1, int(parametric)], "i4")
    put([len(mesh.nodes)], count)
    put(np.arange(1, len(mesh.nodes) + 1), count)
    put(np.hstack((mesh.nodes, mesh.nodes[:, :2])) if parametric else mesh.nodes, "f8")
    blocks = [(2, number, faces) for number, faces in patches.items()]
    blocks.append((3, 1, mesh.elements[:, GMSH_TETRA10] if mesh.order == 2 else mesh.elements))
    total = sum(len(cells) for _, _, cells in blocks)
    pieces.append(b"\n$EndNodes\n$Elements\n")
    put([len(blocks), total, 1, total], count)
    first = 1
    for dimension, number, cells in blocks:
        put([dimension, number, GMSH_TYPES[cells.shape[1]]], "i4")
        put([len(cells)], count)
        put(np.column_stack((np.arange(first, first + len(cells)), cells + 1)), count)
        first += len(cells)
    path.write_bytes(b"".join(pieces) + b"\n$EndElements\n")


def write_med(
    path: Path, mesh: fem.Mesh, families: Mapping[int, Sequence[str]], family_of: np.ndarray
) -> None:
    """Write a MED file as Salome does, with a field on tetrahedra alone.

    Parameters
    ----------
    families : mapping of int to str
        Groups of each family of the boundary's faces.
    family_of : int array (k,)
        Family of each face of `Mesh.boundary`; 0 is none. The tetrahedra have no families.
    """
    kinds = {"T10": mesh.elements, "TR6": mesh.boundary}
    if mesh.order == 1:
        kinds = {"TE4": mesh.elements, "TR3": mesh.boundary}
    with h5py.File(path, "w") as file:
        step = file.create_group("ENS_MAA/shoe/-0000000000000000001-0000000000000000001")
        coordinates = step.create_dataset("NOE/COO", data=mesh.nodes.ravel(order="F"))
        coordinates.attrs["NBR"] = len(mesh.nodes)
        for kind, nodes in kinds.items():
            # its tetrahedra go round in the other sense
            turned = (
                nodes[:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8][: nodes.shape[1]]]
                if kind in ("T10", "TE4")
                else nodes
            )
            entry = step.create_dataset(f"MAI/{kind}/NOD", data=(turned + 1).ravel(order="F"))
            entry.attrs["NBR"] = len(nodes)
            if kind in ("TR3", "TR6"):
                step[f"MAI/{kind}"].create_dataset("FAM", data=family_of)
        for number, groups in families.items():
            family = file.create_group(f"FAS/shoe/ELEME/FAM_{number}")
            family.attrs["NUM"] = number
            family.create_group("GRO").attrs["NBR"] = len(groups)
            padded = [list(group.encode().ljust(80, b"\0")) for group in groups]
            family["GRO"].create_dataset("NOM", data=np.array(padded, dtype=np.int8))
        file["FAS/shoe"].create_group("FAMILLE_ZERO").attrs["NUM"] = 0
        field = file.create_group("CHA/stress/0001/MAI.T10/MED_NO_PROFILE_INTERNAL")
        field.attrs["NBR"] = len(mesh.elements)
        field.create_dataset("CO", data=np.zeros(len(mesh.elements)))
