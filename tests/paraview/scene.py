"""Helpers of the scripts in this folder: the loaded plugin, a scene, and its arrays."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path

import numpy as np
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkIOImage import vtkPNGReader

PLUGIN = Path(__file__).resolve().parents[2] / "paraview_plugin" / "vtk_mls_plugin.py"
simple.LoadPlugin(str(PLUGIN), ns=vars(simple))

import vtk_mls  # noqa: E402  the plugin made it importable

# The corners of a box inside the wavelet; its upper face is rotated by 30 degrees and lifted.
REST = np.array([(x, y, z) for z in (-5.0, 5.0) for y in (-6.0, 6.0) for x in (-6.0, 6.0)])
TURN = np.array([[0.75**0.5, -0.5, 0], [0.5, 0.75**0.5, 0], [0, 0, 1]])
DEFORMED = np.where(REST[:, 2:] > 0, REST @ TURN.T + np.array([0, 0, 1.5]), REST)


def wavelet():
    """An image whose extent does not start at 0; point array RTData."""
    return simple.Wavelet(WholeExtent=[-9, 8, -8, 8, -7, 9])


def control_points(rest=REST, deformed=DEFORMED, **settings):
    return simple.MLSControlPoints(
        RestPoints=list(np.ravel(rest)), DeformedPoints=list(np.ravel(deformed)), **settings
    )


def data(proxy):
    """The proxy's output after an update."""
    proxy.UpdatePipeline()
    return servermanager.Fetch(proxy)


def grid(image):
    """The `vtk_mls.Grid` of a vtkImageData."""
    corner = image.GetPoint(0)
    return vtk_mls.Grid(image.GetDimensions(), corner, image.GetSpacing())


def array(dataset, name):
    """A point array: (n,) or (n, components); of an image (nz, ny, nx) or (..., components)."""
    values = vtk_to_numpy(dataset.GetPointData().GetArray(name))
    if dataset.IsA("vtkImageData"):
        return values.reshape(dataset.GetDimensions()[::-1] + values.shape[1:])
    return values


def screenshot(view, file):
    """Save a picture of a view; the colors (height, width, 3), bottom row first."""
    simple.SaveScreenshot(str(file), view, ImageResolution=list(view.ViewSize))
    reader = vtkPNGReader()
    reader.SetFileName(str(file))
    reader.Update()
    width, height, _ = reader.GetOutput().GetDimensions()
    pixels = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())
    return pixels.reshape(height, width, -1)[..., :3].astype(int)


@contextmanager
def output_messages():
    """Collect VTK's messages in a list of one string instead of printing them."""
    window, usual, text = vtkStringOutputWindow(), vtkOutputWindow.GetInstance(), []
    vtkOutputWindow.SetInstance(window)
    try:
        yield text
    finally:
        vtkOutputWindow.SetInstance(usual)
        text.append(window.GetOutput())
