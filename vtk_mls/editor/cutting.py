"""Cuts as one makes them in the view: a flat one by a widget, others by a line on the surface."""

from __future__ import annotations

import numpy as np

from vtk_mls import HalfPlane, Plane
from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor.cut_widget import CutWidget, next_half
from vtk_mls.editor.incision import Incision

_OF_PLANE = "The blue sheet cuts, and the mouse moves it; C: just half of it."
_OF_HALF = "The blue sheet cuts as far as its red edge, and the mouse moves it; I: another half."
_NEAR = 10  # pixels from the first point, where a click closes a line


class Cutting:
    """Edits the cuts of an editor's state.

    Parameters
    ----------
    editor : Editor
        Whose scene is there.
    interactor : vtkRenderWindowInteractor
    """

    def __init__(self, editor, interactor):
        self._editor, self._line, self._is_visible = editor, None, True
        self._widget = CutWidget(interactor, editor.scene, self._moved, self._ended)

    def show(self, state):
        """Show the flat cut of a state, for the mouse."""
        if self._is_visible:
            self._widget.show(_flat_cut(state))

    def set_visible(self, is_visible):
        """Hide it, or show it again."""
        self._is_visible = is_visible
        self._widget.set_visible(is_visible)

    def change_shape(self):
        """Cut by a plane, by a half-plane, or not at all, in this order."""
        editor, cut = self._editor, _flat_cut(self._editor.state)
        if cut is None:
            cut = self._widget.first(self._camera)
        else:
            cut = self._widget.half(cut, self._camera) if isinstance(cut, Plane) else None
        if cut is not None:  # with the first picture of it, or what is wrong
            is_half = isinstance(cut, HalfPlane)
            editor.say(
                f"{_OF_HALF if is_half else _OF_PLANE} Drag handles away from it to open it "
                "(Ctrl + drag beside handles selects several)."
            )
        editor.change(_with_flat_cut(editor.state, cut))

    def change_half(self):
        """Cut by another half of the plane."""
        cut = _flat_cut(self._editor.state)
        if isinstance(cut, HalfPlane):
            self._editor.change(_with_flat_cut(self._editor.state, next_half(cut)))
        else:
            self._editor.say("There is no half-plane; C makes one.")

    def incise(self):
        """Begin a line on the surface, or cut along it."""
        editor, line = self._editor, self._line
        if line is None:
            self._line = Incision(editor.scene.overlay)
            editor.say(
                "Click on the surface along the cut, at last on its beginning to close it; P cuts."
            )
            return
        if len(line.points) < 2:
            self.drop_line()
            editor.say("A cut needs at least two points on the surface.")
            return
        size = np.ptp(editor.scene.bounds, axis=0).max()
        state = editor.state
        in_rest = state.cut_frame == "rest"
        cut = line.cut(self._away(line), size, state.deformation() if in_rest else None)
        if editor.change(state.changed(cuts=(cut, *state.cuts))):
            self.drop_line()

    def draw_line_to(self, pixel):
        """Go on with a line on the surface; whether one is being drawn."""
        if self._line is None:
            return False
        editor, line = self._editor, self._line
        if not line.is_closed and len(line.points) > 2 and self._is_first(pixel):
            line.close()
            editor.say("The line is closed: P cuts along it, straight into the depth.")
        point = None
        with editor.telling():
            point = None if line.is_closed else editor.surfaces().hit(editor.projection, pixel)
        if point is not None:
            line.add(point)
        return True

    def finish(self):
        """Let go of a cut that the mouse holds."""
        self._widget.finish()

    def drop_line(self):
        """Draw no line on."""
        if self._line is not None:
            self._line.remove()
            self._line = None

    def detach(self):
        """Leave the view."""
        self.drop_line()
        self._widget.detach()

    def _is_first(self, pixel):
        """Whether the line's first point is seen at a pixel."""
        return self._editor.projection.nearest(self._line.points[:1], pixel, _NEAR) is not None

    def _away(self, line):
        """Whither the cut goes from a line: away from the eye; from a closed one into the data.

        All of a closed one's go the same direction, so that what it cuts out can be drawn out.
        """
        points = np.array(line.points)
        seen = unit(points - self._camera.GetPosition())
        if not line.is_closed:
            return seen
        # the vector area of the line is that of all surfaces in it: along their mean normal
        middle = points.mean(axis=0)
        area = np.cross(points - middle, np.roll(points, -1, axis=0) - middle).sum(axis=0)
        ahead = unit(seen.mean(axis=0))
        return unit(area * np.sign(area @ ahead)) if area @ ahead else ahead

    @property
    def _camera(self):
        return self._editor.scene.renderer.GetActiveCamera()

    def _moved(self, cut):
        """Show where the mouse has the cut."""
        self._editor.preview(_with_flat_cut(self._editor.settled, cut))

    def _ended(self, cut):
        self._moved(cut)
        self._editor.settle()


def _flat_cut(state):
    """The cut that the widget moves: the last one that is flat; None without."""
    flat = [cut for cut in state.cuts if isinstance(cut, (Plane, HalfPlane))]
    return flat[-1] if flat else None


def _with_flat_cut(state, cut):
    """The state with another such cut, or without it for None."""
    cuts, old = list(state.cuts), _flat_cut(state)
    if old is not None:
        cuts.remove(old)
    return state.changed(cuts=(*cuts, *([] if cut is None else [cut])))
