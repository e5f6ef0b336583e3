"""Measured heights: files as other programs write them, units, missing heights, and a map below the track."""

import gc
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose

from exudyn_crawler import Case, simulate
from exudyn_crawler.case import Drive, Heights, StepProfile, Terrain
from exudyn_crawler.case.parameters.checks import warn_implausible
from exudyn_crawler.case.parameters.heights import MeasuredGrid
from exudyn_crawler.errors import ImplausibleWarning, ParameterError, SimulationStopped
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor

GRID = 0.05 * np.sin(np.arange(5))[:, None] + 0.02 * np.arange(4)
X, Y = 10.25 + 0.5 * np.arange(5), 20.25 + 0.5 * np.arange(4)
PLACES = np.meshgrid(X, Y, indexing="ij")
HEAD = {"ncols": 5, "nrows": 4, "xllcorner": 10, "yllcorner": 20, "cellsize": 0.5, "NODATA_value": -9999}


def ascii_text(changes=None, z=GRID, text=str):
    """ESRI ASCII grid of heights; None leaves a word of the head out."""
    head = {name: value for name, value in (HEAD | (changes or {})).items() if value is not None}
    lines = [f"{name} {text(value)}" for name, value in head.items()]
    return "\n".join([*lines, *(" ".join(text(float(value)) for value in row) for row in z.T[::-1])]) + "\n"


@pytest.fixture
def asc(tmp_path):
    """Grid of the bytes or the text of an ASCII file."""

    def grid(content, **how):
        path = tmp_path / "a.asc"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return MeasuredGrid(file=path, smoothing=0.0, **how)

    return grid


@pytest.fixture
def netcdf(tmp_path):
    """Grid of a NetCDF file of a variable over dimensions, with places and attributes."""

    def grid(dimensions=("x", "y"), z=GRID, places=None, attributes=None, **how):
        path = tmp_path / "a.nc"
        attributes = attributes or {}
        places = {"x": X, "y": Y} if places is None else places
        coordinates = {name: (name, values, attributes.get(name, {})) for name, values in places.items()}
        data = xarray.Dataset({"z": (dimensions, z, attributes.get("z", {}))}, coordinates)
        data.to_netcdf(path, engine="h5netcdf")
        return MeasuredGrid(file=path, smoothing=0.0, **how)

    return grid


def heights(grid):
    return grid.sample(*PLACES)[..., 0]


def comma(value):
    return str(value).replace(".", ",")


@pytest.mark.parametrize(
    "content",
    [
        ascii_text({"cellsize": None, "dx": 0.5, "dy": 0.5}),
        ascii_text({"xllcorner": None, "xllcenter": 10.25, "yllcorner": None, "YLLCENTER": 20.25}),
        ascii_text({"NODATA_value": "null"}),
        ascii_text({"NODATA_value": "nan"}),
        ascii_text({"ncols": "5.0"}),
        ascii_text(text=comma),
        b"\xef\xbb\xbf" + ascii_text().encode(),
        ascii_text().replace("\n", "\r\n"),
    ],
    ids=["dx and dy", "centres", "null", "nan", "5.0", "commas", "byte order mark", "line ends"],
)
def test_heads_of_other_programs_are_read(asc, content):
    assert_allclose(heights(asc(content)), GRID, atol=1e-14)


def test_steps_along_x_and_y_may_differ(asc):
    grid = asc(ascii_text({"cellsize": None, "dx": 0.5, "dy": 0.25}))
    assert grid.sides == (0.5, 0.25)
    assert_allclose(
        grid.sample(np.array([10.25, 12.25]), np.array([20.125, 20.875]))[:, 0],
        GRID[[0, -1], [0, -1]],
        atol=1e-14,
    )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (ascii_text({"cellsize": 0}), "cellsize must be positive, got 0"),
        (ascii_text({"ncols": 5.7}), r"ncols must be a whole number, got 5\.7"),
        (ascii_text({"nrows": -4}), "nrows must be a whole number, got -4"),
        (ascii_text({"ncols": "x"}), "ncols must be a number, got 'x'"),
        (ascii_text({"xllcorner": None}), "its head has no xllcorner"),
        (ascii_text({"cellsize": None, "dx": 1}), "its head has no cellsize"),
        (ascii_text({"rows": 4}), "its head has 'rows', but an ESRI ASCII grid has only"),
        (
            ascii_text().replace("0.02 ", "0,02 "),
            "height 11 must be a number, got '0,02'; numbers have a point",
        ),
        (b"\x00\xff" * 20, "it must be a text"),
        (ascii_text(z=np.full((5, 4), -9999.0)), "all of its heights are missing"),
        (ascii_text(z=GRID + 3.5e5), r"its heights must be within 12000 m of sea level, got 35000.*'mm'"),
    ],
)
def test_what_an_ascii_grid_does_not_say_is_named(asc, content, message):
    with pytest.raises(ParameterError, match=f"^file: .*a.asc cannot be used: {message}") as refusal:
        asc(content)
    assert len(refusal.value.errors) == 1


