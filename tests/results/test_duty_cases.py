"""Check cases and stages of wear in a duty: damage against hand sums and the check's own cycles, faults."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

import meshes
from exudyn_crawler import Duty, FatigueMaterial, life, read_duty
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.life_run import roller_paths
from exudyn_crawler.results.checks.cases import ShoeCheck
from exudyn_crawler.results.checks.solve import UNLOADED, CheckedShoe, case_shapes, cycle_table
from exudyn_crawler.results.life.duty import DutyCase, DutyRun, DutyStage
from exudyn_crawler.results.life.life import BETWEEN, BEYOND, hours_in_stages, life_of, life_of_stages
from fem import Shapes
from fem.defects import Defect, growth
from meshes.shoe import STEEL, joint_interfaces

STRENGTH, SENSITIVITY, KNEE = 100e6, 0.3, 1e6
MATERIAL = FatigueMaterial.a36().with_(
    fatigue_strength=STRENGTH, mean_sensitivity=SENSITIVITY, roughness=1e-6
)
STONE = DutyCase(name="stones", case="stone", an_hour=2.0)
STRIKE = DutyCase(name="strikes", case="strike", an_hour=0.25)


def duty(*cases: DutyCase, **changes) -> Duty:
    given = {"cases": cases, "material": MATERIAL, "plane_nodes": 0, "survivals": (0.975,)}
    return Duty(**given | changes)


def pulled(mesh, *stresses: float) -> Shapes:
    """Shoe under cases that pull all of it along x by these stresses, Pa."""
    stress = np.zeros((len(mesh.nodes), 6, len(stresses)))
    stress[:, 0] = stresses
    # strain that has this stress in the elements, too
    strain = np.diag([1.0, -STEEL.poissons_ratio, -STEEL.poissons_ratio]) / STEEL.youngs_modulus
    modes = np.einsum("ni,ij,k->njk", mesh.nodes, strain, np.array(stresses))
    return Shapes(mesh, STEEL, tuple(joint_interfaces(mesh)), modes, stress)


@pytest.fixture(scope="module")
def mesh():
    return meshes.mesh_named("coarse")


def damage_of(amplitude: float) -> float:
    """Damage of a cycle from zero to twice the amplitude, by hand: R = 0, slope 5, survival as tested."""
    design = MATERIAL.factors()["design"]
    return ((1.0 + SENSITIVITY) * amplitude * design / STRENGTH) ** 5 / KNEE


def test_damage_of_check_cases_is_the_sum_by_hand(mesh):
    found = life_of(duty(STONE, STRIKE, plane_nodes=3), [], shapes=pulled(mesh, 60e6, 140e6))
    parts = {"stones": 2.0 * damage_of(30e6), "strikes": 0.25 * damage_of(70e6)}
    parts[BETWEEN] = 0.25 * damage_of(70e6)  # from the least to the greatest, as often as the rarest
    assert found.dataset.part.values.tolist() == list(parts)
    node = mesh.surface_nodes[100]
    np.testing.assert_allclose(found.dataset.part_damage.sel(node=node), list(parts.values()), rtol=1e-9)
    np.testing.assert_allclose(found.dataset.life.sel(node=node), [1.0 / sum(parts.values())], rtol=1e-9)
    # the critical plane looks along the pull, to half a degree
    on_plane = float(found.dataset.plane_damage.max())
    assert on_plane == pytest.approx(parts["stones"] + parts["strikes"], rel=1e-3)
    # an even stress is one that any mesh has
    assert float(found.dataset.stress_error.max()) < 1e-6
    causes = found.causes()
    assert causes.loc["stones", "web"] == pytest.approx(1.0 / parts["stones"])
    assert set(causes.columns) == set(found.regions[mesh.surface_nodes])


def test_a_cycle_between_two_cases_has_their_range_and_mean(mesh):
    case = STONE.with_(case="strike", after="stone")
    found = life_of(duty(case), [], shapes=pulled(mesh, 140e6, 60e6))
    curve = MATERIAL.curve()
    expected = 2.0 * curve.damage(np.array([40e6]), np.array([100e6]), (0.975,))[0, 0]
    np.testing.assert_allclose(found.dataset.part_damage.values[0, mesh.surface_nodes], expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("damage", "hours", "spent"),
    [
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
    stages = (DutyStage(name="new", hours=1000.0), DutyStage(name="worn", hours=500.0))
    case = STONE.with_(an_hour=100.0)
    whole = duty(case, stages=stages)
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
    stages = (DutyStage(name="new", hours=1000.0), DutyStage(name="worn", hours=500.0))
    castings = ({"region": "web", "defect_size": 3e-3}, {"region": "lugs", "defect_size": 5e-4})
    strong = MATERIAL.with_(castings=castings, fatigue_strength=400e6)
    whole = duty(STONE.with_(an_hour=100.0), stages=stages, material=strong)
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
def test_runs_and_cases_make_damage_at_all_places_of_the_runs(flexible_run, mesh):
    history = flexible_run[0]
    run = DutyRun(name="pulled", folder=".", an_hour=1000.0)
    alone = life_of(duty(runs=(run,)), [history])
    both = life_of(duty(STONE, runs=(run,), changes_an_hour=0.0), [history], shapes=pulled(mesh, 140e6))
    assert both.dataset.part.values.tolist() == ["pulled: constant", "stones", BETWEEN]
    own = both.dataset.part_damage.sel(part="pulled: constant").values
    np.testing.assert_allclose(own, alone.dataset.part_damage.values[0], rtol=1e-3, atol=1e-9)
    known = both.dataset.place_damage.notnull().all(["shoe", "survival"]).values
    case = both.dataset.place_damage.values - alone.dataset.place_damage.values
    np.testing.assert_allclose(case[..., known], 2.0 * damage_of(70e6), rtol=1e-3)
    assert set(both.nodes[int(both.table["node"][0])].cycles["run"]) <= {"pulled", "stones"}
    higher = dataclasses.replace(mesh, nodes=mesh.nodes + np.array([0.0, 0.0, 1e-4]))
    with pytest.raises(ValueError, match="runs and check cases must have the same mesh, got 13773 nodes"):
        life_of(duty(STONE, runs=(run,)), [history], shapes=pulled(higher, 140e6))


TEXT = """
check = "shoe.toml"
material = { base = "cast_nicrmo" }
stages = [{ name = "new", hours = 9000 }, { name = "worn", hours = 1000, check = "coarse" }]
cases = [
    { name = "stones", case = "stone", an_hour = 3 },
    { name = "ends", case = "ends", an_hour = 1, stage = "worn" },
]
"""


def test_a_duty_of_cases_is_read_with_checks_from_where_it_lies(tmp_path):
    (tmp_path / "wear.toml").write_text(TEXT)
    (tmp_path / "shoe.toml").write_text('mesh = "coarse"\n')
    new, worn = read_duty(tmp_path / "wear.toml").by_stage()
    assert (new.check, worn.check) == (str(tmp_path / "shoe.toml"), "coarse")
    assert [[case.name for case in one.cases] for one in (new, worn)] == [["stones"], ["stones", "ends"]]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('name = "ends"', 'name = "stones"', "names must differ"),
        ('stage = "worn"', 'stage = "old"', r"stage must be one of \['new', 'worn'\], got \['old'\]"),
        ('name = "worn"', 'name = "new"', "the stages' names must differ"),
        ("an_hour = 3", 'an_hour = 3, stage = "worn"', "runs or cases must be given, got neither"),
        ("hours = 9000", "hours = 0", r"stages\[0\].hours"),
    ],
)
def test_faults_of_cases_and_stages_are_told_by_their_keys(tmp_path, old, new, words):
    (tmp_path / "wear.toml").write_text(TEXT.replace(old, new, 1))
    with pytest.raises(CaseFileError, match=words):
        read_duty(tmp_path / "wear.toml")


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
    assert "What cracks which region" in page
    assert "Contact below the treads" in page
    # two treads of 574 kN on 0.18 m (docs/check-cases.md)
    level = roller_paths(found)["check cases"].set_index("tilt in mrad").loc[0.0]
    assert level["pressure in MPa"] == pytest.approx(528.0, rel=1e-3)
    assert level["path"] == "elastic"
    assert "Damage as it grows" not in page
    assert pd.read_csv(tmp_path / "life" / "causes.csv")["part"].tolist() == ["ridges"]
    with pytest.raises(ValueError, match=r"shoe: no check case \['rigde'\]; there are \['even, sand, pass'"):
        life(duty(STONE.with_(case="rigde"), check=str(tmp_path / "shoe.toml")))
