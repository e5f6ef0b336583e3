"""Check cases and roller paths: hand formulas, balance, one-sided ground, CalculiX, every pass of a run."""

import dataclasses
import shutil
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import fem
from exudyn_crawler import Duty, FatigueMaterial
from exudyn_crawler.errors import CaseFileError, ParameterError
from exudyn_crawler.life_run import check_cases, roller_paths
from exudyn_crawler.machines import Outputs
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
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe
from exudyn_crawler.results.checks.roller_path import MIDDLE, PRESSURE, TYPICAL, hertz_table, roller_path
from exudyn_crawler.results.checks.solve import (
    AT_BORES,
    CheckResults,
    solve_cases,
)
from exudyn_crawler.results.checks.tables import CYCLES, cycle_table
from exudyn_crawler.results.life.duty import UNLOADED, DutyRun
from exudyn_crawler.results.stress.recovery import node_stress
from exudyn_crawler.views.figures import roller_path_figure
from exudyn_crawler.views.outputs import write_tables
from exudyn_crawler.views.pages.life import check_lines, write_check_page
from exudyn_crawler.views.pages.report import report_page
from fem.body.element_stress import von_mises
from fem.body.supports import section, surface_points
from fem.fatigue.defects import Defect, growth
from meshes import ShoeDimensions
from tests.fem.calculix_reference import run, sample_nodes, stresses_of
from tests.stress_results import by_modes_alone

FORCE = 574e3
SOFT = 1e5
"""N/m3, on which the shoe does not bend enough to change the pressure."""
WHOLE, ARM = 3.505, 0.24
BEAM = 0.06
"""Part by which bending of a beam and of the shoe differ: the load has to spread over the section."""

HELD = SimpleNamespace(unused_regions=["bores"])
"""Shoe whose bores have the stress of couplings."""


@pytest.fixture(scope="module")
def shoe() -> CheckedShoe:
    return CheckedShoe(ShoeCheck(mesh="coarse"))


def rolling(**place) -> tuple[TreadForce, ...]:
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
        CheckCase(name=name, treads=rolling(), ground=ground, hand_moment=FORCE * moment)
        for name, (ground, moment) in hand.items()
    ]
    cases.append(CheckCase(name="twice", treads=rolling() + rolling(), ground=hand["ends"][0]))
    stone = GroundPart(low=(0.12, 1.15), high=(0.42, 1.45), round=True, height=0.05, stiffness=1e10)
    on_stone = OneSidedGround(stiffness=1e9, parts=(stone,))
    cases.append(CheckCase(name="stone", treads=rolling(), ground=on_stone))
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


def test_bores_head_no_cycles_to_a_crack_and_are_named_behind():
    rows = [
        ("rest", "stone", "bores", 1e4),
        ("rest", "stone", "wings", 1e5),
        ("rest", "stone", "lugs", 1e6),
        ("rest", "turn", "bores", 1e7),
        ("rest", "turn", "web", 3e4),
        ("rest", "pull", "bores", 1e8),
    ]
    cycles = pd.DataFrame(rows, columns=["from", "to", "region", CYCLES])
    worst = CheckResults.worst_cycles.fget(SimpleNamespace(cycles=cycles, shoe=HELD))
    assert worst["to"].tolist() == ["turn", "stone", "pull"]
    assert worst["region"].tolist() == ["web", "wings", "bores"]
    np.testing.assert_array_equal(worst[AT_BORES], [np.nan, 1e4, np.nan])
    apart = cycles[cycles["to"] == "turn"]
    assert AT_BORES not in CheckResults.worst_cycles.fget(SimpleNamespace(cycles=apart, shoe=HELD))