@pytest.mark.parametrize("value", [-32768.0, -3.4028235e38, 1e20, -99999.0])
def test_missing_heights_that_a_file_does_not_declare_are_named(asc, value):
    z = GRID.copy()
    z[1, 2] = value
    with pytest.raises(ParameterError, match=r"1 heights of .* look like missing ones \(no-data\) that"):
        asc(ascii_text(z=z))
    middles = np.meshgrid(X[:-1] + 0.25, Y[:-1] + 0.25, indexing="ij")
    # a declared value may be rounded
    for declared in (value, value * (1.0 - 1e-7)):
        grid = asc(ascii_text({"NODATA_value": declared}, z))
        missing = np.isnan(grid.sample(*middles)[..., 0])
        assert np.argwhere(missing).tolist() == [[0, 1], [0, 2], [1, 1], [1, 2]]


def test_missing_heights_leave_the_others_as_they_are(asc, tmp_path):
    x, y = np.arange(40.0), np.arange(30.0)
    z = 0.3 * np.sin(0.2 * x)[:, None] * np.cos(0.3 * y)
    np.save(tmp_path / "whole.npy", z)
    z[30:35, 20:] = np.nan
    np.save(tmp_path / "holed.npy", z)
    whole, holed = (MeasuredGrid(file=tmp_path / f"{name}.npy", spacing=1.0) for name in ("whole", "holed"))
    far = np.meshgrid(np.linspace(0.0, 22.0, 50), np.linspace(0.0, 29.0, 50))
    assert_allclose(holed.sample(*far), whole.sample(*far), atol=1e-4)
    beside = np.array([29.5, 30.5, 34.5, 35.5])
    assert np.isnan(holed.sample(beside, np.full(4, 25.0))[:, 0]).tolist() == [True, True, True, False]
    square = np.array([[[1.0, 1.0], [28.0, 1.0], [28.0, 28.0], [1.0, 28.0]]])
    bounds = ((0.0, 39.0), (0.0, 29.0))
    assert holed.misfit(square, bounds) == ""
    assert "they are missing about x = 29.15 m, y = 19.16 m" in holed.misfit(
        square + np.array([9.0, 0.0]), bounds
    )


def test_a_netcdf_file_has_its_own_units(netcdf):
    plain = heights(netcdf())
    assert_allclose(plain, GRID, atol=1e-14)
    for unit, size in (("mm", 1e-3), ("cm", 0.01), ("km", 1e3), ("meters", 1.0), ("ft", 0.3048)):
        assert_allclose(heights(netcdf(z=GRID / size, attributes={"z": {"units": unit}})), GRID, atol=1e-14)
    kilometres = {"x": X / 1e3, "y": Y / 1e3}
    units = {axis: {"units": "km"} for axis in "xy"}
    assert_allclose(heights(netcdf(places=kilometres, attributes=units)), GRID, atol=1e-11)
    assert_allclose(heights(netcdf(places=kilometres, place_unit="km")), GRID, atol=1e-11)
    assert_allclose(heights(netcdf(attributes={"z": {"units": "mm"}}, height_unit="m")), GRID, atol=1e-14)
    with pytest.raises(ParameterError, match="'gpm' must be a unit of length of its heights, such as m, mm"):
        netcdf(attributes={"z": {"units": "gpm"}})


def test_a_netcdf_file_may_have_a_band_and_any_order(netcdf):
    turned = {"band": [1], "y": Y[::-1], "x": X}
    assert_allclose(heights(netcdf(("band", "y", "x"), GRID.T[None, ::-1], turned)), GRID, atol=1e-14)
    named = {"easting": X, "northing": Y}
    assert_allclose(heights(netcdf(("easting", "northing"), places=named)), GRID, atol=1e-14)


def test_depths_are_no_heights(netcdf):
    with pytest.raises(
        ParameterError, match="it has depths, positive downward, but heights are needed: change their sign"
    ):
        netcdf(attributes={"z": {"positive": "down"}})


