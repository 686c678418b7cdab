"""A deformed volume is drawn, and differs from the undeformed one.  Argument: a folder for them."""

import sys
from pathlib import Path

import numpy as np
from paraview import simple
from scene import DEFORMED, control_points, data, wavelet
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

folder = Path(sys.argv[1])


def picture(proxy, handles, name):
    view = simple.CreateView("RenderView")
    view.ViewSize = [400, 400]
    view.OrientationAxesVisibility = 0
    volume = simple.Show(proxy, view)
    volume.SetRepresentationType("Volume")
    simple.ColorBy(volume, ("POINTS", "RTData"))
    points = simple.Show(handles, view)
    points.SetRepresentationType("Points")
    points.PointSize = 12
    points.RenderPointsAsSpheres = 1
    points.ColorArrayName = ["POINTS", ""]
    points.AmbientColor = points.DiffuseColor = [1.0, 0.0, 1.0]
    view.CameraPosition, view.CameraFocalPoint = [30, -40, 30], [0, 0, 0]
    view.CameraViewUp = [0, 0, 1]
    simple.Render(view)
    path = folder / f"{name}.png"
    simple.SaveScreenshot(str(path), view)
    reader = vtkPNGReader()
    reader.SetFileName(str(path))
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).astype(float)


source, handles = wavelet(), control_points()
bent = simple.MLSDeform(Input=source, ControlPoints=handles, OutputGrid="fitted")
assert data(bent).GetNumberOfPoints() > 0
before = picture(source, control_points(deformed=()), "undeformed")
after = picture(bent, handles, "deformed")
for pixels in (before, after):
    assert len(np.unique(pixels.round(), axis=0)) > 200, "the picture is blank"
assert np.abs(after - before).max(axis=1).mean() > 5, "the deformation is not visible"
assert len(DEFORMED) == data(handles).GetNumberOfPoints()
