"""Contact of lugs with the teeth of a tumbler: geometry, and Exudyn's contact of curve and circle."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

from exudyn_crawler import Case
from exudyn_crawler.model.exudyn import exu, items
from exudyn_crawler.model.forces.impact import Flange, flange_force
from exudyn_crawler.model.forces.teeth import tooth

PROFILE = Case.closed().gear.tumbler.profile(Case.closed().track)


def depth(place):
    """Penetration of a lug at x and z in the tumbler's axes, m."""
    return tooth(PROFILE, *place)[0]


def test_normal_is_the_gradient_of_the_depth():
    rng, compared = np.random.default_rng(0), 0
    for _ in range(4000):
        radius = rng.uniform(PROFILE.center - PROFILE.arc, PROFILE.addendum + PROFILE.lug)
        angle = rng.uniform(-math.pi, math.pi)
        place = np.array([radius * math.cos(angle), radius * math.sin(angle)])
        found = tooth(PROFILE, *place)
        if not 0.0 < found[0] < 0.05:
            continue
        step = 1e-6
        slope = [(depth(place + e) - depth(place - e)) / (2.0 * step) for e in step * np.eye(2)]
        assert slope == pytest.approx([-found[1], -found[2]], abs=1e-6)
        compared += 1
    assert compared > 100


def test_normal_turns_by_what_is_returned():
    for place in ((1.06, 0.05), (1.17, 0.26)):
        _, nx, nz, turn = tooth(PROFILE, *place)
        step = 1e-6
        moved = tooth(PROFILE, place[0] - step * nz, place[1] + step * nx)
        across = (moved[1] * -nz + moved[2] * nx) / step
        assert across == pytest.approx(-turn, rel=1e-4)


def test_lug_has_its_seat_without_play_and_gaps_repeat():
    radius = Case.closed().gear.tumbler.radius(Case.closed().track.pitch)
    for k in range(int(PROFILE.gaps)):
        angle = 2.0 * math.pi * k / PROFILE.gaps
        assert depth((radius * math.cos(angle), radius * math.sin(angle))) == pytest.approx(0.0, abs=1e-12)


def test_flange_has_play_and_pushes_back():
    flange = Flange(0.01, 1e8, 1e6)
    assert flange_force(flange, 0.0099, 1.0) == (0.0, 0.0, 0.0)
    assert flange_force(flange, 0.012, 0.0)[0] == pytest.approx(-2e5)
    assert flange_force(flange, -0.012, 0.0)[0] == pytest.approx(2e5)
    # damping alone does not pull
    assert flange_force(flange, 0.0101, -10.0)[0] == 0.0


STIFFNESS, SEGMENTS = 5e8, 800


def exudyn_place(start, force):
    """Where Exudyn's contact of a curve of segments with a circle holds a disc at rest under a force, m."""
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[*start, 0.0]))
    disc = mbs.AddObject(items.ObjectRigidBody2D(nodeNumber=node, mass=4490.0, inertia=4490.0))
    middle = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=disc))
    mbs.AddLoad(items.LoadForceVector(markerNumber=middle, loadVector=[*force, 0.0]))
    held = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=[*start, 0.0]))
    damper = {"stiffness": [0.0] * 3, "damping": [2e5, 2e5, 0.0]}
    mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=[held, middle], **damper))
    cosine = (PROFILE.center**2 + PROFILE.arc**2 - PROFILE.addendum**2) / (2.0 * PROFILE.center * PROFILE.arc)
    psi = np.linspace(math.acos(cosine), -math.acos(cosine), SEGMENTS + 1)
    points = np.column_stack((PROFILE.center - PROFILE.arc * np.cos(psi), -PROFILE.arc * np.sin(psi)))
    apart = [-1.0, 0.0, 0.0] * SEGMENTS
    data = mbs.AddNode(items.NodeGenericData(initialCoordinates=apart, numberOfDataCoordinates=len(apart)))
    frames = [mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body)) for body in (ground, disc)]
    curve = {"segmentsData": exu.MatrixContainer(np.column_stack((points[:-1], points[1:])))}
    contact = {"circlesRadii": [PROFILE.lug], "contactStiffness": STIFFNESS, "contactDamping": 1e5}
    mbs.AddObject(items.ObjectContactCurveCircles(markerNumbers=frames, nodeNumber=data, **curve, **contact))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = 2.0, 1000
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.6
    settings.timeIntegration.verboseMode = 0
    mbs.SolveDynamic(settings)
    return np.array(mbs.GetNodeOutput(node, exu.OutputVariableType.Position)[:2])


