"""The stress study on a short propel: frequencies, peaks, files, comparison, refusals."""

import meshio
import numpy as np
import pandas as pd
import pytest

from exudyn_crawler import Case, History, StepProfile, recover_stresses
from exudyn_crawler.case import Drive
from exudyn_crawler.machines import Outputs
from exudyn_crawler.model.flexible_shoes import whole_reduction
from exudyn_crawler.results.stress.basis import stress_basis
from exudyn_crawler.views.outputs import WRITERS, write_outputs
from fem import write_mesh
from meshes import shoe_mesh
from studies.stress import (
    PICTURE_TIMES,
    compare_stresses,
    flexible_quantity,
    highest_in_propel_and_loading,
    in_phase,
    study as stress_study,
)

pytestmark = pytest.mark.simulation

PULL = StepProfile(times=(0.0, 0.5, 0.7), values=(0.0, 0.1, 0.1))
"""Soon at full speed, so that a short run has the papers' pull."""
DURATION = 0.7


def short_case():
    """Two flexible shoes, pulled for 0.6 s and let go."""
    return Case.stress("coarse").with_({"flexible.shoes": (7, 13)}, drive=Drive(speed=PULL, on=((0.0, 0.6),)))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    out = tmp_path_factory.mktemp("stress")
    with pytest.MonkeyPatch.context() as monkeypatch:
        for output in ("page", "pictures"):
            monkeypatch.delitem(WRITERS, output)
        run, table = stress_study(out, short_case(), duration=DURATION, progress=False)
    return run.folder, run.history, run.stresses, table


@pytest.mark.slow
def test_outputs_say_what_is_written_of_the_stresses(study, tmp_path):
    _, history, _, _ = study
    results = recover_stresses(history, (0.2, 0.5), peak=False)
    assert results.dataset.frame.values == pytest.approx([0.2, 0.5], abs=1e-9)

    def write(outputs):
        write_outputs(history, results, tmp_path, outputs)

    nothing = Outputs(tables=False, figures=False, pictures=False, paraview=False, forces=False, page=False)
    write(nothing)
    assert {path.name for path in tmp_path.iterdir()} == {"stress.nc"}
    write(nothing.with_(paraview=True))
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"stress.nc", "track.pvd", "track_parts", *(f"fields_shoe_{n}.vtu" for n in (7, 13))}
    write(Outputs(tables=False, figure_format="svg", paraview=False, page=False))
    assert not list(tmp_path.glob("*.csv"))
    assert {path.name for path in tmp_path.glob("*.png")} == {f"stress_000.{n}000s.png" for n in (2, 5)}
    assert {path.suffix for path in tmp_path.glob("flexible_*")} == {".svg"}


def test_modal_frequencies_of_the_shoe_are_the_papers(study):
    """First bending mode 178.07 Hz (S-paper fig. 9); all of 94 modes and the drive's own are elastic."""
    frequencies = whole_reduction(study[1].case).body.frequencies
    assert len(frequencies) == 94 + 1
    assert frequencies[0] == pytest.approx(178.07, rel=0.01)
    assert (np.diff(frequencies) > 0.0).all()


def test_stress_of_the_front_shoe_is_its_pull(study):
    """It pulls all others at its rear pins, against which its own contact and inertia are small."""
    _, history, results, _ = study
    highest = results.dataset.highest_von_mises
    pull = history.joint_force.sel(joint=12, axis="x").values
    assert pull.max() > 0.25 * 12 * 432.3e3  # friction of the twelve shoes behind
    front = highest.sel(shoe=13).values
    assert abs(float(history.time[front.argmax()] - history.time[pull.argmax()])) < 0.005
    pulling = pull > 0.5 * pull.max()
    ratio = front[pulling] / pull[pulling]
    assert ratio == pytest.approx(np.median(ratio), rel=0.1)
    # shoe 7 pulls half as many and rests on its middle
    assert (front[pulling] > 2.0 * highest.sel(shoe=7).values[pulling]).all()


def test_hot_spots_of_the_front_shoe_are_on_the_inner_faces_of_its_rear_lugs(study):
    """S-paper, table 6: y = 8.76 and 9.95 m; of the five highest nodes some lie on the fillet beside."""
    _, history, results, _ = study
    track = history.case.track
    rear_pin = track.joint_centers["rear right"][0] + track.com_positions(history.case.shoe.com_height)[12, 0]
    spots = results.hot_spots[13]
    assert np.abs(spots["x"] - rear_pin).max() < 0.25
    faces = np.array([8.76, 9.95])
    nearest = np.abs(spots["y"].to_numpy()[:, None] - faces).argmin(axis=1)
    assert set(nearest) == {0, 1}
    assert spots["y"].to_numpy() == pytest.approx(faces[nearest], abs=0.01)


