"""Ground whose units have different heights: the track follows it, and bad ground is refused."""

import math
import subprocess
import sys

import numpy as np
import pytest

from exudyn_crawler import Case, History, simulate
from exudyn_crawler.case import Terrain
from exudyn_crawler.case.parameters.contact import SphereContact as Spheres
from exudyn_crawler.errors import EquilibriumError, ParameterError
from exudyn_crawler.ground.contact import ground_contact
from exudyn_crawler.results.loads.balance import shoe_imbalance
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from studies.comparison import time_mean
from studies.grounds import (
    RAMP_END,
    RAMP_HEIGHT,
    RAMP_START,
    STEP_HEIGHT,
    STEP_PLACE,
    strip,
    uneven_case,
)
from studies.uneven_ground import study

pytestmark = pytest.mark.simulation

GENERAL = Case.translation().with_(contact=Spheres.oil_sand())
INNER = slice(2, 12)
"""Shoes with a neighbour on both sides."""


@pytest.fixture(scope="module")
def step() -> History:
    return study(None, ["step"], duration=1.0)["step"].history


@pytest.fixture(scope="module")
def ramp() -> History:
    return study(None, ["ramp"], duration=1.0)["ramp"].history


@pytest.fixture(scope="module")
def rough() -> History:
    return study(None, ["rough"], duration=1.0)["rough"].history


def test_shoes_stand_higher_beyond_a_step(step):
    x, z = (step.position.sel(axis=axis, shoe=INNER) for axis in "xz")
    clear = 0.5 * (GENERAL.track.pitch + GENERAL.shoe.length)  # neither on the edge nor linked to who is
    before = float(z.where(x < STEP_PLACE - clear).mean())
    beyond = float(z.where(x > STEP_PLACE + clear).mean())
    # the units below both carry the same load and sag alike, to the millimetres by which they differ
    # towards the ends of the strip
    assert beyond - before == pytest.approx(STEP_HEIGHT, abs=0.003)


def test_a_step_down_mirrors_a_step_up():
    down = static_equilibrium(GENERAL.with_(terrain=strip().with_step(14.0, -0.1)))
    up = static_equilibrium(uneven_case("step"))
    heights = [q[2 : 6 * 13 : 6] for q in (down, up)]
    # shoes 2 to 5 and 9 to 12, less the two beside the one on the edge
    for z, change in zip(heights, (-0.1, 0.1), strict=True):
        assert z[8:12].mean() - z[1:5].mean() == pytest.approx(change, abs=0.004)


def test_slope_of_a_ramp_is_in_the_pitch(ramp):
    slope = RAMP_HEIGHT / (RAMP_END - RAMP_START)
    pitch = ramp.angles.sel(axis="y", shoe=INNER).mean()
    # nose up is a negative rotation about y; the steps of 1 m that make the ramp pitch shoes of 0.66 m by
    # more or less, which does not cancel over the eleven shoes
    assert float(-pitch) == pytest.approx(math.atan(slope), rel=0.12)
    now = ramp.position.isel(time=-1)
    line = np.polyfit(now.sel(axis="x"), now.sel(axis="z"), 1)
    assert line[0] == pytest.approx(slope, rel=0.03)


def test_shoes_follow_rough_ground(rough):
    contact = ground_contact(rough.case)
    q = np.zeros(contact.size)
    q[: 6 * 13] = np.hstack(
        (rough.position.values[-1] - contact.shoe_reference[:, :3], rough.angles.values[-1])
    ).ravel()
    ground = contact.ground_below(q, rough.case.terrain.top_heights)
    z = rough.position.sel(axis="z").values[-1]
    assert np.corrcoef(ground, z)[0, 1] > 0.9
    assert z.std() == pytest.approx(ground.std(), rel=0.3)


@pytest.mark.parametrize("ground", ["step", "ramp", "rough"])
def test_ground_carries_the_weight(ground, request):
    history = request.getfixturevalue(ground)
    weight = GENERAL.track.shoe_count * GENERAL.mean_load
    carried = (history.normal_force + history.friction_force).sel(axis="z").sum("contact")
    start = history.dataset.isel(time=0)
    assert float(carried[0]) == pytest.approx(weight, rel=1e-5)
    # the track's vertical momentum changes by less than 61 t times 0.05 m/s in a second
    assert float(time_mean(carried)) == pytest.approx(weight, rel=1e-3)
    for name in ("acceleration", "unit_heave_acceleration", "unit_tilt_acceleration"):
        assert float(abs(start[name]).max()) < 1e-3
    assert float(abs(shoe_imbalance(history).force).max()) < 1e-6 * weight


