"""The result of pending edits of MLS Deform, drawn before Apply.

The deformed input is drawn in place of ParaView's own prop of the filter, or of the input before
the first Apply. This does not change the pipeline: states, Undo and the panel ignore it. It is
updated once a frame for any number of edits, to keep up with the mouse; other views after a drag.
"""

from contextlib import suppress

import numpy as np
from vtkmodules.vtkCommonCore import vtkOutputWindow

from vtk_mls import Deformation, Grid
from vtk_mls.filters import MLSDeform, properties
from vtk_mls.filters import property_tables as tables
from vtk_mls.paraview.displays import BlockSettings
from vtk_mls.paraview.live_image import LiveBox, LiveImage, LiveSlice, LiveVolume
from vtk_mls.paraview.live_prop import LiveEdges, LiveOutline, LiveSurface
from vtk_mls.paraview.server_manager import (
    Observers,
    blocks_of,
    find_proxy,
    input_data,
    input_of,
    is_pending,
    is_remote,
    pending_value,
    pending_values,
    proxies_in,
    render_later,
    views_of,
)
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import shallow_copy

SWITCH = "Live"
_PROP_TYPES = (LiveVolume, LiveImage, LiveSlice, LiveBox, LiveSurface, LiveEdges, LiveOutline)
_GRID = tables.OUTPUT_GRID, *tables.GIVEN_GRID
_IN_PYTHON = properties.Value, properties.Values
_TABLE = [prop for prop in tables.DEFORM if not isinstance(prop, _IN_PYTHON)]
_MAP = *tables.MAP, *tables.CUTTING, *tables.HANDLE_OPTIONS, *tables.LIMITS
# Properties that change the deformation or the grid.
MAP_PROPERTIES = [
    *(prop.name for prop in _TABLE if prop in _MAP),
    tables.INITIAL_TRANSFORM.name,
    *(prop.name for prop in (*tables.OWN_CONTROL_POINTS, *_GRID)),
]
_SOURCE = "MLSControlPoints"


class Live:
    """The result of the pending edits of an MLSDeform, drawn in all views."""

    def __init__(self, proxy):
        self._proxy_id = proxy.GetGlobalID()
        self._pending, self._is_stale, self._is_dragging = PendingFilter(), False, False
        self._props = {}  # LiveProps by ids of view and display, and index of the block
        self._observed_views, self._observers = set(), Observers()  # ids of views
        if is_remote(proxy):
            _switch_off(proxy)

    def edited(self, is_dragging):
        """Note that the deformation may have changed; the map is coarser during a drag."""
        proxy = self._active_proxy()
        if proxy is None:
            return
        if is_remote(proxy):
            self._give_up(proxy, "the data are on another machine")
            return
        self._is_stale, self._is_dragging = True, is_dragging
        for view in views_of(proxy):
            self._observe(view)
            is_observed = view.GetGlobalID() in self._observed_views
            if is_observed and not is_dragging and _displays(proxy, view):
                render_later([view.GetGlobalID()])

    def end(self):
        """Show ParaView's own props."""
        render_later({view_id for view_id, *_ in self._props})
        self._observers.end()
        self._observed_views.clear()
        for prop in self._props.values():
            prop.end()
        self._props, self._pending = {}, PendingFilter()

    def _active_proxy(self):
        """The filter, if it is live and has pending edits; else None, and drawing ends."""
        proxy = find_proxy(self._proxy_id)
        if proxy is None or not (pending_value(proxy, SWITCH) and has_pending_map(proxy)):
            self.end()
            return None
        return proxy

    def _give_up(self, proxy, reason):
        """End, and warn that only Apply shows the result."""
        self.end()
        _switch_off(proxy)
        vtkOutputWindow.GetInstance().DisplayWarningText(
            f"MLS Deform does not follow live, for {reason}. Apply shows the result.\n"
        )

    def _observe(self, view):
        """Draw in each frame of a view."""
        view_id, client = view.GetGlobalID(), view.GetClientSideObject()
        if view_id in self._observed_views or not hasattr(client, "GetRenderWindow"):
            return

        def frame_starts(window, event):
            proxy = self._active_proxy()
            if proxy is None:
                return
            try:
                self._draw(proxy, view_id)
            except (ValueError, TypeError, RuntimeError, MemoryError) as error:
                self._give_up(proxy, str(error) or "there is not enough memory")

        def frame_ends(window, event):
            proxy = find_proxy(self._proxy_id)
            if proxy and any(prop.has_failed for prop in self._props.values()):
                self.end()
                _switch_off(proxy)

        self._observed_views.add(view_id)
        self._observers.add(client.GetRenderWindow(), "StartEvent", frame_starts)
        self._observers.add(client.GetRenderWindow(), "EndEvent", frame_ends)

    def _draw(self, proxy, view_id):
        if self._is_stale:
            self._is_stale = False
            with suppress(ValueError, TypeError, RuntimeError):  # Apply reports it
                self._pending.update(proxy)
        view = find_proxy(view_id, "views")
        if self._pending.deformation is None or view is None:
            return
        renderer = view.GetClientSideObject().GetRenderer()
        visible = _visible_blocks(proxy, view)
        for key in [key for key in self._props if key[0] == view_id]:
            if key not in visible or not self._props[key].is_current(*visible[key]):
                self._props.pop(key).end()
        for key, (display, block) in visible.items():
            if key not in self._props:
                self._props[key] = _prop_type(display, block)(display, block, renderer, key[-1])
            self._props[key].update(self._pending, self._is_dragging)


