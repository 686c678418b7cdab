"""Fixtures of the editor."""

import os
import shutil

import pytest


@pytest.fixture
def screen():
    missing = [tool for tool in ("Xvfb", "xdotool") if not shutil.which(tool)]
    if missing:
        report = pytest.fail if os.environ.get("CI") == "true" else pytest.skip
        report(f"no {', '.join(missing)} on this system: tests/paraview/install.sh installs them")
