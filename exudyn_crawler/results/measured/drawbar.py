"""Drawbar test of a closed track or a machine: pull, torque, efficiency and sinkage over slip.

A force that rises pulls the machine back while its tracks go at the case's speed. Means are over the passage
of a shoe, so that neither the polygon of the tumbler nor single shoes that enter count.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from exudyn_crawler.case import Case, CaseFile, MachineCycle
from exudyn_crawler.case.parameters.machine_cycle import MachinePhase
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.measured.traction import EvenTrack, even_track

START_LENGTHS, RISE_LENGTHS = 1.5, 8.0
"""Lengths of the track that the chain goes before the pull begins, and while it rises. Chosen here: shear
below a track is steady once a shoe has gone from front to rear."""
GREATEST = (
    0.95  # of the pull of the closed form at full slip, up to which the pull rises where no file says more
)
BEFORE, PULLED = "before the pull", "pulled"
HEADS = {
    "slip": "slip",
    "pull": "pull in N",
    "torque": "torque in N m",
    "efficiency": "efficiency",
    "sinkage": "sinkage in m",
    "resistance": "motion resistance in N",
    "closed": "pull in closed form in N",
}
"""Columns of the table."""


@dataclass(frozen=True)
class DrawbarTest:
    """Pull of a drawbar test."""

    pull: float | None = None  # N, greatest; None: `GREATEST` of the closed form
    rise: float | None = None  # s, in which it rises; None: by `RISE_LENGTHS`
    height: float = 0.0  # m, of the drawbar above the ground; at 0 it shifts no load to the rear


def pulled_case(case_file: CaseFile, test: DrawbarTest) -> CaseFile:
    """Case of a test: the pull is part of the machine's load, and the run lasts until it is greatest.

    Raises
    ------
    ValueError
        If the case has no closed track on cells, does not go forward, or has a load that changes.
    """
    case = case_file.case
    track = even_track(case)
    speed = float(case.drive.speed.values[-1])
    if speed <= 0.0:
        raise ValueError(f"drive.speed must end above zero in a drawbar test, got {speed:g} m/s")
    if case.machine is not None and len(case.machine.phases) > 1:
        raise ValueError(f"machine must have one phase in a drawbar test, got {len(case.machine.phases)}")
    if test.rise is not None and test.rise <= 0.0:
        raise ValueError(f"rise must be greater than zero, got {test.rise:g} s")
    greatest = GREATEST * float(track.pull(np.array([1.0]))[0]) if test.pull is None else test.pull
    if greatest <= 0.0:
        raise ValueError(
            f"pull must be greater than zero, got {greatest:g} N: the track's strength is "
            f"{track.strength:.4g} N, its resistance {track.resistance:.4g} N"
        )
    begin = float(case.drive.speed.times[-1]) + START_LENGTHS * track.length / speed
    end = begin + (RISE_LENGTHS * track.length / speed if test.rise is None else test.rise)
    forces, moments = (part[0] for part in case.machine_wrench(0.0))
    arm = test.height - float(case.running_gear().frame_start(case.shoe, case.track)[2])
    phases = [
        MachinePhase(
            name=name,
            end=time,
            force=(float(forces[0]) - pull, *forces[1:].tolist()),
            moment=(float(moments[0]), float(moments[1]) - arm * pull, float(moments[2])),
        )
        for name, time, pull in ((BEFORE, begin, 0.0), (PULLED, end, greatest))
    ]
    pulled = case.with_(machine=MachineCycle(phases=tuple(phases)))
    return case_file.with_(case=pulled, duration=end)


def pull_over_time(case: Case, time: np.ndarray) -> np.ndarray:
    """Pull of the drawbar: what pulls the machine back more than at t = 0; array of the times' shape, N."""
    force, _ = case.machine_wrench(time)
    begin, _ = case.machine_wrench(0.0)
    return begin[0, 0] - force[:, 0]


