"""Sweeps: what is refused, designs, their files, digests of runs, and how long they take."""

import os

import numpy as np
import pytest

from exudyn_crawler import Case, CaseFile, FlexibleShoes, write_case
from exudyn_crawler.errors import CaseFileError, ImplausibleWarning
from exudyn_crawler.machines import Outputs
from exudyn_crawler.run.folder.progress import BEGIN, SIMULATE, rule_of_thumb
from exudyn_crawler.sweep import definition
from exudyn_crawler.sweep.answers import Answer, HotSpot
from exudyn_crawler.sweep.definition import Sweep, design_rows, read_sweep, run_digest
from exudyn_crawler.sweep.running import estimate, run_time
from exudyn_crawler.sweep.vary import Vary
from tests.sweep.cases import DAMPING, FORCE, STIFFNESS, small_case, small_sweep

FRICTION = ("contact.static_friction", "contact.dynamic_friction")


def test_runs_are_the_case_with_their_values_and_nothing_else_changed():
    sweep = small_sweep(vary=(Vary(key=STIFFNESS, values=(1e7, 2e7)), Vary(key=DAMPING, values=(5e4, 6e4))))
    varied = sweep.table()[["spring_stiffness", "spring_damping"]]
    assert varied.values.tolist() == [[1e7, 5e4], [1e7, 6e4], [2e7, 5e4], [2e7, 6e4]]
    found, *_ = sweep.case_of((2e7, 5e4))
    wanted = small_case().case
    terrain = wanted.terrain.with_(spring_stiffness=2e7, spring_damping=5e4)
    assert found.case == wanted.with_(name=found.case.name, terrain=terrain)
    assert found.outputs == sweep.outputs
    assert not found.outputs.figures


def test_a_digest_is_that_of_all_that_a_run_depends_on(monkeypatch):
    case = small_case()
    before = run_digest(case)
    other = ({"duration": 0.03}, {"outputs": Outputs(figures=False)}, {"case": case.case.with_(gravity=9.8)})
    assert len({before, *(run_digest(case.with_(**one)) for one in other)}) == 4
    assert run_digest(case.with_(case=case.case.with_(name="other"))) == before
    monkeypatch.setattr(definition, "_versions", lambda: ["another"])
    assert run_digest(case) != before


def test_a_digest_is_that_of_the_mesh_too(tmp_path):
    mesh = tmp_path / "own.msh"
    mesh.write_text("first")
    base = Case.stress("coarse")
    flexible = base.part(FlexibleShoes).with_(mesh=str(mesh))
    case = CaseFile(case=base.with_(flexible=flexible), duration=0.1)
    before = run_digest(case)
    assert run_digest(case) == before
    mesh.write_text("second")
    os.utime(mesh, ns=(1, 1))
    assert run_digest(case) != before


def test_the_same_case_twice_is_the_same_run():
    sweep = small_sweep(vary=(Vary(key="terrain.columns", low=9.0, high=10.0, count=4),))
    digests = [one.digest for one in sweep.planned]
    assert digests[0] == digests[1] != digests[2] == digests[3]
    # what was worked out of a sweep is no field of its copy
    assert sweep.with_(answers=sweep.answers).planned == sweep.planned


def test_units_and_meanings_are_those_of_the_case_and_the_catalogue():
    sweep = small_sweep(
        vary=(
            Vary(key=STIFFNESS, values=(1e7, 2e7)),
            Vary(key=FRICTION, name="friction", values=(1.0, 2.0), factor=True),
        ),
        answers=(FORCE, Answer(quantity="penetration", statistic="mean", name="sinkage")),
    )
    units = {"spring_stiffness": "N/m", "friction": "", FORCE.label: "N", "sinkage": "m"}
    assert sweep.units() == units
    assert sweep.meanings()["friction"] == "factor of contact.static_friction, contact.dynamic_friction"


