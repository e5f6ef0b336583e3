"""Forces of a run in place of those of a formula, and both beside each other."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.states import CaseLoads
from exudyn_crawler.results.history import History

LEAST_PART = 0.05
"""Of the greatest force on a shoe, from which on it counts as standing on the ground."""
REASONS = {
    "greatest pressure": "a run's is that of a shoe: those under rollers bear more than those between",
    "track load": "statics in both; pins beside the middle of their shoes move some of it",
    "greatest roller load": "rollers of a run stand now on a shoe's middle, now where two of them give way",
    "chain tension at the tumbler": "mean of a run at the end of its taut run; ground takes and gives some "
    "of the pull between the rollers",
    "greatest chain tension": "a run swings by the polygon of the tumbler and strikes of the teeth, and a "
    "shoe that tips below an outer roller pulls at its neighbours: twice the mean and more",
    "torque of a tumbler": "a run on soft ground loses work there; with a contact law of units friction "
    "against yaw adds to that along and across; the chain of a run has no loss in its pins",
    "force across a shoe": "the formula has all friction of the most loaded shoe across the track",
}
"""Why a run and a formula may differ, by quantity."""


class RunForces(NamedTuple):
    """Greatest forces of a run from a time on."""

    name: str
    drive: str
    """What the machine does: "none", "straight" or "turn"."""
    uneven: bool
    """True where the ground has ridges, stones or other heights."""
    pressure: float
    """Of the shoe with the greatest, over pitch times width, Pa."""
    mean_pressure: float
    """Over the shoes that stand, Pa."""
    track_load: float
    """Greatest of a track, N."""
    roller: float
    """Greatest, N."""
    mean_roller: float
    """Mean over rollers and time, N."""
    tension: float
    """Greatest of a link, N."""
    taut: float
    """Mean where the taut run meets its tumbler, N; greatest over the tracks."""
    torque: float
    """Greatest over the tracks of the mean torque of a tumbler, N m."""
    side_force: float
    """Greatest friction across a shoe, N."""


def forces_of_run(history: History, name: str, begin: float | None = None) -> RunForces:
    """Forces of a run of a machine on two tracks.

    Parameters
    ----------
    history : History
        A ValueError if it is of no machine.
    name : str
        Of the run, as tables show it.
    begin : float, optional
        s, from which on they count; that at which the drive has its last speed if none.
    """
    case = history.case
    if case.gear.kind != "machine":
        raise ValueError(f"run must be of a machine on two tracks, got gear.kind {case.gear.kind!r}")
    turn = case.drive.turn_rate
    turns = turn is not None and any(turn.values)
    profiles = [case.drive.speed] if turn is None else [case.drive.speed, turn]
    risen = max(profile.times[-1] for profile in profiles)
    start = min(risen if begin is None else begin, history.duration)
    late = history.time.values >= start - 1e-9
    contacts = history.contacts_by_shoe()
    normal = contacts.normal_force.transpose("time", "shoe", "axis").values[late]
    on_shoes = np.linalg.norm(normal, axis=-1)
    across = np.abs(contacts.friction_force.transpose("time", "shoe", "axis").values[late])
    part = case.track.pitch * case.shoe.width
    stands = on_shoes > LEAST_PART * on_shoes.max()
    tracks = on_shoes.reshape(len(on_shoes), case.tracks, -1).sum(axis=2)
    wheels = history.dataset.wheel_force.transpose("time", "wheel", "axis").values[late]
    rolls = np.array([label.kind == "roller" for label in case.gear.wheel_labels])
    on_rollers = np.linalg.norm(wheels[:, rolls], axis=-1)
    torque = history.dataset.drive_moment.transpose("time", "track").values[late]
    moves = turns or any(case.drive.speed.values)
    # of a turn the way across is what is not along the machine, near its start along y
    side = float(across[..., 1].max()) if turns else 0.0
    return RunForces(
        name=name,
        drive="turn" if turns else "straight" if moves else "none",
        uneven=bool(case.terrain.relief.parts),
        pressure=float(on_shoes.max()) / part,
        mean_pressure=float(on_shoes[stands].mean()) / part,
        track_load=float(tracks.max()),
        roller=float(on_rollers.max()),
        mean_roller=float(on_rollers.mean()),
        tension=float(history.link_tension.transpose("time", "joint").values[late].max()),
        taut=float(_at_tumblers(history, late).max()),
        torque=float(np.abs(torque.mean(axis=0)).max()) if moves else 0.0,
        side_force=side,
    )


def _at_tumblers(history: History, late: np.ndarray) -> np.ndarray:
    """Mean tension of the link nearest to where a run meets a tumbler: array (tracks, 2), lower, upper; N."""
    case = history.case
    gear: Any = case.gear
    tension = history.link_tension.transpose("time", "joint").values[late]
    axes = history.quantity("axes").transpose("time", "shoe", "axis", "body_axis").values[late]
    ahead = axes @ np.array([case.track.pin_ahead, 0.0, case.track.pin_height])
    pins = history.position.transpose("time", "shoe", "axis").values[late] + ahead
    frame = history.side_frame_position.transpose("time", "axis").values[late]
    x, z = (pins[..., c] - frame[:, None, c] for c in (0, 2))
    radius = gear.tumbler.radius(case.track.pitch)
    means = np.zeros((case.tracks, 2))
    each = tension.shape[1] // case.tracks
    for track, end in np.ndindex(*means.shape):
        links = slice(track * each, (track + 1) * each)
        height = gear.tumbler.place[1] + (2 * end - 1) * radius
        away = np.hypot(x[:, links] - gear.tumbler.place[0], z[:, links] - height)
        nearest = away.argmin(axis=1)[:, None]
        means[track, end] = np.take_along_axis(tension[:, links], nearest, axis=1).mean()
    return means


def with_run(
    numbers: AssessmentNumbers, loads: list[CaseLoads], run: RunForces
) -> tuple[list[CaseLoads], str]:
    """Load cases with a run's forces in place of the formula's where it is of that case, and which that is.

    It stands for the first case with its drive: on even ground, or with one roller on a ridge where the run's
    ground has heights. A ValueError if there is none.
    """
    support = "one" if run.uneven else "even"
    fits = [
        number
        for number, row in enumerate(loads)
        if row.support == support and (run.uneven or row.drive == run.drive)
    ]
    if not fits:
        raise ValueError(
            f"no load case has drive {run.drive!r} with support {support!r}, which the run is of"
        )
    number = fits[0]
    row = loads[number]
    needed = run.torque * numbers.drive.efficiency / numbers.drive.radius
    taken = row._replace(
        basis=f"run {run.name}",
        greatest_pressure=run.pressure,
        even_pressure=run.mean_pressure,
        track_load=run.track_load,
        roller=run.roller,
        needed=needed if row.drive in ("straight", "turn") else row.needed,
        tension=run.tension,
        side_force=run.side_force,
    )
    return [*loads[:number], taken, *loads[number + 1 :]], row.name


def comparison(
    numbers: AssessmentNumbers, loads: list[CaseLoads], run: RunForces, stands: str
) -> pd.DataFrame:
    """Formula beside run with what makes the difference: a row for each quantity."""
    row = next(case for case in loads if case.name == stands)
    torque = row.needed * numbers.drive.radius / numbers.drive.efficiency
    pairs = {
        "greatest pressure": (row.greatest_pressure / 1e3, run.pressure / 1e3, "kPa"),
        "track load": (row.track_load / 1e3, run.track_load / 1e3, "kN"),
        "greatest roller load": (row.roller / 1e3, run.roller / 1e3, "kN"),
        "chain tension at the tumbler": (row.tension / 1e3, run.taut / 1e3, "kN"),
        "greatest chain tension": (row.tension / 1e3, run.tension / 1e3, "kN"),
    }
    if run.drive != "none":
        pairs["torque of a tumbler"] = (torque / 1e3, run.torque / 1e3, "kN m")
    if run.drive == "turn":
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
