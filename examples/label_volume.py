"""Labels stay labels
==================

A segmentation must not be interpolated: between liver (10) and bone (13) there is no spleen. Label
arrays are taken from the nearest voxel; all others are interpolated. Files that say that they are
segmentations (.seg.nrrd, NIfTI with intent) need not be named.

You will see a slice at rest, deformed as labels, and deformed as numbers, with wrong labels at the
edges. The end checks that labels bring none that was not there before.
"""

import numpy as np
import pyvista as pv

import vtk_mls.pyvista  # noqa: F401  (not needed where vtk_mls is installed)

frog = pv.examples.load_frog_tissues().extract_subset((50, 449, 80, 379, 70, 109), rate=(2, 2, 1))
frog.rename_array(frog.active_scalars_name, "tissue")
low, high = np.array(frog.bounds).reshape(3, 2).T
corners = [
    (x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])
]
middle = (low + high) / 2
rest = np.array([*corners, middle])
deformed = rest.copy()
deformed[-1] += (60, 40, 0)

labels = frog.mls.deform(rest, deformed, kind="polynomial", label_arrays=["tissue"])
mixed = frog.mls.deform(rest, deformed, kind="polynomial")

plotter = pv.Plotter(shape=(1, 3), border=False, window_size=(1500, 520))
titles = {"at rest": frog, "deformed as labels": labels, "deformed as numbers: wrong": mixed}
for column, (title, volume) in enumerate(titles.items()):
    plotter.subplot(0, column)
    plane = volume.extract_subset((0, 199, 0, 149, 20, 20)).points_to_cells()
    tissues = plane.threshold(0.5, scalars="tissue")  # a color for each voxel, none mixed
    plotter.add_mesh(tissues, cmap="tab20", clim=(1, 20), lighting=False, show_scalar_bar=False)
    plotter.add_text(title, font_size=13, position="upper_edge")
    plotter.view_xy()
    plotter.camera.zoom(1.35)
plotter.screenshot("label_volume.png")

found = set(np.unique(labels["tissue"])) - set(np.unique(frog["tissue"]))
edge = (mixed["tissue"] != labels["tissue"]).mean()
print(
    f"Labels that were not there before: {len(found)}; interpolated, {edge:.1%} of voxels are wrong"
)
assert not found
assert edge > 0
