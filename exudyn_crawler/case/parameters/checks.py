"""Plausibility checks before a run: values that no known machine or ground has."""

import logging
import warnings
from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np
from pydantic import BaseModel

from exudyn_crawler.case import statics
from exudyn_crawler.case.case import Case
from exudyn_crawler.case.parameters import drive, sizes
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.errors import ImplausibleWarning
from exudyn_crawler.settings import fields

logger = logging.getLogger("exudyn_crawler")

_newtons = partial(fields.in_units, units={"GN": 1e9, "MN": 1e6, "kN": 1e3, "N": 1.0}, digits=4)
LEAST_LOAD, GREATEST_LOAD = 1e3, 1e7  # N, mean load of the machine on a shoe
LIGHTEST = 0.5  # least mean load on a shoe, fraction of the shoe's weight (chosen here)
LEAST_GYRATION, GREATEST_GYRATION = 0.02, 5.0  # m, radii of gyration of a shoe
SHALLOWEST = 1e-5  # m, least plausible penetration of a shoe into a unit
BOTTOMLESS = 5.0  # greatest sinkage at which a track can rest, heights of a shoe or of a unit (chosen here)
DEEPEST = 0.5  # greatest plausible penetration, fraction of a load point's height above the underside
GREATEST_SAG = 0.5  # greatest plausible sinkage of a unit under itself and a shoe's load, unit heights


def _loads(case: Case) -> Iterator[str]:
    """Yield a warning for each phase with loads that lift shoes, have an odd size, or act off the shoe."""
    core = case.shoe.width / 6.0
    weight = case.shoe.mass * float(np.linalg.norm(case.gravity_vector()))
    for number, phase in enumerate(case.loads.phases):
        key = f"loads.phases[{number}]"
        end = f"at the end of {phase.name!r}"
        loads = np.array(phase.loads)
        whole = loads.sum()
        if loads.min() < 0.0:
            lifted = f"{_newtons(loads.min())} {end} lifts shoe {loads.argmin() + 1}"
            yield f"{key}.loads: {lifted}; loads press down and are positive"
        elif not case.gear.frame_parts and not LEAST_LOAD <= whole / len(loads) <= GREATEST_LOAD:
            cause = f"{_newtons(whole)} in all; loads are in N"
            if whole == 0.0:
                cause = "nothing, so that the ground carries the shoes alone"
            yield f"{key}.loads: {len(loads)} shoes carry {cause}"
        elif not case.gear.frame_parts and whole < LIGHTEST * len(loads) * weight:
            each = f"{_newtons(whole / len(loads))} on a shoe, which weighs {_newtons(weight)} itself"
            yield f"{key}.loads: {each}: are the load's unit and its marks of decimals and thousands right?"
        if abs(phase.side_shift) > core and loads.any():
            shift = f"{phase.side_shift:g} m {end} is beyond a sixth of the shoe's width, {core:.3g} m"
            yield f"{key}.side_shift: {shift}: the load pulls at the other edge"


def _inertia(case: Case) -> Iterator[str]:
    radii = np.sqrt(np.linalg.eigvalsh(case.shoe.inertia_tensor) / case.shoe.mass)
    if radii[0] < LEAST_GYRATION or radii[-1] > GREATEST_GYRATION:
        gives = f"radii of gyration of {radii[0]:.3g} to {radii[-1]:.3g} m"
        plausible = f"{LEAST_GYRATION} to {GREATEST_GYRATION} m; it is in kg m2"
        mass = fields.quantity_text(case.shoe.mass, "kg")
        yield f"shoe.inertia: with {mass} it gives {gives}, outside of {plausible}"
        return
    reach = sizes.shoe_reach(case.shoe, case.track)
    yield from sizes.wide_inertia("shoe", case.shoe.mass, case.shoe.inertia, reach)
    yield from sizes.thin_inertia("shoe", case.shoe.mass, case.shoe.inertia)


def _unit_sag(case: Case, terrain: Terrain) -> float:
    """Return the sinkage (m) of a unit under its weight and the mean load of a shoe."""
    weight = terrain.unit_mass * case.gravity_vector()[2]
    return float((statics.mean_load(case) - weight) / terrain.heave_stiffness)


