"""Shoes of other dimensions, meshed by netgen where it is installed."""

import sys

import numpy as np
import pytest

import fem
import meshes
from exudyn_crawler import Shoe
from meshes import STEEL, ShoeDimensions
from meshes.build_shoe import main, straighten_distorted
from tests.meshes.test_shoe import assert_bores_at_pins

THICKER = 0.010


@pytest.fixture(scope="module")
def thicker() -> fem.ElasticBody:
    pytest.importorskip("netgen")
    dimensions = ShoeDimensions(top_thickness=ShoeDimensions.top_thickness + THICKER)
    return fem.ElasticBody(meshes.mesh_shoe(dimensions, "coarse"), STEEL)


@pytest.mark.slow
def test_a_thicker_top_plate_weighs_what_its_steel_does(thicker: fem.ElasticBody) -> None:
    ready = fem.ElasticBody(meshes.shoe_mesh("coarse"), STEEL)
    shoe = ShoeDimensions()
    # beside the web, which is solid below the plate, less what the notches take
    beside = shoe.top_length * shoe.width - shoe.beam_length * 2.0 * shoe.plateau_half_width
    most = STEEL.density * THICKER * beside
    assert 0.5 * most < thicker.mass - ready.mass < most
    assert thicker.center_of_mass[2] > ready.center_of_mass[2]


@pytest.mark.slow
def test_a_shoe_of_netgen_has_surfaces_bores_and_underside_where_the_ready_one_has_them(
    thicker: fem.ElasticBody,
) -> None:
    mesh, ready = thicker.mesh, meshes.shoe_mesh("coarse")
    assert set(mesh.surfaces) == set(ready.surfaces)
    assert mesh.elements.shape[1] == 10
    both = (thicker, fem.ElasticBody(ready, STEEL))
    for name in ready.surfaces:
        area, ready_area = (body.surface_weights(name).sum() for body in both)
        assert area == pytest.approx(ready_area, rel=0.05 if name.startswith("bore") else 1e-3)
    assert_bores_at_pins(mesh)


@pytest.mark.slow
def test_the_command_writes_a_mesh_that_a_case_takes_and_refuses_what_makes_no_shoe(tmp_path, capsys) -> None:
    pytest.importorskip("netgen")
    main([str(tmp_path / "wide.msh.gz"), "--size", "coarse", "--rail-width", "0.24"])
    assert Shoe.from_mesh(str(tmp_path / "wide.msh.gz")).rails.width == pytest.approx(0.24)
    # rails level with the flange
    with pytest.raises(SystemExit):
        main([str(tmp_path / "no.msh"), "--rail-height", str(ShoeDimensions.beam_height)])
    assert "must leave faces for all named surfaces, got none for ['flange']" in capsys.readouterr().err
    assert not (tmp_path / "no.msh").exists()


@pytest.mark.slow
def test_overhang_core_and_wear_take_the_steel_that_they_say() -> None:
    pytest.importorskip("netgen")
    shoe = ShoeDimensions(rail_overhang=0.132, wear=0.025, core_wall=0.06)
    mesh = meshes.mesh_shoe(shoe, "coarse")
    ready = meshes.shoe_mesh("coarse")
    path = mesh.nodes[mesh.nodes_of("roller path")]
    np.testing.assert_allclose(path[:, 2] + meshes.COM_HEIGHT, shoe.path_height)
    assert np.ptp(path[:, 0]) == pytest.approx(shoe.top_length)
    worn = 2 * shoe.top_length * shoe.rail_width * shoe.wear
    # from the plate up to the overhang, four ends; the web's walls and roots of lugs are none of it
    free = shoe.rail_height - shoe.rail_depth - shoe.plate_thickness
    below = 4 * shoe.rail_overhang * shoe.rail_width * free
    long, tall = shoe.beam_length - 2 * shoe.core_wall, shoe.rail_height - shoe.core_roof - 0.096
    pockets = long * tall * (2 * shoe.plateau_half_width - 7 * shoe.core_wall)
    assert ready.volume - mesh.volume == pytest.approx(worn + below + pockets, rel=0.03)


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
def test_bad_dimensions_are_refused(name, value, words) -> None:
    with pytest.raises(ValueError, match=f"{name} must be {words}"):
        ShoeDimensions(**{name: value})


def test_bad_sizes_are_refused_before_netgen_is_asked_for() -> None:
    with pytest.raises(ValueError, match=r"size must be one of .*, got 'huge'"):
        meshes.mesh_shoe(size="huge")


def test_without_netgen_it_is_told_how_to_get_it(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "netgen", None)
    with pytest.raises(ModuleNotFoundError, match=r"needs netgen: pip install 'exudyn-crawler\[mesh\]'"):
        meshes.mesh_shoe()


def test_an_element_that_a_curved_edge_turns_inside_out_gets_straight_edges() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    middles = corners[fem.mesh.TETRA_EDGES].mean(axis=1)
    elements = np.arange(10)[None]
    bent = np.vstack((corners, middles))
    bent[4] += (0.0, 0.6, 0.6)
    nodes, count = straighten_distorted(bent, elements)
    assert count == 1
    np.testing.assert_allclose(nodes[4:], middles)
    assert straighten_distorted(nodes, elements)[1] == 0
