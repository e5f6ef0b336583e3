"""Discrepancies of a datasheet: implausible figures, alone or compared with each other."""

from collections.abc import Collection, Iterator

from exudyn_crawler.case.gear.machine import Machine
from exudyn_crawler.case.parameters.checks import implausible, out_of_range
from exudyn_crawler.case.ph4100c import GRAVITY
from exudyn_crawler.machines.case_file import CaseFile
from exudyn_crawler.machines.datasheet import plausible, rules
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.figures import machine_mass
from exudyn_crawler.machines.datasheet.ledger import ledger_of
from exudyn_crawler.machines.datasheet.library import left_of_library
from exudyn_crawler.machines.datasheet.ruled_machine import case_paths
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.origins import Origin
from exudyn_crawler.settings import fields

PRESSURE = (0.4, 3.0)
"""Range of the printed ground pressure over weight by width and length on ground of both tracks (assumed)."""
AREA = 1.0 / 3.0, 2.5
"""Range of the printed contact area over width by length on ground of both tracks, from that of the
pressure."""


def implausible_values(case_file: CaseFile) -> Iterator[str]:
    """Yield lines on all implausible values of a case file, those of the datasheet first."""
    lines = implausible(case_file.case, case_file.duration)
    yield from machine_discrepancies(case_file)
    if case_file.datasheet is None:
        yield from lines
        return
    # a derived value has no wrong unit: shoes of a small machine may weigh less than the range allows
    by_rule = {entry.path for entry in ledger_of(case_file) if entry.origin is not Origin.GIVEN}
    yield from (line for line in lines if line.split(":")[0] not in by_rule)


def machine_discrepancies(case_file: CaseFile) -> Iterator[str]:
    """Yield lines on implausible figures of a machine, from its datasheet and from its case."""
    case = case_file.case
    sheet = case_file.datasheet
    if sheet is not None:
        yield from datasheet_discrepancies(sheet)
    if not isinstance(case.gear, Machine):
        return
    kind = None if sheet is None else sheet.kind
    machine = None if sheet is None else derived(sheet).case
    follows = {} if machine is None else {entry.path: entry.value for entry in fields.values_of(machine)}
    own = {entry.path: entry for entry in fields.values_of(case) if follows.get(entry.path) != entry.value}
    sizes = plausible.Sizes(machine_mass(case), case.track.pitch, case.gear.length)
    rows = [
        (path, "", name, own[path].value, own[path].unit)
        for name, path in case_paths().items()
        if path in own
    ]
    if "track.shoe_count" in own:
        rows.append(("track.shoe_count", "of one track, ", "shoes", case.track.shoe_count // 2, ""))
    speed = max(map(abs, case.drive.speed.values))
    if "drive.speed" in own and speed:
        rows.append(("drive.speed", "", "speed", speed, "m/s"))
    if "gear.torque_limit" in own and case.gear.torque_limit is not None:
        pull = 2.0 * case.gear.torque_limit / case.gear.travel_per_angle(case.track)
        words = "the pull of both tracks with it, "
        rows.append(("gear.torque_limit", words, "drawbar_pull", pull, "N"))
    for path, words, name, value, unit in rows:
        if line := plausible.implausible_number(name, value, unit, kind, sizes):
            yield f"{path}: {words}{line}"


def datasheet_discrepancies(sheet: Datasheet) -> Iterator[str]:
    """Yield lines on implausible figures, printed or derived, with the datasheet's keys."""
    yield from (f"datasheet: {line}" for line in left_of_library(sheet))
    machine = derived(sheet)
    following = plausible.following(sheet, machine.chain, machine.case.shoe.mass)
    odd = dict(plausible.implausible_printed(sheet, following))
    yield from (f"datasheet.{key}: {line}" for key, line in odd.items())
    for line in out_of_range(sheet):
        key = line.split(":")[0]
        if plausible.row_of(key, sheet.kind) is None:
            yield f"datasheet.{line}"
    yield from (f"datasheet: {line}" for line in plausible.implausible_derived(sheet, following))
    yield from _odd_sums(sheet, odd)


def _odd_sums(sheet: Datasheet, odd: Collection[str]) -> Iterator[str]:
    """Yield lines on an area or a pressure that contradicts weight, width and length."""
    length = sheet.length_on_ground or sheet.crawler_length
    if length is None or plausible.WEIGHT in odd:
        return
    area = 2.0 * sheet.shoe_width * length
    if sheet.contact_area is not None:
        least, greatest = AREA
        if not least <= sheet.contact_area / area <= greatest:
            printed = f"{sheet.contact_area:.4g} m2"
            by_length = f"width by length is {area:.4g} m2"
            yield f"datasheet.contact_area: {printed} is not the area of both tracks, {by_length}"
    if sheet.ground_pressure is None or "ground_pressure" in odd:
        return
    mean = rules.ground_pressure(sheet.operating_weight, sheet.shoe_width, length, GRAVITY)
    least, greatest = PRESSURE
    if not least <= sheet.ground_pressure / mean <= greatest:
        printed = f"{1e-3 * sheet.ground_pressure:.4g} kPa"
        by_area = f"weight over both tracks is {1e-3 * mean:.4g} kPa"
        yield f"datasheet.ground_pressure: {printed} is not the mean pressure, {by_area}"
