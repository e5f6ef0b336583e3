"""Run of a datasheet's machine: speed of its chains, drive, steps, and the ground around it."""

import math

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import terrain
from exudyn_crawler.case.parameters.drive import Drive, Solver, StepProfile
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet

RISE = 1.0  # rise time of the speed, s
AHEAD = 30.0  # length of ground ahead of a machine and behind it, m
CELL, WIDEST_CELL = 0.25, 0.1  # side of the ground's cells: fraction of the pitch, and upper limit, m
STORED = 0.01  # longest interval of stored states, s
STATES = 20  # least number of stored states in a pitch of travel, so that none misses the peaks of links
SOIL = "bekker", "lete_sand"
"""Law and name of the ground: sand with 14 MN/m3 under the pressure of a machine of 150 kPa (Wong 2008)."""


def run_speed(sheet: Datasheet) -> float:
    """Return the speed of the chains in a run, m/s: the given one, or slow travel."""
    if sheet.speed is not None:
        return sheet.speed
    slow = sheet.typical_value("slow_travel")
    return slow if sheet.travel_speed is None else min(slow, sheet.travel_speed)


def drive_of(sheet: Datasheet) -> Drive:
    """Return the drive of a run; a machine with its sprocket in front travels along -x."""
    speed = run_speed(sheet)
    if sheet.travel == "on the spot":
        turning = StepProfile(times=(0.0, RISE), values=(0.0, 2.0 * speed / sheet.track_gauge))
        return Drive(speed=StepProfile.constant(0.0), turn_rate=turning)
    return Drive(speed=StepProfile(times=(0.0, RISE), values=(0.0, _sense(sheet) * speed)))


def _sense(sheet: Datasheet) -> float:
    """Return 1 if a run travels along x, -1 if it travels along -x; on the spot its sprocket decides."""
    backward = (sheet.travel == "backward") != (sheet.sprocket == "front")
    return -1.0 if backward else 1.0


def solver_of(pitch: float, speed: float) -> Solver:
    """Return the solver with the P&H 4100C's steps scaled by the root of the pitch.

    States are stored every 10 ms, or `STATES` times in a pitch of the chain at a `speed` (m/s).
    """
    step = 1e-4 * max(1, round(1e4 * Solver().step * math.sqrt(pitch / ph4100c.TRACK["pitch"])))
    stored = min(STORED, pitch / (STATES * speed))
    return Solver(step=step, output_interval=step * max(1, round(stored / step)))


def ground_of(sheet: Datasheet, chain: Chain) -> terrain.CellTerrain:
    """Return the ground around the machine, level or on its grade."""
    length = chain.over_shoes
    wide = sheet.track_gauge + sheet.shoe_width
    around = max(length, wide)
    return terrain.CellTerrain(
        origin=(-AHEAD - length, -0.5 * wide - around),
        length=2.0 * (AHEAD + length),
        width=wide + 2.0 * around,
        cell=min(WIDEST_CELL, round(CELL * chain.pitch, 3)),
        grade=_sense(sheet) * sheet.grade if sheet.grade else 0.0,
    )


def soil_of() -> terrain.CellContact:
    """Return the ground contact of a file that states none."""
    law, name = SOIL
    return terrain.CellContact(law=getattr(terrain.law_class(law), name)())
