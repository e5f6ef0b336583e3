"""Cases of the studies to start from, registered in `pyproject.toml`; this does not load the runs."""

from exudyn_crawler import Case, CaseFile, Drive, FlexibleShoes, StepProfile
from exudyn_crawler.case import ph4100c
from exudyn_crawler.machines import Outputs
from studies import CYCLE_DURATION, DURATION
from studies.grounds import uneven_case


def kinematics() -> CaseFile:
    """Return the case of straight propel."""
    return CaseFile(case=Case.translation(), duration=DURATION)


def forces() -> CaseFile:
    """Return the case of propel with a turn."""
    return CaseFile(case=Case.turning(), duration=DURATION)


def stress() -> CaseFile:
    """Return the case of a whole cycle with six flexible shoes."""
    return CaseFile(case=Case.stress(), duration=CYCLE_DURATION)


def rollers() -> CaseFile:
    """Return the case of a machine that rolls over rigid shoes."""
    return CaseFile(case=Case.rolled(), duration=DURATION)


def uneven() -> CaseFile:
    """Return the case of straight propel over random roughness."""
    return CaseFile(case=uneven_case("rough"), duration=DURATION)


def closed() -> CaseFile:
    """Return the case of half a machine on a closed track, from its start to a speed of 0.3 m/s."""
    return CaseFile(case=Case.closed(), duration=DURATION)


def shovel() -> CaseFile:
    """Return the case of a machine on two closed tracks."""
    return CaseFile(case=Case.shovel(), duration=DURATION)


def grounds() -> CaseFile:
    """Return the case of a machine that rolls over rigid shoes on ground of cells: LETE sand."""
    # imported here, since its laws load the compiler and no other case needs it
    from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil

    return CaseFile(case=Case.rolled().on_cells(BekkerSoil.lete_sand()), duration=DURATION)


def demo() -> CaseFile:
    """Return the case of half a machine up to 1 km/h on a closed track, one shoe flexible, coarse mesh."""
    case = Case.closed()
    case = case.with_(
        name="demo",
        shoe=case.shoe.of_mass(ph4100c.STRESS_SHOE_MASS),
        flexible=FlexibleShoes.ph4100c("coarse").with_(shoes=(7,)),
        drive=Drive(speed=StepProfile(times=(0.0, 1.5), values=(0.0, 0.3))),
        solver=case.solver.with_(output_interval=0.02),
    )
    # the page shows all of these
    outputs = Outputs(figures=False, pictures=False, paraview=False, tables=False, forces=False)
    return CaseFile(case=case, duration=3.5, outputs=outputs)
