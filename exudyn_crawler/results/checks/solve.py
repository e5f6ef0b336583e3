"""Solution of check cases: balanced loads, stresses, peaks by region, cycles to a crack."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from exudyn_crawler.results.checks import cases as ready, roller_path
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe
from exudyn_crawler.results.checks.static_answers import rest_on_ground, static_answers
from exudyn_crawler.results.checks.tables import CYCLES, cycle_table, moment_table, peak_table
from exudyn_crawler.results.life.duty import UNLOADED
from exudyn_crawler.results.stress.hot_spots import BORES
from fem import Shapes
from meshes import STEEL

AT_BORES = "bores, not to be used"
"""Column of the cycles at a bore where these are fewer, beside a pin's coupling."""
NEAR = 1.1
"""Greatest cycles of a near pair of cases, ratio to the least cycles to a crack of the region."""


@dataclass(frozen=True)
class CheckResults:
    """Results of the check cases of a shoe.

    `stress` (cases, nodes, 6), Pa, and `displacement` (cases, nodes, 3), m, are those of the surface's nodes.
    `forces` (n, 3, cases), N, are those of loads and ground on all nodes, without pins. `table` has a row for
    each case and region, `moments` one for each case. `cycles` has a row for each cycle and region, `hertz`
    one for each force, width and tilt of a tread.
    """

    check: ready.ShoeCheck
    shoe: CheckedShoe
    cases: tuple[ready.CheckCase, ...]
    stress: np.ndarray
    displacement: np.ndarray
    forces: np.ndarray
    table: pd.DataFrame
    moments: pd.DataFrame
    cycles: pd.DataFrame
    hertz: pd.DataFrame

    @property
    def worst_cycles(self) -> pd.DataFrame:
        """Rows of `cycles` for the first region to crack, a row for each pair; the shortest first.

        Bores do not count where their stress beside a pin's coupling is not used. If they have fewer
        cycles, a last column `AT_BORES` has them. A pair that stresses bores alone has their row.
        """
        pair = ["from", "to"]
        is_bore = self.cycles["region"].isin(self.shoe.unused_regions)
        usable = self.cycles[~is_bore]
        worst = usable.loc[usable.groupby(pair, sort=False)[CYCLES].idxmin()]
        bores = self.cycles[is_bore]
        rows = worst.merge(bores[[*pair, CYCLES]].rename(columns={CYCLES: AT_BORES}), how="left", on=pair)
        rows[AT_BORES] = rows[AT_BORES].where(rows[AT_BORES] < rows[CYCLES])
        alone = bores.merge(worst[pair], how="left", on=pair, indicator="there").query("there == 'left_only'")
        table = pd.concat((rows, alone.drop(columns="there")), ignore_index=True).sort_values(CYCLES)
        return table if table[AT_BORES].notna().any() else table.drop(columns=AT_BORES)

    @property
    def by_region(self) -> pd.DataFrame:
        """Row of `cycles` with the fewest cycles of each region, fewest first; unused bores come last.

        A last column counts the region's pairs of cases with at most a tenth more cycles.
        """
        first = self.cycles.sort_values(CYCLES).groupby("region", sort=False).head(1)
        least = self.cycles.groupby("region")[CYCLES].transform("min")
        near = self.cycles[self.cycles[CYCLES] <= NEAR * least].groupby("region").size()
        columns = ["region", CYCLES, "from", "to", "an hour", "above yield"]
        table = first[columns].assign(**{"pairs within 10 %": first["region"].map(near)})
        is_bore = table["region"].isin(self.shoe.unused_regions)
        last = table[is_bore].assign(region=f"{BORES}, not to be used")
        return pd.concat((table[~is_bore], last), ignore_index=True)

    def cycle(self, first: str, second: str) -> pd.DataFrame:
        """Return the cycles to a crack in every region between two cases, or `UNLOADED` and a case."""
        stress = dict(zip([case.name for case in self.cases], self.stress, strict=True))
        return cycle_table(self.check, self.shoe, stress, [(first, second)])


