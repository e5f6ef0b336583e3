"""Kinds of a user's items beside bodies and joints: friction with states of its own, hydraulics."""

import numpy as np
import pytest

from exudyn_crawler import add_track, solve_dynamic
from exudyn_crawler.model.exudyn import exu, items
from tests.coupled.models import add_box, add_sensor, model, settings, still_case

pytestmark = pytest.mark.simulation


def test_slider_with_dry_friction_stops():
    """Exudyn switches between sticking and slipping within a step, which is then solved again."""
    case = still_case()
    _container, mbs = model()
    track = add_track(mbs, case)
    mass, speed, friction = 1e3, 0.1, 2e3
    place = [0.0, 0.0, 2.0]
    along = track.axes[:, 0]
    slider = add_box(
        mbs, track, mass, place, initialVelocity=track.at(place)["initialVelocity"] + speed * along
    )
    mbs.CreateGenericJoint(
        itemNumbers=[track.body, slider],
        position=track.place(place),
        constrainedAxes=[0, 1, 1, 1, 1, 1],
        rotationMatrixAxes=track.axes,
        useGlobalFrame=True,
    )
    state = mbs.AddNode(items.NodeGenericData(initialCoordinates=[1, 0, 0], numberOfDataCoordinates=3))
    nodes = track.node, mbs.GetObject(slider)["nodeNumber"]
    ends = [mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0)) for node in nodes]
    mbs.AddObject(
        items.ObjectConnectorCoordinateSpringDamperExt(
            markerNumbers=ends,
            nodeNumber=state,
            dynamicFrictionForce=friction,
            stickingStiffness=1e7,
            stickingDamping=1e4,
        )
    )
    velocity = add_sensor(mbs, slider, "Velocity")
    mbs.Assemble()
    solve_dynamic(mbs, settings(case, 0.08))
    time, found, *_ = mbs.GetSensorStoredData(velocity).T
    # its weight has a part along the tilted frame
    slowing = friction / mass - track.gravity @ along
    slides = time < 0.9 * speed / slowing
    assert found[slides] == pytest.approx(speed - slowing * time[slides], abs=0.03 * speed)
    assert np.abs(found[time > 1.1 * speed / slowing]).max() < 0.05 * speed


def boom_on(mbs, base, track):
    """A boom on a hinge of a base, held by a hydraulic cylinder with an open valve; boom and pressures."""
    boom = add_box(mbs, track, 200.0, [1.0, 0.0, 1.0], 0.4)
    axis = track.axes @ [0.0, 1.0, 0.0]
    mbs.CreateRevoluteJoint(
        itemNumbers=[base, boom], position=track.place([0.0, 0.0, 1.0]), axis=axis, useGlobalFrame=True
    )
    pressures = mbs.AddNode(
        items.NodeGenericODE1(
            referenceCoordinates=[0.0, 0.0], initialCoordinates=[2e6, 2e6], numberOfODE1Coordinates=2
        )
    )
    ends = [
        mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=base, localPosition=[0.5, 0.0, 0.0])),
        mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=boom, localPosition=[0.0, 0.0, 0.0])),
    ]
    mbs.AddObject(
        items.ObjectConnectorHydraulicActuatorSimple(
            markerNumbers=ends,
            nodeNumbers=[pressures],
            offsetLength=0.6,
            strokeLength=1.0,
            chamberCrossSection0=2e-3,
            chamberCrossSection1=1.5e-3,
            hoseVolume0=1e-3,
            hoseVolume1=1e-3,
            valveOpening0=1.0,
            valveOpening1=-1.0,
            actuatorDamping=1e4,
            oilBulkModulus=1e9,
            cylinderBulkModulus=1e10,
            hoseBulkModulus=1e10,
            nominalFlow=3e-8,
            systemPressure=1e7,
            tankPressure=1e5,
        )
    )
    return boom


def test_hydraulic_cylinder_lifts_a_boom_as_on_fixed_ground():
    """Pressures are coordinates of first order; the frame is a thousand times as heavy as the boom."""
    case = still_case()
    ends = []
    for fixed in (False, True):
        _container, mbs = model()
        track = add_track(mbs, case)
        base = track.body
        if fixed:
            base = mbs.CreateGround(referencePosition=track.position, referenceRotationMatrix=track.axes)
        boom = boom_on(mbs, base, track)
        mbs.Assemble()
        chosen = settings(case, 0.1)
        if fixed:
            chosen.timeIntegration.newton.absoluteTolerance = 1e-6
            mbs.SolveDynamic(chosen)
        else:
            solve_dynamic(mbs, chosen)
        position = mbs.GetObjectOutputBody(boom, exu.OutputVariableType.Position, [0, 0, 0])
        ends.append((position - track.position, mbs.systemData.GetODE1Coordinates()))
    (place, pressure), (expected, expected_pressure) = ends
    assert pressure == pytest.approx(expected_pressure, rel=1e-3)
    assert place == pytest.approx(expected, abs=1e-3)
