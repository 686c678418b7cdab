"""3D Slicer without its window (the package slicer-core), as a judge of files.

It brings a VTK of its own, which must not meet ours, so it lives in an environment of its own and
runs in a process of its own. `VTK_MLS_SLICER_PYTHON` names the Python of that environment.
"""

from __future__ import annotations

import os
import subprocess

import pytest

_PYTHON = os.environ.get("VTK_MLS_SLICER_PYTHON")

needs_slicer = pytest.mark.skipif(
    not _PYTHON,
    reason="VTK_MLS_SLICER_PYTHON does not name a Python with the package slicer-core",
)


def run(code, *arguments):
    """What Slicer's Python prints when it runs `code` with `sys.argv[1:] = arguments`."""
    usual = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("PYTHON") and name != "LD_LIBRARY_PATH"
    }
    command = [_PYTHON, "-c", code, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, env=usual, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
