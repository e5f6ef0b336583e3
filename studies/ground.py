"""Machine rolling over ground of cells: sand, a range of oil sand, hard floor with ruts, stones and ridges.

No paper reports this study. The papers' ground of units is compared: there a shoe sinks by 66 mm under its
share of the machine. It tilts, and the rollers' climb is most of the pull. Two trials separate the cost of
sinkage. In one, sand springs back along the line to its start and keeps no rut. In the other, the machine
passes a second time in the ruts of the first. All other soils keep their ruts. Powers of rigid shoes show the
parts of the pull.
"""

from pathlib import Path
from typing import Literal, Unpack

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from exudyn_crawler import Case, CaseFile, Duty, FatigueMaterial, FlexibleShoes, History
from exudyn_crawler.case import Heights, statics
from exudyn_crawler.case.gear.rolled import Rolled
from exudyn_crawler.case.parameters.heights import Ridge, Stone
from exudyn_crawler.case.parameters.terrain import CellContact, CellTerrain
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.machines import Outputs
from exudyn_crawler.results.balance import energy_balance
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import in_words, life_of
from exudyn_crawler.run.folder.record import HISTORY
from studies.rollers import highest_by_region, rolled_case
from studies.running import Running, by_name, save, study_runs

FLEXIBLE = 20  # number of the flexible shoe of every case
PASS_DURATION = 60.0  # s, time for five of the six rollers to pass over the flexible shoe
PAPERS = "papers' units"
AGAIN = "second pass"
SOFT = "oil sand, soft end"
KEEPS_RUTS: Literal["wong", "chrono"] = "chrono"
"""Unloading law of soils that keep nearly all of their sinkage as a rut."""
KILO = 1e3


def reliefs() -> dict[str, Heights]:
    """Return reliefs of a hard floor; their shapes are chosen here."""
    case = Case.rolled()
    (x0, x1) = case.terrain.bounds[0]
    y = case.track.first_com[1]
    edge = 0.5 * case.shoe.width - 0.3
    ridges = [Ridge(x=x, y=y, height=0.1, width=0.2, flank=0.3) for x in np.arange(x0, x1 + 20.0, 2.0)]
    ruts = [
        Ridge(x=x0, y=y + side * edge, heading=0.0, height=-0.1, width=0.6, flank=0.3) for side in (-1.0, 1.0)
    ]
    # a stone under one edge of a shoe, and another under the other edge of the second next shoe
    places = [(x, y + (-1.0) ** k * edge) for k, x in enumerate(np.arange(x0 + 1.0, x1 + 20.0, 1.3))]
    stones = [Stone(x=x, y=across, height=0.08, width=0.2, flank=0.2) for x, across in places]
    return {
        "hard floor": Heights(),
        "hard floor, ruts under both edges": Heights(parts=tuple(ruts)),
        "hard floor, stones under the edges": Heights(parts=tuple(stones)),
        "hard floor, ridges 2 m apart": Heights(parts=tuple(ridges)),
    }


def study_cases(
    mesh: str = "coarse", duration: float = PASS_DURATION, out: Path | None = None
) -> dict[str, CaseFile]:
    """Return the cases of the study, each over `duration` (s).

    Second passes start in the ruts that the first passes left in the study's folder; without `out` there are
    none.
    """
    flexible = FlexibleShoes.ph4100c(mesh).with_(shoes=(FLEXIBLE,))
    base = rolled_case(mesh).with_(flexible=flexible)
    soils = {
        "LETE sand": BekkerSoil.lete_sand(KEEPS_RUTS),
        SOFT: BekkerSoil.oil_sand_low(KEEPS_RUTS),
        "oil sand, stiff end": BekkerSoil.oil_sand_high(KEEPS_RUTS),
    }
    soft = {name: soils[name] for name in ("LETE sand", SOFT)}
    soils |= {f"{name}, springs back": law.with_(reload_stiffness=0.0) for name, law in soft.items()}
    cases = {PAPERS: base} | {name: base.on_cells(law) for name, law in soils.items()}
    cases |= {name: base.on_cells(RockFloor.hard_floor(), relief) for name, relief in reliefs().items()}
    if out is not None:
        before = {name: (out / name / HISTORY).resolve() for name in soft}
        cases |= {f"{name}, {AGAIN}": cases[name].with_({"terrain.ruts": before[name]}) for name in soft}
    start = Outputs(ground_times=(0.0,))
    return {
        name: CaseFile(case=case.with_(name=name), duration=duration, outputs=start)
        for name, case in cases.items()
    }


