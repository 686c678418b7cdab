"""A brain, the same brain warped by a B-spline of SimpleITK, and a user who matches them."""

from __future__ import annotations

import numpy as np
from opened_brain import NAME, copy_to
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkRenderWindow
from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

from vtk_mls import Deformation, io
from vtk_mls.editor import Editor, State
from vtk_mls.editor.matching.pairs import MOVING, TARGET, with_pair
from vtk_mls.editor.slices import SLICES
from vtk_mls.files import control_point_files

SUBJECT = "subject.nii.gz"
MOST_ACTIONS = 25  # of a new user, with the command; fewer are allowed
_SEED, _STRENGTH = 5, 14.0  # mm, of the coefficients of the B-spline
_SPACING = 12  # mm, of the held-out points; voxels are 1 mm
# Places on the brain (LPS, mm) that are seen well in slices across these axes: the front of the
# corpus callosum, both insulas at the back, a temporal pole, the cerebellum.
_PLACES = (
    (0, (-0.5, -31.9, 1.9)),
    (0, (-35.5, 33.0, 19.1)),
    (0, (36.5, 30.0, 19.1)),
    (0, (41.2, -25.5, -32.9)),
    (2, (-22.0, 62.0, -36.0)),
)
_FREE_PIXELS = 14  # around handles: a press there moves slices


class WarpedBrain:
    """The brain and the subject in a folder.

    Parameters
    ----------
    folder : Path
        Gets both files.

    Attributes
    ----------
    held_out : (n, 3) LPS
        Points of the subject's tissue, on a regular grid.
    """

    def __init__(self, folder):
        import SimpleITK as sitk

        self._folder = folder
        copy_to(folder)
        brain = sitk.ReadImage(str(folder / NAME))
        self._warp = sitk.BSplineTransformInitializer(brain, [2, 2, 2])
        rng, count = np.random.default_rng(_SEED), len(self._warp.GetParameters())
        self._warp.SetParameters((_STRENGTH * rng.standard_normal(count)).tolist())
        subject = sitk.Resample(brain, brain, self._warp, sitk.sitkLinear, 0.0)
        sitk.WriteImage(subject, str(folder / SUBJECT))
        tissue = sitk.GetArrayViewFromImage(subject)[::_SPACING, ::_SPACING, ::_SPACING] > 0
        index = _SPACING * np.argwhere(tissue)[:, ::-1]
        places = [subject.TransformIndexToPhysicalPoint(i) for i in index.tolist()]
        self.held_out = np.array(places)

    def on_brain(self, points):
        """The partners on the brain of points (n, 3) on the subject."""
        return np.array([self._warp.TransformPoint(point) for point in np.array(points).tolist()])

    def on_subject(self, points):
        """The partners on the subject of points (n, 3) on the brain."""
        places = np.array(points, float)
        for _ in range(50):
            places += points - self.on_brain(places)
        return places

    def datasets(self):
        """The brain and the subject."""
        return [io.read_dataset(self._folder / name) for name in (NAME, SUBJECT)]

    def errors(self, rest, deformed):
        """Median errors at the held-out points, mm: without a map, of an affine map, of ours."""
        q = self.held_out
        affine = np.linalg.lstsq(_homogeneous(deformed), rest, rcond=None)[0]
        deformation = Deformation(rest, deformed, "auto", device="reference")
        maps = q, _homogeneous(q) @ affine, deformation.backward(q)
        return [float(np.median(np.linalg.norm(p - self.on_brain(q), axis=1))) for p in maps]

    def check(self, saved):
        """The saved pairs halve the error at the held-out points."""
        rest, deformed, *_ = control_point_files.read_pairs(saved / "handles.csv")
        before, affine, after = self.errors(rest, deformed)
        print(f"held-out points: {before:.2f} mm, affine {affine:.2f} mm, now {after:.2f} mm")
        assert after < 0.5 * before
        assert (saved / "brain-deformed.nii.gz").exists()