def test_a_check_is_printed_as_a_row_a_region_with_the_pairs_that_are_as_bad():
    rows = [
        ("rest", "stone", "web", 1e6, 40.0, ""),
        ("rest", "turn", "web", 1.05e6, 42.0, ""),
        ("rest", "pull", "web", 2e6, 80.0, ""),
        ("rest", "stone", "lugs", 3e5, 12.0, "yes"),
        ("rest", "stone", "bores", 1e4, 0.4, ""),
    ]
    columns = ["from", "to", "region", CYCLES, "an hour", "above yield"]
    shown = CheckResults.by_region.fget(
        SimpleNamespace(cycles=pd.DataFrame(rows, columns=columns), shoe=HELD)
    )
    assert shown["region"].tolist() == ["lugs", "web", "bores, not to be used"]
    assert shown["to"].tolist() == ["stone"] * 3
    assert shown["pairs within 10 %"].tolist() == [1, 2, 1]


def test_what_yields_is_told_before_what_cracks_first_below_yield():
    cycles = pd.DataFrame(
        [
            (UNLOADED, "strike", "wings", 4.7, "yes"),
            (UNLOADED, "stone", "wings", 2e4, ""),
            (UNLOADED, "stone", "bores", 1e2, "yes"),
            (UNLOADED, "pull", "bores", 1.0, "yes"),
        ],
        columns=["from", "to", "region", CYCLES, "above yield"],
    )
    peaks = [
        ("strike", "wings", 2936.0, "resolved"),
        ("stone", "wings", 300.0, "mesh too coarse: refine here"),
    ]
    table = pd.DataFrame(peaks, columns=["case", "region", "von Mises in MPa", "verdict"])
    check = SimpleNamespace(material=FatigueMaterial.cast_nicrmo())

    def lines(rows):
        worst = CheckResults.worst_cycles.fget(SimpleNamespace(cycles=rows, shoe=HELD))
        return check_lines(SimpleNamespace(worst_cycles=worst, table=table, check=check, shoe=HELD))

    above, below = lines(cycles)
    assert above.startswith(
        "yields: wings, up to 2936 MPa of linear stress in 'strike', 4.3 times the 690 MPa"
    )
    assert "yields; 1 of 2 cycles do" in above
    assert below == (
        "first to crack below yield: wings, after 20 000 cycles from 'unloaded' to 'stone'; stress there "
        "mesh too coarse: refine here"
    )
    assert len(lines(cycles[:1])) == 1
    assert lines(cycles[1:])[0].startswith("first to crack: wings, after 20 000")


def test_ground_pushes_in_balance_and_never_pulls(shoe):
    case = CheckCase(name="end", treads=rolling(end="front", x=0.0), ground=OneSidedGround())
    loads = shoe.loads(case)
    points = shoe.bed.points
    resultant = shoe.resultant(loads)
    flat = np.full(len(points.areas), 1e8)
    rest = shoe.bed.settle(resultant, np.zeros(len(flat)), np.zeros(len(flat)), flat)
    assert (rest.forces >= 0.0).all()
    assert not rest.forces.all()  # the rear lifts
    pushed = np.zeros_like(loads)
    shoe.parts(pushed)[0][2::3] = points.shapes.T @ rest.forces
    np.testing.assert_allclose(resultant + shoe.resultant(pushed), 0.0, atol=1e-6 * 2 * FORCE)


def test_what_inertia_would_hide_is_refused_by_its_case(shoe):
    def refused(words: str, **case) -> None:
        check = ShoeCheck(mesh="coarse", levels=(), cases=(CheckCase(name="mine", **case),))
        with pytest.raises(ValueError, match=f"case 'mine': .*{words}"):
            solve_cases(check, shoe)

    refused("must be in balance", treads=rolling())
    pin = PinForce(pin="rear left", force=(1e6, 0, 0))
    refused("must be in balance", pins=(pin,), ground=OneSidedGround())
    refused("or it tips over", treads=rolling(), ground=strips((0.5, 1.0)))
    refused("or it tips over", treads=rolling(), ground=OneSidedGround(stiffness=0.0))
    up = Pressure(facing="down", low=(-1, -2, -1), high=(1, 2, 1), force=(0.0, 0.0, 1e6))
    refused("must press downward", pressures=(up,), ground=OneSidedGround())
    refused("no face is directed up", pressures=(up.with_(facing="up", low=(0, 0, 5), high=(1, 1, 6)),))
    refused("must press on the rail", treads=rolling(x=0.5), ground=OneSidedGround())
    refused("held_by must be among", treads=rolling(), held_by=("rear left w",))


