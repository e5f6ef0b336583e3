"""What a run depends on, as frozen and validated data classes in SI units.

`Case` holds all of it; its parts can be made one by one, copied with changes (`with_`) and compared.
Values of the P&H 4100C and of the papers are named constructors beside the class they fill.
"""

from exudyn_crawler.parameters.case import Case
from exudyn_crawler.parameters.contact import ContactLaw
from exudyn_crawler.parameters.drive import Drive
from exudyn_crawler.parameters.flexible import FlexibleShoes
from exudyn_crawler.parameters.general_contact import GeneralContact
from exudyn_crawler.parameters.loads import LoadCycle, Phase
from exudyn_crawler.parameters.profile import StepProfile
from exudyn_crawler.parameters.shoe import Shoe
from exudyn_crawler.parameters.solver import Solver
from exudyn_crawler.parameters.terrain import Terrain
from exudyn_crawler.parameters.track import Track

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
