"""Blocks of memory that compiled functions read."""

from typing import NamedTuple

import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.ground import packed
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.model import equations
from exudyn_crawler.model.compiled_system import compiled_system


class Part(NamedTuple):
    """Numbers of every kind."""

    places: packed.Floats2
    count: int
    law: tuple[float, float]
    is_on: bool


class Whole(NamedTuple):
    """Parts in a row and one alone."""

    parts: tuple[Part, Part]
    last: Part
    numbers: packed.Ints1


KIND = packed.type_of(Whole)
read = packed.reader(KIND)


@inner(allocates=True)
def _summed(part: Part) -> float:
    return part.places.sum() * part.law[1] + part.count + (0.25 if part.is_on else 0.5)


@kernel
def summed(block):
    """Sums of the parts, once in a loop and once by name; the first place of the last is written."""
    whole, total = read(block), 0.0
    for k in range(2):
        total += _summed(whole.parts[k])
    whole.last.places[1, 2] = 7.0
    return total, whole.last.places[1, 1], whole.last.law[0], whole.numbers[whole.numbers.shape[0] - 1]


def part(value, is_on):
    return Part(np.full((2, 3), value), 40, (0.5, 10.0), is_on)


def test_compiled_code_reads_and_writes_what_python_packed():
    whole = Whole((part(1.0, True), part(2.0, False)), part(3.0, True), np.arange(5))
    block = packed.pack(whole, KIND)
    assert summed(block) == (180.0 + 80.75, 3.0, 0.5, 4)
    assert whole.last.places[1].tolist() == [3.0, 3.0, 7.0]


@pytest.mark.parametrize(
    "places",
    [np.zeros((3, 2)).T, np.zeros((2, 3), dtype=np.float32), np.zeros(6), np.zeros((2, 3), dtype=int)],
    ids=["across", "single", "flat", "whole"],
)
def test_an_array_of_another_type_is_refused(places):
    odd = Part(places, 1, (0.0, 0.0), True)
    with pytest.raises(TypeError, match=r"arrays must be array\(float64, 2d, C\), got array"):
        packed.pack(Whole((part(1.0, True), odd), odd, np.arange(2)), KIND)


def test_nothing_is_of_its_kind_and_has_no_rows():
    nothing = packed.nothing(Whole)
    packed.pack(nothing, KIND)
    assert nothing.parts[0].places.shape == (0, 0)
    assert nothing.numbers.shape == (0,)


@pytest.mark.simulation
def test_all_cases_are_compiled_as_one():
    sand = BekkerSoil.lete_sand()
    dragged, rolled = Case.translation(), Case.rolled()
    for case in (dragged, rolled, Case.closed(), dragged.on_cells(sand), rolled.on_cells(sand)):
        system = compiled_system(case)
        state = np.zeros((3, system.layout.coordinate_count))
        if system.sticks:
            system.cells.cover(state)
        assert np.isfinite(system.residual(state, system.inputs(0.0))).all()
    assert len(equations.residual.signatures) == 1
