"""The handles of a state as control-point polydata, as filters read it."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls import RegionHandle, Solid
from vtk_mls.files import metadata
from vtk_mls.handles.handle_cells import cells_of_handles
from vtk_mls.vtk.control_point_polydata import fill_polydata
from vtk_mls.vtk.shape_surfaces import surface_of


def handle_polydata(state):
    """A vtkPolyData of a `State`: vertices are points, lines curves, closed surfaces regions.

    Balls, capsules and segments become surfaces. Weights and labels are those of points.
    """
    handles = [_as_surface(handle) for handle in state.handles]
    rest, deformed, cells = cells_of_handles(state.rest, state.deformed, handles)
    count, weights = len(rest) - len(state), state.weights
    if weights is not None:
        weights = np.append(weights, np.ones(count))
    polydata = vtkPolyData()
    fill_polydata(polydata, rest, deformed, weights, [*state.labels, *[""] * count], cells)
    metadata.store(polydata, metadata.SPACE, ["LPS"])
    return polydata


def _as_surface(handle):
    if not isinstance(handle, RegionHandle) or isinstance(handle.shape, Solid):
        return handle
    return RegionHandle(Solid(*surface_of(handle.shape)), handle.motion)
