"""The command `assess`, what it leaves, and formulas beside runs of the program."""

import time

import numpy as np
import pandas as pd
import pytest

from exudyn_crawler import Case, History, StepProfile, assess, simulate
from exudyn_crawler.assessment import forces, pressure, rollers, run_forces, stability, travel
from exudyn_crawler.assessment.assessment import assessment_of
from exudyn_crawler.assessment.inputs import numbers_of
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.shoe import check_of, shoe_stresses
from exudyn_crawler.case import Drive, Heights, Ridge, Track
from exudyn_crawler.case.parameters.track import SIDES, FlexibleShoes
from exudyn_crawler.errors import ImplausibleWarning
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.machines.datasheet.ledger import GENERAL
from exudyn_crawler.origins import Origin
from exudyn_crawler.results.checks.cases import ShoeCheck
from exudyn_crawler.views.pages import signed
from fem import Mesh, write_mesh
from meshes import mesh_named

STILL = Drive(speed=StepProfile.constant(0.0))
FLOOR = RockFloor.hard_floor().with_(stiffness=1e8, friction=0.3)
BARE = AssessmentSettings(mesh=None)


def standing(slew):
    case = Case.shovel().with_({"gear.car_body.slew": float(np.radians(slew))}, drive=STILL)
    return simulate(case.on_cells(FLOOR), 0.01, progress=False)


@pytest.fixture(scope="module")
def aside():
    """Machine that stands with its upper structure at 60 degrees."""
    return standing(60.0)


def on_shoes(history):
    """Normal force on every shoe as the run ends: array (shoes,), N, and places ahead of the frame, m."""
    normal = history.contacts_by_shoe().normal_force.transpose("time", "shoe", "axis").values[-1]
    place = history.position.transpose("time", "shoe", "axis").values[-1, :, 0]
    frame = history.side_frame_position.transpose("time", "axis").values[-1, 0]
    return np.linalg.norm(normal, axis=-1), place - frame


@pytest.mark.slow
@pytest.mark.simulation
def test_tracks_of_a_run_bear_what_statics_says(aside):
    """Loads of both tracks within 1 %, place of the resultant within 1 cm."""
    numbers = numbers_of(aside.case, BARE)
    level = forces.gravity_on_slope(9.81, 0.0, 0.0)
    stands = forces.resultant(forces.forces_at(numbers.weights, numbers.work, np.radians([60.0]), level))
    left, right = pressure.track_loads(stands.weight, stands.aside, numbers.footprints.gauge)
    force, place = on_shoes(aside)
    half = len(force) // 2
    assert force[half:].sum() == pytest.approx(left[0], rel=0.01)
    assert force[:half].sum() == pytest.approx(right[0], rel=0.01)
    assert force @ place / force.sum() == pytest.approx(stands.ahead[0], abs=0.01)


@pytest.mark.slow
@pytest.mark.simulation
def test_pressure_along_a_track_of_a_run(aside):
    """Trapezoid over the whole shoes below the rollers: each within a tenth of the mean.

    Shoes rest on a linear floor. Those beyond the outer rollers bear little and are left out of the length.
    """
    force, place = on_shoes(aside)
    half = len(force) // 2
    gear, pitch = aside.case.gear, aside.case.track.pitch
    middle = place[:half] + aside.case.track.pin_ahead - 0.5 * pitch
    below = (middle > gear.rollers[0] - 0.5 * pitch) & (middle < gear.rollers[-1] + 0.5 * pitch)
    # those of the upper run bear nothing
    below &= force[:half] > 0.0
    x, load = middle[below], force[:half][below]
    assert len(x) == 9
    length = len(x) * pitch
    away = load @ (x - x.mean()) / load.sum()
    wanted = load.mean() * (1.0 + 12.0 * away * (x - x.mean()) / length**2)
    assert load == pytest.approx(wanted, abs=0.1 * load.mean())
    beam = pressure.track_pressure(load.sum(), away, length, aside.case.shoe.width)
    assert load.max() / (pitch * aside.case.shoe.width) == pytest.approx(beam.greatest, rel=0.1)


