"""A cube in five columns
=======================

The paper's third figure: the same handle on top of a cube is pulled up. You will see, from left to
right, the cube at rest, and deformed by affine, similarity and rigid maps and by polynomials of
degree 2.

Affine maps stretch the cube, similarity widens its top, rigid keeps sizes and so makes a bump, and
polynomials bend it.
"""

import numpy as np
import pyvista as pv

import vtk_mls.pyvista  # noqa: F401  (not needed where vtk_mls is installed)

grid = pv.ImageData(dimensions=(33, 33, 33), spacing=(1 / 32,) * 3)
cube = grid.cast_to_unstructured_grid()
cells = np.floor(cube.cell_centers().points * 8).astype(int)
cube["tile"] = cells.sum(axis=1) % 2

# the corners, the middles of the sides, and the middle of the top, which is pulled
corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
middles = [(0.5, 0, 0.5), (0.5, 1, 0.5), (0, 0.5, 0.5), (1, 0.5, 0.5), (0.5, 0.5, 0), (0.5, 0.5, 1)]
rest = np.array([*corners, *middles])
deformed = rest.copy()
deformed[-1] += (0.2, 0, 0.4)

kinds = ("affine", "similarity", "rigid", "polynomial")
shown = {"at rest": cube} | {k: cube.mls.deform(rest, deformed, kind=k) for k in kinds}

plotter = pv.Plotter(shape=(1, 5), border=False, window_size=(2000, 560))
for column, (title, mesh) in enumerate(shown.items()):
    plotter.subplot(0, column)
    plotter.add_mesh(
        mesh.extract_surface(algorithm="dataset_surface"),
        scalars="tile",
        cmap=["#d9783d", "#f3e3d0"],
        show_scalar_bar=False,
        ambient=0.25,
    )
    handles = rest if title == "at rest" else deformed
    plotter.add_points(handles, color="royalblue", point_size=18, render_points_as_spheres=True)
    plotter.add_text(title, font_size=15, position="upper_edge")
    plotter.camera_position = [(2.6, -4.1, 2.6), (0.5, 0.5, 0.72), (0, 0, 1)]
    plotter.camera.zoom(1.25)
plotter.screenshot("cube_in_columns.png")

for kind in kinds:
    mesh = shown[kind]
    volume = mesh.compute_cell_sizes()["Volume"].sum()
    top = mesh.points[np.argmin(np.linalg.norm(cube.points - rest[-1], axis=1))]
    print(f"{kind:10}: the cube's volume is {volume:.2f} of what it was")
    assert np.abs(top - deformed[-1]).max() < 1e-3
