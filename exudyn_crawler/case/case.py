"""Case: all parameters of a run."""

from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from pydantic import Field

from exudyn_crawler.case import named, outline, ph4100c, statics
from exudyn_crawler.case.gear import AnyGear
from exudyn_crawler.case.gear.base import NOT_COMPILED
from exudyn_crawler.case.gear.dragged import Dragged
from exudyn_crawler.case.parameters import sizes
from exudyn_crawler.case.parameters.contact import PairContact, SphereContact
from exudyn_crawler.case.parameters.drive import Drive, Solver
from exudyn_crawler.case.parameters.heights import Heights
from exudyn_crawler.case.parameters.loads import LoadCycle, follow_shoes
from exudyn_crawler.case.parameters.machine_cycle import MachineCycle
from exudyn_crawler.case.parameters.terrain import CellContact, CellTerrain, SoilLaw, Terrain
from exudyn_crawler.case.parameters.track import SIDES, FlexibleShoes, Shoe, Track
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, Name, Parameters, option, quantity

Section = TypeVar("Section", bound=Parameters)


class Case(Parameters):
    """Track, terrain, contact, drive, loads and solver of one run; `ParameterError` if they do not fit.

    The fields are the keys of a case file. A file may name as its `base` a named case that needs no argument.
    """

    name: Name = option("name of the case in results and figures", "case")
    shoe: Shoe
    track: Track
    gear: AnyGear = option(
        "running gear: kind dragged, rolled, closed, or machine on two closed tracks",
        Dragged(),
    )
    terrain: Annotated[Terrain | CellTerrain, Field(discriminator="model")] = option(
        "ground: model units or cells"
    )
    contact: Annotated[PairContact | SphereContact | CellContact, Field(discriminator="model")] = option(
        "contact of shoes and terrain: model pair, spheres or cells"
    )
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

    renamed: ClassVar[dict[str, str]] = {
        "undercarriage": "is now [gear] with kind = 'rolled'",
        "closed_track": "is now [gear] with kind = 'closed', or 'machine' for two tracks",
        "car_body": "is now [gear.car_body] of a [gear] with kind = 'machine'",
    }
    """Keys of older case files, with the present places of their values."""

    @classmethod
    def translation(cls, shoe: named.Underside = "even") -> Self:
        """Return the straight propel of K-chapter, K-paper, F-paper; `Shoe.uneven` is fitted to the turn."""
        return cls(**named.translation(shoe))

    @classmethod
    def turning(cls, shoe: named.Underside = "even") -> Self:
        """Return the turning propel of K-chapter, K-paper and F-paper; for `shoe` see `translation`."""
        return cls(**named.turning(shoe))

    @classmethod
    def stress(cls, mesh: str = "study", seams: named.Seams = "margin") -> Self:
        """Return propel and loading cycle of the S-paper, with six flexible shoes.

        Each pair of shoe and unit has a whole contact law, as the paper states it. On 1 m units a shoe then
        stands on 4 to 8 of them. Its stiffness and its share of the load therefore change at seams; with
        ``PairContact.oil_sand(sharing="area")`` they do not. For `mesh` see `FlexibleShoes`, for `seams` see
        `Terrain.stress`.
        """
        return cls(**named.stress(mesh, seams))

    @classmethod
    def rolled(cls, shoe_count: int = 24) -> Self:
        """Return the straight propel of a side frame over rigid shoes before it; 24 allow 5 m of travel."""
        return cls(**named.rolled(shoe_count))

    @classmethod
    def closed(cls, shoe_count: int = ph4100c.CLOSED_SHOES) -> Self:
        """Return the straight propel of half a machine on a closed track of rigid shoes.

        The chain has `drive.speed`.
        """
        return cls(**named.closed(shoe_count))

    @classmethod
    def shovel(cls, shoe_count: int = ph4100c.CLOSED_SHOES) -> Self:
        """Return the straight propel of the machine on two closed tracks of `shoe_count` rigid shoes each."""
        return cls(**named.shovel(shoe_count))

    def on_cells(self, law: SoilLaw, heights: Heights | None = None, cell: float = 0.1) -> Self:
        """Return the case on cells of a size (m), flat or with heights; extent and slopes stay the same."""
        (x0, x1), (y0, y1) = self.terrain.bounds
        same: dict[str, Any] = {"grade": self.terrain.grade, "side_slope": self.terrain.side_slope}
        same |= {"origin": (x0, y0), "length": x1 - x0, "width": y1 - y0}
        terrain = CellTerrain(**same, cell=cell, relief=heights or Heights())
        return self.with_(terrain=terrain, contact=CellContact(law=law))

    def of_track(self, side: str) -> Self:
        """Return the case of one of two closed tracks, "right" or "left", with its side frame and no turn."""
        apart = self.gear.middles[SIDES.index(side)] - self.gear.middles[0]
        chain = self.gear.loop(self.track)
        x, y = chain.first_com
        first = SIDES.index(side) * chain.shoe_count
        pins = {"spherical_y": chain.spherical_y + apart, "parallel_y": chain.parallel_y + apart}
        bent = [] if self.flexible is None else [number - first for number in self.flexible.shoes]
        bent = [number for number in bent if 0 < number <= chain.shoe_count]
        return self.with_(
            name=f"{self.name}, {side} track",
            track=chain.with_(first_com=(x, y + apart), **pins),
            gear=self.gear.single,
            loads=LoadCycle.constant([0.0] * chain.shoe_count),
            drive=self.drive.with_(turn_rate=None),
            machine=None,
            flexible=self.flexible.with_(shoes=bent) if self.flexible and bent else None,
        )

    def part(self, kind: type[Section]) -> Section:
        """Return the section of a class; raises `ValueError` if the case has no such section."""
        sections = type(self).model_fields
        for value in (getattr(self, name) for name in sections):
            if isinstance(value, kind):
                return value
        held = {name: fields.models_of(field.annotation) for name, field in sections.items()}
        name = next(name for name, classes in held.items() if any(issubclass(one, kind) for one in classes))
        if (value := getattr(self, name)) is None:
            raise ValueError(f"{name} must be given, got {self.name!r} without it")
        tags = " or ".join(repr(fields.tag_of(one)) for one in held[name] if issubclass(one, kind))
        tag = fields.tag_field(type(value))
        raise ValueError(f"{name}.{tag} must be {tags}, got {getattr(value, tag)!r}")

    @property
    def can_be_compiled(self) -> bool:
        """True if the case has compiled equations of motion."""
        return not isinstance(self.contact, SphereContact) and self.terrain_formulation == "reduced"

    @property
    def is_compiled(self) -> bool:
        """True if a run uses the compiled equations of motion."""
        return self.can_be_compiled and self.formulation != "engine"

    def gravity_vector(self) -> np.ndarray:
        """Return the acceleration of gravity (3,), m/s2: x along the travel at t = 0, z normal to ground."""
        return self.gravity * self.terrain.down

    def outline(self, time: float) -> np.ndarray:
        """Return the corners of the track on the ground at a time (s): array (4, 2), m, global."""
        return outline.outlines(self, np.array([time]))[0]

    def check_support(self, duration: float) -> None:
        """Raise `ValueError` for a drive off the terrain, or a frame off the track, within `duration` (s)."""
        times = np.linspace(0.0, duration, 101 if duration > 0.0 else 1)
        for error in outline.support_errors(self, times):
            raise ValueError(error)

    @classmethod
    def _fitted(cls, values: dict[str, Any]) -> dict[str, Any]:
        """Return the values of a copy, with a machine's zero loads adapted to the number of shoes."""
        # a part is a table if a value in it was changed by its path
        gear, chain = (
            values[name] if isinstance(values[name], dict) else dict(iter(values[name]))
            for name in ("gear", "track")
        )
        count = chain["shoe_count"]
        if gear["kind"] == fields.tag_of(Dragged) or not isinstance(count, int) or count < 1:
            return values
        return values | {"loads": follow_shoes(values["loads"], count)}

    def _errors(self) -> Errors:
        count = self.track.shoe_count
        shoe = self.shoe
        terrain = self.terrain
        contact = self.contact
        spheres = isinstance(contact, SphereContact)
        reduced = self.terrain_formulation == "reduced"
        if (loaded := self.loads.shoe_count) != count:
            yield f"loads must name every shoe of the track ({count}) or be a number, got loads for {loaded}"
        if self.track.pitch + 1e-9 < shoe.length:
            yield f"shoe.length must not exceed the track's pitch {self.track.pitch}, got {shoe.length}"
        yield from sizes.pin_errors(shoe, self.track)
        if self.flexible is not None:
            shoes = self.flexible.shoes
            if shoes[0] < 1 or shoes[-1] > count:
                yield f"flexible.shoes must be in 1..{count}, got {fields.shown(shoes)}"
            if not reduced:
                yield "terrain_formulation must be 'reduced' with flexible shoes"
            if spheres:
                yield "flexible must be none with contact.model 'spheres'; 'pair' and 'cells' allow it"
        if isinstance(terrain, Terrain):
            yield from self._unit_errors(terrain)
        if (terrain.model == "cells") != (contact.model == "cells"):
            got = f"got {contact.model!r} on {terrain.model!r}"
            yield f"contact.model must be 'cells' with terrain.model 'cells', and only with it, {got}"
        elif contact.model == "cells" and not reduced:
            yield "terrain_formulation must be 'reduced' on a terrain of cells, which has no joints"
        yield from self.gear.errors(self)
        if self.formulation == "compiled" and not self.is_compiled:
            yield f"formulation must be 'engine' or none with {NOT_COMPILED}"
        if not self.track.pin.is_ideal and self.gear.pin_play is not None:
            yield f"track.pin.kind must be 'ideal' with gear.play, got {self.track.pin.kind!r}"
        if not self.track.pin.is_ideal and not self.is_compiled:
            kind = self.track.pin.kind
            yield f"track.pin.kind must be 'ideal' without compiled equations of motion, got {kind!r}"
        if isinstance(contact, SphereContact) and isinstance(terrain, Terrain):
            yield from self._sphere_errors(contact, terrain)
        yield from outline.support_errors(self, np.zeros(1))

    def _unit_errors(self, terrain: Terrain) -> Errors:
        """Yield an error for each setting that does not fit a terrain of units."""
        shoe = self.shoe
        contact = self.contact
        reduced = self.terrain_formulation == "reduced"
        small = terrain.unit_length < shoe.length or terrain.unit_width < shoe.width
        if isinstance(contact, PairContact) and contact.normal == "area" and small:
            sides = f"{terrain.unit_length:.4g} x {terrain.unit_width:.4g} m, smaller than a shoe"
            yield f"contact.normal must be 'face' on units of {sides}: neighbours would push each other"
        if not terrain.is_even and not reduced:
            yield "terrain_formulation must be 'reduced' on a terrain.relief, got 'constrained'"

    def _sphere_errors(self, contact: SphereContact, terrain: Terrain) -> Errors:
        """Yield an error for loads that lift the shoes, and for spheres of a wrong size."""
        mean = statics.mean_load(self)
        if not mean > 0.0:
            got = fields.quantity_text(mean, "N")
            yield f"the mean of all loads must press the shoes down, got {got} on each shoe"
        # for the greatest load of a shoe, on linear spheres
        load = max(max(phase.loads) for phase in self.loads.phases)
        depth = float(statics.settled_depths(self, statics.pressed(self, np.array([load])))[0])
        yield from contact.size_errors(depth, min(terrain.unit_length, terrain.unit_width))
