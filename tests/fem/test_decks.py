"""Decks as programs write them: a surface is read whole, or left out with its reason, never in part."""

import re

import numpy as np
import pytest

import fem
from tests.fem.bodies import box_mesh
from tests.fem.decks import (
    SHELLS,
    Shells,
    areas,
    element_faces,
    elements_text,
    lines_of,
    nodes_text,
    same_faces,
    solids_text,
)
from tests.fem.refusals import refused

AREAS = {"top": 2.0, "path": 1.0, "underside": 2.0}
"""m2, of the box's surfaces; the path is half of the top."""


@pytest.fixture(scope="module")
def box() -> fem.Mesh:
    """Box of 2 x 1 x 1 m with its upper and lower side named."""
    mesh = box_mesh((2, 1, 1), (2.0, 1.0, 1.0))
    corners = mesh.nodes[mesh.boundary[:, :3]]
    top = np.isclose(corners[:, :, 2], 1.0).all(axis=1)
    path = top & (corners[:, :, 0].max(axis=1) <= 1.0)
    underside = np.isclose(corners[:, :, 2], 0.0).all(axis=1)
    chosen = {"top": top, "path": path, "underside": underside}
    return mesh.with_surfaces({name: mesh.boundary[faces] for name, faces in chosen.items()})


@pytest.fixture(scope="module")
def shells(box) -> Shells:
    return Shells(box, ["top", "path", "underside"])


def read(folder, text: str) -> fem.Mesh:
    path = folder / "shoe.inp"
    path.write_text(text, encoding="utf-8")
    return fem.read_mesh(path)


def sets_text(shells: Shells) -> str:
    """A block for each set."""
    return "".join(f"*ELSET, ELSET={name}\n{lines_of(numbers)}" for name, numbers in shells.numbers.items())


def assert_whole(mesh: fem.Mesh, box: fem.Mesh) -> None:
    """Same nodes, elements and faces of all surfaces as the box."""
    np.testing.assert_array_equal(mesh.nodes, box.nodes)
    np.testing.assert_array_equal(mesh.elements, box.elements)
    assert areas(mesh) == pytest.approx(AREAS)
    assert all(same_faces(mesh, name, box) for name in AREAS)


def in_two_blocks(box, shells):
    """Sets in two blocks each, with comments within blocks and between them."""
    text = solids_text(box) + shells.text
    for half in (0, 1):
        for name, numbers in shells.numbers.items():
            body = lines_of(numbers[half::2], 1).replace("\n", "\n** comment\n")
            text += f"** {name}\n*ELSET, ELSET={name}\n** first\n{body}"
    return text


def of_shells_in_two_blocks(box, shells):
    """Sets of the blocks of elements themselves, of which each set has two."""
    text = solids_text(box)
    first = SHELLS
    for half in (0, 1):
        for name in ("path", "underside", "rest"):
            faces = box.surface("top" if name == "rest" else name)
            if name == "rest":
                faces = faces[(box.nodes[faces[:, :3], 0] >= 1.0).all(axis=1)]
            text += f"*ELEMENT, TYPE=S6, ELSET={name}\n{elements_text(faces[half::2], first)}"
            first += len(faces[half::2])
    return f"{text}*ELSET, ELSET=top\npath, rest\n*ELSET,ELSET=unused\n{first - 1},\n"


def of_sets(box, shells):
    """Sets of sets, defined after they are named, and sets beside numbers in one line."""
    path = shells.numbers["path"]
    rest = sorted(set(shells.numbers["top"]) - set(path))
    return (
        f"{solids_text(box)}{shells.text}*ELSET, ELSET=top\npath, {', '.join(map(str, rest))}\n"
        f"*ELSET, ELSET=path\nearlier\nlater\n*ELSET, ELSET=earlier\n{lines_of(path[:1])}"
        f"*ELSET, ELSET=later\n{lines_of(path[1:])}"
        f"*ELSET, ELSET=underside\n{lines_of(shells.numbers['underside'])}"
    )


