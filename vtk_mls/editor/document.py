"""The edited state, its history and its selection, drawn in a view."""

from contextlib import contextmanager

import numpy as np

from vtk_mls import RegionHandle
from vtk_mls.editor.grips import NO_ROWS, POINT
from vtk_mls.editor.turning import HandleGroup

# Errors of a deformation or its device, which the window shows.
FAILURES = (ValueError, TypeError, RuntimeError, MemoryError)
NO_SURFACE = "There is no surface at this place: click on the data, or in a slice of them."


class Document:
    """A `State` in a `View`, with undo, selection, and an `Autosave` or None.

    Attributes
    ----------
    state : State
        The displayed state. A preview is not in the history yet.
    selected : (m,) ints
        Rows of grips: those of point handles are the rows of the state.
    hovered, grabbed : int or None
        The grip under the mouse, and the grip that the mouse drags.
    dragged : (m,) ints
        Rows of the grips that the mouse drags.
    """

    def __init__(self, view, state, autosave=None):
        self.view, self.state, self._autosave = view, state, autosave
        self.selected = self.dragged = NO_ROWS
        self.hovered = self.grabbed = None
        self._states, self._index, self._saved = [state], 0, state
        self._is_preview_due = False
        self._group = None
        self._in_drag = state  # the committed one, with the settings that a drag keeps

    @property
    def committed(self):
        """The latest state in the history, without a preview."""
        return self._states[self._index]

    def change(self, state):
        """Commit a new state unless it has no map; whether it is displayed."""
        self.view.shows_undeformed = False
        previous, self.state = self.state, state
        self._drop_missing_rows()
        if not self.show():
            self.state = previous
            self.show(is_quiet=True)
            return False
        self._states[self._index + 1 :] = [state]
        self._index += 1
        self._save_automatically()
        return True

    def step(self, count, message):
        """Undo (-1) or redo (1) one edit; say `message` at the end of the history."""
        index = self._index + count
        if not 0 <= index < len(self._states):
            self.say(message)
            return
        self._index, self.hovered = index, None
        self.state, self.view.shows_undeformed = self.committed, False
        self._drop_missing_rows()
        self.show()
        self._save_automatically()

    def preview(self, state):
        """Show a state that is not committed; with a timer, at the next tick."""
        self.view.shows_undeformed = False
        self.state, self._is_preview_due = state, True
        if not self.view.has_timer:
            self._show_preview()

    def commit(self):
        """Commit the preview."""
        self._is_preview_due = False
        state, self.state = self.state, self.committed
        if state is not self.committed:
            self.change(state)

    def tick(self):
        """Show the latest preview, or refine the picture after the last movement."""
        self.view.has_timer = True
        if self._is_preview_due:
            self._show_preview()
        elif self.view.is_refinement_due:
            if self.view.slices.is_coarse:
                self.view.show_slices()
            self.draw()

    def select(self, rows):
        """Select these grips only."""
        self.selected = np.asarray(rows, int)
        self.draw(is_moving=True)

    def hover(self, row):
        """Highlight the handle under the mouse, or none for None."""
        if row != self.hovered and not self.view.hides_handles:
            self.hovered = row
            self.draw(is_moving=True)

    @property
    def selected_region(self):
        """The index of the region that alone is selected; None without one."""
        state, selected = self.state, self.selected
        owner = int(state.grips.owner[selected[0]]) if len(selected) == 1 else POINT
        is_region = owner >= 0 and isinstance(state.handles[owner], RegionHandle)
        return owner if is_region else None

    @property
    def group(self):
        """The `HandleGroup` of the selected handles, if a box turns them; None without."""
        group = self._group
        if group is None or not np.array_equal(group.rows, self.selected):
            self._group = None
        elif not np.array_equal(group.positions, self.committed.deformed[group.rows]):
            self.turn_selected()
        return self._group

    def turn_selected(self):
        """Let a box turn the selected point handles."""
        self._group = HandleGroup(self.selected, self.committed.deformed[self.selected])

    def target_rows(self):
        """Rows of the selected grips; without a selection, of the grip under the mouse."""
        if len(self.selected):
            return self.selected
        if self.hovered is None:
            self.say("Select handles first: click on one, or hold Ctrl and drag beside them.")
            return NO_ROWS
        return np.array([self.hovered])

    def clear_selection(self):
        """Clear the selection and the hovered handle, before rows change; draw nothing."""
        self.selected, self.hovered = NO_ROWS, None

    def start_drag(self, rows, grabbed):
        """Start to drag grips `rows` by the grip `grabbed`."""
        self.show_deformed()
        self.dragged, self.grabbed = np.asarray(rows, int), grabbed
        self._in_drag = self.committed.with_chosen_settings()
        if self.state.grips.anchored[self.dragged].all():
            self.say("This handle is fixed; F frees it.")
        self.draw(is_moving=True)

    def drag_to(self, positions):
        """Preview new positions (m, 3) of the dragged grips."""
        self.preview(self._in_drag.moved(self.dragged, positions))

    def end_drag(self):
        """End the drag and commit it."""
        self.dragged, self.grabbed = NO_ROWS, None
        if (self.state.grips.deformed == self.committed.grips.deformed).all():
            self.state, self._is_preview_due = self.committed, False
            self.draw(is_moving=True)
        else:
            self.state = self.state.with_settings_of(self.committed)
        self.commit()

    def toggle_deformed(self):
        """Show the data undeformed, or deformed again; not an edit."""
        self.view.shows_undeformed = not self.view.shows_undeformed
        self.show()

    def show_deformed(self):
        """Show the data deformed, before the mouse picks a point on them."""
        if self.view.shows_undeformed:
            self.toggle_deformed()

    def move_slices(self, point, is_moving=False):
        """Move the slices to a point (3,)."""
        with self.reporting_errors():
            self.view.slices.move_to(point)
            self.view.show_slices(not is_moving)
        self.draw_slices() if is_moving else self.draw()

    def zoom(self, pixel, to, factor):
        """Zoom as of `View.zoom`."""
        with self.reporting_errors():
            self.draw_slices() if self.view.zoom(pixel, to, factor) else self.draw(is_moving=True)

    def show(self, is_final=True, is_quiet=False):
        """Deform and draw the data; whether the state has a map."""
        try:
            self.view.show(self.state, is_final)
        except FAILURES as error:
            if not is_quiet:
                self.say(sentence_of(error))
            self.draw(is_moving=True)
            return False
        self.draw(is_moving=not is_final)
        return True

    @property
    def is_saved(self):
        """Whether there is no edit since the last save, or the start."""
        return self.committed is self._saved

    def draw(self, is_moving=False):
        """Render; coarsely while something moves."""
        self.view.overlay.note = "" if self.state is self._saved else "unsaved"
        self.view.motion_widget.show(*self._boxed())
        self.view.draw(self.state, self.selected, self.hovered, self.dragged, is_moving)

    def draw_slices(self):
        """Render the slices while the mouse changes nothing else."""
        self.view.draw_slices(self.state, self.selected, self.hovered, self.dragged)

    def say(self, sentence):
        """Show a message in the window."""
        self.view.overlay.say(sentence)

    @contextmanager
    def reporting_errors(self):
        """Show errors of a deformation or its device as a message."""
        try:
            yield
        except FAILURES as error:
            self.say(sentence_of(error))

    @property
    def offer(self):
        """A sentence that offers the unsaved edits of an earlier session; empty without any."""
        return "" if self._autosave is None else self._autosave.offer

    def answer_offer(self, is_accepted):
        """Commit the state that is offered, or delete it."""
        if not self.offer:
            self.say(f"There are no unsaved edits to {'restore' if is_accepted else 'delete'}.")
        elif not is_accepted:
            self._autosave.delete_offer()
            self.say("The unsaved edits are deleted.")
        else:
            self.clear_selection()
            if self.change(self._autosave.offered):
                self._autosave.offered = None  # its file holds the state until a save
                self.say("The unsaved edits are restored; Z returns to the other handles.")

    def note_save(self):
        """The state was saved: end the offer of unsaved edits."""
        self._saved = self.state
        if self._autosave is not None:
            self._autosave.note_save()

    def _save_automatically(self):
        if self._autosave is None:
            return
        try:
            self._autosave.store(None if self.state is self._saved else self.state)
        except OSError as error:
            self.say(sentence_of(error))
            self.draw()

    def _boxed(self):
        """The shape that a box turns, and its motion (4, 4)."""
        region = self.selected_region
        if region is not None:
            return self.state.handles[region].shape, self.state.handles[region].motion
        group = self.group
        return (None, None) if group is None else (group, group.motion)

    def _show_preview(self):
        self._is_preview_due = False
        self.show(is_final=False)

    def _drop_missing_rows(self):
        count = len(self.state.grips)
        self.selected = self.selected[self.selected < count]
        if self.hovered is not None and self.hovered >= count:
            self.hovered = None


def sentence_of(error):
    """The message of an error as one line, with a capital letter and a full stop."""
    text = " ".join(str(error).split()) or "There is not enough memory."
    return text[0].upper() + text[1:] + "." * (text[-1] not in ".!?")
