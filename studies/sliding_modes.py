"""Cause of the shoes' bouncing: growth of the sliding track's modes by parameter, compared with 10 s runs.

No paper reports this study. The tables are those of `docs/sliding_modes.md`.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler import Case, LoadCycle, PairContact, simulate
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.views.style import save_figure, titled_figure
from exudyn_crawler.views.tables import write_table
from studies.grounds import plain
from studies.sliding import STILL, SteadySliding, eigenmodes, linearized, steady_sliding

SPEED = 0.2  # m/s, above which friction no longer changes with the speed
FRICTION = 0.3
SWINGING = 0.1
"""Least frequency of a swing, Hz."""
COORDINATES = ["x", "y", "z", "roll", "pitch", "yaw"]
"""Coordinates of a shoe: displacement of the COM (m) and angles (rad)."""

SWING = 0.1  # m, greatest motion drawn
PHASES = {"at an instant": 1.0 + 0.0j, "a quarter period later": 1.0j}
"""Drawn instants of a swing, as factors of its shape; the figure shows no growth between them."""


def sliding_modes(case: Case, speed: float, travel: float = 0.0) -> xr.Dataset:
    """Find complex modes of the track on its ground about steady sliding, least stable first.

    A mode moves as the real part of ``shape exp((growth_rate + 2 pi i frequency) t)``. Arguments and errors
    are those of `steady_sliding`.

    Returns
    -------
    xarray.Dataset
        Over `mode`: `growth_rate` (1/s), `frequency` (Hz) and `damping_ratio` (NaN at rest). Complex `shape`
        (mode, shoe, coordinate): displacement of the COM in m and angles in rad. `unit_shape` (mode, unit,
        motion): heave in m and tilt in rad. The greatest motion of a shoe's COM or end is 1 m, real. The
        equilibrium has `position` (shoe, coordinate) from t = 0 before settling, `tension` (joint) and
        `normal_force` (shoe), N.
    """
    state = steady_sliding(case, speed, travel)
    return _dataset(state, *eigenmodes(linearized(state)))


def _dataset(state: SteadySliding, values: np.ndarray, shapes: np.ndarray) -> xr.Dataset:
    case = state.system.case
    contact = state.system.contact
    shoes = case.track.shoe_count
    arms = np.array([1.0, 1.0, 1.0, 0.5 * case.shoe.width, 0.5 * case.shoe.length, 0.5 * case.shoe.width])
    motion = shapes.T[:, : 6 * shoes].reshape(-1, shoes, 6)
    weighted = (motion * arms).reshape(len(values), -1)
    greatest = np.take_along_axis(weighted, np.abs(weighted).argmax(axis=1)[:, None], axis=1)[:, 0]
    # a mode of the ground alone may leave the shoes where they are
    scale = np.where(np.abs(greatest) > 0.0, greatest, 1.0)
    motion_of = contact.coordinates.motion
    ground = (shapes / scale)[6 * shoes : 6 * shoes + contact.coordinates.size].T
    units = [motion_of(s.real) + 1j * motion_of(s.imag) for s in ground]
    # a motion that nothing drives back, such as that across the path, has no damping ratio
    size = np.where(np.abs(values) > STILL * np.abs(values).max(), np.abs(values), np.nan)
    numbers = {"mode": np.arange(1, len(values) + 1), "unit": case.part(Terrain).units}
    numbers |= {"shoe": case.track.shoes, "joint": case.track.joints}
    return xr.Dataset(
        {
            "growth_rate": ("mode", values.real, {"units": "1/s"}),
            "frequency": ("mode", values.imag / (2.0 * np.pi), {"units": "Hz"}),
            "damping_ratio": ("mode", -values.real / size, {"units": "1"}),
            "shape": (("mode", "shoe", "coordinate"), motion / scale[:, None, None]),
            "unit_shape": (("mode", "unit", "motion"), np.array(units)[..., 2:]),
            "position": (("shoe", "coordinate"), state.q[: 6 * shoes].reshape(shoes, 6)),
            "tension": ("joint", state.tension, {"units": "N"}),
            "normal_force": ("shoe", state.normal_force, {"units": "N"}),
        },
        coords=numbers | {"coordinate": COORDINATES, "motion": ["heave", "tilt"]},
        attrs={"title": case.name, "speed": state.speed},
    )


def mode_table(modes: xr.Dataset, count: int = 10) -> pd.DataFrame:
    """Tabulate the least stable modes: frequency, damping, growth, and the greatest motions of shoes.

    Columns `frequency, Hz`, `growth rate, 1/s`, `damping ratio`, `shoe` (the one that moves most) and the
    greatest motion of all shoes in every coordinate, m and rad.
    """
    few = modes.isel(mode=slice(count))
    size = xr.apply_ufunc(np.abs, few["shape"])
    most = size.sel(coordinate=["x", "y", "z"]).max("coordinate").idxmax("shoe")
    table = {
        "mode": few.mode.values,
        "frequency, Hz": few.frequency.values,
        "growth rate, 1/s": few.growth_rate.values,
        "damping ratio": few.damping_ratio.values,
        "shoe": most.values,
    }
    motion = {str(c.values): size.sel(coordinate=c).max("shoe").values for c in size.coordinate}
    return pd.DataFrame(table | motion)


def draw_mode(ax: Axes, modes: xr.Dataset, case: Case, mode: int = 1) -> Axes:
    """Draw undersides and pins of the shoes from the side in a mode about steady sliding, enlarged."""
    shape = modes["shape"].sel(mode=mode).values
    position = modes.position.values
    coms = case.track.com_positions(case.shoe.com_height) + position[:, :3]
    foot = case.shoe.footprint
    points = np.array(
        [[foot[0], 0.0, foot[4]], [foot[1], 0.0, foot[4]], case.track.front_pin, case.track.rear_pin]
    )
    still = _seen(coms, position[:, 4], points)
    for underside in still[:, :2]:
        ax.plot(*underside.T, color="0.75")
    for number, (name, factor) in enumerate(PHASES.items()):
        motion = SWING * (factor * shape).real
        moved = _seen(coms + motion[:, :3], position[:, 4] + motion[:, 4], points)
        for k, (underside, pins) in enumerate(zip(moved[:, :2], moved[:, 2:], strict=True)):
            ax.plot(*underside.T, color=f"C{number}", lw=2.0, label=name if k == 0 else None)
            ax.plot(*pins.T, color=f"C{number}", marker="o", ms=2.5, lw=0.6)
    value = modes.sel(mode=mode)
    ax.set_title(
        f"mode {mode}: {float(value.frequency):.2f} Hz, growth rate {float(value.growth_rate):+.2f}/s",
        loc="left",
    )
    ax.set_xlabel("x in m")
    ax.set_ylabel("z in m, motion enlarged")
    ax.legend(ncols=len(PHASES))
    return ax


def _seen(coms: np.ndarray, pitch: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return positions (shoes, points, 2), x and z, of points (points, 3) in the shoes' frames."""
    c = np.cos(pitch)[:, None]
    s = np.sin(pitch)[:, None]
    x, z = points[:, 0], points[:, 2]
    return np.stack((coms[:, :1] + c * x + s * z, coms[:, 2:] - s * x + c * z), axis=-1)


