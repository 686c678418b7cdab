"""Fixtures of ParaView."""

from gui_fixtures import brain, gui, start
from paraviews import display, paraview

__all__ = ["brain", "display", "gui", "paraview", "start"]
