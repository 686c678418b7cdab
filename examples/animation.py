"""A frog swims
============

Handles that move in time make an animation: of each picture only the positions of the control
points differ. The frog's surface is made once, and each pose is one call.

You will see its legs and arms strike once and come back. The end checks that the exact inverse
leads back to where each point was.
"""

import numpy as np
import pyvista as pv
from PIL import Image

import vtk_mls.pyvista

volume = pv.examples.load_frog_tissues().extract_subset((0, 499, 0, 469, 0, 135), rate=(3, 3, 2))
frog = volume.contour_labels(scalars=volume.active_scalars_name, output_mesh_type="triangles")
frog["tissue"] = frog["boundary_labels"]

body = [(470, 227, 35), (390, 227, 21), (311, 158, 39), (311, 308, 44), (241, 229, 117)]
arms = [(241, 87, 96), (237, 371, 102), (305, 79, 162), (300, 388, 170)]
legs = [(178, 38, 162), (178, 431, 168), (41, 90, 176), (38, 375, 160)]
still = [(170, 229, 96), (85, 229, 158)]
rest = np.array([*body, *arms, *legs, *still], float)


def pose(time):
    """Control points at a time from 0 to 1: a stroke of the legs and one of the arms."""
    stroke = 0.5 - 0.5 * np.cos(2 * np.pi * time)
    wave = np.sin(2 * np.pi * time)
    points = rest.copy()
    outward = np.sign(rest[:, 1] - 227)
    points[5:7, 0] += 45 * stroke  # elbows
    points[7:9] += np.outer([1, 1], (110 * stroke, 0, 0))  # hands
    points[7:9, 1] -= 30 * stroke * outward[7:9]
    points[9:11] += np.outer([1, 1], (-40 * stroke, 0, 0))  # knees
    points[9:11, 1] -= 45 * stroke * outward[9:11]
    points[11:13, 0] -= 130 * stroke  # heels
    points[11:13, 1] -= 40 * stroke * outward[11:13]
    points[0, 1] += 25 * wave  # snout
    return points


plotter = pv.Plotter(window_size=(520, 640))
moving = frog.copy()
look = {"cmap": "Set2", "clim": (1, 15), "show_scalar_bar": False}
plotter.add_mesh(moving, scalars="tissue", smooth_shading=False, **look)
plotter.camera_position = [(200, 235, -1500), (200, 235, 90), (1, 0, 0)]
plotter.camera.parallel_projection = True
plotter.camera.parallel_scale = 330
plotter.show(auto_close=False)
pictures = []
for time in np.linspace(0, 1, 24, endpoint=False):
    moving.points = frog.mls.deform(rest, pose(time), kind="rigid").points
    plotter.render()
    picture = plotter.screenshot(return_img=True)
    pictures.append(Image.fromarray(picture).quantize(64))
pictures[0].save("animation.gif", save_all=True, append_images=pictures[1:], duration=60, loop=0)

d = vtk_mls.Deformation(rest, pose(0.5), kind="rigid")
there_and_back = d.backward(d.forward(frog.points[::200]))
error = np.nanmax(np.abs(there_and_back - frog.points[::200]))
print(f"{frog.n_points} points, {len(pictures)} pictures; there and back within {error:.1e} voxels")
assert error < 1e-2
