"""HDF5 files of reduced bodies and static fields, with digests that reveal a stale file."""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TypeVar

import h5py
import numpy as np

from fem.body.elasticity import Material
from fem.body.interfaces import Interface
from fem.body.mesh import Floats, Mesh
from fem.body.reduced import ReducedBody
from fem.files.hdf5 import PIN_PRESSURES, REDUCED_BODY, STATIC_FIELDS, read_whole, write_rows, write_whole
from fem.stress.static_fields import StaticFields

Content = TypeVar("Content")

_ARRAYS = ("frequencies", "modes", "pilots", "center_of_mass", "inertia", "ritz")
_FIELD_ARRAYS = ("displacements", "energy", "work")


class StaleCacheError(ValueError):
    """Error for a file that belongs to another mesh or to other parameters."""


def save_reduced(path: str | Path, body: ReducedBody, digest: str = "") -> None:
    """Write a reduced body with its mesh into an HDF5 file.

    Parameters
    ----------
    path : str or Path
        File to write, replaced only when complete.
    body : ReducedBody
    digest : str
        Result of `cache.reduction_digest`, if the file is to serve as a cache.
    """

    def fill(file: h5py.File) -> None:
        file.attrs["mesh_digest"] = body.mesh.digest
        file.attrs["digest"] = digest
        file.attrs["content"] = _content_digest(body)
        file.attrs["material"] = json.dumps(asdict(body.material))
        file.attrs["parameters"] = json.dumps(dict(body.parameters))
        file.attrs["mass"] = body.mass
        for name in _ARRAYS:
            write_rows(file, name, getattr(body, name))
        mesh = file.create_group("mesh")
        write_rows(mesh, "nodes", body.mesh.nodes)
        write_rows(mesh, "elements", body.mesh.elements)
        for group, arrays in (
            ("surfaces", body.mesh.surfaces),
            ("surface_weights", body.surface_weights),
        ):
            entry = mesh.create_group(group)
            for name, array in arrays.items():
                entry.create_dataset(name, data=array, compression="gzip")
        for number, interface in enumerate(body.interfaces):
            entry = file.create_group(f"interfaces/{number:03d}")
            entry.attrs["name"] = interface.name
            entry.attrs["spider"] = interface.spider
            entry["center"] = interface.center
            write_rows(entry, "nodes", interface.nodes)

    write_whole(Path(path), REDUCED_BODY, fill)


def save_fields(path: str | Path, fields: StaticFields, digest: str = "") -> None:
    """Write static fields into an HDF5 file, replaced only when complete.

    Parameters
    ----------
    path : str or Path
    fields : StaticFields
    digest : str
        Digest of their inputs, if the file is to serve as a cache.
    """

    def fill(file: h5py.File) -> None:
        file.attrs["digest"] = digest
        file.attrs["content"] = _fields_digest(fields)
        file.attrs["families"] = json.dumps(dict(fields.families))
        for name in _FIELD_ARRAYS:
            write_rows(file, name, getattr(fields, name))

    write_whole(Path(path), STATIC_FIELDS, fill)


def load_reduced(path: str | Path, mesh: Mesh | None = None, digest: str | None = None) -> ReducedBody:
    """Read a reduced body.

    Parameters
    ----------
    path : str or Path
        File of `save_reduced`.
    mesh : Mesh, optional
        Required mesh of the file; any mesh if left out.
    digest : str, optional
        Result of `cache.reduction_digest`; the file must have it, if given.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file is broken or not of a reduced body.
    StaleCacheError
        If mesh or digest differ.
    """

    def check(file: h5py.File) -> None:
        if mesh is not None and file.attrs["mesh_digest"] != mesh.digest:
            raise StaleCacheError(f"{path} must belong to this mesh, got that of another one")
        _check_digest(file, path, digest, "this mesh and these parameters")

    return _read_checked(path, REDUCED_BODY, check, lambda file: _body(file, mesh), _content_digest)


def load_fields(path: str | Path, digest: str | None = None) -> StaticFields:
    """Read static fields.

    Parameters
    ----------
    path : str or Path
        File of `save_fields`.
    digest : str, optional
        Digest that the file must have, if given.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file is broken or not of static fields.
    StaleCacheError
        If the digest differs.
    """

    def check(file: h5py.File) -> None:
        _check_digest(file, path, digest, "this body and these loads")

    return _read_checked(path, STATIC_FIELDS, check, _fields, _fields_digest)


def _fields(file: h5py.File) -> StaticFields:
    """Return the static fields of a file."""
    arrays = {name: file[name][()] for name in _FIELD_ARRAYS}
    return StaticFields(json.loads(file.attrs["families"]), **arrays)


