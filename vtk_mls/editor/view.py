"""What a window shows of a state: data, handles and texts, as fine as there is time for."""

from __future__ import annotations

import time

import numpy as np

from vtk_mls.editor import keys
from vtk_mls.editor.handle_glyphs import Marks
from vtk_mls.editor.overlay import Overlay
from vtk_mls.editor.pace import Pace
from vtk_mls.editor.scene import Scene
from vtk_mls.editor.slices import Slices

_SETTLED = 0.25  # seconds without a move, after which the picture is drawn as fine as it can be
_NOTHING = np.zeros(0, int)


class View:
    """Draws states into the window of an interactor.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
    datasets : list of vtkDataSet

    Attributes
    ----------
    scene : Scene
    slices : Slices
    ticks : bool
        Whether a timer is known to run, so that coarse pictures are replaced by finer ones.
    hides_handles : bool
    drawn_message : str
        What the last picture says.
    shows_before : bool
        Whether the corner says that the data are seen as they were.
    """

    def __init__(self, interactor, datasets):
        window, style = interactor.GetRenderWindow(), interactor.GetInteractorStyle()
        self.scene = Scene(window, datasets)
        self.slices = Slices(self.scene)
        self.ticks = self.hides_handles = self.shows_before = False
        self.drawn_message = ""
        self._overlay, self._pace = Overlay(self.scene.overlay, keys.legend(), keys.HINT), Pace()
        self._looks, self._shows_times, self._moved_at = 0, False, None
        self._tags = [
            (observed, observed.AddObserver(event, what))
            for observed, event, what in (
                (window, "StartEvent", self._lay_out),
                (style, "StartInteractionEvent", self._start_moving),
                (style, "EndInteractionEvent", self._stop_moving),
            )
        ]

    # data

    def show(self, state, is_final):
        """Have the next pictures show the data as a state deforms them.

        Raises
        ------
        ValueError, TypeError, RuntimeError, MemoryError
            If there is no map, or nobody who computes it.
        """
        deformation = state.deformation()

        def make_map(nodes):
            self.scene.show(deformation, nodes, is_final)
            self.slices.show(is_final)

        if deformation is None:
            make_map(self._pace.nodes)
        else:
            self._pace.make(make_map, not is_final)

    def change_look(self):
        """Draw the data by their next look, whose name is returned."""
        self._looks += 1
        name = self.scene.set_look(self._looks)
        self.slices.show(is_final=True)
        return name

    # pictures

    def draw(self, state, selected, hovered, held, is_moving=False):
        """Make a picture; a coarse one while something moves, if a timer will make a finer one."""
        is_moving, pace = is_moving and self.ticks, self._pace
        pixels = pace.pixels_while_moving() if is_moving else pace.pixels_at_rest()
        self.scene.set_coarseness(pixels)
        marks = Marks(state, selected, hovered, held, not self.hides_handles)
        self.scene.glyphs.show(marks)
        self.slices.mark(marks)
        self._overlay.set_status(self._status(state, selected))
        self.drawn_message = self.message
        started = time.perf_counter()
        self.scene.renderer.ResetCameraClippingRange()
        self.scene.window.Render()
        pace.note_picture(pixels, time.perf_counter() - started)
        self._moved_at = time.monotonic() if is_moving and pixels > 1 else None

    def draw_for_file(self, state):
        """Make a picture as fine as it can be, without texts."""
        has_keys = self._overlay.shows_keys
        self._overlay.set_texts_visible(False)
        self._overlay.set_message_visible(False)
        self.scene.set_coarseness(self._pace.pixels_for_file())
        marks = Marks(state, _NOTHING, None, _NOTHING, not self.hides_handles)
        self.scene.glyphs.show(marks)
        self.slices.mark(marks)
        self.scene.window.Render()
        self._overlay.set_texts_visible(not self.hides_handles)
        self._overlay.set_keys_visible(has_keys)
        self._overlay.set_message_visible(True)

    @property
    def is_finer_due(self):
        """Whether nothing has moved for long enough to replace a coarse picture."""
        return self._moved_at is not None and time.monotonic() - self._moved_at > _SETTLED

    # what stands over them

    def say(self, sentence):
        """Show a sentence."""
        self._overlay.say(sentence)

    @property
    def status(self):
        """How it is, as the corner has it."""
        return self._overlay.status

    @property
    def message(self):
        """What it says."""
        return self._overlay.message.replace("\n", " ")

    def set_band(self, corners):
        """Show a rubber band between two pixels, or none for None."""
        self._overlay.set_band(corners)

    def hide_handles(self):
        """Hide handles, legend, hint and status, or show them again; what is said is seen."""
        self.hides_handles = not self.hides_handles
        self.scene.glyphs.set_visible(not self.hides_handles)
        self._overlay.set_texts_visible(not self.hides_handles)

    def toggle_legend(self):
        """Hide or show the legend of keys."""
        self._overlay.set_keys_visible(not self._overlay.shows_keys)

    def toggle_times(self):
        """Show how long maps and pictures take, or no more."""
        self._shows_times = not self._shows_times

    def detach(self):
        """Leave the window to itself."""
        for observed, tag in self._tags:
            observed.RemoveObserver(tag)
        self.slices.detach()
        self.scene.detach()

    def _lay_out(self, window, event):
        self._overlay.lay_out()

    def _start_moving(self, style, event):
        """The camera moves: pictures are coarse."""
        self.scene.set_coarseness(self._pace.pixels_while_moving())
        self._moved_at = None

    def _stop_moving(self, style, event):
        """The camera rests: a finer picture is due, now if no timer will ask for it."""
        self._moved_at = time.monotonic()
        if not self.ticks:
            self._draw_again()

    def _draw_again(self):
        """Make a picture of the same as fine as it can be."""
        self.scene.set_coarseness(self._pace.pixels_at_rest())
        self.scene.window.Render()
        self._moved_at = None

    def _status(self, state, selected):
        pace = self._pace
        parts = [f"{len(state)} handles", state.kind, f"alpha {state.alpha:g}"]
        parts += [f"{len(selected)} selected"] * (len(selected) > 0)
        parts += [f"{int(state.anchored.sum())} fixed"] * bool(state.anchored.any())
        parts += [f"blend {state.blend:g}"] * (state.blend != 1)
        parts += ["shown as it was before; B"] * self.shows_before
        if self._shows_times:
            parts.append(f"map {1e3 * pace.map_seconds:.0f} ms, {pace.nodes} nodes")
            parts.append(f"picture {1e3 * pace.picture_seconds:.0f} ms")
        return "   ".join(parts)