def test_pins_take_the_least_forces_that_hold_a_shoe(shoe):
    along = ("rear left x", "rear right x")
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


def test_no_name_is_markup_or_script_of_a_checks_page(found, tmp_path):
    tag = "<img src=x onerror=alert(1)></script><script>alert(2)</script>"
    cases = tuple(case.model_copy(update={"name": f"{tag} {case.name}"}) for case in found.cases)
    material = found.check.material.model_copy(update={"name": tag})
    check = found.check.model_copy(update={"name": tag, "cases": cases, "material": material})
    tables = {name: getattr(found, name).assign(note=tag) for name in ("table", "moments", "hertz")}
    named = dataclasses.replace(found, check=check, cases=cases, **tables)
    text = write_check_page(named, tmp_path / "check.html").read_text()
    assert "Check of &lt;img src=x" in text
    assert "<img src=x" not in text
    assert "<script>alert" not in text


@pytest.mark.simulation
@pytest.mark.slow
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
    twice = '[[cases]]\nname = "a"\ntreads = [{ side = "left", force = 4e6 }]\n'
    (tmp_path / "mine.toml").write_text(f'mesh = "coarse"\n{twice}{twice}')
    with pytest.raises(CaseFileError, match="names must differ"):
        read_check(tmp_path / "mine.toml")


@pytest.mark.simulation
def test_a_defect_in_tension_counts_where_it_is_worst_in_its_region(found, stress, shoe):
    material = found.check.material.with_(
        castings=({"defect_size": 3e-3}, {"region": "web", "residual_stress": 100e6})
    )
    table = cycle_table(found.check.with_(material=material), shoe, stress, [(UNLOADED, "ends")])
    plain = found.cycle(UNLOADED, "ends").set_index("region")["cycles to a crack"]
    own = table.set_index("region")
    assert own.loc["web", "cycles to a crack"] < plain["web"]
    assert own.loc["wings", "cycles to a crack"] == pytest.approx(plain["wings"])
    assert np.isnan(own.loc["web", "cycles to a crack, defect"])
    wings = stress["ends"][shoe.regions == "wings"]
    highest = von_mises(wings)[wings[:, :3].sum(axis=1) >= 0.0].max()
    expected = growth(Defect(3e-3, 860.0 / 3.2, 0.06), np.zeros(1), np.array([highest]), np.ones(1), 0.975)[0]
    assert own.loc["wings", "cycles to a crack, defect"] == pytest.approx(expected, rel=1e-6)


@pytest.mark.simulation
def test_a_blow_pushes_as_its_energy_and_compliance_say(shoe):
    """On soft ground a shoe hardly bends: F = sqrt(2 E k A); the work of the forces is the energy."""
    top = Pressure(facing="up", low=(-0.2, -0.4, 0.1), high=(0.2, 0.4, 0.4), force=(0.0, 0.0, -1e6))
    soft = OneSidedGround(stiffness=SOFT)
    case = CheckCase(name="blow", treads=rolling(), pressures=(top,), ground=soft, energy=25e3)
    hard = case.with_(name="hard", ground=OneSidedGround(stiffness=1e9))
    off = Pressure(facing="up", low=(-0.4, 1.5, 0.1), high=(0.4, 1.8, 0.4), force=(0.0, 0.0, -1e6))
    aside = case.with_(name="aside", ground=OneSidedGround(), pressures=(off,))
    once = aside.with_(name="rest", pressures=(), energy=None)
    found = solve_cases(ShoeCheck(mesh="coarse", levels=(), cases=(case, hard, aside, once)), shoe)
    blow = found.moments.set_index("case")
    bed = SOFT * 0.63 * WHOLE
    assert blow.loc["blow", "blow in MN"] * 1e6 == pytest.approx((2.0 * 25e3 * bed) ** 0.5, rel=0.01)
    assert blow.loc["blow", "its compliance in m/N"] == pytest.approx(1.0 / bed, rel=0.02)
    force, compliance = blow["blow in MN"] * 1e6, blow["its compliance in m/N"]
    np.testing.assert_allclose((0.5 * force**2 * compliance)[:3], 25e3, rtol=1e-3)
    assert force["hard"] > 3.0 * force["blow"]
    # of what is left in balance with the treads and the ground
    assert found.forces[:, 2, 2].sum() == pytest.approx(0.0, abs=1.0)
    assert found.forces[:, 2, 2][found.forces[:, 2, 2] < 0.0].sum() < -2 * FORCE - 0.5 * force["aside"]
    assert np.isnan(blow.loc["rest", "blow in MN"])
    with pytest.raises(ParameterError, match="energy must be given with treads, pressures and ground"):
        case.with_(ground=None)


