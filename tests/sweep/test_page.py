"""Page of a sweep: what its figures hold, and that names cannot be markup."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler.sweep import page
from exudyn_crawler.sweep.results import for_reading, main_effects

LINKS = {"a": "runs/a/report.html", "b": "runs/b"}


def sweep_of(design="grid"):
    """Stiffnesses on a logarithmic axis, laws, and one answer."""
    stiffness = SimpleNamespace(label="stiffness", scale="log", levels=lambda: (1e7, 2e7))
    law = SimpleNamespace(label="law", scale="linear", levels=lambda: ("pair", "area"))
    answer = SimpleNamespace(label="force", better="less")
    return SimpleNamespace(
        vary=(stiffness, law),
        columns=("stiffness", "law"),
        answers=(answer,),
        design=design,
        is_sampled=False,
        runs=None,
        named="small",
    )


def table_of():
    """Two values of everything and one run that has failed."""
    table = pd.DataFrame(
        {
            "run": [1, 2, 3, 4],
            "folder": ["a", "b", "c", "d"],
            "stiffness": [1e7, 1e7, 2e7, 2e7],
            "law": ["pair", "area", "pair", "area"],
            "force": [1.0, 3.0, 2.0, np.nan],
            "status": ["done", "done", "done", "failed"],
            "reason": ["", "", "", "it <b>sank</b>"],
        }
    )
    table.attrs = {
        "units": {"stiffness": "N/m", "law": "", "force": "N"},
        "meanings": {"stiffness": "k", "law": "sharing", "force": "greatest of the force"},
    }
    return table


def test_a_grid_has_a_curve_a_level_of_what_varies_next():
    figure = page.response_curves(sweep_of(), for_reading(table_of()), "force")
    assert [(one.name, list(one.x), [1e3 * force for force in one.y]) for one in figure.data] == [
        ("law = area", [10.0], [3.0]),
        ("law = pair", [10.0, 20.0], [1.0, 2.0]),
        ("stiffness = 10 MN/m", ["area", "pair"], [3.0, 1.0]),
        ("stiffness = 20 MN/m", ["pair"], [2.0]),
    ]
    assert [axis.title.text for axis in figure.select_xaxes()] == ["stiffness in MN/m", "law"]
    assert next(figure.select_yaxes()).title.text == "force in kN"
    assert list(figure.layout.xaxis.ticktext) == ["10", "20"]


def test_other_designs_have_a_point_a_run():
    points = page.response_curves(sweep_of("list"), table_of(), "force").data
    assert [(list(one.x), list(one.y)) for one in points] == [
        ([1e7, 1e7, 2e7], [1.0, 3.0, 2.0]),
        (["pair", "area", "pair"], [1.0, 3.0, 2.0]),
    ]


def test_effects_reach_from_the_least_to_the_greatest_over_axes_as_they_vary():
    sweep, table = sweep_of(), table_of()
    figure = page.effect_figure(sweep, table, main_effects(sweep, table), "force")
    line = figure.data[0]
    assert list(line.y) == [2.0, 2.0]
    assert list(line.error_y.array) == [1.0, 0.0]
    assert list(line.error_y.arrayminus) == [1.0, 0.0]
    assert (figure.layout.xaxis.type, figure.layout.xaxis2.type) == ("log", None)


def test_lives_are_on_logarithmic_axes_and_many_panels_in_rows():
    sweep, table, names = sweep_of("list"), table_of(), [f"v{k}" for k in range(8)]
    table["force"] = [1e4, 1e5, 2e6, np.nan]
    table[names] = 1.0
    table.attrs["units"] |= {"force": "h"}
    sweep.columns, sweep.vary = names, [SimpleNamespace(label=name, scale="linear") for name in names]
    figure = page.response_curves(sweep, table, "force")
    assert {axis.type for axis in figure.select_yaxes()} == {"log"}
    assert [(one.xaxis, list(one.y)) for one in figure.data][7] == ("x8", [1e4, 1e5, 2e6])
    tops = [axis.domain[1] for axis in figure.select_yaxes()]
    assert tops[page.ACROSS] < min(tops[: page.ACROSS])


def test_the_page_links_to_runs_and_tells_of_failures_without_their_markup():
    text = page.sweep_page(sweep_of(), table_of(), LINKS)
    assert 'href="runs/a/report.html">1</a>' in text
    assert "it &lt;b&gt;sank&lt;/b&gt;" in text
    assert "<p>None: design &#39;grid&#39; needs all runs to have finished.</p>" in text
    assert "0.001 kN" in text
    assert "force in kN" in text


def test_a_sweep_without_a_finished_run_has_a_page_without_figures():
    text = page.sweep_page(sweep_of(), table_of().assign(force=np.nan), LINKS)
    assert "No run has finished." in text
    assert "plotly" not in text.lower()


@pytest.mark.parametrize(("count", "drawn"), [(4, 4), (page.MOST_DRAWN + 1, page.MOST_DRAWN // 2 + 1)])
def test_very_many_runs_are_thinned(count, drawn):
    table = pd.DataFrame({"stiffness": 1e7, "law": "pair", "force": np.arange(count, dtype=float)})
    table.attrs = table_of().attrs
    (points, *_) = page.response_curves(sweep_of("list"), table, "force").data
    assert len(points.y) == drawn
    assert points.y[0] == 0.0


def test_long_tables_are_cut(monkeypatch):
    monkeypatch.setattr(page, "LONGEST_TABLE", 3)
    text = page.sweep_page(sweep_of(), table_of(), LINKS)
    assert "1 more are in results.csv." in text
    assert "sank" not in re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert json.dumps("area")[1:-1] in text