def test_implausible_values_are_warned_of_before_anything_runs():
    sweep = small_sweep(vary=(Vary(key=STIFFNESS, values=(5.0, 6.0, 7.0, 8.0, 1e7), unit="N/m"),))
    with pytest.warns(ImplausibleWarning) as caught:
        sweep.table()
    lines = [str(one.message) for one in caught]
    assert lines[0].startswith("run 1: terrain.spring_stiffness: 5 N/m is outside of 100000 to 1e+11 N/m")
    assert lines[1].startswith("run 1: terrain.spring_stiffness: a unit sinks by ")
    assert lines[-1] == "2 more warnings of this sweep's values"
    assert len(lines) == 7


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"answers": (FORCE, FORCE)}, "name must be given for columns with the same name: joint_force"),
        ({"vary": (Vary(key=STIFFNESS, name="status", values=(1e7,)),)}, "with the same name: status"),
        (
            {"vary": tuple(Vary(key=STIFFNESS, name=name, values=(1e7, 2e7)) for name in "ab")},
            "a path must be varied once, got terrain.spring_stiffness again",
        ),
        ({"vary": ()}, "at least 1 item"),
        (
            {"vary": tuple(Vary(key=key, low=1e4, high=2e7, count=5000) for key in (STIFFNESS, DAMPING))},
            "runs must be at most 1000000, got a grid of at least 25000000",
        ),
    ],
)
def test_sweeps_that_make_no_sense_are_refused(changes, told):
    with pytest.raises(ValueError, match=told):
        small_sweep(**changes)


@pytest.mark.parametrize(
    ("key", "values", "told"),
    [
        (FRICTION[1], (0.2, 0.45, 0.5), r"run 2 \((\w+) = 0.45\): contact: \1 must not [^;]*$"),
        ("duration", (0.01, 0.02), "run 1 .*start must lie within the run of 0.01 s, got 0.015 s"),
    ],
)
def test_runs_that_cannot_be_are_refused_by_their_number(key, values, told):
    sweep = small_sweep(vary=(Vary(key=key, values=values),), answers=(FORCE.with_(start=0.015),))
    with pytest.raises(ValueError, match=told):
        sweep.planned  # noqa: B018


def test_a_sweep_read_back_is_the_same():
    sweep = small_sweep()
    assert Sweep.model_validate_json(sweep.model_dump_json()) == sweep


A, B = Vary(key="a", low=0.0, high=1.0, count=3), Vary(key="b", values=("x", "y"))
C, D = Vary(key="c", low=2.0, high=4.0), Vary(key="d", low=1.0, high=100.0, scale="log")


def test_a_grid_has_every_value_with_every_other_and_a_list_takes_them_in_step():
    assert design_rows("grid", (A, B), None, 1) == [(a, b) for a in (0.0, 0.5, 1.0) for b in ("x", "y")]
    short = Vary(key="a", low=0.0, high=1.0, count=2)
    assert design_rows("list", (short, B), None, 1) == [(0.0, "x"), (1.0, "y")]


def test_a_latin_hypercube_has_one_run_in_every_slice_of_everything():
    rows = np.array(design_rows("latin_hypercube", (C, D), 20, 1))
    slices = np.column_stack(((rows[:, 0] - 2.0) / 2.0, np.log(rows[:, 1]) / np.log(100.0)))
    assert (np.sort(np.floor(20 * slices), axis=0) == np.arange(20)[:, None]).all()


def test_sobol_points_fill_every_quarter_evenly():
    rows = np.array(design_rows("sobol", (C, Vary(key="e", low=0.0, high=1.0)), 16, 1))
    quarters = np.floor(2.0 * np.column_stack(((rows[:, 0] - 2.0) / 2.0, rows[:, 1])))
    assert np.unique(quarters, axis=0, return_counts=True)[1].tolist() == [4, 4, 4, 4]


def test_saltellis_points_are_two_samples_and_their_mixtures():
    rows = np.array(design_rows("saltelli", (C, Vary(key="e", low=0.0, high=1.0)), 8, 1)).reshape(8, 4, 2)
    first, mixed_1, mixed_2, second = rows.transpose(1, 0, 2)
    assert (mixed_1 == np.column_stack((second[:, 0], first[:, 1]))).all()
    assert (mixed_2 == np.column_stack((first[:, 0], second[:, 1]))).all()


@pytest.mark.parametrize("design", ["latin_hypercube", "sobol", "saltelli"])
def test_the_same_seed_draws_the_same(design):
    drawn = [design_rows(design, (C, D), 8, seed) for seed in (1, 1, 2)]
    assert drawn[0] == drawn[1]
    assert drawn[0] != drawn[2]


