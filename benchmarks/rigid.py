"""Speed and accuracy of the rigid model: the 10 s translation run of the papers."""

import statistics
import time as clock

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler import Case, History, SphereContact, simulate
from exudyn_crawler.views.tables import print_table
from studies.comparison import time_mean

DURATION = 10.0
RUNS = 3
TIGHT = {"step": 0.25e-3, "residual": 1e-2}
"""Solver of the reference run."""
FRONT_JOINT = 12


def run(duration: float, **solver: float) -> History:
    """Translation case with changed solver settings."""
    case = Case.translation()
    return simulate(case.with_(solver=case.solver.with_(**solver)), duration, False)


def timed_runs() -> tuple[list[float], History]:
    """Wall seconds of each run after one that compiles, and the last run's history."""
    run(0.1)
    seconds = []
    for _ in range(RUNS):
        start = clock.perf_counter()
        history = run(DURATION)
        seconds.append(clock.perf_counter() - start)
    return seconds, history


def cost_of_output() -> float:
    """Wall time of a run that stores every step over that of one that stores none but the ends.

    Both in turn, median of the ratios: the machine's speed drifts.
    """
    case = Case.translation()
    quiet = case.solver.with_(output_interval=DURATION)
    ratios = []
    for _ in range(RUNS):
        seconds = []
        for solver in (case.solver, quiet):
            start = clock.perf_counter()
            simulate(case.with_(solver=solver), DURATION, False)
            seconds.append(clock.perf_counter() - start)
        ratios.append(seconds[0] / seconds[1])
    return statistics.median(ratios)


def general_contact_seconds() -> list[float]:
    """Wall seconds of each run with the second contact model, after one that compiles."""
    case = Case.translation().with_(contact=SphereContact.oil_sand())
    simulate(case, 0.1, False)
    seconds = []
    for _ in range(RUNS):
        start = clock.perf_counter()
        simulate(case, DURATION, False)
        seconds.append(clock.perf_counter() - start)
    return seconds


def accuracy(history: History) -> pd.DataFrame:
    """Difference of a run from the tight one: RMS by seconds, and of the 10 s means."""
    tight = run(DURATION, **TIGHT)
    quantities = {
        "front joint force x": lambda h: h.joint_force.sel(joint=FRONT_JOINT, axis="x"),
        "pitch rate, all shoes": lambda h: h.angular_velocity.sel(axis="y"),
    }
    rows = []
    for name, quantity in quantities.items():
        ours, reference = quantity(history), quantity(tight)
        row: dict[str, object] = {"quantity": name}
        for second in range(3):
            window = ours.sel(time=slice(second, second + 1))
            exact = reference.interp(time=window.time)
            rms = np.sqrt(((window - exact) ** 2).mean() / (exact**2).mean())
            row[f"RMS {second}-{second + 1} s"] = f"{float(rms):.2%}"
        row["RMS over 10 s"] = f"{rms_of(ours) / rms_of(reference) - 1:+.2%}"
        row["mean"] = f"{mean_of(ours) / mean_of(reference) - 1:+.2%}" if "force" in name else ""
        rows.append(row)
    return pd.DataFrame(rows)


def rms_of(values: xr.DataArray) -> float:
    """Root mean square over time and shoes."""
    return float(np.sqrt((values**2).mean()))


def mean_of(values: xr.DataArray) -> float:
    """Mean over time."""
    return float(time_mean(values))


def main() -> None:
    """Print the tables that `benchmarks/README.md` keeps."""
    seconds, history = timed_runs()
    median = statistics.median(seconds)
    each = ", ".join(f"{value:.2f}" for value in seconds)
    print(f"10 s translation: median {median / DURATION:.3f} wall s per simulated s (runs: {each} s)")
    print(f"storing everything at every step: {cost_of_output() - 1.0:+.0%} wall time")
    general = general_contact_seconds()
    each = ", ".join(f"{value:.2f}" for value in general)
    print(
        f"the same with contact.model 'spheres': median {statistics.median(general) / DURATION:.3f} "
        f"wall s per simulated s (runs: {each} s)"
    )
    print_table(accuracy(history), f"Difference from a tight run {TIGHT}")


if __name__ == "__main__":
    main()
