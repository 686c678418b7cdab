"""The editor: handles that the mouse drags, in any VTK window."""

import numpy as np

from vtk_mls.editor.distortion import MODES, TEXTS
from vtk_mls.editor.document import NO_SURFACE, Document
from vtk_mls.editor.keys import Keyboard
from vtk_mls.editor.matching.mouse import MatchingMouse
from vtk_mls.editor.matching.pair_edits import PairEdits
from vtk_mls.editor.matching.view import MatchingView
from vtk_mls.editor.mouse import PRIORITY
from vtk_mls.editor.saving import Saver
from vtk_mls.editor.sessions import Saving
from vtk_mls.editor.shape_edits import ShapeEdits
from vtk_mls.editor.slices import ALL, ONLY_3D, SLICES
from vtk_mls.editor.state import State
from vtk_mls.model.options import ALPHA, NU
from vtk_mls.rendering.surfaces import handles_on

_TIMER_MILLISECONDS = 15
_LATTICE_COUNTS = 3, 4, 5, 2  # handles along each axis
_MIN_SMOOTHING = 0.01  # of the size of the data


class Editor(ShapeEdits, PairEdits, Saving):
    """Edits a deformation of images and meshes with the mouse and keys.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
        Any kind, with its window. The editor draws in the first renderer of the window; it adds
        one to a window without a renderer.
    datasets : vtkDataSet or list of vtkDataSet
        Images are drawn as volumes, other datasets as surfaces. The same handles move them all.
    state : State, optional
        The initial state. Without handles, the editor adds a lattice over the data.
    paths : list of path, optional
        Files of the datasets, which name the saved files.
    autosave : Autosave, optional
    target : Target or vtkDataSet, optional
        What the data are to match. Landmarks are placed in pairs then, without a lattice.

    Attributes
    ----------
    document, view, scene, slices, saver : Document, MatchingView, Scene, Slices, Saver
    is_narrow : bool
        Whether the window has no room for several slices.

    Raises
    ------
    TypeError, ValueError
        If a dataset cannot be shown.

    Notes
    -----
    Keep a reference to the editor: VTK does not hold one. Nothing is resampled: see
    `DeformedVolume` and `DeformedMesh`. During a drag, the map is as fine as time allows; the
    finest map follows at the end of the drag.
    """

    def __init__(self, interactor, datasets, state=None, paths=(), autosave=None, target=None):
        self._interactor, self._lattice_number, self.is_narrow = interactor, 0, False
        self.scores = {}
        datasets = datasets if isinstance(datasets, (list, tuple)) else [datasets]
        self.view = MatchingView(interactor, datasets)
        self.scene, self.slices = self.view.scene, self.view.slices
        self.saver = Saver(datasets, paths)
        state = State([], []) if state is None else state  # a State without handles is falsy
        if target is None and len(state) == 0 and not state.handles:
            state = state.with_handles_at(self._lattice(_LATTICE_COUNTS[0]))
        self.document = Document(self.view, state, autosave)
        self._add_tools()
        if target is not None:
            self.set_target(target)
        self._mouse = MatchingMouse(interactor, self)
        self._keyboard = Keyboard(interactor, self)
        tick = self.document.tick
        self._timer_tag = interactor.AddObserver("TimerEvent", lambda *_: tick(), PRIORITY)
        if not interactor.GetInitialized():
            interactor.Initialize()
        self._timer = interactor.CreateRepeatingTimer(_TIMER_MILLISECONDS)
        self.document.show()
        self.say(self.offer)
        self.document.draw()  # as fine as the time of the first picture allows

    @property
    def state(self):
        """The displayed `State`; ahead of the history during a drag."""
        return self.document.state

    @property
    def selected(self):
        """Rows of the selected grips, point handles first: (m,) ints."""
        return self.document.selected

    @property
    def message(self):
        """The message in the window."""
        return self.view.overlay.message

    @property
    def status(self):
        """The status line in the corner of the window."""
        return self.view.overlay.status

    @property
    def offer(self):
        """A sentence that offers the unsaved edits of an earlier session; empty without any."""
        return self.document.offer

    def say(self, sentence):
        """Show a message in the window."""
        self.document.say(sentence)

    def do(self, name, value=None):
        """Call the method `name` as its key does: with `value` unless it is None."""
        self.finish()
        self.say("")
        with self.document.reporting_errors():
            getattr(self, name)(*(() if value is None else (value,)))
        if self.message != self.view.drawn_message:
            self.document.draw()

    def finish(self):
        """End drags of the mouse, and commit them."""
        self._mouse.finish()
        self.view.cut_widget.finish()
        self.view.motion_widget.finish()
        self.document.commit()

    def quit(self):
        """End the event loop of the interactor; a drag is committed."""
        self.finish()
        self._interactor.ExitCallback()

    def detach(self):
        """Remove everything of the editor from the window and the interactor."""
        self.finish()
        self._interactor.DestroyTimer(self._timer)
        self._interactor.RemoveObserver(self._timer_tag)
        self._cancel_tools()
        for part in (self._mouse, self._keyboard, self.view):
            part.detach()

    def change(self, state):
        """Commit a new state, or report that it has no map; whether it is displayed."""
        return self.document.change(state)

    def undo(self):
        """Return to the previous state."""
        self.document.step(-1, "There is nothing to undo.")

    def redo(self):
        """Repeat the edit that was undone."""
        self.document.step(1, "There is nothing to redo.")

    def select(self, rows):
        """Select these handles only."""
        self.document.select(rows)

    def select_all(self):
        """Select all handles."""
        self.select(np.arange(len(self.state.grips)))

    def deselect(self):
        """Clear the selection, and remove an unfinished line."""
        self._cancel_tools()
        self.select([])

    def add(self, point):
        """Add a handle at a point (3,) of the deformed data."""
        deformation = self.state.deformation()
        rest = point if deformation is None else deformation.backward([point])[0]
        if self.change(self.state.with_handle(rest, point)):
            self.select([len(self.state) - 1])

    def add_under_mouse(self):
        """Add a handle on the surface, or in the slice, under the mouse."""
        self._add_at(self._mouse.pixel)

    def add_clicked(self):
        """Add a handle at the next click, on the surface or in a slice."""
        self._cancel_tools()
        self._click_tool.wait(self._add_at, is_for_slices=True)
        self.say("Click on the surface, or in a slice, to add a handle.")

    def _add_at(self, pixel):
        self.say("")
        if self.target is not None:
            self.place_at(pixel)
            return
        self.document.show_deformed()
        point = self.view.point_at(pixel)
        if point is None:
            self.say(NO_SURFACE)
        else:
            self.add(point)

    def delete(self):
        """Delete what is selected, or under the mouse: points, regions, nodes of curves, mask."""
        rows = self.document.target_rows()
        if len(rows):
            self.document.clear_selection()
            self.change(self.state.without(rows))

    def fix(self):
        """Fix the selected handles, or the handle under the mouse; free them if all are fixed."""
        rows = self.document.target_rows()
        points = rows[rows < len(self.state)]
        if len(points):
            self.change(self.state.with_anchors(points))
        elif len(rows):
            self.say("Only point handles can be fixed.")

    def reset(self):
        """Return all handles to their rest positions."""
        self.change(self.state.at_rest())

    def lay_lattice(self):
        """Replace the handles by a lattice over the data; each call takes the next size."""
        self._lattice_number += 1
        count = _LATTICE_COUNTS[self._lattice_number % len(_LATTICE_COUNTS)]
        self.document.clear_selection()
        if self.change(self.state.with_handles_at(self._lattice(count, self.state.regions))):
            handles = f"{len(self.state)} handles, {count} along each axis"
            self.say(f"{handles}; Z restores the previous handles.")

    def change_kind(self):
        """Take the next kind of map."""
        self.change(self.state.with_next_kind())

    def change_alpha(self, factor):
        """Multiply alpha: handles act more locally for factors above 1."""
        alpha = self.state.alpha
        self.change(self.state.changed(alpha=ALPHA.limited(alpha * factor, alpha)))

    def change_smoothing(self, factor):
        """Multiply the smoothing length: handles are met less exactly for factors above 1."""
        minimum = _MIN_SMOOTHING * np.ptp(self.scene.bounds, axis=0).max()
        self.change(self.state.with_smoothing_times(factor, minimum))

    def prevent_folds(self):
        """Deform in steps that do not fold at sampled points, or in one."""
        self.change(self.state.changed(steps=0 if self.state.steps == 1 else 1))

    def change_nu(self, factor):
        """Multiply nu - 1: influence fades faster around cuts for factors above 1."""
        nu = self.state.nu
        self.change(self.state.changed(nu=NU.limited(1 + (nu - 1) * factor, nu)))

    def compare(self):
        """Show the data undeformed, or deformed again; not an edit."""
        self.document.toggle_deformed()

    def change_look(self):
        """Draw the data with their next presets of colors and opacities."""
        self.set_look(self.view.preset + 1)

    def set_look(self, index):
        """Draw the data with one of their presets of colors and opacities."""
        self.say(self.view.set_preset(index))
        self.document.draw()

    def show_step(self, index):
        """Show another time step of the first dataset, which is saved from then on."""
        self.scene.replace(self.saver.take_step(index))
        self.set_look(self.view.preset)
        self.document.show()

    def change_distortion(self):
        """Show the deformed grid, the change of volume, both, or neither, in this order."""
        self.set_distortion(self.view.distortion.mode + 1)

    def set_distortion(self, mode):
        """Show the distortion in the mode with this index in `distortion.MODES`."""
        self.view.distortion.mode = mode % len(MODES)
        self.say(TEXTS[self.view.distortion.mode])
        self.document.show()

    def toggle_slices(self):
        """Show or hide three slices beside the 3-D view."""
        self.show_pane(ONLY_3D if self.slices.is_visible else ALL)

    def show_pane(self, pane):
        """Show one of `slices.PANES`; one slice for all of them if there `is_narrow`."""
        if self.scene.flat_axis is None:
            self.view.set_pane(SLICES[0] if pane == ALL and self.is_narrow else pane)
        self.document.draw()

    def enlarge(self, pixel):
        """Show the slice or the 3-D view at a pixel alone, or all of them again."""
        pane = self.view.pane_at(pixel)
        name = ONLY_3D if pane is None else SLICES[2 - pane.axis]
        self.show_pane(ALL if self.slices.pane == name else name)

    def zoom(self, pixel, to, factor):
        """Zoom by a factor about a pixel, which moves to the pixel `to`."""
        self.document.zoom(pixel, to, factor)

    def move_slices(self, point):
        """Move the slices to a point (3,)."""
        self.document.move_slices(point)

    def hide_handles(self):
        """Hide or show handles and texts."""
        self.view.hide_handles()
        self.document.draw()

    def time(self):
        """Show or hide the computing times of maps and pictures."""
        self.view.shows_times = not self.view.shows_times
        self.document.draw()

    def reset_camera(self):
        """Fit the camera to the data."""
        self.view.reset_camera()
        self.document.draw()

    def accept(self):
        """End the curve that is drawn; without one, restore the unsaved edits that are offered."""
        if not self.end_curve():
            self.document.answer_offer(True)

    def decline(self):
        """Delete the unsaved edits that are offered."""
        self.document.answer_offer(False)

    def _lattice(self, count, regions=()):
        """Points (n, 3) of a lattice over the data, outside of regions."""
        points = handles_on(self.scene.items, self.scene.bounds, count)
        for region in regions:
            points = points[region.shape.distance(points)[0] > 0]
        return points