def generated(box, shells):
    """Several lines of GENERATE, with and without a step, and beyond the last element."""
    text = solids_text(box) + shells.text
    for name, numbers in shells.numbers.items():
        ranges = "".join(f"{number}, {number}\n" for number in numbers[:-1])
        text += f"*Elset, elset={name}, generate\n{ranges}{numbers[-1]}, {numbers[-1]}, 1\n"
    return f"{text}*ELSET, ELSET=everything else, GENERATE\n900000, 999999999, 1\n"


def of_element_faces(box, shells):
    """Surfaces of faces of elements, by their numbers, by element sets and by another surface."""
    text = solids_text(box)
    for name in ("underside", "path"):
        faces = element_faces(box, name)
        for side, numbers in faces.items():
            text += f"*Elset, elset=_{name}_S{side}, internal\n{lines_of(numbers)}"
        text += f"*Surface, type=ELEMENT, name={name}\n"
        text += "".join(f"_{name}_S{side}, S{side}\n" for side in faces)
    path = {(side, number) for side, numbers in element_faces(box, "path").items() for number in numbers}
    text += "*SURFACE, NAME=rest\n"
    for side, numbers in element_faces(box, "top").items():
        text += "".join(f"{number}, s{side}\n" for number in numbers if (side, number) not in path)
    return f"{text}*SURFACE, NAME=top, COMBINE=UNION\nrest, path\n"


def of_shells_as_surfaces(box, shells):
    return (
        f"{solids_text(box)}{shells.text}{sets_text(shells).replace('ELSET=', 'ELSET=s_')}"
        "*SURFACE, NAME=top\ns_top, SPOS\n*SURFACE, NAME=path\ns_path, SNEG\n"
        "*SURFACE, NAME=underside\ns_underside\n"
    )


def in_other_spellings(box, shells):
    """Keywords, types and names in any case, quoted and with blanks; lines that go on."""
    text = f"*Heading\n made, by hand\n* node , nset = All\n{nodes_text(box)}"
    text += f'*element, type="c3d10mh",\nelset=Solid\n{elements_text(box.elements)}'
    text += shells.text.replace("STRI65", "cps6")
    for name, numbers in shells.numbers.items():
        half = len(numbers) // 2
        text += f'*elset,elset="{name}"\n{lines_of(numbers[:half])}'
        text += f"*ELSET , ELSET = {name.upper()} , UNSORTED\n{lines_of(numbers[half:])}"
    return text


def with_nodes_apart(box, shells):
    """Nodes and elements in two blocks, comments among them, coordinates left out, pilot nodes, beams."""
    lines = nodes_text(box).replace(", 0.0\n", "\n").replace(", 0.0, ", ", , ").splitlines()
    nodes = "\n** comment\n".join(lines[10:])
    return (
        "*NODE\n{}\n** pilot\n*NODE, NSET=pilot\n900001, 5., 5., 5.\n900002, 5D0, 5E+0\n*NODE\n{}\n"
        "*ELEMENT, TYPE=MASS, ELSET=pilot\n900001, 900001\n*ELEMENT, TYPE=B32\n900002, 900001,\n900002, 1\n"
        "*ELEMENT, TYPE=C3D10\n{}** comment\n{}{}{}*SUBMODEL, INPUT=none.frd\n"
        "*MATERIAL, NAME=steel\n*ELASTIC\n2.1E11, 0.3\n"
    ).format(
        "\n".join(lines[:10]),
        nodes,
        elements_text(box.elements[:5]).replace(", ", ",").replace(",", ",\n", 5),
        "*ELEMENT, TYPE=C3D10I\n" + elements_text(box.elements[5:], 6),
        shells.text,
        sets_text(shells),
    )


def with_one_name_for_a_volume_and_a_surface(box, shells):
    text = solids_text(box).replace("TYPE=C3D10", "TYPE=C3D10, ELSET=top")
    return f"{text}{shells.text}{sets_text(shells)}"


