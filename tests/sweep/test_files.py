"""Sweep files: what they may say, and one line for what they may not."""

import pytest

from exudyn_crawler import write_case
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.sweep.answers import Answer, HotSpot
from exudyn_crawler.sweep.definition import read_sweep
from exudyn_crawler.sweep.vary import Vary
from tests.sweep.cases import STIFFNESS, small_case, small_sweep

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
    [outputs]
    tables = true
    figures = false
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
    keys = ("contact.static_friction", "contact.dynamic_friction")
    assert sweep.vary == (Vary(key=keys, name="friction", low=0.5, high=1.5, factor=True),)
    hot, sinkage = (
        HotSpot(shoe=13, better="more"),
        Answer(quantity="penetration", statistic="mean", of=(1, 2)),
    )
    assert sweep.answers == (hot, sinkage)
    assert (len(sweep.rows), sweep.seed, sweep.outputs.tables) == (5, 3, True)


def test_meshes_are_found_from_the_files_folder(tmp_path):
    text = f'case = "stress"\n[[vary]]\nkey = "flexible.mesh"\nvalues = ["coarse", "own.msh"]\n{ANSWERED}'
    sweep = read_sweep(written(tmp_path, text))
    assert sweep.vary[0].values == ("coarse", str(tmp_path / "own.msh"))
    varied = 'name = "plate"\nkey = ["shoe.mass", "flexible.mesh"]\nvalues = [1, 2]'
    settings = 'settings = [[4400.0, "own.msh"], [4500.0, "study"]]'
    sweep = read_sweep(written(tmp_path, f'case = "stress"\n[[vary]]\n{varied}\n{settings}\n{ANSWERED}'))
    assert sweep.vary[0].settings == ((4400.0, str(tmp_path / "own.msh")), (4500.0, "study"))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("case = ", "not TOML"),
        (f"{VARIED}{ANSWERED}", "case must be a case file, the name of a case, or a table of one"),
        (f'case = "translation"\n{VARIED}', "answers: missing"),
        (f'case = "translation"\nruns = "many"\n{VARIED}{ANSWERED}', "runs: Input should be a valid"),
        (
            f'case = "translation"\ndesing = "grid"\n{VARIED}{ANSWERED}',
            "desing: unknown key; did you mean",
        ),
        (
            f'case = "translation"\n{VARIED}[[answers]]\nmodel = "lives"\n',
            "answers[0].model: Input should be",
        ),
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
    with pytest.raises(FileNotFoundError, match=r"no case file .*other\.toml"):
        read_sweep(written(tmp_path, f'case = "other.toml"\n{VARIED}{ANSWERED}'))
