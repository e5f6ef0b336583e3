"""Flexible shoes in the track: statics, stiffness limit, vibration, momentum, stresses; one on supports."""

import weakref

import exudyn as exu
import exudyn.itemInterface as items
import numpy as np
import pytest

from exudyn_crawler import Case, Drive, FlexibleShoes, StepProfile, Terrain, simulate
from exudyn_crawler.engine.bodies import add_shoe_nodes, add_shoes
from exudyn_crawler.ground.pairs import RESULT
from exudyn_crawler.model.assemble import assemble
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.flexible_shoes import factors_held, floating_shoe, partition, shoe_model
from exudyn_crawler.model.forces.loads import Loads
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.results.loads.load_map import unit_loads
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from fem import Partition, write_mesh
from fem.body.element_stress import von_mises
from studies.grounds import plain
from studies.stress import with_modes
from tests.modal_loads import modal_loads, whole_coordinates
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

COORDINATES = exu.OutputVariableType.Coordinates
SMALL = FlexibleShoes.ph4100c(SMALL_SHOE)
LOAD = 386.4e3
"""N, of a shoe, evenly spread over the loaded surface."""


def track(**changes):
    """The papers' track on the fine grid with two flexible shoes: one in the middle, one driven."""
    flexible = SMALL.with_(shoes=(7, 13), **changes)
    return plain(Case.translation()).with_(terrain=Terrain.stress(), flexible=flexible)


@pytest.fixture(scope="module")
def history():
    return simulate(track(), 0.1)


def test_neither_factors_nor_matrices_outlive_the_reduction():
    body, interfaces = shoe_model(track().part(FlexibleShoes), track().track)
    with factors_held(track()):
        held = weakref.ref(partition(body, interfaces))
        assert held() is not None
        stiffness = weakref.ref(body.stiffness)
        mass = weakref.ref(body.mass_matrix)
    assert (held(), stiffness(), mass()) == (None, None, None)


def test_only_elastic_modes_are_integrated():
    floating = floating_shoe(track())
    assert floating.mode_count == 24 + 12 - 6
    assert floating.reduced.frequencies[0] == pytest.approx(178.07, rel=0.02)


def test_the_ground_carries_the_weight_of_rigid_and_flexible_shoes():
    case = track()
    system = compiled_system(case)
    q = static_equilibrium(case)
    contacts, _ = system.contact.results(q[None], 0.0 * q[None])
    carried = contacts[:, RESULT["normal_force"]][:, 2].sum()
    flexible = floating_shoe(case).reduced.mass
    weight = 13 * LOAD + (11 * case.shoe.mass + 2 * flexible) * case.gravity
    assert carried == pytest.approx(weight, rel=1e-6)


def relative_difference(one, exact):
    return float(np.sqrt(np.mean((one - exact) ** 2) / np.mean(exact**2)))


def stiff_and_rigid(folder, point):
    """Runs of a track with shoes a thousand times stiffer and of the rigid one, driven at a point.

    The mesh is moved to its COM, 1 mm off, where a rigid shoe's is.
    """
    case = track(youngs_modulus=200e12)
    body, _ = shoe_model(case.flexible, case.track)
    x, y, z = body.center_of_mass
    path = folder / "centred.msh"
    mesh = body.mesh
    write_mesh(path, type(mesh)(mesh.nodes - body.center_of_mass, mesh.elements, mesh.surfaces))
    ahead, height = case.track.pin_ahead - x, case.track.pin_height - z
    right, left = case.track.spherical_y - y, case.track.parallel_y - y
    stiff = case.with_(
        track=case.track.with_(pin_ahead=ahead, pin_height=height, spherical_y=right, parallel_y=left),
        drive=Drive(speed=StepProfile(times=(0.0, 0.2), values=(0.0, 0.02)), point=point),
        flexible=case.flexible.with_(mesh=str(path)),
    )
    reduced = floating_shoe(stiff).reduced
    shoe = stiff.shoe.with_(
        mass=reduced.mass,
        inertia=tuple(reduced.inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))),
        load_point=tuple(floating_shoe(stiff).load_point),
    )
    return simulate(stiff.with_(shoe=shoe), 0.2), simulate(stiff.with_(shoe=shoe, flexible=None), 0.2)


