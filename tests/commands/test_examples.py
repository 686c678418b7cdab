"""The numpy and VTK examples pass their own checks; that for pvpython runs in test_scripts.py."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from vtk_fixtures import can_draw

PROJECT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted(
    path for path in (PROJECT / "examples").glob("*.py") if "paraview" not in path.name
)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example(example, tmp_path):
    if "vtkRenderWindow" in example.read_text() and not can_draw():
        pytest.skip("VTK cannot draw here")
    search = os.pathsep.join([str(PROJECT), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, str(example)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": search.rstrip(os.pathsep)},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip()
    assert "ERR|" not in done.stderr, done.stderr
