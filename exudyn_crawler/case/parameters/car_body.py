"""Rigid parts of a machine: car body and upper structure on two tracks."""

import math
from typing import NamedTuple

import numpy as np
from pydantic import AliasChoices

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import base
from exudyn_crawler.case.parameters.base import Place
from exudyn_crawler.settings.parameters import quantity


class Part(NamedTuple):
    """Rigid part of a body."""

    mass: float  # kg
    com: np.ndarray  # (3,), m, in the body's axes
    inertia: np.ndarray  # (3, 3): tensor about its COM, kg m2


class CarBody(base.PH4100C, values=ph4100c.CAR_BODY):
    """Machine on two closed tracks: its car body, which both side frames are fixed to, and upper structure.

    The machine is one rigid body: the upper structure is fixed at its slew angle. Places are in the machine's
    axes: x along the travel, y to the left, z up. Their origin is in the middle between the tracks at the
    height of the lower rollers' axes. Track 1 is the right one; `track.first_com` gives its middle.
    """

    gauge: base.Length = quantity(
        "m",
        "distance between the middles of both tracks",
        (1.0, 20.0),
        validation_alias=AliasChoices("gauge", "track_distance"),  # the second: files of earlier versions
    )
    mass: base.Mass = quantity("kg", "mass of the car body without side frames", (1e2, 1e6))
    inertia: base.Inertia = quantity(
        "kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of the car body about its COM (tensor)"
    )
    com: base.Three = quantity("m", "COM of the car body", (-10.0, 10.0))
    upper_mass: base.Mass = quantity("kg", "mass of the upper structure with dipper", (1e2, 2e6))
    upper_inertia: base.Inertia = quantity(
        "kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of the upper structure about its COM, at slew 0 (tensor)"
    )
    upper_com: base.Three = quantity("m", "COM of the upper structure, at slew 0", (-20.0, 20.0))
    swing_axis: Place = quantity("m", "x of the upper structure's swing axis", (-5.0, 5.0), default=0.0)
    slew: float = quantity(
        "rad",
        "slewing angle of the upper structure, positive to the left",
        (-3.2, 3.2),
        ge=-10,
        le=10,
        default=0.0,
    )

    @property
    def middles(self) -> tuple[float, float]:
        """Lateral positions y of the tracks' middles, right and left, m."""
        return -0.5 * self.gauge, 0.5 * self.gauge

    def upper_at(self, angle: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the upper structure's COM (3,), m, and inertia tensor, kg m2, at a slewing angle (rad)."""
        c = math.cos(angle)
        s = math.sin(angle)
        axis = np.array([self.swing_axis, 0.0, 0.0])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        inertia = turn @ base.inertia_tensor(self.upper_inertia) @ turn.T
        return axis + turn @ (np.array(self.upper_com) - axis), inertia

    def parts(self, side_frame: Part) -> list[Part]:
        """Return the rigid parts of the machine; `side_frame` is the right side frame in its own axes."""
        com, inertia = self.upper_at(self.slew)
        mirror = np.diag([1.0, -1.0, 1.0])
        right, left = (np.array([0.0, y, 0.0]) for y in self.middles)
        return [
            Part(side_frame.mass, right + side_frame.com, side_frame.inertia),
            Part(side_frame.mass, left + mirror @ side_frame.com, mirror @ side_frame.inertia @ mirror),
            Part(self.mass, np.array(self.com), base.inertia_tensor(self.inertia)),
            Part(self.upper_mass, com, inertia),
        ]
