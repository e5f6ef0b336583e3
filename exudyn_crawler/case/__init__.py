"""Parameters that a run depends on: frozen, validated data classes in SI units.

`Case` holds all of it; its parts can be made one by one, copied with changes (`with_`) and compared. Numbers
of the P&H 4100C and of the papers, in `ph4100c`, fill the classes by their named constructors.
"""

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.dragged import Dragged
from exudyn_crawler.case.gear.machine import Machine
from exudyn_crawler.case.gear.rolled import Rolled, ground_below
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.case.parameters.car_body import CarBody, Part
from exudyn_crawler.case.parameters.closed_track import Idler, Tensioner, Tumbler
from exudyn_crawler.case.parameters.contact import PairContact, SphereContact
from exudyn_crawler.case.parameters.drive import Drive, Solver, StepProfile
from exudyn_crawler.case.parameters.heights import Heights, Ramp, Ridge, Roughness, Stone, Waves
from exudyn_crawler.case.parameters.loads import LoadCycle, Phase
from exudyn_crawler.case.parameters.machine_cycle import MachineCycle, MachinePhase
from exudyn_crawler.case.parameters.terrain import CellContact, CellTerrain, Terrain
from exudyn_crawler.case.parameters.track import SIDES, FlexibleShoes, Rails, Shoe, Track
