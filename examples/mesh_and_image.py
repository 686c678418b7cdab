"""Image and mesh as one
=====================

Bend and cut a tetrahedral mesh and an image of the same thing by the same handles.

You will see a slice of the opened image with the cells of the opened mesh over it: they end where
the image ends. A mesh moves by the exact inverse of the map that resamples images, so both stay
together; the end checks that at random places they have the same values.
"""

import numpy as np
import pyvista as pv

import vtk_mls.pyvista

SIZE = 40

image = pv.Wavelet(extent=(0, SIZE) * 3, center=(SIZE / 2,) * 3)
mesh = pv.ImageData(dimensions=(SIZE + 1,) * 3).to_tetrahedra(12).sample(image)

# Two halves are turned away from each other above the edge of the cut; the lower end stays.
edge, angle = np.array([19.7, 20.0, 14.0]), np.radians(25)
rest = np.array([(x, y, z) for x in (4, 15, 25, 36) for y in (5, 35) for z in (22, 36)], float)
below = np.array([(x, y, 3) for x in (4, 20, 36) for y in (5, 35)], float)
x, y, z = (rest - edge).T
c, s = np.cos(angle), np.sin(angle) * np.sign(x)
turned = edge + np.stack([c * x + s * z, y, c * z - s * x], axis=1)

handles = np.vstack([rest, below]), np.vstack([turned, below])
cut = vtk_mls.HalfPlane(edge, normal=(1, 0, 0), inward=(0, 0, 1))
bent_image = image.mls.deform(*handles, cuts=[cut], output_grid="fitted")
bent_mesh = mesh.mls.deform(*handles, cuts=[cut])

slice_of_image = bent_image.slice("y", origin=(0, SIZE / 2, 0))
slice_of_mesh = bent_mesh.slice("y", origin=(0, SIZE / 2, 0), generate_triangles=False)
plotter = pv.Plotter(off_screen=True, window_size=(1200, 900))
plotter.background_color = "black"
plotter.add_mesh(slice_of_image, scalars="RTData", cmap="gray", show_scalar_bar=False)
plotter.add_mesh(slice_of_mesh, color="orange", style="wireframe", opacity=0.6, lighting=False)
plotter.camera_position = "xz"
plotter.camera.zoom(1.5)
plotter.screenshot("mesh_and_image.png")

places = pv.PolyData(np.random.default_rng(1).uniform(1, SIZE - 1, (10_000, 3)))
found = [places.sample(data) for data in (bent_image, bent_mesh)]
valid = np.logical_and(*(sampled["vtkValidPointMask"] > 0 for sampled in found))
first, second = (sampled["RTData"][valid] for sampled in found)
mean = np.abs(first - second).mean() / np.ptp(first)
lost = bent_mesh.field_data["FailedInverses"][0]
print(f"{bent_mesh.n_cells} tetrahedra; {lost} of {bent_mesh.n_points} points lost")
print(f"At {valid.sum()} places inside of both they differ by {mean:.2%} of the values' range")
assert valid.sum() > 3000
assert mean < 0.01
