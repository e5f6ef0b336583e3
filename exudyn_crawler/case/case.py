"""Case: all parameters of a run."""

from typing import Any, ClassVar

import numpy as np

from exudyn_crawler.case import outline
from exudyn_crawler.case.gear.assembled import Assembled
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.dragged import Dragged
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.case.named import NamedCases
from exudyn_crawler.case.parameters import sizes
from exudyn_crawler.case.parameters.car_body import Part
from exudyn_crawler.case.parameters.contact import PairContact, SphereContact, impact_depth
from exudyn_crawler.case.parameters.loads import LoadCycle, follow_shoes
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case.parameters.track import SIDES, Track
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors

NOT_COMPILED = "contact.model 'spheres' and terrain_formulation 'constrained'"


class Case(NamedCases):
    """Track, terrain, contact, drive, loads and solver of one run; `ParameterError` if they do not fit."""

    renamed: ClassVar[dict[str, str]] = {
        "undercarriage": "is now [gear] with kind = 'rolled'",
        "closed_track": "is now [gear] with kind = 'closed', or 'machine' for two tracks",
        "car_body": "is now [gear.car_body] of a [gear] with kind = 'machine'",
    }
    """Keys of older case files, with the present places of their values."""

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
        if isinstance(contact, SphereContact):
            yield from self._sphere_errors(contact)
        yield from self._support_errors(np.zeros(1))

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

    def _sphere_errors(self, contact: SphereContact) -> Errors:
        """Yield an error for loads that lift the shoes, and for spheres of a wrong size."""
        if not self.mean_load > 0.0:
            mean = fields.quantity_text(self.mean_load, "N")
            yield f"the mean of all loads must press the shoes down, got {mean} on each shoe"
        # for the greatest load of a shoe, on linear spheres
        load = max(max(phase.loads) for phase in self.loads.phases)
        depth = self.settled_penetration * float(self.pressed(load)) / self.mean_load
        terrain = self.part(Terrain)
        yield from contact.size_errors(depth, min(terrain.unit_length, terrain.unit_width))

    @property
    def assembled(self) -> Assembled:
        """Start of a closed track; raises `ValueError` if the track is open."""
        return self.part(Closed).assembled(self.shoe, self.track)

    @property
    def tracks(self) -> int:
        """Number of tracks; the right one comes first."""
        return self.gear.tracks

    @property
    def loop(self) -> Track:
        """Chain of one track."""
        return self.gear.loop(self.track)

    @property
    def frame_parts(self) -> list[Part]:
        """Rigid parts of the side frame, or of the machine on two tracks."""
        return self.gear.frame_parts

    @property
    def joints(self) -> np.ndarray:
        """Link numbers; link i connects shoes i and i + 1, a closed track's last one its last and first."""
        return self.gear.joints(self.track)

    @property
    def links(self) -> np.ndarray:
        """Shoes behind and ahead of every link: array (links, 2); for the numbers see `joints`."""
        # an open track has no link ahead of its last shoe, so no link leads back to its first shoe
        rear = self.joints
        count = self.track.shoe_count // self.tracks
        return np.column_stack((rear, np.where(rear % count, rear + 1, rear + 1 - count)))

    @property
    def shoe_reference(self) -> np.ndarray:
        """Positions of the COMs (m, global) and angles (rad) of the shoes at t = 0: array (shoes, 6)."""
        return self.gear.shoe_reference(self.shoe, self.track)

    @property
    def frame_start(self) -> np.ndarray:
        """Origin of the side frame, or the machine, at t = 0, on rails that have not settled: (3,), m."""
        return self.part(RunningGear).frame_start(self.shoe, self.track)

    @property
    def tumbler_reference(self) -> np.ndarray:
        """Centres of the tumblers (m, global) and their angles (rad) at t = 0: array (tracks, 6)."""
        return self.part(Closed).tumbler_reference(self.shoe, self.track)

    @property
    def idler_reference(self) -> np.ndarray:
        """Centres of the idlers (m, global) and their angles (rad) at t = 0: array (tracks, 6)."""
        return self.part(Closed).idler_reference(self.shoe, self.track)

    def of_track(self, side: str) -> "Case":
        """Return the case of one of two closed tracks, "right" or "left", with its side frame and no turn."""
        apart = self.gear.middles[SIDES.index(side)] - self.gear.middles[0]
        chain = self.loop
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

    @property
    def is_compiled(self) -> bool:
        """True if a run uses the compiled equations of motion."""
        can_be = not isinstance(self.contact, SphereContact) and self.terrain_formulation == "reduced"
        return can_be and self.formulation != "engine"

    def gravity_vector(self) -> np.ndarray:
        """Return the acceleration of gravity (3,), m/s2: x along the travel at t = 0, z normal to ground."""
        return self.gravity * self.terrain.down

    def pressed(self, load: np.typing.ArrayLike) -> np.ndarray:
        """Return the force normal to the ground (N) of a shoe's weight and each load (N) on it."""
        return (np.asarray(load) + self.shoe.mass * self.gravity) * -self.terrain.down[2]

    @property
    def first_loads(self) -> np.ndarray:
        """Loads on the shoes at t = 0: array (shoes,), N; a side frame loads the shoes below it evenly."""
        return self.gear.first_loads(self)

    def machine_wrench(self, time: np.typing.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return force (N) and moment (N m) at a side frame's origin, without its weight, at times (s).

        Both are global arrays (times, 3).
        """
        nothing = np.zeros((np.size(time), 3))
        return (nothing, nothing.copy()) if self.machine is None else self.machine.wrench(time)

    @property
    def mean_load(self) -> float:
        """Mean normal force, N, of load and weight below the shoes that carry the machine at t = 0."""
        return float(self.pressed(self.first_loads[self.gear.standing(self)]).mean())

    @property
    def settled_penetration(self) -> float:
        """Penetration of an evenly loaded shoe under the mean load, m."""
        if isinstance(self.contact, SphereContact):
            law = self.contact.reference_stiffness, self.contact.reference_exponent
            return float(impact_depth(self.mean_load, *law))
        return float(self.settled_depths(np.array([self.mean_load]))[0])

    def settled_depths(self, loads: np.ndarray) -> np.ndarray:
        """Return the penetration (m) of an evenly loaded shoe for each load (N); zero if it is lifted."""
        contact = self.contact
        loads = np.maximum(loads, 0.0)
        if isinstance(contact, PairContact):
            return impact_depth(loads, contact.stiffness, contact.exponent)
        if isinstance(contact, SphereContact):
            return loads * self.settled_penetration / self.mean_load
        breadth = self.shoe.ground_breadth
        pressures = (loads / self.shoe.ground_area).tolist()
        return np.array([contact.law.sinkage(pressure, breadth) for pressure in pressures])

    @property
    def sphere_stiffness(self) -> float:
        """Stiffness of a sphere, N/m; a shoe's spheres carry the mean load at the settled penetration."""
        return self.mean_load / self.settled_penetration / self.part(SphereContact).count

    def outline(self, time: float) -> np.ndarray:
        """Return the corners of the track on the ground at a time (s), see `outlines`: array (4, 2), m."""
        return self.outlines(np.array([time]))[0]

    def outlines(self, times: np.ndarray) -> np.ndarray:
        """Return the corners of the track on the ground at times (s): array (times, 4, 2), m, global x and y.

        The drive moves and turns the outline; a machine on two tracks follows its heading. A track under a
        rolling side frame stands still.
        """
        corners = outline.corners_of(self.shoe.footprint, self.shoe_reference)
        return outline.moved(corners, self.drive.turn(times), self.gear.way(self.drive, times))

    def check_support(self, duration: float) -> None:
        """Raise `ValueError` for a drive off the terrain, or a frame off the track, within `duration` (s)."""
        times = np.linspace(0.0, duration, 101 if duration > 0.0 else 1)
        for error in self._support_errors(times):
            raise ValueError(error)

    def _support_errors(self, times: np.ndarray) -> Errors:
        """Yield an error for each part off the track, and for a track off the terrain, at times (s)."""
        outlines = self.outlines(times)
        travels = self.drive.travel(times)
        for time, travel, corners in zip(times.tolist(), travels.tolist(), outlines, strict=True):
            yield from self.gear.reach_errors(self.track, travel, time)
            yield from self.terrain.reach_errors(corners, time)
        yield from self.terrain.map_errors(outlines)
