"""Forces of a run in place of those of a formula, and the comparison of both."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.states import FORMULA, CaseLoads
from exudyn_crawler.case import Heights
from exudyn_crawler.results.history import History
from exudyn_crawler.results.history.catalogue import loaded_shoes, rotation_matrices
from exudyn_crawler.results.history.side_frame import pins_in_frame

REASONS = {
    "greatest pressure": "a run has that of single shoes: shoes under rollers bear more than those between",
    "track load": "both are statics; pins beside the middle of their shoes shift some load to one track",
    "greatest roller load": "in a run a roller on a shoe's middle bears half more than its mean, and less "
    "where two shoes meet; a machine that surges pitches, and one that drives over a ridge bounces on it",
    "chain tension at the tumbler": "a run has the mean at the end of the taut part of the chain; the ground "
    "takes and gives some of the pull between the rollers",
    "greatest chain tension": "the formula is for steady travel: a machine that starts within a second "
    "surges on its chains with several times the mean torque; pins below rollers bear some of their load",
    "torque of a tumbler": "the chain of a run has no loss in its pins; in a turn on units friction at the "
    "slip speeds is above that of fast slip, and a friction torque against yaw comes on top",
    "force across a shoe": "in a turn the formula takes all friction of the most loaded shoe across the "
    "track, on a slope the shoe's share by its load",
    "resultant inside of the nearest edge": "both are statics; greatest pressure and tipping follow from it",
}
"""Reasons for differences between run and formula, by quantity."""


class RunForces(NamedTuple):
    """Greatest forces of a run after a start time."""

    name: str
    drive: str
    """State of the drive: "none", "straight" or "turn"."""
    lies: str
    """Slope of the ground: "level", "grade" or "side slope"."""
    uneven: bool
    """True if the ground has ridges, stones or other relief."""
    loaded: bool
    """True if the run has a payload or a force of the bank (`machine` of the case)."""
    pressure: float
    """Greatest force of a shoe over pitch times width, Pa."""
    mean_pressure: float
    """Mean pressure of the loaded shoes, Pa."""
    track_load: float
    """Greatest load of a track, N."""
    foot: np.ndarray
    """Foot of the ground's resultant over time: X from the swing axis, and y: (times, 2), m."""
    roller: float
    """Greatest roller load, N."""
    roller_loads: np.ndarray
    """Greatest load of each roller, (rollers,), N, on the track with the greatest one."""
    mean_roller: float
    """Mean roller load over rollers and time, N."""
    tension: float
    """Greatest tension of a link, N."""
    taut: float
    """Mean tension at the end of the taut run at its tumbler, N; greatest over the tracks."""
    torque: float
    """Greatest over the tracks of the mean tumbler torque, N m."""
    side_force: float
    """Greatest friction across a shoe, N."""


