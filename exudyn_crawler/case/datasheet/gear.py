"""Gear of a datasheet's machine: two closed tracks of its wheels, its parts, and contacts that fit both."""

import math
from functools import partial
from typing import NamedTuple

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.datasheet import rules, suspension, travel, weights, wheels
from exudyn_crawler.case.datasheet.chain import Chain
from exudyn_crawler.case.datasheet.notes import Notes
from exudyn_crawler.case.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.case.gear.machine import Machine
from exudyn_crawler.case.parameters import fields
from exudyn_crawler.case.parameters.car_body import CarBody
from exudyn_crawler.case.parameters.closed_track import Idler, Tumbler
from exudyn_crawler.case.parameters.track import Shoe, Track

PLAY, FLANGE = 0.015, 0.076  # pitches, of guides: those of the project's P&H 4100C
DAMPED_DEPTH = 1.5e-4  # pitches, at which a contact's damping is full: the same
TREAD_DAMPING, GUIDE_DAMPING = 0.1, 0.73  # of critical: the same
GUIDES = 0.1  # of a tread's stiffness: of the flanges
SOFT = 0.1  # of a tread's compliance: of a pin across the chain
LAG = 0.1  # of the sprocket's speed: how far it falls behind at 0.7 of its torque limit
LEAST_FRAME = 1e-3  # of the operating weight: a side frame
FADING = 0.05  # of the chain's speed: at which rolling resistance has 0.7 of its value
SCALED = (
    *("damping", "damping_depth", "resistance_speed", "guide_play", "guide_height", "guide_stiffness"),
    *("guide_damping", "compliance", "torque_speed", "tumbler.damping", "tumbler.damping_depth"),
)
"""Values of a gear that no datasheet and no source has."""


class Contacts(NamedTuple):
    """Stiffness (N/m) and damping (N s/m) of treads, teeth and flanges."""

    tread: float
    tread_damping: float
    tooth: float
    guide: float
    guide_damping: float


def gear_of(sheet: Datasheet, chain: Chain, shoe: Shoe, track: Track, notes: Notes) -> Machine:
    """Gear of the machine; a ParameterError in words of the datasheet where wheels or weights do not fit."""
    rails = shoe.rails
    assert rails is not None
    pitch = chain.pitch
    place = wheels.wheels_of(sheet, chain, rails.height - track.pin_height, notes)
    sprocket = notes.sized("gear.tumbler.mass", "sprocket_mass", pitch**3, "kg")
    axes = place.roller_radius + rails.height + shoe.com_height
    springs = suspension.springs_of(sheet, chain, shoe.mass, place, notes)
    beside = sprocket, springs.mass
    parts = weights.weights_of(sheet, chain, shoe.mass, beside, axes, notes)
    contacts = _contacts(sheet, chain, shoe, len(place.rollers), notes)
    speed = travel.run_speed(sheet, notes)
    resistance = notes.typical("rolling_resistance")
    notes.note(
        "gear.rolling_resistance", resistance, "", "assumed", "rolling_resistance of the typical values"
    )
    for path in SCALED:
        how = "that of the project's P&H 4100C, by pitch, shoe's mass and speed"
        notes.note(f"gear.{path}", None, "", "assumed", how)
    bogies = suspension.bogies_of(sheet, pitch, place.rollers, notes)
    radius = chain.built_gaps * pitch / (2.0 * math.pi)
    _check_frame(sheet, chain, shoe, parts, sum(bogie.mass for bogie in bogies))
    return Machine(
        mass=parts.frame - sum(bogie.mass for bogie in bogies),
        inertia=parts.frame_inertia,
        com=parts.frame_com,
        tumbler=_tumbler(chain, track, place, sprocket, contacts, notes),
        idler=_idler(sheet, pitch, place, springs, notes),
        rollers=place.rollers,
        bogies=bogies,
        arms=springs.arms,
        roller_radius=place.roller_radius,
        carriers=place.carriers,
        carrier_radius=place.carrier_radius,
        tread_width=notes.sized("gear.tread_width", "tread_width", rails.width),
        stiffness=contacts.tread,
        damping=contacts.tread_damping,
        damping_depth=DAMPED_DEPTH * pitch,
        rolling_resistance=resistance,
        resistance_speed=FADING * speed,
        guide_play=PLAY * pitch,
        guide_height=FLANGE * pitch,
        guide_stiffness=contacts.guide,
        guide_damping=contacts.guide_damping,
        compliance=SOFT / contacts.tread,
        torque_limit=_torque(sheet, radius, notes),
        torque_speed=LAG * speed / radius,
        car_body=_car_body(sheet, parts),
    )