def test_a_file_that_is_no_netcdf_is_refused_in_words_of_the_project(tmp_path):
    (tmp_path / "a.nc").write_text(ascii_text())
    with pytest.raises(ParameterError, match=r"a\.nc cannot be used: it must be a readable NetCDF file$"):
        MeasuredGrid(file=tmp_path / "a.nc")


def test_a_head_has_a_corner_or_a_centre(asc):
    with pytest.raises(ParameterError, match="must have xllcorner or xllcenter, got both"):
        asc("xllcenter 0\nxllcorner 0\n" + ascii_text())


@pytest.mark.parametrize("kind", ["float16", ">f4", "int16", "uint8", "longdouble"])
def test_numbers_of_an_array_may_have_any_kind(tmp_path, kind):
    z = np.arange(40)[:, None] % 3 * np.ones(40)
    np.save(tmp_path / "a.npy", z.astype(kind))
    grid = MeasuredGrid(file=tmp_path / "a.npy", spacing=10.0, smoothing=10.0)
    np.save(tmp_path / "b.npy", z)
    expected = MeasuredGrid(file=tmp_path / "b.npy", spacing=10.0, smoothing=10.0)
    assert_allclose(heights(grid), heights(expected), atol=1e-12)


def test_rounded_places_are_even_within_their_rounding(tmp_path):
    """Float32 has northings to half a metre."""
    x, y = (first + 0.5 * np.arange(40) for first in (415630.25, 5759380.25))
    z = 0.1 * np.sin(0.3 * np.arange(40))[:, None] * np.ones(40)
    data = xarray.Dataset({"z": (("x", "y"), z)}, {"x": x.astype(np.float32), "y": y.astype(np.float32)})
    data.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    grid = MeasuredGrid(file=tmp_path / "a.nc", smoothing=0.0)
    assert grid.sides == pytest.approx((0.5, 0.5), rel=5e-3)
    middle = grid.sample(x[20:21], y[20:21])[0, 0]
    assert middle == pytest.approx(z[20, 0], abs=1e-3)


def test_places_that_a_netcdf_file_lacks_are_asked_for(netcdf):
    with pytest.raises(ParameterError, match="it has no positions along x: give their spacing"):
        netcdf(places={})
    assert_allclose(heights(netcdf(places={}, spacing=0.5, origin=(10.25, 20.25))), GRID, atol=1e-14)
    with pytest.raises(ParameterError, match="spacing must be left out: the file has positions"):
        netcdf(spacing=0.5)


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"places": {"x": np.zeros(5), "y": Y}}, r"its positions along x must differ, got 0 to 0 m"),
        ({"places": {"x": X**2, "y": Y}}, r"its steps along x must be even, got 10\.5 to 12"),
        (
            {"dimensions": ("lon", "lat"), "places": {"lon": X, "lat": Y}},
            r"its positions are in degrees \(lon\)",
        ),
        ({"attributes": {"x": {"units": "degrees_east"}}}, r"its positions are in degrees \(x\)"),
        (
            {"dimensions": ("a", "b"), "places": {}},
            "it must have one variable over x and y, got z over a and b",
        ),
        ({"z": GRID > 0.0}, "it must have one variable over x and y, got z over x and y"),
    ],
)
def test_places_of_a_netcdf_file_that_cannot_be_used_are_named(netcdf, how, message):
    with pytest.raises(ParameterError, match=f"cannot be used: {message}"):
        netcdf(**how)


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (GRID > 0.0, "its array must consist of numbers, got bool"),
        (np.zeros((5, 4), dtype=[("z", float)]), r"its array must consist of numbers, got \[\('z'"),
        (GRID.astype(complex), "its array must consist of numbers, got complex128"),
        (np.zeros(20), "its array must have 2 axes, got 1"),
    ],
)
def test_arrays_that_are_no_heights_are_refused(tmp_path, array, message):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(ParameterError, match=message):
        MeasuredGrid(file=tmp_path / "a.npy", spacing=0.5)


