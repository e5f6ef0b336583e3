"""Comparison with public measurements: numbers of `reported.csv`, and trends if only those are public.

Numbers of the program are fitted only to rows of the class "fit". `docs/measured.md` has the sources, and
how much of each was seen.
"""

from collections.abc import Callable
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from exudyn_crawler import Case, CaseFile, History, StepProfile, read_case, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.files import writable_folder
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.machines.datasheet.library import machines
from exudyn_crawler.results import drive_work
from exudyn_crawler.results.history.tension import roller_clearances
from exudyn_crawler.results.measured import drawbar
from exudyn_crawler.results.measured.soil_fit import fit_plates
from exudyn_crawler.results.measured.soil_stress import CONCENTRATION
from exudyn_crawler.results.measured.soil_tests import PlateTests, read_plates
from exudyn_crawler.run.solve.standing import standing
from studies.comparison import comparison_table, reported_values
from studies.running import save

SINKAGE = 0.02  # m, sinkage at which pressures of plates are compared
LOADS, PRESSURES = (11e3, 15e3, 33e3), (70e3, 100e3, 150e3)
"""Wheel loads, N, and inflation pressures, Pa, of Arvidsson and Keller (2007)."""
TOPSOIL, SUBSOIL = 0.1, 0.7  # m, least and greatest depth of their sensors
TENSIONS = (90e3, 300e3, 550e3)
"""Pretensions of the 4100C's chain, N: nearly the whole possible range on sand."""
LOADED = 0.02  # force above which a shoe counts as loaded, fraction of that on the most loaded shoe
SPEED = 0.5  # m/s, chain speed in drawbar tests
SLIP = 0.2  # slip of Turnage's pulls
SECOND_WHEEL = 9.5, 15.9
"""Clearance of an M113's upper run above its second road wheel, mm; TM 9-2350-247-10, p. 0058 00-3."""
STARTED = 1.0  # s, end of the rise of the speed of a machine from a datasheet
TOUCHES = 0.1  # mm, clearance below which the run lies on a wheel


class Trend(NamedTuple):
    """Measured trend, and the result of the program."""

    measurement: str
    measured: str
    here: str
    agrees: bool


def plates(box: str) -> PlateTests:
    """Return the first loading of the plates in the "large" or the "small" box of sand."""
    with as_file(files("studies").joinpath(f"measured/plates_{box}_box.csv")) as path:
        return read_plates(path).split()[0]


def measured_pressure(tests: PlateTests) -> float:
    """Return the pressure at `SINKAGE`, Pa, interpolated: mean over the tests of one plate."""
    each = [np.interp(SINKAGE, tests.sinkage[points], tests.pressure[points]) for points in tests.each()]
    return float(np.mean(each))


def _by_law(tests: PlateTests, width: float) -> float:
    """Return the pressure (Pa) at `SINKAGE` below a plate of a width (m) by the law fitted to tests."""
    fit, _ = fit_plates(tests)
    modulus = (fit.number("k_c") / width if "k_c" in fit.names else 0.0) + fit.number("k_phi")
    return float(modulus * SINKAGE ** fit.number("exponent"))


def compare_plates() -> pd.DataFrame:
    """Compare plates in sand: laws of the large box, and measured pressures in the small one."""
    large = plates("large")
    reported = reported_values("measured")
    computed = []
    for row in reported.itertuples():
        width = 1e-3 * float(str(row.quantity).split()[3])
        tests = plates("small") if row.case == "law of the same tests" else large
        alone = tests if row.case == "law of all plates" else tests.of(tests.width == width)
        computed.append(1e-3 * _by_law(alone, width))
    return comparison_table(reported, computed)


def below_wheel(load: float, pressure: float, depth: float, concentration: float = CONCENTRATION) -> float:
    """Return the stress (Pa) at a depth (m) below a wheel's evenly loaded circle, by Froehlich."""
    radius = np.sqrt(load / (np.pi * pressure))
    return float(pressure * (1.0 - (1.0 + (radius / depth) ** 2) ** (-0.5 * concentration)))


