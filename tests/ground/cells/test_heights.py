"""Heights of the ground: slopes are derivatives, a seed is the same rock, measured grids from files."""

import math

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose, assert_array_equal

from exudyn_crawler.case.parameters.heights import (
    Heights,
    MeasuredGrid,
    Ramp,
    Ridge,
    Roughness,
    Stone,
    Waves,
)
from exudyn_crawler.errors import CrawlerError, ParameterError
from tests.ground.cells.driving import DOWN, LOAD, ROCK, Driven, Shoe, ground

X, Y = (axis.ravel() for axis in np.meshgrid(np.linspace(-3, 3, 41), np.linspace(-2, 2, 33), indexing="ij"))
GRID = 0.05 * np.sin(np.arange(5))[:, None] + 0.02 * np.arange(4)
GRID_X, GRID_Y = 10.25 + 0.5 * np.arange(5), 20.25 + 0.5 * np.arange(4)
ASCII = "ncols 5\nnrows 4\nxllcorner 10\nyllcorner 20\ncellsize 0.5\nNODATA_value -9999\n"


@pytest.mark.parametrize(
    "heights",
    [
        Heights(level=1.0, slope_x=0.05, slope_y=-0.1),
        Heights(parts=(Ridge(x=0.2, y=0.1, heading=30.0, height=0.1, width=0.5, flank=0.4, length=2.0),)),
        Heights(parts=(Ridge(height=-0.2, width=0.6, flank=0.5), Stone(x=1, y=-1, height=0.06, flank=0.7))),
        Heights(roughness=Roughness(spectrum=16e-6, seed=5)),
        Heights(parts=(Ramp(x=-1.0, heading=20.0, height=0.2, flank=4.0),)),
        Heights(parts=(Waves(x=0.5, heading=-50.0, height=0.1, length=3.0),), scale=-2.0),
    ],
)
def test_slopes_are_the_derivatives_of_heights(heights):
    x, y, e = X + 0.0123, Y + 0.0071, 1e-5
    z = heights.sample(x, y)
    by_x = (heights.sample(x + e, y) - heights.sample(x - e, y))[:, 0] / (2 * e)
    by_y = (heights.sample(x, y + e) - heights.sample(x, y - e))[:, 0] / (2 * e)
    assert_allclose(z[:, 1:], np.column_stack((by_x, by_y)), atol=2e-5)
    assert np.abs(z[:, 0]).max() > 3e-3


def test_parts_stand_where_they_are_named():
    parts = (
        Ridge(x=1.0, height=0.2, width=0.4, flank=0.3),
        Stone(x=-1.0, y=1.0, height=-0.1, width=0.2, flank=0.3),
        Ramp(x=10.0, height=0.4, flank=2.0),
        Waves(x=20.0, heading=90.0, height=0.0, length=4.0),
    )
    x, y = np.array([1.19, 1.51, 1.0, -1.0, -1.0, 10.5, 13.0]), np.array([5.0, 0.0, -40.0, 1.05, 1.41, 0, 9])
    assert_allclose(Heights(parts=parts).sample(x, y)[:, 0], [0.2, 0.0, 0.2, -0.1, 0.0, 0.1, 0.4], atol=1e-15)
    waves = Heights(parts=(Waves(x=1.0, height=0.3, length=4.0),))
    assert_allclose(waves.sample(np.array([1.0, 3.0, 4.0]), np.zeros(3))[:, 0], [0.0, 0.3, 0.15], atol=1e-15)


def test_same_seed_is_the_same_rock_on_any_map():
    rough = Heights(roughness=Roughness(spectrum=256e-6, seed=11))
    assert_array_equal(rough.sample(X, Y)[7:20], rough.sample(X[7:20], Y[7:20]))
    other = rough.with_({"roughness.seed": 12})
    assert np.abs(rough.sample(X, Y) - other.sample(X, Y)).max() > 1e-3


