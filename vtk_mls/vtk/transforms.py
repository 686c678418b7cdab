"""Transforms of VTK made from transforms of this package, and matrices of VTK as arrays."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonTransforms import vtkGeneralTransform
from vtkmodules.vtkFiltersHybrid import vtkGridTransform

from vtk_mls import Affine, Chain, Field, Grid
from vtk_mls.base.validation import short_repr
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms.chain import members_of
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

_INVERSE_TOLERANCE = 1e-6  # of VTK's search for the inverse, as a fraction of the size of the grid


def to_vtk_transform(transform: Transform, grid: Grid | None = None) -> vtkGeneralTransform:
    """A transform of VTK that resamples images as `transform` does.

    It is the backward map: give it to `vtkImageReslice.SetResliceTransform`. Its `GetInverse()`,
    which VTK computes by iteration, moves points (`vtkTransformFilter`). Transforms can be
    concatenated with it. It is a copy: later changes are not followed.

    VTK calls the methods of transforms in C++ only, so that a Python class cannot be one: the map
    is sampled. Affine maps at the beginning and the end of a chain stay exact, and so do fields, if
    there is nothing else in between. Everything else is sampled on the grid and interpolated
    linearly by `vtkGridTransform`: between points with the spacing h the error is at most h^2 / 8
    times the second derivative, summed over the axes. Outside of a grid VTK continues the
    displacement of its border, where a `Field` has 0. Voids of cuts are not marked.

    Parameters
    ----------
    transform : Deformation, Affine, Field or Chain
    grid : Grid, optional
        Of the deformed space, where the map is sampled. Not needed for affine maps and fields.

    Returns
    -------
    vtkGeneralTransform

    Raises
    ------
    TypeError, ValueError
        Naming the argument.
    """
    members = members_of(transform)
    if not all(isinstance(member, (Affine, Field)) for member in members):
        members = _sampled(members, grid)
    result = vtkGeneralTransform()
    result.PostMultiply()
    for member in reversed(members):  # the backward map of the last comes first
        parts = [np.linalg.inv(member.matrix)] if isinstance(member, Affine) else _warp(member)
        for part in parts:
            result.Concatenate(part.ravel().tolist() if isinstance(part, np.ndarray) else part)
    return result


def matrix_of(matrix):
    """The array (4, 4) of a vtkMatrix4x4."""
    return np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])


def _sampled(members, grid):
    """Affine maps, a field, and affine maps, equal to the `members` at the points of a grid."""
    if not isinstance(grid, Grid):
        raise TypeError(
            "`grid` must be a Grid, for the displacements of what is neither an Affine nor a "
            f"Field, got {short_repr(grid)}"
        )
    others = [i for i, member in enumerate(members) if not isinstance(member, Affine)]
    first, last = others[0], others[-1] + 1
    inner, outer = Chain(members[first:last]), members[last:]
    for affine in reversed(outer):  # the grid, in the space before them
        grid = _before(grid, affine)
    return [*members[:first], Field(inner.displacement_field(grid).displacement, grid), *outer]


def _before(grid, affine):
    """A grid in the space before an Affine."""
    steps = np.linalg.inv(affine.matrix)[:3, :3] @ grid.index_to_world
    spacing = np.linalg.norm(steps, axis=0)
    return Grid(grid.dimensions, affine.backward(grid.origin[None])[0], spacing, steps / spacing)


def _warp(field):
    """The vtkGridTransform of a Field, between matrices (4, 4) to and from the axes of its grid.

    `vtkGridTransform` ignores the direction of an image.
    """
    grid = field.grid
    frame = np.eye(4)  # of axes with the sign of the spacing
    frame[:3, :3], frame[:3, 3] = grid.direction * np.sign(grid.spacing), grid.origin
    to_axes = np.linalg.inv(frame)
    image = configured(vtkImageData(), Dimensions=grid.dimensions, Spacing=np.abs(grid.spacing))
    displacement = np.einsum("ij,...j->...i", to_axes[:3, :3], field.displacement)
    array = arrays.from_numpy(displacement.reshape(-1, 3).astype(np.float32), VTK_FLOAT)
    image.GetPointData().SetScalars(array)
    warp = configured(vtkGridTransform(), DisplacementGridData=image)
    warp.SetInterpolationModeToLinear()
    size = np.ptp(grid.corners(), axis=0).max() or np.abs(grid.spacing).max()
    warp.SetInverseTolerance(_INVERSE_TOLERANCE * size)
    return [to_axes, warp, frame]
