"""Duties: files, refusals by the key at fault, FKM's fatigue strength, check cases and stages of wear."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

import meshes
from exudyn_crawler import Duty, FatigueMaterial, life, read_duty
from exudyn_crawler.errors import CaseFileError, ParameterError
from exudyn_crawler.life_run import roller_paths
from exudyn_crawler.results.checks.cases import ShoeCheck
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe
from exudyn_crawler.results.checks.solve import case_shapes
from exudyn_crawler.results.checks.tables import cycle_table
from exudyn_crawler.results.life.duty import UNLOADED, DutyCase, DutyRun, DutyStage
from exudyn_crawler.results.life.duty_runs import BETWEEN, check_cases_of, node_lives, used_cases
from exudyn_crawler.results.life.life import BEYOND, hours_in_stages, in_words, life_of, life_of_stages
from exudyn_crawler.views.pages.life import life_lines
from fem import Shapes
from fem.body.interfaces import Spider
from fem.fatigue.defects import CycleStage, Defect, growth
from meshes.shoe import STEEL, joint_interfaces

TEXT = """
miner = "haibach"

runs = [
    { name = "propel", folder = "runs/propel", share = 0.07 },
    { name = "dig", folder = "/elsewhere/cycle", begin = 15, end = 40.0, an_hour = 75 },
]
[material]
base = "cast_manganese"
roughness = 1e-4
"""
WEAR = """
check = "shoe.toml"
material = { base = "cast_nicrmo" }
stages = [{ name = "new", hours = 9000 }, { name = "worn", hours = 1000, check = "coarse" }]
cases = [
    { name = "stones", case = "stone", an_hour = 3 },
    { name = "ends", case = "ends", an_hour = 1, stage = "worn" },
]
"""
STRENGTH, SENSITIVITY, KNEE = 100e6, 0.3, 1e6
PLATE = FatigueMaterial.a36().with_(fatigue_strength=STRENGTH, mean_sensitivity=SENSITIVITY, roughness=1e-6)
PATH = {"region": "roller path", "residual_stress": -200e6}
STONE = DutyCase(name="stones", case="stone", an_hour=2.0)
STRIKE = DutyCase(name="strikes", case="strike", an_hour=0.25)
STAGES = (DutyStage(name="new", hours=1000.0), DutyStage(name="worn", hours=500.0))


def test_a_duty_is_read_with_folders_from_where_it_lies(tmp_path):
    (tmp_path / "pit.toml").write_text(TEXT)
    duty = read_duty(tmp_path / "pit.toml")
    assert duty.name == "pit"
    assert duty.material == FatigueMaterial.cast_manganese().with_(roughness=1e-4)
    assert [run.folder for run in duty.runs] == [str(tmp_path / "runs/propel"), "/elsewhere/cycle"]
    assert duty.times_an_hour([20.0, 25.0]) == pytest.approx([0.07 * 3600.0 / 20.0, 75.0])
    # a longer run of the same part of the hours happens as much less often
    assert duty.times_an_hour([40.0, 25.0])[0] == pytest.approx(0.07 * 3600.0 / 40.0)


def test_a_duty_of_cases_is_read_with_checks_from_where_it_lies(tmp_path):
    (tmp_path / "wear.toml").write_text(WEAR)
    (tmp_path / "shoe.toml").write_text('mesh = "coarse"\n')
    new, worn = read_duty(tmp_path / "wear.toml").by_stage()
    assert (new.check, worn.check) == (str(tmp_path / "shoe.toml"), "coarse")
    assert [[case.name for case in one.cases] for one in (new, worn)] == [["stones"], ["stones", "ends"]]


OF_TEXT = [
    ("roughness = 1e-4", "yield_strength = 350", r"material.yield_strength: .* got 350; is it in MPa\?"),
    ("share = 0.07", "share = 0.07, an_hour = 3", "an_hour or share must be given, got neither or both"),
    (", share = 0.07", "", "an_hour or share must be given"),
    ("end = 40.0", "end = 10.0", "end must be after begin = 15 s, got 10 s"),
    ("share = 0.07", "shar = 0.07", r"runs\[0\].shar: unknown key; did you mean runs\[0\].share\?"),
    ('name = "dig"', 'name = "propel"', "the runs' names must differ"),
    ("an_hour = 75", "share = 0.95", "more than all machine hours, got 1.02 of them: propel 0.07"),
    ('"cast_manganese"', '"cast_magnesium"', "did you mean 'cast_manganese'"),
    ('miner = "haibach"', 'miner = "palmgren"', "miner: must be 'elementary', 'haibach'"),
    ("[material]", "[material", "not TOML"),
    ('miner = "haibach"', "survivals = [0.9, 0.5]", "survivals must be different and rise"),
]
OF_WEAR = [
    ('name = "ends"', 'name = "stones"', "names must differ"),
    ('stage = "worn"', 'stage = "old"', r"stage must be one of \['new', 'worn'\], got \['old'\]"),
    ('name = "worn"', 'name = "new"', "the stages' names must differ"),
    ("an_hour = 3", 'an_hour = 3, stage = "worn"', "runs or cases must be given, got neither"),
    ("hours = 9000", "hours = 0", r"stages\[0\].hours"),
]


@pytest.mark.parametrize(
    ("text", "old", "new", "words"),
    [*((TEXT, *one) for one in OF_TEXT), *((WEAR, *one) for one in OF_WEAR)],
)
def test_faults_are_told_by_their_keys(tmp_path, text, old, new, words):
    (tmp_path / "pit.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(CaseFileError, match=words):
        read_duty(tmp_path / "pit.toml")


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError, match="no duty file"):
        read_duty(tmp_path / "none.toml")


def test_hours_that_are_more_than_full_are_refused():
    runs = tuple(DutyRun(name=name, folder=".", an_hour=100.0) for name in ("dig", "dump"))
    duty = Duty(runs=runs, material=FatigueMaterial.a36())
    assert duty.times_an_hour([10.0, 20.0]) == [100.0, 100.0]
    with pytest.raises(ValueError, match=r"got 1.667 of them: dig 0.5556, dump 1.111"):
        duty.times_an_hour([20.0, 40.0])


def test_strength_by_hand():
    """FKM, cast steel of 860 MPa with a casting skin: f_W 0.34, a_R 0.20, R_m,N,min 400 MPa, K_f 2."""
    material = FatigueMaterial.cast_nicrmo()
    roughness = 1.0 - 0.20 * np.log10(200.0) * np.log10(2.0 * 860.0 / 400.0)
    design = 1.0 + 0.5 * (1.0 / roughness - 1.0)
    factors = material.factors()
    assert factors["roughness"] == pytest.approx(roughness)
    assert factors["mean_sensitivity"] == pytest.approx(0.35e-3 * 860.0 + 0.05)
    assert material.curve().strength == pytest.approx(0.34 * 860e6 / design / 1.25)
    assert FatigueMaterial.a36().factors()["fatigue_strength"] == pytest.approx(0.45 * 400e6)


def test_support_of_a_gradient_is_stielers():
    """It is 1 + G 10^-(a_G - 0.5 + R_m / b_G) for G up to 0.1 1/mm, a_G 0.5 and b_G 2700 MPa of steel."""
    material = FatigueMaterial.a36().with_(stress_gradient=80.0)
    assert material.factors()["support"] == pytest.approx(1.0 + 0.08 * 10.0 ** -(400.0 / 2700.0))


def test_what_makes_a_part_stronger_or_weaker():
    stronger = ({"roughness": 1e-5}, {"stress_gradient": 200.0}, {"tensile_strength": 950e6})
    weaker = (
        {"roughness": 4e-4},
        {"casting_factor": 1.4},
        {"size_factor": 0.85},
        {"fatigue_strength": 250e6},
    )
    one = FatigueMaterial.cast_nicrmo()
    for changes, sense in ((stronger, 1), (weaker, -1)):
        for change in changes:
            assert sense * (one.with_(**change).curve().strength - one.curve().strength) > 0.0, change


@pytest.mark.parametrize("name", ["a36", "cast_nicrmo", "cast_manganese"])
def test_ready_materials_say_what_they_assume(name):
    material = getattr(FatigueMaterial, name)()
    assert "assumed" in material.source
    assert 100e6 < material.curve("haibach").strength < 250e6


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"yield_strength": 250}, "yield_strength"),
        ({"yield_strength": 900e6}, "yield_strength must not exceed tensile_strength = 860 MPa, got 900 MPa"),
        ({"fkm_class": "wood"}, "fkm_class"),
        ({"survival": 1.0}, "survival"),
        ({"fatigue_strength": 900e6}, "fatigue_strength must not exceed .* = 860 MPa, got 900 MPa"),
        ({"castings": (PATH, PATH)}, "regions must differ"),
        ({"castings": ({"region": "pin"},)}, "region"),
    ],
)
def test_what_is_no_material_is_refused(change, words):
    with pytest.raises(ParameterError, match=words):
        FatigueMaterial.cast_nicrmo().with_(**change)


def test_castings_differ_by_region():
    material = FatigueMaterial.cast_nicrmo().with_(castings=({"defect_size": 1e-3}, PATH))
    assert material.curve("elementary", "roller path").residual_stress == -200e6
    assert material.curve("elementary", "lugs") == FatigueMaterial.cast_nicrmo().curve()
    once = [CycleStage(np.zeros(1), np.array([300e6]), np.ones(1))]
    assert np.isnan(material.defect_life("roller path", "elementary", once, 0.975))
    own = Defect(1e-3, 860.0 / 3.2, 0.06), np.zeros(1), np.array([300e6]), np.ones(1)
    assert material.defect_life("lugs", "elementary", once, 0.9) == growth(*own, 0.9)[0] < 1e6
    # Murakami's limit of 50 micrometres is a range of 486 MPa from 0 (HV 860 / 3.2), of 552 MPa with HV 320
    small = material.with_(castings=({"defect_size": 5e-5},), fatigue_strength=860e6)
    more = [CycleStage(np.zeros(1), np.array([500e6]), np.ones(1))]
    materials = (small, small.with_(hardness=320))
    grows, sleeps = (one.defect_life("lugs", "elementary", more, 0.9) for one in materials)
    assert grows == growth(Defect(5e-5, 860.0 / 3.2, 0.06), *own[1:2], more[0].end, np.ones(1), 0.9)[0]
    assert sleeps > 10.0 * grows


def duty(*cases: DutyCase, **changes) -> Duty:
    given = {"cases": cases, "material": PLATE, "plane_nodes": 0, "survivals": (0.975,)}
    return Duty(**given | changes)


def pulled(mesh, *stresses: float, pins: Spider = "rigid") -> Shapes:
    """Shoe under cases that pull all of it along x by these stresses, Pa."""
    stress = np.zeros((len(mesh.nodes), 6, len(stresses)))
    stress[:, 0] = stresses
    # strain that has this stress in the elements, too
    strain = np.diag([1.0, -STEEL.poissons_ratio, -STEEL.poissons_ratio]) / STEEL.youngs_modulus
    modes = np.einsum("ni,ij,k->njk", mesh.nodes, strain, np.array(stresses))
    return Shapes(mesh, STEEL, tuple(joint_interfaces(mesh, pins)), modes, stress)


@pytest.fixture(scope="module")
def mesh():
    return meshes.mesh_named("coarse")


def damage_of(amplitude: float) -> float:
    """Damage of a cycle from zero to twice the amplitude, by hand: R = 0, slope 5, survival as tested."""
    design = PLATE.factors()["design"]
    return ((1.0 + SENSITIVITY) * amplitude * design / STRENGTH) ** 5 / KNEE


def test_damage_of_check_cases_is_the_sum_by_hand(mesh):
    found = life_of(duty(STONE, STRIKE, plane_nodes=3), [], shapes=pulled(mesh, 60e6, 140e6))
    parts = {"stones": 2.0 * damage_of(30e6), "strikes": 0.25 * damage_of(70e6)}
    parts[BETWEEN] = 0.0  # a strike holds both the least and the greatest stress
    assert found.dataset.part.values.tolist() == list(parts)
    node = mesh.surface_nodes[100]
    np.testing.assert_allclose(found.dataset.part_damage.sel(node=node), list(parts.values()), rtol=1e-9)
    np.testing.assert_allclose(found.dataset.life.sel(node=node), [1.0 / sum(parts.values())], rtol=1e-9)
    # the critical plane looks along the pull, to half a degree
    on_plane = parts["stones"] + parts["strikes"]
    assert float(found.dataset.plane_damage.max()) == pytest.approx(on_plane, rel=1e-3)
    # an even stress is one that any mesh has
    assert float(found.dataset.stress_error.max()) < 1e-6
    causes = found.causes()
    assert causes.loc["stones", "web"] == pytest.approx(1.0 / parts["stones"])
    assert set(causes.columns) == set(found.regions[mesh.surface_nodes])


def test_a_cycle_between_two_cases_has_their_range_and_mean(mesh):
    found = life_of(duty(STONE.with_(case="strike", after="stone")), [], shapes=pulled(mesh, 140e6, 60e6))
    expected = 2.0 * PLATE.curve().damage(np.array([40e6]), np.array([100e6]), (0.975,))[0, 0]
    np.testing.assert_allclose(found.dataset.part_damage.values[0, mesh.surface_nodes], expected, rtol=1e-9)


def test_a_cycle_from_case_to_case_replaces_those_that_it_is_made_of(mesh):
    """Pulled by 140 MPa 3 times an hour and pressed by 60 MPa twice: cycles of 200 MPa, once more of 140."""
    press = DutyCase(name="presses", case="strike", an_hour=2.0)
    found = life_of(duty(STONE.with_(an_hour=3.0), press), [], shapes=pulled(mesh, 140e6, -60e6))
    node = int(mesh.surface_nodes[100])
    curve = PLATE.curve()
    amplitude, mean = np.array([100e6, 70e6]), np.array([40e6, 70e6])
    expected = curve.damage(amplitude, mean, (0.975,))[0] @ [2.0, 1.0]
    assert float(found.dataset.damage_an_hour.sel(node=node)[0]) == pytest.approx(expected, rel=1e-9)
    shown = found.nodes[found.table["node"][0]]
    assert shown.cycles["run"].tolist() == ["stones", BETWEEN]
    assert shown.cycles["times an hour"].tolist() == [1.0, 2.0]
    assert shown.cycles[["begin in Pa", "end in Pa"]].abs().max().max() == pytest.approx(140e6)
    assert shown.by_criterion["signed von mises"] == pytest.approx(expected, rel=1e-9)
    # as often as the duty says
    each = curve.damage(np.array([100e6, 70e6, 30e6]), np.array([40e6, 70e6, -30e6]), (0.975,))[0]
    seldom = damage_at(mesh, node, STONE.with_(an_hour=3.0), press, changes_an_hour=0.5)
    assert seldom == pytest.approx(each @ [0.5, 2.5, 1.5])


def damage_at(mesh, node, *rows, **changes):
    """Damage an hour of a node under rows of check cases that pull by some stresses."""
    stress = {"stone": 140e6, "strike": -60e6, "third": 90e6, "fourth": 40e6, "fifth": -100e6}
    asked = duty(*rows, **changes)
    runs = used_cases(asked, pulled(mesh, *(stress[name] for name in check_cases_of(asked))), [])
    found = node_lives(asked, runs, {node: PLATE.curve()})[node]
    assert found.cycles["damage an hour"].sum() == pytest.approx(
        found.by_criterion[asked.criterion], rel=1e-9
    )
    return found.by_criterion[asked.criterion]


@pytest.mark.parametrize("seed", range(3))
def test_life_is_the_same_however_a_duty_is_cut(mesh, seed):
    """Rows in another order, each cut into several ones of the same case."""
    random = np.random.default_rng(seed)
    node = int(mesh.surface_nodes[100])
    states = ["stone", "strike", "third", "fourth", "fifth", UNLOADED]
    cases = []
    for k in range(5):
        after, state = random.choice(6), random.choice(5)
        also = {"after": states[after if after != state else 5]}
        cases.append(DutyCase(name=f"{k}", case=states[state], an_hour=random.uniform(0.1, 5.0), **also))
    pieces = [
        case.with_(name=f"{case.name}.{k}", an_hour=float(case.an_hour * part))
        for case in cases
        for k, part in enumerate(random.dirichlet(np.ones(random.integers(1, 5))))
    ]
    cut = [pieces[k] for k in random.permutation(len(pieces))]
    for changes_an_hour in (None, 0.7, 0.0):
        whole, again = (
            damage_at(mesh, node, *rows, changes_an_hour=changes_an_hour) for rows in (cases, cut)
        )
        assert again == pytest.approx(whole, rel=1e-9)


def test_stress_above_a_strength_is_said_beside_the_life(mesh):
    """Yield of A36 is 250, its tensile strength 400 MPa."""
    strong, breaking = (
        life_of(duty(STONE.with_(an_hour=1e-4)), [], shapes=pulled(mesh, stress)) for stress in (300e6, 410e6)
    )
    assert set(strong.table["above"]) == {"yield strength"}
    assert strong.table["peak in MPa"].to_numpy() == pytest.approx(300.0)
    last = "life in h that 97.5 % survive"
    assert strong.table[last].to_numpy() == pytest.approx(1e4 / damage_of(150e6))
    lines = "\n".join(life_lines(strong))
    assert "above yield strength:" in lines
    assert "up to 300 MPa" in lines
    assert "It does not know how far the steel flows" in lines
    assert set(breaking.table["above"]) == {"tensile strength"}
    assert set(in_words(breaking.table)[last]) == {"breaks"}
    assert not breaking.dataset.life.values[0, mesh.surface_nodes].any()
    assert not breaking.causes().to_numpy().any()
    lines = life_lines(breaking)
    assert lines[0].startswith("no machine hours: a crack at the first load at the worst node")
    assert "A36's tensile strength is 400 MPa: it breaks at the first such load" in lines[1]
    # in a later stage it breaks as that begins
    whole = duty(STONE.with_(an_hour=1e-4), stages=STAGES)
    stages = life_of_stages(whole, [strong, breaking])
    assert stages.dataset.life.values[0, mesh.surface_nodes] == pytest.approx(1000.0)
    assert stages.table[last].to_numpy() == pytest.approx(1000.0)


@pytest.mark.parametrize(
    ("damage", "hours", "spent"),
    [
        ((1e-4, np.inf), (1000.0, 500.0), (1000.0, 0.0)),  # breaks as the second stage begins
        ((np.inf, 1e-4), (1000.0, 500.0), (0.0, 0.0)),
        ((1e-4, 2e-4), (1000.0, 500.0), (1000.0, 4500.0)),  # 0.1, and 0.9 at twice the rate
        ((1e-3, 1.0), (2000.0, 1.0), (1000.0, 0.0)),  # cracks in the first stage
        ((0.0, 1e-5, 1e-4), (1e4, 2e4, 1.0), (1e4, 2e4, 8000.0)),
        (((0.0, 0.0),), (10.0,), BEYOND),  # without damage beyond what is told
    ],
)
def test_hours_until_damages_add_up_to_one(damage, hours, spent):
    np.testing.assert_allclose(hours_in_stages(np.array(damage), hours), spent)


def new_and_worn(whole, mesh):
    """Lives over two stages, pulled with 150 and 200 MPa, the second on a mesh a little beside."""
    worn = dataclasses.replace(mesh, nodes=mesh.nodes + np.array([0.0, 0.0, 1e-4]))
    return [
        life_of(one, [], shapes=pulled(shape, stress))
        for one, shape, stress in zip(whole.by_stage(), (mesh, worn), (150e6, 200e6), strict=True)
    ]


def test_damage_of_stages_adds_up_at_the_nearest_nodes(mesh):
    whole = duty(STONE.with_(an_hour=100.0), stages=STAGES)
    of_stages = new_and_worn(whole, mesh)
    found = life_of_stages(whole, of_stages)
    new, later = (100.0 * damage_of(one) for one in (75e6, 100e6))
    lasts = 1000.0 + (1.0 - 1000.0 * new) / later
    assert 1000.0 * new < 0.5
    surface = mesh.surface_nodes
    np.testing.assert_allclose(found.dataset.life.values[0, surface], lasts, rtol=1e-6)  # single precision
    assert found.dataset.part.values.tolist() == ["new, stones", "worn, stones"]
    shares = found.dataset.part_damage.values[:, surface[7]] * lasts
    np.testing.assert_allclose(shares, [1000.0 * new, 1.0 - 1000.0 * new], rtol=1e-6)
    assert found.causes().loc["stones", "web"] == pytest.approx(lasts)
    # the worst node stands first, also where it was none of the last stage's worst ones
    rest = dict(list(of_stages[1].nodes.items())[1:])
    again = life_of_stages(whole, [of_stages[0], dataclasses.replace(of_stages[1], nodes=rest)])
    assert again.table["node"].tolist() == [*again.nodes] == found.table["node"].tolist()
    assert found.duty == whole
    assert found.table["life in h that 97.5 % survive"].iloc[0] == pytest.approx(lasts)
    assert found.table["main part"].iloc[0] == "worn, stones"


def test_a_defect_grows_over_the_stages_of_a_duty(mesh):
    """1000 h at 150 MPa and then 200 MPa, 100 times an hour, by the growth law; 0.5 mm sleeps, by Miner."""
    castings = ({"region": "web", "defect_size": 3e-3}, {"region": "lugs", "defect_size": 5e-4})
    strong = PLATE.with_(castings=castings, fatigue_strength=400e6)
    whole = duty(STONE.with_(an_hour=100.0), stages=STAGES, material=strong)
    of_stages = new_and_worn(whole, mesh)
    table = life_of_stages(whole, of_stages).table.set_index("region")
    zero, once = np.zeros(1), np.full(1, 100.0)
    defect = Defect(3e-3, 125.0, 0.06)
    hours, size = growth(defect, zero, np.array([150e6]), once, 0.975, 1000.0)
    rest, _ = growth(defect._replace(size=size), zero, np.array([200e6]), once, 0.975)
    assert hours == 1000.0
    assert table.loc["web", "life in h, defect"] == pytest.approx(1000.0 + rest, rel=1e-6)
    alone = [one.table.set_index("region")["life in h, defect"] for one in of_stages]
    assert alone[1]["web"] < table.loc["web", "life in h, defect"] < alone[0]["web"]
    left = 1.0 - 1000.0 / alone[0]["lugs"]
    assert table.loc["lugs", "life in h, defect"] == pytest.approx(1000.0 + left * alone[1]["lugs"], rel=1e-6)
    assert np.isnan(table.loc["wings", "life in h, defect"])


@pytest.mark.slow
def test_runs_and_cases_make_damage_at_all_places_of_the_runs(history):
    mesh = meshes.mesh_named(history.case.flexible.mesh)
    run = DutyRun(name="pulled", folder=".", an_hour=1000.0)
    alone = life_of(duty(runs=(run,)), [history])
    both = life_of(duty(STONE, runs=(run,), changes_an_hour=0.0), [history], shapes=pulled(mesh, 140e6))
    assert both.dataset.part.values.tolist() == ["pulled: constant", "stones", BETWEEN]
    own = both.dataset.part_damage.sel(part="pulled: constant").values
    np.testing.assert_allclose(own, alone.dataset.part_damage.values[0], rtol=1e-3, atol=1e-9)
    known = both.dataset.place_damage.notnull().all(["shoe", "survival"]).values
    case = (both.dataset.place_damage.values - alone.dataset.place_damage.values)[..., known]
    np.testing.assert_allclose(case, 2.0 * damage_of(70e6), rtol=1e-3)
    assert set(both.nodes[int(both.table["node"][0])].cycles["run"]) <= {"pulled", "stones"}
    higher = dataclasses.replace(mesh, nodes=mesh.nodes + np.array([0.0, 0.0, 1e-4]))
    with pytest.raises(ValueError, match=f"must have the same mesh, got {len(mesh.nodes)} nodes"):
        life_of(duty(STONE, runs=(run,)), [history], shapes=pulled(higher, 140e6))
    with pytest.raises(ValueError, match="must have the same pins, got 'rigid' of 'pulled' and 'averaging'"):
        life_of(duty(STONE, runs=(run,)), [history], shapes=pulled(mesh, 140e6, pins="averaging"))


@pytest.mark.slow
@pytest.mark.simulation
def test_life_by_one_check_case_is_that_of_the_checks_cycles(tmp_path):
    (tmp_path / "shoe.toml").write_text('mesh = "coarse"\nlevels = [{ name = "pass", force = 574e3 }]\n')
    (tmp_path / "turns.toml").write_text(
        'check = "shoe.toml"\nsurvivals = [0.975]\nplane_nodes = 0\n[material]\nbase = "cast_nicrmo"\n'
        '[[cases]]\nname = "ridges"\ncase = "ridge 0.4 m, pass"\nan_hour = 4000\n'
    )
    found = life(tmp_path / "turns.toml", tmp_path / "life")
    check = ShoeCheck(mesh="coarse")
    shoe = CheckedShoe(check)
    only = case_shapes(check, ["ridge 0.4 m, pass"])
    stress = {"ridge": np.ascontiguousarray(only.stress_modes[shoe.mesh.surface_nodes][..., 0])}
    cycles = cycle_table(check, shoe, stress, [(UNLOADED, "ridge")]).set_index("region")["cycles to a crack"]
    for region, hours in found.causes().loc["ridges"].items():
        if hours < BEYOND:
            assert hours == pytest.approx(cycles[region] / 4000.0, rel=2e-3)
    assert (found.causes() < BEYOND).any(axis=None)
    page = (tmp_path / "life" / "life.html").read_text()
    titles = ("What cracks which region", "Contact below the treads", "Damage as it grows")
    assert [title in page for title in titles] == [True, True, False]
    # two treads of 574 kN on 0.18 m (docs/check-cases.md)
    level = roller_paths(found)["check cases"].set_index("tilt in mrad").loc[0.0]
    assert level["pressure in MPa"] == pytest.approx(528.0, rel=1e-3)
    assert level["path"] == "elastic"
    assert pd.read_csv(tmp_path / "life" / "causes.csv")["part"].tolist() == ["ridges"]
    with pytest.raises(ValueError, match=r"shoe: no check case \['rigde'\]; there are \['even, sand, pass'"):
        life(duty(STONE.with_(case="rigde"), check=str(tmp_path / "shoe.toml")))