def mode_figure(modes: xr.Dataset, case: Case, numbers: Sequence[int] = (1, 2)) -> Figure:
    """Draw the given modes from the side, one below the other."""
    title = f"{modes.attrs['title']}, sliding at {modes.attrs['speed']:g} m/s"
    with titled_figure(title, 8.0, 0.6 + 2.6 * len(numbers)) as figure:
        axes = figure.subplots(len(numbers), 1, sharex=True, squeeze=False)[:, 0].tolist()
        for ax, number in zip(axes, numbers, strict=True):
            draw_mode(ax, modes, case, number)
    return figure


def even_ground(stiffness: float = 1e11) -> Case:
    """Return the rigid studies' track on one unit without seams, on springs of a stiffness (N/m)."""
    case = plain(Case.translation())
    (_, length), (_, width) = case.terrain.bounds
    sides = {"columns": 1, "rows": 1, "unit_length": length, "unit_width": width}
    springs = {"spring_stiffness": stiffness, "spring_damping": 0.01 * stiffness, "spring_offset": 20.0}
    return case.with_(name="even", terrain=case.part(Terrain).with_(**sides, **springs))


def grounds() -> dict[str, Case]:
    """Return tracks of rigid shoes on even ground, 7 m units (rigid studies) and 1 m units (stress study)."""
    return {
        "even": even_ground(),
        "7 m units": plain(Case.translation()),
        "1 m units": Case.stress().with_(flexible=None, contact=PairContact.oil_sand(sharing="area")),
    }


