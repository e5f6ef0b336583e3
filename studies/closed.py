"""Closed track: a straight revolution on the papers' ground beside the rolled open track, and turns.

No paper reports this study. The papers' track is open: its tension is an assumed force at its ends, and no
shoe goes over tumbler and idler. The rolled track here has the same rollers, ground and contact. It runs with
its assumed tension, and as a trial with that of the closed track. The machine on two tracks turns about one
of them and on the spot.
"""

from pathlib import Path
from typing import Unpack

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler import Case, CaseFile, FlexibleShoes, History, LoadCycle, StepProfile
from exudyn_crawler.case import Drive, Rolled, ph4100c
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.summary import tension_along_chain
from studies.running import Running, save, study_runs

START = 10.0  # s, end of the machine's start; peaks before it do not count
INTERVAL = 0.02  # s between stored states
TENSION = 8.9e5  # N, tension of the trial: mean of all links of the closed track over its revolution
CUTS = (0.3,)  # m ahead of the tumbler's axis, cuts at which its torque is compared with the tension
OPEN_SHOES, OPEN_DURATION = 31, 70.0  # shoes of the open track; s for all rollers to pass its middle
CLOSED = "closed"
ROLLED = "rolled"
TRIAL = "rolled at the closed tension"
ABOUT_LEFT = "turn about the left track"
ON_SPOT = "turn on the spot"
TURNS = {ABOUT_LEFT: (0.1, 0.02), ON_SPOT: (0.0, 0.03)}
"""Speed (m/s) and turn rate (rad/s) that the machine on two tracks reaches in 1 s."""
TURNING = 6.0  # s, duration of a turn
KILO = 1e3


def closed_case() -> Case:
    """Return half a machine on a closed track of rigid shoes, at the papers' speed on their ground."""
    case = Case.closed()
    return case.with_(solver=case.solver.with_(output_interval=INTERVAL))


def revolution(case: Case) -> float:
    """Return the time (s) of one revolution of a chain, from rest."""
    way = case.track.shoe_count * case.track.pitch
    speed = case.drive.speed
    end = speed.times[-1]
    most = speed.values[-1]
    return float(end + (way - case.drive.travel(end)) / most)


def rolled_case(tension: float = ph4100c.UNDERCARRIAGE["end_tension"]) -> Case:
    """Return the rolled open track with rollers, ground and contact of the closed one; `tension` is in N."""
    closed = closed_case()
    case = Case.rolled()
    frame = Rolled.ph4100c().with_(rollers=closed.part(Closed).rollers, end_tension=tension)
    return case.with_(
        track=case.track.with_(shoe_count=OPEN_SHOES),
        loads=LoadCycle.constant([0.0] * OPEN_SHOES),
        terrain=closed.terrain,
        contact=closed.contact,
        gear=frame,
        solver=case.solver.with_(output_interval=INTERVAL),
    )


def turning_case(speed: float, rate: float) -> Case:
    """Return the machine on two tracks with a drive up to a speed (m/s) and a turn rate (rad/s)."""
    case = Case.shovel()
    profiles = [StepProfile(times=(0.0, 1.0), values=(0.0, goal)) for goal in (speed, rate)]
    drive = Drive(speed=profiles[0], turn_rate=profiles[1])
    return case.with_(drive=drive, solver=case.solver.with_(output_interval=INTERVAL))


def study_cases(
    duration: float | None = None, flexible: int | None = None, mesh: str = "coarse"
) -> dict[str, CaseFile]:
    """Return the cases over at most `duration` (s); `flexible` is the number of a flexible shoe."""
    most = np.inf if duration is None else duration
    closed = closed_case()
    if flexible is not None:
        closed = closed.with_(
            shoe=closed.shoe.of_mass(ph4100c.STRESS_SHOE_MASS),
            flexible=FlexibleShoes.ph4100c(mesh).with_(shoes=(flexible,)),
        )
    cases = {CLOSED: (closed, revolution(closed)), ROLLED: (rolled_case(), OPEN_DURATION)}
    cases[TRIAL] = rolled_case(TENSION), OPEN_DURATION
    cases |= {name: (turning_case(*TURNS[name]), TURNING) for name in TURNS}
    return {
        name: CaseFile(case=case.with_(name=name), duration=min(whole, most))
        for name, (case, whole) in cases.items()
    }


