"""One catalogue of quantities, and a room of results that needs no engine."""

import subprocess
import sys
from pathlib import Path

import pytest

import exudyn_crawler.results
from exudyn_crawler.results.history.catalogue import QUANTITIES
from exudyn_crawler.results.history.derived import contact_force, terrain_deformation


def test_every_variable_of_a_history_is_in_the_catalogue(flexible_run):
    history, stress, _ = flexible_run
    for dataset in (history.dataset, stress):
        for name, values in dataset.data_vars.items():
            quantity = QUANTITIES[str(name)]
            assert set(values.dims) == set(quantity.dimensions), name
            assert values.attrs == quantity.attributes, name


def test_derived_quantities_are_in_the_catalogue(translation):
    for found in (contact_force(translation), terrain_deformation(translation)):
        assert found.attrs in [quantity.attributes for quantity in QUANTITIES.values()]
    assert contact_force(translation).dims == QUANTITIES["contact_force"].dimensions


def test_every_quantity_has_a_name_of_its_own_and_a_label():
    for name, quantity in QUANTITIES.items():
        assert quantity.name == name
        assert quantity.label
        assert quantity.long_name


@pytest.mark.simulation
def test_results_are_read_without_the_engine():
    room = Path(exudyn_crawler.results.__file__).parent
    modules = [".".join(path.relative_to(room).with_suffix("").parts) for path in room.glob("*/[a-z]*.py")]
    assert "history.states" in modules
    imports = "".join(f"import exudyn_crawler.results.{name}\n" for name in sorted(modules))
    script = (
        f"import sys\n{imports}assert not [name for name in sys.modules if name.split('.')[0] == 'exudyn']"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)
