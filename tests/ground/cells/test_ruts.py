"""A run that starts in the ruts of an earlier one: what cells remember, and what of a file is refused."""

import shutil

import numpy as np
import pytest

from exudyn_crawler import Case, CaseFile, run_case, simulate
from exudyn_crawler.case.parameters.heights import Heights, Ridge
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.machines.case_file import BARE, case_text
from exudyn_crawler.machines.case_files import read_case, write_case
from tests.rolled import small_case

SOIL = BekkerSoil.lete_sand("chrono")
DURATION = 0.05


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """History of a short pass of the machine, and its file."""
    folder = tmp_path_factory.mktemp("first")
    history = simulate(small_case().on_cells(SOIL), DURATION, False)
    return history, history.save(folder / "history.nc")


@pytest.mark.simulation
def test_the_second_pass_starts_from_what_the_first_has_left(first, tmp_path):
    history, path = first
    again = history.case.with_({"terrain.ruts": path})
    memory = CellGroundContact(again).ground.state()
    assert len(memory["held"]) == 0
    order = np.lexsort(memory["cells"].T[::-1])
    stored = (history.cell_column, history.cell_row, history.cell_sinkage, history.cell_pressure)
    found = (*memory["cells"][order].T, *memory["memory"][order, :2].T)
    for one, other in zip(found, stored, strict=True):
        np.testing.assert_array_equal(one, other)
    assert not memory["memory"][:, 2:].any()
    # the same load on ground that was under it before: the rut, deeper by what rocking adds
    case_file = CaseFile(case=again, duration=DURATION, outputs=BARE)
    second = run_case(case_file, tmp_path / "second", progress=False).history
    deepest, before = float(second.cell_sinkage.max()), float(history.cell_sinkage.max())
    assert before <= deepest < 1.25 * before
    sunk = [one.contacts_by_shoe().penetration.isel(time=0).mean().item() for one in (history, second)]
    assert sunk[0] < sunk[1] < deepest
    # deepening takes less than making
    energy = [float((one.cell_sinkage * one.cell_pressure).sum()) for one in (history, second)]
    assert energy[1] - energy[0] < 0.5 * energy[0]
    assert read_case(tmp_path / "second" / "case.toml").case == again


@pytest.mark.simulation
def test_ruts_of_another_ground_are_refused_in_a_line_before_anything_is_written(first, tmp_path):
    history, path = first
    ridge = Heights(parts=(Ridge(x=16.0, height=0.1, width=0.2, flank=0.3),))
    altered = tmp_path / "altered.nc"
    altered.write_bytes(path.read_bytes()[:1000])
    for changes, told in (
        ({"contact.law": SOIL.with_(cohesion=2e3)}, "history.nc is the history of a ground with another law"),
        ({"contact.law": RockFloor.hard_floor()}, "history.nc is the history of a ground with another law"),
        ({"terrain.cell": 0.05}, "history.nc is the history of a ground with another cell"),
        (
            {"terrain.relief": ridge, "terrain.cell": 0.05},
            "is the history of a ground with another cell and relief",
        ),
        ({"terrain.ruts": altered}, "altered.nc holds no ground of cells"),
        ({"terrain.ruts": tmp_path / "none.nc"}, "none.nc holds no ground of cells"),
    ):
        case = history.case.with_({"terrain.ruts": path} | changes)
        with pytest.raises(ValueError, match=f"terrain.ruts: .*{told}") as error:
            run_case(CaseFile(case=case, duration=DURATION), tmp_path / "out", progress=False)
        assert "\n" not in str(error.value)
    assert not (tmp_path / "out").exists()
    with pytest.raises(ValueError, match=r"none\.nc holds no ground of cells"):
        simulate(case, DURATION, False)


def test_files_count_from_the_case_file(tmp_path):
    np.save(tmp_path / "pit.npy", np.zeros((40, 40)))
    relief = Heights(measured={"file": tmp_path / "pit.npy", "spacing": 2.0})
    case = Case.translation().on_cells(SOIL, relief).with_({"terrain.ruts": tmp_path / "first.nc"})
    case_file = CaseFile(case=case, duration=1.0)
    assert read_case(write_case(case_file, tmp_path / "whole.toml")).case == case
    relative = case_text(case_file).replace(f"{tmp_path}/", "")
    (tmp_path / "relative.toml").write_text(relative, encoding="utf-8")
    assert read_case(tmp_path / "relative.toml").case == case
    moved = tmp_path / "moved"
    moved.mkdir()
    shutil.copy(tmp_path / "pit.npy", moved)
    (moved / "relative.toml").write_text(relative, encoding="utf-8")
    assert read_case(moved / "relative.toml").case.terrain.ruts == moved / "first.nc"
