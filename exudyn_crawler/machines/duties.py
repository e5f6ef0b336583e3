"""Ground and duty of a machine by name: soils, slopes, obstacles, travel and work."""

from collections.abc import Callable
from functools import partial
from typing import Any

from exudyn_crawler.case.gear.machine import Machine
from exudyn_crawler.case.parameters.machine_cycle import MachineCycle
from exudyn_crawler.case.parameters.terrain import CellContact
from exudyn_crawler.machines.case_file import CaseFile
from exudyn_crawler.machines.datasheet.files import KEY
from exudyn_crawler.machines.edited_text import table_of
from exudyn_crawler.settings.constraints import presets

Values = dict[str, Any]
"""Values of a case file by their paths, to be changed together; None removes a key."""
SOIL = "soil"
SLOPE = "slope"
OBSTACLE = "obstacle on the way"
DUTY = "travel or work"
AHEAD = 1.0
"""Distance of a new obstacle ahead of the foremost shoe, m."""
OBSTACLES: dict[str, Values] = {
    "stone": {"model": "stone", "height": 0.1, "width": 0.1, "flank": 0.3, "y": 0.0},
    "ridge": {"model": "ridge", "height": 0.1, "width": 0.2, "flank": 0.3},
    "rut": {"model": "ridge", "height": -0.1, "width": 0.3, "flank": 0.3},
    "ramp": {"model": "ramp", "height": 0.2, "flank": 1.0},
    "waves": {"model": "waves", "height": 0.05, "length": 2.0},
}
"""Obstacles on the ground with initial sizes, m."""
SLOPES = {
    "level": (None, None),
    "up, 20 %": (0.2, None),
    "down, 20 %": (-0.2, None),
    "across, 15 %": (None, 0.15),
}
"""Grade and side slope by name."""
TRAVELS = {"propel": "straight", "propel backward": "backward", "turn on the spot": "on the spot"}
TRAVELLED = 5.0
"""Duration of a travel run, s."""
DIG = "dig, swing and dump"
STANDS = {"times": [0.0], "values": [0.0]}


def lists() -> dict[str, dict[str, Callable[[CaseFile], Values]]]:
    """Return functions from a case file to the values of each list and name.

    Travel and work apply to machines from datasheets.
    """
    laws = presets(CellContact.model_fields["law"])
    travels: Values = {"drive": None, "machine": None, "duration": TRAVELLED}
    return {
        SOIL: {name: _always({"contact": {"model": "cells", "law": law}}) for name, law in laws.items()},
        SLOPE: {
            name: _always({"terrain.grade": grade, "terrain.side_slope": across})
            for name, (grade, across) in SLOPES.items()
        },
        OBSTACLE: {name: partial(_before_obstacle, name=name) for name in OBSTACLES},
        DUTY: {name: _always(travels | {f"{KEY}.travel": way}) for name, way in TRAVELS.items()}
        | {DIG: _digging},
    }


def _always(values: Values) -> Callable[[CaseFile], Values]:
    """Return a function that gives the same values for every case file."""
    return lambda _case_file: values


def _before_obstacle(case_file: CaseFile, name: str) -> Values:
    case = case_file.case
    number = len(case.terrain.relief.parts)
    x = round(float(case.outline(0.0)[:, 0].max()) + AHEAD, 2)
    return {f"terrain.relief.parts[{number}]": {"name": name, "x": x} | OBSTACLES[name]}


def _digging(case_file: CaseFile) -> Values:
    case = case_file.case
    if not isinstance(case.gear, Machine):
        raise ValueError(f"digging needs a machine on two tracks, got gear.kind {case.gear.kind!r}")
    digs = case.with_(machine=MachineCycle.digging(case.gear.car_body, case.terrain.down.tolist()))
    cycle = table_of(case_file.with_(case=digs), ("machine",))
    stands = {"speed": STANDS, "turn_rate": STANDS}
    return {"drive": stands, "machine": cycle, "duration": cycle["phases"][-1]["end"]}
