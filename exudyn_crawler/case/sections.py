"""Sections of a case: what a case file holds, by its keys."""

from collections.abc import Callable
from typing import Annotated, Literal, TypeVar

from pydantic import Field

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear import AnyGear
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.dragged import Dragged
from exudyn_crawler.case.gear.rolled import Rolled
from exudyn_crawler.case.gear.running_gear import RunningGear
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
"""How shoes and terrain touch."""


Model = TypeVar("Model", bound=Parameters)


def _part(name: str, kind: type[Model]) -> Callable[["Sections"], Model]:
    """Method of a case that gives its part of this name, which has to be of a class."""

    def part(case: "Sections") -> Model:
        """Part of the case; a ValueError if it has none, or one of another class."""
        value = getattr(case, name)
        if isinstance(value, kind):
            return value
        if value is None:
            raise ValueError(f"{name} must be given, got {case.name!r} without it")
        held = fields.models_of(Sections.model_fields[name].annotation)
        tags = " or ".join(repr(fields.tag_of(model)) for model in held if issubclass(model, kind))
        tag = fields.tag_field(type(value))
        raise ValueError(f"{name}.{tag} must be {tags}, got {getattr(value, tag)!r}")

    return part


class Sections(Parameters):
    """Fields of a `Case`, which says what fits."""

    name: Name = option("name of the case in results and figures", "case")
    shoe: Shoe
    track: Track
    gear: AnyGear = option(
        "what moves the track: kind dragged, rolled, closed, or machine on two closed ones",
        Dragged(),
    )
    terrain: AnyTerrain = option("ground: model units or cells")
    contact: Contact = option("how shoes and terrain touch: model pair, spheres or cells")
    drive: Drive
    loads: LoadCycle
    flexible: FlexibleShoes | None = None
    solver: Solver = Solver()
    terrain_formulation: Literal["reduced", "constrained"] = option(
        "independent coordinates of the terrain, or all of them with its joints", "reduced"
    )
    formulation: Literal["compiled", "engine"] | None = option(
        "equations of motion: compiled, or by Exudyn's items, the reference; None: compiled if it can",
        None,
    )
    gravity: float = quantity("m/s2", "on level ground", (9.7, 9.9), ge=0, le=100, default=ph4100c.GRAVITY)
    machine: MachineCycle | None = option(
        "force and moment of the machine on the side frame; none: its weight alone", None
    )

    flexible_shoes = _part("flexible", FlexibleShoes)
    running_gear = _part("gear", RunningGear)
    rolled_gear = _part("gear", Rolled)
    closed_gear = _part("gear", Closed)
    unit_terrain = _part("terrain", Terrain)
    cell_terrain = _part("terrain", CellTerrain)
    cell_contact = _part("contact", CellContact)
    pair_contact = _part("contact", PairContact)
    sphere_contact = _part("contact", SphereContact)
