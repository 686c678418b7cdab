"""A whole turn
============

The ends of a turn by 360 degrees are where they began, so p and q do not tell it from no turn. The
array "Path" of the control points says where they are on the way, and the deformation goes through
these places in small steps. None of them folds.

You will see a bar, its handles moved to their ends at once, and the same by a path, in colors of
the determinant of the Jacobian: it is the change of volume, and below 0 the bar is inside out. The
end checks that nothing folds and that the cells keep their volume.
"""

import numpy as np
import pyvista as pv

import vtk_mls.pyvista  # noqa: F401  (not needed where vtk_mls is installed)

LEGS = 24
bar = pv.ImageData(dimensions=(21, 21, 61), spacing=(0.1, 0.1, 0.1), origin=(-1, -1, 0))
bar = bar.cast_to_structured_grid()

levels = np.linspace(0, 6, 4)
sides = [(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)]
rest = np.array([(x, y, z) for z in levels for x, y in sides], float)


def turned(share):
    """The handles after a share of the turn, which grows from the bottom to the top."""
    angle = 2 * np.pi * share * rest[:, 2] / 6
    x, y = rest[:, 0], rest[:, 1]
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * x - s * y, s * x + c * y, rest[:, 2]])


at_once, by_path = pv.PolyData(rest), pv.PolyData(rest)
places = [turned(k / LEGS) - rest for k in range(1, LEGS)]
for handles in (at_once, by_path):
    handles["Displacement"] = turned(1) - rest
by_path["Path"] = np.hstack(places)

bars = {"a bar": bar}
for title, handles in (("p and q alone", at_once), ("with a path", by_path)):
    bars[title] = bar.mls.deform(handles, generate_jacobian_determinant=True)
bar["JacobianDeterminant"] = np.ones(bar.n_points)

plotter = pv.Plotter(shape=(1, 3), border=False, window_size=(1200, 760))
look = {"cmap": "PuOr", "clim": (0, 2), "below_color": "red", "show_scalar_bar": False}
points = {"color": "black", "point_size": 9, "render_points_as_spheres": True}
for column, (title, mesh) in enumerate(bars.items()):
    plotter.subplot(0, column)
    surface = mesh.extract_surface(algorithm=None)
    plotter.add_mesh(surface, scalars="JacobianDeterminant", **look)
    edges = surface.extract_feature_edges(30, boundary_edges=False)
    plotter.add_mesh(edges, color="#333333", line_width=2)
    plotter.add_points(rest if column == 0 else turned(1), **points)
    plotter.add_text(title, font_size=15, color="#334155", position="upper_edge")
    plotter.camera_position = [(14, -22, 9), (0, 0, 3), (0, 0, 1)]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 4.2
plotter.screenshot("whole_turn.png")

for title in ("p and q alone", "with a path"):
    least = np.nanmin(bars[title]["JacobianDeterminant"])
    lost = bars[title].field_data["FailedInverses"][0]
    print(f"{title}: determinants from {least:.2f}, {lost} points without a place")
turn = bars["with a path"]
volumes = turn.compute_cell_sizes()["Volume"] / bar.compute_cell_sizes()["Volume"]
print(f"cells of the turned bar have {volumes.min():.2f} to {volumes.max():.2f} of their volume")
assert np.nanmin(bars["p and q alone"]["JacobianDeterminant"]) < 0
assert turn["JacobianDeterminant"].min() > 0.1
assert volumes.min() > 0.1
