"""An MLSDeform that has the pending values of another, and is asked what Apply would show."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.filters import MLSDeform, properties, property_tables
from vtk_mls.paraview.server_manager import elements, is_pending
from vtk_mls.vtk.arrays import ImageGeometry

_GRID = property_tables.OUTPUT_GRID, *property_tables.GIVEN_GRID
_TABLE = [each for each in property_tables.DEFORM if each is not property_tables.CUTS]
_MOVING = (
    *(each for each in _TABLE if each in (*property_tables.MAP, *property_tables.CUTTING)),
    *property_tables.OWN_CONTROL_POINTS,
    *_GRID,
)
EDITED = [each.name for each in _MOVING]
_LISTS = ("RestPoints", "DeformedPoints", "Weights")
_SOURCE = "MLSControlPoints"


class PendingFilter:
    """What the edits of a filter that wait for Apply would make.

    Attributes
    ----------
    deformation : Deformation or None
        None until there are valid edits.
    edits : object
        Differs after each edit.
    """

    def __init__(self):
        self._filter = MLSDeform()
        self.deformation, self.edits = None, None

    def update(self, proxy):
        """Take over what is pending.

        Parameters
        ----------
        proxy : proxy of MLSDeform

        Raises
        ------
        TypeError, ValueError, RuntimeError
            If there is no such deformation, as Apply says: the one before stays.
        """
        self._set_properties(proxy)
        self.deformation = self._filter.updated_deformation()
        self.edits = self.deformation, self._filter.GetMTime()

    def geometry(self, image):
        """ImageGeometry of all that a vtkImageData would become."""
        return self._filter.output_geometry(ImageGeometry.of_image(image), lambda: self.deformation)

    @property
    def is_fitted(self):
        """Whether images become as large as what is deformed."""
        return self._filter.GetOutputGrid() == "fitted"

    def image(self, image, extent):
        """What a vtkImageData would become within an extent of that, to the bit."""
        self._filter.SetInputDataObject(0, image)
        output = vtkImageData()
        if not self._filter.UpdateExtent(extent):
            raise ValueError("the image cannot be deformed")  # the filter has said why
        output.ShallowCopy(self._filter.GetOutput())
        return output

    def coarse_image(self, image, most):
        """All that a vtkImageData would become, on a grid of about so many points at most."""
        grid, kept = self.geometry(image).grid, self._grid()
        steps = np.subtract(grid.dimensions, 1)
        coarser = np.cbrt(np.prod(grid.dimensions) / most)
        fewer = np.maximum(np.floor(steps / coarser).astype(int), np.minimum(steps, 1))
        spacing = grid.spacing * steps / np.maximum(fewer, 1) + (steps == 0)
        self._set_grid(("given", (fewer + 1).tolist(), spacing.tolist(), list(grid.origin)))
        try:
            return self.image(image, (0, fewer[0], 0, fewer[1], 0, fewer[2]))
        finally:
            self._set_grid(kept)

    def _grid(self):
        return [getattr(self._filter, f"Get{each.name}")() for each in _GRID]

    def _set_grid(self, values):
        for each, value in zip(_GRID, values):
            each.assign(self._filter, value)

    def _set_properties(self, proxy):
        for each in _TABLE:
            each.assign(self._filter, _value(each, proxy))
        source = proxy.GetProperty("ControlPoints").GetProxy(0)
        client = proxy.GetClientSideObject()
        self._filter.DisconnectControlPoints()
        if source and source.GetXMLName() == _SOURCE and _has_pending_lists(source):
            for each in property_tables.OWN_CONTROL_POINTS:
                each.assign(self._filter, _value(each, source))
        elif source:
            self._filter.SetInputConnection(1, client.GetInputConnection(1, 0))
            for number in range(2):
                info = client.GetInputArrayInformation(number)
                self._filter.SetInputArrayToProcess(number, info)
        self._filter.DisconnectCuts()
        for number in range(client.GetNumberOfInputConnections(2)):
            self._filter.AddInputConnection(2, client.GetInputConnection(2, number))


def moves(proxy):
    """Whether a filter has pending edits by which something moves."""
    if any(is_pending(proxy.GetProperty(name)) for name in EDITED):
        return True
    source = proxy.GetProperty("ControlPoints").GetProxy(0)
    return bool(source) and source.GetXMLName() == _SOURCE and _has_pending_lists(source)


def _has_pending_lists(source):
    return any(is_pending(source.GetProperty(name)) for name in _LISTS)


def _value(each, proxy):
    """The pending value of a property, as the filter's setter takes it."""
    values = elements(proxy.GetProperty(each.name))
    if isinstance(each, properties.Positions):
        return np.reshape(values, (-1, 3)).tolist()
    if isinstance(each, (properties.Vector, properties.Rows, properties.ArrayNames)):
        return values
    if isinstance(each, properties.ArrayName):
        return "" if values[0] == "none" else values[0]
    return bool(values[0]) if isinstance(each, properties.Flag) else values[0]
