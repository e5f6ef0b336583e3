"""Rolling propel: the machine passes over flexible shoes and digs above them, compared with dragging.

Besides the ready shoe it passes over one with overhanging rails, new and with 25 mm worn off its path.

No paper reports this study. The S-paper (Minerals 2016, 6(3), 61) ends with the limits of its dragged, evenly
loaded track: in the field shoes crack in the roller path, under the lower rollers.
"""

from pathlib import Path
from typing import Unpack

import numpy as np
import pandas as pd

from exudyn_crawler import Case, CaseFile, FlexibleShoes, LoadCycle, StepProfile, simulate
from exudyn_crawler.case import MachineCycle, Rails, Rolled, ph4100c
from exudyn_crawler.case.gear.rolled import ground_below
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.results.balance import energy_balance
from exudyn_crawler.results.stress.hot_spots import REGIONS, SHARE, region_table
from meshes import STEEL, mesh_named, shoe_path
from meshes.rails import rail_outline
from studies import CYCLE_DURATION
from studies.running import Compared, Running, by_name, save, study_runs

FLEXIBLE, COUNT = (17, 18, 19, 20, 21, 22), 38  # numbers of the flexible shoes, and the count of all shoes
BEFORE, ABOVE = 15.5, 22.2
"""Positions x of the frame's origin, m: front roller just behind the flexible shoes; above their middle."""
PASS_DURATION = 137.0  # s, time until the rear roller leaves the last flexible shoe
OVERHANG = {"overhang": "shoe_overhang.msh.gz", "overhang worn": "shoe_overhang_25mm.msh.gz"}
"""Ready meshes of shoes with rails that overhang by 0.132 m, as fine as the coarse one."""
STANDS = {"front": -2.9, "middle": 0.0, "rear": 2.9}
"""Distance, m, of the machine's middle ahead of the flexible shoes, by the part of the machine above them."""
CHOICES_DURATION = 8.0  # s
FOLDED = 1.0  # rad, tilt of a shoe above which the chain has folded up
FIRM = 10.0
FIRM_SPRINGS = "springs of the ground x 10"
FIRM_CONTACT = "contact with the ground x 10"
KILO = 1e3


def rolled_case(mesh: str = "study") -> Case:
    """Return one pass of the machine at the papers' speed over six flexible shoes among rigid ones."""
    case = Case.rolled()
    track = case.track.with_(shoe_count=COUNT)
    return case.with_(
        name="pass",
        shoe=case.shoe.of_mass(ph4100c.STRESS_SHOE_MASS),
        track=track,
        terrain=ground_below(track, case.part(Terrain)),
        loads=LoadCycle.constant([0.0] * COUNT),
        flexible=FlexibleShoes.ph4100c(mesh).with_(shoes=FLEXIBLE),
        gear=Rolled.ph4100c().with_(start=BEFORE),
    )


def loading_case(mesh: str = "study", ahead: float = 0.0) -> Case:
    """Return the loading cycle of a machine that stands `ahead` (m) of the flexible shoes after propel."""
    case = rolled_case(mesh)
    frame = Rolled.ph4100c().with_(start=ABOVE + ahead)
    whole = MachineCycle.shovel(frame)
    start = whole.phases[0].end
    phases = tuple(phase.with_(end=phase.end - start) for phase in whole.phases)
    return case.with_(
        name="loading",
        drive=case.drive.with_(speed=StepProfile.constant(0.0)),
        gear=frame,
        machine=MachineCycle(phases=phases),
    )


def overhang_cases() -> dict[str, Case]:
    """Return the pass and the loading cycles at all `STANDS` for shoes with the meshes of `OVERHANG`."""
    cases = {}
    for name, file in OVERHANG.items():
        path = str(shoe_path("coarse").with_name(file))
        mesh = mesh_named(path)
        named = {f"pass {name}": rolled_case(path)}
        rails = Rails(**rail_outline(mesh)._asdict())
        named |= {f"loading {name} {part}": loading_case(path, ahead) for part, ahead in STANDS.items()}
        for title, case in named.items():
            shoe = case.shoe.of_mass(STEEL.density * mesh.volume).with_(rails=rails)
            cases[title] = case.with_(name=title, shoe=shoe)
    return cases


def study_cases(mesh: str = "study", duration: float | None = None) -> dict[str, CaseFile]:
    """Return the cases of the study with their durations (s), at most `duration`.

    See `FlexibleShoes` for `mesh`; shoes with overhanging rails have meshes of their own.
    """
    most = np.inf if duration is None else duration
    loading = ph4100c.RETURN_END - ph4100c.PROPEL_END
    durations = {"pass": PASS_DURATION, "loading": loading, "dragged": CYCLE_DURATION}
    cases = {"pass": rolled_case(mesh), "loading": loading_case(mesh), "dragged": Case.stress(mesh)}
    return {
        name: CaseFile(case=case, duration=min(durations[name.split()[0]], most))
        for name, case in (cases | overhang_cases()).items()
    }


