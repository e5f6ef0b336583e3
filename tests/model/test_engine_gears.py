"""Gears of Exudyn's own bodies, joints and springs move as the compiled equations say."""

import numpy as np
import pytest

from exudyn_crawler import Case, FlexibleShoes, StepProfile
from exudyn_crawler.case.parameters.closed_track import Play, Tensioner
from exudyn_crawler.engine.formulation import track_system
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.run.solve.simulation import integrate, solved_for_tension
from exudyn_crawler.run.solve.start import begin
from tests.model.test_arms import arms_of
from tests.model.test_bogie import BOGIE
from tests.rolled import SPEED, small_case, small_flexible_case
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

SPRING = Tensioner(mass=8e3, stiffness=2e8, preload=3e7)
TURN = StepProfile(times=(0.0, 0.1), values=(0.0, 0.1))
"""rad/s."""


def driven(case, **drive):
    """The case with a drive that starts fast, and a residual that leaves no difference."""
    return case.with_({"solver.residual": 1e-3, "drive": case.drive.with_(speed=SPEED, **drive)})


def closed_flexible():
    """Closed track with two flexible shoes."""
    case = Case.closed()
    flexible = FlexibleShoes.ph4100c(SMALL_SHOE).with_(shoes=(5, 6), highest_frequency=1500.0)
    return case.with_(shoe=case.shoe.of_mass(4489.63), flexible=flexible)


CASES = {
    "rolled": (small_case, 0.06),
    "bogie": (lambda: small_case(bogies=(BOGIE,)), 0.04),
    "arms": (lambda: small_case(arms=arms_of()), 0.04),
    "closed": (lambda: driven(Case.closed()), 0.02),
    "closed on posts": (lambda: driven(Case.closed().with_({"gear.support": "posts"})), 0.01),
    "closed with a drawbar": (lambda: driven(Case.closed(), slip=StepProfile.constant(0.2)), 0.01),
    "closed, limited torque": (lambda: driven(Case.closed().with_({"gear.torque_limit": 2e5})), 0.02),
    "rolled on sand": (lambda: small_case().on_cells(BekkerSoil.lete_sand()), 0.04),
    "rolled, flexible": (lambda: driven(small_flexible_case()), 0.01),
    "closed, flexible": (lambda: driven(closed_flexible()), 0.006),
    "machine that turns": (lambda: driven(Case.shovel(), turn_rate=TURN), 0.01),
}


def both(case, duration):
    """Histories of both formulations from one start."""
    case = solved_for_tension(case.with_({"solver.residual": 1e-3}), False)
    compiled, engine = (track_system(case.with_(formulation=one)) for one in ("compiled", "engine"))
    start = begin(compiled)
    engine.remember(compiled.memory())
    engine.set_initial(*start)
    return [integrate(system, duration, False) for system in (compiled, engine)]


LONG = "closed, limited torque"
"""Case whose drive is steep at first, so that its steps take many iterations."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name == LONG else name for name in CASES]
)
def test_a_short_run_is_the_same_in_both_formulations(name):
    make, duration = CASES[name]
    own, engine = (run.dataset for run in both(make(), duration))
    allowed = 1e-5
    if "modal_coordinate" in own:
        # Exudyn's joints turn differently with the lugs of bent shoes, which jerk as they leave their rest
        allowed = 1e-4
        own, engine = (run.isel(time=slice(1, None)) for run in (own, engine))
        most = allowed * float(np.abs(own["modal_coordinate"]).max())
        np.testing.assert_allclose(engine["modal_coordinate"], own["modal_coordinate"], rtol=0.0, atol=most)
    near = 1e-7
    if name == LONG:
        # a brake holds the track before the first step without a lag, and steps approach its law differently
        near, allowed = 1e-6, 1e-4
    angles = [variable for variable in own if variable.endswith(("angle", "angles"))]
    for variable in ("position", "side_frame_position", *angles):
        np.testing.assert_allclose(engine[variable], own[variable], rtol=0.0, atol=near, err_msg=variable)
    if name == LONG:
        own, engine = (run.isel(time=[-1]) for run in (own, engine))
    forces = ("joint_force", "normal_force", "friction_force", "wheel_force", "roller_force", "tooth_force")
    assert float(np.abs(own["joint_force"]).max()) > 1e5
    for variable in (*forces, "drive_pull", "drive_moment", "drawbar_pull"):
        if variable in own and own[variable].size:
            # friction is small at the start, and as exact as the forces that press the shoes down
            scale = own["normal_force" if variable == "friction_force" else variable]
            most = allowed * float(np.abs(scale).max())
            np.testing.assert_allclose(engine[variable], own[variable], rtol=0.0, atol=most, err_msg=variable)


def test_bodies_pins_and_springs_are_exudyns():
    case = Case.closed()
    mbs = ExudynSystem(case.with_(formulation="engine")).mbs
    kinds = [mbs.GetObject(number)["objectType"] for number in range(mbs.systemData.NumberOfObjects())]
    shoes = case.track.shoe_count
    # beside the shoes a side frame and a tumbler; a bearing, and a hold of the frame's yaw
    assert kinds.count("RigidBody") == shoes + 2
    assert kinds.count("JointGeneric") == shoes + 2
    assert kinds.count("ConnectorRigidBodySpringDamper") == shoes


@pytest.mark.parametrize(
    ("case", "changes", "message"),
    [
        (Case.rolled(), {"terrain_formulation": "constrained"}, "do not go with gear.kind 'rolled'"),
        (
            Case.closed(),
            {"gear.idler.tensioner": SPRING},
            "gear.idler.tensioner and gear.idler.recoil must be",
        ),
        (
            Case.closed(),
            {"gear.play": Play(radial=1e-3, axial=1e-3, stiffness=1e9, damping=1e5)},
            "gear.play must be none with formulation",
        ),
    ],
)
def test_parts_without_exudyns_items_are_refused(case, changes, message):
    with pytest.raises(ParameterError, match=message):
        case.with_({"formulation": "engine"} | changes)
