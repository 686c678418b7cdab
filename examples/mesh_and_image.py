"""Image and mesh as one
=====================

Bend and cut a tetrahedral mesh and an image of the same thing by the same handles.

A mesh moves by the exact inverse of the map that resamples images, so both stay together: at random
places the script compares what either has there. It leaves mesh_and_image.png, a slice of the image
with the mesh's cells over it.
"""

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - what draws
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkPlane, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkCutter, vtkProbeFilter
from vtkmodules.vtkFiltersSources import vtkCellTypeSource
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkImageSlice,
    vtkImageSliceMapper,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

import vtk_mls
from vtk_mls.filters import MLSControlPoints, MLSDeform

SIZE = 40

wavelet = vtkRTAnalyticSource()  # point scalars "RTData"
wavelet.SetWholeExtent(0, SIZE, 0, SIZE, 0, SIZE)
wavelet.SetCenter(SIZE / 2, SIZE / 2, SIZE / 2)

blocks = vtkCellTypeSource()  # twelve tetrahedra in each block
blocks.SetCellType(VTK_TETRA)
blocks.SetBlocksDimensions(SIZE, SIZE, SIZE)
blocks.SetOutputPrecision(0)
tetrahedra = vtkProbeFilter()
tetrahedra.SetInputConnection(blocks.GetOutputPort())
tetrahedra.SetSourceConnection(wavelet.GetOutputPort())

# Two halves are turned away from each other above the edge of the cut; the lower end stays.
edge, angle = np.array([19.7, 20.0, 14.0]), np.radians(25)
rest = np.array([(x, y, z) for x in (4, 15, 25, 36) for y in (5, 35) for z in (22, 36)], float)
below = np.array([(x, y, 3) for x in (4, 20, 36) for y in (5, 35)], float)
x, y, z = (rest - edge).T
c, s = np.cos(angle), np.sin(angle) * np.sign(x)
turned = edge + np.stack([c * x + s * z, y, c * z - s * x], axis=1)
handles = MLSControlPoints()
handles.SetRestPoints([*rest.tolist(), *below.tolist()])
handles.SetDeformedPoints([*turned.tolist(), *below.tolist()])


def deformed(source):
    deform = MLSDeform()
    deform.SetInputConnection(0, source.GetOutputPort())
    deform.SetInputConnection(1, handles.GetOutputPort())
    deform.AddCut(vtk_mls.HalfPlane(edge, normal=(1, 0, 0), inward=(0, 0, 1)))
    deform.SetOutputGrid("fitted")  # of the image: as large as what it shows
    deform.Update()
    return deform.GetOutputDataObject(0)


image, mesh = deformed(wavelet), deformed(tetrahedra)
failed = mesh.GetFieldData().GetArray("FailedInverses").GetValue(0)
print(f"{mesh.GetNumberOfCells()} tetrahedra; {failed} of {mesh.GetNumberOfPoints()} points lost")

places = np.random.default_rng(1).uniform(1, SIZE - 1, (10_000, 3))
points = vtkPoints()
points.SetData(numpy_to_vtk(places, deep=True))
probes = vtkPolyData()
probes.SetPoints(points)
values, valid = [], np.ones(len(places), bool)
for data in (image, mesh):
    probe = vtkProbeFilter()
    probe.SetInputData(probes)
    probe.SetSourceData(data)
    probe.Update()
    found = probe.GetOutput().GetPointData()
    values.append(vtk_to_numpy(found.GetArray("RTData")))
    valid &= vtk_to_numpy(found.GetArray("vtkValidPointMask")) > 0
difference = np.abs(values[0] - values[1])[valid]
spread = np.ptp(values[0][valid])
mean, most = difference.mean() / spread, np.quantile(difference, 0.99) / spread
print(f"At {valid.sum()} places inside of both, the difference is {mean:.2%} of the values' range")
print(f"on average, and for 99 % of them below {most:.1%}")
assert valid.sum() > 3000
assert mean < 0.01

# A picture: slice of the image, cells of the mesh in the same plane.
image.GetPointData().SetActiveScalars("RTData")
slice_mapper = vtkImageSliceMapper()
slice_mapper.SetInputData(image)
slice_mapper.SetOrientationToY()
row = round((SIZE / 2 - image.GetOrigin()[1]) / image.GetSpacing()[1])
slice_mapper.SetSliceNumber(row)
grey = vtkImageSlice()
grey.SetMapper(slice_mapper)
grey.GetProperty().SetColorWindow(250)
grey.GetProperty().SetColorLevel(150)
plane = vtkPlane()
plane.SetOrigin(0, image.GetOrigin()[1] + row * image.GetSpacing()[1], 0)
plane.SetNormal(0, 1, 0)
section = vtkCutter()
section.SetInputData(mesh)
section.SetCutFunction(plane)
section.GenerateTrianglesOff()
lines = vtkPolyDataMapper()
lines.SetInputConnection(section.GetOutputPort())
lines.ScalarVisibilityOff()
cells = vtkActor()
cells.SetMapper(lines)
cells.SetPosition(0, -0.5, 0)  # in front of the slice
cells.GetProperty().SetRepresentationToWireframe()
cells.GetProperty().SetColor(1.0, 0.6, 0.1)
cells.GetProperty().SetOpacity(0.6)
cells.GetProperty().LightingOff()
scene = vtkRenderer()
scene.AddActor(grey)
scene.AddActor(cells)
camera = scene.GetActiveCamera()
camera.ParallelProjectionOn()
camera.SetFocalPoint(SIZE / 2, SIZE / 2, SIZE / 2)
camera.SetPosition(SIZE / 2, -5 * SIZE, SIZE / 2)
camera.SetViewUp(0, 0, 1)
scene.ResetCamera()
camera.Zoom(1.5)
window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.SetSize(1200, 900)
window.AddRenderer(scene)
window.Render()
if window.SupportsOpenGL():
    shot, writer = vtkWindowToImageFilter(), vtkPNGWriter()
    shot.SetInput(window)
    writer.SetInputConnection(shot.GetOutputPort())
    writer.SetFileName("mesh_and_image.png")
    writer.Write()
    print("Wrote mesh_and_image.png")
