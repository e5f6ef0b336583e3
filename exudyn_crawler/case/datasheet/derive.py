"""Case of a datasheet: a machine on two closed tracks of which every value has a note where it comes from."""

import re
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from typing import NamedTuple

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.case import Case
from exudyn_crawler.case.datasheet import chain as chains, gear, plausible, shoe_mesh, shoes, travel, vehicles
from exudyn_crawler.case.datasheet.notes import Note, Notes
from exudyn_crawler.case.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.case.datasheet.typical import TypicalValue
from exudyn_crawler.case.parameters import fields
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.errors import ParameterError

PLACES = {
    "gauge": "gear.car_body.track_distance",
    "shoe_width": "shoe.width",
    "shoes": chains.SHOES,
    "pitch": "track.pitch",
    "shoe_weight": "shoe.mass",
    "upper_weight": "gear.car_body.upper_mass",
    "sag": "gear.idler.sag",
    "chain_tension": "gear.idler.pretension",
    "recoil_force": "gear.idler.recoil.preload",
}
"""Where values of a datasheet stand in the case as they are."""
OF_MESH = ("shoe_width", "pitch", "shoe_weight")
NO_FIGURES = (
    "source",
    "remembered",
    "typical",
    "lift_chart",
    "kind",
    "sprocket",
    "travel",
    "grade",
    "suspension",
    "recoil_spring",
    "shoe_kind",
)


LONG_NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d{3,}(?:e[+-]?\d+)?(?!\w)")
SMALLER = 0.8, 0.6, 0.4, 0.2, 0.1
"""Shares of a sag with which no machine follows that are tried."""


class Derived(NamedTuple):
    """Case that follows from a datasheet, with notes."""

    case: Case
    notes: tuple[Note, ...]
    chain: chains.Chain
    typical: tuple[TypicalValue, ...]  # that it takes of the table


@lru_cache(maxsize=64)
def derived(sheet: Datasheet) -> Derived:
    """Case of a datasheet with the notes on its values; a ParameterError in the datasheet's words."""
    try:
        return _derived(sheet)
    except DatasheetError as error:
        raise DatasheetError("\n".join([*_odd(sheet), str(error)])) from error
    except ParameterError as error:
        raise DatasheetError("\n".join([*_odd(sheet), _refusal(sheet, error)])) from error


def _odd(sheet: Datasheet) -> Iterator[str]:
    """Yield the figures that no machine has, for which one may not follow."""
    yield from (f"{key}: {line}" for key, line in plausible.odd_printed(sheet))
    with suppress(ParameterError):
        chain = chains.chain_of(sheet, Notes(sheet.kind, _overrides(sheet)), ph4100c.GRAVITY)
        yield from plausible.odd_following(sheet, plausible.following(sheet, chain))


def _overrides(sheet: Datasheet) -> dict[str, float | None]:
    """Return the typical values of a datasheet by name, None for those of the table."""
    return {name: getattr(sheet.typical, name) for name in type(sheet.typical).model_fields}


def _derived(sheet: Datasheet) -> Derived:
    """Case of a datasheet; a ParameterError in words of the case where its parts do not go together."""
    notes = Notes(sheet.kind, _overrides(sheet))
    printed = sheet
    sheet = vehicles.with_running_gear(shoe_mesh.sheet_of_mesh(printed), notes)
    of_mesh = None if sheet.shoe_mesh is None else shoe_mesh.shoe_of_mesh(sheet.shoe_mesh)
    chain = chains.chain_of(sheet, notes, ph4100c.GRAVITY, None if of_mesh is None else of_mesh.depth)
    shoe = shoes.shoe_of(sheet, chain, notes, of_mesh)
    track = shoes.track_of(sheet, chain, shoe, notes, of_mesh)
    case = Case(
        name=sheet.kind,
        shoe=shoe,
        track=track,
        gear=gear.gear_of(sheet, chain, shoe, track, notes),
        terrain=travel.ground_of(sheet, chain, notes),
        contact=travel.soil_of(notes),
        drive=travel.drive_of(sheet, notes),
        loads=LoadCycle.constant([0.0] * track.shoe_count),
        solver=travel.solver_of(chain.pitch, notes),
    )
    given = list(_given(printed))
    paths = {note.path for note in given}
    return Derived(
        case, (*given, *(note for note in notes if note.path not in paths)), chain, tuple(notes.used.values())
    )


def _refusal(sheet: Datasheet, error: ParameterError) -> str:
    """Why no machine follows: its sag where a smaller one would do, else the first line of an error."""
    sag = sheet.sag or 0.0
    for smaller in (share * sag for share in SMALLER if sag > 0.0):
        try:
            _derived(sheet.with_(sag=smaller))
        except ParameterError:
            continue
        return (
            f"a sag of {1e3 * sag:.3g} mm lets the idler back into the wheel next to it; "
            f"{1e3 * smaller:.2g} mm do"
        )
    return f"the machine that follows cannot be built: {rounded(str(error).splitlines()[0])}"


def rounded(text: str) -> str:
    """Return a text whose numbers have four digits at most."""
    return LONG_NUMBER.sub(lambda found: f"{float(found[0]):.4g}", text)


def _given(sheet: Datasheet) -> Iterator[Note]:
    """Notes on the values that the datasheet has, but for those that it leaves as they are."""
    for name, field in type(sheet).model_fields.items():
        value = getattr(sheet, name)
        if value is None or value == field.default or name in NO_FIGURES:
            continue
        # values of the case are those of its mesh, which the datasheet's agree with
        of_mesh = sheet.shoe_mesh is not None and name in OF_MESH
        path = f"datasheet.{name}" if of_mesh else PLACES.get(name, f"datasheet.{name}")
        unit = fields.unit_of(field)
        if name in sheet.remembered:
            yield Note(path, value, unit, "assumed", "remembered: not seen in a source")
        else:
            yield Note(path, value, unit, "given", sheet.source)
