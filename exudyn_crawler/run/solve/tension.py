"""Where the idler of a closed track stands that has a tension at rest: the take-up is solved for."""

import math
from functools import lru_cache
from typing import Any

import numpy as np

from exudyn_crawler.case import SIDES, Case, CaseFile
from exudyn_crawler.case.parameters.heights import Heights
from exudyn_crawler.errors import EquilibriumError, ParameterError
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.results.history import History, tension
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.run.solve import equilibrium, start

IDLER = "gear.idler"
SHIMS = 5  # decimals of a take-up in m: so that it is the same again on another machine
NEAR = 1e-3  # of a sag or a pretension, within which it is the one that is wanted
LEAST_SLACK = 1e-4  # m, from which on a chain is taut
TRIED = 16  # take-ups, at most; mostly 4 to 6, of which each is a rest of 0.2 s for 38 shoes
FARTHEST = 4.0  # times more slack or less than before, at most


def tensioned(case: Case) -> Case:
    """Same case with the take-up that gives its chains their tension at rest; as it is, if it says where.

    The tension is that of the machine that stands level on its own ground, as makers measure it, with half of
    its weight on either track. An EquilibriumError if no take-up in reach gives it.
    """
    if not case.gear.is_set_by_tension:
        return case
    return _with_take_up(case, take_up_of(_standing(case)))


def tensioned_file(case_file: CaseFile) -> CaseFile:
    """Case file of `tensioned`."""
    case = tensioned(case_file.case)
    return case_file if case is case_file.case else case_file.with_(case=case)


def chains_at_rest(case: Case) -> list[tension.Hanging]:
    """Chains of a case's closed tracks where they rest; an EquilibriumError if they find none."""
    return tension.hanging_chains(case, history_at_rest(case).dataset.isel(time=0))


def history_at_rest(case: Case) -> History:
    """State of rest as a history of one time, without reactions of joints."""
    system = compiled_system(case)
    row = np.zeros((1, system.layout.size))
    coordinates = system.layout.part(row[0], "coordinates")
    if system.sticks:
        # forces of cells follow from what these remember, which a run gives them as it starts
        coordinates[:] = start.begin(system)[0]
        system.layout.part(row[0], "contact")[:] = system.stored_contacts()
    else:
        coordinates[:] = equilibrium.static_equilibrium(case)
    return system_history(system, row)


def _with_take_up(case: Case, take_up: float) -> Case:
    places = {"take_up": take_up, "sag": None, "pretension": None}
    return case.with_({f"{IDLER}.{name}": value for name, value in places.items()})


def _standing(case: Case) -> Case:
    """One track of a machine that stands level, with its shoes rigid and nothing but its weight on it."""
    whole = sum(part.mass for part in case.frame_parts)
    along, _, up = np.sum([part.mass / whole * part.com for part in case.frame_parts], axis=0)
    level: dict[str, Any] = {"relief": Heights(), "grade": 0.0, "side_slope": 0.0}
    if case.terrain.model == "cells":
        level["ruts"] = None
    single = case if case.tracks == 1 else case.of_track(SIDES[0])
    alone = single.with_(name="machine that stands", machine=None, flexible=None)
    changes = {f"terrain.{name}": value for name, value in level.items()}
    half = {"mass": whole / case.tracks, "com": (float(along), 0.0, float(up)), "support": "ground"}
    return alone.with_(changes | {f"gear.{name}": value for name, value in half.items()})


@lru_cache(maxsize=64)
def take_up_of(case: Case) -> float:
    """Take-up (m) at which the chain of one closed track has its tension at rest; see `tensioned`.

    By secants of the logarithms of tension and slack, which are nearly a straight line, from the estimate of
    the assembly. Where makers' sag is wanted and none of a chain that closes is as small, the tautest.
    """
    idler = case.closed_gear().idler
    taut = _taut(case)
    wanted = case.closed_gear().wanted_sag if idler.pretension is None else idler.pretension

    def excess(slack: float) -> float:
        """Logarithm of the tension over the wanted one, which a sag is the less of the more it is."""
        (chain,) = chains_at_rest(_with_take_up(case, taut - slack))
        if idler.pretension is None:
            return math.log(wanted / max(chain.sag, NEAR * wanted))
        return math.log(max(chain.pretension, NEAR * wanted) / wanted)

    tried: list[tuple[float, float]] = []  # slack and excess
    slack = max(taut - case.assembled.take_up, LEAST_SLACK)
    for _ in range(TRIED):
        try:
            tried.append((slack, excess(slack)))
        except (ParameterError, EquilibriumError):
            if not tried:
                raise
            # a chain too long to stay on its wheels, or without a rest: half of the way
            slack = math.sqrt(slack * tried[-1][0])
            continue
        if abs(tried[-1][1]) < NEAR:
            return round(taut - slack, SHIMS)
        slack = max(slack * math.exp(_way(tried)), LEAST_SLACK)
        if slack == LEAST_SLACK == tried[-1][0]:
            break
    nearest, value = min(tried, key=lambda pair: abs(pair[1]))
    if idler.pretension is idler.sag is None:
        return round(taut - nearest, SHIMS)
    what, unit, size = ("sag", "mm", 1e3) if idler.pretension is None else ("pretension", "kN", 1e-3)
    got = wanted * math.exp(-value if idler.pretension is None else value)
    raise EquilibriumError(
        f"no take-up of the idler gives a {what} of {size * wanted:.4g} {unit} at rest; "
        f"the nearest is {size * got:.4g} {unit}, with a take-up of {taut - nearest:.4g} m"
        + (", where the chain just closes" if nearest == LEAST_SLACK else "")
    )


def _taut(case: Case) -> float:
    """Take-up (m) at which the chain just closes."""
    return case.with_(
        {f"{IDLER}.sag": None, f"{IDLER}.pretension": None, f"{IDLER}.slack": 0.0}
    ).assembled.take_up


def _way(tried: list[tuple[float, float]]) -> float:
    """Logarithm of the next slack over the last one."""
    (slack, value) = tried[-1]
    way = 2.0 * value  # of a chain that hangs as parabolas
    if len(tried) > 1:
        before, earlier = tried[-2]
        slope = (value - earlier) / math.log(slack / before) if slack != before else 0.0
        way = -value / slope if slope < 0.0 else way
    most = math.log(FARTHEST)
    return min(max(way, -most), most)