def bottomless(case: Case) -> str | None:
    """Return a line on shoes that would sink too far for any ground; None if the ground carries them."""
    height = case.shoe.com_height + case.shoe.load_point[2]
    depth = statics.settled_penetration(case)
    how = f"by {depth:.3g} m"
    deepest = depth / height
    if case.terrain.model != "cells":
        sag = _unit_sag(case, case.terrain)
        how += f" into units that sink by {sag:.3g} m"
        deepest = max(deepest, sag / case.terrain.unit_height)
    if deepest <= BOTTOMLESS:
        return None
    load = _newtons(statics.mean_load(case))
    return f"under the mean load of {load} a shoe of {height:.3g} m would sink {how}"


def _gear(case: Case) -> Iterator[str]:
    """Yield the warnings of the gear, such as for inertias and teeth."""
    yield from case.gear.implausible(case.shoe, case.track)


def _sinking(case: Case) -> Iterator[str]:
    depth = statics.settled_penetration(case)
    height = case.shoe.com_height + case.shoe.load_point[2]
    load = statics.mean_load(case)
    sinks = f"contact: a shoe sinks by {depth:.3g} m under its mean load of {_newtons(load)},"
    if depth > DEEPEST * height:
        yield f"{sinks} more than half its height of {height:.3g} m; is it in N/m^exponent? Are loads in N?"
    elif 0.0 < depth < SHALLOWEST:
        yield f"{sinks} less than {SHALLOWEST:g} m; the stiffness is in N/m^exponent"
    terrain = case.terrain
    if terrain.model == "cells":
        return
    sag = _unit_sag(case, terrain)
    if sag > GREATEST_SAG * terrain.unit_height:
        half = f"more than half its height of {terrain.unit_height:.4g} m; the stiffness is in N/m"
        yield f"terrain.spring_stiffness: a unit sinks by {sag:.3g} m under itself and one shoe, {half}"


def _map(case: Case) -> Iterator[str]:
    """Yield a warning for measured heights that are farther apart than a shoe is wide."""
    measured = case.terrain.relief.measured
    if measured is None:
        return
    apart = max(measured.sides)
    width = case.shoe.width
    if apart > width:
        yield (
            f"terrain.relief.measured: heights of {measured.file.name} are {apart:.4g} m apart, a shoe is "
            f"{width:.3g} m wide and feels their mean slope alone; place_unit says in which unit places are"
        )


def warn_implausible(case: Case, duration: float | None = None) -> None:
    """Warn, by an `ImplausibleWarning` each, of values that no known machine or ground has."""
    warn_of(implausible(case, duration))


def warn_of(lines: Iterable[str], category: type[Warning] = ImplausibleWarning) -> None:
    """Log each line and issue it as a warning."""
    for line in lines:
        logger.info("warning: %s", line)
        warnings.warn(line, category, stacklevel=4)


def out_of_range(parameters: BaseModel) -> Iterator[str]:
    """Yield a line for each value outside its plausible range."""
    for entry in fields.walk(parameters):
        plausible = fields.plausible_range(entry.field)
        numbers = _numbers(entry.value)
        if plausible is None or not numbers:
            continue
        least, greatest = plausible
        worst = max(numbers, key=lambda one: max(least - one, one - greatest))
        if not least <= worst <= greatest:
            unit = f" {entry.unit}" if entry.unit else ""
            cause = fields.likely_cause(worst, entry.field)
            size = f"{fields.four_digits(worst)}{unit}"
            yield f"{entry.path}: {size} is outside of {least:g} to {greatest:g}{unit}{cause}"


def implausible(case: Case, duration: float | None = None) -> Iterator[str]:
    """Yield a line for each value of a case that no known machine or ground has."""
    yield from out_of_range(case)
    for check in (_loads, _inertia, _gear, _sinking, _map):
        yield from check(case)
    step = case.solver.step
    if duration is not None and duration < step:
        yield f"solver.step: {step:g} s is longer than the run of {duration:g} s"


def _numbers(value: object) -> list[float]:
    if isinstance(value, drive.StepProfile):
        return list(value.values)
    if isinstance(value, tuple):
        return [number for element in value for number in _numbers(element)]
    return [float(value)] if fields.is_number(value) else []
