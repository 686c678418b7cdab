"""A cut, and its gradients
========================

Cut a block of layers open from above and look into it, in a VTK pipeline.

You will see a slice of the block as text: layers, and the wedge where the cut was pulled open. The
end checks that the face of the cut is smooth, and that the gradient followed the deformation.
"""

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkContourFilter
from vtkmodules.vtkImagingSources import vtkImageSinusoidSource

import vtk_mls
from vtk_mls.filters import MLSControlPoints, MLSDeform

layers = vtkImageSinusoidSource()  # 100 cos(2 pi z / 16)
layers.SetWholeExtent(0, 63, 0, 23, 0, 47)
layers.SetDirection(0, 0, 1)
layers.SetPeriod(16)
layers.SetAmplitude(100)

# Both halves above the edge of the cut are turned outward about it; what is below stays.
edge, angle = np.array([32.3, 12.0, 16.0]), np.radians(20)
rest = np.array([(x, y, z) for x in (10, 26, 38, 54) for y in (4, 20) for z in (28, 44)], float)
below = np.array([(x, y, 4) for x in (6, 32, 58) for y in (4, 20)], float)
x, y, z = (rest - edge).T
c, s = np.cos(angle), np.sin(angle) * np.sign(x)
turned = edge + np.stack([c * x + s * z, y, c * z - s * x], axis=1)
handles = MLSControlPoints()
handles.SetRestPoints([*rest.tolist(), *below.tolist()])
handles.SetDeformedPoints([*turned.tolist(), *below.tolist()])

cut = vtk_mls.HalfPlane(edge, normal=(1, 0, 0), inward=(0, 0, 1))
deform = MLSDeform()
deform.SetInputConnection(0, layers.GetOutputPort())
deform.SetInputConnection(1, handles.GetOutputPort())
deform.AddCut(cut)
deform.SetGradientArray("ImageScalars")
deform.Update()
image = deform.GetOutputDataObject(0)


def array(name):
    values = vtk_to_numpy(image.GetPointData().GetArray(name))
    return values.reshape(48, 24, 64, *values.shape[1:])


for row, void in zip(array("ImageScalars")[::-2, 12], array("Void")[::-2, 12]):
    print("".join(" " if v else ".:-=+#"[int(f / 34 + 3)] for f, v in zip(row, void)).rstrip())

# The zero level of VoidDistance is the face of the opening; the map itself says how exactly.
face = vtkContourFilter()
face.SetInputData(image)
face.SetInputArrayToProcess(0, 0, 0, 0, "VoidDistance")
face.SetValue(0, 0)
face.Update()
points = vtk_to_numpy(face.GetOutput().GetPoints().GetData()).astype(float)
d = vtk_mls.Deformation(np.vstack([rest, below]), np.vstack([turned, below]), cuts=(cut,))
away = np.abs(d.void_distance(points))[points[:, 2] > 20].max()
print(f"The contour is within {away:.3f} voxels of the face")

# The gradient, against differences of the layers at where the material came from.
k, j, i = (np.argwhere(array("VoidDistance")[6:36, 6:18, 6:58] > 3) + 6).T
v, step = np.stack([i, j, k], axis=1).astype(float), 0.05 * np.eye(3)
ahead, behind = ([np.cos(d.backward(v + s * h)[:, 2] * np.pi / 8) for h in step] for s in (1, -1))
true = 1000 * (np.array(ahead) - np.array(behind)).T
error = np.abs(array("Gradient")[k, j, i] - true).max() / np.abs(true).max()
print(f"The gradient is within {error:.1%} of the true one")
assert away < 0.1
assert error < 0.05
