"""The chain of shoes on the ground."""

from typing import Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import FAR, Parameters, Place, quantity

MOST_SHOES = 1000
SIDES = ("right", "left")
"""Pins of a link: the spherical joint (right) and the parallel-axes joint (left)."""


class Track(Parameters):
    """Open chain of equal shoes, linked by pins along y; shoe 1 is the rearmost, the last the front.

    Every link is one frictionless hinge without redundant equations: a spherical joint at one pin and
    an axis kept parallel at the other.
    """

    shoe_count: int = quantity("1", "number of shoes", plausible=(2, 60), ge=2, le=MOST_SHOES)
    first_com: tuple[Place, Place] = quantity("m", "x and y of the COM of shoe 1 at t = 0")
    pitch: float = quantity(
        "m", "distance of the COMs of neighbours in x", plausible=(0.1, 2.0), ge=1e-3, le=100
    )
    pin_ahead: float = quantity(
        "m", "x of the front pins ahead of the COM", plausible=(0.02, 2.0), ge=1e-3, le=100
    )
    pin_height: float = quantity("m", "z of the pins above the COM", plausible=(-1.0, 1.0), ge=-100, le=100)
    spherical_y: float = quantity("m", "y of the spherical joints, global, at t = 0", ge=-FAR, le=FAR)
    parallel_y: float = quantity("m", "y of the parallel-axes joints, global, at t = 0", ge=-FAR, le=FAR)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.pin_ahead >= self.pitch:
            raise ValueError(f"pin_ahead must be less than the pitch {self.pitch}, got {self.pin_ahead}")
        return self

    @classmethod
    def ph4100c(cls) -> Self:
        """Track of the P&H 4100C BOSS (K-chapter and K-paper, tables of COMs and joints)."""
        return cls(**ph4100c.TRACK)

    def check_shoe(self, shoe: int) -> None:
        """Refuse a number that is of no shoe.

        Raises
        ------
        ValueError
        """
        if shoe not in self.shoes:
            raise ValueError(f"shoe must be in 1..{self.shoe_count}, got {shoe}")

    @property
    def shoes(self) -> NDArray:
        """Shoe numbers 1..n, rear to front."""
        return np.arange(1, self.shoe_count + 1)

    @property
    def joints(self) -> NDArray:
        """Link numbers 1..n-1; link i joins shoes i and i+1."""
        return np.arange(1, self.shoe_count)

    def com_positions(self, com_height: float) -> NDArray:
        """COMs at t = 0 with the undersides at z = 0: array (shoes, 3), m, global."""
        positions = np.empty((self.shoe_count, 3))
        positions[:, 0] = self.first_com[0] + self.pitch * np.arange(self.shoe_count)
        positions[:, 1] = self.first_com[1]
        positions[:, 2] = com_height
        return positions

    @property
    def front_pin(self) -> NDArray:
        """Spherical joint at the front of a shoe, in its frame: array (3,), m."""
        return np.array([self.pin_ahead, self.spherical_y - self.first_com[1], self.pin_height])

    @property
    def rear_pin(self) -> NDArray:
        """Spherical joint at the rear of a shoe, in its frame: array (3,), m."""
        return self.front_pin - np.array([self.pitch, 0.0, 0.0])

    @property
    def joint_centers(self) -> dict[str, NDArray]:
        """Joint centres of a shoe in its frame, m: "front right", "front left", "rear right", "rear left"."""
        across = np.array([0.0, self.parallel_y - self.spherical_y, 0.0])
        return {
            f"{end} {side}": pin + number * across
            for end, pin in (("front", self.front_pin), ("rear", self.rear_pin))
            for number, side in enumerate(SIDES)
        }
