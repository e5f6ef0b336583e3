"""What multibody systems have in common that Exudyn integrates."""

from collections.abc import Callable

from numpy.typing import NDArray

from exudyn_crawler.model.engine import exu
from exudyn_crawler.model.flexible_shoes import FloatingShoe


class Integrated:
    """System that Exudyn steps through time.

    Attributes
    ----------
    mbs : exudyn.MainSystem
        The assembled system.
    floating : FloatingShoe, optional
        What the flexible shoes share.
    """

    mbs: "exu.MainSystem"
    floating: FloatingShoe | None

    @property
    def frequencies(self) -> NDArray | None:
        """Of the flexible shoes' modes, Hz: array (modes,); None without flexible shoes."""
        return None if self.floating is None else self.floating.reduced.frequencies

    def after_step(self, told: Callable[[float], bool]) -> None:
        """Call a function with the time after each step; the run ends where it gives False."""
        self.mbs.SetPostStepUserFunction(lambda _mbs, time: told(time))
