"""State of a user's model with its tracks as arrays, from which another process goes on."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from exudyn_crawler.coupled.block import STATE
from exudyn_crawler.coupled.tracks import tracks_of
from exudyn_crawler.model.exudyn import exu

MODEL, TRACK = "model", "track"
"""First words of the names of arrays."""
PARTS = (
    *("ODE2Coordinates", "ODE2Coordinates_t", "ODE2Coordinates_tt"),
    *("ODE1Coordinates", "ODE1Coordinates_t", "AECoordinates", "DataCoordinates"),
)
"""Coordinates of a user's model, as Exudyn names them."""


def store_state(mbs: "exu.MainSystem") -> dict[str, np.ndarray]:
    """Return the state of a model with tracks after `solve_dynamic`, as arrays by name.

    A process that builds the same model, restores the state and goes on gives the same numbers as this one,
    bit for bit. `numpy.savez(path, **state)` writes it to a file. What the user's functions store is not part
    of it.
    """
    data: Any = mbs.systemData
    initial = exu.ConfigurationType.Initial
    stored = {f"{MODEL} {part}": np.array(getattr(data, f"Get{part}")(initial)) for part in PARTS}
    for number, track in enumerate(tracks_of(mbs), 1):
        stored |= {f"{TRACK} {number} {name}": values for name, values in track.block.stored().items()}
    return stored


def restore_state(mbs: "exu.MainSystem", stored: Mapping[str, np.ndarray]) -> None:
    """Set the state of an assembled model with tracks to one of `store_state`.

    The next `solve_dynamic` starts there; its settings give the time. Raises ValueError if the state is that
    of another model.
    """
    for name, values in store_state(mbs).items():
        count = len(stored[name]) if name in stored else 0
        # the memory of the ground grows as the track travels
        is_fixed = name.startswith(f"{MODEL} ") or name.endswith(f" {STATE}")
        if name not in stored or (is_fixed and count != len(values)):
            raise ValueError(
                f"the state is that of another model: {name!r} must have {len(values)} values, got {count}"
            )
    data: Any = mbs.systemData
    initial = exu.ConfigurationType.Initial
    for part in PARTS:
        getattr(data, f"Get{part}")(initial, False)[:] = stored[f"{MODEL} {part}"]
    for number, track in enumerate(tracks_of(mbs), 1):
        first = f"{TRACK} {number} "
        arrays = {name.removeprefix(first): one for name, one in stored.items() if name.startswith(first)}
        track.block.restore(arrays)
