"""Surfaces that are not whole are known by their geometry, whatever file cut them."""

import warnings

import numpy as np
import pytest

import fem
import meshes
from exudyn_crawler import Track
from exudyn_crawler.model.shoe_mesh import pin_interfaces
from fem.body.surface_edges import bore_beyond, boundary_of, flat_beyond
from fem.body.surfaces import surface_weights
from meshes.checks import check_surfaces, check_whole
from meshes.recognition.solids import second_order
from tests.fem.bodies import box_mesh, tube
from tests.fem.refusals import refused
from tests.meshes.solid_shoes import box, occ, rod


def area(mesh: fem.Mesh, faces: np.ndarray) -> float:
    return float(surface_weights(mesh, faces).sum())


def side(mesh: fem.Mesh, axis: int, place: float) -> np.ndarray:
    """Faces of the boundary in a plane across an axis."""
    return mesh.boundary[np.isclose(mesh.nodes[mesh.boundary[:, :3], axis], place, atol=1e-9).all(axis=1)]


@pytest.mark.parametrize("order", [1, 2])
def test_a_flat_goes_on_up_to_its_edges(order):
    box = box_mesh((4, 3, 2), (4.0, 3.0, 2.0), order=order)
    top = side(box, 2, 2.0)
    part = top[(box.nodes[top[:, :3], 0] <= 1.0).all(axis=1)]
    assert area(box, part) == pytest.approx(3.0)
    assert area(box, flat_beyond(boundary_of(box), part)) == pytest.approx(9.0)
    assert len(flat_beyond(boundary_of(box), top)) == 0


@pytest.mark.parametrize(("degrees", "expected"), [(0.05, 2.0), (0.3, 0.0)])
def test_a_flat_ends_where_it_bends(degrees, expected):
    """By an angle such as that of the ready shoe's wings."""
    slope = np.tan(np.radians(degrees))

    def bent(places):
        x, y, z = places.T
        return np.column_stack((x, y, z - slope * np.maximum(x - 1.0, 0.0)))

    box = box_mesh((3, 1, 1), (3.0, 1.0, 1.0), bent)
    part = box.boundary[(box.nodes[box.boundary[:, :3], 2] > 0.9).all(axis=1)]
    part = part[(box.nodes[part[:, :3], 0] <= 1.0).all(axis=1)]
    assert area(box, flat_beyond(boundary_of(box), part)) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("divisions", [8, 24])
@pytest.mark.parametrize("order", [1, 2])
def test_a_bore_goes_on_along_its_axis_and_round_it(order, divisions):
    """Half a tube: its axis is z, what is outside of it looks away from the axis."""
    half = box_mesh((1, divisions, 4), (1.0, 1.0, 2.0), tube(1.0, 1.5, np.pi), order=order)
    radii = np.linalg.norm(half.nodes[half.boundary[:, :3], :2], axis=2)
    bore = half.boundary[np.isclose(radii, 1.0).all(axis=1)]
    heights = half.nodes[bore[:, :3], 2]
    whole = area(half, bore)
    for part, share in ((heights <= 0.5, 0.25), (half.nodes[bore[:, :3], 0] > -1e-9, 0.5)):
        cut = bore[part.all(axis=1)]
        joined, apart = bore_beyond(boundary_of(half), cut, [0.0, 0.0, 1.0])
        assert area(half, cut) == pytest.approx(share * whole)
        assert area(half, joined) == pytest.approx((1.0 - share) * whole)
        assert len(apart) == 0
    ends = bore[((heights <= 0.5) | (heights >= 1.5)).all(axis=1)]
    lowest = ends[(half.nodes[ends[:, :3], 2] <= 0.5).all(axis=1)]
    assert area(half, bore_beyond(boundary_of(half), lowest, [0.0, 0.0, 1.0])[0]) == pytest.approx(
        0.75 * whole
    )
    assert len(bore_beyond(boundary_of(half), bore, [0.0, 0.0, 1.0])[0]) == 0


def pocketed(kind):
    """Mesh of a lug with a bore of 1 along y, over 0..1.2, and of a pad beside that nearly touches it."""
    pad = box((0.98, 2.0), (1.2, 2.0), (-1.5, 0.0))
    body = box((-1.8, 1.8), (0.0, 1.2), (-1.5, 1.8)) + pad - rod((0.0, -0.1, 0.0), "Y", 1.0, 1.35)
    if kind == "round":
        # the pocket's far wall is as near to the bore's
        body -= rod((0.5, 0.6, 0.0), "Z", 0.48, 3.0)
    if kind == "oil hole":
        body -= rod((0.0, 0.6, 0.0), "X", 0.12, 3.0)
    mesh = occ().OCCGeometry(body).GenerateMesh(maxh=2.0, curvaturesafety=1.0, optsteps3d=0)
    mesh.SecondOrder()
    nodes, elements, _ = second_order(mesh)
    return fem.Mesh(nodes, elements, {})


