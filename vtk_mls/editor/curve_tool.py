"""The tool that draws curve handles."""

import numpy as np

from vtk_mls import CurveHandle
from vtk_mls.editor.cut_tool import CutLine
from vtk_mls.editor.document import NO_SURFACE
from vtk_mls.editor.slices import NO_NODES


class CurveTool:
    """Draws a curve handle of a `Document` node by node."""

    def __init__(self, document):
        self._document, self._line = document, None

    @property
    def is_drawing(self):
        """Whether clicks add nodes."""
        return self._line is not None

    def start(self):
        """Add a node at each click from now on."""
        self._line = CutLine(self._document.view.scene.overlay)
        self._document.say(
            "Click along the curve, on the surface or in a slice. Return or the button ends it."
        )

    def click(self, pixel, pane):
        """Add a node on the surface, or in a slice; whether a curve is drawn."""
        document = self._document
        if not self.is_drawing:
            return False
        document.show_deformed()
        with document.reporting_errors():
            point = document.view.point_at(pixel)
            if point is None:
                document.say(NO_SURFACE)
            elif not np.array_equal(self._line.points[-1:], [point]):
                self._line.add(point)
                document.view.slices.drawn_nodes = np.array(self._line.points)
        document.draw(is_moving=True)
        return True

    def end(self):
        """Make the nodes a curve handle, and select them."""
        document, nodes = self._document, np.array(self._line.points).reshape(-1, 3)
        self.cancel()
        if len(nodes) < 2:
            document.say("A curve needs at least two nodes.")
            return
        state = document.state
        deformation = state.deformation()
        rest = nodes if deformation is None else deformation.backward(nodes)
        if document.change(state.with_shape(CurveHandle(rest, nodes))):
            document.say("Drag the nodes of the curve; 9 straightens it, X removes a node.")
            document.select(document.state.grips.rows_of(len(document.state.handles) - 1))

    def cancel(self):
        """Remove an unfinished curve."""
        if self._line is not None:
            self._line.remove()
            self._line = None
            self._document.view.slices.drawn_nodes = NO_NODES
