"""Suspension in a datasheet's side frame: bogies, arms of road wheels, recoil spring of the idler."""

import math
from typing import NamedTuple

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.arms import Arm
from exudyn_crawler.case.gear.running_gear import Bogie
from exudyn_crawler.case.parameters.closed_track import Recoil
from exudyn_crawler.machines.datasheet import rules
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet, DatasheetError, Kind
from exudyn_crawler.machines.datasheet.wheels import WheelPlaces

RECOILS: tuple[Kind, ...] = ("excavator", "dozer", "loader", "drill", "paver")
"""Kinds of machines with grease cylinders and recoil springs at the idlers; the others have shims."""
RECOIL_DAMPING = 0.1  # damping of an idler on its spring, fraction of critical (assumed)
WHEEL_INERTIA = 0.15, 0.13, 0.25
"""Inertia of an arm with its freely spinning wheel over mass and wheel radius squared (M113)."""
COM = 0.66
"""COM of an arm with its wheel, fraction of the way from pivot to axis: arms and wheels of M113 and Marder
weigh 75 and 36 kg."""
BUMP = 10.0  # stiffness of bump stops over that of the spring (assumed)


class Springs(NamedTuple):
    """Sprung parts of one track; their weight is separate from the side frame's."""

    arms: tuple[Arm, ...]
    recoil: Recoil | None

    @property
    def mass(self) -> float:
        """Mass of all sprung parts, kg."""
        return sum(arm.mass for arm in self.arms) + (0.0 if self.recoil is None else self.recoil.mass)


def springs_of(sheet: Datasheet, chain: Chain, shoe: float, place: WheelPlaces) -> Springs:
    """Return arms and recoil spring of a track with shoes of the mass `shoe`, kg."""
    return Springs(_arms(sheet, chain, shoe, place), _recoil(sheet, chain.pitch))


def bogies_of(sheet: Datasheet, pitch: float, rollers: tuple[float, ...]) -> tuple[Bogie, ...]:
    """Return bogies with two lower rollers each, from the front; the side frame's weight includes them."""
    if not sheet.bogies:
        return ()
    if 2 * sheet.bogies > len(rollers):
        raise DatasheetError(
            f"{sheet.bogies} bogies take {2 * sheet.bogies} lower rollers, a track has {len(rollers)}: "
            f"{len(rollers) // 2} bogies do"
        )
    mass = pitch**3 * sheet.typical_value("bogie_mass")
    height = pitch * sheet.typical_value("bogie_pivot")
    bogies = []
    for number in range(len(rollers) + 1 - 2 * sheet.bogies, len(rollers), 2):
        rear, front = rollers[number - 1 : number + 1]
        inertia = rules.box_inertia(mass, front - rear + pitch, pitch, pitch).tolist()
        pivot = 0.5 * (rear + front), height
        bogies.append(
            Bogie(rollers=(number, number + 1), pivot=pivot, mass=mass, inertia=(*inertia, 0.0, 0.0, 0.0))
        )
    return tuple(bogies)


def _recoil(sheet: Datasheet, pitch: float) -> Recoil | None:
    """Return the recoil spring; None if shims hold the idler."""
    has = sheet.kind in RECOILS if sheet.recoil_spring is None else sheet.recoil_spring
    if not (has or sheet.recoil_force is not None):
        return None
    force = sheet.recoil_force
    if force is None:
        force = sheet.operating_weight * ph4100c.GRAVITY * sheet.typical_value("recoil_force")
    stiffness = force / (pitch * sheet.typical_value("recoil_pressed"))
    mass = pitch**3 * sheet.typical_value("idler_mass")
    return Recoil(
        mass=mass,
        preload=force,
        stiffness=stiffness,
        damping=2.0 * RECOIL_DAMPING * math.sqrt(stiffness * mass),
        stroke=pitch * sheet.typical_value("recoil_stroke"),
    )


def _arms(sheet: Datasheet, chain: Chain, shoe: float, place: WheelPlaces) -> tuple[Arm, ...]:
    """Return the arms of the road wheels; empty if the wheels are fixed in the frame."""
    if not sheet.has_arms:
        return ()
    if sheet.bogies:
        raise DatasheetError(f"{sheet.bogies} bogies must be left out with suspension 'arms'")
    rollers = place.rollers
    diameter = 2.0 * place.roller_radius
    if sheet.arm_pivot is None:
        reach = diameter * sheet.typical_value("arm_reach")
        rise = diameter * sheet.typical_value("arm_rise")
    else:
        reach, rise = sheet.arm_pivot
    mass = sheet.arm_weight or diameter**3 * sheet.typical_value("arm_mass")
    sprung = _sprung(sheet, chain, shoe, len(rollers), mass)
    lever = abs(reach)
    torque = (sprung + COM * mass) * ph4100c.GRAVITY * lever
    stiffness = sheet.torsion_bar or torque * sheet.typical_value("arm_stiffness")
    damping = sheet.arm_damping
    if damping is None:
        critical = 2.0 * lever * math.sqrt(stiffness * sprung)
        damping = critical * sheet.typical_value("arm_damping")
    stop = sheet.typical_value("arm_stop")
    # the case has its tumbler at the rear; a machine with its sprocket in front is reversed in it
    ahead = reach if sheet.sprocket == "rear" else -reach
    x_inertia, y_inertia, z_inertia = (share * mass * place.roller_radius**2 for share in WHEEL_INERTIA)
    return tuple(
        Arm(
            roller=number,
            pivot=(x + ahead, rise),
            mass=mass,
            com=(-COM * ahead, -COM * rise),
            inertia=(x_inertia, y_inertia, z_inertia, 0.0, 0.0, 0.0),
            torque=torque,
            stiffness=stiffness,
            damping=damping,
            stop=stop,
            stop_stiffness=BUMP * stiffness,
        )
        for number, x in enumerate(rollers, start=1)
    )


def _sprung(sheet: Datasheet, chain: Chain, shoe: float, wheels: int, arm: float) -> float:
    """Return the mass on an arm, kg: even shares of all but arms and grounded shoes."""
    span = sheet.length_on_ground or chain.on_ground
    on_ground = 2.0 * (1.0 + span / chain.pitch) * shoe
    sprung = (sheet.operating_weight - on_ground) / (2.0 * wheels) - arm
    if sprung <= 0.0:
        raise DatasheetError(
            f"{2 * wheels} arms of {arm:.4g} kg and the shoes on the ground weigh more than the operating "
            f"weight of {1e-3 * sheet.operating_weight:.4g} t"
        )
    return sprung