def test_roughness_has_its_spectrum_along_any_line():
    """Variance of lines by bands of wave numbers, mean of 30 seeds."""
    h, n, spectra = 0.1, 1024, []
    along = h * np.arange(n)
    window = np.hanning(n)
    for seed in range(30):
        c, s = np.cos(seed), np.sin(seed)
        z = Roughness(spectrum=16e-6, seed=seed).sample(along * c, along * s)[:, 0]
        spectra.append(np.abs(np.fft.rfft(z * window)) ** 2 * 2 * h / np.sum(window**2))
    wave, spectrum = np.fft.rfftfreq(n, h), np.mean(spectra, axis=0)
    for low, high in ((0.1, 0.3), (0.3, 1.0)):
        band = (wave > low) & (wave < high)
        wanted = (16e-6 * (wave[band] / 0.1) ** -2).sum()
        assert spectrum[band].sum() == pytest.approx(wanted, rel=0.15)  # less the waves across that are cut


def test_grids_of_all_formats_hold_the_same_heights(tmp_path):
    rows = "\n".join(" ".join(f"{one:.17g}" for one in row) for row in GRID.T[::-1])
    (tmp_path / "a.asc").write_text(ASCII + rows, encoding="ascii")
    np.save(tmp_path / "a.npy", GRID)
    dataset = xarray.Dataset({"z": (("y", "x"), GRID.T)}, {"x": GRID_X, "y": GRID_Y})
    dataset.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    plain = MeasuredGrid(file=tmp_path / "a.asc", smoothing=0.0)
    others = (
        MeasuredGrid(file=tmp_path / "a.npy", spacing=0.5, origin=(10.25, 20.25), smoothing=0.0),
        MeasuredGrid(file=tmp_path / "a.nc", smoothing=0.0),
    )
    at = np.meshgrid(np.linspace(10.25, 12.25, 30), np.linspace(20.25, 21.75, 20))
    for other in others:
        assert_allclose(other.sample(*at), plain.sample(*at), atol=1e-12)
    assert_allclose(plain.sample(*np.meshgrid(GRID_X, GRID_Y))[..., 0], GRID.T, atol=1e-14)
    assert np.isnan(plain.sample(np.array([10.2]), np.array([21.0]))).all()


# of rasterio's own
@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")
def test_a_geotiff_holds_the_same_heights(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    move = rasterio.transform.from_origin(10.0, 22.0, 0.5, 0.5)
    kind = {"driver": "GTiff", "count": 1, "dtype": "float64", "nodata": -9999.0, "crs": "EPSG:32612"}

    def written(name, z):
        with rasterio.open(tmp_path / name, "w", width=5, height=4, transform=move, **kind) as file:
            file.write(z.T[::-1], 1)
        return MeasuredGrid(file=tmp_path / name, smoothing=0.0)

    sampled = written("a.tif", GRID).sample(*np.meshgrid(GRID_X, GRID_Y))[..., 0]
    assert_allclose(sampled, GRID.T, atol=1e-14)
    holed = GRID.copy()
    holed[1, 2] = -9999.0
    beside = written("b.tif", holed).sample(np.array([10.5, 11.5]), np.array([21.5, 21.5]))[:, 0]
    assert np.isnan(beside).tolist() == [True, False]


def test_a_step_is_smoothed_to_a_gaussians_integral(tmp_path):
    z = np.zeros((80, 40))
    z[40:] = 0.05
    np.save(tmp_path / "step.npy", z)
    step = MeasuredGrid(file=tmp_path / "step.npy", spacing=0.05)
    x = np.linspace(0.0, 79 * 0.05, 4001)
    height, slope, across = step.sample(x, np.full_like(x, 1.0)).T
    assert slope.max() == pytest.approx(0.05 / (step.smoothing * math.sqrt(2.0 * math.pi)), rel=0.05)
    assert x[slope.argmax()] == pytest.approx(39.5 * 0.05, abs=1e-6)
    assert_allclose(height[[0, -1]], [0.0, 0.05], atol=1e-6)
    assert np.abs(across).max() < 1e-12
    np.save(tmp_path / "wall.npy", 2.0 * z)
    MeasuredGrid(file=tmp_path / "wall.npy", spacing=0.05)
    with pytest.raises(ParameterError, match="more than 1 m a metre, since cells know no walls, got 2 with"):
        MeasuredGrid(file=tmp_path / "wall.npy", spacing=0.05, smoothing=0.0)


def swing(grid, end):
    """How far heights leave those of a file between 0 and another level (m), between its places."""
    x, y = np.meshgrid(np.linspace(0.5, 3.4, 400), np.linspace(0.1, 1.8, 60))
    z = grid.sample(x, y)[..., 0]
    return max(-z.min(), z.max() - end)


@pytest.mark.parametrize("alone", [False, True], ids=["step", "single cell"])
def test_steps_and_single_cells_of_a_file_are_smoothed_or_refused(tmp_path, alone):
    def measured(height, smoothing):
        z = np.zeros((80, 40))
        if alone:
            z[40, 20] = height
        else:
            z[40:] = height
        np.save(tmp_path / "step.npy", z)
        return MeasuredGrid(file=tmp_path / "step.npy", spacing=0.05, smoothing=smoothing)

    message = (
        r"^smoothing: must be at least 0\.025 m, half a spacing of .*step.npy, since its heights have steps"
    )
    for smoothing in (0.0, 0.02):
        with pytest.raises(ParameterError, match=message + f", got {smoothing:g} m$"):
            measured(0.02, smoothing)
    assert swing(measured(0.05, 0.025), 0.05) < 0.03 * 0.05
    assert swing(measured(0.05, 0.05), 0.05) < 1e-4 * 0.05
    # low ones may stay as they are
    low = 0.2 / (3.0 if alone else 2.0) * 0.05
    assert 1e-4 < swing(measured(0.99 * low, 0.0), low) < 0.011 * 0.05
    with pytest.raises(ParameterError, match=message):
        measured(1.01 * low, 0.0)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.asc", ASCII + "1 " * 19, "5 x 4 heights are announced in its head, got 19"),
        ("a.asc", "ncols 5\n" + "1 " * 20, "its head has no nrows and no cellsize"),
        ("a.asc", ASCII + "0 0 0 0 0 " * 2 + "9 9 9 9 9 " * 2, "must not rise by more than 1 m a metre"),
        ("a.xyz", "", "its name must end with one of .asc, .npy, .nc, .tif, .tiff"),
        ("a.npy", "no array", "cannot be used: an NPY file needs a spacing"),
        ("a.nc", "no file", "cannot be used"),
    ],
)
def test_bad_files_get_one_line(tmp_path, name, text, message):
    (tmp_path / name).write_text(text, encoding="ascii")
    with pytest.raises(ParameterError, match=message) as error:
        MeasuredGrid(file=tmp_path / name)
    assert len(error.value.errors) == 1
    with pytest.raises(ParameterError, match=r"missing\.asc cannot be used"):
        MeasuredGrid(file=tmp_path / "missing.asc")


