"""The numpy and VTK examples pass their own checks; that for pvpython runs in test_scripts.py."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from vtk_fixtures import can_draw

PROJECT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted(
    path for path in (PROJECT / "examples").glob("*.py") if "paraview" not in path.name
)


# The gallery of the documentation, which `make docs` runs, too; the others begin where one does.
FIRST = {"cut_open", "mesh_and_image", "numpy_deform", "pyvista_deform", "vtk_deform", "vtk_live"}


def marked(path):
    marks = () if path.stem in FIRST else pytest.mark.matrix
    return pytest.param(path, id=path.stem, marks=marks)


@pytest.mark.parametrize("example", [marked(example) for example in EXAMPLES])
def test_example(example, tmp_path):
    if re.search(r"vtkRenderWindow|Plotter\(", example.read_text()) and not can_draw():
        pytest.skip("VTK cannot draw here")
    search = os.pathsep.join([str(PROJECT), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, str(example)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": search.rstrip(os.pathsep), "PYVISTA_OFF_SCREEN": "true"},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip()
    assert "ERR|" not in done.stderr, done.stderr
