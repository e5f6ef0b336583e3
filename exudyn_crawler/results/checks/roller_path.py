"""Roller path: line contact of treads on rails, for check cases and for every pass of a run.

Pressure and subsurface stress are those of Hertz, shakedown that of Melan (`fem.fatigue.line_contact`). The
model omits the hardened layer, plastic flow itself, and sliding across the rail; a friction coefficient of
0.3 lowers the limit of 4 k to about 3.3 k. It also omits the free edges of rails: the contact there is not
that of a half-space, and lips flow earlier.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

import fem.fatigue.line_contact as hertz
from exudyn_crawler.case import Case, RunningGear
from exudyn_crawler.files import blocks
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.checks.cases import CheckCase, ShoeCheck
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.life.duty import FatigueMaterial
from exudyn_crawler.results.loads.actions import treads
from exudyn_crawler.results.stress.basis import stress_basis
from fem import Material
from meshes import STEEL, rails

MEGA = 1e6
KILO = 1e3
MILLI = 1e-3
TILTS = (0.0, 0.5e-3, 1e-3, 2e-3)
"""Tilts of a tread across the rail in check cases, rad."""
PLACE = 0.05
"""Approximate length of rail for a row of a run's table, m."""
AT_END = 1e-4
"""Distance from a rail's end within which a disc stands on the rail's edge, m."""
INSTANTS = 400
"""Greatest number of a run's instants for the range of the structure's stress."""
MATERIALS = (FatigueMaterial.cast_nicrmo(), FatigueMaterial.cast_manganese(), FatigueMaterial.a36())
PASSES = "passes"
PRESSURE = "pressure in MPa"
TYPICAL = "median of the passes in MPa"
MIDDLE = "x of its middle in m"
RAIL = "rail"
INTENSITY = "line load over radius"


def limits(material: FatigueMaterial) -> tuple[float, float]:
    """Return the pressures of a level contact alone at first yield and at shakedown, Pa."""
    contact = hertz.LineContact(np.array(MEGA), np.array(MILLI))
    stress = hertz.path_stress(contact, material.yield_strength, STEEL.poissons_ratio)
    return MEGA * stress.to_yield, MEGA * stress.to_shakedown


def plane_modulus(material: Material) -> float:
    """Return the contact modulus of two bodies of the same material in line contact, Pa."""
    return material.youngs_modulus / (2.0 * (1.0 - material.poissons_ratio**2))


def hertz_table(check: ShoeCheck, cases: Iterable[CheckCase]) -> pd.DataFrame:
    """Return the line contact of the treads of check cases: a row for each force, width and tilt."""
    treads: dict[tuple[float, float], str] = {}
    for case in cases:
        for tread in case.treads:
            treads.setdefault(
                (tread.force, min(tread.width or check.tread_width, check.tread_width)), case.name
            )
    rows = []
    for (force, width), first in sorted(treads.items()):
        for tilt in TILTS:
            line_load = float(hertz.greatest_line_load(force, hertz.tilted_moment(force, tilt, width), width))
            contact = hertz.line_contact(line_load, check.roller_radius, plane_modulus(STEEL))
            stress = hertz.path_stress(contact, check.material.yield_strength, STEEL.poissons_ratio)
            row = {"force in kN": force / KILO, "width in m": width, "tilt in mrad": tilt / MILLI}
            row |= {"edge over mean": line_load * width / force} | _contact_columns(contact, stress)
            row |= {"to yield": stress.to_yield, "to shakedown": stress.to_shakedown}
            rows.append(row | {"path": stress.verdict, "first case": first})
    return pd.DataFrame(rows)


def _contact_columns(contact: hertz.LineContact, stress: hertz.PathStress) -> dict[str, float]:
    """Return the columns of pressure, half width, and greatest shear with its depth."""
    return {
        PRESSURE: float(contact.pressure) / MEGA,
        "half width in mm": float(contact.half_width) / MILLI,
        "greatest shear in MPa": stress.shear / MEGA,
        "its depth in mm": stress.depth / MILLI,
    }