def test_treads_of_check_cases_have_the_pressures_of_hand_formulas():
    """p0 = sqrt(q E* / (pi R)), 0.4 m of radius: 528 MPa with 574 kN on 0.18 m, 915 on a third of it."""
    treads = (TreadForce(side="left", force=574e3), TreadForce(side="right", force=574e3, width=0.06))
    cases = [CheckCase(name="one", treads=treads), CheckCase(name="two", treads=treads)]
    found = hertz_table(ShoeCheck(), cases).set_index(["width in m", "tilt in mrad"])
    level = found.xs(0.0, level="tilt in mrad")
    assert level.loc[0.18, PRESSURE] == pytest.approx(528.1, rel=1e-3)
    assert level.loc[0.06, PRESSURE] == pytest.approx(528.1 * 3.0**0.5, rel=1e-3)
    assert level.loc[0.18, "its depth in mm"] == pytest.approx(0.786 * 3.84, rel=0.02)
    assert set(level["path"]) == {"elastic"}
    assert set(found["first case"]) == {"one"}
    of_width = found.loc[0.18]
    assert (np.diff(of_width[PRESSURE]) > 0.0).all()
    assert of_width.loc[1.0, "edge over mean"] > 2.0
    weak = hertz_table(ShoeCheck(material=ShoeCheck().material.a36()), cases)
    assert weak.set_index(["width in m", "tilt in mrad"]).loc[(0.06, 0.0), "path"] == "ratchets"


def test_every_tread_of_a_run_is_counted_by_its_place(rolled):
    table = roller_path(rolled)
    force = np.linalg.norm(rolled.tread_force.values, axis=-1).sum(axis=3)
    assert table["greatest force in kN"].max() <= force.max() / 1e3 * (1.0 + 1e-12)
    assert table[MIDDLE].is_monotonic_increasing
    assert (table[PRESSURE] >= table[TYPICAL] * (1.0 - 1e-12)).all()
    # two rails, three rollers and the shoe behind and ahead of each at most, more while they roll on
    assert table["passes"].min() >= 1
    worst = table.loc[table[PRESSURE].idxmax()]
    frame = rolled.case.gear
    q = worst["greatest force in kN"] * 1e3 * worst["edge over mean"] / frame.tread_width
    modulus = 200e9 / 2.0 / 0.91
    assert worst[PRESSURE] * 1e6 == pytest.approx((q * modulus / np.pi / frame.radius) ** 0.5)
    k = 690e6 / 3.0**0.5
    assert worst["cast NiCrMo to yield"] == pytest.approx(3.106 * k / worst[PRESSURE] / 1e6, rel=5e-3)
    assert worst["cast NiCrMo to shakedown"] == pytest.approx(4.0 * k / worst[PRESSURE] / 1e6, rel=5e-3)
    assert table.filter(like="structure").empty


