"""Compiled functions that are cached on disk."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.simulation
of_unix = pytest.mark.skipif(sys.platform == "win32", reason="limits of a process and signals are Unix's")

HELPER = (
    "from fem.compiling import compiler\n\n"
    "compiled = compiler(fastmath=set(('contract', 'nnan', 'reassoc')))\n"
)
INNER = HELPER + "\n\n@compiled\ndef inner(x):\n    return {factor} * x\n"
OUTER = "from inner import compiled, inner\n\n\n@compiled\ndef outer(x):\n    return inner(x) + 1.0\n"
ASK = """
from fem.compiling import notify_compiling
from outer import outer
told = []
with notify_compiling([outer], lambda: told.append(1)):
    result = outer(3.0)
print(result, len(told), outer.stats.cache_hits)
"""
INTERRUPTED = """
import os, signal
from numba.core import codegen

signal.signal(signal.SIGINT, signal.default_int_handler)
library, asked = codegen.CPUCodeLibrary, []
get = library._object_getbuffer_hook


def interrupted(module):
    asked.append(module)
    os.kill(os.getpid(), signal.SIGINT)
    return get(module)


library._object_getbuffer_hook = interrupted
from outer import outer

try:
    outer(3.0)
except KeyboardInterrupt:
    print("interrupted", len(asked) > 0, outer(3.0))
"""
CHANGES = {
    "the stamp is not compared": """
from numba.core.caching import IndexDataCacheFile
IndexDataCacheFile._load_index = lambda self: {"key": "trial.1.nbc"}
""",
    "the file has another name": """
from numba.core.caching import FunctionCache
FunctionCache.__getattribute__ = lambda self, name: (
    None if name == "_cache_file" else object.__getattribute__(self, name)
)
""",
    "the cache saves otherwise": """
from numba.core.caching import Cache, _Cache
del Cache.save_overload, _Cache.save_overload
""",
}
"""What a later numba might do."""
FULL_DISK = """
import resource, signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
"""


def run(folder: Path, before: str = "", ask: str = ASK, seed: int = 1) -> subprocess.CompletedProcess[str]:
    """A process of its own that asks the compiled function; the order of sets goes by the seed."""
    paths = os.pathsep.join([str(folder), str(Path(__file__).parents[2])])
    command = [sys.executable, "-c", before + ask]
    environment = os.environ | {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(folder / "cache")}
    environment["PYTHONHASHSEED"] = str(seed)
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True)


@pytest.fixture
def functions(tmp_path: Path) -> Path:
    """Folder of a function and of one that it calls."""
    (tmp_path / "outer.py").write_text(OUTER)
    (tmp_path / "inner.py").write_text(INNER.format(factor="2.0"))
    return tmp_path


def test_a_cached_function_notices_a_change_of_what_it_calls(functions):
    assert run(functions).stdout.startswith("7.0 1 ")
    again = run(functions, seed=4).stdout
    assert again.startswith("7.0 0 ")
    assert not again.rstrip().endswith("Counter()")
    (functions / "inner.py").write_text(INNER.format(factor="5.0"))
    assert run(functions).stdout.startswith("16.0 1 ")


OF_OTHERS = {
    "constants.py": "FACTOR = 2.0\nSHIFT = 1.0\n",
    "parts.py": "from typing import NamedTuple\n\n\nclass Part(NamedTuple):\n    a: float\n    b: float\n",
    "unrelated.py": "NOTHING = 0\n",
    "inner.py": HELPER + "import constants\nimport unrelated\nfrom parts import Part\n"
    "\n\n@compiled\ndef inner(x):\n    return Part(constants.FACTOR * x, 0.0)\n",
    "outer.py": "from constants import SHIFT\nfrom inner import compiled, inner\n"
    "\n\n@compiled\ndef outer(x):\n    return inner(x).a + SHIFT\n",
}
"""Files of a function that takes constants, one as it is and one from its module, and a named tuple."""


@pytest.mark.slow
def test_a_cached_function_notices_constants_and_named_tuples_and_nothing_else(tmp_path):
    for name, text in OF_OTHERS.items():
        (tmp_path / name).write_text(text)
    assert run(tmp_path).stdout.startswith("7.0 1 ")
    changes = [
        ("unrelated.py", "NOTHING = 0", "NOTHING = 1", "7.0 0 "),
        ("constants.py", "SHIFT = 1.0", "SHIFT = 4.0", "10.0 1 "),
        ("constants.py", "FACTOR = 2.0", "FACTOR = 5.0", "19.0 1 "),
        ("constants.py", "FACTOR = 5.0\nSHIFT = 4.0", "FACTOR = 4.0\nSHIFT = 5.0", "17.0 1 "),
        ("parts.py", "a: float\n    b: float", "b: float\n    a: float", "5.0 1 "),
    ]
    for name, old, new, expected in changes:
        file = tmp_path / name
        file.write_text(file.read_text().replace(old, new))
        assert run(tmp_path).stdout.startswith(expected), name


@pytest.mark.slow
@of_unix
def test_a_function_that_finds_no_space_for_its_cache_is_compiled_all_the_same(functions):
    for _ in range(2):
        assert run(functions, FULL_DISK).stdout == "7.0 1 Counter()\n"


@pytest.mark.slow
@of_unix
def test_code_of_earlier_sources_is_not_taken_after_a_full_disk(functions):
    assert run(functions).stdout.startswith("7.0 1 ")
    (functions / "inner.py").write_text(INNER.format(factor="5.0"))
    # room for the index of the cache, none for the code
    small = FULL_DISK.replace("(100, 100)", "(4000, 4000)")
    assert run(functions, small).stdout.startswith("16.0 1 ")
    assert run(functions).stdout.startswith("16.0 1 ")


@of_unix
def test_an_interrupt_waits_until_a_function_is_compiled_or_loaded(functions):
    for _ in range(2):
        assert run(functions, ask=INTERRUPTED).stdout == "interrupted True 7.0\n"


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
def test_a_numba_that_no_longer_compares_stamps_caches_nothing_and_warns(functions, change):
    assert run(functions).stdout.startswith("7.0 1 ")
    (functions / "inner.py").write_text(INNER.format(factor="5.0"))
    done = run(functions, CHANGES[change])
    assert done.stdout == "16.0 1 Counter()\n"
    assert done.stderr.count("no longer stamps its cache as expected") == 1