def forces_of_run(history: History, name: str, begin: float | None = None) -> RunForces:
    """Return the forces of a run of a machine on two tracks.

    Parameters
    ----------
    history : History
        History of a machine; any other raises `ValueError`.
    name : str
        Name of the run in tables.
    begin : float, optional
        Start time of the evaluation, s. None: the time at which the drive reaches its last speed.
    """
    case = history.case
    if case.gear.kind != "machine":
        raise ValueError(f"the run must be one of a machine on two tracks, got gear.kind {case.gear.kind!r}")
    turn = case.drive.turn_rate
    turns = turn is not None and any(turn.values)
    profiles = [case.drive.speed] if turn is None else [case.drive.speed, turn]
    risen = max(profile.times[-1] for profile in profiles)
    start = min(risen if begin is None else begin, history.duration)
    late = history.time.values >= start - 1e-9
    contacts = history.contacts_by_shoe()
    normal = contacts.normal_force.transpose("time", "shoe", "axis").values[late]
    on_shoes = np.linalg.norm(normal, axis=-1)
    friction = contacts.friction_force.transpose("time", "shoe", "axis").values[late]
    turned = rotation_matrices(history.side_frame_angles.transpose("time", "axis").values[late])
    part = case.track.pitch * case.shoe.width
    is_loaded = loaded_shoes(xr.DataArray(on_shoes, dims=["time", "shoe"])).values
    tracks = on_shoes.reshape(len(on_shoes), case.gear.tracks, -1).sum(axis=2)
    wheels = history.dataset.wheel_force.transpose("time", "wheel", "axis").values[late]
    rolls = np.array([label.kind == "roller" for label in case.gear.wheel_labels])
    on_rollers = np.linalg.norm(wheels[:, rolls], axis=-1)
    greatest = on_rollers.max(axis=0).reshape(case.gear.tracks, -1)
    torque = history.dataset.drive_moment.transpose("time", "track").values[late]
    moves = turns or any(case.drive.speed.values)
    relief = case.terrain.relief
    return RunForces(
        name=name,
        drive="turn" if turns else "straight" if moves else "none",
        lies=_lies(relief),
        uneven=bool(relief.parts) or relief.roughness is not None or relief.measured is not None,
        loaded=case.machine is not None,
        pressure=float(on_shoes.max()) / part,
        mean_pressure=float(on_shoes[is_loaded].mean()) / part,
        track_load=float(tracks.max()),
        foot=_foot(history, late, on_shoes, turned),
        roller=float(greatest.max()),
        roller_loads=greatest[greatest.max(axis=1).argmax()],
        mean_roller=float(on_rollers.mean()),
        tension=float(history.link_tension.transpose("time", "joint").values[late].max()),
        taut=float(_at_tumblers(history, late).max()),
        torque=float(np.abs(torque.mean(axis=0)).max()) if moves else 0.0,
        side_force=float(np.abs(np.einsum("tsx,tx->ts", friction, turned[..., 1])).max()),
    )


def _lies(relief: Heights) -> str:
    """Return the word for the slope of the ground's plane."""
    if relief.slope_x:
        return "grade"
    return "side slope" if relief.slope_y else "level"


def _foot(history: History, late: np.ndarray, on_shoes: np.ndarray, turned: np.ndarray) -> np.ndarray:
    """Return the foot of the ground forces from the swing axis in the machine's axes: array (times, 2), m.

    Along the tracks it follows from the positions of the shoes. Across them it follows from the loads of both
    tracks at their middles.
    """
    case = history.case
    gear: Any = case.gear
    shoes = history.position.transpose("time", "shoe", "axis").values[late]
    frame = history.side_frame_position.transpose("time", "axis").values[late]
    along = np.einsum("tsx,tx->ts", shoes - frame[:, None], turned[..., 0])
    whole = on_shoes.sum(axis=1)
    tracks = on_shoes.reshape(len(on_shoes), case.gear.tracks, -1).sum(axis=2)
    aside = tracks @ np.array(gear.middles) / whole
    return np.stack(((on_shoes * along).sum(axis=1) / whole - gear.car_body.swing_axis, aside), axis=1)


def _at_tumblers(history: History, late: np.ndarray) -> np.ndarray:
    """Return the mean tension (N) of the links nearest to a tumbler's ends: (tracks, 2), lower and upper."""
    case = history.case
    gear: Any = case.gear
    tension = history.link_tension.transpose("time", "joint").values[late]
    x, _, z = np.moveaxis(pins_in_frame(case, history.dataset.isel(time=late)), -1, 0)
    radius = gear.tumbler.radius(case.track.pitch)
    means = np.zeros((case.gear.tracks, 2))
    each = tension.shape[1] // case.gear.tracks
    for track, end in np.ndindex(*means.shape):
        links = slice(track * each, (track + 1) * each)
        height = gear.tumbler.place[1] + (2 * end - 1) * radius
        away = np.hypot(x[:, links] - gear.tumbler.place[0], z[:, links] - height)
        nearest = away.argmin(axis=1)[:, None]
        means[track, end] = np.take_along_axis(tension[:, links], nearest, axis=1).mean()
    return means


