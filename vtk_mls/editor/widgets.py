"""The widgets that the mouse drags: a flat cut, and a box that turns and moves a region."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPlane, vtkPolyData
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkContourFilter, vtkCutter
from vtkmodules.vtkInteractionWidgets import (
    vtkBoxRepresentation,
    vtkBoxWidget2,
    vtkImplicitPlaneRepresentation,
    vtkImplicitPlaneWidget2,
)

from vtk_mls import Plane
from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor import polydata
from vtk_mls.model.cuts import Obstacle
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import positions_of
from vtk_mls.vtk.objects import configured, output_of
from vtk_mls.vtk.transforms import matrix_of

_BLUE, _LIGHT_BLUE, _RED = (0.35, 0.75, 1.0), (0.8, 0.93, 1.0), (1.0, 0.45, 0.55)
_OPACITY, _GRABBED_OPACITY = 0.18, 0.35  # of the plane
# Of the plane of a cut with an edge: VTK does not pick an invisible plane.
_MIN_OPACITY, _GRABBED_MIN_OPACITY = 0.004, 0.06
_SHEET_OPACITIES = 0.3, 1.0  # of the sheet and its edge
_HIDDEN_OPACITIES = 0.1, 0.45  # likewise, behind the data
_EDGE_WIDTH = 4
_MARGIN = 0.1  # of the plane around the data, relative to their size
_LENGTH = 0.25  # of new cuts, relative to the data
_CELLS = 32  # along each axis of the box in which a sheet is drawn
_OFFSET = 0.01  # of the initial plane from the middle, where handles may be
_BOX_COLOR, _GRABBED_BOX_COLOR = (1.0, 0.78, 0.35), (1.0, 0.35, 0.45)
_BOX_WIDTH, _FACE_OPACITY = 2.5, 0.12  # of edges, and of the face that the mouse drags
_BOX_MARGIN = 0.08  # of the box around the region, relative to its longest side
_MIN_SIZE = 0.12  # of the box, relative to the data


class DragWidget:
    """A VTK widget that reports its value while the mouse drags it.

    `_shown` is None while there is nothing to show. A subclass defines `_value()`, the value at the
    position of the widget.
    """

    def __init__(self, interactor, renderer, widget, representation):
        self._interactor, self._renderer, self._widget = interactor, renderer, widget
        self._is_visible, self._is_dragged = True, False
        self._on_change = self._on_end = self._shown = None
        widget.SetInteractor(interactor)
        widget.SetRepresentation(representation)
        widget.KeyPressActivationOff()
        widget.AddObserver("StartInteractionEvent", self._start)
        widget.AddObserver("InteractionEvent", self._move)
        widget.AddObserver("EndInteractionEvent", self._end)

    def set_callbacks(self, on_change, on_end):
        """Call `on_change(value)` at each movement of the mouse, and `on_end()` after the last."""
        self._on_change, self._on_end = on_change, on_end

    def set_visible(self, is_visible):
        """Hide or show the widget."""
        self._is_visible = is_visible
        self._update()

    def finish(self):
        """Release the widget if the mouse drags it."""
        if self._is_dragged:
            # the widget receives mouse events until the button is released, even if disabled
            self._interactor.InvokeEvent("LeftButtonReleaseEvent")

    def detach(self):
        """Remove the widget from the view."""
        self.finish()
        self._widget.SetEnabled(False)
        self._widget.SetInteractor(None)

    def _start(self, widget, event):
        self._is_dragged = True

    def _move(self, widget, event):
        self._on_change(self._value())

    def _end(self, widget, event):
        self._is_dragged = False
        self._on_change(self._value())
        self._on_end()

    def _update(self):
        """Show or hide the widget; whether it is shown."""
        is_enabled = self._is_visible and self._shown is not None
        if is_enabled != bool(self._widget.GetEnabled()):
            # the widget forgets its renderer, and would take the one under the mouse
            self._widget.SetCurrentRenderer(self._renderer)
            self._widget.SetEnabled(is_enabled)
        return is_enabled


class CutWidget(DragWidget):
    """Lets the mouse move and tilt a flat cut in a `Scene`."""

    def __init__(self, interactor, scene):
        self._bounds = scene.bounds
        margin = _MARGIN / 2 * np.ptp(self._bounds, axis=0)
        self._sheet = EdgedSheet(scene, self._bounds + np.stack([-margin, margin]))
        self._plane = _plane_representation(self._bounds)
        super().__init__(interactor, scene.renderer, vtkImplicitPlaneWidget2(), self._plane)

    def show(self, cut):
        """Show a flat cut, or nothing for None."""
        self._shown = cut
        self._update()
        if cut is not None and self._is_visible:
            configured(self._plane, Origin=cut.point, Normal=cut.normal)
            self._draw_sheet(cut)

    def initial_cut(self, shape, previous):
        """A cut of a `shape`, in the place of the previous one, if there is one.

        Its first vector in the plane points up, its lengths are a quarter of the data.
        """
        camera = self._renderer.GetActiveCamera()
        plane = previous or self._initial_plane(camera)
        up = np.array(camera.GetViewUp())
        up = up - up @ plane.normal * plane.normal
        axis = _nearest_axis(up)
        is_in_plane = abs(axis @ plane.normal) < 0.9
        length = _LENGTH * np.ptp(self._bounds, axis=0).max()
        new = {"vector": axis if is_in_plane else up, "length": length}
        return shape(*(getattr(plane, f.name, new.get(f.kind)) for f in shape.fields))

    def _initial_plane(self, camera):
        """A plane near the middle of the data, seen edge-on."""
        viewing = np.subtract(camera.GetFocalPoint(), camera.GetPosition())
        normal = _nearest_axis(np.cross(viewing, camera.GetViewUp()))
        size = np.ptp(self._bounds, axis=0).max()
        return Plane(self._bounds.mean(axis=0) + _OFFSET * size * normal, normal)

    def _update(self):
        is_enabled = super()._update()
        self._sheet.set_visible(is_enabled and isinstance(self._shown, Obstacle))
        return is_enabled

    def _value(self):
        point, normal = np.array(self._plane.GetOrigin()), np.array(self._plane.GetNormal())
        values = {"point": point, "normal": normal}
        for name in (field.name for field in self._shown.fields[2:] if field.kind == "vector"):
            value = getattr(self._shown, name)
            values[name] = value - value @ normal * normal
            if np.linalg.norm(values[name]) < 1e-3:  # tilted until it was along the new normal
                values[name] = np.cross(normal, np.cross(self._shown.normal, value))
        cut = self._shown.changed(**values)
        self._draw_sheet(cut)
        return cut

    def _draw_sheet(self, cut):
        """Fill all of a plane, or the part that cuts."""
        is_part = isinstance(cut, Obstacle)
        self._plane.GetPlaneProperty().SetOpacity(_MIN_OPACITY if is_part else _OPACITY)
        self._plane.GetSelectedPlaneProperty().SetOpacity(
            _GRABBED_MIN_OPACITY if is_part else _GRABBED_OPACITY
        )
        if is_part:
            self._sheet.show(cut)


class EdgedSheet:
    """Draws a flat cut and its edge within a box with corners (2, 3)."""

    def __init__(self, scene, corners):
        self._actors, self._plane, self._sheet = [], vtkPlane(), vtkPolyData()
        spacing = np.maximum(np.ptp(corners, axis=0), 1e-9 * np.ptp(corners)) / _CELLS
        box = configured(vtkImageData(), Dimensions=[_CELLS + 1] * 3, Spacing=spacing)
        box.SetOrigin(corners[0])
        self._cutter = configured(vtkCutter(), InputData=box, CutFunction=self._plane)
        part = configured(vtkClipPolyData(), InputData=self._sheet)
        edge = configured(vtkContourFilter(), InputData=self._sheet)
        edge.SetValue(0, 0.0)
        layers = (scene.renderer, _SHEET_OPACITIES), (scene.overlay, _HIDDEN_OPACITIES)
        for renderer, opacities in layers:
            for source, color, opacity in zip((part, edge), (_BLUE, _RED), opacities):
                self._actors.append(polydata.unlit_actor(source, color, _EDGE_WIDTH, opacity))
                renderer.AddActor(self._actors[-1])
        self.set_visible(False)

    def show(self, cut):
        """Draw a cut."""
        configured(self._plane, Origin=cut.point, Normal=cut.normal)
        self._sheet.ShallowCopy(output_of(self._cutter))
        depth = cut.depth(positions_of(self._sheet).astype(float))
        arrays.add(self._sheet.GetPointData(), "depth", depth)
        self._sheet.GetPointData().SetActiveScalars("depth")

    def set_visible(self, is_visible):
        """Show or hide the sheet."""
        for actor in self._actors:
            actor.SetVisibility(is_visible)


def _nearest_axis(vector):
    """The unit vector along the axis that is nearest to a vector (3,)."""
    axis = np.abs(vector).argmax()
    return unit(np.eye(3)[axis] * (-1.0 if vector[axis] < 0 else 1.0))


def _plane_representation(bounds):
    plane = configured(vtkImplicitPlaneRepresentation(), PlaceFactor=1 + _MARGIN)
    plane.PlaceWidget(bounds.T.ravel())
    configured(plane, OutlineTranslation=False, OutsideBounds=True, ScaleEnabled=False)
    configured(plane, DrawOutline=False, EdgeColor=_BLUE, Tubing=False)
    plane.GetPlaneProperty().SetColor(_BLUE)
    plane.GetSelectedPlaneProperty().SetColor(_BLUE)
    plane.GetNormalProperty().SetColor(_BLUE)
    plane.GetSelectedNormalProperty().SetColor(_LIGHT_BLUE)
    return plane


class MotionWidget(DragWidget):
    """Lets the mouse turn a shape about its center by the faces of a box; Shift moves it."""

    def __init__(self, interactor, scene):
        self._min_size = _MIN_SIZE * np.ptp(scene.bounds, axis=0).max()
        self._box = _box_representation()
        widget = configured(vtkBoxWidget2(), ScalingEnabled=False, MoveFacesEnabled=False)
        super().__init__(interactor, scene.overlay, widget, self._box)

    def show(self, shape, motion):
        """Show the box around the `bounds` of a shape after a motion (4, 4); nothing for None."""
        if shape is not self._shown and shape is not None:
            self._box.PlaceWidget(self._bounds_of(shape))
        self._shown = shape
        self._update()
        if shape is not None and not self._is_dragged:
            self._box.SetTransform(configured(vtkTransform(), Matrix=motion.ravel()))

    def _bounds_of(self, shape):
        low, high = shape.bounds
        margin = _BOX_MARGIN * (high - low).max()
        half = np.maximum((high - low) / 2 + margin, self._min_size / 2)
        middle = (low + high) / 2
        return np.stack([middle - half, middle + half], axis=1).ravel()

    def _value(self):
        """The motion (4, 4) of the box, exactly a rotation and a translation."""
        transform = vtkTransform()
        self._box.GetTransform(transform)
        motion = matrix_of(transform.GetMatrix())
        left, _, right = np.linalg.svd(motion[:3, :3])
        center = self._shown.bounds.mean(axis=0)
        moved = motion[:3, :3] @ center + motion[:3, 3]
        motion[:3, :3] = left @ right
        motion[:3, 3] = moved - motion[:3, :3] @ center
        return motion

    def _update(self):
        is_enabled = super()._update()
        if is_enabled:
            self._box.HandlesOff()  # those of faces would resize it
        return is_enabled


def _box_representation():
    box = configured(vtkBoxRepresentation(), PlaceFactor=1.0, OutlineCursorWires=False)
    box.HandlesOff()
    for outline, color in (
        (box.GetOutlineProperty(), _BOX_COLOR),
        (box.GetSelectedOutlineProperty(), _GRABBED_BOX_COLOR),
    ):
        configured(outline, Color=color, LineWidth=_BOX_WIDTH, Lighting=False)
    configured(box.GetSelectedFaceProperty(), Color=_GRABBED_BOX_COLOR, Opacity=_FACE_OPACITY)
    return box