def _check_frame(
    sheet: Datasheet, chain: Chain, shoe: Shoe, parts: weights.PartWeights, bogies: float
) -> None:
    """Refuse a machine whose other parts leave no mass for a side frame beside its bogies (kg)."""
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


def _contacts(sheet: Datasheet, chain: Chain, shoe: Shoe, rollers: int, notes: Notes) -> Contacts:
    """Contacts as deep, in pitches, as those of the P&H 4100C under weight and pull.

    Stiffer ones would ask for shorter steps: a shoe swings as fast, in steps, as that machine's.
    """
    pitch = chain.pitch
    weight = sheet.operating_weight * ph4100c.GRAVITY
    # two treads a roller on two tracks
    tread = 0.25 * weight / rollers / (pitch * notes.typical("tread_depth"))
    notes.note("gear.stiffness", tread, "N/m", "assumed", "tread_depth under an even share of the weight")
    pull = sheet.drawbar_pull or weight * notes.typical("pull_share")
    # two sides of a sprocket on two tracks
    tooth = 0.25 * pull / (pitch * notes.typical("contact_depth"))
    notes.note("gear.tumbler.stiffness", tooth, "N/m", "assumed", "contact_depth under the pull of the track")
    guide = GUIDES * tread
    return Contacts(
        tread,
        TREAD_DAMPING * math.sqrt(2.0 * tread * shoe.mass),
        tooth,
        guide,
        2.0 * GUIDE_DAMPING * math.sqrt(guide * shoe.mass),
    )


def _tumbler(
    chain: Chain, track: Track, place: wheels.WheelPlaces, mass: float, contacts: Contacts, notes: Notes
) -> Tumbler:
    """Sprocket, whose teeth end where their flanks meet at the latest."""
    inertia = (*rules.ring_inertia(mass, place.pins).tolist(), 0.0, 0.0, 0.0)
    how = "a wheel between disc and ring on the pins' circle"
    notes.note("gear.tumbler.inertia", inertia, "kg m2", "derived", how)
    notes.note("gear.tumbler.place", place.sprocket, "m", "derived", "by length on ground; sprocket_lift")
    tumbler = Tumbler(
        place=place.sprocket,
        teeth=chain.teeth,
        gaps_per_shoe=chain.gaps_per_shoe,
        mass=mass,
        inertia=inertia,
        reach=place.reach,
        flank=notes.sized("gear.tumbler.flank", "flank", 1.0, ""),
        lug_radius=place.bush,
        stiffness=contacts.tooth,
        damping=contacts.tread_damping,
        damping_depth=DAMPED_DEPTH * chain.pitch,
    )
    longest = tumbler.longest_reach(track)
    if math.isclose(longest, place.reach):
        return tumbler
    notes.note("gear.tumbler.reach", longest, "m", "derived", "where the flanks of a tooth meet")
    return tumbler.with_(reach=longest)


def _idler(
    sheet: Datasheet, pitch: float, place: wheels.WheelPlaces, springs: suspension.Springs, notes: Notes
) -> Idler:
    """Idler where the chain has the tension that the maker asks for."""
    way = notes.sized("gear.idler.range", "take_up", pitch)
    notes.note("gear.idler.place", place.idler, "m", "derived", "by length on ground; idler_lift")
    return Idler(
        place=place.idler,
        radius=place.idler_radius,
        range=(-way, way),
        sag=sheet.sag,
        pretension=sheet.chain_tension,
        recoil=springs.recoil,
    )


def _torque(sheet: Datasheet, radius: float, notes: Notes) -> float | None:
    """Greatest torque of a sprocket, N m: by pull or motor; None where neither is printed."""
    if sheet.drawbar_pull is None:
        if sheet.motor_torque is None or sheet.gear_ratio is None:
            return None
        torque = sheet.motor_torque * sheet.gear_ratio
        return float(notes.note("gear.torque_limit", torque, "N m", "derived", "motor_torque by gear_ratio"))
    torque = rules.sprocket_torque(sheet.drawbar_pull, radius, notes.typical("chain_efficiency"))
    return float(
        notes.note("gear.torque_limit", torque, "N m", "derived", "half of the drawbar pull at the pins")
    )


def _car_body(sheet: Datasheet, parts: weights.PartWeights) -> CarBody:
    return CarBody(
        track_distance=sheet.track_gauge,
        mass=parts.body,
        inertia=parts.body_inertia,
        com=parts.body_com,
        upper_mass=parts.upper,
        upper_inertia=parts.upper_inertia,
        upper_com=parts.upper_com,
    )
