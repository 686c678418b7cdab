"""The editor in its own window."""

from contextlib import suppress

import vtkmodules.vtkInteractionStyle  # registers interactors
import vtkmodules.vtkRenderingOpenGL2  # renders
import vtkmodules.vtkRenderingUI  # noqa: F401  windows of the operating system
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkRenderWindowInteractor

from vtk_mls.base import display
from vtk_mls.editor.autosave import Autosave
from vtk_mls.editor.editor import Editor
from vtk_mls.editor.scene import new_window
from vtk_mls.engine.device.device_check import FIELDS
from vtk_mls.engine.device.devices import DeviceError
from vtk_mls.engine.dispatch import engine_for

_SIZE = 1200, 850
_OFFSCREEN_CLASSES = "vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow"  # without a display


def show(datasets, state, paths, folder=None, target=None, session=None):
    """Edit datasets, from a `State` on, until the window is closed; OSError without a display.

    `paths` are those of the datasets, `folder` is where to save (None: a new one, as of `Saver`),
    `target` a `Target` to match, and `session` the session file that is open, and its views.
    """
    display.check()  # VTK before 9.4 crashes without a display
    window = new_window()
    if window.GetClassName() in _OFFSCREEN_CLASSES:
        raise display.missing()
    if target is not None:  # check the driver now, as the first pair would freeze the window for it
        with suppress(DeviceError):  # the first pair reports it
            engine_for(state.device, needed=("spline", FIELDS))
    window.SetSize(_SIZE)
    window.SetWindowName(f"{paths[0]} - vtk-mls")
    interactor = vtkRenderWindowInteractor()
    interactor.SetRenderWindow(window)
    interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
    editor = Editor(interactor, datasets, state, paths, Autosave(paths[0]), target)
    if folder is not None:
        editor.saver.set_output(folder)
    if session is not None:
        editor.resume_session(*session)
    interactor.Start()
    editor.detach()
    window.Finalize()
