"""Ready meshes meet what the papers say of the shoe; their surfaces; shoes of other dimensions, by netgen."""

import sys

import numpy as np
import pytest

import fem
import meshes
from exudyn_crawler import Shoe
from fem.body.distortion import straighten_distorted
from meshes import LOAD_SURFACES, STEEL, ShoeDimensions
from meshes.build_shoe import main
from meshes.geometry import NODES, VOLUMES
from tests.small_shoe import SMALL_SHOE

THICKER = 0.010


@pytest.fixture(scope="module", params=["coarse", "study"])
def shoe(request):
    return fem.ElasticBody(meshes.mesh_named(request.param), STEEL)


@pytest.fixture(scope="module")
def mesh():
    return meshes.shoe_mesh("coarse")


@pytest.mark.parametrize("size", meshes.SHOE_SIZES)
def test_volumes_and_nodes_are_those_of_the_files(size):
    assert list(VOLUMES) == list(NODES) == list(meshes.SHOE_SIZES)
    mesh = meshes.shoe_mesh(size)
    assert mesh.volume == pytest.approx(VOLUMES[size], rel=1e-12)
    assert len(mesh.nodes) == NODES[size]


def test_mass_and_center(shoe):
    assert shoe.mass == pytest.approx(4489.63, rel=0.01)
    assert np.abs(shoe.center_of_mass[:2]).max() < 0.002
    assert 0.2025 * 0.99 <= shoe.center_of_mass[2] + meshes.COM_HEIGHT <= 0.204 * 1.01


def assert_bores_at_pins(mesh):
    """Bores have the radius and middles of the pins; distances of their nodes from the axes."""
    distances = []
    for name, center in meshes.JOINT_CENTERS.items():
        bore = mesh.nodes[mesh.nodes_of(f"bore {name}")]
        distances.append(np.hypot(bore[:, 0] - center[0], bore[:, 2] - center[2]))
        assert np.median(distances[-1]) == pytest.approx(ShoeDimensions.bore_radius, abs=1e-6)
        assert (bore[:, 1].min() + bore[:, 1].max()) / 2 == pytest.approx(center[1], abs=1e-6)
    return distances


def test_bores_are_where_the_pins_are(shoe):
    for distance in assert_bores_at_pins(shoe.mesh):
        # mid-side nodes leave the arc only where an edge was straightened: a sixth of a circle at most
        assert distance.min() > np.cos(np.pi / 6) * ShoeDimensions.bore_radius


def test_pins_of_neighbours_coincide():
    for side in ("left", "right"):
        front, rear = (np.array(meshes.JOINT_CENTERS[f"{end} {side}"]) for end in ("front", "rear"))
        np.testing.assert_allclose(front - rear, [meshes.PITCH, 0, 0], atol=1e-12)
        assert front[1] + 9.2901 == pytest.approx({"right": 8.68, "left": 10.03}[side])


def test_underside_is_flat_and_as_wide_as_the_paper_says(shoe):
    under = shoe.mesh.nodes[shoe.mesh.nodes_of("underside")]
    np.testing.assert_allclose(under[:, 2], -meshes.COM_HEIGHT, atol=1e-9)
    assert np.ptp(under[:, 1]) == pytest.approx(3.505)
    assert shoe.surface_weights("underside").sum() == pytest.approx(3.505 * 0.63)


def test_named_surfaces(shoe):
    names = {"underside", "top", "roller path", *LOAD_SURFACES, *(f"bore {n}" for n in meshes.JOINT_CENTERS)}
    assert set(shoe.mesh.surfaces) == names
    path, top = (
        set(map(tuple, np.sort(shoe.mesh.surface(name)).tolist())) for name in ("roller path", "top")
    )
    assert path < top
    weights = shoe.surface_weights("top")
    centroid = weights @ shoe.mesh.nodes / weights.sum()
    assert np.abs(centroid[:2]).max() < 0.015