def with_linear_shells(box, shells):
    return f"{solids_text(box)}{Shells(corners_alone(box), list(AREAS), 'S3R').text}{sets_text(shells)}"


def corners_alone(box: fem.Mesh) -> fem.Mesh:
    """Stands for the mesh where only its surfaces' corners are asked for."""
    return type("Corners", (), {"surface": staticmethod(lambda name: box.surface(name)[:, :3])})()


def in_a_part(box, shells):
    """As Abaqus/CAE writes it: a part, an instance of it that is moved and turned, sets of the assembly."""
    top = shells.numbers["top"]
    return (
        "*Part, name=Shoe\n{}{}*Elset, elset=top\n{}*End Part\n"
        "*Part, name=Pin\n*Node\n1, 0., 0., 0.\n*End Part\n"
        "*Assembly, name=Assembly\n*Instance, name=Pin-1, part=Pin\n*End Instance\n"
        "*Instance, name=Shoe-1, part=Shoe\n-5., 0.\n*End Instance\n*Node\n1, 9., 9., 9.\n"
        "*Elset, elset=top, instance=Shoe-1\n{}*Elset, elset=underside, instance=Shoe-1\n{}"
        "*Elset, elset=path\n{}*End Assembly\n"
    ).format(
        solids_text(fem.Mesh(box.nodes + np.array([5.0, 0.0, 0.0]), box.elements, {})),
        shells.text,
        lines_of(top[:3]),
        lines_of(top[3:]),
        lines_of(shells.numbers["underside"]),
        "".join(f"Shoe-1.{number}\n" for number in shells.numbers["path"]),
    )


WRITERS = [
    in_two_blocks,
    of_shells_in_two_blocks,
    of_sets,
    generated,
    of_element_faces,
    of_shells_as_surfaces,
    in_other_spellings,
    with_nodes_apart,
    with_one_name_for_a_volume_and_a_surface,
    with_linear_shells,
    in_a_part,
]


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
def test_surfaces_of_a_deck_are_whole(tmp_path, box, shells, write):
    mesh = read(tmp_path, write(box, shells))
    assert_whole(fem.Mesh(mesh.nodes, mesh.elements, {name: mesh.surface(name) for name in AREAS}), box)


def test_elements_of_the_other_sense_are_turned(tmp_path, box, shells):
    """Programs differ in it; the faces of an element are numbered by its own sense."""
    turned = np.arange(len(box.elements)) % 3 == 0
    elements = np.where(turned[:, None], box.elements[:, fem.files.mesh_content.TURNED], box.elements)
    raw = type("Raw", (), {"nodes": box.nodes, "elements": elements, "surface": box.surface})()
    text = f"{solids_text(raw)}*SURFACE, NAME=top\n"
    for side, numbers in element_faces(raw, "top").items():
        text += "".join(f"{number}, S{side}\n" for number in numbers)
    mesh = read(tmp_path, text)
    np.testing.assert_array_equal(mesh.elements, box.elements)
    assert same_faces(mesh, "top", box)
    assert mesh.notes == (
        f"{turned.sum()} of {len(elements)} elements are numbered in the other sense and were turned",
    )


def test_elements_that_are_turned_inside_out_are_refused(tmp_path, box):
    """Not turned: a node in the wrong place, here beyond the opposite side of the box."""
    nodes = box.nodes.copy()
    corner = int(np.argmax(nodes @ [1.0, 2.0, 4.0]))
    nodes[corner] -= [0.0, 0.0, 3.0]
    raw = type("Raw", (), {"nodes": nodes, "elements": box.elements})()
    refused(
        r"must not be inverted, got \d+ of .* the first is at \[",
        read,
        tmp_path,
        solids_text(raw),
        error=fem.MeshError,
    )


