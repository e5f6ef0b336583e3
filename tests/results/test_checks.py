"""Check cases: section moments by hand formulas, balance, one-sided ground, CalculiX on one of them."""

import shutil

import numpy as np
import pytest

import fem
from exudyn_crawler.errors import CaseFileError, ParameterError
from exudyn_crawler.life_run import check_cases
from exudyn_crawler.results.checks.cases import (
    CheckCase,
    GroundPart,
    OneSidedGround,
    PinForce,
    Pressure,
    ShoeCheck,
    TreadForce,
    read_check,
    ready_cases,
)
from exudyn_crawler.results.checks.solve import UNLOADED, CheckedShoe, cycle_table, solve_cases
from fem.defects import Defect, growth
from fem.stress import von_mises
from fem.supports import section, surface_points
from meshes import ShoeDimensions
from tests.fem.calculix_reference import run, sample_nodes, stresses_of

FORCE = 574e3
SOFT = 1e5
"""N/m3, on which the shoe does not bend enough to change the pressure."""
WHOLE, ARM = 3.505, 0.24
BEAM = 0.06
"""Part by which bending of a beam and of the shoe differ: the load has to spread over the section."""


@pytest.fixture(scope="module")
def shoe() -> CheckedShoe:
    return CheckedShoe(ShoeCheck(mesh="coarse"))


def rolled(**place) -> tuple[TreadForce, ...]:
    return tuple(TreadForce(side=side, force=FORCE, **place) for side in ("left", "right"))


def strips(*edges: tuple[float, float]) -> OneSidedGround:
    parts = tuple(GroundPart(low=(-1.0, a), high=(1.0, b), stiffness=SOFT) for a, b in edges)
    return OneSidedGround(stiffness=0.0, parts=parts)


@pytest.fixture(scope="module")
def found(shoe):
    half = WHOLE / 2
    hand = {
        "even": (OneSidedGround(stiffness=SOFT), half / 2 - ARM),
        "ends": (strips((-half, -half + 0.2), (half - 0.2, half)), half - 0.1 - ARM),
        "ridge": (strips((-0.2, 0.2)), 0.1 - ARM),
    }
    cases = [
        CheckCase(name=name, treads=rolled(), ground=ground, hand_moment=FORCE * moment)
        for name, (ground, moment) in hand.items()
    ]
    cases.append(CheckCase(name="twice", treads=rolled() + rolled(), ground=hand["ends"][0]))
    stone = GroundPart(low=(0.12, 1.15), high=(0.42, 1.45), round=True, height=0.05, stiffness=1e10)
    cases.append(
        CheckCase(name="stone", treads=rolled(), ground=OneSidedGround(stiffness=1e9, parts=(stone,)))
    )
    return solve_cases(ShoeCheck(mesh="coarse", levels=(), cases=tuple(cases)), shoe)


@pytest.fixture(scope="module")
def stress(found):
    """Stresses at the surface, by case."""
    return dict(zip([one.name for one in found.cases], found.stress, strict=True))


@pytest.mark.simulation
def test_section_moments_are_those_of_hand_formulas_and_stresses_those_of_a_beam(found, stress, shoe):
    by_hand = found.moments.set_index("case").loc[["even", "ends", "ridge"]]
    np.testing.assert_allclose(by_hand["over it"], 1.0, rtol=0.02)
    nodes = shoe.mesh.nodes[shoe.mesh.surface_nodes]
    for z, column in ((-0.2025, "underside"), (0.1935, "top")):
        near = (np.abs(nodes[:, 2] - z) < 2e-3) & (np.abs(nodes[:, 1]) < 0.08) & (np.abs(nodes[:, 0]) < 0.12)
        along = stress["ends"][near, 1].mean() / 1e6
        assert along == pytest.approx(by_hand.loc["ends", f"beam, {column} in MPa"], rel=BEAM)


@pytest.mark.simulation
def test_stress_grows_with_loads_and_cycles_by_its_fifth_power(found):
    table = found.table.set_index(["case", "region"])["von Mises in MPa"]
    np.testing.assert_allclose(table["twice"] / table["ends"], 2.0, rtol=1e-4)
    often = found.cycles.set_index(["from", "to", "region"])["cycles to a crack"].sort_index()
    ratio = often[UNLOADED, "ends"] / often[UNLOADED, "twice"]
    np.testing.assert_allclose(ratio, 2.0**5, rtol=1e-3)
    between = found.cycle("even", "ends").set_index("region")["cycles to a crack"]
    # the range between both is less than that from nothing
    assert (between.sort_index() > often[UNLOADED, "ends"]).all()
    assert set(found.table["above yield"]) == {""}


def test_ground_pushes_in_balance_and_never_pulls(shoe):
    case = CheckCase(name="end", treads=rolled(end="front", x=0.0), ground=OneSidedGround())
    loads = shoe.loads(case)
    points = shoe.bed.points
    resultant = shoe.resultant(loads)
    flat = np.full(len(points.areas), 1e8)
    rest = shoe.bed.settle(resultant, np.zeros(len(flat)), np.zeros(len(flat)), flat)
    assert (rest.forces >= 0.0).all()
    assert not rest.forces.all()  # the rear lifts
    pushed = np.zeros_like(loads)
    shoe.parts(pushed)[0][2::3] = points.shapes.T @ rest.forces
    left = resultant + shoe.resultant(pushed)
    np.testing.assert_allclose(left, 0.0, atol=1e-6 * 2 * FORCE)