def roller_path(history: History, materials: Iterable[FatigueMaterial] = MATERIALS) -> pd.DataFrame:
    """Return the line contact of all treads that passed over the shoes of a run, by place on the rail.

    The rear end, the front end and each part between have a row. It has the number of passes (of every
    roller, rail and shoe), their greatest pressure and its median, and the subsurface shear. It also has the
    factors of the stresses at yield and at ratchetting.

    If treads press on flexible shoes, these alone count. The structure's stress in the surface is then
    superposed: that of the instant, and its range over the run. In closed tracks a history has strips of
    rollers, idler and carriers on flexible shoes alone. ValueError without such treads, or if none ever
    pressed.
    """
    case = history.case
    steel = STEEL
    if not has_treads(history):
        needs = "a side frame on an open track, or a closed track's flexible shoes"
        raise ValueError(f"roller paths need {needs}; {case.name!r} has none")
    gear = case.part(RunningGear)
    if (bent := case.flexible) is not None:
        steel = replace(STEEL, youngs_modulus=bent.youngs_modulus, poissons_ratio=bent.poissons_ratio)
    passes = _passes(history, gear)
    worst = passes.loc[passes.groupby("place")[INTENSITY].idxmax()].set_index("place")
    medians = passes.groupby("place")[INTENSITY].median()
    beside = _beside(history, gear, worst)
    edges = _places(case)
    rows = []
    names = ["rear end", *[RAIL] * (len(edges) - 1), "front end"]
    middles = [edges[0], *0.5 * (edges[1:] + edges[:-1]), edges[-1]]
    for place, tread in worst.iterrows():
        contact, typical = (
            hertz.line_contact(intensity * tread["radius"], tread["radius"], plane_modulus(steel))
            for intensity in (tread[INTENSITY], medians[place])
        )
        node, structure = beside.get(place, (None, None))
        stress = hertz.path_stress(contact, MEGA, steel.poissons_ratio, structure)
        row = {"place": names[place], MIDDLE: middles[place]}
        row |= {PASSES: int((passes["place"] == place).sum()), "greatest force in kN": tread["force"] / KILO}
        row |= {"edge over mean": tread["line load"] * gear.tread_width / tread["force"]}
        row |= _contact_columns(contact, stress) | {TYPICAL: float(typical.pressure) / MEGA}
        if structure is not None:
            along, across, _ = structure[0] / MEGA
            row |= {"structure along in MPa": along, "structure across in MPa": across, "node": node}
        for material in materials:
            margins = stress.of_strength(material.yield_strength / MEGA)
            row |= {
                f"{material.name} to yield": margins.to_yield,
                f"{material.name} to shakedown": margins.to_shakedown,
            }
            row |= {material.name: margins.verdict}
        row |= {"shoe": int(tread["shoe"]), "roller": tread["roller"], "time in s": tread["time"]}
        rows.append(row)
    return pd.DataFrame(rows)


def _places(case: Case) -> np.ndarray:
    """Return the edges (n + 1,) of a rail's parts along x in the shoe's frame, m.

    Parts 0 and n + 1 are the ends of the rail.
    """
    rail = case.shoe.roller_path
    return np.linspace(rail.rear, rail.front, 1 + max(1, round((rail.front - rail.rear) / PLACE)))


def has_treads(history: History) -> bool:
    """Return True if a history has strips of treads: a rolled track, or flexible shoes in a closed one."""
    return "tread_force" in history.dataset or "strip_force" in history.dataset


def treads_press(history: History) -> bool:
    """Return True if a tread presses at a stored instant."""
    stored = [name for name in ("tread_force", "strip_force") if name in history.dataset]
    return any(bool(history.dataset[name].any()) for name in stored)


