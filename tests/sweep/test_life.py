"""Life as an answer: that of a duty of the run alone, and what cannot be asked."""

import pytest

from exudyn_crawler import Case, CaseFile, CaseRun, Duty, DutyRun, FatigueMaterial, Life, read_sweep
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.results.stress.regions import shoe_regions
from tests.sweep.cases import STIFFNESS, small_case

WEAK = FatigueMaterial.a36().with_(fatigue_strength=90e6)
"""So weak that the small stresses of a short run wear it out."""


@pytest.mark.slow
def test_life_is_that_of_a_duty_of_the_run_alone(flexible_run):
    history = flexible_run[0]
    part = DutyRun(name="run", folder=".", begin=0.01, share=0.5)
    found = life_of(Duty(runs=(part,), material=WEAK, survivals=(0.9,), plane_nodes=0), [history])
    lives = found.dataset.life[0]
    how = {"material": WEAK, "survival": 0.9, "begin": 0.01, "share": 0.5}
    assert Life(**how).of_run(CaseRun(history, None, None)) == float(lives.min())
    own = float(lives[shoe_regions(found.whole, history.case.track) == "wings"].min())
    assert Life(**how, region="wings").of_run(CaseRun(history, None, None)) == own > float(lives.min())


def test_lives_that_the_runs_do_not_have_are_refused():
    case = CaseFile(case=Case.stress("coarse"), duration=1.0)
    Life(material=WEAK, region="roller path").check(case)
    for answer, told in ((Life(material=WEAK, begin=2.0), "begin must lie within the run of 1 s, got 2 s"),):
        with pytest.raises(ValueError, match=told):
            answer.check(case)
    with pytest.raises(ValueError, match="life needs flexible shoes, the case has none"):
        Life(material=WEAK).check(small_case())
    with pytest.raises(ValueError, match="an_hour or share must be given, got neither or both"):
        Life(material=WEAK, share=0.5, an_hour=10.0)


def test_a_file_names_the_material(tmp_path):
    path = tmp_path / "sweep.toml"
    path.write_text(
        f'case = "stress"\n[[vary]]\nkey = "{STIFFNESS}"\nvalues = [1e7]\n'
        '[[answers]]\nmodel = "life"\nmaterial = { base = "a36", fatigue_strength = 90e6 }\n'
    )
    assert read_sweep(path).answers == (Life(material=WEAK),)
