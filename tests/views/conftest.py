"""Folders as studies leave them, for the tests of the report."""

import json

import numpy as np
import pytest

from exudyn_crawler.results.stress.hot_spots import hot_spot_table
from exudyn_crawler.views.pages.report import write_report
from exudyn_crawler.views.scenes.shoes import write_stress_pictures
from exudyn_crawler.views.tables import write_table
from studies.comparison import comparison_table, reported_values
from studies.forces import study as forces_study
from studies.kinematics import study as kinematics_study
from tests.stress_results import by_modes_alone, stress_results
from tests.views.browser import CHROMIUM


@pytest.fixture(scope="session")
def stress_folder(flexible_run, tmp_path_factory):
    """Folder as the stress study leaves it, of a short run."""
    history, stress, hot_spots = flexible_run
    folder = tmp_path_factory.mktemp("stress")
    history.save(folder / "history.nc")
    stress.to_netcdf(folder / "stress.nc", engine="h5netcdf")
    for shoe, table in hot_spots.items():
        write_table(hot_spot_table(table, stress), folder / f"hot_spots_shoe_{shoe}.csv")
    reported = reported_values("stress")
    # within, without verdict and outside; the rest was not computed
    computed = [value * (1.0 if row % 3 else 10.0) for row, value in enumerate(reported["value"])]
    write_table(comparison_table(reported, [*computed[:-1], np.nan]), folder / "comparison.csv")
    assert write_stress_pictures(stress, history, folder) == sorted(folder.glob("*.png"))
    record = {"wall time": "<1 s", "status": "done", "finished": "2026-03-01T10:20:30+00:00"}
    (folder / "run.json").write_text(json.dumps(record | {"wall_time_s": 81.4}))
    return folder


@pytest.fixture(scope="session")
def stress_report(stress_folder, tmp_path_factory):
    return write_report(stress_folder, tmp_path_factory.mktemp("page") / "report.html")


@pytest.fixture(scope="session")
def rigid_folders(tmp_path_factory):
    """What short runs of the two rigid studies leave."""
    kinematics, forces = (tmp_path_factory.mktemp(name) for name in ("kinematics", "forces"))
    kinematics_study(kinematics, duration=0.02)
    forces_study(forces, duration=0.02, reuse=kinematics)
    return kinematics, forces


@pytest.fixture(scope="package")
def browser():
    """Browser whose loop runs in this thread, where it would disturb tests of other rooms."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with sync_api.sync_playwright() as driver:
        # containers without user namespaces have no sandbox; 3D is drawn in software
        started = driver.chromium.launch(
            executable_path=CHROMIUM,
            args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        )
        yield started
        started.close()


@pytest.fixture(scope="session")
def bent_stress(bent):
    """Stresses of flexible shoes under rollers, by the modes alone, which take a second."""
    return stress_results(by_modes_alone(bent), [0.0, 0.06])[0]
