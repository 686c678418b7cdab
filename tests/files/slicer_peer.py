"""3D Slicer without its window (the package slicer-core), as a judge of files.

It brings a VTK of its own, which must not meet ours, so it lives in an environment of its own and
runs in a process of its own; `make test` makes it.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

_PYTHON = Path(__file__).resolve().parents[2] / ".venv-slicer/bin/python"

needs_slicer = pytest.mark.skipif(
    not _PYTHON.exists(),
    reason="no .venv-slicer with the package slicer-core, which `make test` makes where it can",
)


def run(code, *arguments):
    """What Slicer's Python prints when it runs `code` with `sys.argv[1:] = arguments`."""
    usual = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("PYTHON") and name != "LD_LIBRARY_PATH"
    }
    command = [str(_PYTHON), "-c", code, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", env=usual, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