@pytest.mark.simulation
def test_a_runs_forces_take_the_place_of_the_formulas(aside):
    run = run_forces.forces_of_run(aside, "aside")
    assert (run.drive, run.uneven) == ("none", False)
    found = assessment_of(aside.case, BARE, runs=[(None, run)])
    taken = found.loads[0]
    assert taken.basis == "run aside"
    assert taken.roller == run.roller
    assert {row.basis for row in found.loads[1:]} == {"formula"}
    used = [one for one in found.found if one.load_case == taken.name and one.basis == "run aside"]
    assert {"greatest ground pressure", "chain tension"} <= {one.item for one in used}
    assert {one.basis for one in found.found if one.item == "tipping"} == {"formula"}
    assert any("has the forces of run aside" in line for line in found.lines)
    # a mean over shoes is no even equivalent of Meyerhof's, and has an item of its own
    pressures = {one.item: one for one in used if "pressure" in one.item}
    assert "even equivalent of the pressure" not in pressures
    force = on_shoes(aside)[0]
    mean = force[force >= 0.1 * force.max()].mean()
    part = aside.case.track.pitch * aside.case.shoe.width
    last = History(aside.case, aside.dataset.isel(time=[-1]))
    assert run_forces.forces_of_run(last, "last").mean_pressure == pytest.approx(mean / part)
    assert pressures["mean pressure of the loaded shoes"].number == pytest.approx(run.mean_pressure / 1e3)
    beside = found.compared.set_index("quantity")
    assert beside.loc["track load", "run over formula"] == pytest.approx(1.0, abs=0.02)
    assert beside["what makes a difference"].str.len().min() > 10


@pytest.mark.simulation
def test_a_run_stands_for_the_load_case_that_is_named(aside):
    """Another one than its own, each load case with the forces of one run; what is of none is refused."""
    run = run_forces.forces_of_run(aside, "aside")
    found = assessment_of(aside.case, BARE, runs=[("digs", run), (None, run)])
    assert [row.basis for row in found.loads[:3]] == ["run aside", "run aside", "formula"]
    assert set(found.compared["load case"]) == {row.name for row in found.loads[:2]}
    with pytest.raises(ValueError, match="has the forces of run aside"):
        assessment_of(aside.case, BARE, runs=[("digs", run), ("digs", run)])
    with pytest.raises(ValueError, match=r"must be one of .*digs.*got 'dig'"):
        assessment_of(aside.case, BARE, runs=[("dig", run)])
    # with a payload none of the load cases stands without one
    loaded = BARE.with_(work={"payload": 9e4, "reach": 17.0})
    with pytest.raises(ValueError, match=r"fits no load case; name .*LOAD CASE=RUN"):
        assessment_of(aside.case, loaded, runs=[(None, run)])


@pytest.mark.simulation
def test_the_resultant_of_a_run_is_as_far_from_the_edge_as_statics_says(aside):
    """Within 1 cm ahead; across by the loads of both tracks, of which 65 mm of the pins move some."""
    numbers = numbers_of(aside.case, BARE)
    level = forces.gravity_on_slope(9.81, 0.0, 0.0)
    stands = forces.resultant(forces.forces_at(numbers.weights, numbers.work, np.radians([60.0]), level))
    foot = run_forces.forces_of_run(aside, "aside").foot[-1]
    assert foot[0] + numbers.weights.swing_axis == pytest.approx(stands.ahead[0], abs=0.01)
    assert foot[1] == pytest.approx(stands.aside[0], abs=0.05)


