"""What pending edits of MLS Deform would show, drawn while they wait for Apply.

Where the filter, or before the first Apply its input, is shown as a volume or a mesh, the input is
drawn deformed beside it, and what ParaView shows is hidden. This is no part of the pipeline:
states, Undo and the panel do not know of it. It is brought up to date once a frame, whatever number
of edits came since the last: so it never falls behind the mouse.
"""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.arrays import ImageGeometry
from vtk_mls.filters import MLSDeform, properties, property_tables
from vtk_mls.paraview.live_mesh import LiveMesh
from vtk_mls.paraview.live_volume import LiveVolume
from vtk_mls.paraview.server_manager import elements, find, is_pending, proxies, proxies_of

SWITCH = "Live"
_TABLE = [
    *property_tables.MAP,
    *(each for each in property_tables.CUTTING if each is not property_tables.CUTS),
    *property_tables.OWN_CONTROL_POINTS,
]
_GRID = (property_tables.OUTPUT_GRID, *property_tables.GIVEN_GRID)
EDITED = [each.name for each in (*_TABLE, *_GRID)]
_LISTS = ("RestPoints", "DeformedPoints", "Weights")
_KINDS = (LiveVolume, LiveMesh)


class Live:
    """The pending state of a filter, drawn in every view.

    Parameters
    ----------
    number : int
        Global id of the MLSDeform proxy.
    """

    def __init__(self, number):
        self._number = number
        self._deform = MLSDeform()  # which never runs: it makes a deformation of properties
        self._deformation, self._is_stale, self._is_held = None, False, False
        self._drawn, self._hooks = {}, {}

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
        self._is_stale, self._is_held = True, is_held
        for view in proxies(proxy.GetSessionProxyManager(), "views"):
            self._hook(view)

    def end(self):
        """Show what ParaView shows."""
        for window, tag in self._hooks.values():
            window.RemoveObserver(tag)
        self._hooks = {}
        for drawn in self._drawn.values():
            drawn.end()
        self._drawn, self._deformation = {}, None

    def _hook(self, view):
        """Hear of each frame of a view."""
        number, client = view.GetGlobalID(), view.GetClientSideObject()
        if number in self._hooks or not hasattr(client, "GetRenderWindow"):
            return
        window = client.GetRenderWindow()

        def frame(window, event):
            try:
                self._draw(number)
            except (ValueError, TypeError, RuntimeError, MemoryError):
                self.end()  # Apply says it

        self._hooks[number] = window, window.AddObserver("StartEvent", frame)

    def _draw(self, number):
        """Bring up to date what the view with this id shows."""
        proxy = find(self._number)
        if proxy is None or not _is_wanted(proxy):
            self.end()
            return
        self._update(proxy)
        if self._deformation is None:
            return
        view = find(number, "views")
        shown = {each.GetGlobalID(): each for each in _shown(proxy, view)}
        for key in [key for key in self._drawn if key[0] == number and key[1] not in shown]:
            self._drawn.pop(key).end()
        data = _input_of(proxy)
        renderer = view.GetClientSideObject().GetRenderer()
        for each, display in shown.items():
            self._draw_in((number, each), display, renderer, data)
            drawn = self._drawn.get((number, each))
            if drawn and not drawn.update(self._deformation, self._is_held, self._limits(data)):
                proxy.GetProperty(SWITCH).SetElement(0, 0)  # it has said why
                self.end()
                return

    def _draw_in(self, key, display, renderer, data):
        """Have what draws the data as a display shows them, if anything can."""
        drawn = self._drawn.get(key)
        if drawn and not drawn.is_of(display, data):
            self._drawn.pop(key).end()
            drawn = None
        kind = next((each for each in _KINDS if each.can_draw(display, data)), None)
        if drawn is None and kind:
            self._drawn[key] = kind(display, data, renderer)

    def _update(self, proxy):
        """The deformation of the pending edits; if they are not valid, the last one."""
        if not self._is_stale:
            return
        self._is_stale = False
        try:
            self._set_properties(proxy)
            self._deformation = self._deform._updated_deformation()
        except (ValueError, TypeError, RuntimeError):
            pass  # Apply says it

    def _limits(self, data):
        """Where the output image is, of which Apply shows no more; None if all fits anyhow."""
        if not isinstance(data, vtkImageData) or self._deform.GetOutputGrid() == "fitted":
            return None
        return self._deform._output_geometry(ImageGeometry.of_image(data), None)

    def _set_properties(self, proxy):
        for each in (*_TABLE, *_GRID):
            getattr(self._deform, f"Set{each.name}")(_value(each, proxy))
        source = proxy.GetProperty("ControlPoints").GetProxy(0)
        client = proxy.GetClientSideObject()
        self._deform.DisconnectControlPoints()
        if source and source.GetXMLName() == "MLSControlPoints" and _has_pending_lists(source):
            for each in property_tables.OWN_CONTROL_POINTS:
                getattr(self._deform, f"Set{each.name}")(_value(each, source))
        elif source:
            self._deform.SetInputConnection(1, client.GetInputConnection(1, 0))
            for number in range(2):
                info = client.GetInputArrayInformation(number)
                self._deform.SetInputArrayToProcess(number, info)
        self._deform.DisconnectCuts()
        for number in range(client.GetNumberOfInputConnections(2)):
            self._deform.AddInputConnection(2, client.GetInputConnection(2, number))


def _is_wanted(proxy):
    """Whether a filter's pending state is to be drawn, and can be here."""
    switch = proxy.GetProperty(SWITCH)
    if not switch.GetUncheckedElement(0) or proxy.GetSession().IsA("vtkSMSessionClient"):
        return False
    if any(is_pending(proxy.GetProperty(name)) for name in EDITED):
        return True
    source = proxy.GetProperty("ControlPoints").GetProxy(0)
    return bool(source) and source.GetXMLName() == "MLSControlPoints" and _has_pending_lists(source)


def _has_pending_lists(source):
    return any(is_pending(source.GetProperty(name)) for name in _LISTS)


def _value(each, proxy):
    """The pending value of a property, as the filter's setter takes it."""
    values = elements(proxy.GetProperty(each.name))
    if isinstance(each, properties.Positions):
        return np.reshape(values, (-1, 3)).tolist()
    if isinstance(each, (properties.Vector, properties.Factors)):
        return values
    return values[0]


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


def _input_of(proxy):
    """The filter's input, as it was last updated."""
    source = proxy.GetProperty("Input")
    client = source.GetProxy(0).GetClientSideObject()
    return client.GetOutputDataObject(source.GetOutputPortForConnection(0))
