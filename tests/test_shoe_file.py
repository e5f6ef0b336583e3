"""A maker's file becomes a case that runs and checks read without editing."""

import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import fem
import meshes
from exudyn_crawler import LoadCycle, Shoe, read_case, recover_stresses, simulate
from exudyn_crawler.case import statics
from exudyn_crawler.cli import looking
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.model.shoe_mesh import pin_interfaces
from exudyn_crawler.results.checks import cases
from exudyn_crawler.results.history.summary import HELD, key_results
from exudyn_crawler.results.stress.hot_spots import peak_spots
from exudyn_crawler.shoe_file import MARK, shoe_name, shoe_of, write_shoe
from meshes import mesh_named
from meshes.recognition.axes import Choices
from meshes.undersides import ground_outline
from tests.meshes.swept import FORK, SweptShoe
from tests.meshes.test_shoe_files import written


@pytest.fixture(scope="module")
def fork(tmp_path_factory):
    """Shoe of a fork, as its file in mm gives it, and the paths of what was written."""
    folder = tmp_path_factory.mktemp("fork")
    nodes, tets = SweptShoe(facets=12).mesh()
    shoe = shoe_of(written(folder / "fork.vtu", nodes, [("tetra", tets)]))
    return shoe, write_shoe(shoe, folder)


def test_the_case_has_what_follows_from_the_shape(fork):
    shoe, paths = fork
    case_file = read_case(paths["case"])
    case, mesh = case_file.case, mesh_named(case_file.case.flexible.mesh)
    assert case.track.pitch == pytest.approx(0.25, abs=1e-9)
    assert case.track.joint_centers["rear left"] - case.track.joint_centers["rear right"] == pytest.approx(
        [0.0, 0.2, 0.0]
    )
    body = fem.ElasticBody(mesh, fem.Material(200e9, 0.3, case.flexible.density))
    assert case.shoe.mass == pytest.approx(body.mass, rel=1e-9)
    assert case.shoe.inertia[0] == pytest.approx(body.inertia[0, 0], rel=1e-8)
    assert (case.shoe.length, case.shoe.width) == pytest.approx((0.23, 0.7))
    rails = case.shoe.rails
    assert (rails.front - rails.rear, rails.left - rails.right, rails.width) == pytest.approx(
        (0.13, 0.2, 0.04)
    )
    assert case.flexible.static_fields
    assert [one.name for one in pin_interfaces(mesh, "fork", case.track)] == list(case.track.joint_centers)
    assert shoe.refusals == ()


def test_what_no_shape_gives_is_marked(fork):
    text = fork[1]["case"].read_text(encoding="utf-8")
    marked = {line.partition(" = ")[0] for line in text.splitlines() if line.endswith(MARK)}
    assert marked == {"youngs_modulus", "poissons_ratio", "density", "shoe_count", "first_com", "loads"}


def test_the_table_has_the_first_frequencies_and_the_pitch(fork):
    table = fork[0].table.set_index("quantity")["value"]
    assert table["pitch"] == "250.000"
    assert table["front bores"].startswith("4 of radius 18.000")
    assert float(table["first free-free frequencies"].split(",")[0]) > 100.0
    assert table["rails"] == "two"


def test_a_shoe_with_a_piece_on_a_hinge_is_refused(tmp_path):
    nodes, tets = SweptShoe(facets=8).mesh()
    # an edge at the plate's end, about which the piece turns
    at_end = np.flatnonzero((np.abs(nodes[:, 1] - nodes[:, 1].max()) < 1e-6) & (nodes[:, 2] < 20.5))
    edge = at_end[np.lexsort((nodes[at_end, 0], -nodes[at_end, 2]))[:2]]
    piece = np.array([(0.0, 60.0, 0.0), (0.0, 60.0, 40.0)]) + nodes[edge].mean(axis=0)
    corners = np.concatenate((edge, len(nodes) + np.arange(2)))
    points = np.vstack((nodes, piece))
    if np.linalg.det(points[corners[1:]] - points[corners[0]]) < 0.0:
        corners = corners[[1, 0, 2, 3]]
    path = written(tmp_path / "hinge.vtu", points, [("tetra", np.vstack((tets, corners)))])
    with pytest.raises(
        fem.MeshError, match=r"hinge\.vtu: the mesh must be one stiff body, .* edges or corners"
    ):
        shoe_of(path)