@pytest.mark.parametrize(
    ("design", "vary", "runs", "told"),
    [
        ("sobol", (A, B), 7, "runs must be a power of 2 with design 'sobol', got 7"),
        ("saltelli", (A, B), 9, "runs must be a power of 2 with design 'saltelli', got 9"),
        ("latin_hypercube", (A, B), None, "runs must be given"),
        ("grid", (A, B), 4, "runs must be left out"),
        ("grid", (C,), None, "c: count must be given for a grid"),
        ("list", (A, B), None, "as many values each with design 'list', got a 3, b 2"),
    ],
)
def test_numbers_of_runs_and_values_that_do_not_fit_are_refused(design, vary, runs, told):
    with pytest.raises(ValueError, match=told):
        design_rows(design, vary, runs, 1)


def test_a_rigid_second_takes_what_was_measured_and_three_take_three_times_as_long():
    short, long = small_case(1.0), small_case(3.0)
    begin = BEGIN["dragged"]
    assert run_time(long) - begin == pytest.approx(3.0 * (run_time(short) - begin))
    # docs/speed.md: 0.32 ms a step; profile of a run of 2 s: half of what its steps take goes to its history
    case = CaseFile(case=Case.translation(), duration=1.0)
    assert run_time(case) - begin == pytest.approx(500 * 2 * 0.32e-3, rel=0.2)


def test_a_rolled_second_takes_what_was_measured():
    # processor time beside other work: 2.4 ms a step of 24 rigid shoes, 3.7 ms with a flexible one
    rigid = Case.rolled()
    flexible = rigid.with_(flexible=FlexibleShoes.ph4100c("coarse").with_(shoes=(11,)))
    for case, measured in ((rigid, 2.4e-3), (flexible, 3.7e-3)):
        steps = 1.0 / case.solver.step
        one, two = (rule_of_thumb(CaseFile(case=case, duration=duration)) for duration in (1.0, 2.0))
        found = two[SIMULATE] - one[SIMULATE]
        assert found == pytest.approx(steps * measured, rel=0.2)


def test_finished_runs_tell_how_long_one_takes():
    found = [{"status": "done", "wall_time_s": 30.0}, {"status": "failed"}]
    told = "120 runs of about 30 s each (as 1 finished ones took): 30 min on 2 workers, 1 core"
    assert estimate(small_case(), 120, 2, found).startswith(told)
    assert "by a rule of thumb" in estimate(small_case(), 120, 2, [])


VARIED = f'[[vary]]\nkey = "{STIFFNESS}"\nvalues = [1e7, 2e7]\n'
ANSWERED = '[[answers]]\nquantity = "joint_force"\n'


def written(tmp_path, text):
    path = tmp_path / "sweep.toml"
    path.write_text(text)
    return path


def test_a_file_is_the_sweep_that_it_says(tmp_path):
    write_case(small_case(), tmp_path / "small.toml")
    path = written(tmp_path, f'case = "small.toml"\n{VARIED}{ANSWERED}')
    assert read_sweep(path) == small_sweep()


def test_a_case_may_stand_in_the_file_or_be_a_named_one(tmp_path):
    table = '[case]\nbase = "translation"\nduration = 0.5\n[case.terrain]\nspring_damping = 6e6\n'
    sweep = read_sweep(written(tmp_path, f"{VARIED}{ANSWERED}{table}"))
    assert (sweep.case.duration, sweep.case.case.terrain.spring_damping) == (0.5, 6e6)
    assert read_sweep(written(tmp_path, f'case = "turning"\n{VARIED}{ANSWERED}')).case.case.name == "turning"


def test_everything_may_be_said(tmp_path):
    text = """
    case = "stress"
    design = "latin_hypercube"
    runs = 5
    seed = 3
    outputs = { tables = true, figures = false }
    [[vary]]
    key = ["contact.static_friction", "contact.dynamic_friction"]
    name = "friction"
    low = 0.5
    high = 1.5
    factor = true
    [[answers]]
    model = "hot_spot"
    shoe = 13
    better = "more"
    [[answers]]
    quantity = "penetration"
    statistic = "mean"
    of = [1, 2]
    """
    sweep = read_sweep(written(tmp_path, text))
    assert sweep.vary == (Vary(key=FRICTION, name="friction", low=0.5, high=1.5, factor=True),)
    sinkage = Answer(quantity="penetration", statistic="mean", of=(1, 2))
    assert sweep.answers == (HotSpot(shoe=13, better="more"), sinkage)
    assert (len(sweep.rows), sweep.seed, sweep.outputs.tables) == (5, 3, True)


