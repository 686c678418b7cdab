"""The editor: handles under the mouse, in any window of VTK."""

from __future__ import annotations

import time

import numpy as np

from vtk_mls import HalfPlane, Plane, kinds
from vtk_mls.editor import keys
from vtk_mls.editor.cut_widget import CutWidget, next_half
from vtk_mls.editor.history import History
from vtk_mls.editor.incision import Incision
from vtk_mls.editor.mouse import PRIORITY, Mouse
from vtk_mls.editor.overlay import Overlay
from vtk_mls.editor.pace import Pace
from vtk_mls.editor.saving import Saver
from vtk_mls.editor.scene import Scene
from vtk_mls.editor.state import State
from vtk_mls.filters.control_points import lattice

_TICK = 15  # milliseconds
_SETTLED = 0.25  # seconds without a move, after which the picture is drawn as fine as it can be
_LATTICES = 3, 4, 5, 2  # handles along each axis
_NOTHING = np.zeros(0, int)
# What a deformation that cannot be had is told by, in the window.
_FAILURES = (ValueError, TypeError, RuntimeError, MemoryError)


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
    drafts : Drafts, optional
        Keeps what is not saved.

    Attributes
    ----------
    state : State
        That is shown; while handles are dragged it is ahead of the history.
    selected : (m,) ints
        Rows of handles.
    hovered, grabbed : int or None
        The handle under the mouse, and the one it holds.
    scene : Scene
    saver : Saver

    Raises
    ------
    TypeError, ValueError
        If a dataset cannot be shown.

    Notes
    -----
    Nothing is resampled: see `DeformedVolume` and `DeformedMesh`. A drag shows as fine a map as
    is ready in time, and the finest when it ends.
    """

    def __init__(self, interactor, datasets, state=None, paths=(), drafts=None):
        self._interactor, self._drafts, self._offered = interactor, drafts, None
        datasets = datasets if isinstance(datasets, (list, tuple)) else [datasets]
        self.scene = Scene(interactor.GetRenderWindow(), datasets)
        self.saver = Saver(datasets, paths)
        self._overlay = Overlay(self.scene.overlay, keys.legend())
        self._pace, self._looks, self._lattices = Pace(), 0, 0
        self.selected, self.hovered, self.grabbed = _NOTHING, None, None
        self._held, self._is_wanted, self._moved_at = _NOTHING, False, None
        self._ticks, self._shows_times, self._hides = False, False, False
        state = state or State([], [])
        if len(state) == 0:
            state = state.with_handles_at(self._lattice(_LATTICES[0]))
        self._history = History(state)
        self.state = self._saved = self._history.state
        self._mouse, self._line = Mouse(interactor, self), None
        self._widget = CutWidget(
            interactor, self.scene.renderer, self.scene.bounds, self._cut_moved, self._cut_ended
        )
        self._actions = keys.actions()
        self._tags = [
            interactor.AddObserver(event, what, PRIORITY)
            for event, what in (
                ("KeyPressEvent", self._key),
                ("CharEvent", self._swallow),
                ("TimerEvent", self._tick),
            )
        ]
        style = interactor.GetInteractorStyle()
        self._style_tags = [
            (style, style.AddObserver(event, what))
            for event, what in (
                ("StartInteractionEvent", self._start_moving),
                ("EndInteractionEvent", self._stop_moving),
            )
        ]
        window = self.scene.window
        self._style_tags.append((window, window.AddObserver("StartEvent", self._lay_out)))
        if not interactor.GetInitialized():
            interactor.Initialize()
        self._timer = interactor.CreateRepeatingTimer(_TICK)
        self._show(is_final=True)
        self._offer()
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
        if row != self.hovered and not self._hides:
            self.hovered = row
            self._draw(is_moving=True)

    def select(self, rows):
        """Select handles, and no others."""
        self.selected = np.asarray(rows, int)
        self._draw(is_moving=True)

    def take(self, rows, grabbed):
        """Hold handles by one of them."""
        self._held, self.grabbed = np.asarray(rows, int), grabbed
        if self.state.anchored[self._held].all():
            self.say("This handle is fixed; F frees it.")
        self._draw(is_moving=True)

    def drag_to(self, positions):
        """Move what is held; the newest positions are shown at the next tick."""
        self.state = self._history.state.moved(self._held, positions)
        self._is_wanted = True
        if not self._ticks:
            self._follow()

    def let_go(self):
        """End the drag: what it has moved is an edit."""
        self._held, self.grabbed, self._is_wanted = _NOTHING, None, False
        state = self.state
        self.state = self._history.state
        if (state.deformed != self.state.deformed).any():
            self.change(state)
        else:
            self._draw(is_moving=True)

    def show_band(self, corners):
        """Show the rubber band between two pixels, or none for None."""
        self._overlay.set_band(corners)
        self._draw(is_moving=True)

    # edits

    def change(self, state):
        """Go on to a new state, which can be undone; one that has no map is told instead.

        Returns
        -------
        bool
            Whether it could be shown.
        """
        before, self.state = self.state, state
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
        if self._line is not None:
            self._line.remove()
            self._line = None
        self.select(_NOTHING)

    def reset(self):
        """Put all handles back to where they rest."""
        self.change(self.state.at_rest())

    def lay_lattice(self):
        """Replace the handles by a lattice over the data; each time another one."""
        self._lattices += 1
        count = _LATTICES[self._lattices % len(_LATTICES)]
        self.selected = _NOTHING
        if self.change(self.state.with_handles_at(self._lattice(count))):
            self.say(f"{count} x {count} x {count} handles; Z brings the others back.")

    def change_kind(self):
        """Fit maps of the next kind."""
        names = list(kinds.KINDS)
        self.change(self.state.changed(kind=names[(names.index(self.state.kind) + 1) % len(names)]))

    def change_alpha(self, factor):
        """Let handles act more or less locally."""
        alpha = float(np.clip(self.state.alpha * factor, 0.1, 10))
        self.change(self.state.changed(alpha=round(alpha, 3)))

    def change_nu(self, factor):
        """Let influence fade more or less with the detour around cuts."""
        nu = float(np.clip(1 + (self.state.nu - 1) * factor, 1.05, 20))
        self.change(self.state.changed(nu=round(nu, 3)))

    def change_cut(self):
        """Cut by a plane, by a half-plane, or not at all, in this order."""
        camera, cut = self.scene.renderer.GetActiveCamera(), _flat_cut(self.state)
        if cut is None:
            cut = self._widget.first(camera)
        else:
            cut = self._widget.half(cut, camera) if isinstance(cut, Plane) else None
        if self.change(_with_flat_cut(self.state, cut)) and cut is not None:
            self.say("Drag handles away from the cut to open it; the mouse moves the plane, too.")

    def change_half(self):
        """Cut by another half of the plane."""
        cut = _flat_cut(self.state)
        if isinstance(cut, HalfPlane):
            self.change(_with_flat_cut(self.state, next_half(cut)))
        else:
            self.say("There is no half-plane; C makes one.")

    def incise(self):
        """Begin a line on the surface, or cut along it."""
        line, self._line = self._line, None
        if line is None:
            self._line = Incision(self.scene.overlay)
            self.say("Click on the surface along the cut; P cuts, Esc does not.")
            return
        line.remove()
        if len(line.points) < 2:
            self.say("A cut needs at least two points on the surface.")
            return
        eye = np.array(self.scene.renderer.GetActiveCamera().GetPosition())
        size = np.ptp(self.scene.bounds, axis=0).max()
        in_rest = self.state.cut_frame == "rest"
        cut = line.cut(eye, size, self.state.deformation() if in_rest else None)
        cuts = self.state.cuts
        self.change(self.state.changed(cuts=(cut, *cuts)))

    def draw_line_to(self, pixel):
        """Go on with a line on the surface; whether one is being drawn."""
        if self._line is None:
            return False
        point = self.surfaces().hit(self.projection, pixel)
        if point is not None:
            self._line.add(point)
        self._draw(is_moving=True)
        return True

    def compare(self):
        """Show the data as they were, or deformed again."""
        self.change(self.state.changed(blend=0.0 if self.state.blend else 1.0))

    # what is seen

    def change_look(self):
        """Draw the data by their next look."""
        self._looks += 1
        self.say(self.scene.set_look(self._looks))
        self._draw()

    def hide_handles(self):
        """Hide handles and texts, or show them again."""
        self._hides = not self._hides
        self.scene.glyphs.set_visible(not self._hides)
        self._widget.set_visible(not self._hides)
        self._overlay.set_visible(not self._hides)
        self._overlay.set_keys_visible(False)
        self._draw()

    def toggle_legend(self):
        """Hide or show the legend of keys."""
        self._overlay.set_keys_visible(not self._overlay.shows_keys)
        self._draw()

    def time(self):
        """Show how long maps and pictures take, or no more."""
        self._shows_times = not self._shows_times
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
        self._mouse.finish()
        self.say("Saving ...")
        self._draw(is_moving=True)
        self._overlay.set_visible(False)
        self._draw_for_file()
        try:
            sentence = self.saver.save(self.state, self.scene.window)
        except (OSError, *_FAILURES) as error:
            sentence, is_saved = _sentence(error), False
        else:
            is_saved, self._saved = True, self.state
            if self._drafts is not None:
                self._drafts.forget_all()
        self._overlay.set_visible(not self._hides)
        self.say(sentence)
        self._draw()
        return is_saved

    def accept(self):
        """Take what is offered."""
        state, self._offered = self._offered, None
        if state is None:
            self.say("Nothing is offered.")
        elif self.change(state):
            self.selected = _NOTHING
            self.say("They are back; Z takes the others again.")

    def say(self, sentence):
        """Show a sentence in the window."""
        self._overlay.say(sentence)

    @property
    def message(self):
        """What the window says."""
        return self._overlay.message.replace("\n", " ")

    def quit(self):
        """End the interactor's loop; what is dragged is let go."""
        self._mouse.finish()
        self._interactor.ExitCallback()

    def detach(self):
        """Leave window and interactor to themselves."""
        self._mouse.detach()
        self._widget.detach()
        self._interactor.DestroyTimer(self._timer)
        for tag in self._tags:
            self._interactor.RemoveObserver(tag)
        for observed, tag in self._style_tags:
            observed.RemoveObserver(tag)
        self.scene.detach()

    # events

    def _key(self, interactor, event):
        action = self._actions.get(keys.name_of(interactor))
        if action is None:
            return
        self._mouse.finish()
        interactor.GetCommand(self._tags[0]).SetAbortFlag(True)
        name, value = action
        self.say("")
        getattr(self, name)(*(() if value is None else (value,)))
        if self.message:
            self._draw()

    def _swallow(self, interactor, event):
        """Keep the keys from interactor styles, which have their own meanings for them."""
        interactor.GetCommand(self._tags[1]).SetAbortFlag(True)

    def _tick(self, interactor, event):
        self._ticks = True
        if self._is_wanted:
            self._follow()
        elif self._moved_at is not None and time.monotonic() - self._moved_at > _SETTLED:
            self._draw()

    def _cut_moved(self, cut):
        """Show where the mouse has the cut; the newest one at the next tick."""
        self.state = _with_flat_cut(self._history.state, cut)
        self._is_wanted = True
        if not self._ticks:
            self._follow()

    def _cut_ended(self, cut):
        self._is_wanted = False
        state, self.state = _with_flat_cut(self._history.state, cut), self._history.state
        self.change(state)

    def _start_moving(self, caller, event):
        self.scene.set_coarseness(self._pace.pixels_while_moving())
        self._moved_at = None

    def _stop_moving(self, caller, event):
        self._moved_at = time.monotonic()
        if not self._ticks:
            self._draw()

    def _lay_out(self, window, event):
        self._overlay.lay_out()

    # drawing

    def _follow(self):
        """Show where the drag is now."""
        self._is_wanted = False
        self._show(is_final=False)

    def _show(self, is_final, is_quiet=False):
        """Draw the state as it is; whether there is a map for it."""
        started, pace = time.perf_counter(), self._pace
        nodes = pace.nodes_at_rest() if is_final else pace.nodes_while_moving()
        try:
            deformation = self.state.deformation()
            self.scene.show(deformation, nodes, is_final)
        except _FAILURES as error:
            if not is_quiet:
                self.say(_sentence(error))
            self._draw(is_moving=True)
            return False
        if deformation is not None:
            pace.note_map(nodes, time.perf_counter() - started)
        self._draw(is_moving=not is_final)
        return True

    def _draw(self, is_moving=False):
        """Make a picture; a coarse one while something moves, if a timer will make a finer one."""
        is_moving, pace = is_moving and self._ticks, self._pace
        pixels = pace.pixels_while_moving() if is_moving else pace.pixels_at_rest()
        self.scene.set_coarseness(pixels)
        self.scene.glyphs.show(self.state, self.selected, self.hovered, self._held)
        if not self._hides:
            self._widget.show(_flat_cut(self.state))
        self._overlay.set_status(self._status())
        started = time.perf_counter()
        self.scene.renderer.ResetCameraClippingRange()
        self.scene.window.Render()
        pace.note_picture(pixels, time.perf_counter() - started)
        self._moved_at = time.monotonic() if is_moving and pixels > 1 else None

    def _draw_for_file(self):
        """Make a picture as fine as it can be, without texts."""
        has_keys = self._overlay.shows_keys
        self._overlay.set_keys_visible(False)
        self.scene.set_coarseness(self._pace.pixels_for_file())
        self.scene.glyphs.show(self.state, _NOTHING, None, _NOTHING)
        self._widget.set_visible(False)
        self.scene.window.Render()
        self._widget.set_visible(not self._hides)
        self._overlay.set_keys_visible(has_keys)

    def _status(self):
        state, pace = self.state, self._pace
        parts = [f"{len(state)} handles", state.kind, f"alpha {state.alpha:g}"]
        parts += [f"{len(self.selected)} selected"] * (len(self.selected) > 0)
        parts += [f"{int(state.anchored.sum())} fixed"] * bool(state.anchored.any())
        parts += ["shown as it was before; B"] * (state.blend == 0)
        if self._shows_times:
            parts.append(f"map {1e3 * pace.map_seconds:.0f} ms, {pace.nodes} nodes")
            parts.append(f"picture {1e3 * pace.picture_seconds:.0f} ms")
        return "   ".join(parts)

    def _step(self, has_stepped, otherwise):
        if not has_stepped:
            self.say(otherwise)
            return
        self.state = self._history.state
        self.selected = self.selected[self.selected < len(self.state)]
        self.hovered = None
        self._show(is_final=True)
        self._keep()

    def _offer(self):
        """Offer what an earlier session has not saved."""
        found = self._drafts and self._drafts.found()
        if found:
            self._offered, when = found
            text = time.strftime("%d %B, %H:%M", time.localtime(when))
            self.say(
                f"{len(self._offered)} handles of {text} were not saved: Return brings them back."
            )

    def _keep(self):
        """Keep the state as it is now, unless it is saved."""
        if self._drafts is None:
            return
        try:
            if self.state is self._saved:
                self._drafts.forget()
            else:
                self._drafts.keep(self.state)
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
        return lattice((count,) * 3, self.scene.bounds.T.ravel())


def _flat_cut(state):
    """The cut that the widget moves: the last one that is flat; None without."""
    flat = [cut for cut in state.cuts if isinstance(cut, (Plane, HalfPlane))]
    return flat[-1] if flat else None


def _with_flat_cut(state, cut):
    """The state with another such cut, or without it for None."""
    cuts, old = list(state.cuts), _flat_cut(state)
    if old is not None:
        cuts.remove(old)
    return state.changed(cuts=(*cuts, *([] if cut is None else [cut])))


def _sentence(error):
    text = " ".join(str(error).split()) or "There is not enough memory."
    return text[0].upper() + text[1:] + "." * (text[-1] not in ".!?")