def all_cases(check: ready.ShoeCheck, outline: ready.ShoeOutline) -> tuple[ready.CheckCase, ...]:
    """Return the ready cases at every level of the force, named "case, level", and the check's own cases."""
    cases = [
        ready_case.with_(name=f"{ready_case.name}, {level.name}")
        for level in check.levels
        for ready_case in ready.ready_cases(outline, level.force, check.machine)
    ]
    return (*cases, *check.cases)


def solve_cases(
    check: ready.ShoeCheck, shoe: CheckedShoe, say: Callable[[str], None] = lambda _text: None
) -> CheckResults:
    """Solve all cases of a check; ValueError for a case out of balance, or one that ground cannot carry."""
    cases = all_cases(check, shoe.outline)
    if check.track is not None:
        cases = _possible(check, shoe, cases, say)
    loads, answers, blows = static_answers(shoe, cases, say)
    say("stresses, peaks and cycles")
    surface = shoe.mesh.surface_nodes
    stress = np.ascontiguousarray(np.moveaxis(shoe.body.stress(answers, surface), 2, 0))
    names = [case.name for case in cases]
    by_name = dict(zip(names, stress, strict=True))
    pairs = [(UNLOADED, name) for name in names]
    pairs += [
        (f"{a}, {level.name}", f"{b}, {level.name}")
        for level in check.levels
        for a, b in ready.ready_cycles(shoe.outline)
        if {f"{a}, {level.name}", f"{b}, {level.name}"} <= {*names}
    ]
    return CheckResults(
        check,
        shoe,
        cases,
        stress,
        np.moveaxis(answers[surface], 2, 0),
        shoe.parts(loads)[0].reshape(answers.shape),
        peak_table(check, shoe, names, stress, answers),
        moment_table(shoe, cases, loads, blows),
        cycle_table(check, shoe, by_name, pairs),
        roller_path.hertz_table(check, cases),
    )


def _possible(
    check: ready.ShoeCheck, shoe: CheckedShoe, cases: Sequence[ready.CheckCase], say: Callable[[str], None]
) -> tuple[ready.CheckCase, ...]:
    """Return the cases without impossible ready ones: a loaded face is missing, or the shoe tips over."""
    chosen = {case.name for case in check.cases}
    possible = []
    left_out: dict[tuple[str, str], list[str]] = {}
    unbent = np.zeros_like(shoe.mesh.nodes)
    for case in cases:
        try:
            loads = shoe.loads(case)
            if case.ground is not None:
                rest_on_ground(shoe, case, loads, unbent)
        except ValueError as error:
            if case.name in chosen:
                raise
            name, _, level = case.name.rpartition(", ")
            left_out.setdefault((name, str(error)), []).append(level)
        else:
            possible.append(case)
    for (name, reason), levels in left_out.items():
        at_levels = "" if len(levels) == len(check.levels) else f" ({', '.join(levels)})"
        say(f"left out: {name}{at_levels}: {reason}")
    return tuple(possible)


def case_shapes(
    check: ready.ShoeCheck, names: Sequence[str], say: Callable[[str], None] = lambda _text: None
) -> Shapes:
    """Return displacement and stress of a shoe under some of its check cases, a column each.

    ValueError for an unknown case, with the known ones, and as in `solve_cases`.
    """
    shoe = CheckedShoe(check)
    known = {case.name: case for case in all_cases(check, shoe.outline)}
    if wrong := sorted(set(names) - set(known)):
        raise ValueError(f"{check.name}: no check case {wrong}; there are {[*known]}")
    _, answers, _ = static_answers(shoe, [known[name] for name in names], say)
    joints = tuple(shoe.partition.interfaces)
    return Shapes(shoe.mesh, STEEL, joints, answers, shoe.body.stress(answers))
