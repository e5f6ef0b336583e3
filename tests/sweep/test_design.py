"""Designs against what defines them."""

import numpy as np
import pytest

from exudyn_crawler import Vary
from exudyn_crawler.sweep.design import design_rows

A, B = Vary(key="a", low=0.0, high=1.0, count=3), Vary(key="b", values=("x", "y"))
C, D = Vary(key="c", low=2.0, high=4.0), Vary(key="d", low=1.0, high=100.0, scale="log")


def test_a_grid_has_every_value_with_every_other():
    assert design_rows("grid", (A, B), None, 1) == [(a, b) for a in (0.0, 0.5, 1.0) for b in ("x", "y")]


def test_a_list_takes_values_in_step():
    short = Vary(key="a", low=0.0, high=1.0, count=2)
    assert design_rows("list", (short, B), None, 1) == [(0.0, "x"), (1.0, "y")]
    with pytest.raises(ValueError, match="as many values each with design 'list', got a 3, b 2"):
        design_rows("list", (A, B), None, 1)


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
    ("design", "runs", "told"),
    [
        ("sobol", 7, "a power of 2 with design 'sobol', such as 4 or 8, got 7"),
        ("saltelli", 9, "such as 8 or 16, got 9"),
        ("latin_hypercube", None, "runs must be given"),
        ("grid", 4, "runs must be left out"),
    ],
)
def test_numbers_of_runs_that_do_not_fit_are_refused(design, runs, told):
    with pytest.raises(ValueError, match=told):
        design_rows(design, (A, B), runs, 1)


def test_a_grid_needs_counts():
    with pytest.raises(ValueError, match="c: count must be given for a grid"):
        design_rows("grid", (C,), None, 1)
