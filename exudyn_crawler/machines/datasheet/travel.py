"""What a datasheet's machine does in a run: speed of its chains, drive, steps, and the ground about it."""

import math

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import terrain
from exudyn_crawler.case.parameters.drive import Drive, Solver, StepProfile
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet

RISE = 1.0  # s, in which the speed of a run rises
AHEAD = 30.0  # m of ground ahead of a machine and behind it
CELL, WIDEST_CELL = 0.25, 0.1  # of a pitch, and m: side of the ground's cells
STORED = 0.01  # s, between stored states, about
SOIL = "bekker", "lete_sand"
"""Law and name of the ground: sand of 14 MN/m3 as a machine of 150 kPa presses it in (Wong 2008)."""


def run_speed(sheet: Datasheet) -> float:
    """Speed of the chains in a run, m/s: asked for, or slow travel."""
    if sheet.speed is not None:
        return sheet.speed
    slow = sheet.typical_value("slow_travel")
    return slow if sheet.travel_speed is None else min(slow, sheet.travel_speed)


def drive_of(sheet: Datasheet) -> Drive:
    """Drive of what a run does; a machine with its sprocket in front travels along -x."""
    speed = run_speed(sheet)
    if sheet.travel == "on the spot":
        turning = StepProfile(times=(0.0, RISE), values=(0.0, 2.0 * speed / sheet.track_gauge))
        return Drive(speed=StepProfile.constant(0.0), turn_rate=turning)
    return Drive(speed=StepProfile(times=(0.0, RISE), values=(0.0, _sense(sheet) * speed)))


def _sense(sheet: Datasheet) -> float:
    """1 where a run travels along x, -1 where it goes the other way; on the spot by its sprocket."""
    backward = (sheet.travel == "backward") != (sheet.sprocket == "front")
    return -1.0 if backward else 1.0


def solver_of(pitch: float) -> Solver:
    """Steps of the project's P&H 4100C by the root of the pitch, as times of smaller machines are shorter."""
    step = 1e-4 * max(1, round(1e4 * Solver().step * math.sqrt(pitch / ph4100c.TRACK["pitch"])))
    return Solver(step=step, output_interval=step * max(1, round(STORED / step)))


def ground_of(sheet: Datasheet, chain: Chain) -> terrain.CellTerrain:
    """Ground about the machine, level or on its grade."""
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
    """Ground where a file says no other."""
    law, name = SOIL
    return terrain.CellContact(law=getattr(terrain.law_class(law), name)())
