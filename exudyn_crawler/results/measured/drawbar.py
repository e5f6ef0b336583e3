"""Drawbar test of a closed track or a machine: pull, torque, efficiency and sinkage over slip.

A drawbar makes the machine travel slower than its chains, at one constant slip after another. The drive keeps
the speed of the chains with any torque. Means are over the passage of whole shoes, so that neither the
polygon of the tumbler nor entering shoes have an effect. Travel is that of the drawbar's point on the frame;
all signs are those of the sense of travel.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from exudyn_crawler.case import Case, RunningGear, StepProfile
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.machines import CaseFile
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.measured.traction import EvenTrack, even_track

SLIPS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
"""Slips of a test; the values are a choice of this project. Zero comes before them."""
RISE, SETTLED, COUNTED = 0.15, 2.5, 0.35
"""Travel of the chain, in lengths of the track, for the rise of the slip, the transient, and the mean. Shear
below the track takes one length; trim and sinkage in remaining ruts take the rest: after one length the pull
was 7 % short."""
MISSED = 0.02
"""Difference of the measured from the wanted slip, fraction of the latter, above which a remark is made."""
HEADS = {
    "wanted": "wanted slip",
    "slip": "slip",
    "pull": "pull in N",
    "torque": "torque in N m",
    "efficiency": "efficiency",
    "sinkage": "sinkage in m",
    "resistance": "motion resistance in N",
    "closed": "pull in closed form in N",
    "anew": "pull in closed form with shear anew at each roller in N",
}
"""Columns of the table."""


@dataclass(frozen=True)
class DrawbarTest:
    """Slips that a drawbar holds one after the other, and its height."""

    slips: tuple[float, ...] = SLIPS
    height: float = 0.0  # height of the drawbar above the ground, m; at 0 it shifts no load to the rear


def read_slips(text: str) -> tuple[float, ...]:
    """Read slips from a text such as ``0.02,0.1``; ValueError if they are not numbers."""
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise ValueError(f"slips must be numbers with commas between them, got {text!r}") from None


def pulled_case(case_file: CaseFile, test: DrawbarTest) -> CaseFile:
    """Return the case of a test: its drive holds the slips, and it lasts until the last one is measured.

    Ground of cells is extended to the length of the travel, in its direction; a measured map stays as it is.

    Raises
    ------
    ValueError
        If the case has no closed track on cells, its drive ends at rest, or slips do not increase within 0
        and 1.
    """
    case = case_file.case
    track = even_track(case)
    speed = float(case.drive.speed.values[-1])
    if speed == 0.0:
        raise ValueError("drive.speed must not end at zero in a drawbar test: its chains travel")
    slips = np.array(test.slips, dtype=float)
    if not len(slips) or slips.min() <= 0.0 or slips.max() >= 1.0 or np.any(np.diff(slips) <= 0.0):
        raise ValueError(f"slips must increase between 0 and 1, got {list(test.slips)}")
    length = track.length / abs(speed)
    times = [float(case.drive.speed.times[-1]) + (SETTLED + COUNTED) * length]
    values = [0.0]
    for slip in slips.tolist():
        times += [times[-1] + RISE * length, times[-1] + (RISE + SETTLED + COUNTED) * length]
        values += [slip, slip]
    profile = StepProfile(times=tuple(times), values=tuple(values))
    drive = case.drive.with_(slip=profile, drawbar_height=test.height)
    end = times[-1]
    terrain: Any = case.terrain
    if terrain.relief.measured is None:
        case = case.with_(terrain=_longer(terrain, _reached(case, float(drive.travel(end)), track.length)))
    return case_file.with_(case=case.with_(drive=drive), duration=end)


def _reached(case: Case, travel: float, margin: float) -> tuple[float, float]:
    """Return the least and greatest x of the ground for a travel, m, with a margin (m) ahead."""
    x = case.outline(0.0)[:, 0]
    ends = (x.min() + travel - margin, x.max()) if travel < 0.0 else (x.min(), x.max() + travel + margin)
    return float(ends[0]), float(ends[1])


def _longer(terrain: Any, reached: tuple[float, float]) -> Any:
    """Return the terrain of cells extended to include an interval of x, m."""
    rear, front = terrain.bounds[0]
    behind = max(0.0, rear - reached[0])
    ahead = max(0.0, reached[1] - front)
    x, y = terrain.origin
    return terrain.with_(origin=(x - behind, y), length=terrain.length + behind + ahead)


def drawbar_table(history: History) -> pd.DataFrame:
    """Return the table of a test: columns of `HEADS` in SI units, a row for each constant slip, zero first.

    The measured slip is ``1 - travel of the drawbar / travel of the chain``. Efficiency is the pull's work
    over that of the drive. Motion resistance is the drive's work over the travel of the chain, less the pull;
    it includes the ground's resistance and that of wheels and chain. ValueError if the history is not that of
    a drawbar test.
    """
    case = history.case
    track = even_track(case)
    if case.drive.slip is None:
        raise ValueError(f"case {case.name!r} must have a drive.slip, as the command drawbar sets it")
    time = history.time.values
    gear: Any = case.gear
    sense = math.copysign(1.0, case.drive.speed.values[-1])
    turn = sense * _by_track(history, "tumbler_angle", gear.tracks)
    torque = sense * _by_track(history, "drive_moment", gear.tracks)
    pull = sense * history.quantity("drawbar_pull").values
    chain = gear.travel_per_angle(case.track) * (turn - turn[0]).mean(axis=1)
    travel = sense * _drawbar_place(history)
    work = _summed(np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(turn, axis=0), axis=1))
    pulling = _summed(0.5 * (pull[1:] + pull[:-1]) * np.diff(travel))
    # whole shoes before the end of each hold
    shoes = max(1, round(COUNTED * track.length / gear.chain_pitch(case.track)))
    held = [
        (end, wanted)
        for end, wanted in zip(case.drive.slip.times[::2], case.drive.slip.values[::2], strict=True)
        if end <= time[-1] + 1e-9
    ]
    ends = np.interp([end for end, _ in held], time, chain)
    edges = np.interp(np.column_stack((ends - shoes * gear.chain_pitch(case.track), ends)), chain, time)

    def gained(values: np.ndarray) -> np.ndarray:
        return np.diff(np.interp(edges, time, values))[:, 0]

    def mean(values: np.ndarray) -> np.ndarray:
        integral = _summed(0.5 * (values[1:] + values[:-1]) * np.diff(time))
        return gained(integral) / np.diff(edges)[:, 0]

    slip = 1.0 - gained(travel) / gained(chain)
    rows = {
        "wanted": [wanted for _, wanted in held],
        "slip": slip,
        "pull": mean(pull),
        "torque": mean(torque.sum(axis=1)),
        "efficiency": gained(pulling) / gained(work),
        "sinkage": mean(_sinkage(history)),
        "resistance": gained(work) / gained(chain) - mean(pull),
        "closed": track.pull(np.maximum(slip, 0.0)),
        "anew": track.pull(np.maximum(slip, 0.0), track.rollers),
    }
    return pd.DataFrame(rows).rename(columns=HEADS)


def remarks(history: History, table: pd.DataFrame) -> Iterator[str]:
    """Yield remarks on a test's table: slips that were not met, and a drive that would stall."""
    for wanted, slip in zip(table[HEADS["wanted"]], table[HEADS["slip"]], strict=True):
        if wanted > 0.0 and abs(slip - wanted) > MISSED * wanted:
            yield f"slip: {100.0 * wanted:.4g} % wanted, {100.0 * slip:.4g} % measured"
    gear: Any = history.case.gear
    if gear.torque_limit is None:
        return
    limit = gear.tracks * gear.torque_limit
    beyond = table[table[HEADS["torque"]] > limit]
    if len(beyond):
        wanted, torque = beyond.iloc[0][[HEADS["wanted"], HEADS["torque"]]]
        taken = f"{1e-3 * torque:.4g} kN m of its {1e-3 * limit:.4g} kN m (gear.torque_limit)"
        yield (
            f"the drive stalls before a slip of {100.0 * wanted:.4g} %, which takes {taken}: "
            "pulls from there on are what the ground gives"
        )