def test_any_case_takes_the_mesh_as_its_shoe(fork):
    shoe, paths = fork
    expected = shoe.case_file.case
    path = paths["mesh"].parent / "taken.toml"
    path.write_text(
        'base = "translation"\nloads = 2e4\n[shoe]\nmesh = "fork.msh.gz"\nload_point = [0.0, 0.01, 0.05]\n'
        '[flexible]\nbase = "ph4100c"\nshoes = [7]\n'
    )
    case = read_case(path).case
    assert case.shoe == Shoe.from_mesh(str(paths["mesh"])).with_(load_point=(0.0, 0.01, 0.05))
    assert case.track.pitch == pytest.approx(expected.track.pitch, abs=1e-6)
    for joint, center in expected.track.joint_centers.items():
        np.testing.assert_allclose(case.track.joint_centers[joint], center, atol=1e-5)
    assert case.flexible.mesh == str(paths["mesh"])
    assert case.flexible.static_fields
    assert len(pin_interfaces(shoe.mesh, "fork", case.track)) == 4


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('mesh = "none.msh"', "shoe.mesh must be one of coarse, study, fine or a file, got 'none.msh'"),
        ('base = "ph4100c"\nmesh = "coarse"', "shoe.base must be left out beside shoe.mesh"),
    ],
)
def test_meshes_that_are_no_shoes_of_a_case_are_refused(tmp_path, text, words):
    path = tmp_path / "mine.toml"
    path.write_text(f'base = "translation"\n[shoe]\n{text}\n')
    with pytest.raises(CaseFileError, match=words):
        read_case(path)


def test_files_that_exist_are_not_replaced(fork):
    shoe, paths = fork
    before = paths["mesh"].read_bytes()
    with pytest.raises(FileExistsError, match=r"fork\.msh\.gz exists"):
        write_shoe(shoe, paths["mesh"].parent)
    assert paths["mesh"].read_bytes() == before


def test_a_case_is_checked_on_its_own_track_with_forces_of_its_loads(fork):
    check = cases.read_check(fork[1]["case"])
    case = read_case(fork[1]["case"]).case
    assert check.track == case.track
    assert check.machine == pytest.approx(statics.mean_load(case) / 386.4e3, rel=1e-2)
    assert [one.force / check.machine for one in check.levels] == pytest.approx([388e3, 574e3, 761e3])
    outline = cases.ShoeOutline.of(mesh_named(check.mesh))
    assert outline.beside == pytest.approx(0.7 / 3.505)
    names = [one.name for one in cases.ready_cases(outline, 1e5, check.machine)]
    assert f"both ends {0.2 * outline.beside:.3g} m" in names
    assert len(set(names)) == len(names)


def test_a_shoe_without_rails_has_its_load_on_the_top(tmp_path):
    nodes, tets = SweptShoe(facets=12, rails=False).mesh()
    shoe = shoe_of(written(tmp_path / "bare.vtu", nodes, [("tetra", tets)]))
    assert shoe.case_file.case.shoe.rails is None
    outline = cases.ShoeOutline.of(shoe.mesh)
    ready = cases.ready_cases(outline, 1e5)
    assert not any(one.treads for one in ready)
    even = next(one for one in ready if one.name == "even, sand")
    assert even.pressures[0].force == (0.0, 0.0, -2e5)
    # what a case presses with beside is no reason for the machine to leave the shoe
    turns = [case for case in ready if case.name.startswith("turn")]
    strikes = [case for case in ready if case.name.startswith("strike")]
    assert len(turns) == 6
    assert all(case.pressures[0] == even.pressures[0] for case in (*turns, *strikes))


@pytest.mark.parametrize(
    "own",
    [
        SweptShoe(facets=12, front=FORK[::3], rear=((-115.0, -75.0), (75.0, 115.0))),
        SweptShoe(
            facets=12,
            front=((-195.0, -125.0), (-35.0, 35.0), (125.0, 195.0)),
            rear=((-115.0, -45.0), (45.0, 115.0)),
        ),
    ],
    ids=["side by side", "three and two"],
)
def test_joints_in_gaps_and_parted_bores_are_accepted(tmp_path, own):
    nodes, tets = own.mesh()
    shoe = shoe_of(written(tmp_path / "lugs.vtu", nodes, [("tetra", tets)]))
    assert shoe.refusals == ()
    interfaces = pin_interfaces(shoe.mesh, "lugs", shoe.case_file.case.track)
    every = np.concatenate([one.nodes for one in interfaces])
    assert len(every) == len(np.unique(every))
    assert all(len(one.nodes) >= 12 for one in interfaces)


