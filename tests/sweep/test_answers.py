"""Answers of a run against its history by hand, and those that it cannot give."""

import numpy as np
import pytest

from exudyn_crawler import Case, CaseFile, Duty
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.results.history.catalogue import QUANTITIES
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.results.stress.hot_spots import shoe_regions
from exudyn_crawler.results.stress.recovery import StressResults
from exudyn_crawler.sweep.answers import Answer, HotSpot, Life
from exudyn_crawler.sweep.definition import read_sweep
from tests.stress_results import WEAK
from tests.sweep.cases import STIFFNESS, small_case


@pytest.fixture(scope="module")
def run(translation):
    return CaseRun(translation, None, None)


@pytest.fixture(scope="module")
def bent_run(flexible_run):
    return CaseRun(flexible_run[0], StressResults(*flexible_run[1:], {}, whole=None), None)


def answered(run, **given):
    return Answer(**given).of_run(run)


def test_vectors_count_by_their_length_or_an_axis(run, translation):
    force = translation.joint_force.values
    assert answered(run, quantity="joint_force") == np.linalg.norm(force, axis=-1).max()
    assert answered(run, quantity="joint_force", axis="x", statistic="least") == force[..., 0].min()


def test_statistics_are_those_of_all_times_and_items_together(run, translation):
    heave = translation.unit_heave.values
    wanted = {
        "greatest": heave.max(),
        "least": heave.min(),
        "largest": np.abs(heave).max(),
        "mean": heave.mean(),
        "rms": np.sqrt((heave**2).mean()),
        "range": np.ptp(heave),
        "end": heave[-1].mean(),
    }
    found = {name: answered(run, quantity="unit_heave", statistic=name) for name in wanted}
    assert found == pytest.approx(wanted, rel=1e-12)


def test_shoes_and_times_are_chosen(run, translation):
    part = translation.position.sel(shoe=[2, 13], axis="z").values[translation.time.values >= 0.2 - 1e-9]
    chosen = {"of": (2, 13), "axis": "z", "start": 0.2}
    assert answered(run, quantity="position", statistic="mean", **chosen) == pytest.approx(part.mean())
    first = {"start": 0.0, "end": 0.002, "statistic": "range"}
    assert answered(run, quantity="drive_force", **first) == np.ptp(translation.drive_force.values[:2])


def test_contacts_are_told_by_shoe(run, translation):
    forces = translation.normal_force.values + translation.friction_force.values
    own = forces[:, translation.contact_shoe.values == 5].sum(axis=1)
    found = answered(run, quantity="contact_force", of=(5,), statistic="mean")
    assert found == pytest.approx(np.linalg.norm(own, axis=-1).mean())


def test_hot_spots_and_highest_stresses_are_those_of_the_tables(flexible_run, bent_run):
    _, stress, tables = flexible_run
    assert HotSpot(shoe=13, rank=2).of_run(bent_run) == tables[13]["value"].iloc[1]
    highest = answered(bent_run, quantity="highest_von_mises", of=(7,))
    assert highest == float(stress.highest_von_mises.sel(shoe=7).max())
    # the hottest spot of a shoe is its highest stress
    assert HotSpot(shoe=7).of_run(bent_run) == pytest.approx(highest, rel=1e-6)


VECTOR = "quantity must be a number or a vector over time, .*of a shoe, .*"


@pytest.mark.parametrize(
    ("kind", "given", "told"),
    [
        (Answer, {"quantity": "joint_forc"}, f"{VECTOR}, got 'joint_forc'; the nearest is 'joint_force'"),
        (Answer, {"quantity": "peak_von_mises"}, f"{VECTOR}, got 'peak_von_mises'"),
        (Answer, {"quantity": "axes"}, f"{VECTOR}, got 'axes'"),
        (Answer, {"quantity": "tread_foot"}, f"{VECTOR}, got 'tread_foot'"),
        (Answer, {"quantity": "drive_force", "axis": "x"}, "axis must be left out with drive_force"),
        (Answer, {"quantity": "joint_force", "start": 1.0, "end": 0.5}, "end must be greater than start ="),
        (
            Life,
            {"material": WEAK, "share": 0.5, "an_hour": 9.0},
            "an_hour or share must be given, got neither or both",
        ),
    ],
)
def test_answers_that_make_no_sense_are_refused(kind, given, told):
    with pytest.raises(ValueError, match=told):
        kind(**given)


