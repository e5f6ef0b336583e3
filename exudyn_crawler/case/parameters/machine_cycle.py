"""Load cycle of a machine: force and moment on its side frame, without the weight, in phases over time."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol, Self

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import base, drive, loads
from exudyn_crawler.case.parameters.car_body import CarBody, Part
from exudyn_crawler.settings.parameters import Errors, Several, quantity


class MachinePhase(loads.PhaseEnd):
    """Part of a machine's cycle: force and moment on the side frame at its end."""

    force: base.Vector = quantity(
        "N", "force at the frame's origin in addition to the frame's weight, global"
    )
    moment: base.Vector = quantity("N m", "moment about the frame's origin, global")


class Pose(NamedTuple):
    """Pose of a shovel's upper structure at the end of a phase; the dipper's place is from the swing axis."""

    name: str
    end: float  # s
    swing: float  # rad, from straight ahead to the left
    reach: float  # m
    height: float  # m above the rollers' axes
    payload: float  # kg
    bank: tuple[float, float] = (0.0, 0.0)  # N, force of the bank on the dipper, outward and up

    def turned(self, ahead: float, up: float) -> np.ndarray:
        """Return the vector with components ahead of the upper structure and up: array (3,)."""
        return np.array([ahead * math.cos(self.swing), ahead * math.sin(self.swing), up])


class Weighed(Protocol):
    """Body with a mass (kg) and a COM (m), such as a side frame."""

    @property
    def mass(self) -> float:
        """Mass, kg."""

    @property
    def com(self) -> Sequence[float] | np.ndarray:
        """COM in the body's axes: (3,), m."""


PH4100C_FRAME = Part(
    ph4100c.UNDERCARRIAGE["mass"],
    np.array(ph4100c.UNDERCARRIAGE["com"]),
    base.inertia_tensor(ph4100c.UNDERCARRIAGE["inertia"]),
)
"""Side frame of the P&H 4100C BOSS with half of the machine."""


