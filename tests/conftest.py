"""Short runs of the papers' cases, shared by the tests: a run costs more than what is asked of it."""

import pytest

from exudyn_crawler import Case, CrawlerModel, History


@pytest.fixture(scope="session")
def translation() -> History:
    return CrawlerModel(Case.translation()).simulate(0.4)


@pytest.fixture(scope="session")
def turning() -> History:
    return CrawlerModel(Case.turning()).simulate(0.4)


@pytest.fixture(scope="session")
def constrained() -> History:
    return CrawlerModel(Case.translation().with_(terrain_formulation="constrained")).simulate(0.1)


@pytest.fixture(scope="session")
def longer() -> History:
    """Long enough to slip, stick and bounce."""
    return CrawlerModel(Case.translation()).simulate(3.0)
