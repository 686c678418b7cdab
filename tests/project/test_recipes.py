"""The recipes of CONTRIBUTING work as they stand there, in a copy of the project."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
TEXT = (PROJECT / "CONTRIBUTING.md").read_text()
FOLDERS = ("docs", "opencl", "paraview_plugin", "tests", "vtk_mls")

pytestmark = pytest.mark.long


def recipe(title):
    """(path, what it says behind the path, code) of each block of a section."""
    section = TEXT.partition(f"## {title}\n")[2].partition("\n## ")[0]
    assert section, f"CONTRIBUTING has no section {title}"
    return re.findall(r"```\w+\n(?:#|//) ([\w./]+)(?:, ([^\n]*))?\n(.*?)```", section, re.DOTALL)


@pytest.fixture
def copy(tmp_path):
    for folder in FOLDERS:
        ignored = shutil.ignore_patterns("__pycache__", "*.png")
        shutil.copytree(PROJECT / folder, tmp_path / folder, ignore=ignored)
    shutil.copy(PROJECT / "pyproject.toml", tmp_path)
    return tmp_path


def run(copy, *command):
    done = subprocess.run(
        [sys.executable, *command],
        capture_output=True,
        text=True,
        check=False,
        cwd=copy,
        env={**os.environ, "PYTHONPATH": str(copy)},
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_format(copy):
    (module, _, code), (table, where, line) = recipe("Add a format of files")
    assert where == "in TABLE"
    (copy / module).write_text(code)
    text = (copy / table).read_text()
    assert "TABLE = (\n" in text
    (copy / table).write_text(text.replace("TABLE = (\n", f"TABLE = (\n    {line.strip()},\n", 1))
    run(copy, "docs/formats_page.py")
    assert ".ssv" in (copy / "docs/formats.md").read_text()
    tests = "tests/files/test_formats.py", "tests/files/test_point_files.py"
    run(copy, "-m", "pytest", "-q", *tests, "-k", "ssv or page or labels_can or table")


def test_a_kind(copy):
    if not (PROJECT / "vtk_mls" / "kinds").is_dir():
        pytest.skip("the kinds are in no room of their own yet")
    (kernel, _, code), (module, _, python), (test, _, checks) = recipe("Add a kind")
    for path, text in ((kernel, code), (module, python), (test, checks)):
        assert not (copy / path).exists()
        (copy / path).write_text(text)
    run(copy, "-m", "pytest", "-q", test)