def _drawbar_place(history: History) -> np.ndarray:
    """Return x of the drawbar's point on the frame: array (times,), m."""
    case = history.case
    axes = rotation_matrices(history.side_frame_angles.transpose("time", "axis").values)
    below = case.drive.drawbar_height - case.part(RunningGear).frame_start(case)[2]
    x: np.ndarray = history.side_frame_position.sel(axis="x").values + axes[:, 0, 2] * below
    return x


def _sinkage(history: History) -> np.ndarray:
    """Return the mean sinkage of the loaded area: array (times,), m."""
    contacts = history.contacts_by_shoe()
    area = contacts.area.transpose("time", "shoe").values
    depth = contacts.penetration.transpose("time", "shoe").values
    return np.sum(area * depth, axis=1) / np.maximum(area.sum(axis=1), 1e-12)


def _summed(steps: np.ndarray) -> np.ndarray:
    """Return the running sum from zero: one element longer than the steps."""
    return np.concatenate((np.zeros(1), np.cumsum(steps)))


def _by_track(history: History, name: str, tracks: int) -> np.ndarray:
    """Return a quantity of the tumblers: array (times, tracks)."""
    return history.quantity(name).values.reshape(len(history.time), tracks)


@dataclass(frozen=True)
class DrawbarResult:
    """Key figures of a drawbar test."""

    greatest_pull: float  # N
    slip_there: float
    pull_at_slip: float  # N, at the wanted slip; NaN if the test does not reach it
    coefficient: float  # greatest pull over weight
    gradeability: float  # grade whose tangent is this coefficient, rad
    motion_resistance: float  # N, at the slip without a pull
    best_efficiency: float
    track: EvenTrack