def test_a_turned_instance_is_where_the_assembly_has_it(tmp_path, box):
    """Moved by (1, 0, 0), then turned by 90 degrees about an axis along z through (1, 0)."""
    text = f"*PART, NAME=p\n{solids_text(box)}*END PART\n*INSTANCE, NAME=i, PART=p\n1., 0., 0.\n"
    mesh = read(tmp_path, f"{text}1., 0., 0., 1., 0., 5., 90.\n*END INSTANCE\n")
    x, y, z = box.nodes.T
    np.testing.assert_allclose(mesh.nodes, np.column_stack((1.0 - y, x, z)), atol=1e-12)


def test_included_files_are_read_beside_the_deck(tmp_path, box, shells):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "nodes.txt").write_text(f"** made by hand\n{nodes_text(box)}")
    (tmp_path / "parts" / "mesh.inp").write_text(
        f"*NODE, INPUT=parts/nodes.txt\n*ELEMENT, TYPE=C3D10\n{elements_text(box.elements)}{shells.text}"
    )
    mesh = read(tmp_path, f'*INCLUDE, INPUT="parts\\mesh.inp"\n{sets_text(shells)}')
    assert_whole(mesh, box)


LEFT_OUT = {
    "a set lists an element that is not there": (
        "*ELSET, ELSET=top\n{top}777777,\n",
        "it lists elements that the deck does not have: 777777",
    ),
    "a set names a set that is not there": (
        "*ELSET, ELSET=top\n{top}more\n",
        "it names the set 'more', which the deck does not have",
    ),
    "sets hold each other": ("*ELSET, ELSET=top\n{top}more\n*ELSET, ELSET=more\ntop\n", "holds itself"),
    "quadrangles are among its shells": (
        "*ELSET, ELSET=top\n{top}800001,\n*ELEMENT, TYPE=S8R\n800001, 1, 2, 3, 4, 5, 6, 7,\n8\n",
        "elements of the type S8R; mesh it with triangles",
    ),
    "a shell lies within the body": (
        "*ELEMENT, TYPE=S3, ELSET=top\n800001, {inside}\n*ELSET, ELSET=top\n{top}",
        "1 of its 5 faces are no faces of the boundary",
    ),
    "a face is none of a tetrahedron": (
        "*SURFACE, NAME=top\n1, S5\n*ELSET, ELSET=top\n{top}",
        "it has the face S5 of an element of the type C3D10",
    ),
    "a surface is made of nodes": (
        "*ELSET, ELSET=top\n{top}*SURFACE, NAME=top, TYPE=NODE\nall\n",
        "its nodes do not say",
    ),
}


@pytest.mark.parametrize("case", LEFT_OUT)
def test_what_cannot_be_read_whole_is_left_out_with_a_warning(tmp_path, box, shells, case):
    lines, reason = LEFT_OUT[case]
    inside = ", ".join(str(node + 1) for node in next(iter(interior_faces(box))))
    text = lines.format(top=lines_of(shells.numbers["top"]), inside=inside)
    with pytest.warns(fem.MeshWarning, match=f"shoe.inp: surfaces are left out, 'top': .*{reason}"):
        mesh = read(
            tmp_path,
            f"{solids_text(box)}{shells.text}{sets_text(shells).replace('ELSET=top', 'ELSET=s')}{text}",
        )
    assert set(mesh.surfaces) == {"s", "path", "underside"}
    assert mesh.notes[0].startswith("surface 'top' is left out: ")


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("COMBINE=DIFFERENCE\na, b\n", r"it must list faces of elements \(shoe.inp, line \d+\)"),
        ("TYPE=NODE\nall\n", "its nodes do not say which faces it has"),
        ("TYPE=ELEMENT\n1, S5\n", "it has the face S5 of an element of the type C3D10"),
    ],
)
def test_a_surface_without_any_face_is_noted(tmp_path, box, lines, reason):
    """Contact of other bodies has such ones."""
    mesh = read(tmp_path, f"{solids_text(box)}*SURFACE, NAME=contact, {lines}")
    (note,) = mesh.notes
    assert re.match(f"surface 'contact' is left out: {reason}", note)


