"""An MLSDeform with the pending values of another one: it computes the result of Apply."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import Deformation, Grid
from vtk_mls.filters import MLSDeform, properties
from vtk_mls.filters import property_tables as tables
from vtk_mls.paraview.server_manager import is_pending, pending_values
from vtk_mls.vtk.arrays import ImageGeometry

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


class PendingFilter:
    """The deformation by edits that wait for Apply.

    `deformation` is None until there are valid edits, and with an InitialTransform; `version`
    differs after each edit.
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
        output = vtkImageData()
        if not self._filter.UpdateExtent(extent):
            raise ValueError("the image cannot be deformed")  # the filter reported the reason
        output.ShallowCopy(self._filter.GetOutput())
        return output

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
                info = client.GetInputArrayInformation(index)
                self._filter.SetInputArrayToProcess(index, info)
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