def peaks_in_mid_track(history: History) -> dict[str, float]:
    """Return forces on shoes between the outer rollers' axes, kN: greatest, and mean of acting ones."""
    rollers = history.case.part(RunningGear).rollers
    frame = history.side_frame_position.transpose("time", "axis").values
    place = history.position.transpose("time", "shoe", "axis").values - frame[:, None]
    below = (place[..., 0] > rollers[0]) & (place[..., 0] < rollers[-1]) & (place[..., 2] < 0.0)
    below &= (history.time.values >= min(START, 0.5 * history.duration))[:, None]
    links = history.joint_force.transpose("time", "joint", "axis").values
    names = ["contact_force", "wheel_load" if history.has("wheel_load") else "rail_force"]
    values = [series.transpose("time", "shoe", "axis").values for series in history.over_time(names).values()]
    peaks: dict[str, float] = {}
    kinds = ("ground on a shoe", "wheels on a shoe", "link")
    for name, force in zip(kinds, [*values, links], strict=True):
        size = np.linalg.norm(force, axis=-1)
        size = size[below[:, : size.shape[1]] & (size > 0.0)] / KILO
        peaks |= {f"greatest {name} in kN": float(size.max()), f"mean {name} in kN": float(size.mean())}
    return peaks


def loads_round_the_loop(history: History) -> pd.DataFrame:
    """Tabulate the tension by parts of the loop, and the loads of teeth and wheels, kN."""
    along = tension_along_chain(history)
    late = history.time >= min(START, 0.5 * history.duration)
    parts = [
        {
            "of": f"tension, {part}",
            "least in kN": float(along.least_at[along.part == part].min()) / KILO,
            "mean in kN": float(along.mean_at[along.part == part].mean()) / KILO,
            "greatest in kN": float(along.greatest_at[along.part == part].max()) / KILO,
        }
        for part in dict.fromkeys(along.part.values.tolist())
    ]
    wheel = history.wheel_force.isel(time=late)
    labels = history.case.gear.wheel_labels
    forces = {
        kind: wheel.isel(wheel=[label.kind == kind for label in labels])
        for kind in ("roller", "idler", "carrier")
    }
    forces["teeth on a shoe"] = history.tooth_force.isel(time=late)
    for name, force in forces.items():
        size = np.linalg.norm(force.transpose(..., "axis").values, axis=-1) / KILO
        acts = size[size > 0.0]
        row = {"least in kN": size.min(), "mean in kN": acts.mean(), "greatest in kN": size.max()}
        parts.append({"of": name} | {key: float(value) for key, value in row.items()})
    return pd.DataFrame(parts)


def loads_across(history: History) -> dict[str, float]:
    """Return loads of lugs and pins, kN and kN m: tension, loads across the chain, flanges, teeth, torque."""
    data = history.dataset.isel(time=history.time >= min(START, 0.5 * history.duration))
    late = History(history.case, data)
    left = rotation_matrices(data.side_frame_angles.transpose("time", "axis").values)[..., 1]

    def across(vectors: xr.DataArray) -> np.ndarray:
        return np.einsum("tnc,tc->tn", vectors.transpose("time", ..., "axis").values, left)

    tension = late.quantity("link_tension").values
    ground = late.contacts_by_shoe()
    stands = np.linalg.norm(ground.normal_force.transpose("time", "shoe", "axis").values, axis=-1) > 0.0
    link = across(data.joint_force)
    torque = np.linalg.norm(data.joint_torque.transpose(..., "axis"), axis=-1)
    tooth = np.linalg.norm(data.tooth_force.transpose(..., "axis").values, axis=-1)
    loads = {"least tension in kN": tension.min(), "greatest tension in kN": tension.max()}
    greatest = abs(link).max()
    rms = np.sqrt(np.mean(link**2))
    loads |= {"link across, greatest in kN": greatest, "link across, rms in kN": rms}
    flange = abs(data.guide_force.values).max()
    loads |= {"yaw and roll moment of a link in kN m": torque.max(), "flange on a shoe in kN": flange}
    loads["teeth on a shoe in kN"] = tooth.max()
    moments = np.atleast_1d(data.drive_moment.mean("time").values)
    loads |= {
        f"mean torque, {side} tumbler, in kN m": moment for side, moment in zip(SIDES, moments, strict=False)
    }
    loads["ground across a shoe, mean in kN"] = abs(across(ground.friction_force))[stands].mean()
    return {name: float(value) / KILO for name, value in loads.items()}


