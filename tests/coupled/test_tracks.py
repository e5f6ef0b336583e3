"""A track as items of a user's model: its commands, sensors and refusals."""

import numpy as np
import pytest

from exudyn_crawler import Case, add_track, solve_dynamic
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.model.exudyn import exu
from tests.coupled.models import add_box, model, settings, still_case
from tests.rolled import small_case

pytestmark = pytest.mark.simulation


def test_controller_drives_a_track_and_sensors_store_its_forces():
    case = still_case()
    _container, mbs = model()
    track = add_track(mbs, case)
    force = track.add_sensor("contact_force", shoe=5, axis="z")
    mbs.Assemble()
    mbs.SetPreStepUserFunction(lambda _mbs, time: track.set_speeds(0.5 * min(time, 0.04)) is None)
    solve_dynamic(mbs, settings(case, 0.06))
    assert track.history.side_frame_velocity.sel(axis="x").item() == pytest.approx(0.02, abs=1e-4)
    stored = mbs.GetSensorStoredData(force)
    assert len(stored) == 31
    assert stored[-1, 0] == pytest.approx(0.06)
    last = track.history.contacts_by_shoe().contact_force.sel(shoe=5, axis="z").item()
    assert stored[-1, 1] == pytest.approx(last)
    assert last > 1e3


def test_what_cannot_be_solved_is_refused():
    case = small_case()
    _container, mbs = model()
    mbs.Assemble()
    with pytest.raises(ValueError, match="call add_track"):
        solve_dynamic(mbs, exu.SimulationSettings())
    with pytest.raises(ValueError, match="gear"):
        add_track(mbs, Case.translation())
    for wrong, message in (
        ({"carried_mass": -1.0}, "carried_mass must be at least 0 kg, got -1"),
        ({"carried_com": (0.0, np.nan, 0.0)}, "carried_com must be 3 finite numbers"),
        ({"position": (0.0, 1.0)}, "position must be 3 finite numbers"),
        ({"heading": np.inf}, "heading must be finite, got inf"),
        ({"replaces_upper": True}, "replaces_upper must be False with gear.kind 'rolled'"),
    ):
        with pytest.raises(ValueError, match=message):
            add_track(mbs, case, **wrong)
    track = add_track(mbs, case)
    with pytest.raises(ValueError, match="no motors"):
        track.set_torques(1.0)
    with pytest.raises(ValueError, match="1 finite numbers"):
        track.set_speeds([1.0, 2.0])
    with pytest.raises(ValueError, match="no quantity 'contact_farce'"):
        track.add_sensor("contact_farce")
    mbs.Assemble()
    index = settings(case, 0.01)
    index.timeIntegration.generalizedAlpha.useIndex2Constraints = True
    with pytest.raises(ValueError, match="useIndex2Constraints"):
        solve_dynamic(mbs, index)


def test_run_that_fails_names_the_machine_and_the_equation():
    case = small_case().with_(name="digger")
    _container, mbs = model()
    track = add_track(mbs, case)
    mbs.Assemble()
    solve_dynamic(mbs, settings(case, 0.004))
    track.block.multipliers[:] = np.nan
    track.block.state[:] = np.nan
    with pytest.raises(SimulationStopped, match="machine 1 'digger': Newton's method failed") as stopped:
        solve_dynamic(mbs, settings(case, 0.02, 0.004))
    assert stopped.value.time == pytest.approx(0.004)


def test_renderer_gets_shoes_wheels_and_ground_where_they_are():
    """Without a display: the data that Exudyn would draw, of a track that is turned round."""
    case = small_case()
    _container, mbs = model()
    track = add_track(mbs, case, position=[5.0, 1.0, 0.5], heading=np.pi / 2.0)
    number = track.add_graphics(interval=0.01)
    draw = mbs.GetObject(number)["VgraphicsDataUserFunction"]["function"]
    start = draw(mbs, number)
    mbs.Assemble()
    solve_dynamic(mbs, settings(case, 0.03))
    assert track.film.times == pytest.approx([0.0, 0.01, 0.02, 0.03])
    now = track.film.graphics(0.03)
    assert [len(one["points"]) for one in now] == [len(one["points"]) for one in start]
    for one in now:
        assert one["type"] == "TriangleList"
        assert np.max(one["triangles"]) == len(np.reshape(one["points"], (-1, 3))) - 1
    places = track.history.position.isel(time=0).values @ track.car.placement.turn.T + [5.0, 1.0, 0.5]
    # ground, then the boxes of all shoes about their COMs
    boxes = np.reshape(now[1]["points"], (-1, 8, 3))
    assert np.abs(boxes.mean(axis=1) - places).max() < 0.3
    assert np.ptp(boxes, axis=1).min() > 0.1
    moved = np.reshape(track.film.graphics(0.0)[1]["points"], (-1, 3)) - boxes.reshape(-1, 3)
    assert np.abs(moved).max() > 1e-5


def test_model_that_cannot_be_solved_is_named_and_errors_of_its_functions_come_out():
    case = small_case()
    _container, mbs = model()
    track = add_track(mbs, case)
    ground = mbs.CreateGround()
    box = add_box(mbs, track, 10.0, [0.0, 0.0, 3.0], 0.2)
    # the same joint twice: no unique forces
    for _ in range(2):
        mbs.CreateSphericalJoint(itemNumbers=[ground, box], position=track.place([0.0, 0.0, 3.0]))
    mbs.Assemble()
    unaccelerated = settings(case, 0.004)
    unaccelerated.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
    with pytest.raises(SimulationStopped, match="Newton's method failed in the user's model"):
        solve_dynamic(mbs, unaccelerated)

    def wrong(_mbs, time):
        raise KeyError(time)

    _container, mbs = model()
    add_track(mbs, case)
    mbs.Assemble()
    mbs.SetPreStepUserFunction(wrong)
    with pytest.raises(Exception, match="KeyError"):
        solve_dynamic(mbs, settings(case, 0.004))
