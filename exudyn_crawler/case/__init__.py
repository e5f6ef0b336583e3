"""What a run depends on, as frozen and validated data classes in SI units.

`Case` holds all of it; its parts can be made one by one, copied with changes (`with_`) and compared.
Values of the P&H 4100C and of the papers are named constructors of the class they fill; the numbers stand in
`ph4100c`.
"""

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile, Outputs
from exudyn_crawler.case.files.files import read_case, write_case
from exudyn_crawler.case.parameters.base import StepProfile
from exudyn_crawler.case.parameters.contact import PairContact, SphereContact
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.flexible import FlexibleShoes
from exudyn_crawler.case.parameters.loads import LoadCycle, Phase
from exudyn_crawler.case.parameters.solver import Solver
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case.parameters.track import Rails, Shoe, Track
from exudyn_crawler.case.parameters.undercarriage import (
    MachineCycle,
    MachinePhase,
    Pose,
    Shovel,
    Undercarriage,
)

__all__ = [
    "Case",
    "CaseFile",
    "Drive",
    "FlexibleShoes",
    "LoadCycle",
    "MachineCycle",
    "MachinePhase",
    "Outputs",
    "PairContact",
    "Phase",
    "Pose",
    "Rails",
    "Shoe",
    "Shovel",
    "Solver",
    "SphereContact",
    "StepProfile",
    "Terrain",
    "Track",
    "Undercarriage",
    "read_case",
    "write_case",
]