def _passes(history: History, gear: RunningGear) -> pd.DataFrame:
    """Return the greatest force per width and radius (N/m2) of each shoe, roller, rail and place: a row each.

    Other columns are the time (s) and its row, the place on the rail (m), the tread's force (N) and the side
    of its lean.
    """
    edges = _places(history.case)
    case = history.case
    of_strips = "strip_force", "strip_foot", "strip_guide", "strip_wheel"
    of_treads = "tread_force", "tread_foot", "roller_shoe"
    read = [name for name in (*of_strips, *of_treads) if name in history.dataset]
    names = history.dataset["wheel" if "wheel" in history.dataset.dims else "roller"].values
    radii = np.tile(gear.first_wheels(case)[:, 2], case.gear.tracks)
    rolls = np.array([label.kind != "slide" for label in case.gear.wheel_labels])
    keys = ["shoe", "roller", "rail", "place"]
    tables = []
    done = 0
    for part in blocks(history.dataset[[*read, "position", "angles"]]):
        on = treads(part)
        size = np.linalg.norm(on.force - on.guide, axis=-1)
        presses = size.any(axis=-1) & ((on.wheel >= 0) & rolls[on.wheel])[..., None]
        row, slot, rail = np.nonzero(presses)
        size = size[presses]
        shoe = on.shoe[row, slot]
        wheel = on.wheel[row, slot]
        roller = names[wheel]
        radius = radii[wheel]
        total = size.sum(axis=1)
        moment = size @ gear.strip_places
        foot = np.einsum("ps,psi->pi", size, on.foot[presses]) / total[:, None]
        axes = rotation_matrices(part.angles.values)[row, shoe - 1, :, 0]
        x = np.einsum("pi,pi->p", foot - part.position.values[row, shoe - 1], axes)
        place = np.searchsorted(edges[1:-1], x) + 1
        place[x <= edges[0] + AT_END], place[x >= edges[-1] - AT_END] = 0, len(edges)
        line_load = hertz.greatest_line_load(total, moment, gear.tread_width)
        columns = {"shoe": shoe, "roller": roller, "rail": rail, "place": place, "x": x, "radius": radius}
        columns |= {"row": done + row, "time": part.time.values[row], "force": total}
        columns |= {INTENSITY: line_load / radius}
        table = pd.DataFrame(columns | {"leans": np.sign(moment), "line load": line_load})
        tables.append(table.loc[table.groupby(keys)[INTENSITY].idxmax()])
        done += part.sizes["time"]
    whole = pd.concat(tables, ignore_index=True)
    if whole.empty:
        raise ValueError("a tread must press on a shoe at a stored time, but none does")
    bent = whole["shoe"].isin(() if case.flexible is None else case.flexible.shoes)
    whole = whole[bent] if bent.any() else whole
    return whole.loc[whole.groupby(keys)[INTENSITY].idxmax()].reset_index(drop=True)


def _beside(history: History, gear: RunningGear, worst: pd.DataFrame) -> Mapping[int, tuple[int, np.ndarray]]:
    """Return by place the surface node nearest to the tread's more loaded edge, and the stress there.

    It is that of the structure, (5, 3), Pa: xx, yy, xy at the instant and at the four corners of its range.
    """
    case = history.case
    if case.flexible is None or not set(worst["shoe"]) <= set(case.flexible.shoes):
        return {}
    even = np.linspace(0, history.time.size - 1, min(INSTANTS, history.time.size)).astype(int)
    rows = np.union1d(even, worst["row"])
    basis = stress_basis(History(case, history.dataset.isel(time=rows)), sorted(set(worst["shoe"])))
    mesh = basis.shapes.mesh
    spots = {}
    sides = rails.rail_nodes(mesh)
    for place, tread in worst.iterrows():
        nodes = sides[int(tread["rail"])]
        y = mesh.nodes[nodes, 1].mean() + 0.5 * tread["leans"] * gear.tread_width
        node = nodes[np.hypot(*(mesh.nodes[nodes, :2] - (tread["x"], y)).T).argmin()]
        stress = basis.coordinates[int(tread["shoe"])] @ basis.shapes.stress_modes[node][[0, 1, 3]].T
        here = stress[np.searchsorted(rows, tread["row"])]
        low = stress.min(axis=0)
        high = stress.max(axis=0)
        corners = [(a, b, 0.0) for a in (low[0], high[0]) for b in (low[1], high[1])]
        spots[int(place)] = int(node), np.array([here, *corners])
    return spots
