"""Grounds of cells that the machine rolls over: every one carries it, and the harder ones tilt shoes less."""

import numpy as np
import pytest

from exudyn_crawler import simulate
from studies.ground import PAPERS, row, study_cases

CASES = {name: one.case.with_(flexible=None) for name, one in study_cases(duration=1.0).items()}


def test_grounds_differ_in_nothing_but_the_ground():
    papers = CASES[PAPERS]
    for name, case in CASES.items():
        assert case.with_(name=PAPERS, terrain=papers.terrain, contact=papers.contact) == papers, name


@pytest.mark.simulation
@pytest.mark.parametrize("name", [name for name in CASES if name != PAPERS])
def test_every_ground_carries_the_machine(name):
    case = CASES[name]
    history = simulate(case, 0.05, False)
    carried = (history.normal_force + history.friction_force).sum("contact").values[:, 2]
    frame, shoes = case.undercarriage, case.track.shoe_count
    weight = (frame.mass + shoes * case.shoe.mass) * case.gravity
    # what is still falling into its place takes less than a hundredth
    np.testing.assert_allclose(carried, weight, rtol=0.01)
    assert row(type("Run", (), {"history": history}))["greatest tilt of a shoe in mrad"] < 300.0
