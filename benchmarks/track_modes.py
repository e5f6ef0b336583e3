"""Why the shoes bounce: growth rates of the sliding track over its parameters, beside 10 s runs.

``python -m benchmarks.track_modes`` prints the tables of `docs/track_modes.md` (ten minutes).
"""

import time
from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd

from exudyn_crawler import Case, LoadCycle, PairContact, simulate
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.run.solve.track_modes import track_modes
from exudyn_crawler.views.tables import print_table

SPEED = 0.2
"""m/s, where friction no longer changes with the speed."""
FRICTION = 0.3

SWINGING = 0.1
"""Hz, least frequency of a swing."""


def even_ground(stiffness: float = 1e11) -> Case:
    """The rigid studies' track on one unit, no seams, on springs of some stiffness (N/m)."""
    case = Case.translation()
    (_, length), (_, width) = case.terrain.bounds
    sides = {"columns": 1, "rows": 1, "unit_length": length, "unit_width": width}
    springs = {"spring_stiffness": stiffness, "spring_damping": 0.01 * stiffness, "spring_offset": 20.0}
    return case.with_(name="even", terrain=case.terrain.with_(**sides, **springs))


def grounds() -> dict[str, Case]:
    """Even ground, 7 m units of the rigid studies, 1 m units of the stress study; all shoes rigid."""
    return {
        "even": even_ground(),
        "7 m units": Case.translation(),
        "1 m units": Case.stress().with_(flexible=None, contact=PairContact.oil_sand(sharing="area")),
    }


def with_law(case: Case, **changes: float) -> Case:
    """Case with some parameters of its contact law changed."""
    return case.with_(contact=case.contact.with_(**changes))


def with_friction(case: Case, static: float, dynamic: float) -> Case:
    """Case with other coefficients of friction."""
    return with_law(case, static_friction=static, dynamic_friction=dynamic)


def with_damping(case: Case, factor: float) -> Case:
    """Case with another greatest damping of the contact."""
    return with_law(case, damping=factor * case.contact.damping)


def with_pin_height(case: Case, height: float) -> Case:
    """Case with pins at a height over the underside, m."""
    return case.with_(track=case.track.with_(pin_height=height - case.shoe.com_height))


def with_shoe_length(case: Case, length: float) -> Case:
    """Case with a longer or shorter underside, m."""
    return case.with_(shoe=case.shoe.with_(length=length))


def with_stiffness(case: Case, factor: float) -> Case:
    """Case on stiffer ground."""
    return with_law(case, stiffness=factor * case.contact.stiffness)


def with_shoes(case: Case, count: int) -> Case:
    """Case with another number of shoes, each with the same load."""
    phase = case.loads.phases[0]
    loads = LoadCycle(phases=(phase.with_(loads=(phase.loads[0],) * count),))
    return case.with_(track=case.track.with_(shoe_count=count), loads=loads)


def least_stable(case: Case, speed: float = SPEED, travel: float = 0.0) -> tuple[float, float, int]:
    """Growth rate (1/s) and frequency (Hz) of the least stable swing, and how many grow."""
    modes = track_modes(case, speed, travel)
    swings = modes.where(modes.frequency > SWINGING, drop=True)
    growing = int((swings.growth_rate > 1e-6).sum())
    return float(swings.growth_rate[0]), float(swings.frequency[0]), growing


def line(
    what: str, value: object, cases: Iterable[tuple[str, Case]], speed: float = SPEED
) -> dict[str, object]:
    """Row of a table: growth and frequency on each ground."""
    row: dict[str, object] = {what: value}
    for ground, case in cases:
        try:
            growth, frequency, growing = least_stable(case, speed)
            row[ground] = f"{growth:+.2f} at {frequency:.1f} Hz ({growing})"
        except EquilibriumError:
            row[ground] = "none found"
    return row


