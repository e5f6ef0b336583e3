"""Shoes of datasheets: ready ones that fit, meshes of one's own, flexible ones."""

import dataclasses

import numpy as np
import pytest

import fem
from exudyn_crawler.case import Shoe, Track
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet import figures, library, shoe_mesh
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.ledger import case_ledger
from exudyn_crawler.machines.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.model import shoe_mesh as fits
from meshes import PITCH, STEEL, checks, fitted, grouser, mesh_named
from meshes.recognition import quality

pytest.importorskip("netgen")


def sheet_of(machine):
    """Datasheet of a machine of the library."""
    return read_case(library.machines()[machine]).datasheet


@pytest.fixture(scope="module")
def excavator(tmp_path_factory):
    """Ready shoe of the Komatsu PC300LC-8 in a file, and its datasheet."""
    sheet = sheet_of("pc300lc")
    follows = derived(sheet)
    path = tmp_path_factory.mktemp("shoe") / "shoe.msh.gz"
    fem.write_mesh(path, shoe_mesh.fitted_shoe(sheet, follows.case.shoe, follows.chain, "coarse").mesh)
    return path, sheet


@pytest.mark.parametrize(
    "shoe",
    [
        grouser.GrouserShoe(3.7, 3, 0.167, 0.09, 0.275, 0.665, 0.42, 0.28),
        grouser.GrouserShoe(2.45, 1, 0.35, 0.11, 0.275, 0.665, 0.42, 0.28),
        grouser.GrouserShoe(4.0, 0, 0.0, 0.14, 0.275, 0.665, 0.42, 0.28),
    ],
)
def test_solids_of_links_are_even_and_have_the_volume_of_plate_and_grousers_beside_their_links(shoe):
    from netgen import occ

    body = grouser.build_grouser_solid(occ, shoe)
    wider = grouser.build_grouser_solid(occ, dataclasses.replace(shoe, width=shoe.width + 1.0))
    tip, root = grouser.STOUTNESS.get(shoe.grousers, (0.0, 0.0))
    section = grouser.PLATE * shoe.plate_thickness + shoe.grousers * shoe.grouser_height * 0.5 * (tip + root)
    assert (wider.mass - body.mass) / grouser.REFERENCE**3 == pytest.approx(section, rel=1e-6)
    assert body.center.y == pytest.approx(0.0, abs=1e-6)


def axis_of(nodes):
    """X of the axis of a bore's corner nodes, on a circle in the x-z plane, by least squares."""
    x, z = nodes[:, 0], nodes[:, 2]
    solution, *_ = np.linalg.lstsq(np.column_stack((x, z, np.ones_like(x))), x**2 + z**2, rcond=None)
    return 0.5 * solution[0]


def least_quality(kind):
    """Shape of elements that a ready shoe has at least: the mining shoe as the papers' coarse mesh."""
    return 0.95 * quality.mesh_quality(mesh_named("coarse")).least if kind == "mining" else 0.08


@pytest.mark.parametrize(("thickness", "floor"), [(0.077, None), (0.078, 0.048), (0.1, 0.07), (0.15, 0.0726)])
def test_a_plate_is_notched_below_the_fillets_of_lugs_or_not_at_all(thickness, floor):
    """Lugs of 0.17 pitches about pins at 0.275 with fillets of 0.0224."""
    shoe = grouser.GrouserShoe(2.63, 3, 0.167, thickness, 0.275, 0.665, 0.42, 0.28)
    assert shoe.notch_floor == (floor if floor is None else pytest.approx(floor))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("machine", "kind"),
    [
        ("pc300lc", "double grouser"),
        ("d155ax", "single grouser"),
        ("bg28", "plain"),
        ("ph4100c", "mining"),
        ("cat315c", "triple grouser"),
    ],
)
def test_ready_shoes_have_pitch_width_and_weight_of_machines_of_the_library(machine, kind):
    sheet = sheet_of(machine).with_(shoe_kind=kind)
    follows = derived(sheet)
    shoe = follows.case.shoe
    mesh = shoe_mesh.fitted_shoe(sheet, shoe, follows.chain, "coarse").mesh
    assert mesh.volume * STEEL.density == pytest.approx(shoe.mass, rel=0.01)
    assert np.ptp(mesh.nodes[:, 1]) == pytest.approx(sheet.shoe_width, rel=1e-6)
    assert quality.mesh_quality(mesh).least > least_quality(kind)
    checks.check_whole(fitted.Mesh(mesh.nodes, mesh.elements, mesh.surfaces))
    corners = np.unique(mesh.elements[:, :4])
    front, rear = (
        axis_of(mesh.nodes[np.intersect1d(mesh.nodes_of(f"bore {end} left"), corners)])
        for end in ("front", "rear")
    )
    assert front - rear == pytest.approx(follows.chain.pitch, abs=1e-9)


@pytest.mark.slow
def test_a_machine_follows_from_the_mesh_of_its_shoes(excavator):
    path, sheet = excavator
    case = derived(sheet.with_(shoe_mesh=str(path))).case
    mesh = mesh_named(str(path))
    of_mesh = Shoe.from_mesh(mesh, STEEL.density)
    assert case.shoe == of_mesh
    assert of_mesh.mass == pytest.approx(derived(sheet).case.shoe.mass, rel=0.01)
    assert figures.machine_mass(case) == pytest.approx(sheet.operating_weight, rel=1e-9)
    # the same wheels: pins, rails and plate are where boxes have them
    assert case.gear.idler.place == pytest.approx(derived(sheet).case.gear.idler.place, abs=2e-3)
    assert figures.lengths(case, sheet)[1] == pytest.approx(sheet.crawler_length, rel=0.02)
    assert len(fits.pin_interfaces(mesh, str(path), case.track)) == 4
    fits.check_fit(mesh, str(path), case.shoe, case.shoe.rails)