@pytest.mark.slow
@pytest.mark.parametrize("point", ["frame", "front pins"])
@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_a_shoe_a_thousand_times_stiffer_follows_the_rigid_one(tmp_path, point):
    """From the first step on; measured: 2e-4 of the accelerations, 5e-5 else."""
    one, rigid = stiff_and_rigid(tmp_path, point)
    allowed = {"joint_force": 2e-4, "drive_force": 2e-4, "velocity": 2e-4, "acceleration": 5e-4}
    for name, most in allowed.items():
        axis = {} if name == "drive_force" else {"axis": "x"}
        assert relative_difference(*(h.dataset[name].sel(axis) for h in (one, rigid))) < most, name
    carried = [float(h.normal_force.sel(axis="z").sum("contact").mean()) for h in (one, rigid)]
    assert carried[0] == pytest.approx(carried[1], rel=1e-4)


def test_momentum_of_the_track_balances(history):
    """Modes are orthogonal to rigid motion: a shoe's momentum is its mass times its frame's rate."""
    case = history.case
    mass = np.full(13, case.shoe.mass)
    mass[[6, 12]] = floating_shoe(case).reduced.mass
    rate = (mass[:, None] * history.acceleration).sum("shoe").values
    force = (history.normal_force + history.friction_force).sum("contact").values
    weight = 13 * LOAD + mass.sum() * case.gravity
    force[:, 2] -= weight
    force[:, 0] += history.drive_force.values
    # the mesh's COM lies 0.4 mm beside its frame's origin: 1e-6 of the weight at 1 rad/s2
    assert np.abs(rate - force).max() < 2e-6 * weight


def test_both_pins_of_a_flexible_link_share_its_force(history):
    link = history.pin_force.sel(joint=12)
    assert link.sum("pin").values == pytest.approx(history.joint_force.sel(joint=12).values, abs=1e-6)
    late = link.sel(axis="x").isel(time=-1)
    assert (late > 0.2 * late.sum()).all()


def test_a_free_shoe_vibrates_at_its_modal_frequency():
    """Shoes afloat without weight or damping, the first mode of one set going."""
    case = track(damping=StepProfile.constant(0.0)).with_(gravity=0.0)
    floating = floating_shoe(case)
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    tables = assemble(case).tables
    shoes = add_shoes(mbs, tables, add_shoe_nodes(mbs, tables), np.zeros(3))
    modal_node = shoes.modal_nodes[0]
    mbs.SetNodeParameter(modal_node, "initialCoordinates_t", [1e-2] + [0.0] * (floating.mode_count - 1))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    integration, first = settings.timeIntegration, []
    integration.endTime, integration.numberOfSteps = 0.05, 2000
    integration.generalizedAlpha.spectralRadius, integration.generalizedAlpha.useNewmark = 1.0, True
    mbs.SetPostStepUserFunction(
        lambda system, t: first.append((t, system.GetNodeOutput(modal_node, COORDINATES)[0])) or True
    )
    mbs.SolveDynamic(settings)
    time, q = np.array(first).T
    rising = np.flatnonzero((q[:-1] < 0.0) & (q[1:] >= 0.0))
    crossings = time[rising] - q[rising] * (time[rising + 1] - time[rising]) / (q[rising + 1] - q[rising])
    periods = len(crossings) - 1
    assert periods >= 6
    frequency = periods / (crossings[-1] - crossings[0])
    # 220 steps a period: the trapezoidal rule is 7e-5 slow
    assert frequency == pytest.approx(floating.reduced.frequencies[0], rel=3e-4)


def test_integrated_modes_lie_inside_the_whole_basis(history):
    units = unit_loads(history.case)
    # 24 constraint modes, 76 fixed-interface modes and the answer to the drive, less six rigid modes
    assert len(units.whole.frequencies) == 24 + 76 + 1 - 6
    inside = units.integrated.inside
    assert inside.T @ inside == pytest.approx(np.eye(inside.shape[1]), abs=1e-9)


def test_recovered_statics_are_those_of_the_whole_basis(history):
    """At rest all 94 modes answer statically to their loads: K q = f for each of them."""
    units = unit_loads(history.case)
    still = type(history)(history.case, history.dataset.isel(time=[0]))
    for shoe in (7, 13):
        q = whole_coordinates(still, shoe)
        loads = modal_loads(still, shoe)
        stiffness = (2.0 * np.pi * units.whole.frequencies) ** 2
        static = loads / stiffness
        stress, expected = (units.whole.von_mises(x).max() for x in (q, static))
        assert stress == pytest.approx(expected, rel=1e-3)


