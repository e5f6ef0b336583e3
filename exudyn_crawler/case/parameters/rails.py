"""Rails of a shoe, which the lower rollers of the side frame roll on."""

from typing import Self

from pydantic import model_validator

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import Parameters, Place, quantity


class Rails(Parameters):
    """Two level rails of a shoe, in its frame."""

    rear: Place = quantity("m", "x of the rear ends", plausible=(-1.0, 0.0))
    front: Place = quantity("m", "x of the front ends", plausible=(0.0, 1.0))
    right: Place = quantity("m", "y of the middle of the right rail", plausible=(-1.5, 0.0))
    left: Place = quantity("m", "y of the middle of the left rail", plausible=(0.0, 1.5))
    width: float = quantity("m", "width of a rail", plausible=(0.05, 1.0), ge=1e-3, le=100)
    height: Place = quantity("m", "z of their tops", plausible=(0.0, 1.0))

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.front <= self.rear:
            raise ValueError(f"front must be greater than rear = {self.rear}, got {self.front}")
        if self.left - self.right < self.width:
            raise ValueError(
                f"left and right must be apart by the width {self.width} at least, "
                f"got {self.right} and {self.left}: the rails overlap"
            )
        return self

    @classmethod
    def ph4100c(cls) -> Self:
        """Rails of the shoe in `meshes/`."""
        return cls(**ph4100c.RAILS)

    @property
    def middles(self) -> tuple[float, float]:
        """Y of the middles of the right and of the left rail, m."""
        return self.right, self.left
