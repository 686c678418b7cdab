"""The handles of a state as control-point polydata, as filters read it, and back."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls import RegionHandle, Solid, io
from vtk_mls.files import metadata
from vtk_mls.model.handles.handle_cells import cells_of_handles
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import (
    DISPLACEMENT,
    LABEL,
    WEIGHT,
    cells_of,
    fill_polydata,
    path_of,
)
from vtk_mls.vtk.shape_surfaces import surface_of


def handle_polydata(state):
    """A vtkPolyData of a `State`: vertices are points, lines curves, closed surfaces regions.

    Balls, capsules and segments become surfaces. Weights, labels and paths are those of points.
    """
    handles = [_as_surface(handle) for handle in state.handles]
    rest, deformed, cells = cells_of_handles(state.rest, state.deformed, handles)
    count, weights = len(rest) - len(state), state.weights
    if weights is not None:
        weights = np.append(weights, np.ones(count))
    polydata = vtkPolyData()
    labels, path = [*state.labels, *[""] * count], state.path
    if len(path):
        path = [np.vstack([places, deformed[len(state) :]]) for places in path]
    fill_polydata(polydata, rest, deformed, weights, labels, cells, path)
    metadata.store(polydata, metadata.SPACE, ["LPS"])
    return polydata


def handle_values(polydata, shapes):
    """Attributes of a `State` by name, from a vtkPolyData as of `io.read_control_points`.

    `shapes` is "points" if all points are handles, or "cells" if cells are. ValueError if a cell is
    no handle, or the path of points is not valid.
    """
    labels, path = arrays.texts(polydata.GetPointData(), LABEL), path_of(polydata)
    if shapes == "cells":
        *points, handles = io.handles_of(polydata)
        rows = cells_of(polydata).point_rows
        labels, path = [labels[row] for row in rows] if labels else [], path[:, rows]
    else:
        weight = WEIGHT if polydata.GetPointData().HasArray(WEIGHT) else None
        points, handles = arrays.control_points(polydata, DISPLACEMENT, weight), []
    rest, deformed, weights = points
    values = {"rest": rest, "deformed": deformed, "weights": weights}
    return {**values, "labels": labels, "handles": handles, "path": path}


def _as_surface(handle):
    if not isinstance(handle, RegionHandle) or isinstance(handle.shape, Solid):
        return handle
    return RegionHandle(Solid(*surface_of(handle.shape)), handle.motion)