def leaning(degrees, seconds):
    """Roll (rad) over time and loads (N) of the left rollers of a top-heavy machine across a slope."""
    case = Case.shovel()
    x, y, z = case.gear.car_body.upper_com
    case = case.with_(
        {"gear.car_body.upper_com": (x, y, z + 20.0), "terrain.side_slope": np.tan(np.radians(degrees))},
        drive=STILL,
    )
    history = simulate(case.on_cells(FLOOR.with_(friction=0.9)), seconds, progress=False)
    wheels = history.wheel_force.transpose("time", "wheel", "axis")
    left = [name.startswith("left roller") for name in wheels.wheel.values.tolist()]
    roll = history.side_frame_angles.values.reshape(len(history.time), -1)[:, 0]
    return case, roll, np.linalg.norm(wheels.values[:, left], axis=-1)


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
@pytest.mark.simulation
@pytest.mark.slow
def test_a_machine_across_a_slope_tips_where_statics_says():
    """It leaves the upper track's rollers at the angle about the lower track's middle, within a degree.

    It stands on the outer treads, to whose edges the resultant has a third of a metre more, and tips beyond.
    """
    case, steady, held = leaning(19.5, 0.5)
    numbers = numbers_of(case, BARE)
    level = forces.forces_at(
        numbers.weights, numbers.work, np.zeros(1), forces.gravity_on_slope(9.81, 0.0, 0.0)
    )
    outer = case.shoe.rails.left + 0.5 * case.gear.tread_width
    # treads are on rails, above the ground from which heights count
    lift = case.shoe.com_height + case.shoe.rails.height
    on_rails = level._replace(place=level.place - np.array([0.0, 0.0, lift]))
    edges = numbers.edges._replace(right=numbers.edges.right + outer)
    side = stability.EDGES.index("right")
    leaves = np.degrees(stability.tipping(level, numbers.edges).angle[0, side])
    tips = np.degrees(stability.tipping(on_rails, edges).angle[0, side])
    assert leaves == pytest.approx(20.5, abs=0.1)
    assert tips == pytest.approx(22.5, abs=0.3)
    assert held[-1].sum() > 5e-3 * 9.81 * numbers.weights.lower_mass
    _, stands, lifted = leaning(21.5, 3.0)
    # as it rocks they touch the rails again
    assert lifted[-1].sum() < 1e-3 * 9.81 * numbers.weights.lower_mass
    # it rocks on the treads as the chain of the upper track lifts off
    assert np.degrees(stands.max()) < 1.0
    _, falls, _ = leaning(tips + 3.0, 6.0)
    late = falls[len(falls) // 2 :]
    assert np.degrees(late[-1]) > 20.0
    assert (np.diff(late) > 0.0).all()
    assert np.degrees(np.ptp(steady)) < 0.01


@pytest.mark.simulation
@pytest.mark.slow
def test_turn_on_the_spot_beside_a_run():
    """Pull of both tracks on cells, whose friction goes with the slip of each place: within a tenth."""
    turn = StepProfile(times=(0.0, 1.0), values=(0.0, 0.03))
    case = Case.shovel().with_(
        {"solver.output_interval": 0.02}, drive=Drive(speed=StepProfile.constant(0.0), turn_rate=turn)
    )
    history = simulate(case.on_cells(FLOOR), 4.0, progress=False)
    numbers = numbers_of(history.case, BARE)
    place = numbers.weights.lower_com[0]
    masses = numbers.weights.lower_mass, numbers.weights.upper_mass
    ahead = (masses[0] * place - masses[1] * 1.0) / sum(masses)
    found = travel.turn_of_footprints(numbers.weight, numbers.footprints, 0.3, ahead)
    wheels = 0.03 * 0.5 * numbers.weight + numbers.chain.idler_drag
    late = history.time.values > 2.0
    torque = history.drive_moment.transpose("time", "track").values[late].mean(axis=0)
    mean = 0.5 * np.abs(torque).sum()
    assert (found.pull + wheels) * numbers.drive.radius == pytest.approx(mean, rel=0.1)


@pytest.mark.simulation
@pytest.mark.slow
def test_straight_travel_beside_a_run(tmp_path, told):
    """Torque on a hard floor within a tenth of V f / 2 and the idler's 2 T f: no other losses are in the run.

    A start in a second would make the machine surge for longer than the run. The command takes the forces of
    the run's history, and says of which items.
    """
    drive = Drive(speed=StepProfile(times=(0.0, 6.0), values=(0.0, 0.3)))
    case = Case.shovel().with_({"solver.output_interval": 0.02}, drive=drive).on_cells(FLOOR)
    # three shoes pass the tumbler
    history = simulate(case, 12.6, progress=False)
    numbers = numbers_of(case, BARE.with_(drive={"rest_tension": 261e3}))
    chain = numbers.chain
    resistance = travel.TravelResistance(0.03, chain.idler_drag, chain.pin_drag, numbers.footprints)
    needed = resistance.pull(numbers.weight) / 2.0
    run = run_forces.forces_of_run(history, "straight")
    assert run.torque == pytest.approx(needed * numbers.drive.radius, rel=0.1)
    assert run.tension < 2.0 * (261e3 + needed)
    history.save(tmp_path / "straight.nc")
    (tmp_path / "mine.toml").write_text('machine = "shovel"\nmesh = "none"\n')
    out = told("assess", "mine.toml", "--out", "assessed", "--run", "straight.nc")
    assert "'travels straight on the level' has the forces of run straight.nc" in out
    beside = pd.read_csv(tmp_path / "assessed" / "run.csv").set_index("quantity")
    # greatest over time: the machine bounces as teeth and rollers pass
    assert beside.loc["track load", "run over formula"] == pytest.approx(1.0, abs=0.1)
    items = pd.read_csv(tmp_path / "assessed" / "items.csv").set_index("item")
    pull = items.loc["pull of a track, travels straight on the level"]
    assert pull["from"] == "run straight.nc"
    assert pull["number"] * 1e3 == pytest.approx(run.torque * 0.9 / numbers.drive.radius, rel=1e-6)


@pytest.mark.simulation
@pytest.mark.slow
@pytest.mark.parametrize(("ahead", "limit"), [(0.0, 0.05), (None, 0.1)])
def test_roller_on_a_ridge_beside_a_run(ahead, limit):
    """Mean load of the middle roller of each track while it rolls slowly over the top of a ridge.

    With the COM above it the roller bears all of its track; with the COM where the shovel has it, 0.57 m
    behind, it has what a lever from the rear roller says. Starts that differ by millimetres, by 1 % of the
    speed or by half a step give means within 0.6 %. The limits leave what the formulas do not have: the frame
    leans back by 2 degrees, which takes the COM back by 0.08 m, and the ridge bears shoes up to 0.1 m ahead
    of the roller, together 6 % of the lever. A greatest load over time is no measure: at 0.3 m/s the machine
    bounces on the ridge, and starts that differ by 3e-14 m differ by 0.5 MN after 13 s.
    """
    drive = Drive(speed=StepProfile(times=(0.0, 2.0), values=(0.0, 0.05)))
    case = Case.shovel().with_({"solver.output_interval": 0.02}, drive=drive)
    if ahead is not None:
        weights = numbers_of(case, BARE).weights
        held = ahead * (weights.lower_mass + weights.upper_mass) - weights.lower_mass * weights.lower_com[0]
        _, aside, above = case.gear.car_body.upper_com
        case = case.with_({"gear.car_body.upper_com": (held / weights.upper_mass, aside, above)})
    ridge = Ridge(x=float(case.gear.frame_start(case)[0]) + 0.25, height=0.1, width=0.3, flank=0.3)
    history = simulate(case.on_cells(RockFloor.hard_floor(), Heights(parts=(ridge,))), 10.0, progress=False)
    assert run_forces.forces_of_run(history, "ridge").uneven
    numbers = numbers_of(case, BARE)
    level = forces.gravity_on_slope(9.81, 0.0, 0.0)
    stands = forces.resultant(forces.forces_at(numbers.weights, numbers.work, np.zeros(1), level))
    load = 0.5 * float(stands.weight[0]) - numbers.rollers.grounded_shoe_weight
    places = numbers.rollers.places
    middle = len(places) // 2
    if ahead is not None:
        assert stands.ahead[0] == pytest.approx(ahead, abs=1e-9)
        wanted = rollers.one_load(load, ahead, places)
    else:
        wanted = rollers.two_loads(load, float(stands.ahead[0]), places, (0, middle))
    away = history.side_frame_position.transpose("time", "axis").values[:, 0] + places[middle] - ridge.x
    on_top = np.abs(away) <= 0.5 * ridge.width
    assert on_top.sum() > 200
    wheels = history.wheel_force.transpose("time", "wheel", "axis")
    for side in SIDES:
        number = wheels.wheel.values.tolist().index(f"{side} roller {middle + 1}")
        mean = np.linalg.norm(wheels.values[on_top, number], axis=-1).mean()
        assert mean == pytest.approx(wanted[middle], rel=limit)


def test_the_command_leaves_tables_drawings_and_a_page(told, refused, tmp_path):
    (tmp_path / "mine.toml").write_text(
        'machine = "shovel"\nmesh = "none"\n[work]\npayload = "90 t"\nreach = 17.0\n'
        '[ground]\nname = "stiff clay"\n'
    )
    out = told("assess", "mine.toml", "--out", "assessed")
    first = out.splitlines()[:10]
    assert any(line.startswith("governs: ") for line in first)
    assert "greatest ground pressure" in out
    folder = tmp_path / "assessed"
    items = pd.read_csv(folder / "items.csv")
    used = items["utilisation"].dropna()
    assert used.is_monotonic_decreasing
    assert set(items["mark"]) <= {"S", "D", "R"}
    inputs = pd.read_csv(folder / "inputs.csv").set_index("path")
    assert set(inputs["origin"]) == set(Origin)
    # the file names a case of the program, and gives the payload
    assert inputs.origin["shoe.width"] == Origin.LIBRARY
    assert inputs.origin["work.payload"] == Origin.GIVEN
    page = (folder / "assessment.html").read_text()
    for words in ("Ground pressure", "Tipping", "Clauses followed", "no conformity", "stiff clay"):
        assert words in page
    assert len(list(folder.glob("*.png"))) == 7
    report = signed.stored(folder)
    assert [row[0] for row in report.answers.rows] == items["item"].tolist()
    assert report.lines[0] in first
    assert ("work.payload", "90000 kg") in report.given
    assert (
        len(report.assumed) == (inputs["origin"] == Origin.ASSUMED).sum() - (inputs["how"] == GENERAL).sum()
    )
    assert report.checksums[0][0].endswith("/mine.toml")
    assert "exists" in refused("assess", "mine.toml", "--out", "assessed")
    assert "no file" in refused("assess", "nowhere.toml")
    assert "no history" in refused("assess", "mine.toml", "--out", "other", "--run", "assessed")


@pytest.mark.slow
def test_a_shovel_and_an_excavator_are_assessed_in_twenty_seconds(tmp_path):
    """Of processor time, both together: finite elements of the shovel's shoe, tables, drawings and pages."""
    begin = time.process_time()
    shovel = assess("studies/shovel_assessment.toml", tmp_path / "shovel")
    excavator = assess(library.machines()["pc300lc"], tmp_path / "excavator")
    assert time.process_time() - begin < 20.0
    for found in (shovel, excavator):
        assert found.lines[0].startswith(f"governs: {found.governing[0].item}, ")
    assert shovel.governing[0].item == "shoe, static stress"


@pytest.mark.slow
def test_an_own_shoe_is_checked_by_the_mesh_of_its_case(tmp_path):
    """Ready shoe at three quarters of its size: the same forces make 16/9 of its stress."""
    size = 0.75
    mesh = mesh_named("coarse")
    path = tmp_path / "own.msh"
    write_mesh(path, Mesh(size * mesh.nodes, mesh.elements, mesh.surfaces))
    check = ShoeCheck(name="own", mesh="coarse", levels=())
    chain = Track.ph4100c()
    middle = chain.first_com[1]
    small = chain.with_(
        pitch=size * chain.pitch,
        pin_ahead=size * chain.pin_ahead,
        pin_height=size * chain.pin_height,
        spherical_y=middle + size * (chain.spherical_y - middle),
        parallel_y=middle + size * (chain.parallel_y - middle),
    )
    loads = assessment_of(Case.shovel(), BARE).loads
    ready, _ = shoe_stresses(loads, check, lambda _: None)
    own, _ = shoe_stresses(loads, check.with_(mesh=str(path), track=small), lambda _: None)
    even = [next(row for row in rows if row.check_case.startswith("ridge")) for rows in (ready, own)]
    assert even[1].check_case == "ridge 0.3 m"
    assert even[1].stress == pytest.approx(even[0].stress / size**2, rel=0.05)


@pytest.mark.slow
def test_a_payload_in_tonnes_is_asked_about():
    tonnes = BARE.with_({"work.payload": 90.7, "work.reach": 17.0})
    with pytest.warns(ImplausibleWarning, match=r"^work\.payload: 90\.7 kg is 6.*e-05 of .* is it in t\?"):
        assess(Case.shovel(), settings=tonnes)


@pytest.mark.slow
def test_a_twentieth_of_all_forces_makes_a_twentieth_of_all_stresses():
    """As on a small machine, whose shoe the pull of the papers' would tip."""
    check = ShoeCheck(name="light", mesh="coarse", levels=())
    loads = assessment_of(Case.shovel(), BARE).loads
    light = [row._replace(roller=0.05 * row.roller, needed=0.05 * row.needed) for row in loads]
    whole, part = (shoe_stresses(rows, check, lambda _: None)[0] for rows in (loads, light))
    assert {"turn", "stall"} <= {row.drive for row in loads}
    names = [(row.load_case, row.check_case) for row in whole]
    assert [(row.load_case, row.check_case) for row in part] == names
    assert [row.stress for row in part] == pytest.approx([0.05 * row.stress for row in whole], rel=1e-3)


def test_a_shoe_is_checked_by_its_mesh_or_not_at_all():
    case = Case.shovel()
    settings = AssessmentSettings()
    assert check_of(case, settings, ready_shoe=True).mesh == "coarse"
    assert check_of(case, settings, ready_shoe=False) is None
    own = case.with_(flexible=Case.stress("study").part(FlexibleShoes).with_(shoes=(3,)))
    check = check_of(own, settings, ready_shoe=False)
    assert (check.mesh, check.track) == ("study", case.gear.loop(case.track))
    assert check.roller_radius == case.gear.roller_radius
