"""A VTK pipeline
==============

Deform an image in a VTK pipeline, and once more with VTK's own filters and our displacement map.

You will see how far a ball came when the control point in it was dragged by 20 voxels: less,
since six others hold the box around it. The end checks that `MLSDeform` agrees with
`vtkGridTransform` + `vtkImageReslice`.
"""

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersHybrid import vtkGridTransform
from vtkmodules.vtkImagingCore import vtkImageReslice
from vtkmodules.vtkImagingSources import vtkImageEllipsoidSource

from vtk_mls.filters import MLSControlPoints, MLSDeform, MLSDisplacementField

ball = vtkImageEllipsoidSource()
ball.SetWholeExtent(0, 63, 0, 63, 0, 63)
ball.SetCenter(24, 32, 32)
ball.SetRadius(12, 12, 12)
ball.SetOutputScalarTypeToFloat()

# The center of the ball is dragged along x; the centers of the cube's faces stay.
faces = [(0, 32, 32), (63, 32, 32), (32, 0, 32), (32, 63, 32), (32, 32, 0), (32, 32, 63)]
handles = MLSControlPoints()
handles.SetRestPoints([(24, 32, 32), *faces])
handles.SetDeformedPoints([(44, 32, 32), *faces])

deform = MLSDeform()
deform.SetInputConnection(0, ball.GetOutputPort())
deform.SetInputConnection(1, handles.GetOutputPort())
deform.SetKind("similarity")
deform.Update()

# The same in two steps: the displacement map plugs into any VTK filter that takes a transform.
field = MLSDisplacementField()
field.SetInputConnection(0, ball.GetOutputPort())
field.SetInputConnection(1, handles.GetOutputPort())
field.SetKind("similarity")
transform = vtkGridTransform()
transform.SetDisplacementGridConnection(field.GetOutputPort())
reslice = vtkImageReslice()
reslice.SetInputConnection(ball.GetOutputPort())
reslice.SetResliceTransform(transform)
reslice.SetInterpolationModeToLinear()
reslice.Update()


def values(algorithm):
    image = algorithm.GetOutputDataObject(0)
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(64, 64, 64)


def center(volume):
    return np.array([axis.mean() for axis in np.nonzero(volume > 127)])[::-1]


before, after, by_vtk = values(ball), values(deform), values(reslice)
print(f"The ball's center moved from {center(before).round(1)} to {center(after).round(1)}")
difference = np.abs(after - by_vtk).max()
print(f"MLSDeform and vtkImageReslice differ by at most {difference:.2g} of 255")
assert center(after)[0] - center(before)[0] > 5
assert difference < 1
