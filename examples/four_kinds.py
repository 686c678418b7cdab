"""One of 15 handles, four kinds
================================

The paper's first figure: one of 15 control points is moved, the frog's snout, and the others stay.
All kinds move the head and leave the legs where they are; look at the eyes to tell them apart.
Affine shears the head, similarity and rigid turn it, and a polynomial of degree 2, which has more
freedom between so few control points, also squeezes it.

You will see the frog at rest, and by each kind. The end checks that the control points arrive. The
volume is the segmented frog of PyVista's package; its labels are carried to the nearest voxel.
"""

import numpy as np
import pyvista as pv

import vtk_mls.pyvista

frog = pv.examples.load_frog_tissues().extract_subset((0, 499, 0, 469, 0, 135), rate=(2, 2, 2))
name = frog.active_scalars_name
rest = np.array(
    [
        *[(470, 227, 35), (390, 227, 21), (311, 158, 39), (311, 308, 44), (241, 87, 96)],
        *[(237, 371, 102), (305, 79, 162), (300, 388, 170), (241, 229, 117), (170, 229, 96)],
        *[(85, 229, 158), (178, 38, 162), (178, 431, 168), (41, 90, 176), (38, 375, 160)],
    ],
    float,
)
deformed = rest.copy()
deformed[0] += (-8, 75, 0)

kinds = ("affine", "similarity", "rigid", "polynomial")
given = {
    "output_grid": "given",
    "output_origin": (-40, -40, -30),
    "output_spacing": (2, 2, 3),
    "output_dimensions": (290, 290, 85),
}
shown = {"at rest": frog}
for kind in kinds:
    shown[kind] = frog.mls.deform(rest, deformed, kind=kind, label_arrays=[name], **given)

plotter = pv.Plotter(shape=(1, 5), border=False, window_size=(2000, 590))
for column, (title, volume) in enumerate(shown.items()):
    plotter.subplot(0, column)
    tissues = volume.contour_labels(scalars=name, smoothing_iterations=8)
    plotter.add_mesh(
        tissues,
        scalars="boundary_labels",
        component=0,
        cmap="Set2",
        clim=(1, 15),
        show_scalar_bar=False,
        smooth_shading=True,
    )
    handles = rest if title == "at rest" else deformed
    for points, color in ((handles[:1], "darkorange"), (handles[1:], "royalblue")):
        plotter.add_points(points, color=color, point_size=15, render_points_as_spheres=True)
    plotter.add_text(title, font_size=16, position="upper_edge")
    plotter.camera_position = [(250, 235, -1500), (250, 235, 90), (1, 0, 0)]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 325
plotter.screenshot("four_kinds.png")

# every kind carries the control point exactly to where it was dragged
for kind in kinds:
    d = vtk_mls.Deformation(rest, deformed, kind=kind)
    error = np.abs(d.backward(deformed) - rest).max()
    print(f"{kind:10}: control points arrive within {error:.1e} of a voxel")
    assert error < 1e-3