def test_what_inertia_would_hide_is_refused_by_its_case(shoe):
    def refused(words: str, **case) -> None:
        check = ShoeCheck(mesh="coarse", levels=(), cases=(CheckCase(name="mine", **case),))
        with pytest.raises(ValueError, match=f"case 'mine': .*{words}"):
            solve_cases(check, shoe)

    refused("must be in balance", treads=rolled())
    refused(
        "must be in balance", pins=(PinForce(pin="rear left", force=(1e6, 0, 0)),), ground=OneSidedGround()
    )
    refused("or it tips over", treads=rolled(), ground=strips((0.5, 1.0)))
    refused("or it tips over", treads=rolled(), ground=OneSidedGround(stiffness=0.0))
    up = Pressure(facing="down", low=(-1, -2, -1), high=(1, 2, 1), force=(0.0, 0.0, 1e6))
    refused("must press downward", pressures=(up,), ground=OneSidedGround())
    refused("no face looks up", pressures=(up.with_(facing="up", low=(0, 0, 5), high=(1, 1, 6)),))
    refused("must press on the rail", treads=rolled(x=0.5), ground=OneSidedGround())
    refused("held_by must be of", treads=rolled(), held_by=("rear left w",))


def test_pins_take_the_least_forces_that_hold_a_shoe(shoe):
    along = tuple(f"rear {side} x" for side in ("left", "right"))
    push = Pressure(facing="rear", low=(-1, -0.13, -0.1), high=(0, 0.13, 0.15), force=(1e6, 0.0, 0.0))
    lift = tuple(f"{end} {side} z" for end in ("front", "rear") for side in ("left", "right"))
    loads = shoe.loads(CheckCase(name="push", pressures=(push,), held_by=along + lift))
    np.testing.assert_allclose(shoe.resultant(loads), 0.0, atol=10.0)
    pins = shoe.parts(loads)[1].reshape(4, 6)
    assert pins[:, 0].sum() == pytest.approx(-1e6, rel=1e-9)
    assert pins[:, 2].sum() == pytest.approx(0.0, abs=10.0)


def test_loads_act_where_they_are_said_to(shoe):
    y = 0.24 + 0.22 / 3
    one = TreadForce(side="left", force=1e6, end="front", x=0.02, width=0.22 / 3, across=0.22 / 3)
    forces = shoe.rail(one)[:, 2]
    front = shoe.outline.rails.front
    assert forces.sum() == pytest.approx(-1e6)
    assert forces @ shoe.mesh.nodes[:, 0] / forces.sum() == pytest.approx(front - 0.02, abs=1e-4)
    assert forces @ shoe.mesh.nodes[:, 1] / forces.sum() == pytest.approx(y, abs=1e-4)
    points = surface_points(shoe.mesh, shoe.mesh.surface("underside"), 0.05)
    assert points.areas.sum() == pytest.approx(0.63 * WHOLE)
    cut, dims = section(shoe.mesh, 0.0), ShoeDimensions()
    parts = (
        (dims.plate_length, 0.0, dims.plate_thickness),
        (dims.beam_length, dims.plate_thickness, dims.beam_height - dims.top_thickness),
        (dims.top_length, dims.beam_height - dims.top_thickness, dims.beam_height),
    )
    area = sum(b * (q - p) for b, p, q in parts)
    middle = sum(b * (q**2 - p**2) / 2 for b, p, q in parts) / area
    second = sum(b * ((q - middle) ** 3 - (p - middle) ** 3) / 3 for b, p, q in parts)
    assert (cut.area, cut.second) == pytest.approx((area, second), rel=1e-6)
    assert cut.middle == pytest.approx(middle - 0.2025)


def test_ready_cases_have_names_of_their_own_and_are_in_balance(shoe):
    cases = ready_cases(shoe.outline, FORCE)
    assert len({case.name for case in cases}) == len(cases)
    for case in cases:
        shoe.loads(case)


@pytest.mark.simulation
@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX")
def test_stresses_of_a_check_case_are_those_of_calculix(found, stress, shoe, tmp_path):
    forces = found.forces[..., [one.name for one in found.cases].index("stone")]
    body = shoe.body
    balanced = body.balanced(forces.reshape(-1, 1)).reshape(-1, 3)
    fem.write_calculix(tmp_path / "case.inp", body, forces=balanced, fixed=body.statically_determinate)
    run(tmp_path, "case")
    stresses = stresses_of((tmp_path / "case.frd").read_text())
    nodes = np.intersect1d(sample_nodes(shoe.mesh), shoe.mesh.surface_nodes)
    expected = von_mises(np.array([stresses[int(node) + 1] for node in nodes]))
    own = von_mises(stress["stone"][np.searchsorted(shoe.mesh.surface_nodes, nodes)])
    np.testing.assert_allclose(own, expected, rtol=1e-3, atol=1e-5 * expected.max())


