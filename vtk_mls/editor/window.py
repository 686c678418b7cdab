"""The editor in a window of its own."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import vtkmodules.vtkInteractionStyle  # registers interactors
import vtkmodules.vtkRenderingOpenGL2  # draws
import vtkmodules.vtkRenderingUI  # noqa: F401  windows of the system
from vtkmodules.vtkCommonCore import vtkLogger
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkRenderWindowInteractor

from vtk_mls.editor.drafts import Drafts
from vtk_mls.editor.editor import Editor

_SIZE = 1200, 850
_DISPLAYS = "DISPLAY", "WAYLAND_DISPLAY"
_HIDDEN = "vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow"  # what VTK makes without a display


def show(datasets, state, paths, folder=None):
    """Edit until the window is closed.

    Parameters
    ----------
    datasets : list of vtkDataSet
    state : State
        To begin with.
    paths : list of path
        Of the datasets.
    folder : path, optional
        Where to save, as of `Saver`.

    Raises
    ------
    OSError
        If there is no display.
    """
    window = _window()
    window.SetSize(_SIZE)
    window.SetWindowName(f"{paths[0]} - vtk-mls")
    interactor = vtkRenderWindowInteractor()
    interactor.SetRenderWindow(window)
    interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
    editor = Editor(interactor, datasets, state, paths, Drafts(paths[0]))
    editor.saver.folder = None if folder is None else Path(folder)
    interactor.Start()
    editor.detach()
    window.Finalize()


def _window():
    """A window on the display."""
    if sys.platform == "linux" and not any(map(os.environ.get, _DISPLAYS)):
        raise _no_display()  # VTK before 9.4 crashes
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        window = vtkRenderWindow()
    finally:
        vtkLogger.SetStderrVerbosity(verbosity)
    if window.GetClassName() in _HIDDEN:
        raise _no_display()
    return window


def _no_display():
    return OSError(
        "there is no display to open a window on; set DISPLAY, or work where there is one"
        + " (over ssh: ssh -X)" * (sys.platform != "win32")
    )
