"""Arrays that an output gets: gradients, directions, the Jacobian, and the void of cuts."""

from dataclasses import dataclass

import numpy as np
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes

from vtk_mls.base import buffer_pool
from vtk_mls.vtk import arrays


def scalars(image, name):
    """The point scalars (nz, ny, nx) of an image whose gradient `GradientArray` asks for."""
    data = image.GetPointData()
    array = data.GetArray(name)
    if array is None or array.GetNumberOfComponents() != 1:
        numeric = [array for array in arrays.all_arrays(data) if arrays.is_numeric(array)]
        names = [f"`{array.GetName()}`" for array in numeric if array.GetNumberOfComponents() == 1]
        raise ValueError(
            f"`GradientArray` must name a point array with one component, got `{name}`; the "
            f"input has {', '.join(names) or 'none'}"
        )
    return arrays.to_numpy(array).reshape(image.GetDimensions()[::-1])


@dataclass(frozen=True)
class DirectionArrays:
    """Which arrays are directions that turn with the material."""

    gradients: tuple  # names of arrays that are transformed covariantly
    tangents: tuple  # and contravariantly
    is_unit: bool  # whether gradients get length 1, as normals always do

    def of(self, attributes):
        """ "gradient", "tangent" or, for the active normals, "normal", by names of arrays.

        `attributes` are point or cell data. ValueError if a name does not hold three floats.
        """
        result = {}
        for argument, names, direction in (
            ("GradientVectorArrays", self.gradients, "gradient"),
            ("PushForwardArrays", self.tangents, "tangent"),
        ):
            for name in names:
                array = attributes.GetArray(name)
                if array is None:
                    continue
                if not _is_vectors(array):
                    raise ValueError(
                        f"`{argument}` names `{name}`, which must have 3 components of type float "
                        f"or double, got {array.GetNumberOfComponents()} of "
                        f"{array.GetDataTypeAsString()}"
                    )
                result[name] = direction
        normals = attributes.GetNormals()
        if normals is not None and _is_vectors(normals):
            result[normals.GetName()] = "normal"
        return result


def add_jacobian(output, jacobian, void, matrix, determinant):
    """Add "Jacobian" if `matrix`, and if `determinant` its determinant and "FoldedVoxels".

    `output` is a vtkImageData, `jacobian` dG_i/dv_j (nz, ny, nx, 3, 3) at its points; those where
    `void` (nz, ny, nx), or one for all, is true do not count as folded.
    """
    if matrix:
        arrays.add(output.GetPointData(), "Jacobian", jacobian.swapaxes(-1, -2).reshape(-1, 9))
    if determinant:
        values = np.linalg.det(jacobian)
        arrays.add(output.GetPointData(), "JacobianDeterminant", values.ravel())
        count = np.count_nonzero((values <= 0) & np.logical_not(void))
        arrays.add(output.GetFieldData(), "FoldedVoxels", count)


def _is_vectors(array):
    return array.GetNumberOfComponents() == 3 and array.GetDataTypeAsString() in ("float", "double")


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