@pytest.mark.simulation
@pytest.mark.parametrize("force", [(-5e5, 1e5), (-5e5, -1e5), (-4e5, 3e5), (-4e5, -3e5)])
def test_disc_rests_where_exudyn_holds_it(force):
    """On either flank: in the seat, and up the flank by which a tumbler drives or brakes.

    Exudyn's stiffness counts a metre of the curve, so that the depth is that of an integral along the arc.
    """
    size = math.hypot(*force)
    along = np.array(force) / size
    seat = np.array([PROFILE.center, 0.0])
    # ours: the arc's centre, the disc and the force lie on a line
    ours = seat + along * (PROFILE.arc - PROFILE.lug + 1e-3)
    found = tooth(PROFILE, *ours)
    assert found[0] == pytest.approx(1e-3, abs=1e-12)
    assert found[1:3] == pytest.approx(-along, abs=1e-12)
    place = exudyn_place(ours, force) - seat
    assert place @ [-along[1], along[0]] == pytest.approx(0.0, abs=1e-6)

    psi = np.linspace(-0.5, 0.5, 20001)

    def excess(depth):
        off = PROFILE.arc - PROFILE.lug + depth
        distance = np.sqrt(PROFILE.arc**2 + off**2 - 2.0 * PROFILE.arc * off * np.cos(psi))
        pressed = np.maximum(PROFILE.lug - distance, 0.0) * (PROFILE.arc * np.cos(psi) - off) / distance
        return STIFFNESS * PROFILE.arc * pressed.sum() * (psi[1] - psi[0]) - size

    expected = brentq(excess, 1e-5, 0.05)
    assert place @ along - (PROFILE.arc - PROFILE.lug) == pytest.approx(expected, rel=0.02)


HALF_PITCH = {"teeth": 21, "gaps_per_shoe": 2, "depth": None}


@pytest.mark.parametrize(
    ("changes", "greatest"), [({}, 2.1e-3), (HALF_PITCH, 1.9e-3)], ids=["10 gaps", "10.5 gaps"]
)
def test_polygon_effect_of_a_light_chain_that_is_pulled_over_the_teeth(changes, greatest):
    """Kinematic rig: links without weight run from a lug held in its gap over the teeth into a straight pull.

    How far the chain goes is R sin of the angle of the last lug in a gap: 2 mm more or less than the
    pitches that the tumbler has turned by. Of 21 gaps the chain uses every second one.
    """
    case = Case.closed()
    tumbler, pitch = case.gear.tumbler.with_(changes), case.track.pitch
    profile, radius, count = (
        tumbler.profile(case.track),
        tumbler.radius(pitch),
        tumbler.shoes_per_turn,
    )
    gap, push, stiffness = 2.0 * np.pi / count, 1.0, 1e6  # a millionth of a metre deep
    between = 2.0 * np.pi / tumbler.teeth
    # the first lug, in a gap, stands where the third one is half a gap before the top
    start = 0.5 * np.pi + 2.5 * gap
    ready = between * round(start / between) - start

    def lugs(links, held):
        steps = pitch * np.column_stack((np.cos(links), np.sin(links)))
        return held + np.cumsum(steps, axis=0)

    def energy(links, held, angle):
        places, c, s = lugs(links, held), np.cos(angle), np.sin(angle)
        depth = [tooth(profile, c * x - s * z, s * x + c * z)[0] for x, z in places]
        return 0.5 * stiffness * np.sum(np.maximum(depth, 0.0) ** 2) - push * places[-1, 0]

    turned, travel = np.linspace(0.02, gap - 0.02, 13), []
    # and pairs of instants: a lug has just come in, is in the middle, soon goes out
    pairs = np.add.outer([0.0, 0.5 * gap - 3e-3, gap - 6e-3], [1e-3, 5e-3])
    turned = np.append(turned, pairs)
    for angle in turned:
        seats = start - gap * np.arange(3) - angle
        at = radius * np.column_stack((np.cos(seats), np.sin(seats)))
        first = [*np.arctan2(*(at[1:] - at[:-1]).T[::-1]), 0.0, 0.0, 0.0]
        found = minimize(energy, np.array(first) + 1e-3, (at[0], angle + ready), method="BFGS")
        travel.append(lugs(found.x, at[0])[-1, 0])
    ahead = turned - 0.5 * gap
    assert np.array(travel) == pytest.approx(radius * np.sin(ahead) + 3.0 * pitch, abs=1e-5)
    speeds = np.diff(travel)[13::2] / np.diff(turned)[13::2]
    # the chain's speed over the tumbler's varies by 1 - cos(pi / n), but for the 3 mrad that are left
    assert 1.0 - speeds[0] / speeds[1] == pytest.approx(1.0 - np.cos(np.pi / count - 3e-3), rel=1e-3)
    assert speeds[2] == pytest.approx(speeds[0], rel=1e-4)
    assert speeds[1] == pytest.approx(radius, rel=1e-4)
    beside = np.array(travel) - 3.0 * pitch - count * pitch / (2.0 * np.pi) * ahead
    assert np.abs(beside).max() == pytest.approx(greatest, abs=5e-5)
    assert beside.max() == pytest.approx(-beside.min(), abs=5e-5)