@pytest.mark.simulation
def test_neighbours_do_not_overlap():
    # not the coarse mesh: its chords cut more than the clearances off throat and nose
    mesh = meshes.shoe_mesh("study")
    corners, low, high = mesh.nodes[mesh.elements[:, :4]], mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    for pitch in (meshes.PITCH, -meshes.PITCH):
        points = mesh.nodes[mesh.surface_nodes] + [pitch, 0.0, 0.0]
        points = points[((points > low) & (points < high)).all(axis=1)]
        assert len(points) > 100
        near = corners[
            (corners.max(axis=1) > points.min(axis=0)).all(axis=1)
            & (corners.min(axis=1) < points.max(axis=0)).all(axis=1)
        ]
        frames = np.linalg.inv((near[:, 1:] - near[:, :1]).transpose(0, 2, 1))
        for chunk in np.array_split(points, max(1, len(points) // 200)):
            local = np.einsum("eij,epj->epi", frames, chunk[None] - near[:, :1])
            inside = (local > 1e-6).all(axis=2) & (local.sum(axis=2) < 1 - 1e-6)
            assert not inside.any()


@pytest.mark.slow
def test_study_and_fine_mesh_bend_at_178_hz():
    for size in ("study", "fine"):
        found = fem.ElasticBody(meshes.shoe_mesh(size), STEEL).natural_frequencies(7)[6]
        assert found == pytest.approx(178.07, rel=0.02)


def test_the_small_mesh_has_mass_and_first_mode_of_the_shoe(mesh):
    small, ready = (fem.ElasticBody(one, STEEL) for one in (meshes.mesh_named(SMALL_SHOE), mesh))
    assert small.mass == pytest.approx(ready.mass, rel=0.02)
    assert small.natural_frequencies(7)[6] == pytest.approx(178.07, rel=0.02)


def same(one, other):
    return set(map(tuple, one.tolist())) == set(map(tuple, other.tolist()))


def test_areas_and_centroids(shoe):
    expected = {  # notches take 0.2 m2 off the plateau and off the whole
        "rails": (2 * ShoeDimensions.rail_width * ShoeDimensions.top_length, 0.0043, 0.0),
        "plateau": (1.0009, -0.0015, -0.0129),
        "whole top": (1.9040, 0.0012, -0.0068),
    }
    for name, (area, x, y) in expected.items():
        weights = shoe.surface_weights(name)
        assert weights.sum() == pytest.approx(area, rel=1e-3)
        centroid = weights @ shoe.mesh.nodes / weights.sum()
        np.testing.assert_allclose(centroid[:2], [x, y], atol=2e-4)


def test_only_the_wings_join_the_whole_top(shoe):
    reach = {name: np.abs(shoe.mesh.nodes[shoe.mesh.nodes_of(name), 1]).max() for name in LOAD_SURFACES}
    assert reach == pytest.approx({"rails": 0.35, "plateau": 1.0, "whole top": 3.505 / 2})
    inside = [set(shoe.mesh.nodes_of(name).tolist()) for name in LOAD_SURFACES]
    assert inside[0] < inside[1] < inside[2]
    # neither bottom plate nor lugs
    lug_top = meshes.PIN_HEIGHT + ShoeDimensions.rear_lug_radius
    assert shoe.mesh.nodes[shoe.mesh.nodes_of("whole top"), 2].min() > lug_top + 0.02


@pytest.mark.parametrize("size", ["coarse", "study"])
def test_the_file_keeps_its_digest(size):
    mesh, named = meshes.shoe_mesh(size), meshes.mesh_named(size)
    assert set(named.surfaces) - set(mesh.surfaces) == set(LOAD_SURFACES)
    assert fem.Mesh(named.nodes, named.elements, mesh.surfaces).digest == mesh.digest


def test_a_load_on_each_surface_has_its_resultant(shoe):
    force = np.array([0.0, 1e3, -386.4e3])
    for name in LOAD_SURFACES:
        load = shoe.surface_load(name, force)
        np.testing.assert_allclose(load.sum(axis=0), force, rtol=1e-9)
        assert not load[np.setdiff1d(np.arange(len(load)), shoe.mesh.nodes_of(name))].any()


def test_a_mesh_without_roller_path_has_the_highest_faces_as_rails(mesh):
    own = fem.Mesh(mesh.nodes, mesh.elements, {"top": mesh.surface("top")})
    assert same(meshes.with_load_surfaces(own).surface("rails"), mesh.surface("roller path"))


def test_surfaces_that_a_mesh_names_itself_stay(mesh):
    named = meshes.with_load_surfaces(mesh.with_surfaces({"rails": mesh.surface("top")[:3]}))
    assert same(named.surface("rails"), mesh.surface("top")[:3])
    assert same(named.surface("plateau"), mesh.surface("top"))


def test_a_top_of_one_side_still_has_the_whole_width(mesh):
    top = mesh.surface("top")
    left = top[mesh.nodes[top].mean(axis=1)[:, 1] > 0.0]
    leaning = meshes.with_load_surfaces(mesh.with_surfaces({"top": left}))
    assert same(leaning.surface("plateau"), left)
    assert same(leaning.surface("whole top"), meshes.with_load_surfaces(mesh).surface("whole top"))


def test_what_the_shape_does_not_have_is_left_out(mesh):
    angle = np.radians(45.0)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    leaning = fem.Mesh(mesh.nodes @ turn.T, mesh.elements, {"top": mesh.surface("top")})
    assert set(meshes.with_load_surfaces(leaning).surfaces) == {"top", "plateau"}
    # nor is there anything without a top
    bare = fem.Mesh(mesh.nodes, mesh.elements, {})
    assert meshes.with_load_surfaces(bare) is bare


@pytest.fixture(scope="module")
def thicker():
    pytest.importorskip("netgen")
    dimensions = ShoeDimensions(top_thickness=ShoeDimensions.top_thickness + THICKER)
    return fem.ElasticBody(meshes.mesh_shoe(dimensions, "coarse"), STEEL)


@pytest.mark.slow
def test_a_thicker_top_plate_weighs_what_its_steel_does(thicker, mesh):
    ready, shoe = fem.ElasticBody(mesh, STEEL), ShoeDimensions()
    # beside the web, which is solid below the plate, less what the notches take
    beside = shoe.top_length * shoe.width - shoe.beam_length * 2.0 * shoe.plateau_half_width
    most = STEEL.density * THICKER * beside
    assert 0.5 * most < thicker.mass - ready.mass < most
    assert thicker.center_of_mass[2] > ready.center_of_mass[2]


@pytest.mark.slow
def test_a_shoe_of_netgen_has_surfaces_bores_and_underside_where_the_ready_one_has_them(thicker, mesh):
    assert set(thicker.mesh.surfaces) == set(mesh.surfaces)
    assert thicker.mesh.elements.shape[1] == 10
    both = (thicker, fem.ElasticBody(mesh, STEEL))
    for name in mesh.surfaces:
        area, ready_area = (body.surface_weights(name).sum() for body in both)
        assert area == pytest.approx(ready_area, rel=0.05 if name.startswith("bore") else 1e-3)
    assert_bores_at_pins(thicker.mesh)


@pytest.mark.slow
def test_the_command_writes_a_mesh_that_a_case_takes_and_refuses_what_makes_no_shoe(tmp_path, capsys):
    pytest.importorskip("netgen")
    main([str(tmp_path / "wide.msh.gz"), "--size", "coarse", "--rail-width", "0.24"])
    assert Shoe.from_mesh(tmp_path / "wide.msh.gz").rails.width == pytest.approx(0.24)
    # rails level with the flange
    with pytest.raises(SystemExit):
        main([str(tmp_path / "no.msh"), "--rail-height", str(ShoeDimensions.beam_height)])
    assert "must leave faces for all named surfaces, got none for ['flange']" in capsys.readouterr().err
    assert not (tmp_path / "no.msh").exists()


@pytest.mark.slow
def test_overhang_core_and_wear_take_the_steel_that_they_say(mesh):
    pytest.importorskip("netgen")
    shoe = ShoeDimensions(rail_overhang=0.132, wear=0.025, core_wall=0.06)
    changed = meshes.mesh_shoe(shoe, "coarse")
    path = changed.nodes[changed.nodes_of("roller path")]
    np.testing.assert_allclose(path[:, 2] + meshes.COM_HEIGHT, shoe.path_height)
    assert np.ptp(path[:, 0]) == pytest.approx(shoe.top_length)
    worn = 2 * shoe.top_length * shoe.rail_width * shoe.wear
    # from the plate up to the overhang, four ends; the web's walls and roots of lugs are none of it
    free = shoe.rail_height - shoe.rail_depth - shoe.plate_thickness
    below = 4 * shoe.rail_overhang * shoe.rail_width * free
    long, tall = shoe.beam_length - 2 * shoe.core_wall, shoe.rail_height - shoe.core_roof - 0.096
    pockets = long * tall * (2 * shoe.plateau_half_width - 7 * shoe.core_wall)
    assert mesh.volume - changed.volume == pytest.approx(worn + below + pockets, rel=0.03)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("top_thickness", -0.05, r"a positive length in m, got -0\.05"),
        ("top_thickness", 50.0, r"at most 10 m, got 50\.0"),
        ("top_thickness", 5.0, r"less than the 0\.3555 m .*, got 5\.0"),
        ("rail_overhang", 0.14, "at most 0.132 m"),
        ("rail_overhang", -0.01, "positive or zero"),
        ("wear", 0.03, "less than 0.03 m"),
        ("core_wall", 0.084, "less than 0.084 m"),
        ("core_roof", 0.4, "less than 0.39 m"),
    ],
)
def test_bad_dimensions_are_refused(name, value, words):
    with pytest.raises(ValueError, match=f"{name} must be {words}"):
        ShoeDimensions(**{name: value})


@pytest.mark.parametrize("of_size", [meshes.shoe_path, lambda size: meshes.mesh_shoe(size=size)])
def test_bad_sizes_are_refused_before_netgen_is_asked_for(of_size):
    with pytest.raises(ValueError, match=r"size must be one of .*, got 'huge'"):
        of_size("huge")


def test_without_netgen_it_is_told_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "netgen", None)
    with pytest.raises(
        ModuleNotFoundError, match="needs netgen, which is not installed: pip install netgen-mesher"
    ):
        meshes.mesh_shoe()


def test_an_element_that_a_curved_edge_turns_inside_out_gets_straight_edges():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    middles = corners[fem.body.mesh.TETRA_EDGES].mean(axis=1)
    elements = np.arange(10)[None]
    bent = np.vstack((corners, middles))
    bent[4] += (0.0, 0.6, 0.6)
    nodes, count = straighten_distorted(bent, elements)
    assert count == 1
    np.testing.assert_allclose(nodes[4:], middles)
    assert straighten_distorted(nodes, elements)[1] == 0
