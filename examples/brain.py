"""A brain, cut open
=================

Half a plane cuts a brain from above, between front and back, and both halves are turned outward by
35 degrees.

You will see the brain before and after: the face of the cut shows the tissue that it went through.
The end checks that the volume of the tissue is kept.

The brain is the ICBM 152 average that nilearn's package carries.
"""

import numpy as np
import pyvista as pv

import vtk_mls.pyvista  # noqa: F401  (not needed where vtk_mls is installed)
from vtk_mls import HalfPlane
from vtk_mls.commands import demo

# In millimetres of the file: x to the right, y to the front, z up.
brain = pv.read(demo.brain_file()).gaussian_smooth(std_dev=0.8)
tissue, middle = brain.active_scalars_name, np.array(brain.center)

# From the middle, on one side of the head; the other side has the same.
front = [(59, 9, 21), (14, 9, 55), (61, 30, 8), (52, 59, -6), (27, 61, 23)]
back = [(59, -5, 22), (19, -5, 56), (67, -28, 9), (54, -57, -2), (29, -62, 26)]
below = [(59, 26, -41), (65, -30, -43), (15, -3, -58), (37, -64, -69), (29, 55, -43)]
front, back, below = (
    np.vstack([points, np.array(points) * (-1, 1, 1)]) for points in (front, back, below)
)
edge = np.array([0, 2, -36])


def rotated(points, degrees):
    """Points, rotated about the edge of the cut."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return edge + (points - edge) @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


rest = middle + np.vstack([front, back, below])
deformed = middle + np.vstack([rotated(front, -35), rotated(back, 35), below])
cut = HalfPlane(middle + edge, normal=(0, 1, 0), inward=(0, 0, 1))
# each half turns as a whole, so handles far away count, too: alpha 1
opened = brain.mls.deform(
    *(rest, deformed),
    alpha=1,
    cuts=[cut],
    hide_void=False,
    void_values="continued",
    output_grid="fitted",
)

skin = opened.contour([105], scalars=tissue)
outside = skin.clip_scalar(scalars="VoidDistance", value=0, invert=False)
face = opened.contour([0], scalars="VoidDistance")
face = face.clip_scalar(scalars=tissue, value=105, invert=False)

plotter = pv.Plotter(shape=(1, 2), border=False, window_size=(1500, 720))
look = {"color": "#dba898", "smooth_shading": True, "specular": 0.2, "ambient": 0.2}
plotter.add_mesh(brain.contour([105], scalars=tissue), **look)
plotter.add_points(rest, color="darkorange", point_size=13, render_points_as_spheres=True)
plotter.subplot(0, 1)
plotter.add_mesh(outside, **look)
pinks = ["#40100f", "#6b1d1c", "#b86b61", "#db9e8c", "#faedde"]
plotter.add_mesh(face, scalars=tissue, cmap=pinks, clim=(30, 240), show_scalar_bar=False)
plotter.add_points(deformed, color="darkorange", point_size=13, render_points_as_spheres=True)
plotter.link_views()
plotter.camera_position = [middle + (420, 90, 440), middle + (0, 0, 2), (0, 0, 1)]
plotter.camera.zoom(1.35)
plotter.screenshot("brain.png")

# rigid maps keep sizes: what is tissue now is nearly as much as before
solid = opened[tissue][opened.point_data["Void"] == 0]
share = np.sum(solid > 105) / np.sum(brain[tissue] > 105)
print(f"The tissue's volume is {share:.1%} of what it was")
assert abs(share - 1) < 0.1
