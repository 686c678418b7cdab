"""The editor with a brain in a window that is not shown, for pictures of the pages."""

from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkRenderWindowInteractor

from vtk_mls import io
from vtk_mls.commands import demo
from vtk_mls.editor import Editor
from vtk_mls.editor.saving import picture_of
from vtk_mls.files import vtk_io

_SIZE = 1280, 860


def open_editor():
    """An Editor and its window."""
    window, interactor = vtkRenderWindow(), vtkRenderWindowInteractor()
    window.SetOffScreenRendering(True)
    window.SetSize(_SIZE)
    window.SetMultiSamples(0)
    interactor.SetRenderWindow(window)
    interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
    return Editor(interactor, io.read_dataset(demo.brain_file())), window


def save_picture(editor, window, path):
    """Draw the finest map, and write a PNG file."""
    editor.scene.set_coarseness(1)
    window.Render()
    vtk_io.write_png(picture_of(window), path)
