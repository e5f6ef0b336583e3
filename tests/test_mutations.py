"""Files of every kind, changed by seed: each is read, or refused in at most two lines that name it."""

from collections import Counter

import pytest

from tests.mutations import SILENT, kinds, mutated, outcome


@pytest.mark.filterwarnings("default")
def test_unchanged_files_are_read_without_a_word(tmp_path):
    for kind in kinds():
        end = outcome(kind, kind.content, tmp_path)
        assert (end.code, end.errors, end.others) == (0, (), ()), kind.name


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("count", [64, pytest.param(1000, marks=pytest.mark.slow)])
def test_changed_files_are_taken_with_a_warning_or_refused_in_two_lines(tmp_path, count):
    told = []
    silent = []
    ends = Counter()
    for number, (kind, change, end, faults) in enumerate(mutated(count, tmp_path)):
        ends[end.code] += 1
        lines = [f"{number} {kind.name}: {change.what}: {fault}" for fault in faults]
        (silent if faults == [SILENT] else told).extend(lines)
    assert told == []
    # some of a thousand such values are plausible, and not yet among those that may be any
    assert len(silent) <= max(1, count // 200), silent
    # it is not the refusals alone that were tried
    assert min(ends[0], ends[2]) >= count // 10, ends