def torque_by_tension(history: History, cuts: tuple[float, ...] = CUTS) -> pd.DataFrame:
    """Compare the drive's mean torque over whole pitches with the torque that the tension implies, kN m.

    The chain is cut `cuts` (m) ahead of the tumbler's axis, at pins there or further forward and on no tooth.
    The shoes behind the cut bear the moments of both links about the axis and that of their weight; the
    torque balances them. By work, the torque times an angle is the work that both links and the weight take
    from these shoes. By means of tension, each link acts at the lever n p / (2 pi). The rise of the weight
    counts between the COMs of the shoes that come in and go out: these are further apart than their pins.
    """
    case = history.case
    data = history.dataset
    closed = history.case.part(Closed)
    track = case.track
    weight = case.shoe.mass * case.gravity
    rows = np.arange(history.time.size)
    lever = closed.travel_per_angle(track)
    turning = data.tumbler_speed.values
    pitches = data.tumbler_angle.values * closed.tumbler.shoes_per_turn / (2.0 * np.pi)
    late = int(np.searchsorted(history.time.values, min(START, 0.2 * history.duration)))
    end = np.searchsorted(pitches, pitches[late] + np.floor(pitches[-1] - pitches[late]))
    whole = slice(late, max(int(end), late + 1))
    axis = data.tumbler_position.values[:, None]
    frame = data.side_frame_velocity.values[:, None]
    place = data.position.values - axis
    velocity = data.velocity.values - frame
    force = data.joint_force.values
    arm = rotation_matrices(data.angles.values) @ [track.pin_ahead, 0.0, track.pin_height]
    pin = place + arm
    moving = velocity + np.cross(data.angular_velocity.values, arm)
    records = []
    for ahead in cuts:
        near = np.where(pin[..., 0] > ahead, pin[..., 0], np.inf)
        low, up = (
            np.where(side, near, np.inf).argmin(axis=1) for side in (pin[..., 2] < 0.0, pin[..., 2] > 0.0)
        )
        size, moment, power = (np.zeros((2, len(rows))) for _ in range(3))
        for k, link in enumerate((low, up)):
            p = pin[rows, link]
            f = force[rows, link]
            size[k] = np.hypot(f[:, 0], f[:, 2])
            moment[k] = p[:, 2] * f[:, 0] - p[:, 0] * f[:, 2]
            power[k] = np.sum(f * moving[rows, link], axis=1)
        inside = (np.arange(track.shoe_count) - up[:, None] - 1) % track.shoe_count < (
            (low - up) % track.shoe_count
        )[:, None]
        weights = weight * np.sum(inside * place[..., 0], axis=1)
        rise = weight * np.sum(inside * velocity[..., 2], axis=1)[whole].mean() / turning[whole].mean()
        row = {"cut ahead of the axis in m": ahead, "torque in kN m": data.drive_moment.values[whole].mean()}
        row["by moments in kN m"] = (moment[1] - moment[0] - weights)[whole].mean()
        row["by work in kN m"] = (power[1] - power[0])[whole].mean() / turning[whole].mean() + rise
        row["by means of tension in kN m"] = lever * (size[0] - size[1])[whole].mean() + rise
        records.append(
            {name: float(number) / (KILO if "kN" in name else 1.0) for name, number in row.items()}
        )
    return pd.DataFrame(records)


def study(
    out: Path | None = None,
    *,
    duration: float | None = None,
    flexible: int | None = None,
    mesh: str = "coarse",
    **how: Unpack[Running],
) -> tuple[dict[str, CaseRun], pd.DataFrame, pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Run the closed track and the rolled ones; return the runs by case, and four tables.

    See `study_cases` for the cases. `out` gets their folders and the tables: `loads.csv` (round the loop),
    `torque.csv` (by tension), `peaks.csv` (loads of shoes in mid-track by case) and `turns.csv`. Errors are
    those of `study_runs`.
    """
    with study_runs(out, study_cases(duration, flexible, mesh), **how) as runs:
        loads, torque = (of(runs[CLOSED].history) for of in (loads_round_the_loop, torque_by_tension))
        peaks, turns = (
            pd.DataFrame([{"case": name} | of(runs[name].history) for name in names])
            for of, names in ((peaks_in_mid_track, (CLOSED, ROLLED, TRIAL)), (loads_across, (CLOSED, *TURNS)))
        )
        save(out, loads=loads, torque=torque, peaks=peaks, turns=turns)
        return runs, loads, torque, peaks, turns
