"""Draws a state in the window: data, cut, handles and texts, as finely as time allows."""

import time

from vtk_mls.editor.commands import HINT
from vtk_mls.editor.distortion import Distortion
from vtk_mls.editor.grips import NO_ROWS
from vtk_mls.editor.handle_glyphs import handle_colors
from vtk_mls.editor.overlay import Overlay
from vtk_mls.editor.scene import Scene, new_layer
from vtk_mls.editor.shape_actors import ShapeActors
from vtk_mls.editor.slices import ONLY_3D, Slices
from vtk_mls.editor.widgets import CutWidget, MotionWidget
from vtk_mls.model.kinds import KINDS
from vtk_mls.model.options import DEGREE
from vtk_mls.rendering.pace import MapPace

_REFINEMENT_DELAY = 0.25  # seconds without movement before a fine picture
_MAX_NODES = 96  # along the longest side
# Limits of a picture: its seconds, and the pixels between rays along both axes. At rest, fewer rays
# are for slow graphics only.
_MOVING, _RESTING, _FILE = (0.04, 8.0), (2.0, 3.0), (20.0, 3.0)


class View:
    """Draws states of a list of vtkDataSet in the window of a vtkRenderWindowInteractor.

    Attributes
    ----------
    scene, slices, overlay, distortion, cut_widget, motion_widget
        Objects of the classes with these names.
    has_timer : bool
        Whether a timer runs, so that fine pictures replace coarse ones.
    hides_handles : bool
    shows_undeformed : bool
        Whether the data are drawn undeformed, whatever the state.
    shows_times : bool
        Whether the status line has computing times.
    drawn_message : str
        The message in the last picture.
    preset : int
        The index of the colors and opacities, in the presets of each dataset again and again.
    """

    def __init__(self, interactor, datasets):
        window, style = interactor.GetRenderWindow(), interactor.GetInteractorStyle()
        self.scene = Scene(window, datasets)
        self.distortion = Distortion(self.scene.bounds)
        self.slices = Slices(self.scene, self.distortion)
        self.cut_widget = CutWidget(interactor, self.scene)
        self.motion_widget = MotionWidget(interactor, self.scene)
        self._shapes = ShapeActors(self.scene.overlay)
        self.has_timer = self.hides_handles = self.shows_undeformed = self.shows_times = False
        self.drawn_message, self.overlay = "", Overlay(new_layer(window), HINT)
        self._pace, self.preset, self._moved_at = MapPace(_MAX_NODES), 0, None
        self._tags = [
            (observed, observed.AddObserver(event, handler))
            for observed, event, handler in (
                (window, "StartEvent", self._lay_out),
                (style, "StartInteractionEvent", self._start_camera),
                (style, "EndInteractionEvent", self._stop_camera),
            )
        ]

    def show(self, state, is_final):
        """Deform the data of the next pictures; an error if the state has no map."""
        deformation = self._deformation_of(state)
        self.slices.regions = state.regions
        self.distortion.deformation = deformation

        def make_map(nodes):
            self.scene.show(deformation, nodes, self.distortion, is_final)
            self.show_slices(is_final)

        if deformation is None:
            make_map(self._pace.nodes)
        else:
            self._pace.make(make_map, not is_final)

    def show_slices(self, is_final=True):
        """Draw the slices."""
        self.slices.show(is_final)

    def set_pane(self, pane):
        """Show one of `slices.PANES`."""
        self.slices.set_pane(pane)
        self.show_slices()

    def zoom(self, pixel, to, factor):
        """Zoom by a factor about a pixel, which moves to the pixel `to`; whether in a slice."""
        pane = self.pane_at(pixel)
        if pane is None:
            self.scenes_at(pixel)[0].zoom_at(pixel, to, factor)
        else:
            self.slices.zoom_at(pane, pixel, to, factor)
            self.show_slices(is_final=not self.has_timer)
        return pane is not None

    def reset_camera(self):
        """Fit the camera and the slices to the data."""
        self.scene.reset_camera()
        self.slices.reset_zoom()
        self.show_slices()

    def scenes_at(self, pixel):
        """The `Scene`s that are drawn at a pixel; the mouse picks points of the first."""
        return [self.scene]

    def has_data_at(self, pixel):
        """Whether the edited data are drawn at a pixel."""
        return True

    def pane_at(self, pixel):
        """The `SlicePane` at a pixel; None in a 3-D view."""
        return self.slices.pane_at(pixel)

    def point_at(self, pixel):
        """The visible point (3,) at a pixel, on a surface or in a slice; None beside the data."""
        pane = self.pane_at(pixel)
        if pane is not None:
            return pane.point_at(pixel)
        scene, *_ = self.scenes_at(pixel)
        return scene.picker().hit(pixel)

    def adjust(self, pixel, brightness, contrast):
        """Change the gray values of slices at a pixel, as `SceneVolume.adjust`."""
        for scene in self.scenes_at(pixel):
            for item in scene.items:
                item.adjust(brightness, contrast)
        self.show_slices(is_final=False)

    def set_preset(self, index):
        """Draw the data with one of their presets; the names of these."""
        self.preset = index
        names, *_ = [scene.set_preset(index) for scene in self._scenes]
        self.show_slices()
        return names

    def draw(self, state, selected, hovered, dragged, is_moving=False):
        """Render; coarsely while something moves, if a timer refines the picture later."""
        is_moving, pace = is_moving and self.has_timer, self._pace
        pixels = pace.pixels(_MOVING if is_moving else _RESTING)
        self.cut_widget.show(state.flat_cut)
        self._set_coarseness(pixels)
        self._draw_handles(state, selected, hovered, dragged)
        self.overlay.set_status(self._status_of(state, selected))
        self.drawn_message = self.overlay.message
        started = time.perf_counter()
        self.scene.renderer.ResetCameraClippingRange()
        self.scene.window.Render()
        pace.note_picture(pixels, time.perf_counter() - started)
        is_coarse = is_moving and (pixels > 1 or self.slices.is_coarse)
        self._moved_at = time.monotonic() if is_coarse else None

    def draw_for_file(self, state):
        """Render as finely as possible, without texts and cut widget."""
        for widget in self._widgets:
            widget.set_visible(False)
        self._set_coarseness(self._pace.pixels(_FILE))
        self._draw_handles(state, NO_ROWS, None, NO_ROWS)
        self.overlay.renderer.DrawOff()
        self.scene.window.Render()
        self.overlay.renderer.DrawOn()
        for widget in self._widgets:
            widget.set_visible(not self.hides_handles)

    def draw_slices(self, state, selected, hovered, dragged):
        """Render the moved slices."""
        self.draw(state, selected, hovered, dragged, is_moving=True)

    @property
    def is_refinement_due(self):
        """Whether it is time to replace a coarse picture."""
        return self._moved_at is not None and time.monotonic() - self._moved_at > _REFINEMENT_DELAY

    def hide_handles(self):
        """Hide or show handles, widgets, hint and status, but not the message."""
        self.hides_handles = not self.hides_handles
        for part in (*(scene.glyphs for scene in self._scenes), self._shapes, *self._widgets):
            part.set_visible(not self.hides_handles)
        self.overlay.set_texts_visible(not self.hides_handles)

    def detach(self):
        """Remove everything from the window."""
        for observed, tag in self._tags:
            observed.RemoveObserver(tag)
        for widget in self._widgets:
            widget.detach()
        self.slices.set_pane(ONLY_3D)
        self.scene.detach()
        self.scene.window.RemoveRenderer(self.overlay.renderer)

    @property
    def _scenes(self):
        return [self.scene]

    @property
    def _widgets(self):
        return self.cut_widget, self.motion_widget

    def _deformation_of(self, state):
        """The map of the drawn data; None for the identity."""
        return (state.changed(blend=0.0) if self.shows_undeformed else state).deformation()

    def _draw_handles(self, state, selected, hovered, dragged):
        self._shapes.show(state, selected)
        self._show_grips(state, selected, hovered, handle_colors(state, selected, dragged))

    def _show_grips(self, state, selected, hovered, colors):
        """Place the grips of a `State`, with colors (g, 3)."""
        rest, deformed = state.grips.rest, state.grips.deformed
        self.scene.glyphs.show(rest, deformed, colors, hovered)
        self.slices.show_handles(deformed, colors, not self.hides_handles)

    def _lay_out(self, window, event):
        """Place the texts in the only 3-D view, or else in the whole window."""
        view = self.scene.renderer
        is_alone = view.GetDraw() and len(self._scenes) == 1
        self.overlay.renderer.SetViewport(view.GetViewport() if is_alone else (0, 0, 1, 1))
        self.overlay.lay_out()

    def _set_coarseness(self, pixels):
        for scene in self._scenes:
            scene.set_coarseness(pixels)

    def _start_camera(self, style, event):
        self._set_coarseness(self._pace.pixels(_MOVING))
        self._moved_at = None

    def _stop_camera(self, style, event):
        """Refine the picture; later if there is a timer."""
        self._moved_at = time.monotonic()
        if not self.has_timer:
            self._set_coarseness(self._pace.pixels(_RESTING))
            self.scene.window.Render()
            self._moved_at = None

    def _status_of(self, state, selected):
        pace, regions = self._pace, len(state.regions)
        curves = len(state.handles) - regions
        degree = f" {state.degree}" if DEGREE.needs == ("kind", state.kind) else ""
        fixed, off = int(state.anchored.sum()), int((~state.enabled).sum())
        smoothing = "automatic" if state.smoothing < 0 else f"{state.smoothing:g}"
        texts = (
            (True, f"{len(state)} handle{'s' * (len(state) != 1)}"),
            (regions, f"{regions} rigid"),
            (curves, f"{curves} curve{'s' * (curves > 1)}"),
            (state.mask is not None, "mask"),
            (True, state.kind + degree),
            (state.kind in KINDS, f"alpha {state.alpha:g}"),
            (len(selected), f"{len(selected)} selected"),
            (fixed, f"{fixed} fixed"),
            (off, f"{off} off"),
            (state.smoothing, f"smoothing {smoothing}"),
            (state.steps != 1, f"{state.steps} steps" if state.steps else "steps automatic"),
            (state.blend != 1, f"blend {state.blend:g}"),
            (self.shows_undeformed, "shown undeformed; B"),
            (self.shows_times, f"map {1e3 * pace.map_seconds:.0f} ms, {pace.nodes} nodes"),
            (self.shows_times, f"picture {1e3 * pace.picture_seconds:.0f} ms"),
        )
        return "   ".join(text for is_shown, text in texts if is_shown)
