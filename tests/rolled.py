"""Small cases of a side frame that rolls over a few shoes."""

from exudyn_crawler import Case, FlexibleShoes, LoadCycle, StepProfile
from exudyn_crawler.case import Rolled
from studies.grounds import pitching
from tests.small_shoe import SMALL_SHOE

ROLLERS = (-1.2, 0.0, 1.2)
SHOES = 10
SPEED = StepProfile(times=(0.0, 0.1), values=(0.0, 0.5))
"""m/s: five times the papers', so that rollers cross gaps in a short run."""


def small_case(**frame):
    """Three rollers under a part of the machine on ten rigid shoes and a few large units."""
    whole, case = Rolled.ph4100c(), Case.rolled()
    part = len(ROLLERS) / len(whole.rollers)
    inertia = tuple(part * one for one in (whole.inertia[0], 0.1 * whole.inertia[1], 0.1 * whole.inertia[2]))
    values = {
        "mass": part * whole.mass,
        "inertia": (*inertia, 0.0, 0.0, 0.0),
        "rollers": ROLLERS,
        "ends": (-2.0, 2.0),
        "tumbler": -1.8,
        "start": 12.6,
    }
    # units that pitch, as those of the whole case do
    terrain = pitching(case.with_(terrain=case.terrain.kinematics())).terrain.with_(columns=3, rows=3)
    return case.with_(
        name="small rolled",
        track=case.track.with_(shoe_count=SHOES),
        loads=LoadCycle.constant([0.0] * SHOES),
        terrain=terrain,
        drive=case.drive.with_(speed=SPEED),
        solver=case.solver.with_(step=2e-3, output_interval=2e-3),
        gear=whole.with_(**values | frame),
    )


def small_flexible_case(shoes=(5, 6)):
    """The same with two flexible shoes."""
    case = small_case()
    shoe = case.shoe.of_mass(4489.63)
    flexible = FlexibleShoes.ph4100c(SMALL_SHOE).with_(shoes=shoes, highest_frequency=1500.0)
    return case.with_(shoe=shoe, flexible=flexible)