def test_fields_agree_with_the_modal_history(study):
    _, history, results, _ = study
    basis = stress_basis(history)
    shapes, q = basis.shapes, basis.coordinates[13]
    data = results.dataset.sel(shoe=13)
    instant = int(data.highest_von_mises.values.argmax())
    field = shapes.von_mises(q[instant])[0]
    assert float(data.highest_von_mises[instant]) == pytest.approx(field.max(), rel=1e-9)
    assert int(data.highest_node[instant]) == int(field.argmax())
    assert float(data.peak_von_mises.max()) == pytest.approx(field.max(), rel=1e-9)
    assert float(data.peak_time[field.argmax()]) == pytest.approx(float(data.time[instant]))
    assert (data.least_von_mises <= data.peak_von_mises).all()
    first = data.isel(frame=0)
    assert first.frame_von_mises.values == pytest.approx(shapes.von_mises(q[0])[0], rel=1e-5)
    moved = first.frame_displacement.values
    assert moved == pytest.approx(shapes.displacement(q[0])[0], abs=1e-5 * float(np.abs(moved).max()))


def test_everything_is_written_and_read_back(study):
    out, history, results, table = study
    names, spots = {path.name for path in out.iterdir()}, {f"hot_spots_shoe_{shoe}.csv" for shoe in (7, 13)}
    assert {"history.nc", "stress.nc", "loads.csv", "highest_stresses.csv"} | spots <= names
    assert "flexible_highest_von_Mises_stress.png" in names
    assert "checkpoints" not in names
    fields = meshio.read(out / "fields_shoe_13.vtu").point_data
    assert fields["greatest von Mises"] == pytest.approx(results.dataset.peak_von_mises.sel(shoe=13).values)
    assert (fields["range of von Mises"] >= 0.0).all()
    assert fields["time of the greatest"].max() <= DURATION + 1e-9
    again = History.load(out / "history.nc")
    assert again.case == history.case
    assert recover_stresses(again, PICTURE_TIMES).dataset.identical(results.dataset)
    assert len(pd.read_csv(out.parent / "comparison.csv")) == len(table)


def test_every_row_of_the_paper_is_compared_or_out_of_reach(study):
    _, history, results, table = study
    assert len(table) == 38
    reached = table[table["computed"].notna()]
    assert {"propel", "loading", "modal", "hot spots"} == set(reached["case"])
    assert set(table["case"]) == set(reached["case"])
    assert compare_stresses(history, results).equals(table)


def test_phases_end_where_the_drive_goes_off(study):
    history = study[1]
    speed = flexible_quantity(history, "flexible shoe x velocity")
    assert float(in_phase(speed, history, "propel").time[-1]) == pytest.approx(0.6)
    assert float(in_phase(speed, history, "loading").time[0]) > 0.6
    with pytest.raises(ValueError, match="phase must be"):
        in_phase(speed, history, "rest")
    with pytest.raises(ValueError, match="names no quantity"):
        flexible_quantity(history, "flexible shoe x mood")
    summary = highest_in_propel_and_loading(history, study[2])
    assert list(summary["shoe"]) == [7, 13]
    assert (summary["propel"] > 0.0).all()


def test_a_track_of_rigid_shoes_is_refused():
    with pytest.raises(ValueError, match="flexible must be given"):
        stress_study(case=Case.translation())


def test_a_mesh_without_bores_is_refused(tmp_path):
    mesh = shoe_mesh("coarse")
    kept = {name: faces for name, faces in mesh.surfaces.items() if name != "bore rear left"}
    path = tmp_path / "fewer.msh"
    write_mesh(path, type(mesh)(mesh.nodes, mesh.elements, kept))
    with pytest.raises(ValueError, match="must have the surface 'bore rear left'"):
        stress_study(case=short_case().with_({"flexible.mesh": str(path)}), duration=0.1)


@pytest.mark.slow
def test_quiet_steps_lose_nothing_of_slow_loading():
    """Dig to swing in the paper's time, without the drive: 10 ms steps against 2 ms."""
    case = Case.stress("coarse")
    dig, swing = case.loads.phases[1:3]
    phases = (dig.with_(end=0.0), swing.with_(end=swing.end - dig.end))
    case = case.with_({"loads.phases": phases, "drive.on": (), "flexible.shoes": (7,)})
    peaks = []
    for one in (case, case.with_({"solver.quiet_step": case.solver.step})):
        run, _ = stress_study(case=one, duration=2.0, progress=False)
        peaks.append(float(run.stresses.dataset.highest_von_mises.sel(shoe=7)[-1]))
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-3)
