"""Duty files: read, checked, and refused by the key at fault."""

import pytest

from exudyn_crawler import Duty, FatigueMaterial, read_duty
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.results.life.duty import DutyRun

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


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "pit.toml"
    path.write_text(TEXT)
    return path


def test_a_duty_is_read_with_folders_from_where_it_lies(file):
    duty = read_duty(file)
    assert duty.name == "pit"
    assert duty.material == FatigueMaterial.cast_manganese().with_(roughness=1e-4)
    assert [run.folder for run in duty.runs] == [str(file.parent / "runs/propel"), "/elsewhere/cycle"]
    assert duty.times_an_hour([20.0, 25.0]) == pytest.approx([0.07 * 3600.0 / 20.0, 75.0])
    # a longer run of the same part of the hours happens as much less often
    assert duty.times_an_hour([40.0, 25.0])[0] == pytest.approx(0.07 * 3600.0 / 40.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
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
    ],
)
def test_faults_are_told_by_their_keys(file, old, new, words):
    file.write_text(TEXT.replace(old, new))
    with pytest.raises(CaseFileError, match=words):
        read_duty(file)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError, match="no duty file"):
        read_duty(tmp_path / "none.toml")


def test_hours_that_are_more_than_full_are_refused():
    runs = tuple(DutyRun(name=name, folder=".", an_hour=100.0) for name in ("dig", "dump"))
    duty = Duty(runs=runs, material=FatigueMaterial.a36())
    assert duty.times_an_hour([10.0, 20.0]) == [100.0, 100.0]
    with pytest.raises(ValueError, match=r"got 1.667 of them: dig 0.5556, dump 1.111"):
        duty.times_an_hour([20.0, 40.0])
