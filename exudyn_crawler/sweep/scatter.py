"""Scatter of lives over a duty: values are drawn, and cycles, counted once, get other weights."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from exudyn_crawler.case.parameters import checks
from exudyn_crawler.life_run import stage_lives
from exudyn_crawler.results.life import duty_runs, life
from exudyn_crawler.results.life.duty import DamageOptions, Duty, DutyCase, DutyRun, read_duty
from exudyn_crawler.results.stress.hot_spots import BORES, REGIONS
from exudyn_crawler.settings import fields, parameters, reading
from exudyn_crawler.sweep import answers, definition
from fem.fatigue.changes import EndsTracker, PassEnds, changes
from fem.fatigue.defects import CycleStage

WORST = 5
"""Nodes of a region with the most damage by any part of a duty, or by all together: draws count there."""
DEFECTS = 10  # worst nodes of a region at which its defect is evaluated
DRAWN = ("material", "miner", "survivals", "an_hour", "share", "load", "case", "after", "hours")
"""Parameters of a duty that may be drawn, by the first or the last name of their path."""


class DutyScatter(definition.Variation):
    """Lives over a duty with drawn values: every draw is a shoe."""

    duty: Duty
    design: definition.Design = parameters.option("design of the draws, as in a sweep", "latin_hypercube")

    def _errors(self) -> parameters.Errors:
        for path in (path for variable in self.vary for path in variable.keys):
            names = fields.names_of(fields.parse_path(path))
            if not {names[0], names[-1]} & set(DRAWN):
                yield f"{path} cannot be drawn; what can begins or ends with {', '.join(DRAWN)}"
        yield from super()._errors()

    @property
    def named(self) -> str:
        """Name of the duty, for reading."""
        return f"duty {self.duty.name}"

    @property
    def _varied(self) -> Duty:
        return self.duty

    @cached_property
    def answers(self) -> tuple[answers.Life, ...]:
        """Life of the shoe without its bores, and of each of its other regions."""
        damage = {name: getattr(self.duty, name) for name in DamageOptions.model_fields}
        regions = [None, *(region for region in REGIONS if region != BORES)]
        return tuple(
            answers.Life(region=region, survival=self.duty.survivals[-1], **damage) for region in regions
        )

    @cached_property
    def duties(self) -> list[Duty]:
        """Duty of every draw, checked; warns of an implausible fleet."""
        checks.warn_of(self._odd_fleet())
        return self._of_all(lambda _number, values: self._changed(values))

    @property
    def planned(self) -> tuple[definition.PlannedRun, ...]:
        """All draws."""
        self.duties  # noqa: B018 - refuses draws that cannot be
        return tuple(definition.PlannedRun(k, values, str(k), ()) for k, values in enumerate(self.rows, 1))

    def lives(self, say: Callable[[str], None] = lambda _text: None) -> list[dict[str, float]]:
        """Return the lives (h) of every draw by name of answer; raises as `life`."""
        counted = CountedDuty.of(stage_lives(_with_all_cases(self.duties), say), self.duty)
        say(f"{len(self.duties)} draws at {len(counted.regions)} nodes")
        long = dict.fromkeys((answer.label for answer in self.answers), life.BEYOND)
        return [long | counted.lives(duty) for duty in self.duties]


AnySweep = definition.Sweep | DutyScatter


def _with_all_cases(duties: Sequence[Duty]) -> Duty:
    """Return the first of some duties with the check cases of all of them."""
    cases = {_key(case): case for duty in duties for case in duty.cases}
    named = (case.with_(name=key, load=1.0) for key, case in cases.items())
    return duties[0].with_(cases=tuple(named))


def _key(case: DutyCase) -> str:
    return sha256("\n".join((case.name, case.case, case.after)).encode()).hexdigest()


class CountedStage(NamedTuple):
    """Cycles at nodes in a stage of a duty: part, node and stresses (Pa), each (n,).

    `ends` (parts, places, nodes) are the least and greatest stresses of the passes of the parts.
    """

    runs: Sequence[duty_runs.UsedRun]
    part: np.ndarray
    node: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    ends: PassEnds

    def weighed(self, duty: Duty) -> "WeighedCycles":
        """Return the cycles with the weights of a drawn duty."""
        drawn = {run.name: run for run in duty.runs} | {_key(case): case for case in duty.cases}
        often = np.zeros(len(self.runs))
        load = np.ones(len(self.runs))
        for k, used_run in enumerate(self.runs):
            match drawn.get(used_run.run.name):
                case DutyCase() as case:
                    often[k] = case.an_hour
                    load[k] = case.load
                case DutyRun() as run:
                    often[k] = run.times_an_hour(float(used_run.time[-1] - used_run.time[0]))
        there = often > 0.0
        _, places, nodes = self.ends.lowest.shape
        passes = PassEnds(*(load[there, None, None] * values[there] for values in self.ends))
        flat = PassEnds(*(values.reshape(there.sum(), -1) for values in passes))
        mixed = changes(flat, often[there], duty.most_changes)
        factor = load[self.part]
        return WeighedCycles(
            np.concatenate((self.node, mixed.place % nodes)),
            np.concatenate((factor * self.begin, mixed.begin)),
            np.concatenate((factor * self.end, mixed.end)),
            np.concatenate((often[self.part], mixed.rate)) / places,
            np.max([-passes.lowest.min(axis=(0, 1)), passes.highest.max(axis=(0, 1))], axis=0),
        )


class WeighedCycles(NamedTuple):
    """Cycles of a drawn duty in a stage: node, both stresses (Pa) and number an hour, each (n,).

    Replaced cycles have negative numbers. `peak` (nodes,) is the greatest magnitude of stress, Pa.
    """

    node: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    rate: np.ndarray
    peak: np.ndarray

    def of(self, node: int, lasts: float) -> CycleStage:
        """Return the cycles of a node over `lasts` (h), less the replaced ones."""
        here = self.node == node
        ends = np.sort(np.stack((self.begin[here], self.end[here]), axis=1), axis=1)
        different, each = np.unique(ends, axis=0, return_inverse=True)
        rate = np.bincount(each.ravel(), self.rate[here], len(different))
        return CycleStage(different[:, 0], different[:, 1], np.maximum(rate, 0.0), lasts)


@dataclass(frozen=True)
class CountedDuty:
    """Cycles over a duty at nodes that may crack first; a draw changes only the weights of their damage."""

    regions: np.ndarray  # (nodes,) of str
    stages: tuple[CountedStage, ...]

    @classmethod
    def of(cls, stages: Sequence[life.LifeResults], duty: Duty) -> "CountedDuty":
        """Return the cycles in the stages of a duty, at nodes of the last stage's mesh."""
        last = stages[-1]
        near = [life.nearest_nodes(stage, stages[-1]) for stage in stages]
        surface = last.whole.mesh.surface_nodes
        chosen = set[int]()
        for stage, nearest in zip(stages, near, strict=True):
            for part in (*stage.dataset.part_damage.values, stage.dataset.damage_an_hour.values[-1]):
                known = pd.Series(part[nearest[surface]], surface).sort_values(ascending=False)
                known = known[(known > 0.0) & (last.regions[known.index] != BORES)]
                chosen |= {*known.groupby(last.regions[known.index]).head(WORST).index}
        nodes = np.array(sorted(chosen))
        counted = (_counted(stage, nearest[nodes]) for stage, nearest in zip(stages, near, strict=True))
        return cls(last.regions[nodes], tuple(counted))

    def lives(self, duty: Duty) -> dict[str, float]:
        """Return the life (h) of the shoe and of each region over a drawn duty, by name of answer."""
        material = duty.material
        survival = duty.survivals[-1:]
        curve = replace(material.curve(duty.miner), residual_stress=0.0)
        residual = np.array([material.casting(region).residual_stress for region in self.regions])
        weighed = [stage.weighed(of) for stage, of in zip(self.stages, duty.by_stage(), strict=True)]
        damage = np.zeros((len(weighed), len(self.regions)))
        for by_region, cycles in zip(damage, weighed, strict=True):
            moves = cycles.begin != cycles.end
            node, begin, end, often = (values[moves] for values in cycles[:4])
            each = curve.damage(0.5 * np.abs(end - begin), 0.5 * (begin + end) + residual[node], survival)[0]
            by_region += np.maximum(np.bincount(node, often * each, len(by_region)), 0.0)
            by_region[cycles.peak > material.tensile_strength] = np.inf
        hours = [*(stage.hours for stage in duty.stages[:-1]), np.inf]
        lives = life.hours_in_stages(damage, hours).sum(axis=0)
        shortest = {"life": life.BEYOND}
        for region in dict.fromkeys(self.regions):
            here = np.flatnonzero(self.regions == region)
            worst = here[np.argsort(lives[here])]
            least = min(float(lives[worst[0]]), life.BEYOND)
            for node in worst[:DEFECTS] if material.casting(region).defect_size else ():
                stages = [cycles.of(node, lasts) for cycles, lasts in zip(weighed, hours, strict=True)]
                least = min(least, material.defect_life(region, duty.miner, stages, survival[0]))
            shortest[f"life_{region}".replace(" ", "_")] = least
            shortest["life"] = min(shortest["life"], least)
        return shortest


