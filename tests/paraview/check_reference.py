"""MLS Deform on the grid of a reference, and MLS Landmark Report."""

import os
import tempfile

import numpy as np
from paraview import servermanager, simple
from scene import DEFORMED, REST, array, control_points, data, wavelet
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import Deformation, Sampling, io
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

FAR = np.array([200.0, 0, 0])

# The output has the grid of the input Reference, where the handles bring the data.
wave, handles = wavelet(), control_points(deformed=DEFORMED + FAR)
TURNED = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3
expected = ImageGeometry(
    (0, 11, 2, 12, -3, 5), (199.0, -7.0, -6.0), (0.9, 1.1, 1.3), tuple(TURNED.ravel().tolist())
)
file = vtkImageData()
expected.apply_to(file)
arrays.add(file.GetPointData(), "target", np.zeros(file.GetNumberOfPoints()))
folder = tempfile.TemporaryDirectory()
io.write_dataset(file, os.path.join(folder.name, "target.vti"))
target = simple.XMLImageDataReader(FileName=[os.path.join(folder.name, "target.vti")])
deform = simple.MLSDeform(Input=wave, ControlPoints=handles)
assert deform.GetProperty("Reference") is not None
deform.Reference = target
image = data(deform)
# Fetch leaves out the directions in ParaView 5.11
own = deform.GetClientSideObject().GetOutputDataObject(0)
np.testing.assert_allclose(ImageGeometry.of_image(own).grid.points(), expected.grid.points())
assert image.GetExtent() == expected.extent
value = Deformation(REST, DEFORMED + FAR, map_tolerance=deform.MapTolerance)
volume = data(wave)
sampling = Sampling(ImageGeometry.of_image(volume).grid, expected.grid, background="auto")
(values,) = value.resample([array(volume, "RTData")], sampling)
np.testing.assert_allclose(array(image, "RTData"), values, atol=1e-3)
assert np.ptp(values) > 50

# Without the reference the grid is that of the input again.
deform.Reference = None
assert data(deform).GetExtent() == data(wave).GetExtent()


# The report: a table of pairs, and one of the settings that were tried.
rng = np.random.default_rng(2)
p = rng.uniform(-50, 50, (40, 3))
pairs = control_points(p, p + 4 * np.sin(p[:, ::-1] / 40) + [3, 0, 0])
check = simple.MLSLandmarkReport(Input=pairs, Device="reference")
check.UpdatePipeline()
assert servermanager.Fetch(check, idx=1).GetNumberOfRows() > 2
moved = simple.Transform(Input=pairs)
moved.Transform.Translate = [0.0, 0.0, 2.0]
check.DeformedControlPoints = moved
check.UpdatePipeline()
table = servermanager.Fetch(check, idx=0).GetRowData()
assert arrays.texts(table, "Name")[:3] == ["1", "2", "3"]
np.testing.assert_allclose(arrays.to_numpy(table.GetArray("Moved")), 2, rtol=1e-6)
