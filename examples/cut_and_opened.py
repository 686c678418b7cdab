"""Cut and opened
==============

The paper's second figure: half a plane cuts a body from above, and rigid maps pull both sides
apart. Control points do not act through the cut, and where it opens there is nothing.

You will see a ball of layers with the plane, and then opened: the faces of the cut show what was
inside. The end checks that they are where the distance from the void is 0.
"""

import numpy as np
import pyvista as pv

import vtk_mls.pyvista
from vtk_mls import HalfPlane

ball = pv.ImageData(dimensions=(131, 111, 121), origin=(-65, -55, -55))
ball["radius"] = np.linalg.norm(ball.points, axis=1).astype(np.float32)

# Both halves are rotated outward about the edge of the cut, the lower part stays.
edge, angle = np.array([0.2, 0, -25]), np.radians(28)
rest = np.array([(x, y, z) for x in (-36, -14, 14, 36) for y in (-25, 25) for z in (-5, 30)], float)
below = np.array([(x, y, -42) for x in (-20, 0, 20) for y in (-15, 15)], float)
x, y, z = (rest - edge).T
c, s = np.cos(angle), np.sin(angle) * np.sign(x)
rotated = edge + np.stack([c * x + s * z, y, c * z - s * x], axis=1)
rest, deformed = np.vstack([rest, below]), np.vstack([rotated, below])
cut = HalfPlane(edge, normal=(1, 0, 0), inward=(0, 0, 1))

# The void is kept, with values continued behind its face, so that contours and clips are smooth.
opened = ball.mls.deform(
    rest,
    deformed,
    cuts=[cut],
    kind="rigid",
    hide_void=False,
    void_values="continued",
    background=100,
)
outside = opened.contour([50], scalars="radius").clip_scalar(
    scalars="VoidDistance", value=0, invert=False
)
face = opened.contour([0], scalars="VoidDistance").clip_scalar(scalars="radius", value=50)

sheet = pv.Plane(center=(0.2, 0, 15), direction=(1, 0, 0), i_size=80, j_size=120)
plotter = pv.Plotter(shape=(1, 2), border=False, window_size=(1400, 700))
layers = {"scalars": "radius", "cmap": "RdYlBu", "clim": (0, 55), "show_scalar_bar": False}
skin = {"color": "steelblue", "smooth_shading": True, "specular": 0.3}
plotter.add_mesh(ball.contour([50], scalars="radius"), **skin)
plotter.add_mesh(sheet, color="orange", opacity=0.4)
plotter.add_points(rest, color="darkorange", point_size=14, render_points_as_spheres=True)
plotter.subplot(0, 1)
plotter.add_mesh(outside, **skin)
plotter.add_mesh(face, n_colors=9, ambient=0.3, **layers)
plotter.add_points(deformed, color="darkorange", point_size=14, render_points_as_spheres=True)
plotter.link_views()
plotter.camera_position = [(105, -215, 165), (0, 0, 0), (0, 0, 1)]
plotter.screenshot("cut_and_opened.png")

d = vtk_mls.Deformation(rest, deformed, cuts=[cut])
off = np.abs(d.void_distance(face.points))[face.points[:, 2] > -20].max()
print(f"{opened['Void'].mean():.1%} of the grid is void; its face is found within {off:.3f} voxels")
assert off < 0.2