def drawbar_result(history: History, slip: float = 0.2) -> DrawbarResult:
    """Return the key figures of a test; the steepest grade has the tangent greatest pull over weight."""
    table = drawbar_table(history).rename(columns={head: name for name, head in HEADS.items()})
    track = even_track(history.case)
    best = table.loc[table["pull"].idxmax()]
    # a slip short of the wanted one by rounding counts as reached
    reached = slip <= table["slip"].max() + 1e-3
    return DrawbarResult(
        greatest_pull=float(best["pull"]),
        slip_there=float(best["slip"]),
        pull_at_slip=float(np.interp(slip, table["slip"], table["pull"])) if reached else math.nan,
        coefficient=float(best["pull"]) / track.weight,
        gradeability=math.atan(float(best["pull"]) / track.weight),
        motion_resistance=float(np.interp(0.0, table["pull"], table["resistance"])),
        best_efficiency=float(table["efficiency"].max()),
        track=track,
    )


def result_rows(result: DrawbarResult, slip: float) -> list[tuple[str, float, str]]:
    """Return rows of a test's key figures for reading: name, value, unit."""
    track = result.track
    there = f"at {100.0 * slip:g} % slip"
    return [
        ("greatest pull", 1e-3 * result.greatest_pull, "kN"),
        ("slip there, measured", 100.0 * result.slip_there, "%"),
        (f"pull {there}", 1e-3 * result.pull_at_slip, "kN"),
        (f"pull {there} in closed form", 1e-3 * float(track.pull(np.array([slip]))[0]), "kN"),
        (
            f"pull {there} in closed form, shear anew at each roller",
            1e-3 * float(track.pull(np.array([slip]), track.rollers)[0]),
            "kN",
        ),
        ("the ground springs back, of its sinkage at the mean pressure", 100.0 * track.rebound, "%"),
        ("greatest pull over weight", result.coefficient, ""),
        ("gradeability", math.degrees(result.gradeability), "deg"),
        ("motion resistance", 1e-3 * result.motion_resistance, "kN"),
        ("best efficiency", result.best_efficiency, ""),
        ("weight", 1e-3 * track.weight, "kN"),
        ("mean pressure", 1e-3 * track.pressure, "kPa"),
        ("strength in closed form", 1e-3 * track.strength, "kN"),
        ("resistance of compaction in closed form", 1e-3 * track.resistance, "kN"),
    ]
