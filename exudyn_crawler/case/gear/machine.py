"""Machine gear: two closed tracks, with car body and upper structure between them."""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, ClassVar, Literal, Self

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.assembled import Assembled, assembled
from exudyn_crawler.case.gear.base import WheelLabel, Whole
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.parameters import sizes
from exudyn_crawler.case.parameters.car_body import CarBody, Part
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.track import SIDES, Shoe, Track
from exudyn_crawler.settings.parameters import Errors, option

UPPER_REACH = 3.0  # greatest radius of gyration of an upper structure with its boom, lengths of the crawler
INSTANTS = 501  # number of times for the integration of the travelled path


class Machine(Closed):
    """Machine on two closed tracks, which share `track.shoe_count`, the right first; nothing holds its plane.

    The tracks go at `drive.speed` more or less half of `car_body.gauge` times `drive.turn_rate`.
    """

    kind: Literal["machine"] = option(  # type: ignore[assignment]
        "machine on two closed tracks with a car body", "machine"
    )
    car_body: CarBody

    tracks: ClassVar[int] = 2
    loops: ClassVar[int] = 2
    phrase: ClassVar[str] = "Machine of {whole} t on two closed tracks of {shoes} shoes each"

    @classmethod
    def of(cls, track: Closed, car_body: CarBody) -> Self:
        """Return a machine on two equal tracks, each with its own side frame."""
        return cls(**_values(track), car_body=car_body)

    @classmethod
    def ph4100c(cls) -> Self:
        """Return the machine of the P&H 4100C BOSS; `case.ph4100c` marks assumed values."""
        half = Closed.ph4100c()
        mass = ph4100c.SIDE_FRAME_MASS
        inertia = tuple(value * mass / half.mass for value in half.inertia)
        return cls.of(half.with_(mass=mass, inertia=inertia), CarBody.ph4100c())

    @property
    def single(self) -> Closed:
        """Gear of a single track with its own side frame."""
        return _single(self)

    @property
    def middles(self) -> np.ndarray:
        """Lateral positions y of the tracks' middles in the machine's axes: array (2,), m."""
        return np.array(self.car_body.middles)

    @property
    def wheel_labels(self) -> list[WheelLabel]:
        """Kinds and numbers of the wheels of the right track, then of the left one."""
        labels = super().wheel_labels
        return [label._replace(track=side) for side in SIDES for label in labels]

    @property
    def frame_parts(self) -> list[Part]:
        """Rigid parts of the machine."""
        return self.car_body.parts(self.frame)

    @property
    def holds(self) -> tuple[int, ...]:
        """Coordinates of the machine with a hold: none."""
        return ()

    @property
    def tipping(self) -> float:
        """Lateral distance from the middle at which a weight tips the machine, m."""
        return 0.5 * self.car_body.gauge

    def assembled(self, case: Whole) -> Assembled:
        """Return the start of the right track; raises `assembly.MisfitError` if its chain does not close."""
        return assembled(self.single, case.shoe, self.loop(case.track))

    def way(self, drive: Drive, times: np.ndarray) -> np.ndarray:
        """Return the displacement of the machine's middle, which follows its heading: array (times, 2), m."""
        if drive.turn_rate is None:
            return super().way(drive, times)
        instants = np.linspace(0.0, times, INSTANTS, axis=-1)
        heading = drive.turn_rate.integral(instants)
        ahead = np.array([np.cos(heading), np.sin(heading)])
        way: np.ndarray = np.trapezoid(drive.speed.value(instants) * ahead, instants)
        return way.T

    def errors(self, case: Whole) -> Errors:
        """Yield an error for each contradiction to the rest of the case."""
        if (count := case.track.shoe_count) % 2:
            yield f"track.shoe_count must be even with gear.kind 'machine', which has two tracks, got {count}"
        if self.support == "posts":
            yield "gear.support must be 'ground' with gear.kind 'machine', which stands on both tracks"
        width = f"the shoes' width of {case.shoe.width:.4g} m"
        apart = self.car_body.gauge
        if apart < case.shoe.width:
            yield f"gear.car_body.gauge must be at least {width}, got {apart:g} m"
        yield from super().errors(case)

    def turn_errors(self, drive: Drive) -> Errors:
        """Yield no error: two tracks can turn."""
        yield from ()

    def implausible(self, shoe: Shoe, chain: Track) -> Iterator[str]:
        """Yield a warning for each value that no known machine has."""
        yield from super().implausible(shoe, chain)
        body = self.car_body
        upper = "gear.car_body, upper structure", body.upper_mass, body.upper_inertia
        for part, reach in (
            (("gear.car_body", body.mass, body.inertia), self.length),
            (upper, UPPER_REACH * self.length),
        ):
            yield from sizes.thin_inertia(*part)
            yield from sizes.far_inertia(*part, reach)

    def track_errors(self, shoe: Shoe, chain: Track) -> Errors:
        """Yield an error for each property of rails and chain that does not fit the wheels of one track."""
        yield from self.single.track_errors(shoe, chain)


@lru_cache(maxsize=64)
def _single(machine: Machine) -> Closed:
    return Closed(**_values(machine))


def _values(track: Closed) -> dict[str, Any]:
    """Return the values of a closed track without its kind."""
    return {name: getattr(track, name) for name in Closed.model_fields if name != "kind"}