@pytest.mark.parametrize(
    "kind",
    ["flat", pytest.param("round", marks=pytest.mark.slow), pytest.param("oil hole", marks=pytest.mark.slow)],
)
def test_a_bore_is_whole_up_to_the_pockets_and_holes_that_break_into_it(kind):
    mesh = pocketed(kind)
    places = mesh.nodes[mesh.boundary[:, :3]]
    is_bore = (np.abs(np.linalg.norm(places[..., ::2], axis=2) - 1.0) < 1e-3).all(axis=1)
    middle = places.mean(axis=1)
    normals = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])
    looks = np.einsum("kc,kc->k", normals[:, ::2], middle[:, ::2])
    is_bore &= looks < -0.95 * np.linalg.norm(normals, axis=1) * np.linalg.norm(middle[:, ::2], axis=1)
    boundary = boundary_of(mesh)
    joined, apart = bore_beyond(boundary, mesh.boundary[is_bore])
    assert len(joined) == len(apart) == 0
    behind = is_bore & (middle[:, 0] < 0.0)
    joined, apart = bore_beyond(boundary, mesh.boundary[behind])
    assert area(mesh, joined) + area(mesh, apart) == pytest.approx(
        area(mesh, mesh.boundary[is_bore & ~behind]), rel=1e-9
    )


@pytest.fixture(scope="module")
def ready() -> fem.Mesh:
    return meshes.shoe_mesh("coarse")


def middles(mesh: fem.Mesh, name: str) -> np.ndarray:
    return mesh.nodes[mesh.surface(name)[:, :3]].mean(axis=1)


def cut(mesh: fem.Mesh, name: str, remaining: np.ndarray) -> fem.Mesh:
    return meshes.with_load_surfaces(mesh.with_surfaces({name: mesh.surface(name)[remaining]}))


@pytest.mark.parametrize("file", ["shoe_coarse.msh.gz", "shoe_study.msh.gz", "shoe_overhang_25mm.msh.gz"])
def test_ready_shoes_are_whole(file):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_whole(meshes.mesh_named(str(meshes.shoe_path().with_name(file))))


def test_an_underside_or_a_bore_that_is_cut_is_refused_with_what_is_left_out(ready):
    under = middles(ready, "underside")
    words = (
        r"'underside' of the mesh 'x', 1.401 m2, ends inside a flat, of which it leaves out 0.8075 m2, at \["
    )
    refused(words, check_whole, cut(ready, "underside", under[:, 0] < 0.1), "x", error=fem.MeshError)
    for name in meshes.JOINT_CENTERS:
        bore = middles(ready, f"bore {name}")
        words = f"'bore {name}' of the mesh, .* ends inside the bore, .*name all of it in the program"
        for remaining in (np.arange(len(bore)) > 0, bore[:, 2] < meshes.PIN_HEIGHT):
            refused(words, check_whole, cut(ready, f"bore {name}", remaining), error=fem.MeshError)


def test_a_cheek_without_a_name_and_a_top_without_its_flange_are_warned_of(ready):
    y = middles(ready, "bore front right")[:, 1]
    with pytest.warns(
        fem.MeshWarning, match=r"axis of .*'bore front right' .* lies a part .* 0.0364\d m2"
    ) as caught:
        check_whole(cut(ready, "bore front right", y < y.mean()))
    assert len(caught) == 1
    with pytest.warns(fem.MeshWarning, match="'whole top' .* is 0.7 m wide on a shoe of 3.5 m"):
        check_whole(meshes.with_load_surfaces(ready.with_surfaces({"top": ready.surface("roller path")})))
    with pytest.warns(fem.MeshWarning, match="'top' .* ends inside a flat, of which it leaves out 0.5"):
        check_whole(cut(ready, "top", np.arange(len(ready.surface("top"))) % 2 == 0))


def test_a_bore_without_a_name_is_left_to_its_pin(ready):
    surfaces = {name: faces for name, faces in ready.surfaces.items() if name != "bore rear left"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_whole(fem.Mesh(ready.nodes, ready.elements, surfaces))


def test_a_file_of_a_cut_surface_is_refused_when_it_is_read(tmp_path, ready):
    fem.write_mesh(tmp_path / "cut.msh", cut(ready, "underside", middles(ready, "underside")[:, 0] < 0.1))
    refused(
        "the mesh '.*cut.msh', .*a flat", meshes.mesh_named, str(tmp_path / "cut.msh"), error=fem.MeshError
    )


def test_names_are_known_in_other_spellings_and_not_twice(ready):
    spelt = {
        "UNDERSIDE": "underside",
        "Top": "top",
        "bore-rear_LEFT": "bore rear left",
        "Rollerpath": "roller path",
    }
    surfaces = {name: ready.surface(known) for name, known in spelt.items()}
    named = meshes.with_load_surfaces(
        fem.Mesh(ready.nodes, ready.elements, surfaces | {"Mine": ready.boundary})
    )
    assert set(named.surfaces) == {*spelt.values(), *meshes.LOAD_SURFACES, "Mine"}
    twice = ready.with_surfaces({"TOP": ready.surface("top")})
    refused("one surface 'top', got 'top' and 'TOP'", meshes.with_load_surfaces, twice, error=fem.MeshError)


def test_a_missing_surface_is_refused_with_what_the_file_left_out(ready):
    notes = ("node sets do not say which faces are a surface, so that these are left out: 'underside'",)
    bare = fem.Mesh(ready.nodes, ready.elements, {}, notes)
    words = "'x' must have the surface 'underside', which has none; node sets do not say which faces"
    refused(words, check_surfaces, bare, "whole top", "x")
    words = "'x' must have the surface 'bore front right', which has none; node sets do not say"
    refused(words, pin_interfaces, bare, "x", Track.ph4100c())