def covered(history: History) -> np.ndarray:
    """Return the share of each cell below undersides at the end of a run, from above; shoes stand along x."""
    cell = history.case.part(CellTerrain).cell
    (x0, x1, y0, y1, _) = history.case.shoe.footprint
    place = history.position.isel(time=-1).values

    def part(first: xr.DataArray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        edge = cell * first.values[:, None]
        return np.clip(np.minimum(high, edge + cell) - np.maximum(low, edge), 0.0, None) / cell

    x = part(history.cell_column, place[:, 0] + x0, place[:, 0] + x1)
    y = part(history.cell_row, place[:, 1] + y0, place[:, 1] + y1)
    return (x * y).sum(axis=1)


def retained_work(
    history: History, sinkage: xr.DataArray, pressure: xr.DataArray, share: ArrayLike = 1.0
) -> float:
    """Return the work (J) that cells keep after loading to their greatest sinkages (m) and pressures (Pa).

    Shoes press on a `share` of every cell.
    """
    law = history.case.part(CellContact).law
    shoe = history.case.shoe
    if not isinstance(law, BekkerSoil):
        return 0.0
    constants = law.constants(min(shoe.length, shoe.width))
    z = sinkage.values
    p = pressure.values
    modulus = np.array([law.kernel.prepare(constants, *pair)[0] for pair in zip(z, p, strict=True)])
    given_back = np.divide(0.5 * p**2, modulus, out=np.zeros_like(p), where=modulus > 0.0)
    work = share * (p * z / (law.exponent + 1.0) - given_back)
    return history.case.part(CellTerrain).cell ** 2 * float(work.sum())


def work_balance(history: History) -> dict[str, float]:
    """Return the work kept by the ground, and the work of drive and sinking less the rolling resistance.

    The works are mean forces over the distance travelled, in kN. The work kept is unknown on units.
    """
    case = history.case
    frame = history.case.part(Rolled)
    x, height = (history.side_frame_position.sel(axis=axis).values for axis in "xz")
    resistance = frame.rolling_resistance * frame.mass * case.gravity
    shoes = history.position.sel(axis="z").sum("shoe").values
    fallen = case.gravity * (frame.mass * (height[0] - height[-1]) + case.shoe.mass * (shoes[0] - shoes[-1]))
    pulled = np.trapezoid(history.drive_pull.values, x) - resistance * (x[-1] - x[0])
    works = {"pull beyond rolling": pulled, "given by sinking": fallen}
    if history.has("cell_sinkage_then"):
        begin = history.dataset.isel(ground_time=0)
        share = covered(history)
        end = retained_work(history, history.cell_sinkage, history.cell_pressure, share)
        start = retained_work(history, begin.cell_sinkage_then, begin.cell_pressure_then, share)
        works["kept by the ground"] = end - start
    return {f"{name}, kN over the distance": work / (x[-1] - x[0]) / KILO for name, work in works.items()}


def row(run: CaseRun) -> dict[str, float]:
    """Return pull, tilt, sinkage and loads of a run."""
    history = run.history
    tilt = np.abs(history.angles.sel(axis="y").values)
    carried = history.contacts_by_shoe()
    case = history.case
    evenly = float(statics.pressed(case, case.gear.first_loads(case)).mean())
    pressed = carried.normal_force.sel(axis="z").values > 0.25 * evenly
    sunk = np.where(pressed, carried.penetration.values, np.nan)
    heave = history.side_frame_position.sel(axis="z").values
    treads = np.linalg.norm(history.roller_force.values, axis=-1)
    return {
        "mean pull in kN": float(history.drive_pull.mean()) / KILO,
        "greatest pull in kN": float(history.drive_pull.max()) / KILO,
        "greatest tilt of a shoe in mrad": KILO * float(tilt.max()),
        "mean sinkage in mm": KILO * float(np.nanmean(sunk)),
        "greatest sinkage in mm": KILO * float(np.nanmax(sunk)),
        "heave of the frame in mm": KILO * float(np.ptp(heave)),
        "greatest force on a rail in kN": float(treads.max()) / KILO,
    } | work_balance(history)


def power_cases(duration: float | None = None, out: Path | None = None) -> dict[str, CaseFile]:
    """Return the cases of `power_study` with rigid shoes, each over its own duration (s), at most `duration`.

    The first is the machine of `study_cases` without its flexible shoe. Its second pass is in the ruts
    that the first left in the folder. The others are trials over 24 shoes. With the longest K slip is nearly
    elastic.
    """
    lete = BekkerSoil.lete_sand(KEEPS_RUTS)
    soft = BekkerSoil.oil_sand_low(KEEPS_RUTS)
    back = soft.with_(reload_stiffness=0.0)
    trials = {
        f"{SOFT}, springs back": (back, 30.0),
        f"{SOFT}, springs back, 20 s": (back, 20.0),
        f"{SOFT}, springs back, K of 100 mm": (back.with_(shear_deformation=0.1), 20.0),
        f"{SOFT}, springs back, undamped": (back.with_(shear_viscosity=0.0, damping=0.0), 20.0),
        "LETE sand, springs back": (lete.with_(reload_stiffness=0.0), 20.0),
        "LETE sand, 20 s": (lete, 20.0),
    }
    first = rolled_case().with_(flexible=None).on_cells(lete)
    cases = {"LETE sand": (first, PASS_DURATION)}
    if out is not None:
        ruts = {"terrain.ruts": (out / "LETE sand" / HISTORY).resolve()}
        cases[f"LETE sand, {AGAIN}"] = first.with_(ruts), PASS_DURATION
    cases |= {name: (Case.rolled().on_cells(law), time) for name, (law, time) in trials.items()}
    return {
        name: CaseFile(case=case.with_(name=name), duration=min(time, duration or time))
        for name, (case, time) in cases.items()
    }


def powers_over_way(history: History) -> dict[str, float]:
    """Return the works of `energy_balance` as mean forces over the distance travelled, kN.

    The first four supply the others. The drive's pull counts without the rolling resistance of the frame's
    weight. Treads count by the work that they take less than this resistance. The chain counts by the work of
    drive and tension on it.
    """
    case = history.case
    work = energy_balance(history).isel(time=-1)
    frame = case.part(Rolled)
    x = history.side_frame_position.sel(axis="x").values
    pulled = np.trapezoid(history.drive_pull.values, x)
    rolling = frame.rolling_resistance * frame.mass * case.gravity * (x[-1] - x[0])
    works = {
        "pull beyond rolling": pulled - rolling,
        "given by sinking": -work.gravitational - work.frame_gravitational,
        "given by the chain": work.drive + work.machine_load - pulled,
        "spared by treads": rolling - work.rolling_resistance - work.tread_damping - work.treads,
        "taken by pressure": work.pressure,
        "taken by shear": work.shear,
        "set in motion": work.kinetic + work.frame_kinetic,
        "left over": work.imbalance,
    }
    return {f"{name} in kN": float(energy) / (x[-1] - x[0]) / KILO for name, energy in works.items()}


def power_study(
    out: Path | None = None, *, duration: float | None = None, **how: Unpack[Running]
) -> pd.DataFrame:
    """Tabulate the parts of the pull from powers of rigid shoes, a row for each case of `power_cases`.

    `out` gets their folders and `powers.csv`. Errors are those of `study_runs`.
    """
    with study_runs(out, power_cases(duration, out), **how) as runs:
        table = pd.DataFrame({"ground": name} | _power_row(run.history) for name, run in runs.items())
        save(out, powers=table)
        return table


def _power_row(history: History) -> dict[str, float]:
    x = history.side_frame_position.sel(axis="x").values
    tilt = np.abs(history.angles.sel(axis="y").values)
    moved = history.position.sel(axis="x")
    return {
        "distance travelled in m": x[-1] - x[0],
        **powers_over_way(history),
        "greatest tilt of a shoe in mrad": KILO * float(tilt.max()),
        "greatest displacement of a shoe in mm": KILO * float(np.abs(moved - moved.isel(time=0)).max()),
    }


def lives_by_region(run: CaseRun) -> pd.DataFrame:
    """Return the flexible shoe's shortest life by region, in hours of propel; the pass repeats."""
    name = run.history.case.name
    only = DutyRun(name="pass", folder=str(run.folder or name), share=1.0)
    duty = Duty(name=name, runs=(only,), material=FatigueMaterial.cast_nicrmo())
    return life_of(duty, [run.history]).table


def study(
    out: Path | None = None,
    mesh: str = "coarse",
    *,
    duration: float = PASS_DURATION,
    **how: Unpack[Running],
) -> tuple[dict[str, CaseRun], pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Roll the machine with one flexible shoe over every ground; return runs by ground, and three tables.

    See `study_cases` for the cases. `out` gets their folders and the tables: `grounds.csv` (pull and stress),
    `regions.csv` and `lives.csv` (highest stresses and shortest lives by region). Errors are those of
    `study_runs`.
    """
    with study_runs(out, study_cases(mesh, duration, out), **how) as runs:
        table = pd.DataFrame({"ground": name} | row(run) for name, run in runs.items())
        regions = by_name("ground", {name: highest_by_region(run) for name, run in runs.items()}).fillna(0.0)
        lives = by_name("ground", {name: lives_by_region(run) for name, run in runs.items()})
        lives = in_words(lives.fillna(0.0))
        highest = regions.groupby("ground")["von Mises in MPa"].max()
        table["highest stress in MPa"] = highest[table["ground"]].values
        save(out, grounds=table, regions=regions, lives=lives)
        return runs, table, regions, lives