def _counted(stage: life.LifeResults, nodes: np.ndarray) -> CountedStage:
    """Return the cycles in a stage at some nodes, without those too small for any draw."""
    rows = []
    ends = []
    for part, run in enumerate(stage.runs):
        negligible = 1e-3 / life.BEYOND / run.times_an_hour
        counting = run.counting(stage.duty.material.curve(stage.duty.miner), (0.999,), negligible)
        at_places = []
        for shoe in run.basis.coordinates:
            signals = duty_runs.node_signals(stage.duty.criterion, run.basis, shoe, nodes)
            tracker = EndsTracker(len(signals))
            tracker.add(slice(len(signals)), signals, 0)
            at_places.append(tracker.ends)
            for node, signal in enumerate(signals):
                cycles = counting.cycles(signal)
                columns = np.full(len(cycles.begin), part), np.full(len(cycles.begin), node)
                rows.append(np.stack((*columns, cycles.begin, cycles.end)))
        ends.append(PassEnds.stacked(at_places))
    part, node, begin, end = np.concatenate(rows, axis=1)
    return CountedStage(stage.runs, part.astype(int), node.astype(int), begin, end, PassEnds.stacked(ends))


def read_scatter(path: str | Path) -> AnySweep:
    """Read a sweep file, or one with a duty file and its drawn values; raises as `read_sweep`."""
    path = Path(path)

    def values(content: reading.Content) -> reading.Content:
        duty_file = path.parent / str(content.pop("duty"))
        if not duty_file.is_file():
            raise ValueError(f"duty: there is no file {duty_file}")
        duty = read_duty(duty_file)
        bare_duty = duty.with_(survivals=duty.survivals[-1:], plane_nodes=0)
        return content | {"duty": bare_duty.model_dump(mode="json")}

    with reading.errors_named(path, DutyScatter):
        of_duty = "duty" in reading.toml_content(path, "sweep file")
    if of_duty:
        return reading.read_parameters(path, DutyScatter, "duty scatter file", values)
    return definition.read_sweep(path)
