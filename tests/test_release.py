"""What a release says of itself is said alike everywhere."""

import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NOT_ON_CONDA_FORGE = {"exudyn", "pylife"}


def read(name):
    return (ROOT / name).read_text(encoding="utf-8")


def dependencies():
    """Dependencies of the package without spaces and markers, by name."""
    names = [line.split(";")[0].replace(" ", "") for line in PROJECT["dependencies"]]
    return {re.split("[<>=]", name)[0]: name for name in names}


def test_version_is_the_same_in_project_changelog_citation_and_recipe():
    version = PROJECT["version"]
    assert re.search(r"(?m)^## (.*)$", read("CHANGELOG.md"))[1] == version
    assert yaml.safe_load(read("CITATION.cff"))["version"] == version
    assert yaml.safe_load(read("recipe/recipe.yaml"))["context"]["version"] == version


def test_recipe_and_environment_need_what_the_package_needs():
    needed = dependencies()
    run = yaml.safe_load(read("recipe/recipe.yaml"))["requirements"]["run"]
    by_conda = {text for name, text in needed.items() if name not in NOT_ON_CONDA_FORGE}
    assert {one.replace(" ", "") for one in run[1:]} == by_conda
    *listed, by_pip = yaml.safe_load(read("recipe/environment.yml"))["dependencies"]
    assert {one.replace(" ", "") for one in listed[2:]} == by_conda
    assert set(by_pip["pip"]) == {needed[name] for name in NOT_ON_CONDA_FORGE}