@pytest.fixture(scope="module")
def grousers(tmp_path_factory):
    """Shoe with a grouser, on its plate and on its tips."""
    nodes, tets = SweptShoe(facets=8, grouser=True).mesh()
    path = written(tmp_path_factory.mktemp("grouser") / "grouser.vtu", nodes, [("tetra", tets)])
    return shoe_of(path), shoe_of(path, Choices(footprint="tips"))


@pytest.mark.slow
def test_grousers_turn_static_fields_off_and_ask(grousers):
    plate, tips = grousers
    assert any("--footprint tips decides" in line for line in plate.lines())
    assert not plate.case_file.case.flexible.static_fields
    assert plate.case_file.case.shoe.length == pytest.approx(0.23)
    # a grouser that is sunk in presses with the plate
    assert plate.case_file.case.shoe.ground_area == pytest.approx(0.23 * 0.7)
    assert tips.case_file.case.shoe.length == pytest.approx(0.02)
    assert tips.case_file.case.shoe.com_height - plate.case_file.case.shoe.com_height == pytest.approx(0.04)
    assert tips.case_file.case.loads == plate.case_file.case.loads


@pytest.mark.parametrize("on_cells", [False, True], ids=["units", "cells"])
def test_a_resting_shoe_presses_with_its_weight_over_tips_or_plate(grousers, on_cells):
    pressures = []
    for shoe, area in zip(grousers, (0.23 * 0.7, 0.02 * 0.7), strict=True):
        case = shoe.case_file.case.with_({"shoe.rails": None, "flexible": None})
        case = case.with_(track=case.track.with_(shoe_count=2), loads=LoadCycle.constant(3e3, 2))
        case = case.on_cells(BekkerSoil.lete_sand()) if on_cells else case
        rest = simulate(case, 0.002, progress=False)
        weight = case.loads.phases[0].loads[0] + case.shoe.mass * case.gravity
        pressure = rest.quantity("ground_pressure").isel(time=0).values
        assert pressure.mean() == pytest.approx(weight / area, rel=1e-3)
        assert rest.dataset.area.isel(time=0).sum() == pytest.approx(2.0 * area, rel=1e-3)
        pressures.append(pressure.mean())
    assert pressures[1] / pressures[0] == pytest.approx(0.23 / 0.02, rel=2e-2)


def test_an_underside_whose_lugs_stand_between_the_neighbours_is_a_rectangle_of_its_area(tmp_path):
    nodes, tets = SweptShoe(facets=8, standing=True).mesh()
    shoe = shoe_of(written(tmp_path / "standing.vtu", nodes, [("tetra", tets)]))
    assert any("longer than the pitch" in line for line in shoe.lines())
    of_case = read_case(write_shoe(shoe, tmp_path)["case"]).case
    # four lugs of 40 mm ahead of the plate and two behind it, 50 mm long
    lugs = 4 * 0.04 * 0.05, 2 * 0.04 * 0.05
    area = 0.23 * 0.7 + sum(lugs)
    assert of_case.shoe.ground_area == pytest.approx(area)
    assert of_case.shoe.width == pytest.approx(0.7)
    assert of_case.shoe.length == pytest.approx(area / 0.7)
    assert of_case.shoe.length < of_case.track.pitch
    middle = (lugs[0] - lugs[1]) * 0.14 / area
    com = of_case.track.pin_ahead - 0.125  # of the plate's middle from the COM
    assert of_case.shoe.underside_center[0] == pytest.approx(com + middle)
    assert shoe.refusals == ()
    case = of_case.with_({"shoe.rails": None, "flexible": None})
    case = case.with_(track=case.track.with_(shoe_count=2), loads=LoadCycle.constant(3e3, 2))
    rest = simulate(case, 0.002, progress=False)
    weight = 3e3 + case.shoe.mass * case.gravity
    pressure = rest.quantity("ground_pressure").isel(time=0).values
    assert pressure.mean() == pytest.approx(weight / area, rel=1e-3)