def wheel_trend() -> Trend:
    """Compare stress below wheels: inflation pressure governs the topsoil, load the subsoil."""
    soft, _, hard = PRESSURES
    light, _, heavy = LOADS
    by_pressure = [below_wheel(heavy, hard, z) / below_wheel(heavy, soft, z) for z in (TOPSOIL, SUBSOIL)]
    by_load = [below_wheel(heavy, soft, z) / below_wheel(light, soft, z) for z in (TOPSOIL, SUBSOIL)]
    return Trend(
        "stress in soil below wheels of 11 to 33 kN at 70 to 150 kPa",
        "inflation pressure has a large influence 0.1 m deep and very little in the subsoil, where load has",
        f"150 over 70 kPa: {by_pressure[0]:.2f} times as much 0.1 m deep, {by_pressure[1]:.2f} 0.7 m deep; "
        f"33 over 11 kN: {by_load[0]:.2f} and {by_load[1]:.2f}",
        by_pressure[0] > 1.5 and by_pressure[1] < 1.3 and by_load[1] > 2.0,
    )


def _closed(drive: Drive, pretension: float | None = None, load: float = 1.0) -> Case:
    """Return half of the 4100C, load centred, on LETE sand that keeps ruts, without rolling resistance."""
    case = Case.closed()
    gear: Any = case.gear
    idler = gear.idler
    if pretension is not None:
        idler = idler.with_(pretension=pretension, slack=None)
    gear = gear.with_(rolling_resistance=0.0, com=(0.0, 0.0, gear.com[2]), idler=idler, mass=load * gear.mass)
    solver = case.solver.with_(step=5e-3, output_interval=0.05)
    return case.with_(gear=gear, drive=drive, solver=solver).on_cells(
        BekkerSoil.lete_sand("chrono"), cell=0.2
    )


def evenness(history: History) -> float:
    """Return the ratio of greatest to mean pressure of the loaded shoes at the end of a run."""
    force = history.contacts_by_shoe().normal_force.sel(axis="z").isel(time=-1).values
    loaded = force[force > LOADED * force.max()]
    return float(loaded.max() / loaded.mean())


def tension_trend(say: Callable[[str], None]) -> Trend:
    """Compare the evenness of pressure below a standing track by its tension."""
    ratios = []
    for tension in TENSIONS:
        case = _closed(Drive(speed=StepProfile.constant(0.0)), tension)
        ratios.append(evenness(simulate(case, 0.01, progress=False)))
        say(f"pretension {tension:.3g} N: greatest over mean pressure {ratios[-1]:.3f}")
    numbers = ", ".join(f"{value:.2f}" for value in ratios)
    tensions = ", ".join(f"{1e-3 * value:g}" for value in TENSIONS)
    return Trend(
        "ground pressure of a crawler harvester by track tension",
        "with weak tension the pressure is no longer even along the track",
        f"greatest over mean pressure {numbers} at {tensions} kN",
        ratios == sorted(ratios, reverse=True),
    )


def adjustment_trend(say: Callable[[str], None]) -> Trend:
    """Compare the clearances of the library's M113 between upper run and road wheels."""
    machine = standing(read_case(machines()["m113"]).case, progress=False)
    assert machine is not None  # it has a machine
    gaps = 1e3 * roller_clearances(machine.case, machine.history.dataset.isel(time=0))
    numbers = ["; ".join(f"{gap:.1f}" for gap in track) for track in gaps]
    say(f"M113: gaps of the upper run to its road wheels, from the sprocket: {numbers} mm")
    least, greatest = SECOND_WHEEL
    return Trend(
        "gap between the upper run and the second road wheel of an M113",
        f"{least:g} to {greatest:g} mm where the run touches the third",
        f"{' and '.join(f'{gap:.1f}' for gap in gaps[:, 1])} mm, and {gaps[:, 2].max():.1f} mm to the third",
        bool(np.all((gaps[:, 1] > least) & (gaps[:, 1] < greatest)) and gaps[:, 2].max() < TOUCHES),
    )


class Resisted(NamedTuple):
    """Run of an M113 on a hard floor."""

    pins: str
    speed: float  # km/h
    pretension: float | None = None  # N; none: that of its manual


RESISTED = {
    "slow": Resisted("rubber", 5.0),
    "fast": Resisted("rubber", 20.0),
    "slack": Resisted("rubber", 5.0, 12e3),
    "needles": Resisted("needles", 5.0),
}
"""Speeds of the classes of pins in Wong's book (remembered), their pins, and half of the pretension."""