def with_run(
    numbers: AssessmentNumbers, loads: list[CaseLoads], run: RunForces, wanted: str | None = None
) -> tuple[list[CaseLoads], str]:
    """Return the load cases with a run's forces in place of the formula's, and the name of the replaced case.

    The run replaces the load case named `wanted`, or else the first one with its drive, ground and load. A
    run with relief replaces a case with one roller on a ridge, any other a case on even ground. Raise
    `ValueError` if no load case fits, or if the case has the forces of another run.
    """
    number = _number_of(loads, run, wanted)
    row = loads[number]
    if row.basis != FORMULA:
        raise ValueError(
            f"load case {row.name!r} has the forces of {row.basis}, and not of {run.name} as well"
        )
    needed = run.torque * numbers.drive.efficiency / numbers.drive.radius
    taken = row._replace(
        basis=f"run {run.name}",
        greatest_pressure=run.pressure,
        even_pressure=np.nan,
        mean_pressure=run.mean_pressure,
        track_load=run.track_load,
        roller=run.roller,
        roller_loads=run.roller_loads,
        distance=least_distance(numbers, run),
        needed=needed if row.drive in ("straight", "turn") else row.needed,
        tension=run.tension,
        side_force=run.side_force,
    )
    return [*loads[:number], taken, *loads[number + 1 :]], row.name


def _number_of(loads: list[CaseLoads], run: RunForces, wanted: str | None) -> int:
    """Return the number of the load case that a run replaces."""
    names = [row.name for row in loads]
    if wanted is not None:
        if wanted not in names:
            raise ValueError(f"load case of run {run.name} must be one of {', '.join(names)}, got {wanted!r}")
        return names.index(wanted)
    support = "one" if run.uneven else "even"
    fits = [
        number
        for number, row in enumerate(loads)
        if row.support == support
        and (run.uneven or (row.drive, row.lies, row.loaded) == (run.drive, run.lies, run.loaded))
    ]
    if not fits:
        load = "with" if run.loaded else "without"
        raise ValueError(
            f"run {run.name} (drive {run.drive!r}, {run.lies}, {load} payload or bank, support {support!r}) "
            "fits no load case; name its load case, 'LOAD CASE=RUN'"
        )
    return fits[0]


def least_distance(numbers: AssessmentNumbers, run: RunForces) -> float:
    """Return the least distance, m, of the resultant's foot of a run from the edges, positive inside."""
    ahead = run.foot[:, 0] + numbers.weights.swing_axis
    aside = run.foot[:, 1]
    edges = numbers.edges
    inside = (edges.front - ahead, edges.rear + ahead, edges.left - aside, edges.right + aside)
    return float(np.min(inside))


def comparison(
    numbers: AssessmentNumbers, loads: list[CaseLoads], run: RunForces, stands: str
) -> pd.DataFrame:
    """Compare formula and run: a row for each quantity, with reasons for the difference."""
    row = next(case for case in loads if case.name == stands)
    torque = row.needed * numbers.drive.radius / numbers.drive.efficiency
    pairs = {
        "greatest pressure": (row.greatest_pressure / 1e3, run.pressure / 1e3, "kPa"),
        "track load": (row.track_load / 1e3, run.track_load / 1e3, "kN"),
        "resultant inside of the nearest edge": (row.distance, least_distance(numbers, run), "m"),
        "greatest roller load": (row.roller / 1e3, run.roller / 1e3, "kN"),
        "chain tension at the tumbler": (row.tension / 1e3, run.taut / 1e3, "kN"),
        "greatest chain tension": (row.tension / 1e3, run.tension / 1e3, "kN"),
    }
    if row.drive in ("straight", "turn"):
        pairs["torque of a tumbler"] = (torque / 1e3, run.torque / 1e3, "kN m")
    if row.side_force:
        pairs["force across a shoe"] = (row.side_force / 1e3, run.side_force / 1e3, "kN")
    rows = [
        {
            "quantity": name,
            "load case": stands,
            "formula": formula,
            "run": of_run,
            "unit": unit,
            "run over formula": of_run / formula if formula else np.nan,
            "what makes a difference": REASONS[name],
        }
        for name, (formula, of_run, unit) in pairs.items()
    ]
    return pd.DataFrame(rows)
