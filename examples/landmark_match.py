"""A brain, matched by landmarks
=============================

A brain is matched to a subject by 28 pairs of landmarks, as one clicks them: on edges of the image,
far from each other, also at the rim of the brain.

You will see the brain, the subject, and their difference before and after the match. The subject is
the same brain, warped by a B-spline of SimpleITK, so the true partner of every point is known. The
end checks that the error becomes smaller everywhere, not only at the landmarks.

The brain is the ICBM 152 average that nilearn's package carries.
"""

import numpy as np
import pyvista as pv
import SimpleITK as sitk
from matplotlib.colors import LinearSegmentedColormap

from vtk_mls import Deformation, Grid, landmarks
from vtk_mls.commands import demo

brain = sitk.ReadImage(str(demo.brain_file()), sitk.sitkFloat32)
warp = sitk.BSplineTransformInitializer(brain, [2, 2, 2])
rng = np.random.default_rng(5)
warp.SetParameters((14 * rng.standard_normal(len(warp.GetParameters()))).tolist())
subject = sitk.Resample(brain, brain, warp, sitk.sitkLinear, 0.0)
grid = Grid(
    brain.GetSize(), brain.GetOrigin(), brain.GetSpacing(), np.reshape(brain.GetDirection(), (3, 3))
)
values, target = (sitk.GetArrayFromImage(image) for image in (brain, subject))


def partners(points):
    """The places on the brain (n, 3) of points on the subject."""
    return np.array([warp.TransformPoint(point) for point in points.tolist()])


def spread(points, count):
    """Points that are far from each other, beginning with the one farthest from the middle."""
    chosen, distance = [], np.linalg.norm(points - points.mean(axis=0), axis=1)
    for _ in range(count):
        chosen.append(points[distance.argmax()])
        away = np.linalg.norm(points - chosen[-1], axis=1)
        distance = away if len(chosen) == 1 else np.minimum(distance, away)
    return np.array(chosen)


# Edges of the image every 4 mm. A hand is 1 mm off; the images correct it.
smooth = sitk.GradientMagnitudeRecursiveGaussian(subject, 1.5)
strength = sitk.GetArrayFromImage(smooth)[::4, ::4, ::4]
tissue = target[::4, ::4, ::4] > 0.15 * target.max()
is_edge = tissue & (strength > np.quantile(strength[tissue], 0.8))
inside = grid.at(4 * np.argwhere(tissue)[:, ::-1])
q = spread(grid.at(4 * np.argwhere(is_edge)[:, ::-1]), 28)
p = partners(q)
clicked = q + rng.normal(0, 0.6, q.shape)
moving, fixed = (landmarks.Image(array, grid) for array in (values, target))
refined = landmarks.refine(moving, fixed, p, clicked).deformed

# The pairs themselves tell which map predicts them best.
options = landmarks.report(p, refined).recommended.options
d = Deformation(p, refined, **options)
(matched,) = d.resample([values], grid)

# Slices, in the axes of the grid: across, and from the side.
differences = LinearSegmentedColormap.from_list("", ["#6fc7ff", "#12161f", "orange"])
gray = {"cmap": "gray", "clim": (0, 0.9 * values.max())}
difference = {"cmap": differences, "clim": (-0.5 * values.max(), 0.5 * values.max())}
shown = {
    "a brain": (values, gray, p),
    "the subject": (target, gray, refined),
    "difference": (values - target, difference, None),
    "matched by 28 pairs": (matched - target, difference, None),
}
plotter = pv.Plotter(shape=(2, 4), border=False, window_size=(1500, 760))
for column, (title, (array, colors, points)) in enumerate(shown.items()):
    volume = pv.ImageData(dimensions=grid.dimensions, spacing=grid.spacing)
    volume["values"] = array.ravel()
    middle = np.array(volume.center)
    for row, (axis, up) in enumerate((("z", (0, -1, 0)), ("x", (0, 0, 1)))):
        plotter.subplot(row, column)
        plotter.set_background("#12161f")
        normal = np.array([axis == "x", 0, axis == "z"], float)
        plane = volume.slice(normal, origin=middle)
        plotter.add_mesh(plane, lighting=False, show_scalar_bar=False, **colors)
        if points is not None:
            places = grid.index_of(points) * grid.spacing
            ahead = places + (60 - (places - middle) @ normal)[:, None] * normal
            look = {"color": "orange", "point_size": 9, "render_points_as_spheres": True}
            plotter.add_points(ahead, **look)
        if row == 0:
            plotter.add_text(title, font_size=13, color="white", position="upper_edge")
        plotter.camera_position = [middle + 500 * normal, middle, up]
        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = 137
plotter.screenshot("landmark_match.png")

# The distance of every 4th voxel of the tissue to its true partner.
before, after = (
    np.linalg.norm(places - partners(inside), axis=1) for places in (inside, d.backward(inside))
)
for name, errors in (("before", before), ("after", after)):
    print(f"{name}: {np.median(errors):.1f} mm from the true partner, {errors.max():.1f} at most")
print(f"smaller at {np.mean(after < before):.1%} of the places")
assert np.median(after) < 0.15 * np.median(before)
assert after.max() < 0.3 * before.max()
