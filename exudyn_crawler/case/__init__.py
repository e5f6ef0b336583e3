"""What a run depends on, as frozen and validated data classes in SI units.

`Case` holds all of it; its parts can be made one by one, copied with changes (`with_`) and compared. Numbers
of the P&H 4100C and of the papers, in `ph4100c`, fill the classes by their named constructors.
"""

from exudyn_crawler.case.case import Case as Case
from exudyn_crawler.case.case_file import CaseFile as CaseFile
from exudyn_crawler.case.case_file import Outputs as Outputs
from exudyn_crawler.case.files import read_case as read_case
from exudyn_crawler.case.files import write_case as write_case
from exudyn_crawler.case.parameters.cells import CellContact as CellContact
from exudyn_crawler.case.parameters.cells import CellTerrain as CellTerrain
from exudyn_crawler.case.parameters.contact import PairContact as PairContact
from exudyn_crawler.case.parameters.contact import SphereContact as SphereContact
from exudyn_crawler.case.parameters.drive import Drive as Drive
from exudyn_crawler.case.parameters.drive import Solver as Solver
from exudyn_crawler.case.parameters.drive import StepProfile as StepProfile
from exudyn_crawler.case.parameters.flexible import FlexibleShoes as FlexibleShoes
from exudyn_crawler.case.parameters.heights import Heights as Heights
from exudyn_crawler.case.parameters.loads import LoadCycle as LoadCycle
from exudyn_crawler.case.parameters.loads import Phase as Phase
from exudyn_crawler.case.parameters.terrain import Terrain as Terrain
from exudyn_crawler.case.parameters.track import Rails as Rails
from exudyn_crawler.case.parameters.track import Shoe as Shoe
from exudyn_crawler.case.parameters.track import Track as Track
from exudyn_crawler.case.parameters.undercarriage import MachineCycle as MachineCycle
from exudyn_crawler.case.parameters.undercarriage import MachinePhase as MachinePhase
from exudyn_crawler.case.parameters.undercarriage import Pose as Pose
from exudyn_crawler.case.parameters.undercarriage import Shovel as Shovel
from exudyn_crawler.case.parameters.undercarriage import Undercarriage as Undercarriage
