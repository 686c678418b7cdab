"""Thousands of handles
====================

Control points need not come from a mouse: here 3,000 of them lie at random in a box, as landmarks
of a registration would, and follow a wave. Their number costs time in proportion; nothing is
solved.

You will see the box, its layers and the control points at rest and after the wave. The end checks
how well points between them follow it.
"""

import time

import numpy as np
import pyvista as pv

import vtk_mls


def wave(points):
    """Where a known, smooth deformation carries points."""
    x, y, z = points.T
    lift = 5 * np.sin(x / 8) * np.cos(y / 8)
    return np.stack([x + 2 * np.sin(z / 10), y + 2 * np.sin(x / 12), z + lift], axis=1)


rest = np.random.default_rng(5).uniform(-32, 32, (3000, 3))
d = vtk_mls.Deformation(rest, wave(rest), kind="affine", alpha=2)

grid = pv.ImageData(dimensions=(49, 49, 33), spacing=(1, 1, 1), origin=(-24, -24, -16))
box = grid.cast_to_structured_grid()
box["layer"] = np.floor(box.points[:, 2] / 4) % 2
start = time.perf_counter()
moved = d.forward(box.points)
seconds = time.perf_counter() - start
error = np.linalg.norm(moved - wave(box.points), axis=1)
print(f"{box.n_points} points by {len(rest)} control points in {seconds:.1f} s")
print(f"They follow the wave to {error.mean():.3f} on average, where it is up to 5 high")

plotter = pv.Plotter(shape=(1, 2), border=False, window_size=(1400, 620))
for column, (points, handles) in enumerate(((box.points, rest), (moved, wave(rest)))):
    plotter.subplot(0, column)
    shown = box.copy()
    shown.points = points
    look = {"cmap": ["#3f88b5", "#f2d27a"], "ambient": 0.35, "show_scalar_bar": False}
    surface = shown.extract_surface(algorithm="dataset_surface")
    plotter.add_mesh(surface, scalars="layer", smooth_shading=True, **look)
    plotter.add_points(handles, color="black", point_size=2.5, opacity=0.5)
    plotter.camera_position = [(75, -105, 75), (0, 0, -3), (0, 0, 1)]
plotter.screenshot("many_handles.png")
assert error.mean() < 0.5
