"""A release: the packages it asks for, the pictures it shows, the addresses in README."""

from __future__ import annotations

import ast
import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
TEXT = (PROJECT / "docs" / "releasing.md").read_text(encoding="utf-8")
# Extras for those who change the project.
OURS = {"test", "docs", "bench"}


def extras():
    """The packages of each extra that users ask for, with those of the extras that it takes in."""
    tomllib = pytest.importorskip("tomllib", reason="Python 3.11 or later reads pyproject.toml")
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    table = project["optional-dependencies"]

    def packages(extra):
        found = set()
        for requirement in table[extra]:
            name, inner = re.match(r"([\w-]+)(?:\[([\w,]+)\])?", requirement).groups()
            inner = inner.split(",") if name == "vtk-mls" else ()
            found |= set().union(*map(packages, inner)) if inner else {name}
        return found

    users = {extra: packages(extra) for extra in table if extra not in OURS}
    return {"always": set(project["dependencies"])} | users


def told():
    """The packages of the list in releasing.md, by what asks for them."""
    found = {}
    section = TEXT.partition("## What is bundled")[2].partition("\n## ")[0]
    for names, askers in re.findall(r"^\| ([\w, -]+) \| ([^|]+) \|", section, re.MULTILINE):
        for asker in re.findall(r"`(\w+)`|(always)", askers):
            found.setdefault("".join(asker), set()).update(names.split(", "))
    return found


def test_the_list_of_packages_is_that_of_the_extras():
    assert told() == extras()


def test_what_is_imported_is_in_the_list():
    """Packages that modules of the package import somewhere."""
    known = {"vtkmodules": "vtk", "paraview": None, "aiohttp": "trame", "trame_client": "trame"}
    used = set()
    for path in (PROJECT / "vtk_mls").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            used |= {name.partition(".")[0] for name in names if name}
    used -= {*sys.stdlib_module_names, "vtk_mls"}
    section = TEXT.partition("## What is bundled")[2].partition("\n## ")[0]
    missing = {known.get(name, name) for name in used} - {None}
    assert not {name for name in missing if not re.search(rf"\b{name}\b", section)}


def test_each_picture_of_the_site_has_a_line():
    pictures = {
        path.name for path in (PROJECT / "docs").glob("*") if path.suffix in (".png", ".gif")
    }
    assert not {name for name in pictures if f"`{name}`" not in TEXT}


@pytest.fixture
def released(tmp_path):
    """A copy with what the package index is told, after the workflow's step."""
    for folder in (".ci", "opencl", "paraview_plugin", "vtk_mls"):
        shutil.copytree(
            PROJECT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__")
        )
    for name in ("README.md", "pyproject.toml", "LICENSE"):
        shutil.copy(PROJECT / name, tmp_path)
    command = [sys.executable, ".ci/addresses", "someone/vtk_mls", "v9.9"]
    subprocess.run(command, cwd=tmp_path, check=True)
    return tmp_path


def test_links_and_pictures_of_the_release_are_addresses(released):
    text = (released / "README.md").read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    assert not [each for each in targets if not each.startswith(("https://", "#"))]
    pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)
    raw = "https://raw.githubusercontent.com/someone/vtk_mls/v9.9/"
    assert "pip install 'vtk-mls[vtk,cpu]'" in text
    assert "'.[" not in text
    assert pictures
    assert [each for each in pictures if each.startswith(raw)] == pictures
    for target in targets:
        path = re.sub(r"^https://[^/]+/someone/vtk_mls/(blob/)?v9.9/", "", target)
        assert path.startswith("https:") or (PROJECT / path).exists(), target


@pytest.mark.long
def test_the_index_takes_the_release(released):
    if importlib.util.find_spec("twine") is None:
        pytest.skip("twine is not installed")
    for command in (
        ["build", "--no-isolation", "--wheel", "--outdir", "dist"],
        ["twine", "check", "--strict", "dist/*"],
    ):
        done = subprocess.run(
            [sys.executable, "-m", *command],
            cwd=released,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
    assert "PASSED" in done.stdout


def test_the_oldest_and_the_newest_are_tried():
    tomllib = pytest.importorskip("tomllib", reason="Python 3.11 or later reads pyproject.toml")
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    spec = importlib.util.spec_from_file_location("run", PROJECT / "tests/environments/run.py")
    environments = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(environments)
    announced = [each.rpartition(" ")[2] for each in project["classifiers"] if " :: 3." in each]
    tried = {version for version, _ in environments.MATRIX}
    assert {project["requires-python"].removeprefix(">="), announced[-1]} <= tried
    oldest = project["optional-dependencies"]["vtk"][0].replace(">=", "==")
    pinned = {each for _, every in environments.MATRIX for each in every}
    assert any(each.startswith(oldest) for each in pinned)
    assert any(not every for _, every in environments.MATRIX)
