"""A release says the same of itself everywhere, and what a newcomer runs first is fast."""

import importlib
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from exudyn_crawler import __main__

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NOT_ON_CONDA_FORGE = {"exudyn", "netgen-mesher", "pylife"}
DEMO = [sys.executable, "-m", "exudyn_crawler", "demo"]


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


def test_the_installed_command_is_this_one():
    module, _, name = PROJECT["scripts"]["exudyn-crawler"].partition(":")
    assert getattr(importlib.import_module(module), name) is __main__.main


def processor_time():
    """Of the processes that were called and have ended, in s."""
    return sum(os.times()[2:4])


@pytest.mark.slow
def test_the_demo_makes_its_page_within_20_s_and_compiles_nothing_that_the_installation_did(tmp_path):
    subprocess.run([*DEMO, "--prepare"], cwd=tmp_path, check=True)
    assert not list(tmp_path.iterdir())
    before = processor_time()
    done = subprocess.run(DEMO, cwd=tmp_path, check=True, capture_output=True, text=True)
    assert processor_time() - before < 20.0
    assert "compile the equations" not in done.stderr
    assert "peak stress" in done.stdout
    assert "exudyn-crawler init" in done.stdout.splitlines()[-1]
    page = (tmp_path / "results/demo/report.html").read_text(encoding="utf-8")
    assert "Track in motion" in page
    assert "Flexible shoes in 3D" in page
