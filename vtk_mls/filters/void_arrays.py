"""Arrays of the void that cuts open."""

import numpy as np
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes

from vtk_mls.base import buffer_pool
from vtk_mls.vtk import arrays

# Before VTK 9.3 vtkGeometryFilter, which ParaView 5.11 has as "Extract Surface", puts the last face
# of each column of an image with hidden cells at the end of the z axis, whatever axis the column
# has: beyond its memory where the image ends later along z. (Its fast mode does not.)
CAN_HIDE_CELLS = (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 3)


def add_void(attributes, void_distance):
    """Add "VoidDistance" to point data, and its sign "Void".

    `void_distance` (nz, ny, nx) float32, world units, is that of a `DisplacementField`.
    """
    arrays.add(attributes, "VoidDistance", void_distance.ravel())
    void = buffer_pool.empty(void_distance.size, bool)
    arrays.add(attributes, "Void", np.less(void_distance.ravel(), 0, out=void))


def add_overlap(output, deformation, grid, progress):
    """Add "Overlap" to the points of an image on a grid, and "OverlappingPoints"."""
    overlaps = deformation.overlap_field(grid, progress)
    arrays.add(output.GetPointData(), "Overlap", overlaps.ravel())
    arrays.add(output.GetFieldData(), "OverlappingPoints", np.count_nonzero(overlaps))


def hide(attributes, hidden):
    """Mark points or cells as hidden, and keep the flags of their ghost array."""
    is_points = attributes.IsA("vtkPointData")
    flag = vtkDataSetAttributes.HIDDENPOINT if is_points else vtkDataSetAttributes.HIDDENCELL
    ghosts = buffer_pool.empty(hidden.size, np.uint8)
    np.multiply(hidden.ravel().view(np.uint8), np.uint8(flag), out=ghosts)
    before = attributes.GetArray(arrays.GHOSTS)
    if before is not None:
        ghosts |= arrays.to_numpy(before).astype(np.uint8)
    arrays.add(attributes, arrays.GHOSTS, ghosts)
