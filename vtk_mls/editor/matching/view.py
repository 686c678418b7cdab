"""A view of the data with a target beside them."""

import time

import numpy as np

from vtk_mls.editor.matching.pairs import MOVING, TARGET
from vtk_mls.editor.matching.target import Comparison
from vtk_mls.editor.matching.target_view import TargetView
from vtk_mls.editor.view import View


class MatchingView(View):
    """A `View` that shows a target as well, if there is one: a `TargetView` or None.

    `comparison` says how both sides are drawn.
    """

    def __init__(self, interactor, datasets):
        self.target, self.comparison = None, Comparison()
        super().__init__(interactor, datasets)

    def set_target(self, target):
        """Show another `Target` beside the data, or none for None, from the next `show` on."""
        if self.target is not None:
            self.target.detach()
        self.target = None if target is None else TargetView(self, target)

    def set_comparison(self, comparison):
        """Draw both sides as a `Comparison` says, from the next `show` on."""
        self.comparison = comparison
        self.target.arrange()

    def side_at(self, pixel):
        """MOVING or TARGET: the side of the window at a pixel."""
        return MOVING if self.target is None or not self.target.is_at(pixel) else TARGET

    def shows_both_at(self, pixel):
        """Whether both sides are drawn over each other at a pixel."""
        return bool(self.slices.compared) and self.slices.pane_at(pixel) is not None

    def center_on(self, point):
        """Move the camera to look at a point (3,), in the same direction."""
        camera = self.scene.renderer.GetActiveCamera()
        offset = np.subtract(point, camera.GetFocalPoint())
        camera.SetPosition(np.add(camera.GetPosition(), offset))
        camera.SetFocalPoint(point)

    def show_slices(self, is_final=True):
        super().show_slices(is_final)
        if self.target is not None:
            self.target.show_slices(is_final)

    def set_pane(self, pane):
        if self.target is None:
            super().set_pane(pane)
        else:
            self.target.arrange(pane)
            self.show_slices()

    def reset_camera(self):
        super().reset_camera()
        if self.target is not None:
            self.target.reset_camera()

    def scenes_at(self, pixel):
        if self.shows_both_at(pixel):
            return self._scenes
        return [self.scene if self.side_at(pixel) == MOVING else self.target.scene]

    def has_data_at(self, pixel):
        return self.side_at(pixel) == MOVING

    def pane_at(self, pixel):
        pane = super().pane_at(pixel)
        return self.target.slices.pane_at(pixel) if pane is None and self.target else pane

    def draw_slices(self, state, selected, hovered, dragged):
        """Render the moved slices; with a target, do not render the 3-D views again."""
        if self.target is None or not self.slices.is_visible:
            super().draw_slices(state, selected, hovered, dragged)
            return
        self._draw_handles(state, selected, hovered, dragged)
        layers = [layer for scene in self._scenes for layer in scene.layers if layer.GetDraw()]
        for layer in layers:
            layer.DrawOff()
        self.scene.window.Render()
        for layer in layers:
            layer.DrawOn()
        self._moved_at = time.monotonic() if self.slices.is_coarse else None

    def detach(self):
        self.set_target(None)
        super().detach()

    @property
    def _scenes(self):
        return [self.scene] if self.target is None else [self.scene, self.target.scene]

    def _deformation_of(self, state):
        deformation = super()._deformation_of(state)
        if deformation is None and self.target is not None:
            return self.target.initial_map(state.device)
        return deformation

    def _show_grips(self, state, selected, hovered, colors):
        if self.target is None:
            super()._show_grips(state, selected, hovered, colors)
        else:
            self.target.draw(state, selected, hovered, colors)

    def _lay_out(self, window, event):
        super()._lay_out(window, event)
        if self.target is not None:
            self.target.lay_out()
