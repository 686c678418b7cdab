"""Tetrahedra, cut through
=======================

A ring of tetrahedra is cut through and bent open. Cells that the cut crosses are split exactly
along it, their points doubled, so that either end moves on its own.

You will see the ring, and the same bent open, in colors that say how well the cells have kept
their volume. The end checks that none is inside out.
"""

import numpy as np
import pyvista as pv
import tetgen

import vtk_mls.pyvista  # noqa: F401  (not needed where vtk_mls is installed)
from vtk_mls import HalfPlane

surface = pv.ParametricTorus(ringradius=10, crosssectionradius=3, u_res=90, v_res=36)
surface = surface.triangulate().clean()
mesher = tetgen.TetGen(surface)
mesher.tetrahedralize(switches="pq1.4a0.25Q")
ring = mesher.grid

# Around the ring eight stations of four control points each; the cut is at its left end.
angles = np.radians([-175, -140, -90, -40, 40, 90, 140, 175])
rest, deformed = [], []
for angle in angles:
    for out, up in ((8, -2), (12, -2), (8, 2), (12, 2)):
        rest.append((out * np.cos(angle), out * np.sin(angle), up))
        bent = 0.75 * angle  # of a ring that is wider, so that its middle line keeps its length
        radius = 10 / 0.75 + out - 10
        deformed.append((radius * np.cos(bent) - 3.3, radius * np.sin(bent), up))
cut = HalfPlane((0, 0, 0), normal=(0, 1, 0), inward=(-1, 0, 0))
opened = ring.mls.deform(
    *(rest, deformed),
    cuts=[cut],
    nu=8,
    kind="rigid",
    generate_jacobian_determinant=True,
)

before, after = (mesh.compute_cell_sizes()["Volume"] for mesh in (ring, opened))
plotter = pv.Plotter(shape=(1, 2), border=False, window_size=(1400, 620))
look = {"show_edges": True, "edge_color": "#404040", "line_width": 0.5, "show_scalar_bar": False}
ring["JacobianDeterminant"] = np.ones(ring.n_points)
for column, (mesh, handles) in enumerate(((ring, rest), (opened, deformed))):
    plotter.subplot(0, column)
    plotter.add_mesh(mesh, scalars="JacobianDeterminant", cmap="PuOr", clim=(0.6, 1.4), **look)
    plotter.add_points(
        np.array(handles), color="black", point_size=11, render_points_as_spheres=True
    )
    plotter.camera_position = [(-40, -34, 46), (1, 0, 0), (0, 0, 1)]
    plotter.camera.zoom(1.05)
plotter.screenshot("tetrahedra.png")

print(f"{ring.n_cells} tetrahedra, {opened.n_cells} after the cut, volume {after.sum():.0f}")
print(f"of {before.sum():.0f}; {opened.field_data['FailedInverses'][0]} points have no inverse")
assert opened.n_cells > ring.n_cells
assert after.min() > -1e-4
assert abs(after.sum() / before.sum() - 1) < 0.05