class MachineCycle(loads.Cycle):
    """Force and moment of the machine on one side frame, in phases whose ends are joined by cubic STEPs."""

    phases: Several[MachinePhase]

    @classmethod
    def shovel(
        cls,
        frame: Weighed = PH4100C_FRAME,
        poses: Sequence[Pose] = tuple(Pose(*row) for row in ph4100c.SHOVEL_POSES),
        shovel: Mapping[str, Any] = ph4100c.SHOVEL,
        side: float = 1.0,
        down: Sequence[float] = (0.0, 0.0, -1.0),
    ) -> Self:
        """Return the cycle of a rope shovel from its weights and the forces on its dipper.

        Statics gives the share of this track. The resultant of all forces acts at y from the middle between
        the tracks, and both tracks carry it by the lever rule. Along x each share acts at the place of the
        whole. The pair of both tracks' forces balances the lateral moment; none of it acts on the side frame.

        The share is reduced by the weight of the side frame. Poses are at the ends of the phases; masses and
        places of the `shovel` are as in `ph4100c.SHOVEL`. `side` is 1 on the left track and -1 on the right
        one; `down` is as in `Terrain.down`. Raises `ValueError` if the machine tips over a track.
        """
        gravity = np.asarray(down, dtype=float)
        phases = []
        for pose in poses:
            forces, places = _loads(shovel, pose, gravity)
            whole = forces.sum(axis=0)
            moment = np.cross(places, forces).sum(axis=0)
            aside = moment[0] / whole[2]
            share = 0.5 + side * aside / ph4100c.GAUGE
            if not 0.0 <= share <= 1.0:
                acts = f"its weight acts {aside:.3g} m beside the middle"
                raise ValueError(f"the machine tips sideways at the end of {pose.name!r}: {acts}")
            weight = frame.mass * ph4100c.GRAVITY * gravity
            force = tuple((share * whole - weight).tolist())
            turn = float(share * moment[1] - np.cross(frame.com, weight)[1])
            phases.append(MachinePhase(name=pose.name, end=pose.end, force=force, moment=(0.0, turn, 0.0)))
        return cls(phases=tuple(phases))

    @classmethod
    def slewing(
        cls,
        body: CarBody | None = None,
        poses: Sequence[Pose] = tuple(Pose(*row) for row in ph4100c.SHOVEL_POSES),
        down: Sequence[float] = (0.0, 0.0, -1.0),
    ) -> Self:
        """Return the cycle of a standing machine on two tracks, from slewing and the load on its dipper.

        Poses give the dipper's payload and the force of the bank; the upper structure's weight follows their
        swing. Neglected are the shift of the front's weight with the dipper's reach, and the angular momentum
        of slewing. `body` has the upper structure, by default that of the P&H 4100C, which slews from `slew`.
        For poses and `down` see `shovel`.
        """
        body = body or CarBody.ph4100c()
        gravity = ph4100c.GRAVITY * np.asarray(down, dtype=float)
        rest, _ = body.upper_at(body.slew)
        phases = []
        for pose in poses:
            dipper = np.array([body.swing_axis, 0.0, 0.0]) + pose.turned(pose.reach, pose.height)
            force = pose.payload * gravity + pose.turned(*pose.bank)
            moved = body.upper_at(pose.swing)[0] - rest
            moment = np.cross(dipper, force) + np.cross(moved, body.upper_mass * gravity)
            named = {"force": tuple(force.tolist()), "moment": tuple(moment.tolist())}
            phases.append(MachinePhase(name=pose.name, end=pose.end, **named))
        return cls(phases=tuple(phases))

    @classmethod
    def digging(cls, body: CarBody, down: Sequence[float] = (0.0, 0.0, -1.0)) -> Self:
        """Return the cycle of a standing machine of any size: dig, swing, dump and return.

        No source. The poses of the P&H 4100C without propel are scaled by the ratio of the upper structures'
        masses: payload and bank by the ratio, lengths by its third root. Times are the same.
        """
        ratio = body.upper_mass / CarBody.ph4100c().upper_mass
        length = ratio ** (1.0 / 3.0)
        poses = [
            pose._replace(
                end=pose.end - ph4100c.PROPEL_END,
                reach=length * pose.reach,
                height=length * pose.height,
                payload=ratio * pose.payload,
                bank=(ratio * pose.bank[0], ratio * pose.bank[1]),
            )
            for pose in (Pose(*row) for row in ph4100c.SHOVEL_POSES)
            if pose.end > ph4100c.PROPEL_END
        ]
        return cls.slewing(body, poses, down)

    @property
    def components(self) -> list[drive.StepProfile]:
        """Components x, y and z of force (N) and moment (N m) over time (s), global."""
        return self.profiles((*phase.force, *phase.moment) for phase in self.phases)

    def wrench(self, time: np.typing.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return force (N) and moment (N m) at each time (s): array (times, 3) each."""
        wrenches = loads.values_of(self.components, time)
        return wrenches[:, :3], wrenches[:, 3:]

    def balance_errors(
        self, parts: Sequence[Part], rollers: Sequence[float], aside: float, gravity: np.ndarray
    ) -> Errors:
        """Yield an error for each phase in which a roller would have to pull on the rail.

        Only the ends of phases are checked, because they have the extremes. `parts` are those of the side
        frame, or of the machine, on `rollers` (x, m). The body tips if its weight acts more than `aside` (m)
        beside the middle. `gravity` is (3,), m/s2. Shoes are not parts: the chain on the ground holds no
        roller down.
        """
        weight = sum(part.mass for part in parts) * gravity
        rear = rollers[0]
        front = rollers[-1]
        turned = sum(np.cross(part.com, part.mass * gravity) for part in parts)
        for phase in self.phases:
            force = np.array(phase.force) + weight
            moment = np.array(phase.moment) + turned
            pose_end = f"machine: at the end of {phase.name!r} it"
            if force[2] >= 0.0:
                yield f"{pose_end} lifts the side frame"
            x, y = moment[1] / -force[2], -moment[0] / -force[2]
            if not rear <= x <= front:
                span = f"rollers are from {rear:.4g} to {front:.4g} m"
                carried = f"what they carry, {-force[2]:.4g} N without the chain on the ground,"
                yield f"{pose_end} tips: {span}, {carried} acts at x = {x:.3g} m"
            if abs(y) > aside:
                beside = f"{y:.3g} m beside the middle of the track, more than {aside:.4g} m"
                yield f"{pose_end}s weight acts {beside}: the side frame tips"


def _loads(shovel: Mapping[str, Any], pose: Pose, down: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the forces on the machine (N) and their places (m): array (k, 3) each.

    Places are from the swing axis, at the height of the rollers' axes.
    """
    dipper = pose.turned(pose.reach, pose.height)
    places = pose.turned(0.0, shovel["lower_height"]), pose.turned(*shovel["upper_place"]), dipper, dipper
    upper = shovel["upper"]
    front = shovel["front"]
    masses = shovel["mass"] - upper - front, upper, front + pose.payload
    forces = [*(mass * ph4100c.GRAVITY * down for mass in masses), pose.turned(*pose.bank)]
    return np.array(forces), np.array(places)