def drawbar_table(history: History) -> pd.DataFrame:
    """Table of a test: columns of `HEADS` in SI units, a row for the passage of each shoe.

    Slip is that of the way: ``1 - way of the machine / way of the chain``. Efficiency is the pull's work over
    that of the drive, motion resistance the drive's work by the way of the chain less the pull, so that it
    has the ground's and that of wheels and chain. ValueError if the history is of no drawbar test.
    """
    case = history.case
    track = even_track(case)
    time = history.time.values
    pull = pull_over_time(case, time)
    if pull.max() <= 0.0:
        raise ValueError(
            f"case {case.name!r} must have a machine whose force pulls back, as drawbar makes it"
        )
    gear: Any = case.gear
    turn = _by_track(history, "tumbler_angle", gear.tracks)
    torque = _by_track(history, "drive_moment", gear.tracks)
    chain = gear.travel_per_angle(case.track) * (turn - turn[0]).mean(axis=1)
    way = history.side_frame_position.sel(axis="x").values
    contacts = history.contacts_by_shoe()
    area = contacts.area.transpose("time", "shoe").values
    depth = contacts.penetration.transpose("time", "shoe").values
    sinkage = np.sum(area * depth, axis=1) / np.maximum(area.sum(axis=1), 1e-12)
    work = _summed(np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(turn, axis=0), axis=1))
    pulling = _summed(0.5 * (pull[1:] + pull[:-1]) * np.diff(way))
    pitch = gear.chain_pitch(case.track)
    marks = np.arange(np.interp(_begin(case), time, chain), chain[-1] + 1e-9, pitch)
    edges = np.interp(marks, chain, time)

    def gained(values: np.ndarray) -> np.ndarray:
        return np.diff(np.interp(edges, time, values))

    def mean(values: np.ndarray) -> np.ndarray:
        integral = _summed(0.5 * (values[1:] + values[:-1]) * np.diff(time))
        return gained(integral) / np.diff(edges)

    slip = 1.0 - gained(way) / gained(chain)
    rows = {
        "slip": slip,
        "pull": mean(pull),
        "torque": mean(torque.sum(axis=1)),
        "efficiency": gained(pulling) / gained(work),
        "sinkage": mean(sinkage),
        "resistance": gained(work) / gained(chain) - mean(pull),
        "closed": np.where(slip > 0.0, track.pull(np.maximum(slip, 1e-6)), math.nan),
    }
    return pd.DataFrame(rows).rename(columns=HEADS)


def _summed(steps: np.ndarray) -> np.ndarray:
    """Running sum from zero: array one longer."""
    return np.concatenate((np.zeros(1), np.cumsum(steps)))


def _begin(case: Case) -> float:
    """Time at which the pull begins, s."""
    assert case.machine is not None
    return case.machine.phases[-2].end if len(case.machine.phases) > 1 else 0.0


def _by_track(history: History, name: str, tracks: int) -> np.ndarray:
    """Quantity of the tumblers: array (times, tracks)."""
    return history.quantity(name).values.reshape(len(history.time), tracks)


@dataclass(frozen=True)
class DrawbarResult:
    """What a drawbar test says in numbers."""

    greatest_pull: float  # N
    slip_there: float
    pull_at_slip: float  # N, at the slip that was asked for; NaN where the test does not reach it
    coefficient: float  # greatest pull over weight
    gradeability: float  # rad, of the grade on which that coefficient is used up
    motion_resistance: float  # N, before the pull
    best_efficiency: float
    track: EvenTrack


def drawbar_result(history: History, slip: float = 0.2) -> DrawbarResult:
    """Numbers of a test; a machine climbs a grade whose tangent is the greatest pull over its weight."""
    table = drawbar_table(history).rename(columns={head: name for name, head in HEADS.items()})
    track = even_track(history.case)
    best = table.loc[table["pull"].idxmax()]
    rising = table[table["slip"].cummax() <= table["slip"]]
    reached = slip <= table["slip"].max()
    return DrawbarResult(
        greatest_pull=float(best["pull"]),
        slip_there=float(best["slip"]),
        pull_at_slip=float(np.interp(slip, rising["slip"], rising["pull"])) if reached else math.nan,
        coefficient=float(best["pull"]) / track.weight,
        gradeability=math.atan(float(best["pull"]) / track.weight),
        motion_resistance=float(table["resistance"].iloc[0]),
        best_efficiency=float(table["efficiency"].max()),
        track=track,
    )


def result_rows(result: DrawbarResult, slip: float) -> list[tuple[str, float, str]]:
    """Rows of a test's numbers for reading: name, value, unit."""
    track = result.track
    return [
        ("greatest pull", 1e-3 * result.greatest_pull, "kN"),
        ("slip there", 100.0 * result.slip_there, "%"),
        (f"pull at {100.0 * slip:g} % slip", 1e-3 * result.pull_at_slip, "kN"),
        ("greatest pull over weight", result.coefficient, ""),
        ("gradeability", math.degrees(result.gradeability), "deg"),
        ("motion resistance", 1e-3 * result.motion_resistance, "kN"),
        ("best efficiency", result.best_efficiency, ""),
        ("weight", 1e-3 * track.weight, "kN"),
        ("mean pressure", 1e-3 * track.pressure, "kPa"),
        ("strength in closed form", 1e-3 * track.strength, "kN"),
        ("resistance of compaction in closed form", 1e-3 * track.resistance, "kN"),
        (
            f"pull at {100.0 * slip:g} % slip in closed form",
            1e-3 * float(track.pull(np.array([slip]))[0]),
            "kN",
        ),
    ]