def test_parts_that_are_too_fine_for_the_cells_are_refused():
    heights = Heights(parts=(Ridge(height=0.1, width=0.2, flank=0.15),), roughness=Roughness(spectrum=1e-6))
    with pytest.raises(ParameterError) as error:
        ground(ROCK, heights, cell=0.12)
    assert error.value.errors == [
        "parts[0].flank (ridge): must be at least 2 cells of 0.12 m, got 0.15 m",
        "roughness.shortest: must be at least 4 cells of 0.12 m, got 0.4 m",
    ]


@pytest.mark.slow
def test_a_shoe_that_leaves_the_measured_ground_is_reported(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((30, 60)))
    heights = Heights(measured=MeasuredGrid(file=tmp_path / "a.npy", spacing=0.1))
    shoe = Shoe(ROCK, [1.5, 3.0, 0.0], heights=heights)
    assert shoe.move([1.5, 3.0, -1e-4])[2] == pytest.approx(1e5 * 0.65 * 3.505, rel=1e-9)
    with pytest.raises(CrawlerError, match=r"a shoe left the measured ground: the track is at x = 2\.8"):
        shoe.move([2.8, 3.0, -1e-4])


def test_a_shoe_driven_over_a_ridge_is_lifted_without_a_blow():
    """60 mm over a smooth flank: the support stays below three times the load, tipping included."""
    ridge = Ridge(x=4.0, height=0.06, width=0.05, flank=0.3)
    how = {"mass": LOAD / 9.81, "h": 5e-3, "heights": Heights(parts=(ridge,))}
    shoe = Driven(ROCK.with_(damping=0.5), [3.3, 3.0, 1e-4], **how)
    shoe.settle(DOWN)
    peak = 0.0
    while shoe.r[0] < 4.4:
        shoe.step(DOWN, (1e7, 0.2 * min(1.0, shoe.time / 0.5)))
        peak = max(peak, shoe.ground.shoes.wrench[0, 2])
    assert shoe.r[2] > 0.02
    assert peak < 3.0 * LOAD
    assert abs(1.0 - shoe.R[1, 1]) < 1e-6
