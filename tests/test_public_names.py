"""What the package offers: all of it there, and shown in notebooks and completion."""

import importlib
import inspect
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import exudyn_crawler
import fem
import meshes
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.results.life.life import LifeResults
from exudyn_crawler.results.stress.recovery import StressResults

USERS = Path(__file__).with_name("user_script.py")


@pytest.mark.parametrize("name", exudyn_crawler.__all__)
def test_every_public_name_is_there_and_told(name):
    assert inspect.getdoc(getattr(exudyn_crawler, name))


def test_names_are_in_order_no_module_hides_one_and_others_are_refused():
    assert exudyn_crawler.__all__ == sorted(exudyn_crawler.__all__)
    with pytest.raises(AttributeError, match="No exudyn_crawler attribute gravity"):
        _ = exudyn_crawler.gravity
    for name in exudyn_crawler.__all__:
        public = getattr(exudyn_crawler, name)
        importlib.import_module(public.__module__)
        assert getattr(exudyn_crawler, name) is public
        assert not inspect.ismodule(public)


@pytest.mark.parametrize("package", [fem, meshes], ids=lambda package: package.__name__)
def test_names_of_finite_elements_and_meshes_are_there_and_in_completion(package):
    assert dir(package) == package.__all__ == sorted(package.__all__)
    modules = {name for name in package.__all__ if inspect.ismodule(getattr(package, name))}
    assert modules == ({"trust"} if package is fem else set())
    with pytest.raises(AttributeError, match="attribute gravity"):
        _ = package.gravity


@pytest.mark.parametrize("package", [exudyn_crawler, fem, meshes], ids=lambda package: package.__name__)
def test_type_checkers_find_the_types_of_a_package_and_its_stub_names_what_all_does(package):
    init = Path(package.__file__)
    assert init.with_name("py.typed").is_file()
    stub = init.with_suffix(".pyi").read_text(encoding="utf-8")
    assert sorted(re.findall(r"(?m)^from \S+ import (\w+) as \1$", stub)) == package.__all__


def checked_by_mypy(folder, *scripts):
    """What mypy says of scripts in a folder that knows the packages only as installed ones."""
    place = str(Path(exudyn_crawler.__file__).parents[1])
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", "", "--cache-dir", "cache"]
    return subprocess.run(
        [*command, *scripts],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": place},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.simulation
def test_a_users_script_is_right_in_types_and_a_wrong_one_is_told(tmp_path):
    text = USERS.read_text(encoding="utf-8")
    wrong = text.replace(
        "simulate(Case.translation(), duration=0.01)", 'simulate("translation", duration=[])'
    )
    assert wrong != text
    for name, content in {"mine.py": text, "wrong.py": wrong}.items():
        (tmp_path / name).write_text(content, encoding="utf-8")
    done = checked_by_mypy(tmp_path, "mine.py", "wrong.py")
    errors = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert [line.split(":")[0] for line in errors] == ["wrong.py"] * 2, done.stdout + done.stderr
    assert all("[arg-type]" in line for line in errors)


@pytest.mark.parametrize("name", ["exudyn_crawler", "fem", "meshes"])
def test_importing_a_package_imports_nothing_that_takes_time(name):
    script = f"import sys, {name}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not {"numpy", "scipy", "numba", "exudyn", "xarray"} & set(done.stdout.split())


def test_completion_shows_the_public_names_and_no_helpers():
    shown = set(dir(exudyn_crawler))
    assert set(exudyn_crawler.__all__) <= shown
    assert not {"import_module", "Any", "find_spec"} & shown


@pytest.mark.parametrize("name", ["fem", "meshes", "studies"])
def test_a_stranger_of_a_neighbours_name_is_refused_by_its_place(tmp_path, name):
    (tmp_path / name).mkdir()
    (tmp_path / name / "__init__.py").touch()
    script = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import exudyn_crawler"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"ImportError: the package {name!r} must be that in ")
    assert f"got {tmp_path / name}" in last


def test_objects_of_a_notebook_show_themselves(flexible_run):
    history, stress, hot_spots = flexible_run
    results = StressResults(stress, hot_spots, {}, whole=None)
    run = CaseRun(history, results, folder=None)
    life = LifeResults(None, stress, hot_spots[7], nodes={}, runs=(), regions=None)
    for one, words in (
        (history.case, ["terrain.spring_stiffness", "N/m", "stiffness of each spring"]),
        (history, ["&#x27;stress&#x27; over 0.06 s", "joint_force"]),
        (results, ["Shoe 13", "highest_von_mises"]),
        (life, ["verdict", "peak_von_mises"]),
        (run, ["kept nowhere", "Shoe 7", "joint_force"]),
    ):
        html = one._repr_html_()
        assert [word for word in words if word not in html] == []
    # and names cannot be markup
    assert "<b>" not in exudyn_crawler.Case.translation().with_(name="<b>loud</b>")._repr_html_()


def test_completion_shows_the_variables_of_a_history(translation):
    assert {"position", "case", "save", "duration"} <= set(dir(translation))
