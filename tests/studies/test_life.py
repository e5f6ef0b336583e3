"""The life study on a short run that is taken for the stress study's cycle."""

import pandas as pd
import pytest

from exudyn_crawler import FatigueMaterial, History, LoadCycle
from exudyn_crawler.case import Phase
from studies import life as life_study


@pytest.fixture
def stress_of_a_moment(flexible_run, tmp_path):
    """Folder as the stress study leaves it, of a propel of 0.03 s and as much digging."""
    history = flexible_run[0]
    even = history.case.loads.phases[0].loads
    cycle = LoadCycle(
        phases=(Phase(name="propel", end=0.03, loads=even), Phase(name="dig", end=0.06, loads=even))
    )
    (tmp_path / "stress" / "cycle").mkdir(parents=True)
    History(history.case.with_(loads=cycle), history.dataset).save(
        tmp_path / "stress" / "cycle" / "history.nc"
    )
    return tmp_path / "stress"


def test_lives_of_materials_stand_side_by_side(stress_of_a_moment, tmp_path, monkeypatch):
    monkeypatch.setattr(life_study, "MATERIALS", (FatigueMaterial.a36,))
    monkeypatch.setattr(life_study, "PROPEL_SHARE", 1e-3)
    out = tmp_path / "life"
    found, summary = life_study.study(out, stress_of_a_moment, stress_of_a_moment / "cycle")
    assert list(found) == ["dragged_a36", "rolled_a36"] == summary["propel_and_material"].tolist()
    dragged, rolled = found.values()
    assert dragged.dataset.part.values.tolist() == [
        "dragged propel: propel",
        "dig cycle: dig",
        "between runs",
    ]
    assert rolled.dataset.part.values.tolist()[:2] == ["rolled propel: propel", "rolled propel: dig"]
    assert (out / "dragged_a36" / "life.html").is_file()
    assert len(pd.read_csv(out / "summary.csv")) == 2
    with pytest.raises(FileExistsError, match="exists"):
        life_study.study(out, stress_of_a_moment)