class Walk:
    """Where a user presses the mouse for five pairs, in a picture of a size.

    Parameters
    ----------
    brain : WarpedBrain
    size : (width, height)
        Pixels of the picture.
    shows_one : bool
        Whether the page has no room for all slices: the user selects one of them.
    """

    def __init__(self, brain, size, shows_one=False):
        window, interactor = vtkRenderWindow(), vtkGenericRenderWindowInteractor()
        window.SetOffScreenRendering(True)
        window.SetSize(*size)
        interactor.SetRenderWindow(window)
        interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
        moving, target = brain.datasets()
        self._editor = Editor(interactor, moving, State([], []), target=target)
        slices = {MOVING: self._editor.slices, TARGET: self._editor.view.target.slices}
        self._panes = {(side, pane.axis): pane for side in slices for pane in slices[side]._panes}
        self._brain, self._height, self._shows_one = brain, size[1], shows_one
        self.state, self._point = State([], [], device="reference"), slices[MOVING].point.copy()

    def actions(self):
        """Yield ("drag", start, by) and ("click", pixel), from the upper left corner.

        If one slice is shown, ("pane", name) is before them.
        """
        for axis, place in _PLACES:
            place = np.array(place)
            on_subject = self._brain.on_subject(place[None])[0]
            if abs(on_subject - self._point)[axis] > 2:
                across = 1 if axis != 1 else 0
                yield from self._select(across)
                yield self._drag_to(on_subject, across)
            yield from self._select(axis)
            yield self._click(axis, on_subject)
            deformation = self.state.deformation()
            drawn = place if deformation is None else deformation.forward([place])[0]
            yield self._correct(axis, drawn)

    def _select(self, axis):
        """Show the slice across an axis alone, if there is no room for all."""
        if self._shows_one:
            self._editor.show_pane(SLICES[2 - axis])
            yield "pane", SLICES[2 - axis]

    def _drag_to(self, point, axis):
        """Move the slices on the target by a slice across an axis."""
        end = self._pixel(TARGET, axis, point)
        handles = self._panes[TARGET, axis].projection.pixels(self.state.deformed)[:, :2]
        starts = (end + offset for offset in ((40, 30), (-40, 30), (40, -30), (-40, -30)))
        start = next(
            start
            for start in starts
            if (np.linalg.norm(handles - start, axis=1) > _FREE_PIXELS).all()
        )
        self._point = self._place(TARGET, axis, end)
        (x, y), (x_end, y_end) = map(self._from_above, (start, end))
        return "drag", (x, y), (x_end - x, y_end - y)

    def _click(self, axis, point):
        """Place a landmark on the target."""
        pixel = self._pixel(TARGET, axis, point)
        self._point = place = self._place(TARGET, axis, pixel)
        self.state = with_pair(self.state, self._at_rest(place), place)
        return "click", self._from_above(pixel)

    def _correct(self, axis, point):
        """Drag the last landmark to its place on the data."""
        start, end = (self._pixel(MOVING, axis, x) for x in (self._point, point))
        row = len(self.state) - 1
        place = self._place(MOVING, axis, end)
        self.state = self.state.with_rest(row, self._at_rest(place))
        (x, y), (x_end, y_end) = map(self._from_above, (start, end))
        return "drag", (x, y), (x_end - x, y_end - y)

    def _at_rest(self, place):
        deformation = self.state.deformation()
        return place if deformation is None else deformation.backward([place])[0]

    def _pixel(self, side, axis, point):
        return np.rint(self._panes[side, axis].projection.pixels(np.array([point]))[0, :2])

    def _place(self, side, axis, pixel):
        """The point (3,) of a slice at a pixel, through the point of all slices."""
        near, far = self._panes[side, axis].projection.ray(pixel)
        return near + (self._point - near)[axis] / (far - near)[axis] * (far - near)

    def _from_above(self, pixel):
        return int(pixel[0]), int(self._height - 1 - pixel[1])


def _homogeneous(points):
    return np.c_[points, np.ones(len(points))]
