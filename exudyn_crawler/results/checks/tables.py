"""Tables of check cases: peaks by region, cycles to a crack, bending moments with hand calculations."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from exudyn_crawler.results.checks import cases as ready
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe
from exudyn_crawler.results.life.duty import UNLOADED
from exudyn_crawler.results.stress.hot_spots import REGIONS
from fem.body import supports
from fem.body.element_stress import principal, von_mises
from fem.fatigue import defects
from fem.stress import trust
from meshes import STEEL

MEGA = 1e6
SURVIVAL = 0.975
BLOW = ("blow in MN", "its compliance in m/N")  # columns of the moments
CYCLES = "cycles to a crack"
WIDEST = 10  # number of nodes of a region, those with the widest cycles in tension, checked for a defect


def moment_table(
    shoe: CheckedShoe,
    cases: Sequence[ready.CheckCase],
    loads: np.ndarray,
    blows: Mapping[str, tuple[float, float]],
) -> pd.DataFrame:
    """Return the bending moment at y = 0 by all loads left of it, that by hand, beam stresses, and blows."""
    cut = supports.section(shoe.mesh, 0.0)
    rows = []
    places = np.concatenate((shoe.mesh.nodes, [interface.center for interface in shoe.partition.interfaces]))
    left = places[:, 1] > 0.0
    _, y, z = places[left].T
    for case, load in zip(cases, loads.T, strict=True):
        forces, centers = shoe.parts(load)
        acting = np.concatenate((forces.reshape(-1, 3), centers.reshape(-1, 6)[:, :3]))[left]
        moment = float((y * acting[:, 2] - (z - cut.middle) * acting[:, 1]).sum())
        by_hand = np.nan if case.hand_moment is None else case.hand_moment
        row = {
            "case": case.name,
            "moment at y = 0 in kN m": moment / 1e3,
            "by hand in kN m": by_hand / 1e3,
            "over it": moment / by_hand,
            "beam, underside in MPa": moment * (cut.middle - cut.bottom) / cut.second / MEGA,
            "beam, top in MPa": moment * (cut.middle - cut.top) / cut.second / MEGA,
        }
        rows.append(row | dict(zip(BLOW, blows.get(case.name, (np.nan, np.nan)), strict=True)))
    return pd.DataFrame(rows)


def peak_table(
    check: ready.ShoeCheck, shoe: CheckedShoe, names: Sequence[str], stress: np.ndarray, answers: np.ndarray
) -> pd.DataFrame:
    """Return the highest von Mises stress of each case and region, with the error by the mesh."""
    tables = []
    for k, name in enumerate(names):
        mises = von_mises(stress[k])
        resolved = trust.resolution(shoe.mesh, STEEL, answers[..., k])
        highest = pd.Series(mises).groupby(shoe.regions).idxmax()
        rows = highest.reindex([region for region in REGIONS if region in highest]).to_numpy()
        node = shoe.mesh.surface_nodes[rows]
        region = shoe.regions[rows]
        error = trust.with_bores(resolved.error, shoe.shapes)[node]
        principals = principal(stress[k, rows]) / MEGA
        verdicts = trust.verdict_numbers(
            error, error, resolved.relative_jump[node], np.isin(region, shoe.unused_regions)
        )
        columns = {
            "case": name,
            "region": region,
            "von Mises in MPa": mises[rows] / MEGA,
            "greatest principal in MPa": principals[:, 2],
            "least principal in MPa": principals[:, 0],
            "mesh error": error,
            "verdict": trust.verdict_words(verdicts),
            "above yield": np.where(mises[rows] > check.material.yield_strength, "yes", ""),
            "node": node,
        }
        places = zip(("x in m", "y in m", "z in m"), shoe.mesh.nodes[node].T, strict=True)
        tables.append(pd.DataFrame(columns | dict(places)))
    return pd.concat(tables, ignore_index=True)


def cycle_table(
    check: ready.ShoeCheck,
    shoe: CheckedShoe,
    stress: Mapping[str, np.ndarray],
    pairs: Sequence[tuple[str, str]],
) -> pd.DataFrame:
    """Return the cycles to a crack between states by region: the least of all nodes, for 97.5 % survival.

    The amplitude is half of the von Mises stress of the states' difference. The mean stress is the von Mises
    stress of their mean, with the sign of its hydrostatic part.
    """
    none = np.zeros((len(shoe.regions), 6))
    rows = []
    material = check.material
    curves = {region: material.curve("elementary", region) for region in REGIONS}
    for first, second in pairs:
        if wrong := {first, second} - {*stress, UNLOADED}:
            raise ValueError(f"cycles: no case {sorted(wrong)}; there are {[*stress]}")
        a, b = (stress.get(name, none) for name in (first, second))
        change = a - b
        mean = 0.5 * (a + b)
        amplitude = 0.5 * von_mises(change)
        signed = np.where(mean[:, :3].sum(axis=1) < 0.0, -1.0, 1.0) * von_mises(mean)
        highest = np.maximum(von_mises(a), von_mises(b))
        for region in REGIONS:
            places = np.flatnonzero((shoe.regions == region) & (amplitude > 1.0))
            if not len(places):
                continue
            damage = curves[region].damage(amplitude[places], signed[places], (SURVIVAL,))[0]
            place = places[np.argmax(damage)]
            often = 1.0 / float(damage.max())
            row = {
                "from": first,
                "to": second,
                "region": region,
                "amplitude in MPa": amplitude[place] / MEGA,
                "mean in MPa": signed[place] / MEGA,
                CYCLES: often,
                "an hour": often / check.hours,
                "node": int(shoe.mesh.surface_nodes[place]),
                "above yield": "yes" if highest[place] > material.yield_strength else "",
            }
            if material.castings:
                tension = signed[places] + amplitude[places] + curves[region].residual_stress > 0.0
                widest = [place, *places[np.argsort(tension * amplitude[places])[-WIDEST:]]]
                ends = np.stack((signed - amplitude, signed + amplitude))[:, widest, None]
                each = ([defects.CycleStage(low, high, np.ones(1))] for low, high in ends.swapaxes(0, 1))
                lives = (material.defect_life(region, "elementary", stages, SURVIVAL) for stages in each)
                row["cycles to a crack, defect"] = min(lives)
            rows.append(row)
    return pd.DataFrame(rows)
