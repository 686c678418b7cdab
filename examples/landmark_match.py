"""A brain, matched to another by landmarks
========================================

Twelve landmarks, placed by hand in two images of brains, are refined by the images and match one
brain to the other.

You will see a slice of the subject, and the difference of the atlas and the subject before and
after. The end checks places that are no landmarks.

The atlas is the ICBM 152 average that nilearn's package carries. The subject is the same brain,
warped by a spline of VTK, so that the true partner of each place is known.
"""

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform
from vtkmodules.vtkImagingCore import vtkImageReslice

import vtk_mls.pyvista  # noqa: F401  (not needed where vtk_mls is installed)
from vtk_mls import Deformation, Grid, landmarks
from vtk_mls.commands import demo

rng = np.random.default_rng(4)
# In millimetres of the file: x to the right, y to the front, z up.
brain = pv.read(demo.brain_file())
tissue, middle = brain.active_scalars_name, np.array(brain.center)


def as_vtk(points):
    result = vtkPoints()
    for point in points:
        result.InsertNextPoint(point)
    return result


# The warp takes places of the subject to those of the atlas: 27 nodes move by some 9 mm.
nodes = middle + 70 * np.stack(np.meshgrid(*[(-1, 0, 1)] * 3), axis=-1).reshape(-1, 3)
warp = vtkThinPlateSplineTransform()
warp.SetBasisToR()
warp.SetSourceLandmarks(as_vtk(nodes))
warp.SetTargetLandmarks(as_vtk(nodes + rng.normal(0, 5, nodes.shape)))
reslice = vtkImageReslice()
reslice.SetInputData(brain)
reslice.SetResliceTransform(warp)
reslice.SetInterpolationModeToLinear()
reslice.Update()
subject = pv.wrap(reslice.GetOutput())


def partners(points):
    """Places on the atlas of places on the subject."""
    return np.array([warp.TransformPoint(point) for point in points.tolist()])


# Landmarks on the subject, and where a user has clicked on it: some 1 mm beside them.
dx, dy, dz = np.array([(x, y, z) for x in (-32, 32) for y in (-45, 0, 40) for z in (-22, 28)]).T
q = middle + np.column_stack([dx, dy, dz])
p = partners(q)
clicked = q + rng.normal(0, 0.8, q.shape)
grid = Grid(brain.dimensions, brain.origin, brain.spacing)
images = [
    landmarks.Image(image[tissue].reshape(grid.shape).astype(float), grid)
    for image in (brain, subject)
]
refined = landmarks.refine(*images, p, clicked)
report = landmarks.report(p, refined.deformed)
matched = brain.mls.deform(p, refined.deformed, **report.recommended.options)

plotter = pv.Plotter(shape=(1, 3), border=False, window_size=(1500, 600))
signed = {"cmap": "RdBu", "clim": (-160, 160), "show_scalar_bar": False}
for column, (image, title) in enumerate(
    ((None, "subject"), (brain, "atlas - subject"), (matched, "matched - subject"))
):
    plotter.subplot(0, column)
    shown, look = subject.copy(), {"cmap": "gray", "show_scalar_bar": False}
    if image is not None:
        shown[tissue] = np.asarray(image[tissue], float) - subject[tissue]
        look = signed
    plotter.add_mesh(shown.slice("z", origin=middle + (0, 0, 5)), scalars=tissue, **look)
    plotter.add_text(title, font_size=14)
    plotter.view_xy()
    plotter.camera.zoom(1.35)
plotter.screenshot("landmark_match.png")

inside = [axis.ravel() for axis in np.meshgrid(*[np.arange(-40, 41, 16)] * 3)]
held_out = middle + np.column_stack(inside)
value = Deformation(p, refined.deformed, **report.recommended.options)
before, after = (
    np.median(np.linalg.norm(places - partners(held_out), axis=1))
    for places in (held_out, value.backward(held_out))
)
moved = sum(not reason for reason in refined.refused)
print(f"{moved} of {len(q)} landmarks refined; take {report.recommended.flags}")
print(f"{len(held_out)} other places: {before:.1f} mm before, {after:.1f} mm after")
assert after < 0.5 * before
