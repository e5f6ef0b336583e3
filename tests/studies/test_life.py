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
    ends = {"propel": 0.03, "dig": 0.06}
    cycle = LoadCycle(phases=tuple(Phase(name=name, end=end, loads=even) for name, end in ends.items()))
    folder = tmp_path / "stress"
    (folder / "cycle").mkdir(parents=True)
    History(history.case.with_(loads=cycle), history.dataset).save(folder / "cycle" / "history.nc")
    return folder


def test_lives_of_materials_stand_side_by_side(stress_of_a_moment, tmp_path, monkeypatch):
    monkeypatch.setattr(life_study, "MATERIALS", (FatigueMaterial.a36,))
    out = tmp_path / "life"
    found, summary = life_study.study(out, stress_of_a_moment)
    assert list(found) == ["dragged_a36"] == summary["propel_and_material"].tolist()
    parts = found["dragged_a36"].dataset.part.values.tolist()
    assert parts == ["dragged propel: propel", "dig cycle: dig", "between runs"]
    assert (out / "dragged_a36" / "life.html").is_file()
    assert len(pd.read_csv(out / "summary.csv")) == 1
    with pytest.raises(FileExistsError, match="exists"):
        life_study.study(out, stress_of_a_moment)


def test_rolled_propel_takes_the_place_of_the_dragged(stress_of_a_moment, tmp_path):
    cycle = stress_of_a_moment / "cycle"
    dragged, rolled = (
        life_study.duty_of(cycle, FatigueMaterial.a36(), rolled) for rolled in (None, tmp_path / "rolled")
    )
    assert dragged.runs[1] == rolled.runs[1]
    assert (dragged.runs[0].end, rolled.runs[0].end) == (0.03, None)
    assert rolled.runs[0].folder == str(tmp_path / "rolled")
