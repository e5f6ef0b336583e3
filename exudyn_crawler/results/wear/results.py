"""Results of a wear forecast together."""

from dataclasses import dataclass

from exudyn_crawler.results.wear.forecast import WearForecast
from exudyn_crawler.results.wear.plan import WearPlan


@dataclass(frozen=True)
class WearResults:
    """Wear of a machine: forecast by inspections."""

    plan: WearPlan
    forecast: WearForecast | None

    @property
    def lines(self) -> list[str]:
        """Lines on what is due first."""
        return [] if self.forecast is None else self.forecast.lines
