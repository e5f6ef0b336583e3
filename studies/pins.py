"""Friction of link pins: work of a pin in a lap, power of the drive, and whether the chain rattles.

A lap of one pin is what all pins do while the chain moves on by one pitch: each run covers whole pitches at
constant speed.
"""

from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple, Unpack

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure
from scipy.signal import welch

from exudyn_crawler import CaseFile, History, read_case
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.machines.case_file import BARE
from exudyn_crawler.results import drive_work
from exudyn_crawler.results.wear.work import REGIONS, run_work
from exudyn_crawler.views import style
from studies.running import Running, save, study_runs

MACHINE = "pc300lc"
PITCHES = 5
"""Pitches of travel at constant speed."""
START = 0.9
"""Time at which the speed is constant and the start has died away, s."""
SWEEP = 20.0  # deg
RATTLE = 15.0
"""Frequency above which forces that follow the pitch have died away, Hz."""
HARD_SAG = 0.025
"""Sag on the hard floor, m: its lower run leaves the chain no 20 mm."""


SHOWN = ("ideal", "greased", "dry")
"""Runs in the picture."""


class Run(NamedTuple):
    """Pins, speed and ground of a run."""

    kind: str
    speed: float  # m/s
    ground: str = "sand"


RUNS = {
    "ideal": Run("ideal", 0.6),
    "greased": Run("greased", 0.6),
    "dry": Run("dry", 0.6),
    "greased, half speed": Run("greased", 0.3),
    "greased, slow": Run("greased", 0.1),
    "greased, hard floor": Run("greased", 0.3, "hard floor"),
}


def case_file(run: Run) -> CaseFile:
    """Return the case of a run: the machine travels straight."""
    library = files("exudyn_crawler.machines.datasheet") / "library"
    file = read_case(str(library / f"{MACHINE}.toml"), [f'track.pin.kind="{run.kind}"'])
    case = file.case
    if run.ground == "hard floor":
        case = case.on_cells(RockFloor.hard_floor()).with_({"gear.idler.sag": HARD_SAG})
    changes: dict[str, Any] = {
        "drive.speed.times": (0.0, START - 0.2),
        "drive.speed.values": (0.0, run.speed),
        # the same part of the friction at every speed
        "track.pin.friction_rate": case.track.pin.friction_rate * run.speed / RUNS["ideal"].speed,
        "solver.output_interval": 4.0 * case.solver.step,
    }
    travel = PITCHES * case.track.pitch / run.speed
    return file.with_(case=case.with_(changes), duration=START + travel, outputs=BARE)


def lap(history: History) -> dict[str, float]:
    """Return the work of a pin in a lap (kJ) by region, and powers and fluctuations at constant speed."""
    radius = history.case.track.pin.radius_at(history.case.track.pitch)
    whole = run_work(history, radius, 0.0, START)
    laps = float(whole.laps.mean())
    of_pins = whole.by_place.sel(pair="pin").mean("track").values / whole.shoes
    row = {f"{name} in kJ": 1e-3 * of_pins[whole.regions == k].sum() / laps for k, name in enumerate(REGIONS)}
    row["whole path in kJ"] = 1e-3 * whole.pins_by_threshold[0.0] / laps
    row[f"sweeps of {SWEEP:g} deg in kJ"] = 1e-3 * whole.pins_by_threshold[SWEEP] / laps
    row["closed form in kJ"] = 1e-3 * whole.by_tensions / laps
    powers = drive_work.drive_work(history).set_index("where")[drive_work.POWER]
    row["drive in kW"] = powers[drive_work.DRIVE]
    row["pins in kW"] = powers.get("pins", 0.0)
    late = history.dataset.isel(time=history.time >= START)
    row["torque in kN m"] = 1e-3 * abs(float(late.drive_moment.mean()))
    row["greatest tension in kN"] = 1e-3 * float(late_tension(history).max())
    for name, frequency, density in densities(history):
        above = frequency >= RATTLE
        row[f"{name} above {RATTLE:g} Hz, rms"] = float(np.sqrt(density[above].sum() * frequency[1]))
    return row


def late_tension(history: History) -> xr.DataArray:
    """Return the tension of the links at constant speed, N: (time, joint)."""
    return history.quantity("link_tension").isel(time=history.time >= START)


def densities(history: History) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield name with unit, frequencies (Hz) and mean power spectral density of torque and tension."""
    late = history.drive_moment.isel(time=history.time >= START)
    rate = (late.time.size - 1) / float(late.time[-1] - late.time[0])
    for name, values in (("torque in kN m", late), ("tension in kN", late_tension(history))):
        series = 1e-3 * np.atleast_2d(values.transpose(..., "time").values)
        frequency, density = welch(series, rate, nperseg=min(256, series.shape[-1]))
        yield name, frequency, density.mean(axis=0)


def spectra(histories: Mapping[str, History]) -> Figure:
    """Draw the power spectral densities of torque and tension at constant speed."""
    with style.titled_figure("Torque and tension at constant speed over frequency", 9.0, 4.0) as figure:
        axes = figure.subplots(1, 2)
        for label, history in histories.items():
            for ax, (name, frequency, density) in zip(axes, densities(history), strict=True):
                ax.semilogy(frequency[1:], density[1:], label=label)
                ax.set(xlabel="frequency in Hz", ylabel=f"density of {name}, squared over Hz")
        axes[0].legend()
    return figure


def study(out: Path | None = None, **how: Unpack[Running]) -> pd.DataFrame:
    """Run the machine with each kind of pin and tabulate the laps; `out` gets `pins.csv` and `spectra.png`.

    Errors are those of `study_runs`.
    """
    cases = {name.replace(", ", "_").replace(" ", "_"): case_file(run) for name, run in RUNS.items()}
    with study_runs(out, cases, **how) as runs:
        histories = {name: run.history for name, run in zip(RUNS, runs.values(), strict=True)}
        table = pd.DataFrame(
            [{"run": name, **RUNS[name]._asdict(), **lap(history)} for name, history in histories.items()]
        )
        save(out, pins=table)
        if out is not None:
            drawn = {name: histories[name] for name in SHOWN}
            style.save_figure(spectra(drawn), out / "spectra.png", overwrite=True)
    return table