def with_law(case: Case, **factors: float) -> Case:
    """Return the case with some parameters of its contact law times factors."""
    law = case.part(PairContact)
    return case.with_(contact=law.with_(**{name: f * getattr(law, name) for name, f in factors.items()}))


def with_friction(case: Case, static: float, dynamic: float) -> Case:
    """Return the case with other coefficients of friction."""
    return case.with_(contact=case.part(PairContact).with_(static_friction=static, dynamic_friction=dynamic))


def with_shoes(case: Case, count: int) -> Case:
    """Return the case with another number of shoes, each with the same load."""
    phase = case.loads.phases[0]
    loads = LoadCycle(phases=(phase.with_(loads=(phase.loads[0],) * count),))
    return case.with_(track=case.track.with_(shoe_count=count), loads=loads)


def _with_pin_height(case: Case, height: float) -> Case:
    return case.with_(track=case.track.with_(pin_height=height - case.shoe.com_height))


COARSE = ("even", "7 m units")
ALL = ("even", "7 m units", "1 m units")
FRICTIONS = (0.0, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6)
HEIGHTS = (0.07, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35)
COUNTS = (2, 3, 4, 5, 7, 9, 11, 13, 16, 20)
PARAMETERS: dict[str, tuple[Sequence[float], Callable[..., Case], Sequence[str]]] = {
    "friction": (FRICTIONS, lambda case, mu: with_friction(case, mu, mu), ALL),
    "damping factor": ((0, 0.1, 0.3, 1, 3, 10, 30, 100), lambda case, f: with_law(case, damping=f), ALL),
    "pin height, m": (HEIGHTS, _with_pin_height, COARSE),
    "shoe length, m": ((0.55, 0.59, 0.63, 0.65), lambda case, m: case.with_({"shoe.length": m}), COARSE),
    "contact stiffness factor": ((0.5, 1, 2, 4), lambda case, f: with_law(case, stiffness=f), COARSE),
    "shoes": (COUNTS, with_shoes, COARSE),
}
"""Values, change of a case with constant friction, and grounds, by parameter."""
SPEEDS = (0.002, 0.005, 0.009, 0.012, 0.02, 0.03, 0.05, 0.08, 0.095, 0.1, 0.2)  # m/s


def _trials(constant: Sequence[float], damped: Sequence[float] = ()) -> list[tuple[float, float, float]]:
    """Return trials with the papers' friction, with constant coefficients, and with damping factors."""
    falling = [(0.4, 0.3, factor) for factor in (1.0, 10.0, 100.0)]
    level = [*((mu, mu, 1.0) for mu in constant), *((0.3, 0.3, factor) for factor in damped)]
    return [falling[0], *level, *falling[1:]]


TRIALS = {
    "even": _trials((0.0, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4)),
    "7 m units": _trials((0.0, 0.1, 0.2, 0.3), (3.0, 10.0, 100.0)),
    "1 m units": _trials((0.0, 0.1, 0.3), (10.0,)),
}
"""Coefficients of friction and damping factor of the runs, by ground."""


def least_stable(case: Case, speed: float = SPEED, travel: float = 0.0) -> tuple[float, float, int]:
    """Return growth rate (1/s) and frequency (Hz) of the least stable swing, and the number growing."""
    modes = sliding_modes(case, speed, travel)
    swings = modes.where(modes.frequency > SWINGING, drop=True)
    growing = int((swings.growth_rate > 1e-6).sum())
    return float(swings.growth_rate[0]), float(swings.frequency[0]), growing


