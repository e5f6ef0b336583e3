"""Surfaces of the top that may carry the machine, on the ready shoes and on meshes that users bring."""

import numpy as np
import pytest

import fem
import meshes
from meshes import LOAD_SURFACES, STEEL


def same(one: np.ndarray, other: np.ndarray) -> bool:
    return set(map(tuple, one.tolist())) == set(map(tuple, other.tolist()))


@pytest.fixture(scope="module", params=["coarse", "study"])
def shoe(request: pytest.FixtureRequest) -> fem.ElasticBody:
    return fem.ElasticBody(meshes.mesh_named(request.param), STEEL)


def test_areas_and_centroids(shoe: fem.ElasticBody) -> None:
    dimensions = meshes.ShoeDimensions()
    expected = {  # notches take 0.2 m2 off the plateau and off the whole
        "rails": (2 * dimensions.rail_width * dimensions.top_length, 0.0043, 0.0),
        "plateau": (1.0009, -0.0015, -0.0129),
        "whole top": (1.9040, 0.0012, -0.0068),
    }
    for name, (area, x, y) in expected.items():
        weights = shoe.surface_weights(name)
        assert weights.sum() == pytest.approx(area, rel=1e-3)
        centroid = weights @ shoe.mesh.nodes / weights.sum()
        np.testing.assert_allclose(centroid[:2], [x, y], atol=2e-4)


def test_only_the_wings_join_the_whole_top(shoe: fem.ElasticBody) -> None:
    reach = {name: np.abs(shoe.mesh.nodes[shoe.mesh.nodes_of(name), 1]).max() for name in LOAD_SURFACES}
    assert reach == pytest.approx({"rails": 0.35, "plateau": 1.0, "whole top": 3.505 / 2})
    inside = [set(shoe.mesh.nodes_of(name).tolist()) for name in LOAD_SURFACES]
    assert inside[0] < inside[1] < inside[2]
    # neither bottom plate nor lugs
    lug_top = meshes.PIN_HEIGHT + meshes.ShoeDimensions().rear_lug_radius
    assert shoe.mesh.nodes[shoe.mesh.nodes_of("whole top"), 2].min() > lug_top + 0.02


@pytest.fixture(scope="module")
def mesh() -> fem.Mesh:
    return meshes.shoe_mesh("coarse")


def test_the_file_keeps_its_digest(mesh: fem.Mesh) -> None:
    named = meshes.mesh_named("coarse")
    assert set(named.surfaces) - set(mesh.surfaces) == set(LOAD_SURFACES)
    assert fem.Mesh(named.nodes, named.elements, mesh.surfaces).digest == mesh.digest


def test_a_load_on_each_surface_has_its_resultant(shoe: fem.ElasticBody) -> None:
    force = np.array([0.0, 1e3, -386.4e3])
    for name in LOAD_SURFACES:
        load = shoe.surface_load(name, force)
        np.testing.assert_allclose(load.sum(axis=0), force, rtol=1e-9)
        assert not load[np.setdiff1d(np.arange(len(load)), shoe.mesh.nodes_of(name))].any()


def test_a_mesh_without_roller_path_has_the_highest_faces_as_rails(mesh: fem.Mesh) -> None:
    own = fem.Mesh(mesh.nodes, mesh.elements, {"top": mesh.surface("top")})
    assert same(meshes.with_load_surfaces(own).surface("rails"), mesh.surface("roller path"))


def test_surfaces_that_a_mesh_names_itself_stay(mesh: fem.Mesh) -> None:
    own = mesh.with_surfaces({"rails": mesh.surface("top")[:3]})
    named = meshes.with_load_surfaces(own)
    assert same(named.surface("rails"), mesh.surface("top")[:3])
    assert same(named.surface("plateau"), mesh.surface("top"))


def test_a_top_of_one_side_still_has_the_whole_width(mesh: fem.Mesh) -> None:
    top = mesh.surface("top")
    left = top[mesh.nodes[top].mean(axis=1)[:, 1] > 0.0]
    leaning = meshes.with_load_surfaces(mesh.with_surfaces({"top": left}))
    assert same(leaning.surface("plateau"), left)
    assert same(leaning.surface("whole top"), meshes.with_load_surfaces(mesh).surface("whole top"))


def test_what_the_shape_does_not_have_is_left_out(mesh: fem.Mesh) -> None:
    angle = np.radians(45.0)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    leaning = fem.Mesh(mesh.nodes @ turn.T, mesh.elements, {"top": mesh.surface("top")})
    assert set(meshes.with_load_surfaces(leaning).surfaces) == {"top", "plateau"}


def test_a_mesh_without_top_stays_as_it_is(mesh: fem.Mesh) -> None:
    bare = fem.Mesh(mesh.nodes, mesh.elements, {})
    assert meshes.with_load_surfaces(bare) is bare
