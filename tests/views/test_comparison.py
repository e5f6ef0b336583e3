"""Page of two runs: what differs, and their curves together."""

import pytest

from exudyn_crawler.views.pages.runs import comparison_figures, write_comparison


def test_curves_of_both_runs_stand_in_one_figure(translation, turning):
    figures = comparison_figures({"straight": translation, "curved": turning}, {})
    assert list(figures)[:2] == ["contact force", "velocity"]
    axes = figures["velocity"].axes
    assert len(axes) == 3
    names = [line.get_label() for line in axes[0].lines]
    assert names == [f"shoe {shoe}, {run}" for shoe in (1, 7, 13) for run in ("straight", "curved")]
    x = translation.velocity.sel(shoe=7, axis="x").values
    assert axes[0].lines[2].get_ydata() == pytest.approx(x)


def test_the_page_shows_parameters_results_and_curves(translation, turning, tmp_path):
    runs = {"straight": translation, "curved": turning}
    page = write_comparison(runs, tmp_path / "both.html").read_text(encoding="utf-8")
    assert "A is straight: case &#39;translation&#39;, 0.4 s" in page
    assert "<td>drive.turn_rate</td>" in page
    assert "<td>angular_velocity</td>" in page
    assert page.count("data:image/png;base64,") == 6
    assert "http" not in page
    with pytest.raises(FileExistsError, match=r"both\.html exists"):
        write_comparison(runs, tmp_path / "both.html")
    with pytest.raises(ValueError, match=r"histories must be two, got \['straight'\]"):
        write_comparison({"straight": translation}, tmp_path / "one.html")


def test_equal_runs_say_so(translation, tmp_path):
    page = write_comparison({"one": translation, "other": translation}, tmp_path / "same.html").read_text()
    assert "<p>Nothing differs in the cases.</p>" in page
    assert "<p>Nothing that both runs have differs in the results, beyond rounding.</p>" in page
    assert "<table" not in page


def test_runs_without_a_common_flexible_shoe_are_compared_by_the_rest(flexible_run, bent, bent_stress):
    figures = comparison_figures({"a": flexible_run[0], "b": bent}, {"a": flexible_run[1], "b": bent_stress})
    assert "highest von Mises stress" not in figures
    assert "velocity" in figures