def test_meshes_are_found_from_the_files_folder(tmp_path):
    (tmp_path / "own.msh").touch()
    head = 'case = "stress"\n[[vary]]\nname = "plate"\n'
    text = f'{head}key = "flexible.mesh"\nvalues = ["coarse", "own.msh"]\n{ANSWERED}'
    assert read_sweep(written(tmp_path, text)).vary[0].values == ("coarse", str(tmp_path / "own.msh"))
    varied = 'key = ["shoe.mass", "flexible.mesh"]\nvalues = [1, 2]'
    settings = 'settings = [[4400.0, "own.msh"], [4500.0, "study"]]'
    sweep = read_sweep(written(tmp_path, f"{head}{varied}\n{settings}\n{ANSWERED}"))
    assert sweep.vary[0].settings == ((4400.0, str(tmp_path / "own.msh")), (4500.0, "study"))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("case = ", "not TOML"),
        (f"{VARIED}{ANSWERED}", "case must be a case file, the name of a case, or a table of one"),
        (f'case = "translation"\n{VARIED}', "answers: missing"),
        (f'case = "translation"\nruns = "many"\n{VARIED}{ANSWERED}', "runs: must be a "),
        (f'case = "translation"\ndesing = "grid"\n{VARIED}{ANSWERED}', "desing: unknown key; did you mean"),
        (f'case = "translation"\n{VARIED}[[answers]]\nmodel = "lives"\n', "answers[0].model: must be"),
        (
            f'case = "translation"\n{VARIED}[[answers]]\nquantity = "pin_force"\n',
            "pin_force_greatest: pin_force needs flexible shoes",
        ),
        (f"{VARIED}{ANSWERED}[case]\nbase = 'translations'\n", "base: no 'translations'; did you mean"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(tmp_path, text, told):
    with pytest.raises(CaseFileError) as refused:
        read_sweep(written(tmp_path, text))
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)


def test_files_that_are_not_there_are_told(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no sweep file .*sweep\.toml"):
        read_sweep(tmp_path / "sweep.toml")
    with pytest.raises(FileNotFoundError, match=r"^.*sweep\.toml: there is no case file .*other\.toml"):
        read_sweep(written(tmp_path, f'case = "other.toml"\n{VARIED}{ANSWERED}'))


def test_bounds_and_values_may_have_units(tmp_path):
    bounds = f'[[vary]]\nkey = "{STIFFNESS}"\nlow = "5 N/m"\nhigh = "80 MN/m"\ncount = 2\n'
    listed = f'[[vary]]\nkey = "{DAMPING}"\nvalues = ["1 kN s/m", "2e3 N s/m"]\n'
    path = written(tmp_path, f'[case]\nbase = "translation"\n{bounds}{listed}{ANSWERED}')
    first, second = read_sweep(path).vary
    # a unit in words says that 5 N/m are meant
    assert (first.low, first.high, first.unit) == (5.0, 80e6, "N/m")
    assert second.values == (1e3, 2e3)
    for mixed, told in (
        (
            '"1 kN s/m", 2',
            r"values\[1\] = 2 must have a unit as '1 kN s/m' has, such as '2 kN s/m' or '2 N s/m'$",
        ),
        ('"1 kN s/m", 0.5', r"values\[1\] = 0\.5 must have a unit"),
    ):
        (tmp_path / "mixed.toml").write_text(path.read_text().replace('"1 kN s/m", "2e3 N s/m"', mixed))
        with pytest.raises(CaseFileError, match=told):
            read_sweep(tmp_path / "mixed.toml")
    (tmp_path / "mixed.toml").write_text(path.read_text().replace('"5 N/m"', "5"))
    with pytest.raises(
        CaseFileError, match=r"low = 5 must have a unit as '80 MN/m' has, such as '5 MN/m' or '5 N/m'$"
    ):
        read_sweep(tmp_path / "mixed.toml")
    path.write_text(path.read_text().replace("5 N/m", "5 MPa"))
    with pytest.raises(CaseFileError, match=r"low: must be a number, or such as '1 %', got '5 MPa'"):
        read_sweep(path)
