"""Study of rolling propel: its cases and a reduced run."""

import numpy as np
import pytest

from exudyn_crawler.model.flexible_shoes import check_shoe
from studies import rollers


@pytest.fixture(scope="module")
def coarse():
    return rollers.study_cases("coarse")


def test_pass_begins_behind_the_flexible_shoes_and_ends_beyond_them(coarse):
    whole = coarse["pass"]
    case, frame = whole.case, whole.case.undercarriage
    places = case.track.first_com[0] + (np.array(rollers.FLEXIBLE) - 1) * case.track.pitch
    rails = case.shoe.rails
    assert frame.start + frame.rollers[-1] < places[0] + rails.rear
    end = frame.start + case.drive.travel(whole.duration)
    assert end + frame.rollers[0] > places[-1] + rails.front


@pytest.mark.parametrize(("name", "lower"), [*zip(rollers.OVERHANG, (0.0, 0.025), strict=True)])
def test_machine_passes_and_digs_over_shoes_whose_rails_overhang(name, lower, coarse):
    assert [own for own in coarse if own.split(" ", 1)[1:] == [name]] == [f"pass {name}"]
    ready, case = coarse["pass"].case, coarse[f"pass {name}"].case
    assert case.shoe.rails.height == pytest.approx(ready.shoe.rails.height - lower, abs=1e-6)
    assert 0.9 < case.shoe.mass / ready.shoe.mass < 0.95
    check_shoe(case)
    # wherever it stands, some of its rollers are above flexible shoes, all of them on one of its stands
    middles = case.track.first_com[0] + (np.array(rollers.FLEXIBLE) - 1) * case.track.pitch
    above = []
    for part in rollers.STANDS:
        frame = coarse[f"loading {name} {part}"].case.undercarriage
        under = frame.start + np.array(frame.rollers)
        low, high = middles[0] - 0.5 * case.track.pitch, middles[-1] + 0.5 * case.track.pitch
        above.append((under > low) & (under < high))
    assert np.any(above, axis=0).all()
    assert np.sum(above, axis=1).min() >= 2


def test_machine_digs_above_the_flexible_shoes(coarse):
    case = coarse["loading"].case
    middle = case.track.first_com[0] + (np.mean(rollers.FLEXIBLE) - 1) * case.track.pitch
    assert case.undercarriage.start == pytest.approx(middle, abs=0.1)
    assert case.machine.phases[0].end == 0.0


def test_open_choices_differ_from_what_is_chosen_by_one_thing():
    cases = rollers.choices()
    for name in (rollers.FIRM_SPRINGS, rollers.FIRM_CONTACT):
        assert cases.pop(name).undercarriage == cases["as it is"].undercarriage
    chosen = cases.pop("as it is").undercarriage.model_dump()
    for name, case in cases.items():
        changed = [key for key, value in case.undercarriage.model_dump().items() if value != chosen[key]]
        assert len(changed) == 1, name


@pytest.mark.slow
@pytest.mark.simulation
def test_reduced_study_finds_stresses_in_all_regions():
    runs, regions = rollers.study(None, "coarse", duration=0.3, progress=False)
    assert list(runs) == ["pass", "loading", "dragged", *rollers.overhang_cases()]
    names = {"roller path", "notches", "lugs", "web", "wings"}
    assert set(regions["region"]) == names
    assert (regions["von Mises in MPa"] > 0.0).all()
    shares = regions.filter(like="share of ")
    assert shares.sum(axis=1).to_numpy() == pytest.approx(1.0, abs=1e-9)
    share = regions.set_index("case")["share of rollers"]
    assert (share["dragged"] == 0.0).all()
    assert (share["pass"] == 0.0).all()  # they have not reached the flexible shoes
    assert share["loading"].abs().max() > 0.1
    highest = rollers.highest_by_region(runs["loading"])
    assert highest["node"].tolist() == regions.query("case == 'loading'")["node"].tolist()
