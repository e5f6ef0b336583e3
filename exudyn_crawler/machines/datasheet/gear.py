"""Gear of a datasheet's machine: two closed tracks with wheels, parts, and contacts that fit both."""

import math
from functools import partial
from typing import NamedTuple

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.machine import Machine
from exudyn_crawler.case.parameters.car_body import CarBody
from exudyn_crawler.case.parameters.closed_track import Idler, Tumbler
from exudyn_crawler.case.parameters.track import Shoe, Track
from exudyn_crawler.machines.datasheet import rules, suspension, travel, weights, wheels
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.origins import Ruled
from exudyn_crawler.settings import fields

PLAY, FLANGE = 0.015, 0.076  # play and height of guides, pitches: those of the project's P&H 4100C
DAMPED_DEPTH = 1.5e-4  # depth of full contact damping, pitches: that of the P&H 4100C
TREAD_DAMPING, GUIDE_DAMPING = 0.1, 0.73  # fractions of critical damping: those of the P&H 4100C
GUIDES = 0.1  # stiffness of the flanges over that of a tread
SOFT = 0.1  # compliance of a pin across the chain over that of a tread
LAG = 0.1  # lag of the sprocket at 0.7 of its torque limit, fraction of its speed
LEAST_FRAME = 1e-3  # least mass of a side frame, fraction of the operating weight
WITHOUT_BUSHES = ("shovel", "vehicle")
"""Kinds of machines whose sprockets drive lugs of the shoes, not bushes about their front pins."""
FADING = 0.05  # speed at which rolling resistance has 0.7 of its value, fraction of the chain's speed


class Contacts(NamedTuple):
    """Stiffness (N/m) and damping (N s/m) of treads, teeth and flanges."""

    tread: float
    tread_damping: float
    tooth: float
    guide: float
    guide_damping: float


def gear_of(sheet: Datasheet, chain: Chain, shoe: Shoe, track: Track) -> tuple[Machine, dict[str, Ruled]]:
    """Return the gear of the machine, and values with several possible rules, with the rule of each.

    Raise `ParameterError` in the datasheet's terms if wheels or weights do not fit.
    """
    rails = shoe.roller_path
    pitch = chain.pitch
    place = wheels.wheels_of(sheet, chain, rails.height - track.pin_height)
    typical = pitch**3 * sheet.typical_value("sprocket_mass")
    # typical weights are those of sprockets with more gaps than some have
    sprocket = min(typical, rules.solid_wheel(place.pins))
    axes = place.roller_radius + rails.height + shoe.com_height
    springs = suspension.springs_of(sheet, chain, shoe.mass, place)
    beside = sprocket, springs.mass
    parts = weights.weights_of(sheet, chain, shoe.mass, beside, axes)
    contacts = _contacts(sheet, chain, shoe, len(place.rollers))
    speed = travel.run_speed(sheet)
    bogies = suspension.bogies_of(sheet, pitch, place.rollers)
    radius = chain.built_gaps * pitch / (2.0 * math.pi)
    _check_frame(sheet, chain, shoe, parts, sum(bogie.mass for bogie in bogies))
    tumbler = _tumbler(sheet, chain, track, place, sprocket, contacts)
    flanks = Ruled(tumbler.reach, "" if tumbler.reach == place.reach else "flanks")
    mass = Ruled(sprocket, "solid" if sprocket < typical else "")
    ruled = {
        "track.pin.kind": Ruled(track.pin.kind, track.pin.kind),
        "gear.tumbler.reach": flanks,
        "gear.tumbler.mass": mass,
        "gear.tumbler.lugs": Ruled(tumbler.lugs, "bushes" if tumbler.lugs else ""),
        **place.ruled,
        **parts.ruled,
    }
    gear = Machine(
        mass=parts.frame - sum(bogie.mass for bogie in bogies),
        inertia=parts.frame_inertia,
        com=parts.frame_com,
        tumbler=tumbler,
        idler=_idler(sheet, pitch, place, springs),
        rollers=place.rollers,
        bogies=bogies,
        arms=springs.arms,
        roller_radius=place.roller_radius,
        carriers=place.carriers,
        carrier_radius=place.carrier_radius,
        tread_width=rails.width * sheet.typical_value("tread_width"),
        stiffness=contacts.tread,
        damping=contacts.tread_damping,
        damping_depth=DAMPED_DEPTH * pitch,
        rolling_resistance=sheet.typical_value("rolling_resistance"),
        resistance_speed=FADING * speed,
        guide_play=PLAY * pitch,
        guide_height=FLANGE * pitch,
        guide_stiffness=contacts.guide,
        guide_damping=contacts.guide_damping,
        compliance=SOFT / contacts.tread,
        torque_limit=_torque(sheet, radius),
        torque_speed=LAG * speed / radius,
        car_body=_car_body(sheet, parts),
    )
    return gear, ruled