@pytest.mark.simulation
def test_a_check_leaves_tables_and_a_picture_of_each_case_of_its_file(tmp_path):
    (tmp_path / "mine.toml").write_text(
        'mesh = "coarse"\nlevels = []\n[material]\nbase = "a36"\n'
        '[[cases]]\nname = "flange"\nheld_by = ["front left x"]\nground = { stiffness = 1e8 }\n'
        'treads = [{ side = "left", force = 4e6, width = 0.06 }, { side = "right", force = 4e6 }]\n'
    )
    out = tmp_path / "out"
    result = check_cases(tmp_path / "mine.toml", out)
    names = {"peaks.csv", "moments.csv", "cycles.csv", "hertz.csv", "check.html", "pictures"}
    assert {path.name for path in out.iterdir()} == names
    assert [path.name for path in (out / "pictures").iterdir()] == ["001_flange.png"]
    assert result.table.set_index("region")["above yield"]["roller path"] == "yes"
    page = (out / "check.html").read_text()
    assert all(words in page for words in ("Check of mine", "Cases in 3D", "check-view", "Below a tread"))
    with pytest.raises(FileExistsError):
        check_cases(tmp_path / "mine.toml", out)
    assert read_check(tmp_path / "mine.toml").name == "mine"
    (tmp_path / "mine.toml").write_text('mesh = "coarse"\n[[cases]]\nname = "a"\n[[cases]]\nname = "a"\n')
    with pytest.raises(CaseFileError, match="names must differ"):
        read_check(tmp_path / "mine.toml")


@pytest.mark.simulation
def test_a_defect_in_tension_counts_where_it_is_worst_in_its_region(found, stress, shoe):
    material = found.check.material.with_(
        castings=({"defect_size": 3e-3}, {"region": "web", "residual_stress": 100e6})
    )
    table = cycle_table(found.check.with_(material=material), shoe, stress, [(UNLOADED, "ends")])
    unloaded = found.cycles[(found.cycles["from"] == UNLOADED) & (found.cycles["to"] == "ends")]
    plain = unloaded.set_index("region")["cycles to a crack"]
    own = table.set_index("region")
    assert own.loc["web", "cycles to a crack"] < plain["web"]
    assert own.loc["wings", "cycles to a crack"] == pytest.approx(plain["wings"])
    assert np.isnan(own.loc["web", "cycles to a crack, defect"])
    wings = stress["ends"][shoe.regions == "wings"]
    highest = von_mises(wings)[wings[:, :3].sum(axis=1) >= 0.0].max()
    defect = Defect(3e-3, 860.0 / 3.2, 0.06)
    expected = growth(defect, np.zeros(1), np.array([highest]), np.ones(1), 0.975)[0]
    assert own.loc["wings", "cycles to a crack, defect"] == pytest.approx(expected, rel=1e-6)


@pytest.mark.simulation
def test_a_blow_pushes_as_its_energy_and_compliance_say(shoe):
    """On soft ground a shoe hardly bends: F = sqrt(2 E k A); the work of the forces is the energy."""
    top = Pressure(facing="up", low=(-0.2, -0.4, 0.1), high=(0.2, 0.4, 0.4), force=(0.0, 0.0, -1e6))
    soft = OneSidedGround(stiffness=SOFT)
    case = CheckCase(name="blow", treads=rolled(), pressures=(top,), ground=soft, energy=25e3)
    hard = case.with_(name="hard", ground=OneSidedGround(stiffness=1e9))
    off = Pressure(facing="up", low=(-0.4, 1.5, 0.1), high=(0.4, 1.8, 0.4), force=(0.0, 0.0, -1e6))
    aside = case.with_(name="aside", ground=OneSidedGround(), pressures=(off,))
    once = aside.with_(name="rest", pressures=(), energy=None)
    found = solve_cases(ShoeCheck(mesh="coarse", levels=(), cases=(case, hard, aside, once)), shoe)
    blow = found.moments.set_index("case")
    assert blow.loc["blow", "blow in MN"] * 1e6 == pytest.approx(
        (2.0 * 25e3 * SOFT * 0.63 * WHOLE) ** 0.5, rel=0.01
    )
    assert blow.loc["blow", "its compliance in m/N"] == pytest.approx(1.0 / (SOFT * 0.63 * WHOLE), rel=0.02)
    force, compliance = blow["blow in MN"] * 1e6, blow["its compliance in m/N"]
    np.testing.assert_allclose((0.5 * force**2 * compliance)[:3], 25e3, rtol=1e-3)
    assert force["hard"] > 3.0 * force["blow"]
    # of what is left in balance with the treads and the ground
    assert found.forces[:, 2, 2].sum() == pytest.approx(0.0, abs=1.0)
    assert found.forces[:, 2, 2][found.forces[:, 2, 2] < 0.0].sum() < -2 * FORCE - 0.5 * force["aside"]
    assert np.isnan(blow.loc["rest", "blow in MN"])
    with pytest.raises(ParameterError, match="energy needs treads, pressures and ground"):
        case.with_(ground=None)
