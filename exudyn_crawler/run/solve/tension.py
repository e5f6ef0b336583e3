"""Search for the take-up of the idler that gives a closed track its tension at rest."""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.case import SIDES, Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.parameters.closed_track import Tensioner
from exudyn_crawler.case.parameters.heights import Heights
from exudyn_crawler.errors import EquilibriumError, ParameterError
from exudyn_crawler.machines import CaseFile
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.results.history import History, tension
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.run.solve import equilibrium, start

IDLER = "gear.idler"
SHIMS = 5  # decimals of a take-up in m, so that it is the same on every computer
NEAR = 1e-3  # greatest relative deviation from a wanted sag or pretension
LEAST_SLACK = 1e-4  # slack of a chain that counts as taut, m
TRIED = 16  # greatest number of take-ups; mostly 4 to 6, and each takes a rest of 0.2 s for 38 shoes
FARTHEST = 4.0  # greatest ratio of successive slacks, or its reciprocal
LEAST_STEP = 0.01  # least scale of the take-up's steps on sprung arms, fraction of a pitch
SOFTNESS = 10.0  # compression of the spring that replaces a push, in pitches
LIGHT = 1e-4  # mass of an idler moved by the push, fraction of the mass on a track


def tensioned(case: Case) -> Case:
    """Return the case with the take-up for its chains' tension at rest; unchanged if the case gives it.

    The tension is that of the machine at rest on its own ground, made level, as makers measure it. Each track
    carries half of its weight. EquilibriumError if no possible take-up gives it.
    """
    if not case.gear.is_set_by_tension:
        return case
    return _with_take_up(case, take_up_of(adjusted_track(case)))


def tensioned_file(case_file: CaseFile) -> CaseFile:
    """Return the case file with the case of `tensioned`."""
    case = tensioned(case_file.case)
    return case_file if case is case_file.case else case_file.with_(case=case)


def chains_at_rest(case: Case) -> list[tension.Hanging]:
    """Return the chains of a case's closed tracks at rest; EquilibriumError without a rest."""
    return tension.hanging_chains(case, history_at_rest(case).dataset.isel(time=0))


def history_at_rest(case: Case) -> History:
    """Return the state of rest as a history of one time, without reactions of joints."""
    system = compiled_system(case)
    row = np.zeros((1, system.layout.size))
    coordinates = system.layout.part(row[0], "coordinates")
    if system.sticks:
        # forces of cells follow from their memory, which the start of a run sets
        coordinates[:] = start.begin(system)[0]
        system.layout.part(row[0], "contact")[:] = system.stored_contacts()
    else:
        coordinates[:] = equilibrium.static_equilibrium(case)
    return system_history(system, row)


def _with_take_up(case: Case, take_up: float) -> Case:
    places = {"take_up": take_up, "sag": None, "pretension": None}
    return case.with_({f"{IDLER}.{name}": value for name, value in places.items()})


def adjusted_track(case: Case) -> Case:
    """Return the case of one track of a machine on level ground, with rigid shoes and its weight alone."""
    whole = sum(part.mass for part in case.gear.frame_parts)
    along, _, up = np.sum([part.mass / whole * part.com for part in case.gear.frame_parts], axis=0)
    level: dict[str, Any] = {"relief": Heights(), "grade": 0.0, "side_slope": 0.0}
    if case.terrain.model == "cells":
        level["ruts"] = None
    single = case if case.gear.tracks == 1 else case.of_track(SIDES[0])
    alone = single.with_(name="machine that stands", machine=None, flexible=None)
    changes = {f"terrain.{name}": value for name, value in level.items()}
    half = {"mass": whole / case.gear.tracks, "com": (float(along), 0.0, float(up)), "support": "ground"}
    return alone.with_(changes | {f"gear.{name}": value for name, value in half.items()})


class _Tried(NamedTuple):
    """Chain at rest in a search for its take-up."""

    tightness: float  # 0 at the first take-up; see `_Search`
    excess: float  # ln(tension / wanted tension)
    take_up: float  # m


class _Search(NamedTuple):
    """Take-ups of a search, by a tightness that rises nearly as the logarithm of the tension.

    About rigid wheels the tightness is -0.5 ln(slack / first slack): a chain hangs as parabolas. Sprung arms
    yield to the tension, so that with them the tightness is linear in the take-up.
    """

    first: float  # first take-up, m
    slack: float  # slack at the first take-up, m
    taut: float | None  # take-up that just closes the chain about rigid wheels, m; None for wheels on arms

    @property
    def most(self) -> float:
        """Greatest tightness: the chain just closes."""
        return math.inf if self.taut is None else 0.5 * math.log(self.slack / LEAST_SLACK)

    def take_up(self, tightness: float) -> float:
        """Return the take-up at a tightness, m."""
        if self.taut is None:
            return self.first + 2.0 * self.slack * tightness
        return self.taut - self.slack * math.exp(-2.0 * tightness)