def test_a_shoe_bends_under_its_load_as_the_whole_model_does():
    """A free shoe between its evenly spread load and an even ground, against a direct solution."""
    body, _ = shoe_model(track().flexible, track().track)
    reduced, force = floating_shoe(track()).reduced, np.array([0.0, 0.0, -LOAD])
    load = reduced.load("top", force) - reduced.load("underside", force)
    q = load / (2.0 * np.pi * reduced.frequencies) ** 2
    forces = body.surface_load("top", force) - body.surface_load("underside", force)
    exact = body.displacement_under(forces.reshape(-1, 1)).reshape(-1, 3)
    middle = np.abs(body.mesh.nodes[:, 1]) < 0.05
    bend = [
        u[middle, 2].mean() - u[np.abs(body.mesh.nodes[:, 1]) > 1.7, 2].mean()
        for u in (reduced.displacement(q)[0], exact)
    ]
    assert bend[0] == pytest.approx(bend[1], rel=0.05)


def test_a_released_shoe_is_driven_no_more_until_the_drive_is_on_again():
    speed = StepProfile(times=(0.0, 0.05, 0.1, 0.15, 0.2), values=(0.0, 0.01, 0.0, 0.0, 0.02))
    case = Case.translation().with_(drive=Drive(speed=speed, on=((0.0, 0.1), (0.15, 9.0))))
    history = simulate(case, 0.2)
    t = history.time
    off = (t > 0.1 + 1e-9) & (t <= 0.15 + 1e-9)
    front = history.velocity.sel(shoe=13, axis="x")
    assert (history.drive_force.where(~off, drop=True)[1:] != 0.0).all()
    assert (history.drive_force.where(off, drop=True) == 0.0).all()
    assert float(np.abs(front.where(off, drop=True)).max()) > 0.0
    again = (t > 0.15 + 1e-9).values
    assert front.values[again] == pytest.approx(speed.value(t.values[again]), abs=1e-9)


def test_modes_are_chosen_by_number_or_frequency():
    def chosen(modes):
        return floating_shoe(track().with_(flexible=with_modes(SMALL.with_(shoes=(13,)), modes)))

    assert chosen("1-3, 6").mode_count == 4
    frequencies = chosen("500 Hz").reduced.frequencies
    assert 1 < len(frequencies) < 94
    assert frequencies.max() <= 500.0
    with pytest.raises(ValueError, match="highest_frequency must be at least"):
        chosen("100Hz")


def test_a_staged_run_with_flexible_shoes_is_the_unstaged_one(history):
    """Solver calls one after the other with floating-frame bodies, each from the state that the last left."""
    staged = history.case.with_({"solver.checkpoint_interval": 0.02})
    parts = simulate(staged, history.duration).dataset
    # a stage takes its first accelerations for the scheme's own, a quarter of a step before, and the pulled
    # node makes the modes swing on with the difference; of second order in the step (with half of it 12 times
    # less): measured 3.4e-4 of the modal velocity, at most 4e-5 else
    allowed = {"position": 1e-9, "velocity": 1e-3, "joint_force": 1e-4, "modal_coordinate": 1e-4}
    for name, most in (allowed | {"modal_velocity": 1e-3}).items():
        off = relative_difference(parts[name].values, history.dataset[name].values)
        assert 0.0 < off < most, (name, off)


def test_the_load_goes_over_the_named_surface():
    """From the rails to the whole top it spreads, and a shoe on even ground is stressed less and less."""
    body, interfaces = shoe_model(FlexibleShoes.ph4100c("coarse"), track().track)
    surfaces = ("rails", "plateau", "whole top")
    assert SMALL.load_surface == "whole top"
    loads = [body.surface_load(name, np.array([0.0, 0.0, -1e6])) for name in surfaces]
    ground = body.surface_load("underside", np.array([0.0, 0.0, 1e6]))
    forces = np.column_stack([(load + ground).ravel() for load in loads])
    answer = Partition(body, interfaces).static_response(forces).reshape(-1, 3, len(surfaces))
    peaks = von_mises(np.moveaxis(body.stress(answer), 2, 0)).max(axis=1)
    # 41, 30 and 16 MPa at 611 kN on this mesh
    assert peaks * 0.611e-6 == pytest.approx([41.3, 29.7, 16.1], rel=0.03)
    body, _ = shoe_model(SMALL, track().track)
    for name in surfaces:
        weights = body.surface_weights(name)
        middle = weights @ body.mesh.nodes / weights.sum()
        assert floating_shoe(track(load_surface=name)).load_point == pytest.approx(middle, abs=1e-9)
    with pytest.raises(ValueError, match=r"load_surface must be a surface of the mesh '.*small_shoe"):
        shoe_model(SMALL.with_(load_surface="bottom"), track().track)


HELD = {"front right": (1, 1, 1), "front left": (1, 0, 1), "rear right": (0, 0, 1), "rear left": (0, 0, 1)}
"""Directions x, y, z in which each joint centre is held; all its rotations are free."""


