"""Side frame of a track that it rolls over, and whether it fits that track."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import ArrayLike, NDArray
from pydantic import model_validator

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import Parameters, Place, quantity
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.case.parameters.shoe import Moment, Shoe
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case.parameters.track import Track

Roller = Annotated[float, Ge(-1e3), Le(1e3)]
"""Place of a roller along the frame, m."""


class Undercarriage(Parameters):
    """What rides on one track: the side frame with its share of the machine, and how it rolls on the shoes.

    Places are in the frame's own axes: x along the travel, y lateral, z up. Their origin lies at the height
    of the rollers' axes above the middle line of the track, at x = `start` at t = 0. The rollers are fixed in
    the frame, whose travel is the drive; heave, roll and pitch are free, y and yaw are held.
    """

    mass: float = quantity(
        "kg", "half of the machine without its shoes", plausible=(1e4, 2e6), ge=1.0, le=1e9
    )
    inertia: tuple[Moment, Moment, Moment, Moment, Moment, Moment] = quantity(
        "kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of this mass about its COM (tensor components)"
    )
    com: tuple[Place, Place, Place] = quantity("m", "its COM", plausible=(-10.0, 10.0))
    start: Place = quantity("m", "x of the frame's origin at t = 0, global")
    ends: tuple[Place, Place] = quantity("m", "x of the frame's rear and front end", plausible=(-20.0, 20.0))
    rollers: tuple[Roller, ...] = quantity("m", "x of the rollers' axes, rear to front", min_length=2)
    radius: float = quantity("m", "radius of the treads", plausible=(0.05, 1.5), ge=1e-2, le=100)
    tread_width: float = quantity(
        "m",
        "width of each tread; it stands in the middle of its rail",
        plausible=(0.02, 1.0),
        ge=1e-3,
        le=100,
    )
    strips: Literal[1, 2] = quantity(
        "1", "strips of a tread, which share its load as a tilted rail has it", default=2
    )
    stiffness: float = quantity(
        "N/m^exponent", "contact stiffness of a tread on a rail", plausible=(1e7, 1e12), ge=1.0, le=1e18
    )
    exponent: float = quantity("1", "exponent of the depth", plausible=(1.0, 1.6), ge=1, le=10, default=1.0)
    damping: float = quantity("N s/m", "greatest damping of a tread", plausible=(0.0, 1e8), ge=0, le=1e12)
    damping_depth: float = quantity(
        "m", "depth at which the damping is full", plausible=(1e-7, 1e-2), ge=1e-9, le=10
    )
    rolling_resistance: float = quantity(
        "1", "resistance of a roller over its normal force", plausible=(0.0, 0.2), ge=0, le=10
    )
    resistance_speed: float = quantity(
        "m/s",
        "travel at which the resistance has 0.7 of its value, nothing at rest",
        plausible=(1e-5, 0.1),
        ge=1e-9,
        le=100,
    )
    tumbler: Place = quantity("m", "x where the drive tumbler pulls the chain", plausible=(-20.0, 20.0))
    end_tension: float = quantity(
        "N", "pull on both ends of the chain", plausible=(0.0, 5e6), ge=0, le=1e10, default=0.0
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        principal = np.linalg.eigvalsh(self.inertia_tensor)
        if principal[0] <= 0.0 or principal[2] > principal[0] + principal[1]:
            raise ValueError(f"inertia must be that of a body, got principal moments {principal.tolist()}")
        rear, front = self.ends
        if front <= rear:
            raise ValueError(f"ends must be rear and front end in this order, got {self.ends}")
        apart = np.diff(self.rollers)
        if np.any(apart < 2.0 * self.radius):
            raise ValueError(
                f"rollers must stand in order and apart by their diameter {2.0 * self.radius:g} m at least, "
                f"got {list(self.rollers)}: they overlap"
            )
        outside = [x for x in self.rollers if not rear + self.radius <= x <= front - self.radius]
        if outside:
            raise ValueError(
                f"rollers must be within the frame, whose ends are at {rear:g} and {front:g} m, by their "
                f"radius {self.radius:g} m, got {outside}"
            )
        if not rear <= self.tumbler <= front:
            raise ValueError(f"tumbler must be within the frame's ends {self.ends}, got {self.tumbler}")
        return self

    @classmethod
    def ph4100c(cls) -> Self:
        """Undercarriage of one track of the P&H 4100C BOSS; `case.ph4100c` says what is open."""
        return cls(**ph4100c.UNDERCARRIAGE)

    @property
    def inertia_tensor(self) -> NDArray:
        """Inertia tensor about the COM: array (3, 3), kg m2."""
        xx, yy, zz, yz, xz, xy = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    @property
    def strip_places(self) -> NDArray:
        """Y of the strips' middles beside that of their tread: array (strips,), m.

        Two stand at the Gauss points, where they resist tilting as an evenly spread contact does.
        """
        points, _ = np.polynomial.legendre.leggauss(self.strips)
        return 0.5 * self.tread_width * points

    def shares_of_links(self, ahead: ArrayLike, links: int, pitch: float) -> NDArray:
        """Shares of the links in the pull of the tumbler, which change evenly between neighbours.

        Parameters
        ----------
        ahead : array (times,)
            x of the tumbler ahead of the pins of link 1, m.
        links : int
            Number of links.
        pitch : float
            Of the chain, m.

        Returns
        -------
        array (times, links)
        """
        place = np.asarray(ahead, dtype=float)[..., None] / pitch
        return np.clip(1.0 - np.abs(place - np.arange(links)), 0.0, None)


MARGIN = 4.0
"""m of ground ahead of the track."""
FEWEST_SHOES = 4
"""Two links that the tumbler pulls lie between them."""


def ground_below(track: Track, terrain: Terrain) -> Terrain:
    """Terrain with as many units along x as a track of any length needs."""
    end = track.first_com[0] + track.shoe_count * track.pitch + MARGIN
    return terrain.with_(columns=math.ceil((end - terrain.origin[0]) / terrain.unit_length))


def check_rolled(frame: Undercarriage, shoe: Shoe, track: Track, drive: Drive, loads: LoadCycle) -> None:
    """Refuse what does not go with a side frame.

    Raises
    ------
    ValueError
        Naming the field and what is allowed.
    """
    rails = shoe.rails
    if rails is None:
        raise ValueError("shoe.rails must be given with an undercarriage, which rolls on them")
    if frame.tread_width > rails.width:
        raise ValueError(
            f"undercarriage.tread_width must not exceed the rails' width {rails.width} m, "
            f"got {frame.tread_width}"
        )
    gap = track.pitch - (rails.front - rails.rear)
    if not 0.0 <= gap < 2.0 * frame.radius:
        raise ValueError(
            f"shoe.rails must leave a gap from shoe to shoe that rollers cross: none below 0 and less than "
            f"their diameter {2.0 * frame.radius:g} m, got {gap:.4g} m with the pitch {track.pitch}"
        )
    if track.shoe_count < FEWEST_SHOES:
        raise ValueError(
            f"track.shoe_count must be at least {FEWEST_SHOES} with an undercarriage, got {track.shoe_count}"
        )
    if drive.turn_rate is not None:
        raise ValueError("drive.turn_rate must be None with an undercarriage, whose yaw is held")
    if drive.on is not None:
        raise ValueError(
            "drive.on must be None with an undercarriage, which the drive moves or holds at all times; "
            "a speed of zero is a brake"
        )
    if any(load != 0.0 for phase in loads.phases for load in phase.loads):
        raise ValueError(
            "loads must be zero on every shoe with an undercarriage, whose rollers carry the machine"
        )


def check_length(frame: Undercarriage, track: Track, drive: Drive, duration: float) -> None:
    """Refuse a drive that takes rollers or tumbler off the track within `duration` (s).

    Raises
    ------
    ValueError
        With the time, the place and the track's extent.
    """
    first, last = track.first_com[0], track.first_com[0] + (track.shoe_count - 1) * track.pitch
    pins = first + track.pin_ahead, last - track.pitch + track.pin_ahead
    parts = (
        ("rear roller", frame.rollers[0], (first, last)),
        ("front roller", frame.rollers[-1], (first, last)),
        ("tumbler", frame.tumbler, pins),
    )
    for time in np.linspace(0.0, duration, 101 if duration > 0.0 else 1):
        travel = drive.travel(time)
        for name, place, (least, greatest) in parts:
            x = frame.start + travel + place
            if not least <= x <= greatest:
                raise ValueError(
                    f"track must be long enough for the drive: at t = {time:.3g} s the {name} is at "
                    f"x = {x:.4g} m, the shoes reach from {least:.4g} to {greatest:.4g} m; "
                    f"more shoes (track.shoe_count) or another undercarriage.start give it way"
                )
