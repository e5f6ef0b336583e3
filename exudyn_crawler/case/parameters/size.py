"""Sizes of a run that no machine can hold, refused before it starts."""

import math
import os
from collections.abc import Iterator
from typing import SupportsFloat

from exudyn_crawler.case.case import Case

NUMBER = 8
"""Bytes."""
FALLBACK_MEMORY = 64e9
"""Bytes, taken for the machine's memory where the system does not tell it."""
GREATEST_HISTORY = 1e12
"""Bytes of a history on disk."""
MOST_STAGES = 1_000_000
"""Stages of a run, which begin at its checkpoints."""
COPIES_OF_MODES = 6
"""Arrays as large as a basis that a reduction and the stresses of its modes hold at a time."""
A_UNIT = 20e3
"""Bytes of a unit that is a body of the multibody system with its joints."""


def check_duration(duration: object) -> None:
    """Refuse a duration that is no number of seconds above zero.

    Raises
    ------
    ValueError
    """
    if not isinstance(duration, SupportsFloat):
        raise ValueError(f"duration must be a number in s, got {duration!r}")
    if not 0.0 < float(duration) < math.inf:
        raise ValueError(f"duration must be positive and finite, got {duration!r} s")


def check_size(case: Case, duration: float) -> None:
    """Refuse a run that would take more memory than the machine has, or a history that no disk holds.

    Parameters
    ----------
    duration : float
        s.

    Raises
    ------
    ValueError
        With what is too large and what it would take.
    """
    for what, needed in memory(case):
        _check_memory(what, needed)
    solver = case.solver
    times = duration / max(solver.output_interval, solver.step)
    needed = times * stored_numbers(case) * NUMBER
    if needed > GREATEST_HISTORY:
        raise ValueError(
            f"duration: {duration:g} s would leave {times:.3g} stored states of {_bytes(needed)}, allowed is "
            f"{_bytes(GREATEST_HISTORY)}; a greater solver.output_interval stores fewer"
        )
    stages = duration / solver.checkpoint_interval
    if stages > MOST_STAGES:
        raise ValueError(
            f"solver.checkpoint_interval: {solver.checkpoint_interval:g} s in {duration:g} s make "
            f"{stages:.3g} stages, allowed are {MOST_STAGES}"
        )


def memory(case: Case) -> Iterator[tuple[str, float]]:
    """Bytes that parts of a case take while it is built, by what takes them, as far as they grow fast."""
    terrain = case.terrain
    what = f"terrain: {terrain.columns} x {terrain.rows} units"
    if case.terrain_formulation == "constrained" or case.contact.model == "spheres":
        yield what, A_UNIT * terrain.unit_count
    else:
        # singular value decomposition of the joints' equations in the heave and tilt of every unit
        yield what, 4.0 * NUMBER * (2.0 * terrain.unit_count) ** 2


def stored_numbers(case: Case) -> int:
    """Numbers of a stored state in a history, about: coordinates with two rates, units and contacts."""
    shoes, units = case.track.shoe_count, case.terrain.unit_count
    modes = 0 if case.flexible is None else case.flexible.mode_count * len(case.flexible.shoes)
    return 60 * shoes + 6 * units + 3 * modes


def check_modes(nodes: int, modes: int) -> None:
    """Refuse a basis of so many modes of a mesh that the machine cannot hold; see `check_size`."""
    needed = float(COPIES_OF_MODES * NUMBER * 3 * nodes * modes)
    _check_memory(f"flexible.recovered_modes: {modes} modes of {nodes} nodes", needed)


def _check_memory(what: str, needed: float) -> None:
    allowed = machine_memory()
    if needed > allowed:
        raise ValueError(
            f"{what} would take {_bytes(needed)} of memory, more than the {_bytes(allowed)} of this machine"
        )


def machine_memory() -> float:
    """Memory of this machine, bytes."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return FALLBACK_MEMORY


def _bytes(count: float) -> str:
    """Bytes for reading."""
    for size, unit in ((1e15, "PB"), (1e12, "TB"), (1e9, "GB"), (1e6, "MB")):
        if count >= size:
            return f"{count / size:.3g} {unit}"
    return f"{count:.3g} B"