SMALL, STRESS = small_case(), CaseFile(case=Case.stress("coarse"), duration=1.0)


@pytest.mark.parametrize(
    ("case", "answer", "told"),
    [
        (SMALL, Answer(quantity="pin_force"), "pin_force needs flexible shoes, the case has none"),
        (SMALL, Answer(quantity="highest_von_mises"), "needs flexible shoes"),
        (
            SMALL,
            Answer(quantity="rail_force"),
            r"needs a side frame on an open track, the case has another gear\.kind",
        ),
        (SMALL, Answer(quantity="joint_force", of=(2, 3)), r"of must be links of \[1, 2\], got \[3\]"),
        (
            SMALL,
            Answer(quantity="drive_force", of=(1,)),
            "of must be left out, drive_force is of the whole track",
        ),
        (SMALL, Answer(quantity="joint_force", end=0.5), "end must lie within the run of 0.02 s, got 0.5 s"),
        (SMALL, HotSpot(shoe=3), r"shoe must be a flexible one \(none\), got 3"),
        (SMALL, Life(material=WEAK), "life needs flexible shoes, the case has none"),
        (STRESS, Answer(quantity="pin_force", of=(1,)), r"of must be pins of .*, got \[1\]"),
        (STRESS, Life(material=WEAK, begin=2.0), "begin must lie within the run of 1 s, got 2 s"),
    ],
)
def test_answers_that_the_runs_cannot_give_are_refused(case, answer, told):
    with pytest.raises(ValueError, match=told):
        answer.check(case)


def test_answers_of_flexible_shoes_are_those_of_the_case():
    flexible = STRESS.case.part(FlexibleShoes).shoes
    Answer(quantity="pin_force", of=(flexible[0],)).check(STRESS)
    HotSpot(shoe=flexible[-1]).check(STRESS)
    Life(material=WEAK, region="roller path").check(STRESS)


def test_rollers_on_a_shoe_are_an_answer_of_a_rolled_case(rolled):
    answer = Answer(quantity="rail_force", of=(5,), axis="z", statistic="least")
    answer.check(CaseFile(case=rolled.case, duration=0.2))
    found = answer.of_run(CaseRun(rolled, None, None))
    assert found == float(rolled.rail_force.sel(shoe=5, axis="z").min()) < -1e5


@pytest.mark.parametrize("name", QUANTITIES)
def test_any_quantity_is_an_answer_or_refused_before_anything_runs(name, run, bent_run, rolled):
    given = 0
    for one in (bent_run, run, CaseRun(rolled, None, None)):
        try:
            answer = Answer(quantity=name)
            answer.check(CaseFile(case=one.history.case, duration=one.history.duration))
        except ValueError:
            continue
        assert np.isfinite(answer.of_run(one))
        given += 1
    real = QUANTITIES[name].numbers in ("double", "single") and "time" in QUANTITIES[name].dimensions
    # none of the runs has such ground, goes round a tumbler or has bogies or arms
    real = real and not {"cells", "closed", "gear.bogies", "gear.arms"} & set(QUANTITIES[name].needs)
    assert (
        given > 0 or not real or name in ("point", "patch", "tread_foot", "axes") or "terrain_motion" in name
    )


@pytest.mark.slow
def test_life_is_that_of_a_duty_of_the_run_alone(bent_run):
    history = bent_run.history
    part = DutyRun(name="run", folder=".", begin=0.01, share=0.5)
    found = life_of(Duty(runs=(part,), material=WEAK, survivals=(0.9,), plane_nodes=0), [history])
    lives = found.dataset.life[0]
    how = {"material": WEAK, "survival": 0.9, "begin": 0.01, "share": 0.5}
    assert Life(**how).of_run(bent_run) == float(lives.min())
    own = float(lives[shoe_regions(found.whole, history.case.track) == "wings"].min())
    assert Life(**how, region="wings").of_run(bent_run) == own > float(lives.min())


def test_a_file_names_the_material(tmp_path):
    path = tmp_path / "sweep.toml"
    path.write_text(
        f'case = "stress"\n[[vary]]\nkey = "{STIFFNESS}"\nvalues = [1e7]\n'
        '[[answers]]\nmodel = "life"\nmaterial = { base = "a36", fatigue_strength = 90e6 }\n'
    )
    assert read_sweep(path).answers == (Life(material=WEAK),)
