"""What the pictures of the cut brain share: the brain, its control points and cut."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth, vtkImageGradient
from vtkmodules.vtkIOImage import vtkNIFTIImageReader

from vtk_mls import HalfPlane
from vtk_mls.demo import volumes
from vtk_mls.demo.drawing import DRAGGED, PINNED, spheres
from vtk_mls.filters import MLSControlPoints, MLSDeform

# In millimetres: x to the right, y to the front, z up. The cut runs down to its edge at EDGE.
EDGE = np.array([98.0, 118.0, 58.0])
CUT = HalfPlane(EDGE, normal=(0, 1, 0), inward=(0, 0, 1))
ANGLE = np.radians(35)  # by which each half is rotated about the edge
FRONT = [(157, 125, 115), (112, 125, 149), (159, 146, 102), (150, 175, 88), (125, 177, 117)]
BACK = [(157, 111, 116), (117, 111, 150), (165, 88, 103), (152, 59, 88), (127, 54, 120)]
BELOW = [(157, 142, 53), (163, 86, 51), (113, 114, 36), (135, 52, 25), (127, 171, 51)]
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
    """T1-weighted volume of a brain, smoothed a little, with its gradient twice."""
    reader = vtkNIFTIImageReader()
    reader.SetFileName(str(volumes.brain()))
    smooth = vtkImageGaussianSmooth()
    smooth.SetInputConnection(reader.GetOutputPort())
    smooth.SetStandardDeviation(0.8)
    gradient = vtkImageGradient()
    gradient.SetInputConnection(smooth.GetOutputPort())
    gradient.SetDimensionality(3)
    gradient.Update()
    brain = vtkImageData()
    brain.DeepCopy(smooth.GetOutput())
    brain.GetPointData().GetScalars().SetName("T1")
    for name in ("Turned", "Carried"):
        values = vtk_to_numpy(gradient.GetOutput().GetPointData().GetScalars())
        add(brain, name, values.astype(np.float32))
    return brain


def control_points():
    """Rest and deformed positions (n, 3): both halves are rotated outward, what is below stays."""
    front, back, below = (_both_sides(points) for points in (FRONT, BACK, BELOW))
    rest = np.vstack([front, back, below])
    return rest, np.vstack([_rotated(front, -ANGLE), _rotated(back, ANGLE), below])


def pulled_open(dataset):
    """An `MLSDeform` of an image or mesh of the brain, to be updated."""
    deform, source = MLSDeform(), MLSControlPoints()
    rest, deformed = control_points()
    source.SetRestPoints(rest)
    source.SetDeformedPoints(deformed)
    deform.SetInputData(dataset)
    deform.SetInputConnection(1, source.GetOutputPort())
    deform.AddCut(CUT)
    deform.SetOutputGrid("given")
    deform.SetOutputOrigin(*LOWER)
    deform.SetOutputDimensions(*(UPPER - LOWER + 1).astype(int).tolist())
    return deform


def marked(positions):
    """Actors that show where the control points are, moved ones in another colour."""
    rest, deformed = control_points()
    moved = np.any(rest != deformed, axis=1)
    return spheres(positions[moved], 3.0, DRAGGED), spheres(positions[~moved], 3.0, PINNED)


def _both_sides(points):
    """The points and their mirror images."""
    points = np.array(points, dtype=float)
    return np.vstack([points, points * (-1, 1, 1) + (2 * EDGE[0], 0, 0)])


def _rotated(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return EDGE + (points - EDGE) @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


def add(image, name, values):
    """Add point data."""
    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    image.GetPointData().AddArray(array)