def _visible_blocks(proxy, view):
    """Displays and visible blocks to draw in a view, by the keys of `Live._props`."""
    visible, data = {}, input_data(proxy)
    blocks = blocks_of(data)
    for display in _displays(proxy, view):
        if all(_prop_type(display, block) for block in blocks):
            hidden = BlockSettings(display, data).hidden
            for index, block in enumerate(blocks):
                if index not in hidden:
                    visible[view.GetGlobalID(), display.GetGlobalID(), index] = display, block
    return visible


def _prop_type(display, data):
    """The class that draws data as a display shows them; None without such a class."""
    return next((cls for cls in _PROP_TYPES if cls.can_draw(display, data)), None)


def _switch_off(proxy):
    proxy.GetProperty(SWITCH).SetElement(0, 0)


def _displays(proxy, view):
    """The visible displays of a filter in a view; if there are none, those of its input."""
    of_filter, of_input = [], []
    for display in proxies_in(view.GetProperty("Representations")):
        source = input_of(display)
        if source is None or not pending_value(display, "Visibility"):
            continue
        if source[0].GetGlobalID() == proxy.GetGlobalID():
            of_filter.append(display)
        elif source == input_of(proxy):
            of_input.append(display)
    return of_filter or of_input


class PendingFilter:
    """The deformation by edits that wait for Apply.

    `deformation` is None without valid edits, and with an InitialTransform; edits change `version`.
    """

    def __init__(self):
        self._filter = MLSDeform()
        self.deformation, self.version = None, None

    def update(self, proxy):
        """Copy the pending values of a proxy of MLSDeform.

        TypeError, ValueError or RuntimeError if a value is wrong, as Apply reports it; the last
        deformation stays.
        """
        self._set_properties(proxy)
        transform = self._filter.updated_deformation()
        self.deformation = transform if isinstance(transform, Deformation) else None
        self.version = self.deformation, self._filter.GetMTime()

    def geometry(self, image):
        """ImageGeometry of a whole deformed vtkImageData."""
        return self._filter.output_geometry(ImageGeometry.of_image(image), lambda: self.deformation)

    def limits(self, image):
        """The Grid within which a volume, a vtkImageData, is drawn; None for all of it.

        A fitted grid contains all of it; that of a Reference can have other directions.
        """
        if self._filter.has_reference() or self._filter.GetOutputGrid() == "fitted":
            return None
        return self.geometry(image).grid

    def image(self, image, extent):
        """The part of a deformed vtkImageData in an extent, bit for bit as Apply computes it."""
        self._filter.SetInputDataObject(0, image)
        if not self._filter.UpdateExtent(extent):
            raise ValueError("the image cannot be deformed")  # the filter reported the reason
        return shallow_copy(self._filter.GetOutput())

    def coarse_image(self, image, max_points):
        """A whole deformed vtkImageData on a grid of about `max_points` points."""
        grid = self.geometry(image).grid
        steps = np.subtract(grid.dimensions, 1)
        factor = np.cbrt(np.prod(grid.dimensions) / max_points)
        fewer = np.maximum(np.floor(steps / factor).astype(int), np.minimum(steps, 1))
        spacing = grid.spacing * steps / np.maximum(fewer, 1) + (steps == 0)
        self._filter.SetReference(Grid(fewer + 1, grid.origin, spacing, grid.direction))
        try:
            return self.image(image, (0, fewer[0], 0, fewer[1], 0, fewer[2]))
        finally:
            self._filter.SetReference(None)

    def _set_properties(self, proxy):
        for prop in _TABLE:
            prop.assign(self._filter, _setter_value(prop, proxy))
        if self._filter.GetBackground():  # as in `proxies`
            self._filter.SetAutomaticBackground(False)
        source = proxy.GetProperty("ControlPoints").GetProxy(0)
        client = proxy.GetClientSideObject()
        self._filter.series_backgrounds = client.corner_backgrounds
        self._filter.DisconnectControlPoints()
        if _has_pending_lists(source):
            for prop in tables.OWN_CONTROL_POINTS:
                prop.assign(self._filter, _setter_value(prop, source))
        elif source:
            self._filter.SetInputConnection(1, client.GetInputConnection(1, 0))
            for index in range(2):
                self._filter.SetInputArrayToProcess(index, client.GetInputArrayInformation(index))
        for port in (2, 3, 4, 5):
            self._filter.RemoveAllInputConnections(port)
            for index in range(client.GetNumberOfInputConnections(port)):
                self._filter.AddInputConnection(port, client.GetInputConnection(port, index))


def has_pending_map(proxy):
    """Whether pending edits of an MLSDeform change the deformation or the grid."""
    if any(is_pending(proxy.GetProperty(name)) for name in MAP_PROPERTIES):
        return True
    return _has_pending_lists(proxy.GetProperty("ControlPoints").GetProxy(0))


def _has_pending_lists(source):
    return (
        source is not None
        and source.GetXMLName() == _SOURCE
        and any(is_pending(source.GetProperty(prop.name)) for prop in tables.OWN_CONTROL_POINTS)
    )


def _setter_value(prop, proxy):
    """The pending value of a property, as the filter's setter takes it."""
    values = pending_values(proxy.GetProperty(prop.name))
    if isinstance(prop, (properties.Positions, properties.Planes)):
        return np.reshape(values, (-1, len(prop.columns))).tolist()
    if isinstance(prop, (properties.Vector, properties.Rows, properties.ArrayNames)):
        return values
    if isinstance(prop, properties.ArrayName):
        return "" if values[0] == "none" else values[0]
    return bool(values[0]) if isinstance(prop, properties.Flag) else values[0]
