"""Summary of a machine at rest on its track, for reading: ground pressure, and tension of its chains."""

from collections.abc import Iterator
from typing import NamedTuple

from exudyn_crawler.case import Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.closed_frame import GREATEST_SAG, LEAST_SAG
from exudyn_crawler.results.history import History, tension
from exudyn_crawler.results.history.catalogue import LOADED
from exudyn_crawler.run.solve.simulation import compiled, solved_for_tension
from exudyn_crawler.run.solve.tension import history_at_rest
from exudyn_crawler.settings.fields import quantity_text


class Standing(NamedTuple):
    """Machine at rest on its track."""

    case: Case  # case with the take-up of its idler
    history: History  # history of one time

    @property
    def lines(self) -> list[str]:
        """Ground pressure and tension, a line each."""
        return [self._on_ground(), *self._chains()]

    @property
    def warnings(self) -> Iterator[str]:
        """Warnings of chains tauter or slacker than makers ask for."""
        for chain in self.chains:
            share = chain.sag / chain.span
            if not LEAST_SAG <= share <= GREATEST_SAG:
                side = f"{chain.side} chain" if chain.side else "chain"
                how = "tauter" if share < LEAST_SAG else "slacker"
                sags = f"it sags by {1e3 * chain.sag:.3g} mm in {chain.span:.3g} m behind the idler"
                makers = f"{100.0 * LEAST_SAG:g} to {100.0 * GREATEST_SAG:g} %"
                yield (
                    f"gear.idler: the {side} is {how} than makers ask for: {sags}, "
                    f"{100.0 * share:.2g} %, not {makers}; idler.sag or idler.pretension say its tension"
                )

    @property
    def chains(self) -> list[tension.Hanging]:
        """Chains of a machine on closed tracks on the ground; empty for others."""
        if not self.case.gear.loops or self.case.part(Closed).support == "posts":
            return []
        return tension.hanging_chains(self.case, self.history.dataset.isel(time=0))

    def _on_ground(self) -> str:
        pressure = self.history.ground_pressure.isel(time=0)
        mean = float(self.history.mean_ground_pressure.isel(time=0))
        # normals incline with the units that a shoe tilts, and some of them act against each other
        carried = float(self.history.normal_force.isel(time=0).sel(axis="z").sum())
        if not mean:
            return "at rest: no shoe is on the ground"
        loaded = int((pressure >= LOADED * pressure.max()).sum())
        return (
            f"at rest: the ground carries {quantity_text(carried, 'N')}, most of it on {loaded} of "
            f"{len(pressure)} shoes; the pressure below these is {1e-3 * mean:.4g} kPa on the mean and "
            f"{1e-3 * float(pressure.max()):.4g} kPa at most"
        )

    def _chains(self) -> Iterator[str]:
        if not self.chains:
            return
        gear = self.case.part(Closed)
        weight = sum(part.mass for part in gear.frame_parts) * self.case.gravity / gear.tracks
        for chain in self.chains:
            side = f"{chain.side} chain" if chain.side else "chain"
            push = f"half of its push on the idler of {quantity_text(chain.push, 'N')}"
            share = f"{100.0 * chain.push / weight:.3g} % of the weight on its rollers"
            sag = (
                f"it sags by {1e3 * chain.sag:.3g} mm in {chain.span:.3g} m between idler and {chain.carrier}"
            )
            take_up = f"take-up {1e3 * gear.assembled(self.case).take_up:.1f} mm"
            pull = quantity_text(chain.pretension, "N")
            yield f"tension at rest: {side} {pull}, {push} ({share}); {sag}; {take_up}"


def standing(case: Case, progress: bool | None = None) -> Standing | None:
    """Return the rest of a machine on its track with rigid shoes; None for a track without a machine.

    EquilibriumError if the search finds none.
    """
    if not case.gear.frame_parts:
        return None
    compiled(case, progress)
    rigid = solved_for_tension(case.with_(flexible=None), progress)
    return Standing(rigid, history_at_rest(rigid))