def interior_faces(mesh: fem.Mesh) -> set[tuple[int, ...]]:
    """Corners, ascending, of faces between two elements."""
    faces = np.sort(mesh.elements[:, fem.body.mesh.TETRA_FACES[:, :3]].reshape(-1, 3), axis=1)
    return set(map(tuple, faces.tolist())) - set(map(tuple, np.sort(mesh.boundary[:, :3], axis=1).tolist()))


ONE = "*NODE\n1, 0.\n*ELEMENT, TYPE=C3D4\n"
"""Deck of a node, up to its elements."""
REFUSED = {
    "*NGEN, NSET=x\n1, 2\n": r"one by one, got \*NGEN \(shoe.inp, line 1\); let the program write",
    "*NODE, SYSTEM=C\n1, 0., 0., 0.\n": "Cartesian coordinates",
    "*NODE\n1, 0., 0., 0.\n*NODE\n1, 0., 0., 1.\n": r"got node 1 at two \(shoe.inp, line 3\)",
    "*NODE\n1, 0., x, 0.\n": r"\(shoe.inp, line 1\) must follow the syntax of Abaqus: could not convert",
    "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3\n": r"must have 4 nodes for each element, got 4 numbers",
    f"{ONE}1, 1, 2, 3, 4\n": "nodes of elements of the type C3D4 must be in the deck, which lacks 2, 3, 4",
    f"{ONE}1, 1, 2, 3, 4\n1, 4, 3, 2, 1\n": "got element 1 twice",
    "*INCLUDE, INPUT=none.inp\n": r"'none.inp', which the deck includes, must be in the same folder \(",
    "*INCLUDE, INPUT=shoe.inp\n": "must not include each other",
    "*INCLUDE\n": "must have INPUT=file",
    "*HEADING\nnothing\n": r"a deck must have \*NODE and \*ELEMENT",
    "\0\1": "a deck must be text",
    "*ELSET, ELSET=x, GENERATE\n1, 9, 0\n": r"\*ELSET .* must not be zero",
    "*ELSET\n1\n": r"\*ELSET \(shoe.inp, line 1\) must have a name, ELSET=",
    "*SURFACE, TYPE=ELEMENT\n1, S1\n": r"\*SURFACE \(shoe.inp, line 1\) must have a name, NAME=",
    "*INSTANCE, NAME=j\n*END INSTANCE\n*ELSET, ELSET=x, INSTANCE=i\n1\n": "must have the instance 'i'",
    ONE.replace("D4", "D8R") + "1, 1, 1, 1, 1, 1, 1, 1, 1\n": "must hold tetrahedra .* got 1 hexahedron",
}


@pytest.mark.parametrize("text", REFUSED)
def test_decks_that_cannot_be_read_say_where_and_what_to_do(tmp_path, text):
    refused(rf"shoe.inp.*{REFUSED[text]}", read, tmp_path, text, error=fem.MeshError)


def test_several_bodies_are_refused_by_their_names(tmp_path, box):
    part = "*PART, NAME={0}\n" + solids_text(box).replace("{", "") + "*END PART\n"
    refused(
        "one part with tetrahedra, got 'a', 'b'",
        read,
        tmp_path,
        part.format("a") + part.format("b"),
        error=fem.MeshError,
    )
    twice = "*INSTANCE, NAME=i, PART=a\n*END INSTANCE\n*INSTANCE, NAME=j, PART=a\n*END INSTANCE\n"
    refused(
        "one instance of the body, got 'i', 'j'",
        read,
        tmp_path,
        part.format("a") + twice,
        error=fem.MeshError,
    )


def test_what_a_mesh_does_not_need_is_noted(tmp_path, box, shells):
    mesh = read(tmp_path, with_nodes_apart(box, shells))
    assert mesh.notes == (
        "node sets do not say which faces are a surface, so that these are left out: 'pilot'",
        "2 nodes belong to no solid element and are left out",
        "1 elements of the kind MASS are left out",
        "1 elements of the kind B32 are left out",
    )
