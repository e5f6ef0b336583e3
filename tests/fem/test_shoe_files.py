"""The ready shoe in files of other programs: its surfaces are whole there, and its stress is the same."""

import numpy as np
import pytest

import fem
import meshes
from fem.body.surfaces import surface_weights
from tests.fem.bodies import static_stress
from tests.fem.decks import Shells, areas, element_faces, lines_of, solids_text, write_msh41

PRESSURE = 1e5
"""Pa, that the ground presses on the underside with."""
WHOLE = {"whole top": 1.9039, "plateau": 1.0008, "top": 1.0008, "rails": 0.2640, "underside": 2.20815}
"""Areas of the coarse mesh, m2."""


@pytest.fixture(scope="module")
def ready() -> fem.Mesh:
    """The ready file's mesh."""
    return meshes.shoe_mesh("coarse")


@pytest.fixture(scope="module")
def partition(ready) -> fem.Partition:
    return fem.Partition(fem.ElasticBody(ready, meshes.STEEL), meshes.joint_interfaces(ready))


@pytest.fixture(scope="module")
def flange(ready) -> np.ndarray:
    """Faces of the top beside the roller path."""
    path = set(map(tuple, np.sort(ready.surface("roller path")).tolist()))
    top = ready.surface("top")
    return top[[tuple(face) not in path for face in np.sort(top).tolist()]]


def deck_of_sets(ready, path, flange):
    """Sets of shells in blocks that stand apart, with comments within them; the path is a part of the top."""
    shells = Shells(ready, list(ready.surfaces))
    text = solids_text(ready) + shells.text
    for half in (0, 1):
        for name, numbers in shells.numbers.items():
            written = numbers if name == "roller path" and half else numbers[half::2]
            lines = lines_of(written).splitlines()
            text += "\n".join((f'*ELSET, ELSET="{name}"', *lines[:2], "** comment", *lines[2:], ""))
    path.write_text(text)


def deck_of_element_faces(ready, path, flange):
    """Surfaces of element faces, in names as Abaqus allows them without quotes."""
    text = solids_text(ready)
    for name in ready.surfaces:
        faces = element_faces(ready, name)
        word = name.replace(" ", "_").upper()
        for side, numbers in faces.items():
            text += f"*ELSET, ELSET=_{word}_S{side}, INTERNAL\n{lines_of(numbers)}"
        text += f"*SURFACE, TYPE=ELEMENT, NAME={word}\n" + "".join(
            f"_{word}_S{side}, S{side}\n" for side in faces
        )
    path.write_text(text)


def msh_of_several_groups(ready, path, flange):
    """The roller path in two groups, of which the first one is not the top."""
    names = ["roller path", "top", *(name for name in ready.surfaces if name not in ("roller path", "top"))]
    patches = {k: flange if name == "top" else ready.surface(name) for k, name in enumerate(names, start=1)}
    groups = {k: [1, 2] if k == 1 else [k] for k in patches} | {0: [1]}
    named = [(2, k, name) for k, name in enumerate(names, start=1)]
    write_msh41(path, ready, patches, groups, [*named, (3, 1, "underside")], binary=True)


@pytest.fixture(
    scope="module",
    params=[(deck_of_sets, ".inp"), (deck_of_element_faces, ".inp"), (msh_of_several_groups, ".msh")],
    ids=["sets", "faces", "groups"],
)
def written(request, ready, flange, tmp_path_factory) -> fem.Mesh:
    write, suffix = request.param
    path = tmp_path_factory.mktemp("files") / f"shoe{suffix}"
    write(ready, path, flange)
    return meshes.mesh_named(str(path))


def test_surfaces_of_another_programs_file_have_their_areas(written, ready):
    sizes = areas(written)
    assert {name: sizes[name] for name in WHOLE} == pytest.approx(WHOLE, abs=1e-4)
    of_ready = areas(ready)
    assert {name: sizes[name] for name in of_ready} == pytest.approx(of_ready, rel=1e-12)


@pytest.mark.simulation
def test_its_static_stress_is_that_of_the_ready_file(written, partition):
    """The machine's load on the whole top, held up by pressure on the underside."""
    np.testing.assert_array_equal(written.elements, partition.body.mesh.elements)
    pair = (written, meshes.mesh_named("coarse"))
    stresses = [fem.body.element_stress.von_mises(static_stress(partition, _forces(mesh))) for mesh in pair]
    np.testing.assert_allclose(stresses[0], stresses[1], rtol=1e-6, atol=1.0)
    assert stresses[1].max() > 1e6


def _forces(mesh: fem.Mesh) -> np.ndarray:
    """Nodal forces (n, 3), N."""
    under = PRESSURE * surface_weights(mesh, mesh.surface("underside"))
    top = surface_weights(mesh, mesh.surface("whole top"))
    forces = np.zeros_like(mesh.nodes)
    forces[:, 2] = under - under.sum() * top / top.sum()
    return forces.reshape(-1, 1)
