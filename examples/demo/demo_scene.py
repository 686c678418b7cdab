"""What the pictures of the cut brain share: the brain, its control points and cut."""

from __future__ import annotations

import numpy as np
from demo_drawing import DRAGGED, PINNED, spheres
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkImagingGeneral import vtkImageGradient

from vtk_mls import HalfPlane
from vtk_mls.commands import demo
from vtk_mls.filters import MLSControlPoints, MLSDeform

# In millimeters: x to the right, y to the front, z up. The cut runs down to its edge.
EDGE = np.array(demo.EDGE)
CUT = HalfPlane(EDGE, normal=(0, 1, 0), inward=(0, 0, 1))
LOWER, UPPER = np.array([15.0, -30.0, 0.0]), np.array([181.0, 262.0, 176.0])  # of the output

MIDDLE = (98.0, 118.0, 93.0)  # of the picture
VIEW = (1.0, 0.2, 1.1)  # from the middle towards the eye
LIGHTS = {(0.0, 0.6, 0.8): 1.0, (0.8, -0.6, 0.15): 0.42}  # directions and intensities
TISSUES = {0: (0.25, 0.06, 0.07), 70: (0.4, 0.11, 0.11), 135: (0.72, 0.42, 0.38)} | {
    175: (0.86, 0.62, 0.55),
    205: (0.98, 0.93, 0.86),
    255: (1.0, 0.97, 0.92),
}


def brain():
    """The brain of `vtk-mls demo` with its gradient twice."""
    image = demo.brain()
    gradient = vtkImageGradient()
    gradient.SetInputData(image)
    gradient.SetDimensionality(3)
    gradient.Update()
    for name in ("Turned", "Carried"):
        values = vtk_to_numpy(gradient.GetOutput().GetPointData().GetScalars())
        add(image, name, values.astype(np.float32))
    return image


def pulled_open(dataset):
    """An `MLSDeform` of an image or mesh of the brain, to be updated."""
    deform, source = MLSDeform(), MLSControlPoints()
    rest, deformed = demo.control_points()
    source.SetRestPoints(rest)
    source.SetDeformedPoints(deformed)
    deform.SetInputData(dataset)
    deform.SetInputConnection(1, source.GetOutputPort())
    deform.AddCut(CUT)
    deform.SetAlpha(1)  # each half turns as a whole
    deform.SetOutputGrid("given")
    deform.SetOutputOrigin(*LOWER)
    deform.SetOutputDimensions(*(UPPER - LOWER + 1).astype(int).tolist())
    return deform


def marked(positions):
    """Actors that show where the control points are, moved ones in another color."""
    rest, deformed = demo.control_points()
    moved = np.any(rest != deformed, axis=1)
    return spheres(positions[moved], 3.0, DRAGGED), spheres(positions[~moved], 3.0, PINNED)


def add(image, name, values):
    """Add point data."""
    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    image.GetPointData().AddArray(array)
