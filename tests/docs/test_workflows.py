"""Workflow files run commands that there are, on the systems and with the versions that the project names."""

import importlib.util
import itertools
import os
import re
import shlex
import subprocess
import sys

import pytest
import typer
import yaml

from docs.rooms import ROOT
from exudyn_crawler import cli
from tests.test_release import PROJECT

FOLDER = ROOT / ".github"
WORKFLOWS = sorted((FOLDER / "workflows").glob("*.yml"))
FORMS = sorted((FOLDER / "ISSUE_TEMPLATE").glob("*.yml"))
FETCHED = {"build"}
"""Modules that a step installs before it calls them."""
SYSTEMS = ["ubuntu-latest", "windows-latest", "macos-latest"]


def content(path):
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def jobs():
    return [(path.stem, name, job) for path in WORKFLOWS for name, job in content(path)["jobs"].items()]


def lines_of(job):
    """Lines that a job runs, one for each choice of the values of its matrix that they name."""
    matrix = job.get("strategy", {}).get("matrix", {})
    for choice in itertools.product(*matrix.values()):
        for step in job["steps"]:
            for line in step.get("run", "").splitlines():
                for name, value in zip(matrix, choice, strict=True):
                    line = line.replace(f"${{{{ matrix.{name} }}}}", value)
                yield line


LINES = sorted({line for _, _, job in jobs() for line in lines_of(job)})


def fault(line):
    """Return what is wrong with a command; empty for one that there is."""
    program, *words = shlex.split(line)
    if program == "make":
        known = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
        return ", ".join(set(words) - known)
    if program == "python":
        assert words[0] == "-m"
        return "" if words[1] in FETCHED or importlib.util.find_spec(words[1]) else words[1]
    if program == "exudyn-crawler":
        known = typer.main.get_command(cli.app)
        if words != ["--version"]:
            command = known.get_command(typer.Context(known), words[0])
            return "" if command and command.make_context(words[0], words[1:]) else words[0]
        return ""
    if program == "grep":
        return "" if (ROOT / words[-1]).is_file() else words[-1]
    return "" if os.access(ROOT / program, os.X_OK) else program


@pytest.mark.parametrize("line", LINES)
def test_commands_of_workflows_exist(line):
    assert not fault(line)


@pytest.mark.parametrize(
    "line", ["make nothing", "python -m nothing", "exudyn-crawler nothing", ".ci/nothing"]
)
def test_commands_that_are_not_there_are_found(line):
    assert fault(line)


def test_files_that_jobs_name_exist_and_every_job_ends():
    for where, name, job in jobs():
        assert job["timeout-minutes"] > 0, (where, name)
        for step in job["steps"]:
            if path := step.get("with", {}).get("cache-dependency-path"):
                assert (ROOT / path).is_file()


def test_tests_and_wheel_run_on_three_systems_and_with_the_lowest_python():
    here = content(FOLDER / "workflows" / "test.yml")["jobs"]
    for name in ("tests", "wheel"):
        assert here[name]["strategy"]["matrix"]["os"] == SYSTEMS
    lowest = PROJECT["requires-python"].removeprefix(">=")
    named = [line.rpartition(" ")[2] for line in PROJECT["classifiers"] if line.startswith("Programming")]
    assert here["tests"]["strategy"]["matrix"]["python"] == [
        lowest,
        max(named, key=lambda word: word.split(".")),
    ]


def test_only_the_job_that_publishes_may_and_only_for_a_tag():
    publish = content(FOLDER / "workflows" / "publish.yml")
    # YAML 1.1 reads "on" as true
    assert publish[True] == {"push": {"tags": ["v*"]}}
    assert publish["permissions"] == {}
    rights = {name: job["permissions"] for name, job in publish["jobs"].items()}
    assert rights == {"build": {"contents": "read"}, "publish": {"id-token": "write"}}
    assert content(FOLDER / "workflows" / "test.yml")["permissions"] == {"contents": "read"}


@pytest.mark.skipif(sys.platform == "win32", reason="the step runs on Linux")
@pytest.mark.parametrize(("tag", "fits"), [("v" + PROJECT["version"], True), ("v99.0.0", False)])
def test_a_tag_of_another_version_is_not_published(tag, fits):
    steps = content(FOLDER / "workflows" / "publish.yml")["jobs"]["build"]["steps"]
    line = next(step["run"] for step in steps if "tag" in step.get("name", ""))
    done = subprocess.run(
        ["bash", "-c", line], cwd=ROOT, env={**os.environ, "GITHUB_REF_NAME": tag}, check=False
    )
    assert (done.returncode == 0) is fits


def test_forms_for_issues_ask_for_the_version():
    asked = [form for form in map(content, FORMS) if "body" in form]
    assert len(asked) == 2
    for form in asked:
        texts = [part["attributes"].get("description", "") for part in form["body"]]
        assert any("exudyn-crawler --version" in text for text in texts)
