"""What a machine does on the side frame of one track over time: force and moment beside its weight."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple, Self

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import Name, Parameters, StepProfile, quantity
from exudyn_crawler.case.parameters.undercarriage import Undercarriage

Component = Annotated[float, Ge(-1e12), Le(1e12)]
"""Component of a force or a moment, N or N m."""
Vector = tuple[Component, Component, Component]


class MachinePhase(Parameters):
    """Part of a machine's cycle: force and moment on the side frame at its end."""

    name: Name = Field(description="name of the phase")
    end: float = quantity("s", "time at which the phase ends", ge=0, le=1e9)
    force: Vector = quantity("N", "force at the frame's origin beside the frame's weight, global")
    moment: Vector = quantity("N m", "moment about the frame's origin, global")


class Pose(NamedTuple):
    """Upper structure of a shovel at the end of a phase.

    Attributes
    ----------
    name : str
    end : float
        s.
    swing : float
        rad, of the dipper from straight ahead to the left.
    reach, height : float
        Of the dipper from the swing axis and above the rollers' axes, m.
    payload : float
        kg in the dipper.
    bank : tuple of float
        Force of the bank on the dipper away from the machine and up, N.
    """

    name: str
    end: float
    swing: float
    reach: float
    height: float
    payload: float
    bank: tuple[float, float] = (0.0, 0.0)


class Shovel(NamedTuple):
    """Masses (kg) of a shovel and their places: m from the swing axis and above the rollers' axes.

    The rest of the whole stands on the swing axis at the height of the lower works.
    """

    mass: float = ph4100c.SHOVEL["mass"]
    upper: float = ph4100c.SHOVEL["upper"]
    upper_place: tuple[float, float] = ph4100c.SHOVEL["upper_place"]
    front: float = ph4100c.SHOVEL["front"]
    lower_height: float = ph4100c.SHOVEL["lower_height"]


class MachineCycle(Parameters):
    """Force and moment of the machine on one side frame, in phases whose ends are joined by cubic STEPs."""

    phases: Annotated[tuple[MachinePhase, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _check(self) -> Self:
        ends = [phase.end for phase in self.phases]
        if np.any(np.diff(ends) <= 0.0):
            raise ValueError(f"the phases' ends must increase, got {ends}")
        return self

    @classmethod
    def shovel(
        cls,
        frame: Undercarriage | None = None,
        poses: Sequence[Pose] = tuple(Pose(*one) for one in ph4100c.SHOVEL_POSES),
        shovel: Shovel | None = None,
        side: float = 1.0,
        down: Sequence[float] = (0.0, 0.0, -1.0),
    ) -> Self:
        """Cycle of a rope shovel from its weights and what its dipper meets.

        Statics gives this track its share: the resultant of all forces, at y from the middle between the
        tracks, rests on both in the ratio of their distances. Along x each share stands where the whole does.
        The lateral moment that is left is the pair of both tracks' forces: none of it is on the side frame.

        Parameters
        ----------
        frame : Undercarriage, optional
            Side frame, of whose weight the machine's share is taken off; that of the P&H 4100C if None.
        poses : sequence of Pose
            At the ends of the phases.
        shovel : Shovel, optional
            Masses; those of the P&H 4100C if None.
        side : float
            1 where the track is the left one, -1 for the right one.
        down : array (3,)
            Direction of gravity, as of `Terrain.down`.

        Raises
        ------
        ValueError
            If the machine tips over a track.
        """
        own = Undercarriage.ph4100c() if frame is None else frame
        masses = Shovel() if shovel is None else shovel
        phases = []
        for pose in poses:
            forces, places = _loads(masses, pose, np.asarray(down, dtype=float))
            whole, moment = forces.sum(axis=0), np.cross(places, forces).sum(axis=0)
            aside = moment[0] / whole[2]
            share = 0.5 + side * aside / ph4100c.TRACK_DISTANCE
            if not 0.0 <= share <= 1.0:
                raise ValueError(
                    f"the machine tips sideways at the end of {pose.name!r}: its weight acts {aside:.3g} m "
                    f"beside the middle, its tracks stand {0.5 * ph4100c.TRACK_DISTANCE:.3g} m beside it"
                )
            weight = own.mass * ph4100c.GRAVITY * np.asarray(down, dtype=float)
            force = share * whole - weight
            turn = share * moment[1] - np.cross(own.com, weight)[1]
            phases.append(
                MachinePhase(
                    name=pose.name, end=pose.end, force=tuple(force.tolist()), moment=(0.0, float(turn), 0.0)
                )
            )
        return cls(phases=tuple(phases))

    def wrench(self, time: ArrayLike) -> tuple[NDArray, NDArray]:
        """Force (N) and moment (N m) at each time (s): array (times, 3) each."""
        t, ends = np.atleast_1d(np.asarray(time, dtype=float)), tuple(phase.end for phase in self.phases)
        columns = [
            StepProfile(times=ends, values=tuple(getattr(phase, kind)[axis] for phase in self.phases)).value(
                t
            )
            for kind in ("force", "moment")
            for axis in range(3)
        ]
        both = np.column_stack(columns)
        return both[:, :3], both[:, 3:]

    def check_balance(self, frame: Undercarriage, gravity: NDArray) -> None:
        """Refuse a cycle in which a roller would have to pull.

        Between the ends of phases force and moment are means of those at the ends, so that these tell.

        Parameters
        ----------
        gravity : array (3,)
            m/s2.

        Raises
        ------
        ValueError
            Naming the phase and where the machine's weight acts.
        """
        weight = frame.mass * gravity
        for phase in self.phases:
            force = np.array(phase.force) + weight
            moment = np.array(phase.moment) + np.cross(frame.com, weight)
            if force[2] >= 0.0:
                raise ValueError(f"machine: at the end of {phase.name!r} it lifts the side frame")
            x, y = moment[1] / -force[2], -moment[0] / -force[2]
            rear, front = frame.rollers[0], frame.rollers[-1]
            if not rear <= x <= front:
                raise ValueError(
                    f"machine: at the end of {phase.name!r} its weight acts at x = {x:.3g} m, the rollers "
                    f"stand from {rear:g} to {front:g} m: it tips"
                )
            if abs(y) > TIPPING:
                raise ValueError(
                    f"machine: at the end of {phase.name!r} its weight acts {y:.3g} m beside the middle of "
                    f"the track, more than {TIPPING} m: the side frame tips"
                )


TIPPING = 0.24
"""m, from the middle of the track to that of a rail of the P&H 4100C."""


def _loads(shovel: Shovel, pose: Pose, down: NDArray) -> tuple[NDArray, NDArray]:
    """Forces on the machine (N) and their places from the swing axis at the rollers (m): (k, 3) each."""
    ahead = np.array([math.cos(pose.swing), math.sin(pose.swing), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    back, height = shovel.upper_place
    dipper = pose.reach * ahead + pose.height * up
    lower = shovel.mass - shovel.upper - shovel.front
    weights = [(lower, shovel.lower_height * up), (shovel.upper, back * ahead + height * up)]
    weights += [(shovel.front + pose.payload, dipper)]
    forces = [mass * ph4100c.GRAVITY * down for mass, _ in weights]
    forces.append(pose.bank[0] * ahead + pose.bank[1] * up)
    return np.array(forces), np.array([*(place for _, place in weights), dipper])