def test_a_life_shows_the_roller_path_of_its_rolled_runs(rolled):
    run = SimpleNamespace(basis=SimpleNamespace(history=rolled), run=SimpleNamespace(name="propel"))
    duty = Duty(runs=(DutyRun(name="propel", folder=".", share=0.1),), material=FatigueMaterial.a36())
    found = roller_paths(SimpleNamespace(duty=duty, runs=[run]))
    pd.testing.assert_frame_equal(found["propel"], roller_path(rolled, [duty.material]))
    assert "A36 to shakedown" in found["propel"]


def test_blocks_of_a_long_history_make_no_difference(rolled, monkeypatch):
    whole = roller_path(rolled)
    monkeypatch.setattr("exudyn_crawler.files.TIMES_AT_ONCE", 100)
    pd.testing.assert_frame_equal(roller_path(rolled), whole)


def test_stress_of_the_structure_is_that_of_the_node_below_the_tread(bent):
    bent = by_modes_alone(bent)
    table = roller_path(bent)
    assert set(table["shoe"]) <= set(bent.case.flexible.shoes)
    row = table.loc[table[PRESSURE].idxmax()]
    stress = node_stress(bent, int(row["shoe"]), node=int(row["node"])).sel(time=row["time in s"]).stress
    for component, name in (("xx", "along"), ("yy", "across")):
        assert float(stress.sel(component=component)) / 1e6 == pytest.approx(row[f"structure {name} in MPa"])
    assert np.isfinite(table[["structure along in MPa", "structure across in MPa"]]).all(axis=None)
    # what comes and goes lowers no limit that the contact alone has, but for what it adds to the shear
    alone = 4.0 * 690.0 / 3.0**0.5 / table[PRESSURE]
    assert (table["cast NiCrMo to shakedown"] <= alone * (1.0 + 5e-3)).all()


def test_a_check_case_without_loads_is_refused(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('mesh = "coarse"\n[[cases]]\nname = "idle"\n')
    with pytest.raises(CaseFileError, match=r"mine\.toml: cases\[0\].*: treads, pressures or pins must be"):
        read_check(path)


@pytest.mark.slow
def test_a_check_case_out_of_balance_is_refused_with_its_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('mesh = "coarse"\n[[cases]]\nname = "apart"\ntreads = [{ side = "left", force = 5e5 }]\n')
    with pytest.raises(ValueError, match=r"mine\.toml: case 'apart': loads must be in balance"):
        check_cases(path)


def test_a_case_to_be_checked_must_have_flexible_shoes(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('base = "closed"\nduration = 1.0\n')
    with pytest.raises(
        ValueError, match=r"mine\.toml: \[flexible\] must be given, since its mesh is checked"
    ):
        read_check(path)
    path.write_text('base = "stress"\nduration = 1.0\n')
    assert read_check(path).mesh == "study"


def test_a_duty_is_no_check():
    with pytest.raises(ValueError, match=r"duty\.toml is a duty, for the command life"):
        read_check("studies/duty.toml")


def test_a_track_without_rollers_has_no_roller_path(translation):
    with pytest.raises(
        ValueError, match="need a side frame on an open track, or a closed track's flexible shoes"
    ):
        roller_path(translation)


def test_a_rolled_run_leaves_its_roller_path_and_its_page_shows_it(rolled, tmp_path):
    write_tables(rolled, None, tmp_path, Outputs())
    table = pd.read_csv(tmp_path / "roller_path.csv")
    pd.testing.assert_frame_equal(table, roller_path(rolled), check_dtype=False, rtol=1e-8)
    (ax,) = roller_path_figure(table, "rolled").axes
    drawn = ax.get_lines()[0].get_ydata()
    np.testing.assert_allclose(drawn, table.loc[table["place"] == "rail", PRESSURE])
    assert sum("shakedown of" in str(line.get_label()) for line in ax.get_lines()) == 3
    rolled.save(tmp_path / "history.nc")
    assert "Roller path" in report_page(tmp_path)
