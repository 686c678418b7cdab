"""The arrays that tell how a deformation turns and stretches."""

from __future__ import annotations

import numpy as np

from vtk_mls.vtk import arrays


def scalars(image, name):
    """The point scalars of an image whose gradient `GradientArray` asks for.

    Returns
    -------
    (nz, ny, nx) array
    """
    data = image.GetPointData()
    array = data.GetArray(name)
    if array is None or array.GetNumberOfComponents() != 1:
        there = [data.GetArray(i) for i in range(data.GetNumberOfArrays())]
        names = [f"`{a.GetName()}`" for a in there if a and a.GetNumberOfComponents() == 1]
        raise ValueError(
            f"`GradientArray` must name a point array with one component, got `{name}`; the "
            f"input has {', '.join(names) or 'none'}"
        )
    return arrays.to_numpy(array).reshape(image.GetDimensions()[::-1])


def directions(attributes, gradients, tangents):
    """Which arrays of point or cell data turn with the material, and how.

    Parameters
    ----------
    attributes : vtkDataSetAttributes
    gradients, tangents : names of arrays

    Returns
    -------
    dict of name: "gradient", "tangent" or (the active normals) "normal"

    Raises
    ------
    ValueError
        If one of the names does not hold three floats.
    """
    found = {}
    for wanted, names, how in (
        ("GradientVectorArrays", gradients, "gradient"),
        ("PushForwardArrays", tangents, "tangent"),
    ):
        for name in names:
            array = attributes.GetArray(name)
            if array is None:
                continue
            if not _is_vectors(array):
                raise ValueError(
                    f"`{wanted}` names `{name}`, which must have 3 components of type float or "
                    f"double, got {array.GetNumberOfComponents()} of {array.GetDataTypeAsString()}"
                )
            found[name] = how
    normals = attributes.GetNormals()
    if normals is not None and _is_vectors(normals):
        found[normals.GetName()] = "normal"
    return found


def add_gradient(output, values):
    """Add "Gradient", (nz, ny, nx, 3) float32, to the points of an image."""
    arrays.add(output.GetPointData(), "Gradient", values.reshape(-1, 3))


def add_jacobian(output, jacobian, void, matrix, determinant):
    """Add what is wanted of the Jacobian to an image.

    Parameters
    ----------
    output : vtkImageData
    jacobian : (nz, ny, nx, 3, 3) float32
        dG_i/dv_j at the points.
    void : (nz, ny, nx) bool
        Points that do not count as folded.
    matrix, determinant : bool
        Whether "Jacobian", or "JacobianDeterminant" and "FoldedVoxels" are wanted.
    """
    if matrix:
        rows = jacobian.swapaxes(-1, -2).reshape(-1, 9)
        arrays.add(output.GetPointData(), "Jacobian", rows)
    if determinant:
        values = np.linalg.det(jacobian)
        arrays.add(output.GetPointData(), "JacobianDeterminant", values.ravel())
        count = np.count_nonzero((values <= 0) & ~void)
        arrays.add(output.GetFieldData(), "FoldedVoxels", np.array([count], np.int64))


def _is_vectors(array):
    return array.GetNumberOfComponents() == 3 and array.GetDataTypeAsString() in ("float", "double")