class Running:
    """Object whose pickle runs code as it is read."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


def test_no_code_in_a_file_is_run(tmp_path):
    array = np.empty((2, 2), dtype=object)
    array[:] = Running(tmp_path / "ran")
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    np.load(tmp_path / "a.npy", allow_pickle=True)
    assert (tmp_path / "ran").exists()
    (tmp_path / "ran").unlink()
    with pytest.raises(ParameterError, match=r"a\.npy cannot be used: "):
        MeasuredGrid(file=tmp_path / "a.npy", spacing=0.5)
    assert not (tmp_path / "ran").exists()


def test_a_file_that_is_no_array_takes_no_memory(tmp_path):
    np.savez(tmp_path / "z.npz", z=GRID)
    shutil.move(tmp_path / "z.npz", tmp_path / "z.npy")
    head = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000, 1000000), }"
    words = head.ljust(117) + "\n"
    (tmp_path / "bomb.npy").write_bytes(b"\x93NUMPY\x01\x00v\x00" + words.encode())
    for name, message in (("z", "it must be an NPY file"), ("bomb", "its head does not match its content")):
        with pytest.raises(ParameterError, match=message):
            MeasuredGrid(file=tmp_path / f"{name}.npy", spacing=0.5)


def test_heights_in_another_unit_are_too_steep_and_named(asc):
    assert_allclose(heights(asc(ascii_text(z=1e3 * GRID), height_unit="mm")), GRID, atol=1e-14)
    with pytest.raises(ParameterError, match=r"more than 1 m a metre.*are they in mm\? height_unit = 'mm'"):
        asc(ascii_text(z=1300.0 * GRID))


@pytest.fixture(scope="module")
def gentle(tmp_path_factory):
    """Array of 60 x 40 heights, 0.5 m apart."""
    path = tmp_path_factory.mktemp("maps") / "gentle.npy"
    np.save(path, 0.1 * np.sin(0.1 * np.arange(60))[:, None] * np.cos(0.1 * np.arange(40)))
    return path


def on_map(path, **how):
    """Rolled track on a map of a file, or in a NPY file with a spacing of 0.5 m."""
    how = {"spacing": 0.5} | how
    return Case.rolled().on_cells(BekkerSoil.lete_sand(), Heights(measured=MeasuredGrid(file=path, **how)))


NEEDED = (
    r"^terrain\.relief\.measured: gentle\.npy must have heights wherever the track comes, "
    r"x = 9\.7141\.\.25\.6262 m, y = 7\.4376\.\.11\.1426 m"
)


@pytest.mark.parametrize(
    ("how", "message"),
    [
        (
            {"origin": (415630.0, 5759380.0)},
            r", and has them at x = 415630\.\.415660 m, y = 5759380\.\.5759400 m; "
            r"origin = \[\S+, \S+\] would bring it there$",
        ),
        ({"origin": (-10.0, 0.0)}, r"x = -10\.\.19\.5 m, y = 0\.\.19\.5 m; origin = \["),
        ({"spacing": 0.05}, r"it is 2\.95 x 1\.95 m large, too small wherever it lies$"),
    ],
)
def test_a_map_that_does_not_lie_below_the_track_is_refused_with_the_shift(gentle, how, message):
    with pytest.raises(ParameterError, match=NEEDED + ".*" + message):
        on_map(gentle, smoothing=0.5, **how)


def test_the_shift_that_a_refusal_names_fits(gentle):
    with pytest.raises(ParameterError) as refusal:
        on_map(gentle, origin=(415630.0, 5759380.0))
    words = str(refusal.value).split("origin = [")[1].split("]")[0]
    shift = tuple(float(word) for word in words.split(","))
    terrain = on_map(gentle, origin=shift).terrain
    assert np.isfinite(terrain.surface(np.array([9.8, 25.6]), np.array([7.5, 11.1]))).all()


def test_places_in_degrees_or_kilometres_are_named(tmp_path):
    small = {"ncols": 60, "nrows": 40, "cellsize": 0.000277777778}
    cases = (
        (
            {"xllcorner": 55.87, "yllcorner": 54.65},
            r"its places from 55\.8701, 54\.6501 look like degrees: heights are needed over places in m",
        ),
        (
            {"xllcorner": 0.0, "yllcorner": 0.0, "cellsize": 0.0005},
            r"are its places in km or mi\? With place_unit = 'km' it is 29\.5 x 19\.5 m large; "
            r"with place_unit = 'mi' it is 47\.48 x 31\.38 m large",
        ),
    )
    for head, words in cases:
        (tmp_path / "a.asc").write_text(ascii_text(small | head, np.zeros((60, 40))))
        with pytest.raises(ParameterError, match=words):
            on_map(tmp_path / "a.asc", spacing=None)


def test_the_whole_drive_needs_heights(gentle):
    case = Case.translation().on_cells(
        BekkerSoil.lete_sand(),
        Heights(measured=MeasuredGrid(file=gentle, spacing=0.5, origin=(-11.0, 0.0))),
    )
    case.check_support(1.0)
    with pytest.raises(ValueError, match=r"relief\.measured: gentle\.npy must have heights .*; origin = \["):
        case.check_support(30.0)


def test_units_name_the_shift_too(gentle):
    with pytest.raises(
        ParameterError, match=r"relief must have heights over the whole terrain: gentle\.npy .*; origin"
    ):
        Terrain.stress().with_(
            relief=Heights(measured=MeasuredGrid(file=gentle, spacing=0.5, origin=(100.0, 0.0)))
        )


def test_a_map_with_few_heights_below_the_track_warns(gentle):
    case = on_map(gentle, spacing=30.0)
    with pytest.warns(ImplausibleWarning, match=r"heights of gentle\.npy are 30 m apart, a shoe is 3\.5"):
        warn_implausible(case)


@pytest.mark.simulation
@pytest.mark.parametrize("seed", [0, 4])
def test_a_dragged_track_rests_on_a_map_as_on_the_waves_in_it(tmp_path, seed):
    """Places that the search for rest tries off the map are no end of it: from these two it left the map."""
    random = np.random.default_rng(seed)
    parts = []
    for number in range(4):
        length, heading, height, x = (
            random.uniform(*span) for span in ((6, 15), (0, 360), (0.02, 0.08), (0, 10))
        )
        wave = {"model": "waves", "name": f"{number}", "x": x, "heading": heading, "height": height}
        parts.append(wave | {"length": length})
    waves = Heights(parts=parts)
    x, y = np.arange(4.25, 25.0, 0.5), np.arange(0.25, 20.0, 0.5)
    np.save(tmp_path / "map.npy", waves.sample(*np.meshgrid(x, y, indexing="ij"))[..., 0])
    grid = MeasuredGrid(file=tmp_path / "map.npy", spacing=0.5, origin=(x[0], y[0]))
    starts = []
    for relief in (Heights(measured=grid), waves):
        case = Case.translation().on_cells(BekkerSoil.lete_sand(), relief)
        starts.append(simulate(case, 0.002, progress=False).position.isel(time=0))
    assert_allclose(starts[0], starts[1], atol=2e-4)


@pytest.mark.simulation
@pytest.mark.parametrize("formulation", ["compiled", pytest.param("engine", marks=pytest.mark.slow)])
def test_a_shoe_that_leaves_a_map_ends_the_run_with_its_place(tmp_path, monkeypatch, formulation):
    monkeypatch.setattr(MeasuredGrid, "misfit", lambda *_: "")
    np.save(tmp_path / "flat.npy", np.zeros((40, 20)))
    front = Case.translation().outline(0.0)[2]
    origin = (front[0] + 0.12 - 19.5, front[1] - 5.0)
    relief = Heights(measured=MeasuredGrid(file=tmp_path / "flat.npy", spacing=0.5, origin=origin))
    drive = Drive(speed=StepProfile(times=(0.0, 0.1), values=(0.0, 1.0)))
    case = (
        Case.translation()
        .on_cells(RockFloor.hard_floor(), relief)
        .with_(drive=drive, formulation=formulation)
    )
    reach = r"a shoe left the measured ground: the track is at x = 10\.2 to 18\.07 m"
    with pytest.raises(SimulationStopped, match=reach) as stop:
        simulate(case, 0.5, progress=False)
    assert stop.value.time == pytest.approx(0.123, abs=2e-3)


@pytest.mark.filterwarnings("error")
def test_broken_netcdf_is_refused_and_leaves_nothing_to_be_said_later(netcdf, tmp_path):
    """The reader of NetCDF would leave the file half open, and say so when its memory is freed."""
    netcdf()
    content = (tmp_path / "a.nc").read_bytes()
    for place in (len(content) // 2, len(content) // 3):
        (tmp_path / "b.nc").write_bytes(content[:place] + b"[" * 500 + content[place:])
        with pytest.raises(ParameterError, match=r"b\.nc cannot be used: it is broken: "):
            MeasuredGrid(file=tmp_path / "b.nc")
        gc.collect()


def test_netcdf_without_heights_is_refused(netcdf):
    with pytest.raises(ParameterError, match=r"cannot be used: it has no heights: 0 x \d+ of them"):
        netcdf(z=GRID[:0], places={"x": X[:0], "y": Y})
