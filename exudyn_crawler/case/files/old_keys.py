"""Keys that cases had before this release; they are read with a warning and go with the next one."""

import warnings
from collections.abc import Iterator
from typing import Any

from exudyn_crawler.case.parameters.kinds import BASE

MODEL, SPHERES = "contact_model", "general_contact"


def migrated(values: dict[str, Any], where: object) -> dict[str, Any]:
    """Content of a case file or a dumped case with today's keys in place of old ones.

    Where old and new keys contradict each other the old ones stay, to be refused as unknown.

    Warns
    -----
    FutureWarning
        Once, with what to write now and `where` the old keys are.
    """
    values = dict(values)
    advice = [*_contact(values), *_drive(values)]
    if advice:
        told = f"{where}: old keys are read for this release only; write {', '.join(advice)}"
        warnings.warn(told, FutureWarning, stacklevel=3)
    return values


def _contact(values: dict[str, Any]) -> Iterator[str]:
    """Put `contact_model` and `general_contact` into `contact`; gives what to write now."""
    contact, spheres = values.get("contact", {}), values.get(SPHERES, {})
    model = values.get(MODEL, "pair")
    if not isinstance(contact, dict) or not isinstance(spheres, dict) or "model" in contact:
        return
    based = BASE in values or BASE in contact
    if not (values.keys() & {MODEL, SPHERES}):
        if contact and not based:
            values["contact"] = {"model": "pair", **contact}
            yield "model = 'pair' in contact"
        return
    if model == "pair":
        values["contact"] = {"model": "pair", **contact}
    elif model == "general":
        # a whole set of spheres was the default, and a base gave what a file left out
        base = {BASE: "oil_sand"} if based or SPHERES not in values else {}
        law = {f"reference_{name}": contact[name] for name in ("stiffness", "exponent") if name in contact}
        values["contact"] = {"model": "spheres", **base, **law, **spheres}
    else:
        return
    for name in (MODEL, SPHERES):
        values.pop(name, None)
    yield f"model = {values['contact']['model']!r} in contact in place of {MODEL} and {SPHERES}"


def _drive(values: dict[str, Any]) -> Iterator[str]:
    """Put `loads.drive_on` into `drive`; gives what to write now."""
    loads, drive = values.get("loads"), values.get("drive", {})
    if not isinstance(loads, dict) or not isinstance(drive, dict) or "drive_on" not in loads or "on" in drive:
        return
    values["loads"] = {name: value for name, value in loads.items() if name != "drive_on"}
    values["drive"] = {**drive, "on": loads["drive_on"]}
    yield "drive.on in place of loads.drive_on"
