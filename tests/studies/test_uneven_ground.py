"""Spheres on units that follow a relief: the track follows it, too."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case, History
from exudyn_crawler.case import statics
from exudyn_crawler.case.parameters.contact import SphereContact as Spheres
from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.results.balance import shoe_imbalance
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from studies import grounds
from studies.comparison import time_mean
from studies.uneven_ground import study

pytestmark = pytest.mark.simulation

GENERAL = Case.translation().with_(contact=Spheres.oil_sand())
INNER = slice(2, 12)
"""Shoes with a neighbour on both sides."""


@pytest.fixture(scope="module")
def runs() -> dict[str, History]:
    """A second on every ground."""
    return {ground: run.history for ground, run in study(None, duration=1.0).items()}


@pytest.mark.slow
def test_shoes_stand_higher_beyond_a_step(runs):
    step = runs["step"]
    x, z = (step.position.sel(axis=axis, shoe=INNER) for axis in "xz")
    clear = 0.5 * (GENERAL.track.pitch + GENERAL.shoe.length)  # neither on the step nor linked to who is
    before = float(z.where(x < grounds.STEP_PLACE - clear).mean())
    beyond = float(z.where(x > grounds.STEP_PLACE + grounds.STEP_LENGTH + clear).mean())
    # the units below both carry the same load and sag alike, to the millimetres by which they differ
    # towards the ends of the strip
    assert beyond - before == pytest.approx(grounds.STEP_HEIGHT, abs=0.003)


def test_a_step_down_mirrors_a_step_up():
    up = grounds.uneven_case("step")
    found = [static_equilibrium(case) for case in (up.with_({"terrain.relief.scale": -1.0}), up)]
    heights = [q[2 : 6 * 13 : 6] for q in found]
    # shoes 2 to 5 and 10 to 12, less those beside the ones on the step
    for z, change in zip(heights, (-0.1, 0.1), strict=True):
        assert z[9:12].mean() - z[1:5].mean() == pytest.approx(change, abs=0.004)


@pytest.mark.slow
def test_slope_of_a_ramp_is_in_the_pitch(runs):
    ramp = runs["ramp"]
    slope = grounds.RAMP_HEIGHT / (grounds.RAMP_END - grounds.RAMP_START)
    pitch = ramp.angles.sel(axis="y", shoe=INNER).mean()
    # nose up is a negative rotation about y; the strip sags less below its ends
    assert float(-pitch) == pytest.approx(math.atan(slope), rel=0.05)
    now = ramp.position.isel(time=-1)
    assert np.polyfit(now.sel(axis="x"), now.sel(axis="z"), 1)[0] == pytest.approx(slope, rel=0.03)


@pytest.mark.slow
def test_shoes_follow_rough_ground(runs):
    rough = runs["rough"]
    ground = rough.case.terrain.surface(rough.position.sel(axis="x").values[-1])
    z = rough.position.sel(axis="z").values[-1]
    assert ground.std() > 0.005
    assert np.corrcoef(ground, z)[0, 1] > 0.9
    assert z.std() == pytest.approx(ground.std(), rel=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("ground", ["step", "ramp", "rough"])
def test_ground_carries_the_weight(ground, runs):
    history = runs[ground]
    weight = GENERAL.track.shoe_count * statics.mean_load(GENERAL)
    carried = (history.normal_force + history.friction_force).sel(axis="z").sum("contact")
    start = history.dataset.isel(time=0)
    assert float(carried[0]) == pytest.approx(weight, rel=1e-5)
    # the track's vertical momentum changes by less than 61 t times 0.05 m/s in a second
    assert float(time_mean(carried)) == pytest.approx(weight, rel=1e-3)
    for name in ("acceleration", "unit_heave_acceleration", "unit_tilt_acceleration"):
        assert float(abs(start[name]).max()) < 1e-3
    assert float(abs(shoe_imbalance(history).force).max()) < 1e-6 * weight


def test_unknown_ground_is_refused():
    with pytest.raises(ValueError, match=r"ground must be one of step, ramp, rough, got 'moon'"):
        grounds.uneven_case("moon")


@pytest.mark.slow
def test_ground_without_rest_is_named():
    """Down a steep ramp the track slides onto its held front shoe: at rest there is no friction."""
    case = grounds.uneven_case("ramp").with_({"name": "steep", "terrain.relief.scale": -1.7})
    with pytest.raises(EquilibriumError, match=r"case 'steep' .* uneven ground.* shoe"):
        static_equilibrium(case)


@pytest.mark.slow
def test_the_command_leaves_a_folder_and_does_not_overwrite_it(call, refused, tmp_path):
    words = ("studies", "uneven", "step", "--duration", 0.05, "--out", "a")
    code, _, err = call(*words)
    assert code == 0, err
    names = {path.name for path in (tmp_path / "a" / "step").iterdir()}
    assert {"history.nc", "case.toml", "ground.png"} <= names
    assert "holds results already" in refused(*words)