def test_seed_decides_the_roughness():
    one, again, other = (strip().with_roughness(0.02, seed) for seed in (1, 1, 2))
    assert one.heights == again.heights
    assert one.heights != other.heights
    large = Terrain.kinematics().with_(columns=50, rows=50).with_roughness(0.02, 1)
    # 2500 samples: the standard deviation is known within 1.4 %, the mean within 0.4 mm
    assert np.std(large.heights) == pytest.approx(0.02, rel=0.05)
    assert np.mean(large.heights) == pytest.approx(0.0, abs=0.0015)


def test_grounds_add_up():
    terrain = strip().with_step(14.0, 0.1).with_ramp(8.0, 20.0, 0.6)
    x = terrain.centers[:, 0]
    expected = np.where(x > 14.0, 0.1, 0.0) + 0.6 * np.clip((x - 8.0) / 12.0, 0.0, 1.0)
    assert terrain.top_heights == pytest.approx(expected, abs=1e-15)
    assert terrain.centers == pytest.approx(strip().centers)


def test_run_on_the_papers_grid():
    """Units of 7 x 7 m with a step below the track's middle."""
    terrain = Terrain.kinematics().with_step(14.0, 0.1)
    q = static_equilibrium(GENERAL.with_(terrain=terrain))
    even = static_equilibrium(GENERAL)
    rise = (q - even)[2 : 6 * 13 : 6]
    assert rise[:5].mean() == pytest.approx(0.0, abs=0.003)
    assert rise[8:].mean() == pytest.approx(0.1, abs=0.003)


def test_heights_are_refused_by_the_pair_law():
    with pytest.raises(ParameterError, match=r"terrain.heights must be None with contact\.model 'pair'"):
        Case.translation().with_(terrain=strip().with_step(14.0, 0.1))


@pytest.mark.parametrize(
    ("heights", "message"),
    [
        ((0.0,) * 12, r"heights must name every unit \(13\), got 12"),
        ((0.0,) * 12 + (math.nan,), "finite"),
        ((0.0,) * 12 + (math.inf,), "finite"),
    ],
)
def test_bad_heights_are_refused(heights, message):
    with pytest.raises(ParameterError, match=message):
        strip().with_(heights=heights)


def test_bad_grounds_are_refused():
    with pytest.raises(ValueError, match="x1 must be greater than x0 = 10"):
        strip().with_ramp(10.0, 10.0, 0.1)
    for deviation in (-0.1, math.nan, math.inf):
        with pytest.raises(ValueError, match="standard_deviation must be finite and not negative"):
            strip().with_roughness(deviation, 1)
    with pytest.raises(ParameterError, match="finite"):
        strip().with_step(10.0, math.inf)
    with pytest.raises(ValueError, match=r"ground must be of \['step', 'ramp', 'rough'\], got 'moon'"):
        uneven_case("moon")


def test_step_that_leaves_the_track_unsupported_is_refused():
    message = r"units 6 and 7 below it differ by 0\.2 m, allowed is less than 0\.1342 m"
    with pytest.raises(ParameterError, match=message):
        GENERAL.with_(terrain=strip().with_step(14.0, 0.2))
    larger = GENERAL.sphere_contact().with_(radius=0.25)
    with pytest.raises(ParameterError, match=r"allowed is less than 0\.1842 m"):
        GENERAL.with_(terrain=strip().with_step(14.0, 0.2), contact=larger)


def test_step_ahead_is_refused_before_the_run():
    case = GENERAL.with_(
        terrain=strip().with_step(19.0, 0.2)
    )  # the track ends at 18.3 m, at 19.06 m after 10 s
    case.check_support(8.0)
    with pytest.raises(ValueError, match=r"at t = 9\.\d+ s units 11 and 12 below it differ by 0\.2 m"):
        simulate(case, 10.0)


def test_ground_without_rest_is_named():
    """Down a steep ramp the track slides onto its held front shoe: at rest there is no friction."""
    case = GENERAL.with_(name="steep", terrain=strip().with_ramp(8.0, 20.0, -1.0))
    with pytest.raises(EquilibriumError, match=r"case 'steep' .* uneven ground.* shoe"):
        static_equilibrium(case)


@pytest.mark.slow
def test_study_runs_as_a_script(tmp_path):
    command = [
        sys.executable,
        "-m",
        "studies.uneven_ground",
        "step",
        "--duration",
        "0.05",
        "--out",
        tmp_path / "a",
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    names = {path.name for path in (tmp_path / "a" / "step").iterdir()}
    assert {"history.nc", "case.toml", "ground.png"} <= names
    again = subprocess.run(command, capture_output=True, text=True)
    assert again.returncode == 2
    assert "holds results already" in again.stderr
