"""Tables over the slewing angle: ground pressure, and stability about each edge."""

import numpy as np
import pandas as pd

from exudyn_crawler.assessment import forces, pressure, stability
from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.states import SLEW

KILO = 1e3
MEGA = 1e6
WITHOUT, WITH = "without payload", "with payload"
TOWARDS = dict(zip(stability.EDGES, np.radians([0.0, 180.0, 90.0, 270.0]), strict=True))
"""Direction from the middle to each edge, rad from ahead to the left."""
CHECKED = (0.0, 30.0, 60.0, 90.0, 180.0)
"""Slewing angles, deg, at which beams are compared with a plate."""


def _payloads(numbers: AssessmentNumbers) -> dict[str, float]:
    """Return payloads (kg) by their names: none, and that of the work if it has one."""
    payloads = {WITHOUT: 0.0}
    if numbers.work.payload:
        payloads[WITH] = numbers.work.payload
    return payloads


def over_slew(numbers: AssessmentNumbers, rated_part: float) -> pd.DataFrame:
    """Return pressure and stability by slewing angle: level, at rest, with and without payload.

    If the reach is stated, a column gives the rated load at the reach.
    """
    level = forces.gravity_on_slope(numbers.gravity, 0.0, 0.0)
    still = numbers.work._replace(digging=(0.0, 0.0), wind=0.0, slew_rate=0.0)
    bare = forces.forces_at(numbers.weights, still._replace(payload=0.0), SLEW, level)
    tables = []
    for words, payload in _payloads(numbers).items():
        acting = forces.forces_at(numbers.weights, still._replace(payload=payload), SLEW, level)
        stands = forces.resultant(acting)
        left, right = pressure.pressure_of_tracks(stands, numbers.fewest)
        tipped = stability.tipping(acting, numbers.edges)
        columns = {
            "state": words,
            "slew in deg": np.degrees(SLEW),
            "ahead in m": stands.ahead,
            "to the left in m": stands.aside,
            "left track, greatest in kPa": left.greatest / KILO,
            "right track, greatest in kPa": right.greatest / KILO,
            "left track, mean in kPa": left.mean / KILO,
            "right track, mean in kPa": right.mean / KILO,
            "length that carries in m": left.length,
            "least margin": tipped.margin.min(axis=1),
            "edge": [stability.EDGES[edge] for edge in tipped.first_edge],
            "tips at in deg": np.degrees(tipped.angle.min(axis=1)),
            "tips about": [stability.EDGES[edge] for edge in tipped.angle.argmin(axis=1)],
        }
        if "work.reach" not in numbers.not_stated:
            loads = stability.tipping_load(
                bare, numbers.edges, numbers.work.reach, numbers.weights.swing_axis, SLEW
            )
            columns["rated load in t"] = rated_part * loads / numbers.gravity / KILO
        tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True)


def tipping_over_slew(numbers: AssessmentNumbers) -> pd.DataFrame:
    """Return the moments about each edge by slewing angle: a row for each angle, edge and state.

    States with and without payload are: level, the permitted side slope falling towards the edge, and the
    greatest wind towards the edge.
    """
    still = numbers.work._replace(digging=(0.0, 0.0), wind=0.0, slew_rate=0.0)
    tables = []
    for words, payload in _payloads(numbers).items():
        work = still._replace(payload=payload)
        for number, (edge, towards) in enumerate(TOWARDS.items()):
            states = [("level", 0.0, work)]
            if numbers.slope:
                states.append(("side slope", numbers.slope, work))
            if numbers.work.wind:
                states.append(
                    ("wind", 0.0, work._replace(wind=numbers.work.wind, wind_towards=float(towards)))
                )
            for name, slope, of_state in states:
                gravity = forces.gravity_on_slope(numbers.gravity, slope, float(towards))
                found = stability.tipping(
                    forces.forces_at(numbers.weights, of_state, SLEW, gravity), numbers.edges
                )
                columns = {
                    "state": f"{words}, {name}",
                    "edge": edge,
                    "slew in deg": np.degrees(SLEW),
                    "stabilising in MN m": found.stabilising[:, number] / MEGA,
                    "overturning in MN m": found.overturning[:, number] / MEGA,
                    "margin": found.margin[:, number],
                    "tips further at in deg": np.degrees(found.angle[:, number]),
                }
                tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True)


def least_over_slew(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of `tipping_over_slew` at the angle of first tipping, one for each state and edge."""
    first = table.groupby(["state", "edge"], sort=False)["tips further at in deg"].idxmin()
    return table.loc[first].reset_index(drop=True)


def beams_and_plate(numbers: AssessmentNumbers, over: pd.DataFrame) -> pd.DataFrame:
    """Return the greatest pressure of both tracks as a rigid plate on the case's ground and as beams.

    `over` is the table of `over_slew`; its last state is used.
    """
    laws: dict[str, pressure.Law | None] = {"linear": None}
    if numbers.ground.law is not None:
        laws[numbers.ground.law_name] = numbers.ground.law
    last = over[over["state"] == over["state"].iloc[-1]]
    weight = numbers.weight + numbers.gravity * _payloads(numbers)[last["state"].iloc[0]]
    rows = []
    for angle in CHECKED:
        state = last[last["slew in deg"].round() == angle].iloc[0]
        place = float(state["ahead in m"]), float(state["to the left in m"])
        beams = max(state["left track, greatest in kPa"], state["right track, greatest in kPa"])
        row = {"slew in deg": angle, "beams in kPa": beams}
        if np.isfinite(beams):
            for name, law in laws.items():
                plate = pressure.plate_pressure(weight, *place, numbers.fewest, law)
                row[f"plate on {name} ground in kPa"] = plate.greatest / KILO
        rows.append(row)
    return pd.DataFrame(rows)
