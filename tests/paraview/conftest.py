"""Fixtures of ParaView: its installations, and running GUIs."""

from __future__ import annotations

import shutil
from functools import partial

import pytest
from gui import running
from gui_scenes import OWN, SETUP, noise, write_brain
from paraviews import PICTURES, PROJECT, display, paraview, unavailable

__all__ = ["display", "paraview"]


@pytest.fixture
def start(paraview, display, request):
    """A context manager for a running GUI."""
    missing = [tool for tool in ("Xvfb", "xdotool", "import") if not shutil.which(tool)]
    if missing:
        unavailable(f"no {', '.join(missing)} here: tests/paraview/install.sh says why")
    name = request.node.originalname.removeprefix("test_")
    folder = PICTURES / request.node.callspec.id / name
    return partial(running, paraview, PROJECT, folder, display)


@pytest.fixture
def gui(start):
    """A running GUI with a wavelet, which must not print an error or a warning."""
    with start() as gui:
        gui.run(SETUP)
        yield gui
        assert noise(gui) == []


@pytest.fixture(scope="module")
def brain():
    """File of a volume, relative to the project."""
    return write_brain(OWN / "brain.vti", step=2)