def linear_tables() -> Iterator[tuple[str, pd.DataFrame]]:
    """Tables of growth rates, each over one parameter, constant friction where not said otherwise."""
    constant = {name: with_friction(case, FRICTION, FRICTION) for name, case in grounds().items()}

    def over(what, values, change, base=constant):
        rows = [line(what, v, [(name, change(case, v)) for name, case in base.items()]) for v in values]
        return f"growth rate (1/s) over {what}", pd.DataFrame(rows)

    yield over(
        "friction", (0.0, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6), lambda c, v: with_friction(c, v, v)
    )
    yield over("damping factor", (0.0, 0.1, 0.3, 1, 3, 10, 30, 100), with_damping)
    few = {name: constant[name] for name in ("even", "7 m units")}
    yield over("pin height, m", (0.07, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35), with_pin_height, few)
    yield over("shoe length, m", (0.55, 0.59, 0.63, 0.65), with_shoe_length, few)
    yield over("contact stiffness factor", (0.5, 1, 2, 4), with_stiffness, few)
    yield over("shoes", (2, 3, 4, 5, 7, 9, 11, 13, 16, 20), with_shoes, few)
    rows = [
        line("speed, m/s", speed, grounds().items(), speed)
        for speed in (0.002, 0.005, 0.009, 0.012, 0.02, 0.03, 0.05, 0.08, 0.095, 0.1, 0.2)
    ]
    yield "growth rate (1/s) over speed, with the papers' falling friction", pd.DataFrame(rows)


TRIALS = (
    ("even", 0.4, 0.3, 1.0),
    ("even", 0.0, 0.0, 1.0),
    ("even", 0.1, 0.1, 1.0),
    ("even", 0.15, 0.15, 1.0),
    ("even", 0.2, 0.2, 1.0),
    ("even", 0.25, 0.25, 1.0),
    ("even", 0.3, 0.3, 1.0),
    ("even", 0.4, 0.4, 1.0),
    ("even", 0.4, 0.3, 10.0),
    ("even", 0.4, 0.3, 100.0),
    ("7 m units", 0.4, 0.3, 1.0),
    ("7 m units", 0.0, 0.0, 1.0),
    ("7 m units", 0.1, 0.1, 1.0),
    ("7 m units", 0.2, 0.2, 1.0),
    ("7 m units", 0.3, 0.3, 1.0),
    ("7 m units", 0.3, 0.3, 3.0),
    ("7 m units", 0.3, 0.3, 10.0),
    ("7 m units", 0.3, 0.3, 100.0),
    ("7 m units", 0.4, 0.3, 10.0),
    ("7 m units", 0.4, 0.3, 100.0),
    ("1 m units", 0.4, 0.3, 1.0),
    ("1 m units", 0.0, 0.0, 1.0),
    ("1 m units", 0.1, 0.1, 1.0),
    ("1 m units", 0.3, 0.3, 1.0),
    ("1 m units", 0.3, 0.3, 10.0),
    ("1 m units", 0.4, 0.3, 10.0),
    ("1 m units", 0.4, 0.3, 100.0),
)
"""Ground, coefficients of friction and factor of damping of the runs."""


def trial(
    ground: str, static: float, dynamic: float, damping: float, duration: float = 10.0
) -> dict[str, object]:
    """Predicted growth at the final speed beside what a run does."""
    case = with_damping(with_friction(grounds()[ground], static, dynamic), damping)
    growth = least_stable(case)[0]
    run = simulate(case, duration, progress=False).dataset
    velocity, at = run.velocity.sel(axis="z").values, run.time.values
    forces = run.normal_force.sel(axis="z").groupby("contact_shoe").sum().values
    spectrum = np.abs(np.fft.rfft(velocity[at >= 0.5 * duration], axis=0)).mean(axis=1)
    step = float(np.median(np.diff(at)))
    frequency = np.fft.rfftfreq(int((at >= 0.5 * duration).sum()), step)[spectrum.argmax()]

    def rms(first: float) -> float:
        return float(np.sqrt(np.mean(velocity[(at >= first) & (at < first + 1.0)] ** 2)))

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


def main() -> None:
    """Print all tables."""
    began = time.perf_counter()
    for title, table in linear_tables():
        print_table(table, title)
    print_table(pd.DataFrame([trial(*one) for one in TRIALS]), "10 s runs, m/s")
    print(f"{time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
