"""Equations that no disk keeps yet: half of them is compiled by another process, for every kind of track."""

import json
import os
import subprocess
import sys

import pytest

SCRIPT = """
import json
from exudyn_crawler import Case, FlexibleShoes, simulate
from exudyn_crawler.model.equations import matrix, residual
from exudyn_crawler.model.newton import step

few = FlexibleShoes.ph4100c("coarse").with_(shoes=(12, 13), fixed_modes=2, recovered_modes=2)
simulate(Case.turning(), 0.002, progress=False)
simulate(Case.stress("coarse").with_(flexible=few), 0.002, progress=False)
stats = [one.stats for one in (residual, matrix, step)]
print(json.dumps([[sum(one.cache_hits.values()), sum(one.cache_misses.values())] for one in stats]))
"""


@pytest.mark.slow
def test_the_matrix_is_compiled_beside_the_residual_and_once_for_all_tracks(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    for expected in ([[0, 1], [1, 0], [0, 1]], [[1, 0]] * 3):
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True
        )
        hits_and_misses = json.loads(done.stdout.splitlines()[-1])
        assert hits_and_misses[0] == expected[0]
        assert hits_and_misses[2] == expected[2]
        assert hits_and_misses[1][1] == expected[1][1]
