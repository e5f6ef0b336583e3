"""Figures of the derived machine beside those of its datasheet: weight, pressure, pull, speed, grade."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.machines.datasheet import rules
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.machines.datasheet.shoe_mesh import shoe_of_mesh

CLOSE, OF_LENGTH = 0.03, 0.05
"""Tolerances of agreement with the datasheet, relative: of weight and pressure, and of a length."""
MADE = "was built to it"
"""Verdict on a figure derived from the printed one."""
LOSS = 0.05
"""Total resistance of a slow excavator on firm ground, fraction of the weight (0.04 to 0.08, remembered)."""
ON_GROUND = ("datasheet.length_on_ground", "datasheet.pitch", "datasheet.shoes", "datasheet.sprocket_gaps")
"""Values that determine the lengths of a track."""


class Figure(NamedTuple):
    """Figure of the derived machine beside that of its datasheet, in SI units."""

    name: str
    value: float
    printed: float | None
    unit: str
    verdict: str

    @property
    def difference(self) -> float | None:
        """Relative difference; None without a printed figure."""
        return self.value / self.printed - 1.0 if self.printed else None


def machine_mass(case: Case) -> float:
    """Return the mass of all parts of a machine, kg: its shoes and their load."""
    return case.gear.whole_mass(case)


def lengths(case: Case, sheet: Datasheet) -> tuple[float, float]:
    """Return the length on ground, and over the shoes, of one assembled track, m."""
    gear = case.part(Closed)
    start = gear.assembled(case)
    rear, front, _, _, low = case.shoe.footprint
    if sheet.shoe_mesh is not None:
        low -= shoe_of_mesh(sheet.shoe_mesh).grouser
    place = start.shoes[:, 0]
    pitch = start.shoes[:, 4]
    ends = [place + x * np.cos(pitch) + low * np.sin(pitch) for x in (rear, 0.5 * (rear + front), front)]
    on_ground = gear.length + start.take_up
    if sheet.sprocket_to_idler is not None or sheet.has_road_wheels:
        on_ground = gear.rollers[-1] - gear.rollers[0]
    return on_ground, float(np.max(ends) - np.min(ends))


def contact_area(case: Case, sheet: Datasheet) -> float:
    """Return the contact area of both tracks of the assembled machine, as on datasheets, m2."""
    counts = rules.ground_length(*lengths(case, sheet), sheet.typical_value("pressure_share"))
    return 2.0 * case.shoe.width * counts


def mean_pressure(case: Case, sheet: Datasheet) -> float:
    """Return the mean ground pressure of the assembled machine, as on datasheets, Pa."""
    return machine_mass(case) * case.gravity / contact_area(case, sheet)


def figures(case: Case, sheet: Datasheet) -> list[Figure]:
    """Return all figures that the datasheet allows to check."""
    return [*_built(case, sheet), *_travelling(case, sheet)]


def _compared(
    name: str, value: float, printed: float | None, unit: str, most: float, made: bool = False
) -> Figure:
    """Return a figure beside the printed one; it does not agree if the printed one `made` it."""
    verdict = "follows"
    if printed:
        off = value / printed - 1.0
        verdict = f"differs by {100.0 * off:+.1f} %" if abs(off) > most else MADE if made else "agrees"
    return Figure(name, value, printed, unit, verdict)


def _built(case: Case, sheet: Datasheet) -> Iterator[Figure]:
    """Yield weight, lengths and pressure."""
    figures_of = derived(sheet).ruled.figures_of
    of_lengths = figures_of(*ON_GROUND)
    mass = machine_mass(case)
    made = "operating_weight" in figures_of("gear.mass")
    yield _compared("weight of all parts", mass, sheet.operating_weight, "kg", CLOSE, made)
    if sheet.shoe_weight is not None:
        made = "shoe_weight" in figures_of("shoe.mass")
        yield _compared("weight of a shoe", case.shoe.mass, sheet.shoe_weight, "kg", CLOSE, made)
    on_ground, over_shoes = lengths(case, sheet)
    made = "length_on_ground" in of_lengths
    yield _compared("length on ground", on_ground, sheet.length_on_ground, "m", OF_LENGTH, made)
    made = "crawler_length" in of_lengths
    yield _compared("length over shoes", over_shoes, sheet.crawler_length, "m", OF_LENGTH, made)
    if sheet.contact_area is not None:
        area = contact_area(case, sheet)
        made = "contact_area" in of_lengths
        yield _compared("contact area", area, sheet.contact_area, "m2", CLOSE, made)
    stated = sheet.ground_pressure
    made = "ground_pressure" in of_lengths
    pressure = _compared("mean ground pressure", mean_pressure(case, sheet), stated, "Pa", CLOSE, made)
    if stated and abs(pressure.value / stated - 1.0) > CLOSE:
        counts = mass * case.gravity / (2.0 * case.shoe.width * stated)
        where = f"the printed one has the weight on {counts:.3g} m of each track"
        pressure = pressure._replace(verdict=f"{pressure.verdict}: {where}")
    yield pressure


def _travelling(case: Case, sheet: Datasheet) -> Iterator[Figure]:
    """Yield sprocket speed, power, pull and grade."""
    gear = case.part(Closed)
    radius = gear.travel_per_angle(case.track)
    weight = machine_mass(case) * case.gravity
    speed = sheet.travel_speed
    pull = sheet.drawbar_pull
    if speed is not None:
        turns = speed / radius
        rpm = 60.0 * turns / (2.0 * math.pi)
        yield Figure(
            "speed of the sprockets", turns, None, "rad/s", f"{rpm:.3g} rpm at {3.6 * speed:.3g} km/h"
        )
    yield from _of_motors(sheet, radius)
    if pull is not None:
        need = f"takes a coefficient of traction of {pull / weight:.2f}"
        yield Figure("drawbar pull over weight", pull / weight, None, "1", need)
        torque = rules.sprocket_torque(pull, radius, sheet.typical_value("chain_efficiency"))
        yield Figure("torque of a sprocket", torque, None, "N m", "at the drawbar pull")
    if pull is not None and speed is not None:
        words = "at once they take this power: "
        power = pull * speed
        if sheet.power is None:
            words += "its gears have less pull where they have more speed"
        else:
            share = power / sheet.power
            words += (
                "the drives have it"
                if share <= 1.0
                else f"{share:.2g} times what the drives have, so never at once"
            )
        yield Figure("pull times speed", power, None, "W", words)
    if sheet.gradeability is not None:
        yield from _grade(sheet.gradeability, pull, weight)


def _of_motors(sheet: Datasheet, radius: float) -> Iterator[Figure]:
    """Yield travel speed and pull of the travel motors, from their gears and the pins' radius (m)."""
    ratio = sheet.gear_ratio
    if ratio is None:
        return
    printed = sheet.travel_speed
    if sheet.motor_speed is not None:
        speed = sheet.motor_speed / ratio * radius
        yield _compared("speed by the motors", speed, printed, "m/s", OF_LENGTH)
    printed = sheet.drawbar_pull
    if sheet.motor_torque is not None:
        pull = 2.0 * sheet.motor_torque * ratio * sheet.typical_value("chain_efficiency") / radius
        yield _compared("drawbar pull by the motors", pull, printed, "N", OF_LENGTH)


def _grade(slope: float, pull: float | None, weight: float) -> Iterator[Figure]:
    """Yield the pull needed on a grade, and the friction."""
    steep = math.hypot(1.0, slope)
    needed = weight * (slope + LOSS) / steep
    verdict = f"and a coefficient of traction of {slope + LOSS:.2f}"
    if pull is not None:
        verdict = f"the drawbar pull has {pull / needed:.2g} times as much; {verdict}"
    yield Figure(f"pull up a grade of {100.0 * slope:.0f} %", needed, None, "N", verdict)
