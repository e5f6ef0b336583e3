"""Study of the closed track: its cases and a reduced run."""

from pathlib import Path

import pytest

from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.views.tables import cell_text
from studies import closed, commands
from tests.test_terminal import check_tables


def test_chain_goes_once_round_in_the_whole_run():
    whole = closed.study_cases()[closed.CLOSED]
    travel = whole.case.drive.travel(whole.duration)
    assert travel == pytest.approx(whole.case.track.shoe_count * whole.case.track.pitch, rel=1e-9)


def test_all_rollers_pass_a_shoe_in_the_middle_of_the_open_track():
    case = closed.study_cases()[closed.ROLLED].case
    frame, way = case.gear, case.drive.travel(closed.OPEN_DURATION)
    middle = case.track.com_positions(0.0)[case.track.shoe_count // 2 - 1, 0]
    assert frame.start + frame.rollers[-1] < middle
    assert frame.start + way + frame.rollers[0] > middle
    case.check_support(closed.OPEN_DURATION)


def test_rolled_track_differs_from_its_trial_by_the_tension_alone():
    cases = closed.study_cases()
    whole, rolled, trial = (cases[name].case for name in (closed.CLOSED, closed.ROLLED, closed.TRIAL))
    assert trial.gear == rolled.gear.with_(end_tension=closed.TENSION)
    assert trial.with_(name=rolled.name, gear=rolled.gear) == rolled
    assert rolled.gear.rollers == whole.gear.rollers
    assert (rolled.terrain, rolled.contact) == (whole.terrain, whole.contact)
    assert closed.rolled_case(closed.TENSION).gear == trial.gear


def test_one_track_stands_in_a_turn_about_it_and_both_go_against_each_other_on_the_spot():
    for name, left in ((closed.ABOUT_LEFT, 0.0), (closed.ON_SPOT, -1.0)):
        case = closed.study_cases()[name].case
        speed, rate = case.drive.speed.values[-1], case.drive.turn_rate.values[-1]
        of_tracks = speed - rate * case.gear.middles
        assert of_tracks[1] == pytest.approx(left * of_tracks[0], abs=0.05 * of_tracks[0])
        case.check_support(closed.study_cases()[name].duration)


def test_a_shoe_may_be_flexible():
    assert closed.study_cases(flexible=7)[closed.CLOSED].case.part(FlexibleShoes).shoes == (7,)
    assert closed.study_cases()[closed.CLOSED].case.flexible is None


@pytest.mark.slow
@pytest.mark.simulation
def test_reduced_study_has_loads_round_the_loop_and_in_mid_track(monkeypatch, capsys):
    made = runs, loads, torque, peaks, turns = closed.study(None, duration=0.1, progress=False)
    monkeypatch.setattr("studies.closed.study", lambda *_, **__: made)
    for width in (80, 120):
        for name, value in {"COLUMNS": width, "TTY_COMPATIBLE": 1, "NO_COLOR": 1}.items():
            monkeypatch.setenv(name, str(value))
        commands.closed(out=Path("closed"))
        check_tables(capsys.readouterr().out.splitlines(), width, [cell_text(torque.iloc[0, 1])])
    assert list(runs) == [closed.CLOSED, closed.ROLLED, closed.TRIAL, *closed.TURNS]
    assert peaks["case"].tolist() == [closed.CLOSED, closed.ROLLED, closed.TRIAL]
    assert turns["case"].tolist() == [closed.CLOSED, *closed.TURNS]
    assert turns["mean torque, left tumbler, in kN m"].isna().tolist() == [True, False, False]
    assert (turns["greatest tension in kN"] > turns["least tension in kN"]).all()
    assert (loads["greatest in kN"] >= loads["mean in kN"]).all()
    tensions = {f"tension, {part}" for part in ("lower run", "idler", "upper run", "tumbler")}
    assert set(loads.loc[loads["of"].str.startswith("tension"), "of"]) == tensions
    # a carrier bears what hangs between it and its neighbours, 1.8 m of chain, and what the tension lifts
    assert 50.0 < loads.set_index("of").loc["carrier", "mean in kN"] < 250.0
    assert torque["by moments in kN m"].notna().all()
    numbers = peaks.set_index("case")
    assert (numbers > 0.0).all(axis=None)
    assert numbers.loc[closed.TRIAL, "mean link in kN"] > numbers.loc[closed.ROLLED, "mean link in kN"]