def motion_resistance(run: Resisted) -> float:
    """Return the mean pull of an M113's drive over the weight, at constant speed and without inertia."""
    file = read_case(machines()["m113"], [f"datasheet.speed={run.speed / 3.6}"])
    case = file.case.on_cells(RockFloor.hard_floor()).with_({"track.pin.kind": run.pins})
    if run.pretension is not None:
        case = case.with_({"gear.idler.pretension": run.pretension})
    history = simulate(case, STARTED + 2.0, progress=False)
    power = drive_work.drive_work(history).set_index("where")[drive_work.POWER]
    late = history.side_frame_position.sel(axis="x", time=history.time >= STARTED)
    speed = abs(float((late[-1] - late[0]) / (late.time[-1] - late.time[0])))
    mass = sum(part.mass for part in case.gear.frame_parts) + case.track.shoe_count * case.shoe.mass
    return float(1e3 * (power[drive_work.DRIVE] - power["inertia"]) / (speed * mass * case.gravity))


def resistance_trend(say: Callable[[str], None]) -> Trend:
    """Compare the motion resistance of the library's M113 on hard ground by speed, pretension and pins."""
    found = {}
    for name, run in RESISTED.items():
        found[name] = motion_resistance(run)
        say(f"M113, {name} ({run.pins}, {run.speed:g} km/h): resistance {found[name]:.4f} of the weight")
    return Trend(
        "motion resistance of tracked vehicles on hard ground over their weight",
        "0.024 at 5 km/h, 0.029 at 20 (mean of vehicles); 0.046 and 0.049 with pins in rubber, 0.026 with "
        "needle bearings at 5; it grows with the speed",
        f"{found['slow']:.3f} and {found['fast']:.3f} with rubber, {found['needles']:.3f} with needles; "
        f"{found['slack']:.3f} with rubber and half of the pretension",
        found["needles"] < found["slow"] < found["fast"] and found["slack"] < found["slow"],
    )


def pull_at_slip(case: Case) -> tuple[float, float]:
    """Return the pull at `SLIP` of a case in a drawbar test, N, and as a fraction of the weight."""
    test = drawbar.pulled_case(CaseFile(case=case, duration=1.0), drawbar.DrawbarTest((SLIP,)))
    result = drawbar.drawbar_result(simulate(test.case, test.duration, progress=False), SLIP)
    return result.pull_at_slip, result.pull_at_slip / result.track.weight


def pull_trends(say: Callable[[str], None]) -> list[Trend]:
    """Compare the pull at 20 % slip by load and by tension."""
    drive = Drive(speed=StepProfile(times=(0.0, 2.0), values=(0.0, SPEED)))
    cases = {
        "as it is": _closed(drive),
        "half load": _closed(drive, load=0.5),
        "slack": _closed(drive, TENSIONS[0]),
        "tight": _closed(drive, TENSIONS[-1]),
    }
    pulls = {}
    for name, case in cases.items():
        pulls[name] = pull_at_slip(case)
        say(f"{name}: pull at 20 % slip {pulls[name][0]:.4g} N, {pulls[name][1]:.4f} of the weight")
    usual, half, slack, tight = (pulls[name] for name in cases)
    by_tension = tight[0] / slack[0]
    return [
        Trend(
            "pull of a model track in sand at 20 % slip by load",
            "load is among the variables that govern it",
            f"0.64 of the weight pulls {half[0] / usual[0]:.3f} of the pull, {half[1]:.3f} of it in place of "
            f"{usual[1]:.3f}",
            half[0] < 0.7 * usual[0],
        ),
        Trend(
            "pull of a model track in sand at 20 % slip by tension",
            "high tension in the belt raises it slightly",
            f"550 kN of pretension in place of 90: {100.0 * (by_tension - 1.0):+.1f} %, in place of some "
            f"250: {100.0 * (tight[0] / usual[0] - 1.0):+.1f} %",
            slack[0] < usual[0] < tight[0] < 1.1 * usual[0],
        ),
    ]


def study(
    out: Path | None, runs: bool = False, say: Callable[[str], None] = print
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tabulate rows with numbers, and trends; with `runs` also trends from runs (three minutes)."""
    if out is not None:
        writable_folder(out)
    rows = compare_plates()
    trends = [wheel_trend()]
    if runs:
        trends += [adjustment_trend(say), resistance_trend(say), tension_trend(say), *pull_trends(say)]
    table = pd.DataFrame(trends)
    save(out, comparison=rows, trends=table)
    return rows, table