def highest_by_region(run: CaseRun) -> pd.DataFrame:
    """Return the highest von Mises stress of any flexible shoe by region, as rows of `region_table`."""
    stresses = run.recovered()
    table = region_table(stresses.by_region, stresses.dataset)
    highest = table.loc[table.groupby("region")["von Mises in MPa"].idxmax()]
    order = [region for region in REGIONS if region in set(highest["region"])]
    return highest.set_index("region").loc[order].reset_index()


def study(
    out: Path | None = None,
    mesh: str = "study",
    *,
    duration: float | None = None,
    **how: Unpack[Running],
) -> Compared:
    """Run the pass, the loading cycle and the papers' dragged study, and compare their hot spots.

    See `study_cases` for the cases. `out` gets their folders and `regions.csv`. Errors are those of
    `study_runs`.
    """
    with study_runs(out, study_cases(mesh, duration), **how) as runs:
        table = by_name("case", {name: highest_by_region(run) for name, run in runs.items()})
        shares = table.filter(like=SHARE).fillna(0.0)
        table = table.assign(**shares.to_dict("series"))
        save(out, regions=table)
        return runs, table


def _with_rollers(frame: Rolled, count: int, spacing: float) -> Rolled:
    return frame.with_(rollers=tuple(spacing * (k - 0.5 * (count - 1)) for k in range(count)))


def choices() -> dict[str, Case]:
    """Return the default rigid machine, variants with one changed choice each, and firmer grounds."""
    case = Case.rolled()
    frame = Rolled.ph4100c()
    changed = {
        "as it is": frame,
        "7 rollers over the same length": _with_rollers(frame, 7, 8.75 / 6.0),
        "7 rollers, two shoes apart": _with_rollers(frame, 7, 2.0 * ph4100c.TRACK["pitch"]),
        "8 rollers, 1.1 m apart": _with_rollers(frame, 8, 1.1),
        "radius 0.3 m": frame.with_(radius=0.3),
        "stiffness x 10": frame.with_(stiffness=10.0 * frame.stiffness),
        "rolling resistance 0.1": frame.with_(rolling_resistance=0.1),
        "no end tension": frame.with_(end_tension=0.0),
        "tumbler in front": frame.with_(tumbler=-frame.tumbler),
    }
    cases = {name: case.with_(name=name, gear=gear) for name, gear in changed.items()}
    springs = case.part(Terrain).with_(spring_stiffness=FIRM * case.part(Terrain).spring_stiffness)
    contact = case.part(PairContact)
    contact = contact.with_(stiffness=FIRM * contact.stiffness)
    return cases | {
        FIRM_SPRINGS: case.with_(name=FIRM_SPRINGS, terrain=springs),
        FIRM_CONTACT: case.with_(name=FIRM_CONTACT, contact=contact),
    }


def open_choices(duration: float = CHOICES_DURATION) -> pd.DataFrame:
    """Tabulate the effect of the open choices on a rigid machine over a duration (s).

    Only friction and tension keep the chain from folding up; if it does, the run stops.
    """
    rows = []
    for name, case in choices().items():
        try:
            history = simulate(case, duration, progress=False)
        except SimulationStopped as stopped:
            rows.append({"choice": name, "folds up at s": stopped.time})
            continue
        tilt = np.abs(history.angles.sel(axis="y").values).max(axis=1)
        if tilt.max() > FOLDED:
            rows.append({"choice": name, "folds up at s": float(history.time[np.argmax(tilt > FOLDED)])})
            continue
        treads = np.linalg.norm(history.roller_force.values, axis=-1)
        heave = history.side_frame_position.values[:, 2]
        balance = energy_balance(history).isel(time=-1)
        rows.append(
            {
                "choice": name,
                "greatest force on a rail in kN": treads.max() / KILO,
                "mean of those that touch in kN": treads[treads > 0.0].mean() / KILO,
                "mean pull in kN": float(history.drive_pull.mean()) / KILO,
                "greatest pull in kN": float(history.drive_pull.max()) / KILO,
                "greatest tilt of a shoe in rad": float(tilt.max()),
                "heave of the frame in mm": float(np.ptp(heave)) * KILO,
                "work of the drive in kJ": float(balance["drive"]) / KILO,
                "of it rolling resistance in kJ": float(balance["rolling_resistance"]) / KILO,
            }
        )
    return pd.DataFrame(rows)