@pytest.mark.slow
def test_plate_of_a_ready_shoe_bends_as_a_beam_and_no_part_hangs_loose(excavator):
    path, sheet = excavator
    mesh = mesh_named(str(path))
    body = fem.ElasticBody(mesh, STEEL)
    modes = body.natural_frequencies(8)
    assert np.abs(modes[:6]).max() < 1e-3 * modes[6]
    # wings: cantilevers of plate and three grousers beyond the links, Bernoulli's beam
    pitch = derived(sheet).chain.pitch
    under = mesh.nodes[mesh.nodes_of("underside"), 2].min()
    thickness = np.ptp(mesh.nodes[mesh.nodes_of("underside"), 2]) + (
        mesh.nodes[mesh.nodes_of("whole top"), 2].min() - under
    )
    height = 0.036
    tip, root = (part * pitch for part in grouser.STOUTNESS[3])
    # strips along z of plate and grousers
    z = np.linspace(-height, thickness, 4001)
    width = np.where(z > 0.0, grouser.PLATE * pitch, 3.0 * (root + (tip - root) * -z / height))
    area = np.trapezoid(width, z)
    middle = np.trapezoid(width * z, z) / area
    second = np.trapezoid(width * (z - middle) ** 2, z)
    length = sheet.shoe_width
    # free-free beam of the whole width without links is softer, one that is stiff between them is stiffer
    slender = (
        (4.73 / length) ** 2 * np.sqrt(STEEL.youngs_modulus * second / (STEEL.density * area)) / 2 / np.pi
    )
    assert 0.6 * slender < modes[6] < 1.1 * slender


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "pitch", "width"),
    [
        ("triple grouser", 0.456, 1.2),
        ("plain", 0.3, 1.2),
        ("mining", 0.5, 1.4),
        ("single grouser", 0.26, 0.61),
    ],
)
def test_shoes_of_other_machines_are_meshed_without_slivers(kind, pitch, width):
    """A step of a millimetre in the solid would have four times as many nodes."""
    machine = {"plain": "crane", "mining": "shovel", "single grouser": "dozer"}.get(kind, "excavator")
    mass = 1e3 * (pitch / 0.066) ** 3
    sheet = Datasheet(
        kind=machine,
        operating_weight=mass,
        gauge=3.0 * width,
        shoe_width=width,
        length_on_ground=16.0 * pitch,
        pitch=pitch,
    )
    follows = derived(sheet)
    mesh = shoe_mesh.fitted_shoe(sheet, follows.case.shoe, follows.chain, "coarse").mesh
    assert mesh.volume * STEEL.density == pytest.approx(follows.case.shoe.mass, rel=0.01)
    assert len(mesh.nodes) < 25_000
    assert quality.mesh_quality(mesh).least > least_quality(kind)


def test_weights_that_no_plate_makes_are_refused_in_the_datasheets_words():
    sheet = sheet_of("pc300lc").with_(shoe_weight=20.0)
    follows = derived(sheet)
    words = (
        r"a triple grouser shoe of 216 mm pitch and 800 mm width cannot weigh 20 kg: a plate of 6.4\d mm? ?.*"
    )
    with pytest.raises(DatasheetError, match=words.split(":")[0]):
        shoe_mesh.fitted_shoe(sheet, follows.case.shoe, follows.chain, "coarse")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[flexible]\nshoes = [3]\n", "flexible shoes need shoe_mesh in the datasheet"),
        ('[shoe]\nmesh = "none.msh"\n', "none.msh"),
        ('[shoe]\nmesh = "coarse"\n', "shoe_width is 800 mm, shoe_mesh coarse is 3505 mm wide"),
    ],
)
def test_shoes_that_do_not_go_with_a_datasheet_are_refused(tmp_path, text, words):
    path = tmp_path / "mine.toml"
    path.write_text('duration = 1.0\n[datasheet]\nbase = "pc300lc"\n' + text)
    with pytest.raises(CaseFileError, match=words):
        read_case(path)


def test_the_papers_shoe_as_a_mesh_of_ones_own_makes_a_shovel(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        'duration = 1.0\n[datasheet]\nbase = "ph4100c"\n[shoe]\nmesh = "coarse"\n[flexible]\nshoes = [5]\n'
    )
    case_file = read_case(path)
    case = case_file.case
    assert case.shoe.mass == pytest.approx(4503.32, rel=1e-4)
    assert case.flexible.mesh == "coarse"
    assert case.flexible.shoes == (5,)
    assert figures.machine_mass(case) == pytest.approx(1410184.0)
    fits.check_fit(mesh_named("coarse"), "coarse", case.shoe, case.shoe.rails)
    rows = case_ledger(case_file)
    assert (rows["shoe.mass"].origin, rows["shoe.mass"].how) == (
        "derived",
        "shoe_mesh: its volume of steel, its surfaces and bores",
    )
    assert rows["flexible.youngs_modulus"].origin == "assumed"


def test_pins_of_a_mesh_are_the_axes_of_its_bores():
    of_mesh = shoe_mesh.shoe_of_mesh("coarse")
    assert of_mesh.pitch == pytest.approx(PITCH, abs=1e-6)
    front = Track.ph4100c().joint_centers["front right"]
    assert (of_mesh.pin_ahead, of_mesh.pin_height) == pytest.approx((front[0], front[2]), abs=1e-6)


def test_datasheet_needs_no_netgen_for_boxes():
    assert derived(Datasheet(operating_weight=35e3, gauge=2.59, shoe_width=0.8, length_on_ground=4.03)).case
