"""What a datasheet's machine does in a run: speed of its chains, drive, steps, and the ground about it."""

import math

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.datasheet.chain import Chain
from exudyn_crawler.case.datasheet.notes import Notes
from exudyn_crawler.case.datasheet.sheet import Datasheet
from exudyn_crawler.case.parameters import fields, terrain
from exudyn_crawler.case.parameters.drive import Drive, Solver, StepProfile

RISE = 1.0  # s, in which the speed of a run rises
AHEAD = 30.0  # m of ground ahead of a machine and behind it
CELL, WIDEST_CELL = 0.25, 0.1  # of a pitch, and m: side of the ground's cells
STORED = 0.01  # s, between stored states, about
SOIL = "bekker", "lete_sand"
"""Law and name of the ground: sand of 14 MN/m3 as a machine of 150 kPa presses it in (Wong 2008)."""
SOIL_WORDS = "LETE sand as Chrono has it (demo_VEH_SCMTerrain_RigidTire); the file may name another soil"


def run_speed(sheet: Datasheet, notes: Notes) -> float:
    """Speed of the chains in a run, m/s: asked for, or slow travel."""
    if sheet.speed is not None:
        return sheet.speed
    slow = notes.typical("slow_travel")
    return slow if sheet.travel_speed is None else min(slow, sheet.travel_speed)


def drive_of(sheet: Datasheet, notes: Notes) -> Drive:
    """Drive of what a run does; a machine with its sprocket in front travels along -x."""
    speed = run_speed(sheet, notes)
    on_the_spot = sheet.travel == "on the spot"
    reached = f"reached in {RISE:g} s"
    driven = "drive.turn_rate" if on_the_spot else "drive.speed"
    if sheet.speed is None:
        notes.note(driven, None, "", "assumed", f"slow_travel, no faster than travel_speed; {reached}")
    else:
        notes.note(driven, None, "", "derived", f"speed of the datasheet; {reached}")
    if on_the_spot:
        turning = StepProfile(times=(0.0, RISE), values=(0.0, 2.0 * speed / sheet.track_gauge))
        return Drive(speed=StepProfile.constant(0.0), turn_rate=turning)
    return Drive(speed=StepProfile(times=(0.0, RISE), values=(0.0, _sense(sheet) * speed)))


def _sense(sheet: Datasheet) -> float:
    """1 where a run travels along x, -1 where it goes the other way; on the spot by its sprocket."""
    backward = (sheet.travel == "backward") != (sheet.sprocket == "front")
    return -1.0 if backward else 1.0


def solver_of(pitch: float, notes: Notes) -> Solver:
    """Steps of the project's P&H 4100C by the root of the pitch, as times of smaller machines are shorter."""
    step = 1e-4 * max(1, round(1e4 * Solver().step * math.sqrt(pitch / ph4100c.TRACK["pitch"])))
    notes.note("solver.step", None, "", "assumed", "that of the project's P&H 4100C by the root of the pitch")
    return Solver(step=step, output_interval=step * max(1, round(STORED / step)))


def ground_of(sheet: Datasheet, chain: Chain, notes: Notes) -> terrain.CellTerrain:
    """Ground about the machine, level or on its grade."""
    length = chain.over_shoes
    wide = sheet.track_gauge + sheet.shoe_width
    around = max(length, wide)
    extent = f"{AHEAD:g} m ahead of the machine and behind it, its greater side beside it"
    for name in ("origin", "length", "width"):
        notes.note(f"terrain.{name}", None, "", "assumed", f"chosen: {extent}")
    cell = f"chosen: {CELL:g} pitches, {1e3 * WIDEST_CELL:g} mm at most"
    notes.note("terrain.cell", None, "", "assumed", cell)
    grade = 0.0
    if sheet.grade:
        grade = notes.note("terrain.grade", _sense(sheet) * sheet.grade, "", "given", "grade of the file")
    return terrain.CellTerrain(
        origin=(-AHEAD - length, -0.5 * wide - around),
        length=2.0 * (AHEAD + length),
        width=wide + 2.0 * around,
        cell=min(WIDEST_CELL, round(CELL * chain.pitch, 3)),
        grade=grade,
    )


def soil_of(notes: Notes) -> terrain.CellContact:
    """Ground where a file says no other."""
    law, name = SOIL
    contact = terrain.CellContact(law=getattr(terrain.law_class(law), name)())
    for entry in fields.values_of(contact.law):
        notes.note(f"contact.law.{entry.path}", None, "", "assumed", SOIL_WORDS)
    return contact
