"""The plugin of napari, in a real window on a virtual display.

Napari brings Qt, so it lives in an environment of its own, which `make mouse` makes.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

PYTHON = Path(__file__).resolve().parents[2] / ".venv-napari/bin/python"


@pytest.mark.skipif(not PYTHON.exists(), reason="no .venv-napari, which `make mouse` makes")
@pytest.mark.skipif(not shutil.which("xvfb-run"), reason="no xvfb-run")
def test_plugin_in_napari(tmp_path):
    checks = Path(__file__).with_name("window_checks.py")
    pytest_options = ["--noconftest", "-p", "no:cacheprovider", "-c", "/dev/null", "-q"]
    done = subprocess.run(
        [*("xvfb-run", "-a", "-s", "-screen 0 1280x900x24"), PYTHON, "-m", "pytest"]
        + [*pytest_options, "--rootdir", tmp_path, checks],
        capture_output=True,
        encoding="utf-8",
        env={name: value for name, value in os.environ.items() if not name.startswith("PYTEST")},
        timeout=600,
    )
    assert done.returncode == 0, done.stdout[-8000:] + done.stderr[-2000:]
