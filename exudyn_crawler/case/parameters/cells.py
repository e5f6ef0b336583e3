"""Ground of cells that remember: where it is, its heights and the law of its soil."""

import importlib
import json
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, SerializeAsAny

from exudyn_crawler.case.parameters.base import File, Parameters, Place, quantity
from exudyn_crawler.case.parameters.terrain import Ground

LAWS = "exudyn_crawler.ground.cells.laws"
"""Where the laws are, a file each: a room above this one, found by name."""


class SoilLaw(Parameters):
    """Parameters of a law of the cells: what each of them has."""

    model: str = Field(description="which law: the name of its file in ground/cells/laws")

    @staticmethod
    def plugged_in() -> list[type["SoilLaw"]]:
        """Classes of all laws that there are."""
        laws: list[type[SoilLaw]] = importlib.import_module(LAWS).law_classes()
        return laws

    def sinkage(self, pressure: float, width: float) -> float:
        """Sinkage (m) of a plate as wide as `width` (m) that is first loaded by a pressure (Pa)."""
        raise NotImplementedError


def _law(values: Any) -> Any:
    """Law of a table by its model; anything else as it is."""
    if not isinstance(values, dict):
        return values
    return importlib.import_module(LAWS).law_class(values.get("model"))(**values)


class CellContact(Parameters):
    """Shoes on cells: pressure and shear of every cell by a law of the soil."""

    model: Literal["cells"] = Field(default="cells", description="cells: ground that remembers")
    law: Annotated[SerializeAsAny[SoilLaw], BeforeValidator(_law)] = Field(
        description="law of the soil, by its model"
    )


class CellTerrain(Ground):
    """Field of square cells, each with a height, the sinkage that it has had and the shear that it bears."""

    model: Literal["cells"] = Field(default="cells", description="cells: ground that remembers")
    origin: tuple[Place, Place] = quantity("m", "x and y of the field's first corner, global")
    length: float = quantity("m", "of the field along x", gt=0, le=1e5)
    width: float = quantity("m", "of the field along y", gt=0, le=1e5)
    cell: float = quantity("m", "side of a cell", plausible=(0.02, 0.2), ge=1e-3, le=10, default=0.1)
    ruts: File | None = quantity(
        "", "history (.nc) of an earlier run on this ground, whose ruts it has; none: fresh", default=None
    )

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and greatest x, least and greatest y, m, global."""
        x, y = self.origin
        return (x, x + self.length), (y, y + self.width)

    @property
    def units(self) -> np.ndarray:
        """Numbers of units, of which there are none."""
        return np.zeros(0, dtype=int)

    def surface(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Height of the ground at places (m): array of their shape, m."""
        return np.asarray(self.relief.sample(x, y)[..., 0])

    def earlier(self, law: SoilLaw) -> dict[str, np.ndarray]:
        """Cells that the earlier run has pressed in, by their names in its history; none of fresh ground.

        A ValueError if there is no such history, or one of other cells, other heights or another law.
        """
        if self.ruts is None:
            return {}
        import xarray

        names = ("cell_column", "cell_row", "cell_sinkage", "cell_pressure")
        try:
            with xarray.open_dataset(self.ruts, engine="h5netcdf") as stored:
                case = json.loads(stored.attrs["case"])
                cells = {name: stored[name].values for name in names}
        # altered bytes make the readers raise all kinds of errors
        except Exception as error:
            reason = " ".join(str(error).split())
            raise ValueError(f"terrain.ruts: {self.ruts} has no ground of cells: {reason}") from error
        own = self.model_dump(mode="json") | {"law": law.model_dump(mode="json")}
        its = case["terrain"] | {"law": case["contact"]["law"]}
        if others := [name for name in ("cell", "relief", "law") if its[name] != own[name]]:
            raise ValueError(f"terrain.ruts: {self.ruts} is of a ground with another {' and '.join(others)}")
        return cells
