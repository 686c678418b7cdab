"""One drag, alpha 1 and 2
=======================

The weight of a handle is 1 / distance^(2 alpha). In space a shell of handles at distance r has
about r^2 of them. With alpha 1 all shells count alike, and a dragged handle is a spike. With alpha
2, the default, it takes along what is near.

You will see the middle layer of a block of 27 handles with spacing 1 after the middle handle was
dragged by 0.5, with alpha 1 and 2. The end checks where half of the drag is left.
"""

import numpy as np
import pyvista as pv

from vtk_mls import Deformation

rest = np.array([(x, y, z) for z in (-1, 0, 1) for y in (-1, 0, 1) for x in (-1, 0, 1)], float)
deformed = rest.copy()
deformed[13] += (0, 0, 0.5)  # the middle
layer = pv.Plane(i_size=2.4, j_size=2.4, i_resolution=240, j_resolution=240)

deformations = {
    "alpha 1": Deformation(rest, deformed, alpha=1),
    "alpha 2": Deformation(rest, deformed),
}
above = (0, 0, 0.006)  # where they can be seen
plotter = pv.Plotter(shape=(1, 2), border=False, window_size=(1400, 480))
for column, (title, d) in enumerate(deformations.items()):
    lifted = layer.copy()
    lifted.points = d.forward(layer.points)
    nodes = lifted.points.reshape(241, 241, 3)
    rows = nodes[::10], nodes[:, ::10]
    lines = [pv.MultipleLines(line + above) for line in (*rows[0], *rows[1].swapaxes(0, 1))]
    plotter.subplot(0, column)
    lifted = lifted.compute_normals()
    plotter.add_mesh(lifted, color="#9db4cc", smooth_shading=True, specular=0.3, ambient=0.15)
    plotter.add_mesh(pv.merge(lines), color="#2b3a4d", line_width=1.5, lighting=False)
    handles = d.deformed[9:18]
    for points, color in ((handles[4:5], "darkorange"), (np.delete(handles, 4, 0), "royalblue")):
        plotter.add_points(points, color=color, point_size=18, render_points_as_spheres=True)
    plotter.add_text(title, font_size=15, position="upper_edge", color="#334155")
    plotter.camera_position = [(1.6, -3.9, 2.5), (0, 0, 0), (0, 0, 1)]
    plotter.camera.zoom(1.33)
plotter.screenshot("local_drag.png")

# the largest distance at which half of the drag is left
distances = np.linspace(0, 1, 2001)
start = np.column_stack([distances, np.zeros((2001, 2))])
half = {}
for title in ("alpha 1", "alpha 2"):
    height = deformations[title].forward(start)[:, 2]
    half[title] = distances[np.argmax(height < 0.25)]
    print(f"{title}: half of the drag is left at {half[title]:.2f} of the spacing")
assert half["alpha 1"] < 0.25
assert half["alpha 2"] > 0.4
