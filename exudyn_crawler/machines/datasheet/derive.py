"""Case derived from a datasheet: a machine on two closed tracks, with the rule of every derived value."""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.case import Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines.datasheet import (
    chain as chains,
    gear,
    library,
    plausible,
    shoe_mesh,
    shoes,
    travel,
    vehicles,
)
from exudyn_crawler.machines.datasheet.ruled_machine import RuledMachine
from exudyn_crawler.machines.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.origins import Ledger, Ruled

LONG_NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d{3,}(?:e[+-]?\d+)?(?!\w)")


@dataclass(frozen=True)
class Derived:
    """Case derived from a datasheet, with its chain and the rules of its values."""

    case: Case
    chain: chains.Chain
    ruled: RuledMachine

    @property
    def ledger(self) -> Ledger:
        """Ledger of figures, of the case's derived values, and of typical values."""
        return self.ruled.ledger


@lru_cache(maxsize=64)
def derived(sheet: Datasheet) -> Derived:
    """Return the case of a datasheet; raise `ParameterError` in the datasheet's terms."""
    try:
        return _derived(sheet)
    except ParameterError as error:
        why = str(error) if isinstance(error, DatasheetError) else _refusal(sheet, error)
        raise DatasheetError("\n".join([*_odd(sheet), why, *library.left_of_library(sheet)])) from error


def _odd(sheet: Datasheet) -> Iterator[str]:
    """Yield the implausible figures, which may be the reason that no machine follows."""
    yield from (f"{key}: {line}" for key, line in plausible.implausible_printed(sheet))
    with suppress(ParameterError):
        chain = chains.chain_of(sheet, ph4100c.GRAVITY)
        yield from plausible.implausible_derived(sheet, plausible.following(sheet, chain))


def _derived(printed: Datasheet) -> Derived:
    """Return the case of a datasheet; raise `ParameterError` in the terms of the case if parts do not fit."""
    sheet, of_vehicle = vehicles.with_running_gear(shoe_mesh.sheet_of_mesh(printed))
    of_mesh = None if sheet.shoe_mesh is None else shoe_mesh.shoe_of_mesh(sheet.shoe_mesh)
    chain = chains.chain_of(sheet, ph4100c.GRAVITY, None if of_mesh is None else of_mesh.depth)
    shoe = shoes.shoe_of(sheet, chain, of_mesh)
    track = shoes.track_of(sheet, chain, shoe, of_mesh)
    machine, of_gear = gear.gear_of(sheet, chain, shoe, track)
    case = Case(
        name=sheet.kind,
        shoe=shoe,
        track=track,
        gear=machine,
        terrain=travel.ground_of(sheet, chain),
        contact=travel.soil_of(),
        drive=travel.drive_of(sheet),
        loads=LoadCycle.constant([0.0] * track.shoe_count),
        solver=travel.solver_of(chain.pitch, travel.run_speed(sheet)),
    )
    ruled = {f"datasheet.{name}": Ruled(value, "") for name, value in _followed(sheet, case).items()}
    if sheet.travel == "on the spot":
        ruled["drive.speed"] = Ruled(0.0, sheet.travel)
    ruled |= chain.ruled | of_gear | of_vehicle
    return Derived(case, chain, RuledMachine(printed, sheet, case, ruled))


def _followed(sheet: Datasheet, case: Case) -> dict[str, float]:
    """Return figures of the case, printed or not, by their names."""
    machine = case.part(Closed)
    recoil = machine.idler.recoil
    return {
        "gauge": sheet.track_gauge,
        "shoe_weight": case.shoe.mass,
        "shoes": case.track.shoe_count // case.gear.tracks,
        "lower_rollers": len(machine.rollers),
        "carrier_rollers": len(machine.carriers),
    } | ({} if recoil is None else {"recoil_force": recoil.preload})


def _refusal(sheet: Datasheet, error: ParameterError) -> str:
    """Return the reason that no machine follows: its sag if the usual one works, else the error's line 1."""
    if sheet.sag:
        with suppress(ParameterError):
            usual = _derived(sheet.with_(sag=None)).case.part(Closed).wanted_sag
            back = f"a sag of {1e3 * sheet.sag:.3g} mm lets the idler back into the wheel next to it"
            return f"{back}; {1e3 * usual:.2g} mm do"
    return f"the machine that follows cannot be built: {rounded(str(error).splitlines()[0])}"


def rounded(text: str) -> str:
    """Return a text with at most four digits in its numbers."""
    return LONG_NUMBER.sub(lambda found: f"{float(found[0]):.4g}", text)
