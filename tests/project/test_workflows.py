"""A workflow installs what the tests that it runs import."""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
TESTS = PROJECT / "tests"
WORKFLOWS = sorted((PROJECT / ".github" / "workflows").glob("*.yml"))
# Packages whose modules are called otherwise.
MODULES = {"pynrrd": "nrrd", "vtk": "vtkmodules", "pytest-xdist": "xdist"}


def jobs(text):
    """The commands of each job of a workflow."""
    parts = re.split(r"^  (\w+):\n", text.partition("\njobs:\n")[2], flags=re.MULTILINE)
    return {
        name: re.findall(r"^ +- run: (.*)$", body, re.MULTILINE)
        for name, body in zip(parts[1::2], parts[2::2])
    }


def folders_run(commands):
    """The folders whose tests a job runs by pytest itself, not by make."""
    lines = [line for line in commands if "-m pytest " in line]
    return [word for line in lines for word in line.split() if word.startswith("tests/")]


def name_of(requirement):
    return re.match(r"[\w-]+", requirement)[0]


def installed(commands, project):
    """The modules that a job installs by pip."""
    extras = project["optional-dependencies"]
    words = [word for line in commands if "pip install" in line for word in line.split()]
    wanted = [word.strip('"') for word in words[words.index("install") + 1 :]]
    names = {name_of(word) for word in wanted if re.match(r"\w", word)}
    for extra in re.findall(r"whl\)\[([\w,]+)\]", " ".join(wanted)):
        needed = [
            *project["dependencies"],
            *(each for one in extra.split(",") for each in extras[one]),
        ]
        names |= {name_of(each) for each in needed} | {"vtk_mls"}
    return {MODULES.get(name, name) for name in names}


def imported(path):
    """The modules that a file imports as it is loaded."""
    names = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module.partition(".")[0])
    return names - set(sys.stdlib_module_names)


def needed(folder):
    """The packages that the tests of a folder import, by way of what lies beside them, too."""
    todo, packages = {TESTS / "conftest.py", *folder.glob("*.py")}, set()
    done = set()
    while todo:
        path = todo.pop()
        done.add(path)
        for name in imported(path):
            own = [place / f"{name}.py" for place in (folder, TESTS)]
            own = [each for each in own if each.is_file()]
            todo |= set(own[:1]) - done
            packages |= set() if own else {name}
    return packages


RUN = [
    pytest.param(commands, folder, id=f"{path.stem}-{job}-{folder}")
    for path in WORKFLOWS
    for job, commands in jobs(path.read_text(encoding="utf-8")).items()
    for folder in folders_run(commands)
]


def project():
    tomllib = pytest.importorskip("tomllib", reason="Python 3.11 or later reads pyproject.toml")
    return tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.mark.parametrize(("commands", "folder"), RUN)
def test_what_tests_import_is_installed(commands, folder):
    assert needed(PROJECT / folder) <= installed(commands, project())


def test_a_package_that_is_not_installed_is_found():
    commands = ['python -m pip install "$(ls dist/*.whl)[vtk]" pytest']
    missing = needed(TESTS / "files") - installed(commands, project())
    assert missing == {"SimpleITK", "meshio", "nibabel", "nrrd"}
    assert {path.stem for path in WORKFLOWS} >= {"check", "release", "test"}
    assert any("release-install" in each.id for each in RUN)
