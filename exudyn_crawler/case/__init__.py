"""What a run depends on, as frozen and validated data classes in SI units.

`Case` holds all of it; its parts can be made one by one, copied with changes (`with_`) and compared.
Values of the P&H 4100C and of the papers are named constructors beside the class they fill.
"""

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.contact import ContactLaw
from exudyn_crawler.case.drive import Drive
from exudyn_crawler.case.flexible import FlexibleShoes
from exudyn_crawler.case.loads import LoadCycle, Phase
from exudyn_crawler.case.profile import StepProfile
from exudyn_crawler.case.shoe import Shoe
from exudyn_crawler.case.solver import Solver
from exudyn_crawler.case.spheres import GeneralContact
from exudyn_crawler.case.terrain import Terrain
from exudyn_crawler.case.track import Track

__all__ = [
    "Case",
    "ContactLaw",
    "Drive",
    "FlexibleShoes",
    "GeneralContact",
    "LoadCycle",
    "Phase",
    "Shoe",
    "Solver",
    "StepProfile",
    "Terrain",
    "Track",
]
