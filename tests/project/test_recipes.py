"""The recipes of CONTRIBUTING work as they stand there, in a copy of the project."""

from __future__ import annotations

import re
import shutil
import textwrap

import pytest
from command_fixtures import PROJECT, python

TEXT = (PROJECT / "CONTRIBUTING.md").read_text()
FOLDERS = ("docs", "opencl", "paraview_plugin", "tests", "vtk_mls")


def recipe(title):
    """(path, text behind the path, code) of each block of a section."""
    section = TEXT.partition(f"## {title}\n")[2].partition("\n## ")[0]
    assert section, f"CONTRIBUTING has no section {title}"
    return re.findall(r"```\w+\n(?:#|//) ([\w./]+)(?:, ([^\n]*))?\n(.*?)```", section, re.DOTALL)


@pytest.fixture
def copy(tmp_path):
    for folder in FOLDERS:
        ignored = shutil.ignore_patterns("__pycache__", "*.png", "_build", "gallery", "made")
        shutil.copytree(PROJECT / folder, tmp_path / folder, ignore=ignored)
    shutil.copy(PROJECT / "pyproject.toml", tmp_path)
    return tmp_path


def run(copy, *command):
    status, out, err = python(*command, folder=copy, path=copy)
    assert status == 0, out + err


@pytest.mark.matrix
def test_a_format(copy):
    (module, _, code), (table, where, line) = recipe("Add a file format")
    assert where == "in TABLE"
    (copy / module).write_text(code)
    insert(copy / table, "\nTABLE = (\n", f"{line.strip()},\n")
    run(copy, "docs/formats_page.py")
    assert ".ssv" in (copy / "docs/formats.md").read_text()
    tests = "tests/files/test_formats.py", "tests/files/test_point_files.py"
    run(copy, "-m", "pytest", "-q", *tests, "-k", "ssv or page or labels_can or table")


KIND_IS_FOUND = """
from vtk_mls.commands.kernel_checks import checks
from vtk_mls.paraview.panels import DEFORM

assert any("translation" in element for element in DEFORM)
assert "translation" in checks(engine=None)
"""


def write(copy, blocks):
    """Write new files; the path of the last one, the test."""
    for path, where, code in blocks:
        assert not where
        assert not (copy / path).exists()
        (copy / path).write_text(code)
    return blocks[-1][0]


def insert(path, anchor, code):
    """Insert code behind the line `anchor`, one level deeper."""
    text = path.read_text()
    assert text.count(anchor) == 1
    indent = " " * (len(anchor.strip("\n")) - len(anchor.strip()) + 4)
    path.write_text(text.replace(anchor, anchor + textwrap.indent(code, indent)))


def add_after(path, before, line):
    """Insert `line` behind the line `before`, at the same level."""
    text = path.read_text()
    (indent,) = re.findall(rf"^( *){re.escape(before)}\n", text, re.MULTILINE)
    path.write_text(text.replace(f"{indent}{before}\n", f"{indent}{before}\n{indent}{line}"))


@pytest.mark.matrix
def test_a_kind(copy):
    test = write(copy, recipe("Add a kind"))
    run(copy, "-m", "pytest", "-q", test)
    run(copy, "docs/properties_page.py")
    assert '"translation"' in (copy / "docs/properties.md").read_text()
    run(copy, "-c", KIND_IS_FOUND)


# New kernels: each device is checked again.
@pytest.mark.parametrize("part", ["not kernels", pytest.param("kernels", marks=pytest.mark.matrix)])
def test_a_shape_of_cuts(part, copy):
    """A file in Python makes a shape that all interfaces have."""
    test = write(copy, recipe("Add a shape of cuts"))
    run(copy, "-m", "pytest", "-q", test, "-k", part)
    run(copy, "docs/properties_page.py")
    assert "### CutRadius" in (copy / "docs/properties.md").read_text()


@pytest.mark.parametrize("title", ["Add a shape of rigid regions", "Add a mask"])
def test_a_class(title, copy):
    (module, where, code), test = recipe(title)
    assert where == "at the end"
    with (copy / module).open("a") as file:
        file.write(f"\n\n{code}")
    run(copy, "-m", "pytest", "-q", write(copy, [test]), "-k", "not kernels")


@pytest.mark.matrix
def test_an_option(copy):
    (table, in_table, row), *changes, test = recipe("Add an option of the deformation")
    assert in_table == "in OPTIONS"
    insert(copy / table, "\nOPTIONS = (\n", f"{row.rstrip()},\n")
    for module, place, line in changes:
        add_after(copy / module, place.removeprefix("after "), line)
    run(copy, "-m", "pytest", "-q", write(copy, [test]))
    run(copy, "docs/properties_page.py")
    assert "WeightPower" in (copy / "docs/properties.md").read_text()


@pytest.mark.matrix
def test_a_property(copy):
    (table, in_table, line), *changes, (module, in_module, use), test = recipe("Add a property")
    assert (in_table, in_module) == ("in VOID", "first in _mark_cells")
    insert(copy / table, "\nVOID = (\n", line.replace(")\n", "),\n"))
    for changed, place, row in changes:
        add_after(copy / changed, place.removeprefix("after "), row)
    insert(copy / module, "    def _mark_cells(self, progress):\n", use)
    run(copy, "-m", "pytest", "-q", write(copy, [test]))
    run(copy, "docs/properties_page.py")
    assert "MarkVoidCells" in (copy / "docs/properties.md").read_text()


def test_a_filter(copy):
    (module, _, code), (names, in_all, name), (_, in_modules, row), test = recipe("Add a filter")
    assert (in_all, in_modules) == ("in __all__", "in _MODULES")
    (copy / module).write_text(code)
    text = (copy / names).read_text()
    (copy / names).write_text(text.replace("__all__ = [", f"__all__ = [{name.strip()}, ", 1))
    insert(copy / names, "\n_MODULES = {\n", f"{row.strip()},\n")
    run(copy, "-m", "pytest", "-q", write(copy, [test]))


def test_a_key(copy):
    (table, in_table, row), (module, place, code), test = recipe("Add a key")
    assert (in_table, place) == ("in Handles", "before reset")
    insert(copy / table, '\n    "Handles": (\n', f"        {row.rstrip()},\n")
    anchor = "    def reset(self):\n"
    text = (copy / module).read_text()
    assert text.count(anchor) == 1
    method = textwrap.indent(code, "    ")
    (copy / module).write_text(text.replace(anchor, f"{method}\n{anchor}"))
    run(copy, "-m", "pytest", "-q", write(copy, [test]))


def test_a_quirk(copy):
    (table, in_table, row), test = recipe("Add a driver's quirk")
    assert in_table == "in QUIRKS"
    insert(copy / table, "\nQUIRKS = (\n", f"{row.rstrip()},\n")
    run(copy, "-m", "pytest", "-q", write(copy, [test]))
