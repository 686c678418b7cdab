"""An editor that draws off the screen, in a thread of its own, for a page."""

import gc
import queue
import threading
import time
from concurrent.futures import Future
from contextlib import suppress

import numpy as np
import vtkmodules.vtkInteractionStyle
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  draws
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkTextActor
from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

from vtk_mls.editor import Editor
from vtk_mls.editor.scene import new_window
from vtk_mls.editor.slices import ALL
from vtk_mls.model.options import KIND
from vtk_mls.web import panel_values
from vtk_mls.web.picture import pixel_of, send_event

_TICK = 0.015  # seconds between two timer events
_IDLE = 1.0  # seconds without work before garbage is collected
_NARROW = 600  # pixels of a picture below which one pane is shown
_SIZE = 900, 700  # pixels, before the page says its size


class Session:
    """An `Editor` in a thread of its own, so that the page is served while the editor computes.

    Parameters
    ----------
    on_change : callable
        Called in that thread with a dict of the changed values of the panel.

    Attributes
    ----------
    editor : Editor
        Only for functions that `call` calls.
    window : vtkRenderWindow
    working_since : float or None
        `time.monotonic()` at the start of the function that the thread calls now.
    on_draw, on_idle : callable
        Called in that thread after each picture, and when there is no other work.

    Notes
    -----
    An OpenGL context belongs to the thread that drew first, and so do VTK's objects with buffers
    and textures. Python's garbage collector would free such objects in any thread. Therefore it is
    off in this process, which serves one page, and this thread calls it when it is idle.
    """

    def __init__(self, on_change):
        self.editor = self.window = self._interactor = None
        self.on_draw = self.on_idle = lambda: None
        self._on_change, self._panel = on_change, {}
        self._calls, self.working_since = queue.SimpleQueue(), None
        self._thread = threading.Thread(target=self._work, name="editor", daemon=True)
        self._thread.start()

    def call(self, function):
        """A concurrent.futures.Future of the result of a function that the thread calls.

        The function may change the editor; `on_change` follows.
        """
        future = Future()
        self._calls.put((future, function))
        return future

    def open(self, datasets, state, paths, autosave, target=None):
        """Show other data, and a `Target`; in the editor's thread.

        After an error, a TypeError, ValueError, RuntimeError or MemoryError, the session is
        unchanged.
        """
        previous, size = self.editor, self.window.GetSize() if self.window else _SIZE
        if previous is not None:
            previous.finish()
        window, interactor = self._new_window(size)
        try:
            editor = Editor(interactor, datasets, state, paths, autosave, target)
        except BaseException:
            window.Finalize()
            raise
        if previous is not None:
            previous.detach()
            self.window.Finalize()
        self.editor, self.window, self._interactor = editor, window, interactor
        del previous
        gc.collect()
        self._leave_texts_to_page()
        self._fit_narrow_pictures(size)
        self._warm_up()

    def set_target(self, target):
        """Show a `Target` beside the data, without the initial handles; in the editor's thread."""
        editor = self.editor
        editor.finish()
        editor.set_target(target)
        if editor.state.is_resting.all() and not any(editor.state.labels):
            self._fit_narrow_pictures(self.window.GetSize())
            editor.select([])
            kind = "auto" if editor.state.kind == KIND.default else editor.state.kind
            editor.change(editor.state.with_handles_at([]).changed(kind=kind))

    def send(self, event):
        """Send an event of the page to the editor; in its thread.

        It is as of `send_event`, or of the type "zoom" with `factor` and the movement `dx`, `dy` of
        the fingers, or "cancel", which releases a button without a click.
        """
        kind = event["type"]
        if kind == "zoom":
            x, y = float(event["x"]), float(event["y"])
            ends = (x, y), (x + float(event["dx"]), y + float(event["dy"]))
            pixels = [pixel_of(self.window, *end) for end in ends]
            self.editor.zoom(*pixels, float(event["factor"]))
        elif kind == "cancel":
            self.editor.finish()
            send_event(self._interactor, {**event, "type": "up"})
        else:
            send_event(self._interactor, event)

    def resize(self, size):
        """Draw at the page's size (width, height) in pixels; in the editor's thread."""
        if tuple(size) != tuple(self.window.GetSize()):
            self.window.SetSize(*size)
            self._interactor.UpdateSize(*size)
            self._fit_narrow_pictures(size)
            self.window.Render()

    # The thread

    def _work(self):
        gc.disable()
        worked_at, ticked_at = time.monotonic(), 0.0
        while True:
            with suppress(queue.Empty):
                call = self._calls.get(timeout=_TICK)
                self.working_since = time.monotonic()
                self._answer(*call)
                self.working_since, worked_at = None, time.monotonic()
            if time.monotonic() - ticked_at >= _TICK or self._calls.empty():
                ticked_at = time.monotonic()
                self._tick()
            if worked_at is not None and time.monotonic() - worked_at > _IDLE:
                gc.collect()
                worked_at = None

    def _answer(self, future, function):
        try:
            try:
                result = function()
            finally:
                self._update_panel()
            future.set_result(result)
        except Exception as error:  # for the caller
            future.set_exception(error)

    def _tick(self):
        if self.editor is None:
            return
        try:
            self._interactor.InvokeEvent("TimerEvent")
            self._update_panel()
            self.on_idle()
        except Exception as error:  # the thread must not end
            reason = " ".join(str(error).split()) or type(error).__name__
            sentence = f"The page could not be kept up to date ({reason}): reload it."
            with suppress(Exception):
                self.editor.say(sentence)
                self._on_change({"message": sentence})

    def _update_panel(self):
        if self.editor is None:
            return
        values = panel_values.values_of(self.editor, self._panel)
        changed = {
            name: value
            for name, value in values.items()
            if name not in self._panel or self._panel[name] != value
        }
        if changed:
            self._on_change(changed)
            self._panel.update(changed)

    # The window

    def _new_window(self, size):
        window, interactor = new_window(), vtkGenericRenderWindowInteractor()
        window.SetOffScreenRendering(True)
        window.SetMultiSamples(0)
        window.SetSize(*size)
        window.AddObserver("EndEvent", lambda caller, event: self.on_draw())
        interactor.SetRenderWindow(window)
        interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
        return window, interactor

    def _leave_texts_to_page(self):
        """Remove texts from the picture: the page has its own, sharper."""
        renderer = self.editor.view.overlay.renderer
        for prop in [*renderer.GetViewProps()]:
            if isinstance(prop, vtkTextActor):
                renderer.RemoveViewProp(prop)

    def _fit_narrow_pictures(self, size):
        """In upright pictures, make the view angle the horizontal one; in narrow ones, one pane."""
        camera = self.editor.scene.renderer.GetActiveCamera()
        camera.SetUseHorizontalViewAngle(size[0] < size[1])
        self.editor.is_narrow = size[0] < _NARROW
        if self.editor.is_narrow and self.editor.slices.pane == ALL:
            self.editor.show_pane(ALL)

    def _warm_up(self):
        """Build kernels and shaders of the first map before the first drag."""
        state = self.editor.state.changed(blend=1.0)
        if state.is_identity:
            bounds = self.editor.scene.bounds
            step = 1e-3 * np.ptp(bounds, axis=0).max()
            if not len(state.grips):
                state = state.with_handle(bounds[0], bounds[0])
            state = state.moved([0], state.grips.rest[:1] + step)
        self._interactor.InvokeEvent("TimerEvent")  # with a running timer pictures are coarse first
        with suppress(ValueError, RuntimeError):  # the first edit reports it
            self.editor.document.preview(state.changed(anchored=None))
            self._interactor.InvokeEvent("TimerEvent")
        self.editor.document.preview(self.editor.document.committed)
