"""What pending edits of MLS Deform would show, drawn while they wait for Apply.

Where the filter, or before the first Apply its input, is shown, the input is drawn deformed beside
it, and what ParaView shows is hidden. This is no part of the pipeline: states, Undo and the panel
do not know of it. It is brought up to date once a frame, whatever number of edits came since the
last: so it never falls behind the mouse. Views that the mouse is not in are drawn when it lets go.
"""

from __future__ import annotations

from contextlib import suppress

from vtkmodules.vtkCommonCore import vtkOutputWindow

from vtk_mls.paraview import late_render
from vtk_mls.paraview.block_look import BlockLook
from vtk_mls.paraview.live_image import LiveBox, LiveImage, LiveSlice
from vtk_mls.paraview.live_mesh import LiveEdges, LiveMesh, LiveOutline
from vtk_mls.paraview.live_volume import LiveVolume
from vtk_mls.paraview.observers import Observers
from vtk_mls.paraview.pending_filter import PendingFilter, moves
from vtk_mls.paraview.server_manager import (
    blocks_of,
    find,
    input_of,
    is_remote,
    proxies,
    proxies_of,
)

SWITCH = "Live"
_KINDS = (LiveVolume, LiveImage, LiveSlice, LiveBox, LiveMesh, LiveEdges, LiveOutline)


class Live:
    """The pending state of a filter, drawn in every view.

    Parameters
    ----------
    proxy : proxy of MLSDeform
    """

    def __init__(self, proxy):
        self._number = proxy.GetGlobalID()
        self._pending, self._is_stale, self._is_held = PendingFilter(), False, False
        self._drawn = {}
        self._views, self._observers = set(), Observers()  # ids of views, whose frames are heard of
        if is_remote(proxy):
            _switch_off(proxy)

    def edited(self, is_held):
        """Something that the deformation depends on may have changed.

        Parameters
        ----------
        is_held : bool
            Whether the mouse holds a handle: the map is coarser then.
        """
        proxy = find(self._number)
        if proxy is None or not _is_wanted(proxy):
            self.end()
            return
        if is_remote(proxy):
            self._give_up(proxy, "the data are on another machine")
            return
        self._is_stale, self._is_held = True, is_held
        for view in proxies(proxy.GetSessionProxyManager(), "views"):
            self._hook(view)
            if not is_held and view.GetGlobalID() in self._views and _shown(proxy, view):
                late_render.ask([view.GetGlobalID()])

    def end(self):
        """Show what ParaView shows."""
        late_render.ask({number for number, *_ in self._drawn})
        self._observers.end()
        self._views.clear()
        for drawn in self._drawn.values():
            drawn.end()
        self._drawn, self._pending = {}, PendingFilter()

    def _give_up(self, proxy, why):
        """Leave it to Apply, and say so."""
        self.end()
        _switch_off(proxy)
        vtkOutputWindow.GetInstance().DisplayWarningText(
            f"MLS Deform does not follow live, for {why}. Apply shows the result.\n"
        )

    def _hook(self, view):
        """Hear of each frame of a view."""
        number, client = view.GetGlobalID(), view.GetClientSideObject()
        if number in self._views or not hasattr(client, "GetRenderWindow"):
            return
        window = client.GetRenderWindow()

        def frame(window, event):
            proxy = find(self._number)
            if proxy is None or not _is_wanted(proxy):
                self.end()
                return
            try:
                self._draw(proxy, number)
            except (ValueError, TypeError, RuntimeError, MemoryError) as error:
                self._give_up(proxy, str(error) or "there is not enough memory")

        def drawn(window, event):
            proxy = find(self._number)
            if proxy and any(each.has_failed for each in self._drawn.values()):
                self.end()
                _switch_off(proxy)

        self._views.add(number)
        self._observers.add(window, "StartEvent", frame)
        self._observers.add(window, "EndEvent", drawn)

    def _draw(self, proxy, number):
        """Bring up to date what the view with this id shows."""
        if self._is_stale:
            self._is_stale = False
            with suppress(ValueError, TypeError, RuntimeError):  # Apply says it
                self._pending.update(proxy)
        view = find(number, "views")
        if self._pending.deformation is None or view is None:
            return
        renderer = view.GetClientSideObject().GetRenderer()
        wanted, data = {}, input_of(proxy)
        blocks = blocks_of(data)
        for display in _shown(proxy, view):
            if all(_kind(display, block) for block in blocks):
                hidden = BlockLook(display, data).hidden
                for index, block in enumerate(blocks):
                    if index not in hidden:
                        wanted[number, display.GetGlobalID(), index] = display, block
        for key in [key for key in self._drawn if key[0] == number]:
            if key not in wanted or not self._drawn[key].is_of(*wanted[key]):
                self._drawn.pop(key).end()
        for key, (display, block) in wanted.items():
            if key not in self._drawn:
                self._drawn[key] = _kind(display, block)(display, block, renderer, key[-1])
            self._drawn[key].update(self._pending, self._is_held)


def _kind(display, data):
    """What can draw data as a display shows them; None if nothing can."""
    return next((each for each in _KINDS if each.can_draw(display, data)), None)


def _is_wanted(proxy):
    """Whether a filter's pending state is to be drawn."""
    return bool(proxy.GetProperty(SWITCH).GetUncheckedElement(0)) and moves(proxy)


def _switch_off(proxy):
    proxy.GetProperty(SWITCH).SetElement(0, 0)


def _shown(proxy, view):
    """Displays in a view where the pending state is to be seen."""
    displays = proxies_of(view.GetProperty("Representations"))
    source = proxy.GetProperty("Input")
    input_ = source.GetProxy(0), source.GetOutputPortForConnection(0)
    found = {True: [], False: []}
    for display in displays:
        shown, visible = display.GetProperty("Input"), display.GetProperty("Visibility")
        if shown and shown.GetNumberOfProxies() and visible and visible.GetElement(0):
            of = shown.GetProxy(0), shown.GetOutputPortForConnection(0)
            if of[0].GetGlobalID() == proxy.GetGlobalID() or of == input_:
                found[of != input_].append(display)
    return found[True] or found[False]