def _read_checked(
    path: str | Path,
    kind: str,
    check: Callable[[h5py.File], None],
    read: Callable[[h5py.File], Content],
    content_digest: Callable[[Content], str],
) -> Content:
    """Read the content of a file of a kind after a check of its inputs.

    Raises `ValueError` if the content is not what was written, by its digest.
    """

    def read_all(file: h5py.File) -> Content:
        check(file)
        content = read(file)
        if file.attrs["content"] != content_digest(content):
            raise ValueError(f"{path} must be whole, got content that its digest does not match")
        return content

    return read_whole(Path(path), kind, read_all)


def _check_digest(file: h5py.File, path: str | Path, digest: str | None, inputs: str) -> None:
    """Raise `StaleCacheError` unless a file has a digest of its inputs; None: any will do."""
    if digest is not None and file.attrs["digest"] != digest:
        raise StaleCacheError(f"{path} must be made with {inputs}, got others")


def save_pressures(path: str | Path, pressures: Mapping[str, Floats], digest: str = "") -> None:
    """Write pressures of pins in contact into an HDF5 file, replaced only when complete.

    Parameters
    ----------
    path : str or Path
    pressures : mapping of str to array (f, 2 d)
        By name of the interface, see `pin_contact.PinContact`.
    digest : str
        Digest of their inputs, if the file is to serve as a cache.
    """

    def fill(file: h5py.File) -> None:
        file.attrs["digest"] = digest
        file.attrs["content"] = _pressures_digest(pressures)
        group = file.create_group("pressures")
        for name, array in pressures.items():
            write_rows(group, name, array)

    write_whole(Path(path), PIN_PRESSURES, fill)


def load_pressures(path: str | Path, digest: str | None = None) -> dict[str, Floats]:
    """Read pressures of pins in contact.

    Parameters
    ----------
    path : str or Path
        File of `save_pressures`.
    digest : str, optional
        Digest that the file must have, if given.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file is broken or not of pressures.
    StaleCacheError
        If the digest differs.
    """

    def check(file: h5py.File) -> None:
        _check_digest(file, path, digest, "this body and these bores")

    return _read_checked(path, PIN_PRESSURES, check, _pressures, _pressures_digest)


def _pressures(file: h5py.File) -> dict[str, Floats]:
    """Return the pressures of a file by name."""
    return {name: array[()] for name, array in file["pressures"].items()}


def _pressures_digest(pressures: Mapping[str, Floats]) -> str:
    """Return the SHA-256 of pressures by name."""
    sha = hashlib.sha256()
    for name, array in sorted(pressures.items()):
        sha.update(json.dumps([name, *array.shape]).encode() + np.ascontiguousarray(array).tobytes())
    return sha.hexdigest()


def _fields_digest(fields: StaticFields) -> str:
    """Return the SHA-256 of everything that static fields hold."""
    sha = hashlib.sha256(json.dumps(dict(fields.families)).encode())
    for name in _FIELD_ARRAYS:
        sha.update(np.ascontiguousarray(getattr(fields, name)).data)
    return sha.hexdigest()


def _body(file: h5py.File, mesh: Mesh | None) -> ReducedBody:
    """Return the reduced body of a file, with a mesh in place of the equal one of the file if it is given."""
    stored = file["mesh"]
    body_mesh = mesh or Mesh(
        stored["nodes"][()],
        stored["elements"][()],
        {name: data[()] for name, data in stored["surfaces"].items()},
    )
    return ReducedBody(
        mesh=body_mesh,
        material=Material(**json.loads(file.attrs["material"])),
        interfaces=tuple(
            Interface(
                str(entry.attrs["name"]),
                entry["center"][()],
                entry["nodes"][()],
                entry.attrs["spider"],
            )
            for _, entry in sorted(file["interfaces"].items())
        ),
        mass=float(file.attrs["mass"]),
        surface_weights={name: data[()] for name, data in stored["surface_weights"].items()},
        parameters=json.loads(file.attrs["parameters"]),
        **{name: file[name][()] for name in _ARRAYS},
    )


def _content_digest(body: ReducedBody) -> str:
    """Return the SHA-256 of everything that a reduced body holds."""
    sha = hashlib.sha256(body.mesh.digest.encode())
    interfaces = [(i.name, i.spider, i.center.tolist(), i.nodes.tolist()) for i in body.interfaces]
    described = [asdict(body.material), dict(body.parameters), body.mass, interfaces]
    sha.update(json.dumps(described, sort_keys=True).encode())
    weights = [array for _, array in sorted(body.surface_weights.items())]
    for array in (*(getattr(body, name) for name in _ARRAYS), *weights):
        sha.update(np.ascontiguousarray(array).data)
    return sha.hexdigest()
