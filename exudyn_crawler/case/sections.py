"""Sections of a case: the contents of a case file, by key."""

from typing import Annotated, Literal, TypeVar

from pydantic import Field

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear import AnyGear
from exudyn_crawler.case.gear.dragged import Dragged
from exudyn_crawler.case.parameters.contact import PairContact, SphereContact
from exudyn_crawler.case.parameters.drive import Drive, Solver
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.case.parameters.machine_cycle import MachineCycle
from exudyn_crawler.case.parameters.terrain import CellContact, CellTerrain, Terrain
from exudyn_crawler.case.parameters.track import FlexibleShoes, Shoe, Track
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Name, Parameters, option, quantity

AnyTerrain = Annotated[Terrain | CellTerrain, Field(discriminator="model")]
Contact = Annotated[PairContact | SphereContact | CellContact, Field(discriminator="model")]
"""Contact of shoes and terrain."""


Model = TypeVar("Model", bound=Parameters)


class Sections(Parameters):
    """Fields of a `Case`, which says what fits."""

    name: Name = option("name of the case in results and figures", "case")
    shoe: Shoe
    track: Track
    gear: AnyGear = option(
        "running gear: kind dragged, rolled, closed, or machine on two closed tracks",
        Dragged(),
    )
    terrain: AnyTerrain = option("ground: model units or cells")
    contact: Contact = option("contact of shoes and terrain: model pair, spheres or cells")
    drive: Drive
    loads: LoadCycle
    flexible: FlexibleShoes | None = None
    solver: Solver = Solver()
    terrain_formulation: Literal["reduced", "constrained"] = option(
        "terrain coordinates: reduced to independent ones, or all of them constrained by joints", "reduced"
    )
    formulation: Literal["compiled", "engine"] | None = option(
        "equations of motion: compiled, or of Exudyn's items (reference); none: compiled if possible",
        None,
    )
    gravity: float = quantity(
        "m/s2", "gravitational acceleration", (9.7, 9.9), ge=0, le=100, default=ph4100c.GRAVITY
    )
    machine: MachineCycle | None = option(
        "force and moment of the machine on the side frame; none: its weight alone", None
    )

    def part(self, kind: type[Model]) -> Model:
        """Return the part of a class; raises `ValueError` if the case has no such part."""
        names = type(self).model_fields
        for value in (getattr(self, name) for name in names):
            if isinstance(value, kind):
                return value
        held = {name: fields.models_of(field.annotation) for name, field in names.items()}
        name = next(name for name, classes in held.items() if any(issubclass(one, kind) for one in classes))
        if (value := getattr(self, name)) is None:
            raise ValueError(f"{name} must be given, got {self.name!r} without it")
        tags = " or ".join(repr(fields.tag_of(one)) for one in held[name] if issubclass(one, kind))
        tag = fields.tag_field(type(value))
        raise ValueError(f"{name}.{tag} must be {tags}, got {getattr(value, tag)!r}")