def _check_frame(
    sheet: Datasheet, chain: Chain, shoe: Shoe, parts: weights.PartWeights, bogies: float
) -> None:
    """Raise `DatasheetError` if the other parts leave no mass for a side frame beside its bogies (kg)."""
    frame = parts.frame - bogies
    if frame >= LEAST_FRAME * sheet.operating_weight:
        return
    text = partial(fields.quantity_text, unit="kg")
    of_track = f"{chain.shoes} shoes of {text(shoe.mass)}" + (f", bogies of {text(bogies)}" if bogies else "")
    raise DatasheetError(
        f"a side frame would weigh {text(frame)}: {of_track} on each track, a car body of {text(parts.body)} "
        f"and an upper structure of {text(parts.upper)} leave no more of operating_weight "
        f"{text(sheet.operating_weight)}; lighter or fewer shoes, or another weight"
    )


def _contacts(sheet: Datasheet, chain: Chain, shoe: Shoe, rollers: int) -> Contacts:
    """Return contacts as deep, in pitches, as those of the P&H 4100C under weight and pull.

    Stiffer contacts would need shorter steps: the oscillation of a shoe takes as many steps as on that
    machine.
    """
    pitch = chain.pitch
    weight = sheet.operating_weight * ph4100c.GRAVITY
    # two treads per roller, two tracks
    tread = 0.25 * weight / rollers / (pitch * sheet.typical_value("tread_depth"))
    pull = sheet.drawbar_pull or weight * sheet.typical_value("pull_share")
    # two sides per sprocket, two tracks
    tooth = 0.25 * pull / (pitch * sheet.typical_value("contact_depth"))
    guide = GUIDES * tread
    return Contacts(
        tread,
        TREAD_DAMPING * math.sqrt(2.0 * tread * shoe.mass),
        tooth,
        guide,
        2.0 * GUIDE_DAMPING * math.sqrt(guide * shoe.mass),
    )


def _tumbler(
    sheet: Datasheet,
    chain: Chain,
    track: Track,
    place: wheels.WheelPlaces,
    mass: float,
    contacts: Contacts,
) -> Tumbler:
    """Return the sprocket; its teeth end no later than their flanks meet."""
    inertia = (*rules.ring_inertia(mass, place.pins).tolist(), 0.0, 0.0, 0.0)
    tumbler = Tumbler(
        place=place.sprocket,
        teeth=chain.teeth,
        gaps_per_shoe=chain.gaps_per_shoe,
        mass=mass,
        inertia=inertia,
        reach=place.reach,
        flank=sheet.typical_value("flank"),
        lug_radius=place.bush,
        lugs=() if sheet.kind in WITHOUT_BUSHES else ((track.pin_ahead, track.pin_height),),
        stiffness=contacts.tooth,
        damping=contacts.tread_damping,
        damping_depth=DAMPED_DEPTH * chain.pitch,
    )
    longest = tumbler.longest_reach(track)
    return tumbler if math.isclose(longest, place.reach) else tumbler.with_(reach=longest)


def _idler(sheet: Datasheet, pitch: float, place: wheels.WheelPlaces, springs: suspension.Springs) -> Idler:
    """Return the idler with the maker's chain tension."""
    way = pitch * sheet.typical_value("take_up")
    return Idler(
        place=place.idler,
        radius=place.idler_radius,
        range=(-way, way),
        sag=sheet.sag,
        pretension=sheet.chain_tension,
        recoil=springs.recoil,
    )


def _torque(sheet: Datasheet, radius: float) -> float | None:
    """Return the greatest torque of a sprocket, N m: by pull or motor; None if neither is printed."""
    if sheet.drawbar_pull is None:
        if sheet.motor_torque is None or sheet.gear_ratio is None:
            return None
        return sheet.motor_torque * sheet.gear_ratio
    return rules.sprocket_torque(sheet.drawbar_pull, radius, sheet.typical_value("chain_efficiency"))


def _car_body(sheet: Datasheet, parts: weights.PartWeights) -> CarBody:
    return CarBody(
        gauge=sheet.track_gauge,
        mass=parts.body,
        inertia=parts.body_inertia,
        com=parts.body_com,
        upper_mass=parts.upper,
        upper_inertia=parts.upper_inertia,
        upper_com=parts.upper_com,
    )
