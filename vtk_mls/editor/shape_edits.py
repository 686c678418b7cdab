"""The edits of an editor that concern cuts, regions, curves and the mask."""

import numpy as np

from vtk_mls import BallMask, CurveHandle
from vtk_mls.editor.line_tools import CurveTool, CutTool
from vtk_mls.editor.region_tool import RegionTool
from vtk_mls.model.handles.curve import straightened

_RADIUS = 0.25  # of the initial mask, and its fall-off, relative to the data
_MASK_HINT = (
    "It acts in the inner ball, and fades out to the outer one; drag the violet points. "
    "W: everywhere."
)


class ShapeEdits:
    """Base of `Editor` with the methods for cuts and for handles that have a shape."""

    def _add_tools(self):
        self._region_tool, self._click_tool = RegionTool(self.document), ClickTool()
        self._cut_tool, self._curve_tool = CutTool(self.document), CurveTool(self.document)
        self.tools = self._cut_tool, self._curve_tool, self._click_tool

    def _cancel_tools(self, but=None):
        for tool in self.tools:
            if tool is not but:
                tool.cancel()

    def change_cut(self):
        """Cut by the next of the flat shapes, or not at all after the last."""
        self._cut_tool.change_shape()

    def change_half(self):
        """Turn the cut by an eighth of a turn about its normal, or let it grow."""
        self._cut_tool.change_edge()

    def incise(self):
        """Start a line on the surface, or cut along it."""
        self._cancel_tools(self._cut_tool)
        self._cut_tool.incise()

    def make_rigid(self):
        """Make the mesh or the segment under the mouse a rigid region."""
        self._region_tool.make_rigid(self._mouse.pixel)

    def make_clicked_rigid(self):
        """Make the mesh or the segment that is clicked on next a rigid region."""
        self._cancel_tools()
        self._click_tool.wait(self._region_tool.make_rigid, is_for_slices=False)
        self.say("Click on a mesh, or on a segment of a label image, to make it rigid.")

    def turn_handle(self):
        """Let a box turn the selected handles, or the one under the mouse, which becomes a ball."""
        rows = self.document.target_rows()
        if len(rows) > 1:
            self._region_tool.turn_handles(rows)
        elif len(rows):
            self._region_tool.turn_handle(rows[0])

    def draw_curve(self):
        """Start a curve handle, or end it."""
        self._cancel_tools(self._curve_tool)
        if not self.end_curve():
            self._curve_tool.start()

    @property
    def is_drawing_curve(self):
        """Whether clicks add nodes of a curve."""
        return self._curve_tool.is_drawing

    def end_curve(self):
        """End the curve that is drawn; whether there was one."""
        is_drawing = self._curve_tool.is_drawing
        if is_drawing:
            self._curve_tool.end()
        return is_drawing

    def straighten(self):
        """Put the selected curves, or the only one, on straight lines of their length at rest."""
        self.end_curve()
        state = self.state
        curves = [i for i, handle in enumerate(state.handles) if isinstance(handle, CurveHandle)]
        selected = np.intersect1d(curves, state.grips.owner[self.selected]).astype(int).tolist()
        if not selected and len(curves) > 1:
            self.say("Select a node of the curve to straighten: click on one.")
            return
        if not curves:
            self.say("There is no curve to straighten: press D to draw one.")
            return
        for index in selected or curves:
            state = state.with_shape(straightened(state.handles[index]), index)
        if self.change(state):
            self.say("Straightened. J shows folds, Z undoes it.")

    def change_mask(self):
        """Let the deformation act in a ball around the selected handles, or everywhere."""
        state, size = self.state, np.ptp(self.scene.bounds, axis=0).max()
        if state.mask is not None:
            self.document.clear_selection()
            self.change(state.changed(mask=None))
            return
        selected = state.grips.deformed[self.selected]
        middle = selected.mean(axis=0) if len(selected) else self.scene.bounds.mean(axis=0)
        if self.change(state.changed(mask=BallMask(middle, _RADIUS * size, _RADIUS * size))):
            self.say(_MASK_HINT)

    def set_name(self, row, name):
        """Name a point handle."""
        if row >= len(self.state):
            self.say("Only point handles have names.")
        elif name != self.state.labels[row]:
            self.change(self.state.with_name(row, name))

    def set_position(self, row, position):
        """Put a grip at a position (3,) of the deformed space."""
        if self.state.grips.anchored[row]:
            self.say("This handle is fixed; F frees it.")
        else:
            self.change(self.state.moved([row], [position]))

    def set_rest(self, row, position):
        """Put the rest position of a point or of a node of a curve at (3,)."""
        self.change(self.state.with_rest(row, position))


class ClickTool:
    """Calls a function with the pixel of the next click, for commands that need a place."""

    def __init__(self):
        self._act, self._is_for_slices = None, False

    def wait(self, act, is_for_slices):
        """Call `act(pixel)` at the next click, in 3-D views and, if `is_for_slices`, in slices."""
        self._act, self._is_for_slices = act, is_for_slices

    def cancel(self):
        """Do not wait."""
        self._act = None

    def click(self, pixel, pane):
        """Act at a pixel of a `SlicePane`, or of a 3-D view for None; whether this waited."""
        act = self._act
        if act is None or (pane is not None and not self._is_for_slices):
            return False
        self.cancel()
        act(pixel)
        return True
