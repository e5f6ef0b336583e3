"""Sweeps: their runs, digests and refusals."""

import os

import pytest

from exudyn_crawler import Answer, Case, CaseFile, Outputs, Sweep, Vary
from exudyn_crawler.errors import ImplausibleWarning
from exudyn_crawler.sweep import definition
from exudyn_crawler.sweep.definition import run_digest
from tests.sweep.cases import DAMPING, FORCE, STIFFNESS, small_case, small_sweep

FRICTION = ("contact.static_friction", "contact.dynamic_friction")


def test_runs_are_the_case_with_their_values_and_nothing_else_changed():
    sweep = small_sweep(vary=(Vary(key=STIFFNESS, values=(1e7, 2e7)), Vary(key=DAMPING, values=(5e4, 6e4))))
    table = sweep.table()
    assert table[["spring_stiffness", "spring_damping"]].values.tolist() == [
        [1e7, 5e4],
        [1e7, 6e4],
        [2e7, 5e4],
        [2e7, 6e4],
    ]
    found, _ = sweep.case_of((2e7, 5e4))
    wanted = small_case().case
    terrain = wanted.terrain.with_(spring_stiffness=2e7, spring_damping=5e4)
    assert found.case == wanted.with_(name=found.case.name, terrain=terrain)
    assert found.outputs == sweep.outputs
    assert not found.outputs.figures


def test_a_digest_is_that_of_all_that_a_run_depends_on(monkeypatch):
    case = small_case()
    other = [
        case.with_(duration=0.03),
        case.with_(outputs=Outputs(figures=False)),
        case.with_(case=case.case.with_(gravity=9.8)),
    ]
    assert len({run_digest(one) for one in (case, *other)}) == 4
    assert run_digest(case.with_(case=case.case.with_(name="other"))) == run_digest(case)
    before = run_digest(case)
    monkeypatch.setattr(definition, "_versions", lambda: ["another"])
    assert run_digest(case) != before


def test_a_digest_is_that_of_the_mesh_too(tmp_path):
    mesh = tmp_path / "own.msh"
    mesh.write_text("first")
    base = Case.stress("coarse")
    case = base.with_(flexible=base.flexible_shoes().with_(mesh=str(mesh)))
    before = run_digest(CaseFile(case=case, duration=0.1))
    assert run_digest(CaseFile(case=case, duration=0.1)) == before
    mesh.write_text("second")
    os.utime(mesh, ns=(1, 1))
    assert run_digest(CaseFile(case=case, duration=0.1)) != before


def test_the_same_case_twice_is_the_same_run():
    sweep = small_sweep(vary=(Vary(key="terrain.columns", low=9.0, high=10.0, count=4),))
    digests = [one.digest for one in sweep.planned]
    assert digests[0] == digests[1] != digests[2] == digests[3]


def test_units_and_meanings_are_those_of_the_case_and_the_catalogue():
    sweep = small_sweep(
        vary=(
            Vary(key=STIFFNESS, values=(1e7, 2e7)),
            Vary(key=FRICTION, name="friction", values=(1.0, 2.0), factor=True),
        ),
        answers=(FORCE, Answer(quantity="penetration", statistic="mean", name="sinkage")),
    )
    units = {"spring_stiffness": "N/m", "friction": "", "joint_force_greatest": "N", "sinkage": "m"}
    assert sweep.units() == units
    assert sweep.meanings()["friction"] == "factor of contact.static_friction, contact.dynamic_friction"


def test_runs_whose_values_do_not_fit_each_other_are_refused_by_their_number():
    sweep = small_sweep(vary=(Vary(key="contact.dynamic_friction", values=(0.2, 0.45, 0.5)),))
    told = (
        r"run 2 \(dynamic_friction = 0.45\): contact: dynamic_friction must not .*; 2 of 3 runs are at fault"
    )
    with pytest.raises(ValueError, match=told):
        sweep.planned  # noqa: B018


def test_answers_are_checked_against_every_run():
    sweep = small_sweep(
        vary=(Vary(key="duration", values=(0.01, 0.02)),),
        answers=(Answer(quantity="joint_force", start=0.015),),
    )
    with pytest.raises(ValueError, match=r"run 1 .*start must lie within the run of 0.01 s, got 0.015 s"):
        sweep.planned  # noqa: B018


def test_what_varies_without_effect_is_warned_of():
    sweep = small_sweep(vary=(Vary(key="solver.quiet_step", values=(0.004, 0.008), unit="s"),))
    with pytest.warns(ImplausibleWarning, match="solver.quiet_step: it changes nothing with a drive that"):
        sweep.planned  # noqa: B018


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"answers": (FORCE, FORCE)}, "name must be given where columns would be the same: joint_force"),
        ({"vary": (Vary(key=STIFFNESS, name="status", values=(1e7,)),)}, "would be the same: status"),
        (
            {"vary": tuple(Vary(key=STIFFNESS, name=name, values=(1e7, 2e7)) for name in "ab")},
            "a path must vary once, got terrain.spring_stiffness again",
        ),
        ({"vary": ()}, "at least 1 item"),
        (
            {
                "vary": (
                    Vary(key=STIFFNESS, low=1e7, high=2e7, count=5000),
                    Vary(key=DAMPING, low=1e4, high=2e4, count=5000),
                )
            },
            "runs must be at most 1000000, got a grid of at least 25000000",
        ),
    ],
)
def test_sweeps_that_make_no_sense_are_refused(changes, told):
    with pytest.raises(ValueError, match=told):
        small_sweep(**changes)


def test_a_sweep_read_back_is_the_same():
    sweep = small_sweep()
    assert Sweep.model_validate_json(sweep.model_dump_json()) == sweep
