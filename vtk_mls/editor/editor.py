"""The editor: handles under the mouse, in any window of VTK."""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np

from vtk_mls.editor.cutting import Cutting
from vtk_mls.editor.first_handles import handles_on
from vtk_mls.editor.history import History
from vtk_mls.editor.keyboard import Keyboard
from vtk_mls.editor.mouse import PRIORITY, Mouse
from vtk_mls.editor.saving import Saver
from vtk_mls.editor.slice_mouse import SliceMouse
from vtk_mls.editor.state import State
from vtk_mls.editor.view import View

_TICK = 15  # milliseconds
_LATTICES = 3, 4, 5, 2  # handles along each axis
_NOTHING = np.zeros(0, int)
# What a deformation that cannot be had is told by, in the window.
FAILURES = (ValueError, TypeError, RuntimeError, MemoryError)


class Editor:
    """Edits a deformation of images and meshes by mouse and keys, which a legend explains.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
        With its window; any of its kinds, also one without a display. The editor draws into the
        window's first renderer, or its own if there is none.
    datasets : vtkDataSet or list of vtkDataSet
        Images are drawn as volumes, all else as surfaces; the same handles move them all.
    state : State, optional
        Where to begin; without handles, or if not given, with a lattice over the data.
    paths : list of path, optional
        Of the datasets, for what is saved.
    autosave : Autosave, optional
        Keeps unsaved edits.

    Attributes
    ----------
    state : State
        That is shown; while handles are dragged it is ahead of the history.
    selected : (m,) ints
        Rows of handles.
    hovered, grabbed : int or None
        The handle under the mouse, and the one it holds.
    scene : Scene
    slices : Slices
    saver : Saver
    shows_before : bool
        Whether the data are seen as they were; the next edit shows them deformed again.

    Raises
    ------
    TypeError, ValueError
        If a dataset cannot be shown.

    Notes
    -----
    Keep this object as long as it edits: VTK does not hold it. Nothing is resampled: see
    `DeformedVolume` and `DeformedMesh`. A drag shows as fine a map as is ready in time, and the
    finest when it ends.
    """

    def __init__(self, interactor, datasets, state=None, paths=(), autosave=None):
        self._interactor = interactor
        datasets = datasets if isinstance(datasets, (list, tuple)) else [datasets]
        self._view = View(interactor, datasets)
        self.scene, self.slices = self._view.scene, self._view.slices
        self.saver = Saver(datasets, paths)
        self.selected, self.hovered, self.grabbed = _NOTHING, None, None
        self._held, self._is_wanted, self._lattices = _NOTHING, False, 0
        self.shows_before = False
        state = State([], []) if state is None else state  # one without handles is falsy
        if len(state) == 0:
            state = state.with_handles_at(self._lattice(_LATTICES[0]))
        self._history = History(state)
        self.state = self._history.state
        self._autosave, self._saved_state = autosave, self.state
        self._mouse, self._cutting = Mouse(interactor, self), Cutting(self, interactor)
        self._slice_mouse = SliceMouse(interactor, self, self.slices)
        self._keyboard = Keyboard(interactor, self)
        self._tick_tag = interactor.AddObserver("TimerEvent", self._tick, PRIORITY)
        if not interactor.GetInitialized():
            interactor.Initialize()
        self._timer = interactor.CreateRepeatingTimer(_TICK)
        self._show(is_final=True)
        self.say(self.offer)
        self._draw()  # as fine as the first picture has shown to be possible

    # what the mouse does

    @property
    def projection(self):
        """How the world is seen now."""
        return self.scene.projection

    def surfaces(self):
        """What one sees now."""
        return self.scene.surfaces()

    def hover(self, row):
        """Show that the mouse is over a handle, or over none for None."""
        if row != self.hovered and not self._view.hides_handles:
            self.hovered = row
            self._draw(is_moving=True)

    def select(self, rows):
        """Select handles, and no others."""
        self.selected = np.asarray(rows, int)
        self._draw(is_moving=True)

    def take(self, rows, grabbed):
        """Hold handles by one of them."""
        self._show_after()
        self._held, self.grabbed = np.asarray(rows, int), grabbed
        if self.state.anchored[self._held].all():
            self.say("This handle is fixed; F frees it.")
        self._draw(is_moving=True)

    def drag_to(self, positions):
        """Move what is held; the newest positions are shown at the next tick."""
        self.preview(self.settled.moved(self._held, positions))

    def let_go(self):
        """End the drag: what it has moved is an edit."""
        self._held, self.grabbed = _NOTHING, None
        if (self.state.deformed == self.settled.deformed).all():
            self.state, self._is_wanted = self.settled, False
            self._draw(is_moving=True)
        self.settle()

    def show_band(self, corners):
        """Show the rubber band between two pixels, or none for None."""
        self._view.set_band(corners)
        self._draw(is_moving=True)

    def preview(self, state):
        """Show a state that is no edit yet; the newest one at the next tick."""
        self.shows_before = False
        self.state, self._is_wanted = state, True
        if not self._view.ticks:
            self._follow()

    def settle(self):
        """Make an edit of what is previewed."""
        self._is_wanted = False
        state, self.state = self.state, self.settled
        if state is not self.settled:
            self.change(state)

    def finish(self):
        """Let go of what the mouse holds: it is an edit."""
        self._mouse.finish()
        self._slice_mouse.finish()
        self._cutting.finish()
        self.settle()

    @property
    def settled(self):
        """The state without what is only previewed."""
        return self._history.state

    # edits

    def change(self, state):
        """Go on to a new state, which can be undone; one that has no map is told instead.

        Returns
        -------
        bool
            Whether it could be shown.
        """
        self.shows_before = False
        before, self.state = self.state, state
        self._forget_rows_that_are_gone()
        if not self._show(is_final=True):
            self.state = before
            self._show(is_final=True, is_quiet=True)
            return False
        self._history.push(state)
        self._keep()
        return True

    def undo(self):
        """Go back to the state before."""
        self._step(self._history.undo(), "There is nothing to undo.")

    def redo(self):
        """Do again what was undone."""
        self._step(self._history.redo(), "There is nothing to do again.")

    def add_under_mouse(self):
        """Add a handle on the surface under the mouse."""
        self._show_after()
        pane = self.slices.pane_at(self._mouse.pixel)
        if pane is not None:
            self.add(pane.point_at(self._mouse.pixel))
            return
        point = self.surfaces().hit(self.projection, self._mouse.pixel)
        if point is None:
            self.say("There is no surface under the mouse.")
        else:
            self.add(point)

    def add(self, point):
        """Add a handle at a point (3,) of the deformed data, whose material it takes."""
        deformation = self.state.deformation()
        rest = point if deformation is None else deformation.backward([point])[0]
        if self.change(self.state.with_handle(rest, point)):
            self.select([len(self.state) - 1])

    def delete(self):
        """Delete what is selected, or the handle under the mouse."""
        rows = self._meant()
        if len(rows):
            self.selected, self.hovered = _NOTHING, None
            self.change(self.state.without(rows))

    def fix(self):
        """Anchor what is selected, or the handle under the mouse; or free it if it is anchored."""
        rows = self._meant()
        if len(rows):
            self.change(self.state.with_anchors(rows))

    def select_all(self):
        """Select all handles."""
        self.select(np.arange(len(self.state)))

    def deselect(self):
        """Select none, and draw no line on."""
        self._cutting.drop_line()
        self.select(_NOTHING)

    def reset(self):
        """Put all handles back to where they rest."""
        self.change(self.state.at_rest())

    def lay_lattice(self):
        """Replace the handles by a lattice on the data; each time another one."""
        self._lattices += 1
        count = _LATTICES[self._lattices % len(_LATTICES)]
        self.selected, self.hovered = _NOTHING, None
        if self.change(self.state.with_handles_at(self._lattice(count))):
            handles = f"{len(self.state)} handles, {count} along each axis"
            self.say(f"{handles}; Z brings the others back.")

    def change_kind(self):
        """Fit maps of the next kind."""
        self.change(self.state.with_next_kind())

    def change_alpha(self, factor):
        """Let handles act more or less locally."""
        self.change(self.state.with_alpha_times(factor))

    def change_nu(self, factor):
        """Let influence fade more or less with the detour around cuts."""
        self.change(self.state.with_nu_times(factor))

    def change_cut(self):
        """Cut by a plane, by a half-plane, or not at all, in this order."""
        self._cutting.change_shape()

    def change_half(self):
        """Cut by another half of the plane."""
        self._cutting.change_half()

    def incise(self):
        """Begin a line on the surface, or cut along it."""
        self._cutting.incise()

    def draw_line_to(self, pixel):
        """Go on with a line on the surface; whether one is being drawn."""
        self._show_after()
        is_drawn = self._cutting.draw_line_to(pixel)
        if is_drawn:
            self._draw(is_moving=True)
        return is_drawn

    # what is seen

    def compare(self):
        """Show the data as they were, or deformed again; no edit."""
        self.shows_before = not self.shows_before
        self._show(is_final=True)

    def change_look(self):
        """Draw the data by their next look."""
        self.say(self._view.change_look())
        self._draw()

    def toggle_slices(self):
        """Show slices beside the 3-D view, or not."""
        self.slices.toggle()
        self._draw()

    def look_at(self, point, is_moving=False):
        """Lay the slices through a point (3,)."""
        with self.telling():
            self.slices.move_to(point, not is_moving)
        self._draw(is_moving)

    def hide_handles(self):
        """Hide handles and texts, or show them again."""
        self._view.hide_handles()
        self._cutting.set_visible(not self._view.hides_handles)
        self._draw()

    def toggle_legend(self):
        """Hide or show the legend of keys."""
        self._view.toggle_legend()
        self._draw()

    def time(self):
        """Show how long maps and pictures take, or no more."""
        self._view.toggle_times()
        self._draw()

    def reset_camera(self):
        """See all of the data."""
        self.scene.reset_camera()
        self._draw()

    def save(self):
        """Save handles, deformed data, displacement field, picture and script.

        Returns
        -------
        bool
            Whether all are saved.
        """
        self.finish()
        self._show_after()
        self.say("Saving ...")
        self._draw(is_moving=True)
        self._cutting.set_visible(False)
        self._view.draw_for_file(self.state)
        self._cutting.set_visible(not self._view.hides_handles)
        try:
            sentence = self.saver.save(self.state, self.scene.window)
        except (OSError, *FAILURES) as error:
            sentence, is_saved = _sentence(error), False
        else:
            is_saved = True
            self._saved_state = self.state
            if self._autosave is not None:
                self._autosave.note_save()
        self.say(sentence)
        self._draw()
        return is_saved

    def accept(self):
        """Take what is offered."""
        if not self.offer:
            self.say("Nothing is offered.")
            return
        self.selected, self.hovered = _NOTHING, None
        if self.change(self._autosave.offered):
            self._autosave.take()
            self.say("They are back; Z takes the others again.")

    def decline(self):
        """Drop what is offered, for good."""
        if not self.offer:
            self.say("Nothing is offered.")
            return
        self._autosave.drop()
        self.say("They are dropped.")

    @property
    def offer(self):
        """A sentence that offers the unsaved edits of an earlier session; empty without any."""
        return self._autosave.offer if self._autosave is not None else ""

    def say(self, sentence):
        """Show a sentence in the window."""
        self._view.say(sentence)

    @property
    def message(self):
        """What the window says."""
        return self._view.message

    @property
    def status(self):
        """How it is, as the window has it in its corner."""
        return self._view.status

    def quit(self):
        """End the interactor's loop; what is dragged is let go."""
        self.finish()
        self._interactor.ExitCallback()

    def detach(self):
        """Leave window and interactor to themselves."""
        self.finish()
        self._mouse.detach()
        self._slice_mouse.detach()
        self._cutting.detach()
        self._interactor.DestroyTimer(self._timer)
        self._interactor.RemoveObserver(self._tick_tag)
        self._keyboard.detach()
        self._view.detach()

    # events

    def do(self, name, value=None):
        """Do what a key is for: one of the methods, with its argument or None."""
        self.finish()
        self.say("")
        with self.telling():
            getattr(self, name)(*(() if value is None else (value,)))
        if self.message != self._view.drawn_message:
            self._draw()

    @contextmanager
    def telling(self):
        """Say in one sentence what fails in a block, a device as a rule; the editor goes on."""
        try:
            yield
        except FAILURES as error:
            self.say(_sentence(error))

    def _tick(self, interactor, event):
        self._view.ticks = True
        if self._is_wanted:
            self._follow()
        elif self._view.is_finer_due:
            self._draw()

    # drawing

    def _follow(self):
        """Show where the drag is now."""
        self._is_wanted = False
        self._show(is_final=False)

    def _show(self, is_final, is_quiet=False):
        """Draw the state as it is; whether there is a map for it."""
        try:
            self._view.show(self._seen, is_final)
        except FAILURES as error:
            if not is_quiet:
                self.say(_sentence(error))
            self._draw(is_moving=True)
            return False
        self._draw(is_moving=not is_final)
        return True

    def _draw(self, is_moving=False):
        """Make a picture; a coarse one while something moves."""
        self._cutting.show(self.state)
        self._view.shows_before = self.shows_before
        self._view.draw(self.state, self.selected, self.hovered, self._held, is_moving)

    @property
    def _seen(self):
        """The state by which the data are drawn."""
        return self.state.changed(blend=0.0) if self.shows_before else self.state

    def _show_after(self):
        """Show the data deformed, for the mouse is to find what it sees."""
        if self.shows_before:
            self.compare()

    def _step(self, has_stepped, otherwise):
        if not has_stepped:
            self.say(otherwise)
            return
        self.state, self.hovered, self.shows_before = self.settled, None, False
        self._forget_rows_that_are_gone()
        self._show(is_final=True)
        self._keep()

    def _forget_rows_that_are_gone(self):
        """Neither select nor hover what the state has not."""
        count = len(self.state)
        self.selected = self.selected[self.selected < count]
        if self.hovered is not None and self.hovered >= count:
            self.hovered = None

    def _keep(self):
        """Keep the state as it is now, unless it is saved."""
        if self._autosave is None:
            return
        try:
            self._autosave.keep(None if self.state is self._saved_state else self.state)
        except OSError as error:
            self.say(_sentence(error))
            self._draw()

    def _meant(self):
        """Rows of what is selected, or of the handle under the mouse."""
        if len(self.selected):
            return self.selected
        if self.hovered is None:
            self.say("Select handles first: click on one, or Ctrl and drag beside them.")
            return _NOTHING
        return np.array([self.hovered])

    def _lattice(self, count):
        return handles_on(self.scene.shown, self.scene.bounds, count)


def _sentence(error):
    text = " ".join(str(error).split()) or "There is not enough memory."
    return text[0].upper() + text[1:] + "." * (text[-1] not in ".!?")
