"""Cuts from properties and polydata, and the arrays that tell of the void they open."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPolyData
from vtkmodules.vtkFiltersCore import (
    vtkCleanPolyData,
    vtkPolyDataConnectivityFilter,
    vtkTriangleFilter,
)

from vtk_mls import HalfPlane, Plane, Surface, arrays

# Before VTK 9.3 vtkGeometryFilter, which ParaView 5.11 has as "Extract Surface", puts the last face
# of each column of an image with hidden cells at the end of the z axis, whatever axis the column
# has: beyond its memory where the image ends later along z. (Its fast mode does not.)
CAN_HIDE_CELLS = (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 3)


def own_cuts(kind, origin, normal, inward):
    """The cut that properties describe, as a tuple of none or one."""
    try:
        if kind == "plane":
            return (Plane(origin, normal),)
        if kind == "half-plane":
            return (HalfPlane(origin, normal, inward),)
    except (TypeError, ValueError) as error:
        names = "`CutOrigin` and `CutNormal`" if kind == "plane" else "`CutNormal` and `CutInward`"
        raise ValueError(f"the {kind} by {names} is not one: {error}") from error
    return ()


def surfaces(polydata):
    """The surfaces of a vtkPolyData as cuts.

    Polygons and triangle strips become triangles; points at the same place are one, and what is
    no triangle then is left out, as lines and vertices are. Parts that do not hang together are
    cuts of their own.

    Parameters
    ----------
    polydata : vtkPolyData

    Returns
    -------
    list of Surface

    Raises
    ------
    ValueError
        If there is no surface, a point is not finite, or a triangle has no area.
    """
    points = polydata.GetPoints()
    if points is not None and not np.isfinite(arrays.to_numpy(points.GetData())).all():
        raise ValueError("`Cuts` has a point that is not finite")
    bare = vtkPolyData()
    bare.SetPoints(points)
    bare.SetPolys(polydata.GetPolys())
    bare.SetStrips(polydata.GetStrips())
    triangles, clean, parts = (
        vtkTriangleFilter(),
        vtkCleanPolyData(),
        vtkPolyDataConnectivityFilter(),
    )
    triangles.SetInputData(bare)
    clean.SetInputConnection(triangles.GetOutputPort())
    clean.SetConvertPolysToLines(False)
    parts.SetInputConnection(clean.GetOutputPort())
    parts.SetExtractionModeToAllRegions()
    parts.SetColorRegions(True)
    clean.Update()
    if clean.GetOutput().GetNumberOfPolys() == 0:
        raise ValueError(
            "`Cuts` has no surface; it must have polygons or triangle strips, got "
            f"{polydata.GetNumberOfPoints()} points and {polydata.GetNumberOfLines()} lines"
        )
    parts.Update()
    result = parts.GetOutput()
    places = arrays.to_numpy(result.GetPoints().GetData())
    corners = arrays.to_numpy(result.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    part = arrays.to_numpy(result.GetPointData().GetArray("RegionId"))[corners[:, 0]]
    found = []
    for number in range(part.max() + 1):
        used, rows = np.unique(corners[part == number], return_inverse=True)
        try:
            found.append(Surface(places[used], rows.reshape(-1, 3)))
        except ValueError as error:
            raise ValueError(f"`Cuts` has no usable surface: {error}") from error
    return found


def add_void(attributes, void_distance):
    """Add "VoidDistance", and "Void", which is its sign.

    Parameters
    ----------
    attributes : vtkPointData
    void_distance : (nz, ny, nx) float32, world units
        As of `DisplacementField.void_distance`.
    """
    arrays.add(attributes, "VoidDistance", void_distance.ravel())
    arrays.add(attributes, "Void", void_distance.ravel() < 0)


def hide(attributes, hidden):
    """Mark points or cells as hidden, beside what their ghost array says already."""
    is_points = attributes.IsA("vtkPointData")
    flag = vtkDataSetAttributes.HIDDENPOINT if is_points else vtkDataSetAttributes.HIDDENCELL
    ghosts = hidden.ravel() * np.uint8(flag)
    before = attributes.GetArray(arrays.GHOSTS)
    if before is not None:
        ghosts |= arrays.to_numpy(before).astype(np.uint8)
    arrays.add(attributes, arrays.GHOSTS, ghosts)


def touched(points):
    """Cells with a corner among the points (nz, ny, nx) bool; cells as of `arrays.cell_grid`."""
    for axis in range(3):
        if points.shape[axis] > 1:
            points = np.maximum(*(np.moveaxis(points, axis, 0)[part] for part in _ENDS))
            points = np.moveaxis(points, 0, axis)
    return points


_ENDS = slice(None, -1), slice(1, None)
