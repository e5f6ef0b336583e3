"""A scheduler and a worker in this process: a cluster of processes takes seconds to start."""

from collections.abc import Iterator

import pytest
from distributed import LocalCluster

from exudyn_crawler.sweep import page


@pytest.fixture(scope="session")
def scheduler() -> Iterator[str]:
    """Address of a scheduler."""
    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0") as cluster:
        yield cluster.scheduler_address


@pytest.fixture
def without_reports(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write no reports of single runs, which take longer than the runs."""
    monkeypatch.setattr(page, "_report_of", lambda *_: None)
