"""Small VTK scenes, and fixtures that turn VTK's messages into failures. Tests import them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from control_point_sets import DEVICES
from vtkmodules import vtkCommonCore
from vtkmodules.vtkCommonCore import (
    VTK_DOUBLE,
    vtkDataArray,
    vtkOutputWindow,
    vtkStringOutputWindow,
)
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData, vtkPolyData

from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import set_positions
from vtk_mls.vtk.objects import configured

# The names of VTK's types of numbers, and their constants.
TYPES = {
    name: getattr(vtkCommonCore, f"VTK_{name.upper().replace(' ', '_')}")
    for name in (
        "bit",
        "char",
        "signed char",
        "unsigned char",
        "short",
        "unsigned short",
        "int",
        "unsigned int",
        "long",
        "unsigned long",
        "long long",
        "unsigned long long",
        "id type",
        "float",
        "double",
    )
}
# A right-handed turn about no particular axis.
TURNED = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3


class Messages:
    """What VTK had to say."""

    def __init__(self, window):
        self._window, self._read = window, 0

    def take(self):
        """The text since the last call."""
        text = self._window.GetOutput()
        text, self._read = text[self._read :], len(text)
        return text

    def assert_one(self, match):
        """There was exactly one message, of one line, with the pattern `match`."""
        lines = [line for line in self.take().splitlines() if line.strip()]
        assert len(lines) == 1, lines
        assert re.search(match, lines[0]), lines[0]

    def assert_none(self):
        text = self.take()
        assert text == "", f"VTK said: {text}"


@contextmanager
def collected_messages():
    """The `Messages` of VTK meanwhile."""
    usual, window = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    try:
        yield Messages(window)
    finally:
        vtkOutputWindow.SetInstance(usual)


@pytest.fixture(autouse=True)
def messages():
    """VTK's messages; those that a test does not take make it fail."""
    with collected_messages() as messages:
        yield messages
    messages.assert_none()


FAST = DEVICES[0] if DEVICES else "reference"

# Corners of a box around (4, 4, 3), its upper face turned by 30 degrees and lifted.
REST = np.array([(x, y, z) for z in (1.0, 5.0) for y in (1.0, 7.0) for x in (1.0, 7.0)])
_TURN = np.array([[0.75**0.5, -0.5, 0], [0.5, 0.75**0.5, 0], [0, 0, 1]])
DEFORMED = np.where(REST[:, 2:] > 3, (REST - 4) @ _TURN.T + [4, 4, 4.75], REST)


def make_image(
    dimensions=(9, 8, 7),
    start=(0, 0, 0),
    direction=None,
    origin=(0.5, 0.25, 0),
    spacing=(0.9, 1.0, 1.1),
):
    """An image without arrays."""
    image = configured(vtkImageData(), Origin=origin, Spacing=spacing)
    image.SetExtent([i for a, n in zip(start, dimensions) for i in (a, a + n - 1)])
    if direction is not None:
        image.SetDirectionMatrix(*np.ravel(direction))
    return image


def polydata_of(places, **cells):
    """A vtkPolyData of points (n, 3), and of ids of its Verts, Lines, Polys or Strips."""
    mesh = vtkPolyData()
    set_positions(mesh, np.array(places, float).reshape(-1, 3), VTK_DOUBLE)
    for name, lists in cells.items():
        array = vtkCellArray()
        for ids in lists:
            array.InsertNextCell(len(ids), list(ids))
        getattr(mesh, f"Set{name}")(array)
    return mesh


def scalar_image(values, geometry, name="density"):
    """An image with active point values (n,) or (n, components), on an `ImageGeometry`."""
    image = vtkImageData()
    geometry.apply_to(image)
    arrays.add(image.GetPointData(), name, values)
    image.GetPointData().SetActiveScalars(name)
    return image


def add_scalars(data, name, values, vtk_type=None):
    """Add an array to the points of data, as of `add_array`, as their active scalars; the data."""
    add_array(data.GetPointData(), name, values, vtk_type)
    data.GetPointData().SetActiveScalars(name)
    return data


def add_array(attributes, name, values, vtk_type=None):
    """Add a copy of `values` (n,) or (n, components); float64 if no type is given."""
    values = np.asarray(values)
    array = vtkDataArray.CreateDataArray(vtk_type) if vtk_type else None
    if array is None:
        array = arrays.from_numpy(values.astype(np.float64), 11)
    else:
        array.SetNumberOfComponents(1 if values.ndim == 1 else values.shape[1])
        array.SetNumberOfTuples(len(values))
        for i, value in enumerate(values.ravel().tolist()):
            array.SetComponent(*divmod(i, array.GetNumberOfComponents()), value)
    array.SetName(name)
    attributes.AddArray(array)
    return array


_PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.Render()
raise SystemExit(not window.SupportsOpenGL())
"""


def can_draw():
    """Asked in a process of its own, which a machine without OpenGL may take down."""
    probe = subprocess.run([sys.executable, "-c", _PROBE], capture_output=True, check=False)
    return probe.returncode == 0


@pytest.fixture(scope="module")
def opengl():
    """Pictures can be drawn."""
    with pytest.MonkeyPatch.context() as patch:
        if sys.platform == "linux" and not os.environ.get("DISPLAY"):
            patch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # X11 would complain
        if not can_draw():
            pytest.skip("VTK cannot draw here")
        yield