@lru_cache(maxsize=64)
def take_up_of(case: Case) -> float:
    """Return the take-up (m) that gives the chain of one closed track its tension at rest; see `tensioned`.

    The search follows secants of the logarithm of the tension, from an estimate. If makers' sag is wanted and
    no chain that closes has so small a sag, the result is the tautest chain.
    """
    idler = case.part(Closed).idler
    wanted = case.part(Closed).wanted_sag if idler.pretension is None else idler.pretension

    def excess(take_up: float) -> float:
        """Return ln(tension / wanted tension); it falls as the sag grows."""
        (chain,) = chains_at_rest(_with_take_up(case, take_up))
        if idler.pretension is None:
            return math.log(wanted / max(chain.sag, NEAR * wanted))
        return math.log(max(chain.pretension, NEAR * wanted) / wanted)

    search = _search(case)
    tried: list[_Tried] = []
    tightness = 0.0
    for _ in range(TRIED):
        take_up = search.take_up(tightness)
        try:
            tried.append(_Tried(tightness, excess(take_up), take_up))
        except (ParameterError, EquilibriumError):
            if not tried:
                raise
            # a chain too long to stay on its wheels, or without a rest: half of the step
            tightness = 0.5 * (tightness + tried[-1].tightness)
            continue
        if abs(tried[-1].excess) < NEAR:
            return round(take_up, SHIMS)
        tightness = min(tightness + _way(tried), search.most)
        if tightness == search.most == tried[-1].tightness:
            break
    nearest = min(tried, key=lambda trial: abs(trial.excess))
    if idler.pretension is idler.sag is None:
        return round(nearest.take_up, SHIMS)
    what, unit, size = ("sag", "mm", 1e3) if idler.pretension is None else ("pretension", "kN", 1e-3)
    got = wanted * math.exp(-nearest.excess if idler.pretension is None else nearest.excess)
    raise EquilibriumError(
        f"no take-up of the idler gives a {what} of {size * wanted:.4g} {unit} at rest; "
        f"the nearest is {size * got:.4g} {unit}, with a take-up of {nearest.take_up:.4g} m"
        + (", where the chain just closes" if nearest.tightness == search.most else "")
    )


def _search(case: Case) -> _Search:
    """Return the search for a take-up, with its first one.

    On sprung arms the idler is first pushed with about the force of the tension, as a mechanic does with a
    grease gun. It stays where it comes to rest. Friction on the ground leaves the chain of a run slightly
    slacker or tauter there.
    """
    gear = case.part(Closed)
    taut = _taut(case)
    slack = max(taut - gear.assembled(case).take_up, LEAST_SLACK)
    if not gear.sinks:
        return _Search(taut - slack, slack, taut)
    pretension = gear.idler.pretension
    if pretension is None:
        weight = case.shoe.mass * case.gravity / case.track.pitch
        pretension = weight * float(gear.upper_spans[-1]) ** 2 / (8.0 * gear.wanted_sag)
    first = _pushed_take_up(case, 2.0 * pretension, taut)
    try:
        _with_take_up(case, first)
    except ParameterError:  # an idler pushed into a road wheel, or a chain that is too slack
        first = taut - slack
    return _Search(first, max(slack, LEAST_STEP * case.track.pitch), None)


def _pushed_take_up(case: Case, push: float, taut: float) -> float:
    """Return the take-up (m) at rest of an idler that a soft spring pushes forward with a force, N."""
    gear = case.part(Closed)
    stiffness = push / (SOFTNESS * case.track.pitch)
    spring = Tensioner(mass=LIGHT * gear.mass, stiffness=stiffness, preload=push + stiffness * taut)
    idler = gear.idler.with_(tensioner=spring, recoil=None, sag=None, pretension=None)
    return float(history_at_rest(case.with_({IDLER: idler})).take_up.item())


def _taut(case: Case) -> float:
    """Return the take-up (m) that just closes the chain."""
    taut = case.with_({f"{IDLER}.sag": None, f"{IDLER}.pretension": None, f"{IDLER}.slack": 0.0})
    return taut.part(Closed).assembled(taut).take_up


def _way(tried: list[_Tried]) -> float:
    """Return the step from the last tightness to the next."""
    last = tried[-1]
    way = -last.excess
    if len(tried) > 1:
        before = tried[-2]
        apart = last.tightness - before.tightness
        slope = (last.excess - before.excess) / apart if apart else 0.0
        way = -last.excess / slope if slope > 0.0 else way
    most = 0.5 * math.log(FARTHEST)
    return min(max(way, -most), most)
