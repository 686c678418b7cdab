"""The tool for rigid regions: from meshes, labels and handles, turned by a box."""

import numpy as np

from vtk_mls import Ball, RegionHandle
from vtk_mls.editor.turning import in_enough_steps

_RADIUS = 0.05  # of a handle that can be turned, relative to the data
_HINT = "Drag the box to turn it, its middle to move it; X removes it."
_GROUP_HINT = "Drag the box to turn the handles, its middle to move them; turns add up."
_NO_SHAPE = "There is no mesh and no segment of a label image here; load one with `--with`."


class RegionTool:
    """Makes rigid regions in a `Document`, and moves the selected one."""

    def __init__(self, document):
        self._document = document
        self._scene, self._widget = document.view.scene, document.view.motion_widget
        self._widget.set_callbacks(self._preview, self._commit)

    def make_rigid(self, pixel):
        """Make the mesh or the segment at a pixel of the 3-D view a region."""
        document = self._document
        with document.reporting_errors():
            shape = self._scene.rigid_shape_at(pixel)
            if shape is None:
                document.say(_NO_SHAPE)
                return
            state = document.state
            for index, handle in enumerate(state.handles):
                if isinstance(handle, RegionHandle) and _are_same(shape, handle.shape):
                    self._select(index, "It is rigid already. " + _HINT)
                    return
            # handles inside would hold their positions against its motion
            inside = np.flatnonzero(shape.distance(state.rest)[0] == 0)
            document.clear_selection()
            if document.change(state.without(inside).with_shape(RegionHandle(shape, np.eye(4)))):
                removed = f"; removed handles in it: {len(inside)}" if len(inside) else ""
                self._select(len(state.handles), f"It is rigid now{removed}. {_HINT}")

    def turn_handle(self, row):
        """Make the point handle of a row a ball that can be turned."""
        document, state = self._document, self._document.state
        if row >= len(state):
            document.say("Only a point handle becomes a ball that can be turned.")
            return
        motion = np.eye(4)
        motion[:3, 3] = state.deformed[row] - state.rest[row]
        radius = _RADIUS * np.ptp(self._scene.bounds, axis=0).max()
        region = RegionHandle(Ball(state.rest[row], radius), motion)
        document.clear_selection()
        if document.change(state.without([row]).with_shape(region)):
            self._select(len(document.state.handles) - 1, "The handle can be turned. " + _HINT)

    def turn_handles(self, rows):
        """Let the box turn several point handles together."""
        document = self._document
        if (rows >= len(document.state)).any():
            document.say("Only point handles turn together.")
            return
        document.select(rows)
        document.turn_selected()
        document.say(_GROUP_HINT)

    def _select(self, index, message):
        self._document.say(message)
        self._document.select(self._document.state.grips.rows_of(index))

    def _preview(self, motion):
        document = self._document
        state, index, group = document.committed, document.selected_region, document.group
        if group is not None:
            group.turn_to(motion)
            document.preview(group.turned(state))
        elif index is not None:
            region = RegionHandle(state.handles[index].shape, motion)
            document.preview(state.with_shape(region, index))

    def _commit(self):
        document = self._document
        with document.reporting_errors():
            if document.group is not None:
                document.state = in_enough_steps(document.state)
        document.commit()


def _are_same(shape, other):
    pairs = ((getattr(shape, f.name), getattr(other, f.name, None)) for f in shape.fields)
    return type(shape) is type(other) and all(x is y or np.array_equal(x, y) for x, y in pairs)
