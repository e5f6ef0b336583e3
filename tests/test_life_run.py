"""A duty into a folder, in Python and by the command: files that agree, refusals before any counting."""

import dataclasses

import meshio
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import Duty, life, read_duty
from exudyn_crawler.errors import ImplausibleWarning
from exudyn_crawler.life_run import FILES
from exudyn_crawler.results.life.life import life_words
from exudyn_crawler.views.pages.life import life_lines
from exudyn_crawler.views.tables import cell_text

DUTY = """
plane_nodes = 0
survivals = [0.9]

[material]
base = "a36"
fatigue_strength = 90e6

[[runs]]
name = "propel"
folder = "run"
share = 0.1
"""


@pytest.fixture(scope="module")
def pit(flexible_run, tmp_path_factory):
    """Folder with a duty file, its run and its life."""
    folder = tmp_path_factory.mktemp("pit")
    (folder / "run").mkdir()
    flexible_run[0].save(folder / "run" / "history.nc")
    (folder / "digging.toml").write_text(DUTY)
    return folder, life(folder / "digging.toml", folder / "life")


def test_everything_is_written_and_agrees(pit):
    folder, found = pit[0] / "life", pit[1]
    assert {path.name for path in folder.iterdir()} == set(FILES)
    with xr.open_dataset(folder / "life.nc", engine="h5netcdf") as saved:
        assert saved.life.values == pytest.approx(found.dataset.life.values, nan_ok=True)
        assert Duty.model_validate_json(saved.attrs["duty"]) == read_duty(pit[0] / "digging.toml")
    fields = meshio.read(folder / "life.vtu").point_data
    assert fields["life in h, 90 % survive"] == pytest.approx(found.dataset.life[0].values, nan_ok=True)
    assert {"damage an hour, place 7", "damage an hour, propel: constant"} <= set(fields)
    table = pd.read_csv(folder / "shortest_lives.csv")
    assert table["node"].tolist() == found.table["node"].tolist()
    first = int(table["node"][0])
    growth = pd.read_csv(folder / "damage_histories.csv").query(f"node == {first}")
    last = growth.groupby(["run", "shoe"])["damage an hour"].last().sum()
    assert last == pytest.approx(float(found.dataset.damage_an_hour[0, first]), rel=1e-3)
    matrices = pd.read_csv(folder / "rainflow_matrices.csv")
    assert set(matrices["node"]) == set(table["node"])
    assert (matrices["cycles an hour"] > 0.0).all()


def test_the_page_shows_life_table_and_duty(pit):
    page = (pit[0] / "life" / "life.html").read_text()
    shortest = cell_text(life_words(float(np.nanmin(pit[1].dataset.life[-1]))))
    for words in ("Life in 3D", "stays at place 13", f"before {shortest} machine hours", "fatigue_strength"):
        assert words in page
    assert "http://" not in page.split("<main>")[0]
    # what is inside a spider is not to be used, and does not stand at the head
    found = pit[1]
    held = found.table.assign(flag=["in spider", *[""] * (len(found.table) - 1)])
    line = life_lines(dataclasses.replace(found, table=held))[0]
    assert f"({held['region'][1]}) before" in line


def test_the_command_tells_shortest_lives_and_faults(pit, call, tmp_path):
    code, out, _ = call("life", pit[0] / "digging.toml")
    assert code == 0
    assert "shortest lives by region" in out
    assert (tmp_path / "results" / "digging" / "life.html").is_file()
    code, _, err = call("life", pit[0] / "digging.toml")
    assert code == 2
    assert "life.nc exists; allow overwriting" in err
    wrong = pit[0] / "wrong.toml"
    wrong.write_text(DUTY.replace('folder = "run"', 'folder = "rum"'))
    code, _, err = call("life", wrong)
    assert code == 2
    assert "run 'propel': no history at" in err
    assert not (tmp_path / "results" / "wrong").exists()


def test_implausible_materials_are_warned_of_before_anything_is_counted(tmp_path):
    (tmp_path / "odd.toml").write_text(DUTY.replace("90e6", "1e6\nslope = 50\nscatter = 10"))
    with (
        pytest.warns(ImplausibleWarning) as caught,
        pytest.raises(FileNotFoundError, match="run 'propel': no history"),
    ):
        life(tmp_path / "odd.toml")
    assert [str(one.message).partition("; ")[0] for one in caught] == [
        "material.slope: 50 is outside of 3 to 15",
        "material.scatter: 10 is outside of 1 to 2",
        "material.fatigue_strength: 1e+06 Pa is outside of 5e+07 to 1e+09 Pa",
    ]