def test_a_file_whose_whole_name_is_an_ending_is_refused():
    with pytest.raises(
        ValueError, match=r"\.step: the file must have a name before its ending, such as shoe\.step"
    ):
        shoe_of(".step")
    assert shoe_name(Path("a/my.shoe.step")) == "my"


def test_grousers_at_a_plates_edges_belong_to_its_rectangle():
    x = (-0.15, -0.12, 0.12, 0.15)
    mesh = strips(x[:2], x[2:])
    corners = mesh.nodes[mesh.boundary[:, :3]]
    down = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] < 0.0
    plate = down & (np.abs(corners[..., 2]) < 1e-9).all(axis=1)
    tips = mesh.surface("underside")
    with_edges = ground_outline(mesh.with_surfaces({"underside": np.vstack((mesh.boundary[plate], tips))}))
    np.testing.assert_allclose((with_edges.low, with_edges.high), [(-0.15, -0.25), (0.15, 0.25)])
    assert (with_edges.level, with_edges.share, with_edges.strip_length) == (0.0, 1.0, 0.0)
    assert ground_outline(mesh).level == pytest.approx(-0.03)


def strips(*ends):
    """Mesh of a plate of 0.3 x 0.5 m on strips between such x, whose underside are the strips' tips."""
    x = np.unique([-0.15, 0.15, *np.ravel(ends)])
    corners = []
    for low, high in itertools.pairwise(x):
        corners.append((low, high, 0.0, 0.02))
        if any(start <= low and high <= end for start, end in ends):
            corners.append((low, high, -0.03, 0.0))
    parts = []
    for low, high, bottom, top in corners:
        box = np.array(list(itertools.product((low, high), (-0.25, 0.25), (bottom, top))))
        parts.append(
            box[[[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]]
        )
    places = np.concatenate(parts).reshape(-1, 3)
    nodes, numbers = np.unique(places.round(9), axis=0, return_inverse=True)
    mesh = fem.Mesh(nodes, numbers.reshape(-1, 4)[:, [1, 0, 2, 3]], {})
    below = (mesh.nodes[mesh.boundary[:, :3]][..., 2] < -0.0299).all(axis=1)
    return mesh.with_surfaces({"underside": mesh.boundary[below]})


def test_strips_of_an_underside_are_measured():
    of_mesh = ground_outline(strips((-0.14, -0.12), (-0.01, 0.01), (0.1, 0.13)))
    assert of_mesh.strip_length == pytest.approx(0.07 / 3.0)
    assert of_mesh.share == pytest.approx(0.07 / 0.27)
    single = ground_outline(strips((-0.02, 0.02)))
    assert (single.strip_length, single.share) == (0.0, 1.0)


@pytest.mark.slow
def test_the_ready_shoe_keeps_mass_and_frequencies_in_millimetres():
    ready = meshes.shoe_mesh("coarse")
    own = Shoe.from_mesh("coarse")
    assert own.rails is not None
    from meshes.recognition.shoe import FileSolid, recognize_solid

    found = recognize_solid(FileSolid(1e3 * ready.nodes[:, [1, 2, 0]], ready.elements, None, {}), Choices())
    shoe = Shoe.from_mesh(found.mesh)
    assert shoe.mass == pytest.approx(own.mass, rel=1e-9)
    assert shoe.inertia == pytest.approx(own.inertia, rel=1e-6, abs=1e-3)
    assert shoe.rails.width == pytest.approx(own.rails.width)
    bodies = [fem.ElasticBody(mesh, meshes.STEEL).natural_frequencies(9)[6:] for mesh in (ready, found.mesh)]
    np.testing.assert_allclose(*bodies, rtol=1e-6)


@pytest.mark.slow
def test_flexible_shoes_with_lugs_in_between_run(tmp_path):
    lugs = SweptShoe(
        facets=12,
        front=((-195.0, -125.0), (-35.0, 35.0), (125.0, 195.0)),
        rear=((-115.0, -45.0), (45.0, 115.0)),
    )
    nodes, tets = lugs.mesh()
    path = written(tmp_path / "lugs.vtu", nodes, [("tetra", tets)])
    case_file = read_case(write_shoe(shoe_of(path), tmp_path)["case"])
    history = simulate(case_file.case, 0.01, progress=False)
    stresses = recover_stresses(history)
    spots = stresses.hot_spots[7]
    peaks = stresses.dataset.peak_von_mises.sel(shoe=7)
    is_held = stresses.dataset.in_spider
    usable = float(peaks.where(~is_held).max())
    held = float(peaks.where(is_held).max())
    assert (spots["flag"].iloc[:5] != "in spider").all()
    assert spots["value"].iloc[0] == pytest.approx(usable)
    # a higher one beside a rigid ring is named behind what may be used
    assert len(spots) == 5 + (held > usable)
    results = key_results(history, stresses.dataset).set_index("result")["value"]
    assert results["highest von Mises stress"] == pytest.approx(usable / 1e6)
    assert (HELD in results) == (held > usable)
    # the ground carries the shoe of weight and load
    carried = history.over_time(["contact_force"])["contact_force"]
    weight = case_file.case.shoe.mass * case_file.case.gravity + statics.mean_load(case_file.case)
    assert float(carried.isel(time=0).sel(shoe=7, axis="z")) == pytest.approx(weight, rel=0.05)


@pytest.mark.slow
def test_closed_tracks_of_the_ready_shoe_and_of_its_file_in_millimetres_are_the_same(tmp_path):
    ready = meshes.shoe_mesh("coarse")
    points = 1e3 * ready.nodes[:, [1, 2, 0]]
    path = written(tmp_path / "turned.vtu", points, [("tetra10", ready.elements)])
    write_shoe(shoe_of(path), tmp_path)
    rests = []
    for mesh in ("coarse", "turned.msh.gz"):
        closed = tmp_path / "closed.toml"
        closed.write_text(
            f'base = "closed"\n[shoe]\nmesh = "{mesh}"\n[flexible]\nbase = "ph4100c"\nshoes = [5]\n'
            "fixed_modes = 10\nrecovered_modes = 20\nstatic_fields = false\n"
        )
        history = simulate(read_case(closed).case, 0.01, progress=False)
        stress = recover_stresses(history).dataset
        rests.append((history.joint_force.values, float(stress.highest_von_mises.max())))
    size = np.abs(rests[0][0]).max()
    np.testing.assert_allclose(rests[1][0], rests[0][0], atol=0.01 * size)
    assert rests[1][1] == pytest.approx(rests[0][1], rel=0.01)


@pytest.mark.slow
def test_check_of_a_makers_file_makes_its_case_first(tmp_path, monkeypatch, capsys):
    checked = []

    def noted(file, *_places, **_options):
        checked.append(file)
        raise KeyboardInterrupt

    monkeypatch.setattr("exudyn_crawler.check_cases", noted)
    nodes, tets = SweptShoe(facets=8, grouser=True).mesh()
    path = written(tmp_path / "maker.vtu", nodes, [("tetra", tets)])
    with pytest.raises(KeyboardInterrupt):
        looking.check(file=path, footprint="tips", out=tmp_path / "out")
    assert checked == [tmp_path / "out" / "maker.toml"]
    case = read_case(checked[0]).case
    assert case.track.pitch == pytest.approx(0.25, abs=1e-9)
    assert case.shoe.length == pytest.approx(0.02)
    assert (tmp_path / "out" / "maker.png").stat().st_size > 10_000
    assert "underside that presses │ tips" in " ".join(capsys.readouterr().out.split())
    with pytest.raises(ValueError, match=r"must go with a maker's file, got .*maker\.toml"):
        looking.check(file=checked[0], footprint="tips", out=tmp_path / "out")


def spots(*rows):
    return pd.DataFrame(rows, columns=["value", "flag"])


def test_a_place_in_a_spider_is_named_behind_the_first_that_may_be_used():
    by_shoe = {7: spots((9.0, "in spider"), (5.0, "")), 8: spots((8.0, "in spider"), (6.0, ""))}
    found = peak_spots(by_shoe)
    assert [(words, shoe, spot["value"].iloc[0]) for words, (shoe, spot) in found.items()] == [
        ("peak stress", 8, 6.0),
        ("higher beside a pin coupling, not to be used", 7, 9.0),
    ]
    assert list(peak_spots({7: spots((9.0, ""), (5.0, "in spider"))})) == ["peak stress"]
    assert list(peak_spots({7: spots((9.0, "in spider"))})) == [
        "higher beside a pin coupling, not to be used"
    ]
