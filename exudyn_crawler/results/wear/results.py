"""Results of a wear forecast together: inspections, work of duties, limits, inputs."""

from dataclasses import dataclass

import pandas as pd

from exudyn_crawler.case import Case
from exudyn_crawler.origins import Ledger
from exudyn_crawler.results.wear import duty_work
from exudyn_crawler.results.wear.duty_work import DutyWork
from exudyn_crawler.results.wear.forecast import PartForecast, WearForecast
from exudyn_crawler.results.wear.ledger import inputs_ledger
from exudyn_crawler.results.wear.plan import WearPlan

NO_HOURS = (
    "no hours without an inspection or a stated coefficient: coefficients of sources span four decades; the "
    "work gives ratios between duties, machines, tensions and directions"
)


@dataclass(frozen=True)
class WearResults:
    """Wear of a machine: forecast by inspections, and work of its duties."""

    plan: WearPlan
    forecast: WearForecast | None
    duties: tuple[DutyWork, ...] = ()

    @property
    def pitch(self) -> PartForecast | None:
        """Forecast of the pitch that is due first; None without one."""
        parts = () if self.forecast is None else self.forecast.parts
        return next((part for part in parts if part.series.part == "pitch"), None)

    @property
    def by_duty(self) -> pd.DataFrame:
        """Work a propel hour and hours by part and duty; empty without duties."""
        return (
            duty_work.duty_table(self.plan, [*self.duties], self.forecast) if self.duties else pd.DataFrame()
        )

    @property
    def work(self) -> pd.DataFrame:
        """Work of all pairs by duty, run and side; empty without duties."""
        tables = [duty_work.work_table(duty) for duty in self.duties]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    @property
    def sweeps(self) -> pd.DataFrame:
        """Work of a pin by the threshold of sweeps beside the closed form; empty without duties."""
        tables = [duty_work.sweep_table(duty) for duty in self.duties]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    @property
    def regions(self) -> pd.DataFrame:
        """Work of a pin by region of the loop; empty without duties."""
        tables = [duty_work.region_table(duty) for duty in self.duties]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    @property
    def growth(self) -> pd.DataFrame:
        """Limits of the growth of the pitch, the least first; empty without duties."""
        return (
            duty_work.growth_table(self.duties[0], self.plan, self.pitch) if self.duties else pd.DataFrame()
        )

    @property
    def case(self) -> Case | None:
        """Case of the first run of the duties; None without duties."""
        return next((work.case for duty in self.duties for work in duty.runs.values()), None)

    @property
    def inputs(self) -> Ledger:
        """Inputs with their origins."""
        return inputs_ledger(
            self.plan, self.case, None if self.forecast is None else self.forecast.inspections
        )

    @property
    def lines(self) -> list[str]:
        """Lines on what is due first, on the limits of the pitch, and on pins beside their closed form."""
        lines = [] if self.forecast is None else self.forecast.lines
        if not self.duties:
            return lines
        least = self.growth.iloc[0]
        lines.append(f"first limit of the pitch: {least['limit']} at {least['growth in %']:.3g} % of growth")
        chosen = self.sweeps[self.sweeps["sweeps from deg"] > 0.0].groupby("run", sort=False).last()
        for run, row in chosen.iterrows():
            lines.append(
                f"pin, {run}: {row['pin in kJ a lap']:.3g} kJ a lap by sweeps of "
                f"{row['sweeps from deg']:.3g} deg and more, {row['closed form in kJ a lap']:.3g} kJ by the "
                "closed form with tensions of the run"
            )
        if self.forecast is None and not any(part.coefficient for part in self.plan.parts):
            lines.append(NO_HOURS)
        return lines
