"""Number types of a track's parameters, with bounds that every machine is within."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import pydantic
from annotated_types import Ge, Gt, Le, Lt

from exudyn_crawler.settings.parameters import Parameters

FAR = 1e6  # m, greatest coordinate that is exact to a tenth of a micrometre

# the bounds exclude values that no machine has or that make the numerics fail
Place = Annotated[float, Ge(-FAR), Le(FAR)]
Component = Annotated[float, Ge(-1e12), Le(1e12)]  # of a force, a moment or an inertia
Length = Annotated[float, Ge(1e-3), Le(100.0)]
Extent = Annotated[float, Ge(0.0), Le(100.0)]
Width = Annotated[float, Ge(1e-9), Le(100.0)]
Depth = Annotated[float, Ge(1e-9), Le(10.0)]
Speed = Annotated[float, Ge(1e-9), Le(100.0)]
Stiffness = Annotated[float, Ge(1.0), Le(1e18)]
Exponent = Annotated[float, Ge(1.0), Le(10.0)]
Damping = Annotated[float, Ge(0.0), Le(1e12)]
Coefficient = Annotated[float, Ge(0.0), Le(10.0)]  # of friction or resistance
Slope = Annotated[float, Gt(-1.0), Lt(1.0)]
Mass = Annotated[float, Ge(1.0), Le(1e9)]  # of a machine's parts
Load = Annotated[float, Ge(-1e10), Le(1e10)]  # on a shoe, N
Roller = Annotated[float, Ge(-1e3), Le(1e3)]  # place of a roller along the frame, m
Survival = Annotated[float, Gt(0.0), Lt(1.0)]  # fraction of shoes that survives
Two = tuple[Place, Place]
Three = tuple[Place, Place, Place]
Vector = tuple[Component, Component, Component]
Six = tuple[Component, Component, Component, Component, Component, Component]


def _of_a_body(inertia: Six) -> Six:
    principal = np.linalg.eigvalsh(inertia_tensor(inertia))
    if principal[0] <= 0.0 or principal[2] > principal[0] + principal[1]:
        of_body = "principal moments positive, none above the sum of the other two"
        raise ValueError(
            f"must be the inertia of a body ({of_body}), got principal moments {principal.tolist()}"
        )
    return inertia


Inertia = Annotated[Six, pydantic.AfterValidator(_of_a_body)]
"""Ixx, Iyy, Izz, Iyz, Ixz, Ixy (tensor components), kg m2."""


def inertia_tensor(inertia: Six) -> np.ndarray:
    """Return the inertia tensor from its components: array (3, 3), kg m2."""
    xx, yy, zz, yz, xz, xy = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


class PH4100C(Parameters):
    """Parameters whose `values` for the P&H 4100C BOSS a class names."""

    _of_ph4100c: ClassVar[Mapping[str, Any]]

    def __init_subclass__(cls, values: Mapping[str, Any], **of_model: Any) -> None:
        super().__init_subclass__(**of_model)
        cls._of_ph4100c = values

    @classmethod
    def ph4100c(cls) -> Self:
        """Return the values of the P&H 4100C BOSS; `case.ph4100c` gives sources and marks assumed values."""
        return cls(**cls._of_ph4100c)
