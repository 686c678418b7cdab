"""A mesh and an image in PyVista
==============================

Bend a mesh and an image of the same ball by the same handles in PyVista.

You will see the ball at rest, and the deformed surface with contours of the deformed image in it.
The end checks that on the moved surface the moved image still says how far its middle was.

Run: python examples/pyvista_deform.py [picture.png]

In a window of yours, `plotter.mls.edit([image, mesh])` in place of `rest` and `deformed` lets you
drag the handles by the mouse.
"""

import sys

import numpy as np
import pyvista as pv

import vtk_mls.pyvista  # noqa: F401  (not needed where vtk_mls is installed)

picture = sys.argv[1] if len(sys.argv) > 1 else "pyvista.png"
if not picture.endswith(".png"):
    sys.exit(f"the picture must be a .png file, got `{picture}`")

# a ball of radius 20, as the distance from its middle and as its surface
image = pv.ImageData(dimensions=(81, 81, 61), origin=(-40, -40, -30))
image["distance"] = np.linalg.norm(image.points, axis=1)
mesh = pv.Sphere(radius=20, theta_resolution=60, phi_resolution=60)

# the six ends of its axes, two of which are dragged
rest = 20.0 * np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
deformed = rest.copy()
deformed[0] += (10, 8, 0)
deformed[1] += (-10, 8, 0)

bent_image = image.mls.deform(rest, deformed, kind="rigid", background=100)
bent_mesh = mesh.mls.deform(rest, deformed, kind="rigid")

plotter = pv.Plotter(off_screen=True, shape=(1, 2), window_size=(900, 400))
plotter.add_mesh(mesh, color="lightsteelblue", opacity=0.5)
plotter.add_points(rest, color="orange", point_size=12, render_points_as_spheres=True)
plotter.add_text("at rest", font_size=8, position=(10, 370))
plotter.subplot(0, 1)
plotter.add_mesh(bent_mesh, color="lightsteelblue", opacity=0.5)
middle = bent_image.slice("z")
plotter.add_mesh(middle.contour([8, 12, 16, 20]), color="crimson", line_width=3)
plotter.add_points(deformed, color="orange", point_size=12, render_points_as_spheres=True)
plotter.add_text("deformed: surface, and contours of the image", font_size=8, position=(10, 370))
plotter.link_views()
plotter.view_vector((0.2, -0.6, 1))
plotter.screenshot(picture)

# both stay registered: on the moved surface the moved image still says 20
said = bent_mesh.sample(bent_image)["distance"]
print(f"distance on the deformed surface: {said.min():.2f} to {said.max():.2f}, 20 at rest")
assert np.abs(said - 20).max() < 0.1
