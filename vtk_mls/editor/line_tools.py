"""The tools for cuts, flat or along a line on the surface, and for curve handles."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from vtk_mls import CurveHandle, Surface
from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor import polydata
from vtk_mls.editor.document import NO_SURFACE
from vtk_mls.editor.handle_glyphs import DRAWN
from vtk_mls.editor.slices import NO_NODES
from vtk_mls.model.cuts import BY_NUMBERS, Obstacle

_HINT = (
    "The blue sheet cuts{edge}, and the mouse moves it; C: another shape. Drag handles away from "
    "it to open the cut. Ctrl, or the page's button with a check mark, selects several by a drag."
)
_EDGE = " up to its red edge (I changes it)"
_GROWTH, _MIN_LENGTH, _MAX_LENGTH = 1.25, 0.1, 0.5  # of lengths of a cut, relative to the data
_CLOSING_DISTANCE = 10  # pixels from the first point, where a click closes the line
_DEPTH, _HEIGHT = 0.4, 0.15  # of a cut below and above the line, relative to the data


class CutTool:
    """Edits the cuts of a `Document`."""

    def __init__(self, document):
        self._document, self._line = document, None
        self._scene, self._widget = document.view.scene, document.view.cut_widget
        self._widget.set_callbacks(self._preview, document.commit)

    def change_shape(self):
        """Cut by the next of the flat shapes, or not at all after the last."""
        document = self._document
        cut, shapes = document.state.flat_cut, [*BY_NUMBERS.values(), None]
        shape = shapes[0] if cut is None else shapes[shapes.index(type(cut)) + 1]
        cut = shape and self._widget.initial_cut(shape, cut)
        if cut is not None:  # the message is part of the first picture; an error replaces it
            document.say(_HINT.format(edge=_EDGE * isinstance(cut, Obstacle)))
        document.change(document.state.with_flat_cut(cut))

    def change_edge(self):
        """Turn the cut by an eighth of a turn about its normal, or let it grow."""
        document = self._document
        cut = document.state.flat_cut
        if not isinstance(cut, Obstacle):
            document.say("There is no cut with an edge; C makes one.")
            return
        size = np.ptp(self._scene.bounds, axis=0).max()
        values = {}
        for field in cut.fields[2:]:
            value = getattr(cut, field.name)
            if field.kind == "vector":
                value = np.sqrt(0.5) * (value + np.cross(cut.normal, value))
            else:
                is_largest = _GROWTH * value > _MAX_LENGTH * size
                value = _MIN_LENGTH * size if is_largest else _GROWTH * value
            values[field.name] = value
        document.change(document.state.with_flat_cut(cut.changed(**values)))

    def incise(self):
        """Start a line on the surface, or cut along it."""
        document, line = self._document, self._line
        if line is None:
            self._line = CutLine(self._scene.overlay)
            document.say(
                "Click on the surface along the cut; click on the first point to close the line. "
                "P, or the button again, cuts."
            )
            return
        if len(line.points) < 2:
            self.cancel()
            document.say("A cut needs at least two points on the surface.")
            return
        state = document.state
        deformation = state.deformation() if state.cut_frame == "rest" else None
        size = np.ptp(self._scene.bounds, axis=0).max()
        cut = line.cut(self._depth_directions(line), size, deformation)
        if document.change(state.changed(cuts=(cut, *state.cuts))):
            self.cancel()

    def click(self, pixel, pane):
        """Extend the line on the surface; whether there is a line in the 3-D view."""
        document, line = self._document, self._line
        if pane is not None:
            return False
        document.show_deformed()
        if line is None:
            return False
        nearest = self._scene.projection.nearest
        can_close = not line.is_closed and len(line.points) > 2
        if can_close and nearest(line.points[:1], pixel, _CLOSING_DISTANCE) is not None:
            line.close()
            document.say("The line is closed: P cuts along it, straight into the depth.")
        with document.reporting_errors():
            point = None if line.is_closed else self._scene.picker().hit(pixel)
            if point is not None:
                line.add(point)
            elif not line.is_closed:
                document.say(NO_SURFACE)
        document.draw(is_moving=True)
        return True

    def cancel(self):
        """Remove an unfinished line."""
        if self._line is not None:
            self._line.remove()
            self._line = None

    def _depth_directions(self, line):
        """Unit vectors, (3,) or (n, 3), from a line into the depth.

        Those of an open line point away from the eye. A closed line has one direction, so that the
        piece can be pulled out.
        """
        points = np.array(line.points)
        viewing = unit(points - self._scene.renderer.GetActiveCamera().GetPosition())
        if not line.is_closed:
            return viewing
        # the vector area of the line is along the mean normal of any surface that it bounds
        middle = points.mean(axis=0)
        area = np.cross(points - middle, np.roll(points, -1, axis=0) - middle).sum(axis=0)
        ahead = unit(viewing.mean(axis=0))
        return unit(area * np.sign(area @ ahead)) if area @ ahead else ahead

    def _preview(self, cut):
        self._document.preview(self._document.committed.with_flat_cut(cut))


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


class CutLine:
    """A line on the surface that grows point by point, until it `is_closed` at its first point."""

    def __init__(self, renderer):
        self._renderer, self.points, self.is_closed = renderer, [], False
        self._polydata = vtkPolyData()
        self._actor = polydata.unlit_actor(self._polydata, tuple(np.divide(DRAWN, 255)), 4)
        polydata.show_points_as_balls(self._actor, 9)
        renderer.AddActor(self._actor)

    def add(self, point):
        """Append a point (3,)."""
        self.points.append(np.array(point))
        self._draw()

    def close(self):
        """Return to the first point."""
        self.is_closed = True
        self._draw()

    def cut(self, depth_directions, size, deformation):
        """The `Surface` through the line.

        `depth_directions` are unit vectors, (3,) or (n, 3), and `size` is that of the data, which
        are drawn after a `deformation`, None for the identity: the cut is in the rest space.
        """
        line, count = np.array(self.points), len(self.points)
        above, below = _HEIGHT * size * depth_directions, _DEPTH * size * depth_directions
        rows = np.stack([line - above, line, line + below])
        if deformation is not None:
            rows = deformation.backward(rows.reshape(-1, 3)).reshape(rows.shape)
        edges = list(enumerate([*range(1, count), 0]))[: None if self.is_closed else -1]
        triangles = []
        for upper, lower in ((0, count), (count, 2 * count)):
            for i, j in edges:
                triangles += [(upper + i, upper + j, lower + i), (upper + j, lower + j, lower + i)]
        return Surface(rows.reshape(-1, 3), triangles)

    def remove(self):
        """Remove the line from the view."""
        self._renderer.RemoveActor(self._actor)

    def _draw(self):
        ids = np.arange(len(self.points))
        line = np.append(ids, [0] * self.is_closed).astype(int)
        self._polydata.SetPoints(polydata.points(self.points))
        self._polydata.SetLines(polydata.cells(line[None]) if len(ids) > 1 else vtkCellArray())
        self._polydata.SetVerts(polydata.cells(ids[:, None]))