def supported_case(load_mode=False):
    case = Case.stress(SMALL_SHOE)
    flexible = with_modes(case.flexible.with_(shoes=(7,), load_mode=load_mode), "all")
    return case.with_(gravity=0.0, flexible=flexible)


def in_engine(case):
    """Displacements (nodes, 3) and stress (nodes, 6) of the reduced shoe as the engine's body carries it."""
    floating = floating_shoe(case)
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    tables, ground = assemble(case).tables, mbs.AddObject(items.ObjectGround())
    reduced, nodes, rows = floating.reduced, add_shoe_nodes(mbs, tables), floating.load_rows
    pilots = zip(reduced.interfaces, reduced.pilots, strict=True)
    points = [(interface.center, pilot[:3], pilot[3:]) for interface, pilot in pilots]
    points.append((floating.load_point, rows, np.zeros_like(rows)))
    places = (np.array(one) for one in zip(*points, strict=True))
    count = len(points)
    markers = Markers(np.full(count, 6), *places, np.full(count, floating.mode_count))
    tables = tables._replace(markers=markers, loads=Loads(*np.zeros((2, 0), dtype=int)))
    shoes = add_shoes(mbs, tables, nodes, np.zeros(3))
    for other in (*nodes[:6], *nodes[7:]):
        at = mbs.GetNode(other)["referenceCoordinates"][:3]
        base = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=at))
        marker = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=other))
        mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[base, marker]))
    place = np.array(case.track.com_positions(case.shoe.com_height)[6])
    for interface, marker in zip(reduced.interfaces, shoes.markers[:-1], strict=True):
        center = (place + case.track.joint_centers[interface.name]).tolist()
        base = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=center))
        axes = [*HELD[interface.name], 0, 0, 0]
        mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[base, marker], constrainedAxes=axes))
    mbs.AddLoad(items.LoadForceVector(markerNumber=shoes.markers[-1], loadVector=[0.0, 0.0, -LOAD]))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.staticSolver.useLoadFactor = False
    newton = settings.staticSolver.newton
    newton.absoluteTolerance, newton.relativeTolerance = 1e-3, 1e-16
    newton.weightTolerancePerCoordinate, newton.maxIterations = True, 50
    mbs.SolveStatic(settings)
    moved = np.array(mbs.GetNodeOutput(nodes[6], COORDINATES))
    q = np.array(mbs.GetNodeOutput(shoes.modal_nodes[0], COORDINATES))
    # e1 to e3 are half the small angles
    rigid = moved[:3] + np.cross(2.0 * moved[4:7], reduced.nodes)
    return rigid + reduced.displacement(q)[0], reduced.stress(q)[0]


@pytest.fixture(scope="module")
def full():
    """The same of the full model with its spiders, by a direct solution."""
    case = supported_case()
    body, interfaces = shoe_model(case.flexible, case.track)
    partition = Partition(body, interfaces)
    modes = partition.constraint_modes
    forces = body.surface_load(case.flexible.load_surface, np.array([0.0, 0.0, -LOAD])).reshape(-1, 1)
    stiffness = modes.T @ (body.stiffness @ modes)
    held = np.concatenate([[*HELD[interface.name], 0, 0, 0] for interface in interfaces]).astype(bool)
    centers = np.zeros((len(held), 1))
    centers[~held] = np.linalg.solve(stiffness[np.ix_(~held, ~held)], (modes.T @ forces)[~held])
    answer = (modes @ centers + partition.held_response(forces)).reshape(-1, 3)
    return answer, body.stress(answer[:, :, None])[:, :, 0]


@pytest.mark.slow
def test_a_simply_supported_shoe_with_a_mode_for_its_load_is_the_full_model(full):
    displacement, stress = in_engine(supported_case(load_mode=True))
    assert np.abs(full[0][:, 2]).max() > 3e-5
    assert von_mises(full[1]).max() > 15e6
    assert relative_difference(displacement, full[0]) < 0.002
    # the mode balances the load by the shoe's own inertia, the supports here do it at the pins
    assert relative_difference(stress, full[1]) < 0.01


@pytest.mark.slow
def test_the_94_modes_lose_what_the_load_bends_between_them(full):
    """Measured: 0.3 % of the displacements and 2 % of the stresses in the mean, 0.3 % of the greatest."""
    displacement, stress = in_engine(supported_case())
    assert 0.001 < relative_difference(displacement, full[0]) < 0.01
    assert 0.01 < relative_difference(von_mises(stress), von_mises(full[1])) < 0.05
    assert von_mises(stress).max() == pytest.approx(von_mises(full[1]).max(), rel=0.01)
