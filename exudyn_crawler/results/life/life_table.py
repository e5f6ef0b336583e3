"""Shortest lives by region of the shoe, and what makes them."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.life.life_causes import NodeLife
from exudyn_crawler.results.stress.hot_spots import SHARE
from fem import Shapes

BEYOND = 1e9
"""h, beyond which lives are not told apart; damage below one over it is left out."""
BETWEEN = "between runs"
"""Part of the damage that no run has alone."""
LIFE = "life in h"
"""What the columns of lives begin with."""


def life_hours(damage: NDArray | float) -> NDArray:
    """Hours that damages an hour leave; `BEYOND` stands for all beyond."""
    return np.where(damage * BEYOND <= 1.0, BEYOND, 1.0 / np.maximum(damage, 1.0 / BEYOND))


def worst_nodes(damage: NDArray, count: int) -> NDArray:
    """Numbers of the nodes with the greatest damage (n,) at most `count`; what is not a number has none."""
    known = np.flatnonzero(damage > 0.0)
    return known[np.argsort(-damage[known], kind="stable")[:count]]


def shortest_by_region(regions: NDArray, damage: NDArray) -> list[int]:
    """Node of the greatest damage (n,) of each region, the worst first.

    Parameters
    ----------
    regions : array (n,) of str
        Of `regions.shoe_regions`; those without any known damage are left out.
    """
    found = []
    for name in dict.fromkeys(regions):
        own = np.flatnonzero((regions == name) & ~np.isnan(damage))
        if len(own):
            found.append(int(own[damage[own].argmax()]))
    return sorted(found, key=lambda node: -damage[node])


def shortest_lives(
    dataset: xr.Dataset,
    nodes: Mapping[int, NodeLife],
    whole: Shapes,
    regions: NDArray,
    verdicts: Mapping[int, str],
) -> pd.DataFrame:
    """Table of lives and what makes them, of some nodes such as the worst of every region.

    Parameters
    ----------
    regions : array (n,) of str
        Of `regions.shoe_regions`.
    verdicts : mapping of int to str
        How far to trust the stress of each node.

    Returns
    -------
    pandas.DataFrame
        A row a node: region, node and its place in the shoe (m); life (h, 1e9 for
        all beyond) at each survival; the range in which the last of them lies, by what is open of the stress,
        and the verdict; the place in the track that wears it most and the life of a shoe that
        stays there; run and phase with the greatest part of the damage, and that part; the load with the
        greatest part, and the parts of all; life by each criterion at the greatest survival, those signed
        without what goes from run to run; and whether a joint's rigid spider is near.
    """
    rows = []
    for node, life in nodes.items():
        own = dataset.sel(node=node)
        places = own.place_damage.isel(survival=-1)
        parts = own.part_damage
        whole_damage = float(own.damage_an_hour[-1])
        loads = life.load_shares
        row: dict[str, object] = {"region": regions[node], "node": node}
        row |= {f"{axis} in the shoe in m": float(own.node_position.sel(axis=axis)) for axis in "xyz"}
        row |= {_life_at(one): float(own.life.sel(survival=one)) for one in own.survival.values}
        factor = float(own.life_factor)
        row |= {
            f"{LIFE} at least": float(life_hours(whole_damage * factor)),
            f"{LIFE} at most": float(life_hours(whole_damage / factor)),
            "verdict": verdicts[node],
            "worst place": int(places.shoe[int(np.nanargmax(places.values))]),
            f"{LIFE} there": float(life_hours(float(places.max()))),
            "main part": str(parts.part.values[int(parts.values.argmax())]) if whole_damage > 0.0 else "",
            "its share": float(parts.max()) / whole_damage if whole_damage > 0.0 else 0.0,
            "main load": max(loads, key=lambda name: loads[name]) if loads else "",
        }
        row |= {SHARE + name: share for name, share in loads.items()}
        row |= {f"{LIFE}, {name}": float(life_hours(one)) for name, one in life.by_criterion.items()}
        row[f"{LIFE}, critical plane"] = float(life_hours(float(own.plane_damage[-1])))
        row["flag"] = _flag(whole, node)
        rows.append(row)
    return pd.DataFrame(rows)


def _life_at(survival: float) -> str:
    return f"{LIFE} that {100.0 * survival:g} % survive"


def _flag(whole: Shapes, node: int) -> str:
    """Whether a joint's rigid spider makes the stress of a node, in words of the hot spots."""
    if node in whole.spider_nodes:
        return "in spider"
    return "beside spider" if node in whole.nodes_beside_spiders else ""


def in_words(table: pd.DataFrame) -> pd.DataFrame:
    """Same table with lives as they are read: four digits, "beyond 1e9"."""
    lives = [name for name in table.columns if name.startswith(LIFE)]
    return table.assign(**{name: table[name].map(life_words) for name in lives})


def life_words(hours: float) -> str:
    """Life in h for reading."""
    if np.isnan(hours):
        return "not known"
    return "beyond 1e9" if hours >= BEYOND else f"{hours:.4g}"
