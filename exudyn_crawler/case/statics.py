"""Statics of a case: the loads on its shoes, and how deep they settle."""

import numpy as np

from exudyn_crawler.case.gear.base import Whole
from exudyn_crawler.case.parameters.contact import PairContact, SphereContact, impact_depth


def pressed(case: Whole, load: np.typing.ArrayLike) -> np.ndarray:
    """Return the force normal to the ground (N) of a shoe's weight and each load (N) on it."""
    return (np.asarray(load) + case.shoe.mass * case.gravity) * -case.terrain.down[2]


def mean_load(case: Whole) -> float:
    """Return the mean normal force (N) of load and weight below the shoes that carry the machine at t = 0."""
    return float(pressed(case, case.gear.first_loads(case)[case.gear.standing(case)]).mean())


def settled_penetration(case: Whole) -> float:
    """Return the penetration (m) of an evenly loaded shoe under the mean load."""
    mean = mean_load(case)
    if isinstance(case.contact, SphereContact):
        return float(impact_depth(mean, case.contact.reference_stiffness, case.contact.reference_exponent))
    return float(settled_depths(case, np.array([mean]))[0])


def settled_depths(case: Whole, loads: np.ndarray) -> np.ndarray:
    """Return the penetration (m) of an evenly loaded shoe for each load (N); zero if it is lifted."""
    contact = case.contact
    loads = np.maximum(loads, 0.0)
    if isinstance(contact, PairContact):
        return impact_depth(loads, contact.stiffness, contact.exponent)
    if isinstance(contact, SphereContact):
        return loads * settled_penetration(case) / mean_load(case)
    breadth = case.shoe.ground_breadth
    pressures = (loads / case.shoe.ground_area).tolist()
    return np.array([contact.law.sinkage(pressure, breadth) for pressure in pressures])


def sphere_stiffness(case: Whole, spheres: SphereContact) -> float:
    """Return the stiffness of a sphere, N/m; a shoe's carry the mean load at the settled penetration."""
    return mean_load(case) / settled_penetration(case) / spheres.count


def machine_wrench(case: Whole, time: np.typing.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return force (N) and moment (N m) at a side frame's origin, without its weight, at times (s).

    Both are global arrays (times, 3).
    """
    nothing = np.zeros((np.size(time), 3))
    return (nothing, nothing.copy()) if case.machine is None else case.machine.wrench(time)
