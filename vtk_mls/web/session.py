"""What one page edits: a window off the screen, its editor, and what the page is told of it."""

from __future__ import annotations

import gc
from contextlib import suppress

import numpy as np
import vtkmodules.vtkInteractionStyle
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  draws
from vtkmodules.vtkCommonCore import vtkLogger
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkTextActor
from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

from vtk_mls.editor import Editor
from vtk_mls.editor import keys as editor_keys
from vtk_mls.web import events, panel_values
from vtk_mls.web.worker import Worker

_SIZE = 900, 700
# Keys that the page answers by itself.
_OF_THE_PAGE = "save", "quit", "toggle_legend", "change_look"
_NOT_SENT = {name for name, (method, _) in editor_keys.actions().items() if method in _OF_THE_PAGE}


class Session:
    """An `Editor` in a thread of its own.

    Parameters
    ----------
    told : callable
        Called there with a dict of what has changed for the panel.

    Attributes
    ----------
    editor : Editor
        Only for functions that `call` calls.
    window : vtkRenderWindow
    drawn, idle : callable
        Called there after each picture, and when there is nothing else to do.
    """

    def __init__(self, told):
        self.editor = self.window = self._interactor = None
        self.drawn = self.idle = lambda: None
        self._told, self._said, self._saved, self.look = told, {}, None, 0
        self._worker = Worker(self._tick)
        self._worker.start()

    def call(self, function):
        """A Future of what a function returns that is called in the editor's thread.

        It may change the editor; the panel is told what has changed.
        """
        return self._worker.call(lambda: self._watched(function))

    def open(self, datasets, state, paths, autosave):
        """Show data instead of those that were shown; in the editor's thread.

        Raises
        ------
        TypeError, ValueError, RuntimeError, MemoryError
            If they cannot be shown; all is then as before.
        """
        before, size = self.editor, self.window.GetSize() if self.window else _SIZE
        if before is not None:
            before.finish()
        window, interactor = self._new_window(size)
        try:
            editor = Editor(interactor, datasets, state, paths, autosave)
        except BaseException:
            window.Finalize()
            raise
        if before is not None:
            before.detach()
            self.window.Finalize()
        self.editor, self.window, self._interactor, self.look = editor, window, interactor, 0
        del before
        gc.collect()
        _leave_texts_to_the_page(self.editor)
        self._saved = self.editor.state
        self._see_all_of_narrow(size)
        self._warm_up()

    def send(self, event):
        """Send an event of the page to the editor; in its thread."""
        if not (event["type"] == "key" and _name_of(event) in _NOT_SENT):
            events.send(self._interactor, event)

    def resize(self, size):
        """Draw as large as the page shows it; in the editor's thread."""
        if tuple(size) != tuple(self.window.GetSize()):
            self._see_all_of_narrow(size)
            self.window.SetSize(*size)
            self._interactor.UpdateSize(*size)
            self.window.Render()

    def _see_all_of_narrow(self, size):
        """Have pictures higher than wide show as much across as others show along their height."""
        camera = self.editor.scene.renderer.GetActiveCamera()
        camera.SetUseHorizontalViewAngle(size[0] < size[1])

    def set_look(self, number):
        """Draw the data by one of their looks; in the editor's thread."""
        self.look = number
        self.editor.say(self.editor.scene.set_preset(number))
        self.editor.slices.show(is_final=True)
        self.editor.select(self.editor.selected)  # draws

    def save(self):
        """Save all; in the editor's thread. The folder.

        Raises
        ------
        OSError
            With the editor's sentence, if it could not.
        """
        if not self.editor.save():
            raise OSError(self.editor.message)
        self._saved = self.editor.state
        self.editor.say("Saved.")
        return self.editor.saver.folder

    def _warm_up(self):
        """Have the first map's kernels and shaders built before the first handle is dragged."""
        state = self.editor.state.changed(blend=1.0)
        if state.is_resting.all():
            state = state.moved([0], state.rest[:1] + 1e-3 * np.ptp(state.rest, axis=0).max())
        self._interactor.InvokeEvent("TimerEvent")  # pictures are coarse where time goes on
        with suppress(ValueError, RuntimeError):  # the first edit says what is wrong
            self.editor.document.preview(state.changed(anchored=None))
            self._interactor.InvokeEvent("TimerEvent")
        self.editor.document.preview(self.editor.document.committed)

    def _new_window(self, size):
        """A window off the screen, and its interactor."""
        window, interactor = _window(), vtkGenericRenderWindowInteractor()
        window.SetOffScreenRendering(True)
        window.SetMultiSamples(0)
        window.SetSize(*size)
        window.AddObserver("EndEvent", self._tell_drawn)
        interactor.SetRenderWindow(window)
        interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
        return window, interactor

    def _tell_drawn(self, window, event):
        self.drawn()

    def _watched(self, function):
        try:
            return function()
        finally:
            self._tell()

    def _tick(self):
        if self.editor is None:
            return
        try:
            self._interactor.InvokeEvent("TimerEvent")
            self._tell()
            self.idle()
        except Exception as error:  # whatever it is, nobody else has this thread's work
            self._tell_failure(error)

    def _tell_failure(self, error):
        reason = " ".join(str(error).split()) or type(error).__name__
        sentence = f"The page could not be kept up to date ({reason}): reload it."
        with suppress(Exception):  # nobody can be told then
            self.editor.say(sentence)
            self._told({"message": sentence})

    def _tell(self):
        if self.editor is None:
            return
        values = panel_values.values_of(self.editor, self._said, self.look)
        values["is_saved"] = self.editor.state is self._saved
        changed = {
            name: value
            for name, value in values.items()
            if name not in self._said or self._said[name] != value
        }
        if changed:
            self._told(changed)
            self._said.update(changed)


def _window():
    """A window, which may have looked for a display in vain."""
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        return vtkRenderWindow()
    finally:
        vtkLogger.SetStderrVerbosity(verbosity)


def _name_of(event):
    """What the editor calls the key of an event."""
    key = event["key"].lower() if len(event["key"]) == 1 else event["key"]
    return f"Ctrl+{key}" if event.get("ctrl") else key


def _leave_texts_to_the_page(editor):
    """Take texts out of the picture: the page has its own, which stay sharp."""
    for prop in [*editor.scene.overlay.GetViewProps()]:
        if isinstance(prop, vtkTextActor):
            editor.scene.overlay.RemoveViewProp(prop)
