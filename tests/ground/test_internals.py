"""Numba without the internals that the compiled functions use: the same numbers, and a warning."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from exudyn_crawler import Case, simulate
from exudyn_crawler.ground import packed
from exudyn_crawler.ground.cells import layouts, tiles
from exudyn_crawler.ground.cells.pressing import ShoePoints

GONE = """
import sys, types
import numba.np.arrayobj


def without(name, other=None):
    # a module as this package sees it; numba keeps its own
    module = types.ModuleType("numba.np.arrayobj")
    vars(module).update(vars(numba.np.arrayobj))
    delattr(module, name)
    if other:
        setattr(module, name, other)
    sys.modules["numba.np.arrayobj"] = module
"""
CHANGES = {
    "there is no maker of entries": """
import sys
import numba
del numba._dynfunc
sys.modules["numba._dynfunc"] = None
""",
    "there are no arrays of parts": GONE + 'without("populate_array")\n',
    "arrays have the shape backwards": GONE
    + """
populate = numba.np.arrayobj.populate_array


def turned(array, **parts):
    return populate(array, **parts | {"shape": parts["shape"][::-1]})


turned.__module__ = "numba"
without("populate_array", turned)
""",
    "passes are added otherwise": """
from numba.core.compiler_machinery import PassManager
PassManager.add_pass_after = lambda self, *passes: None
""",
    "references are always counted": """
from numba.core import cpu, options
del options.DefaultOptions._nrt, cpu._options_mixin._nrt
""",
}
"""What a later numba might do."""
ASK = "from tests.ground.test_internals import {0}; print({0}())"


def digest(*arrays: np.ndarray) -> str:
    """Return a digest of all bits of arrays."""
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()


def committed() -> str:
    """Return the digest of a map on which the pressure of two shoes on twenty cells is accepted."""
    random = np.random.default_rng(3)
    memory = random.uniform(0.0, 1.0, (tiles.SIDE**2, tiles.FIELDS))
    ground = packed.nothing(tiles.Tiles)._replace(
        fresh=0.125, forgets=False, memory=memory, loaded=np.zeros(len(memory))
    )
    shoes = packed.nothing(ShoePoints)._replace(
        counts=np.array([20, 15]),
        cells=np.stack([random.permutation(30)[:20] for _ in range(2)]),
        areas=random.uniform(0.001, 0.01, (2, 20)),
        trial=random.uniform(-0.5, 1.0, (2, 20, layouts.TRIAL_WIDTH)),
    )
    block = packed.pack(tiles.TilesUnderShoes(ground, shoes), tiles.UNDER_SHOES)
    held = tiles.commit(block, np.arange(40))
    return digest(memory, held)


def simulated() -> str:
    """Return the digest of a run."""
    history = simulate(Case.translation(), 0.05, progress=False)
    return digest(*(history[name].values for name in sorted(history.variables)))


def asked(function: str, change: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Ask for a digest in a process of its own, with another numba and an empty cache."""
    paths = os.pathsep.join(sys.path)
    environment = os.environ | {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(folder)}
    command = [sys.executable, "-c", change + ASK.format(function)]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True)


def is_the_same_and_warns(function: str, change: str, folder: Path) -> None:
    done = asked(function, CHANGES[change], folder)
    assert done.stdout.strip() == globals()[function]()
    assert done.stderr.count("has other internals than expected") == 1


@pytest.mark.simulation
@pytest.mark.parametrize(
    "change", [pytest.param(name, marks=[pytest.mark.slow] if k else []) for k, name in enumerate(CHANGES)]
)
def test_another_numba_gives_the_same_numbers_and_a_warning(change, tmp_path):
    is_the_same_and_warns("committed", change, tmp_path)


@pytest.mark.slow
def test_another_numba_gives_the_same_run(tmp_path):
    is_the_same_and_warns("simulated", "there is no maker of entries", tmp_path)