def growth_row(cases: Iterable[tuple[str, Case]], speed: float = SPEED) -> dict[str, str]:
    """Return growth rate, frequency and number of growing swings by ground, as text."""
    row = {}
    for ground, case in cases:
        try:
            growth, frequency, growing = least_stable(case, speed)
            row[ground] = f"{growth:+.2f} at {frequency:.1f} Hz ({growing})"
        except EquilibriumError:
            row[ground] = "none found"
    return row


def growth_over(parameter: str, values: Sequence[float] | None = None) -> pd.DataFrame:
    """Tabulate `growth_row` over one of `PARAMETERS`, with constant friction."""
    all_values, change, on = PARAMETERS[parameter]
    base = {name: with_friction(grounds()[name], FRICTION, FRICTION) for name in on}
    rows = [
        {parameter: value} | growth_row((name, change(case, value)) for name, case in base.items())
        for value in (all_values if values is None else values)
    ]
    return pd.DataFrame(rows)


def growth_over_speed() -> pd.DataFrame:
    """Tabulate `growth_row` over the speed, with the papers' falling friction."""
    return pd.DataFrame([{"speed, m/s": v} | growth_row(grounds().items(), v) for v in SPEEDS])


def trial(
    ground: str, static: float, dynamic: float, damping: float, duration: float = 10.0
) -> dict[str, object]:
    """Compare the predicted growth at the final speed with a run."""
    case = with_law(with_friction(grounds()[ground], static, dynamic), damping=damping)
    growth = least_stable(case)[0]
    run = simulate(case, duration, progress=False).dataset
    velocity = run.velocity.sel(axis="z").values
    times = run.time.values
    forces = run.normal_force.sel(axis="z").groupby("contact_shoe").sum().values
    spectrum = np.abs(np.fft.rfft(velocity[times >= 0.5 * duration], axis=0)).mean(axis=1)
    step = float(np.median(np.diff(times)))
    frequency = np.fft.rfftfreq(int((times >= 0.5 * duration).sum()), step)[spectrum.argmax()]

    def rms(first: float) -> float:
        return float(np.sqrt(np.mean(velocity[(times >= first) & (times < first + 1.0)] ** 2)))

    return {
        "ground": ground,
        "mu_s / mu_d": f"{static:g} / {dynamic:g}",
        "damping": damping,
        "growth at 0.2 m/s": growth,
        "least v_z": velocity.min(),
        "greatest": velocity.max(),
        "rms 4-5 s": rms(4.0),
        "rms 9-10 s": rms(duration - 1.0),
        "peak, Hz": frequency,
        "off ground": float((forces < 1.0).mean()),
    }


def study(
    out: Path | None = None, *, runs: bool = False, overwrite: bool = False
) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield titles and tables one by one; `out` gets each table as a CSV file, and `modes.png`.

    `runs` adds the 10 s runs, which take longest. Raises `FileExistsError` if a file exists and `overwrite`
    is false.
    """
    case = with_friction(plain(Case.translation()), FRICTION, FRICTION)
    modes = sliding_modes(case, SPEED)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        save_figure(mode_figure(modes, case), out / "modes.png", overwrite)
    for title, table in _tables(modes, runs):
        if out is not None:
            write_table(table, out / table_name(title), overwrite)
        yield title, table


def table_name(title: str) -> str:
    """Return the file name for the table of a title."""
    return f"{title.split(',')[0].replace(' ', '_')}.csv"


def _tables(modes: xr.Dataset, runs: bool) -> Iterator[tuple[str, pd.DataFrame]]:
    yield "modes", mode_table(modes, 5)
    for parameter in PARAMETERS:
        yield f"growth over {parameter}", growth_over(parameter)
    yield "growth over speed", growth_over_speed()
    if runs:
        rows = [trial(ground, *settings) for ground, some in TRIALS.items() for settings in some]
        yield "runs", pd.DataFrame(rows)
