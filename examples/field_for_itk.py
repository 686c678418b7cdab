"""A field for ITK
===============

The displacement field goes to a file that SimpleITK, ANTs and 3D Slicer take as a transform. What
they resample with it is what vtk_mls makes itself.

You will see a slice at rest, both results, and their difference, which is black; the end checks it.
"""

import tempfile
from pathlib import Path

import numpy as np
import pyvista as pv
import SimpleITK as sitk

import vtk_mls
from vtk_mls import Grid, Sampling
from vtk_mls.commands import demo
from vtk_mls.files import field_files

head = sitk.ReadImage(str(demo.brain_file()), sitk.sitkFloat32)[::2, ::2, ::2]
direction = np.reshape(head.GetDirection(), (3, 3))
grid = Grid(head.GetSize(), head.GetOrigin(), head.GetSpacing(), direction)

# In LPS: x to the left, y to the back, z up. One side is pulled outward, the rest is held.
rest = np.array([(50, 0, 20), (-50, 0, 20), (0, -70, 10), (0, 90, 0), (0, 20, 75), (0, 20, -45)])
deformed = rest + np.array([(24, -12, 8), *[(0, 0, 0)] * 5])
d = vtk_mls.Deformation(rest, deformed, kind="similarity")

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "warp.nrrd")
    field_files.write(d.displacement_field(grid).displacement, grid, file)
    warp = sitk.DisplacementFieldTransform(sitk.ReadImage(str(file), sitk.sitkVectorFloat64))
theirs = sitk.GetArrayFromImage(sitk.Resample(head, head, warp, sitk.sitkLinear))
(ours,) = d.resample([sitk.GetArrayFromImage(head)], Sampling(grid))

plotter = pv.Plotter(shape=(1, 4), border=False, window_size=(1600, 500))
before = sitk.GetArrayFromImage(head)
difference = np.abs(theirs - ours)
titles = ("at rest", "vtk_mls", "ITK, by the field", "10 x their difference")
for column, (title, volume) in enumerate(zip(titles, (before, ours, theirs, 10 * difference))):
    plotter.subplot(0, column)
    rows = volume[55, ::-1, ::-1]  # seen from above, the nose up
    image = pv.ImageData(dimensions=(*rows.T.shape, 1))
    image["T1"] = rows[:, ::-1].ravel()
    plotter.add_mesh(image, cmap="gray", clim=(0, 230), show_scalar_bar=False)
    plotter.add_text(title, font_size=12, position="upper_edge")
    plotter.view_xy()
    plotter.camera.zoom(1.3)
plotter.screenshot("field_for_itk.png")

# at the border ITK asks half a voxel less far than we do
inside = difference[3:-3, 3:-3, 3:-3]
mean, most = inside.mean(), inside.max()
print(f"ITK and vtk_mls differ by {mean:.4f} on average and {most:.2f} at most, of 255")
assert mean < 0.01
