"""A running `vtk-mls view`, for tests."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import contextmanager

from command_fixtures import PROJECT


@contextmanager
def server(folder, *arguments, **variables):
    """A running server, with variables of its environment; (process, address)."""
    environment = {**os.environ, "PYTHONPATH": str(PROJECT), **variables}
    process = subprocess.Popen(
        [sys.executable, "-m", "vtk_mls", "view", *arguments, "--no-browser", "--port", "0"],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        line = process.stdout.readline()
        assert "http://" in line, process.communicate()[1]
        yield process, line.split()[-1]
    finally:
        process.terminate()
        process.communicate()
