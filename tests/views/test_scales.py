"""Scales of pictures."""

import pytest

from exudyn_crawler.views.placement import greatest_shoe_force, shoe_forces
from exudyn_crawler.views.scales import LONGEST_OF_SHOE, drawn_scale, round_down, round_up, shoe_force_scale


def test_scales_are_round_and_fit():
    assert [round_down(value) for value in (0.0199, 2.0, 4.99, 731.0)] == pytest.approx([0.01, 2, 2, 500])
    assert [round_up(value) for value in (0.0201, 2.0, 172.1, 84.8)] == pytest.approx([0.03, 2, 200, 100])
    assert drawn_scale([0.0, -0.003], 0.1) == pytest.approx(20.0)
    assert drawn_scale([0.0], 0.1) == 1.0


def test_the_greatest_force_of_a_run_gets_the_longest_arrow(translation):
    forces = [shoe_forces(translation.dataset.isel(time=k))[1] for k in range(len(translation.time))]
    greatest = max(float((force**2).sum(axis=1).max() ** 0.5) for force in forces)
    assert greatest_shoe_force(translation) == pytest.approx(greatest)
    assert shoe_force_scale(translation) * greatest == pytest.approx(LONGEST_OF_SHOE)
