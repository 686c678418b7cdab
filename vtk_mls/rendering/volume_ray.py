"""Where along a ray a volume hides what is behind it."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkImageData
from vtkmodules.vtkRenderingCore import vtkAbstractVolumeMapper
from vtkmodules.vtkRenderingVolume import vtkVolumeMapper

from vtk_mls.base.interpolation import sample
from vtk_mls.rendering import deformed_volume
from vtk_mls.vtk.arrays import ImageGeometry

_HIDES = 0.5  # opacity of all that is before it
_STEP = 0.5  # of the smallest spacing
_MOST_STEPS = 2000


def opaque_at(volume, start, end):
    """Where a ray has become half opaque, as VTK composites the volume along it.

    Parameters
    ----------
    volume : vtkVolume
        With images; other blend modes than composite hide nothing.
    start, end : (3,) float64, world coordinates

    Returns
    -------
    float or None
        Fraction of the ray from start to end; None if all of it is not so opaque.
    """
    mapper, image, deformation = _drawn(volume)
    if image is None or mapper.GetBlendMode() != vtkVolumeMapper.COMPOSITE_BLEND:
        return None
    found = _values(mapper, image)
    if found is None:
        return None
    values, grid = found
    to_data = np.linalg.inv(_matrix(volume))
    ends = np.stack([start, end]) @ to_data[:3, :3].T + to_data[:3, 3]
    property_ = volume.GetProperty()
    found = light_along(
        lambda points: _opacity(property_, points, values, grid, deformation),
        ends,
        _corners(grid, deformation),
        _STEP * min(grid.spacing),
        property_.GetScalarOpacityUnitDistance(0),
    )
    if found is None:
        return None
    t, light = found
    return np.interp(_HIDES, 1 - light, t) if light[-1] <= 1 - _HIDES else None


def light_along(opacity_at, ends, corners, step, unit):
    """How much light has passed along a ray.

    Parameters
    ----------
    opacity_at : callable
        Opacity of points (m, 3), per `unit` of distance: (m,).
    ends : (2, 3) float64
        Of the ray.
    corners : (2, 3) float64
        Lowest and highest, of a box beyond which there is nothing.
    step : float
        From sample to sample, unless they are too many.
    unit : float

    Returns
    -------
    t : (n,) float64
        Fractions of the ray, rising from where it enters the box.
    light : (n,) float64
        What has passed all up to there, falling from 1.
    None
        If the ray does not meet the box.
    """
    near, far = _passage(ends, corners)
    length = np.linalg.norm(ends[1] - ends[0])
    count = int(np.clip((far - near) * length / step, 0, _MOST_STEPS))
    if count == 0:
        return None
    t = np.linspace(near, far, count + 1)
    middles = (t[1:] + t[:-1]) / 2
    opacity = opacity_at(ends[0] + middles[:, None] * (ends[1] - ends[0]))
    passed = (1 - np.clip(opacity, 0, 1)) ** ((far - near) * length / count / unit)
    return t, np.cumprod([1, *passed])


def _drawn(volume):
    """The mapper, the image that it draws, and the deformation with which; None without."""
    mapper = volume.GetMapper()
    if drawn := deformed_volume.drawn_as(volume):
        return mapper, *drawn
    data = mapper.GetDataObjectInput() if isinstance(mapper, vtkVolumeMapper) else None
    if isinstance(data, vtkCompositeDataSet):
        iterator = data.NewIterator()
        iterator.UnRegister(None)
        iterator.InitTraversal()
        data = iterator.GetCurrentDataObject()
    return mapper, data if isinstance(data, vtkImageData) else None, None


def _values(mapper, image):
    """The component that says how opaque, (nz, ny, nx), and its Grid; None without an array."""
    of_cells = reference(0)
    which = mapper.GetScalarMode(), mapper.GetArrayAccessMode(), mapper.GetArrayId()
    array = vtkAbstractVolumeMapper.GetScalars(image, *which, mapper.GetArrayName(), of_cells)
    if array is None:
        return None
    grid = ImageGeometry.of_image(image).grid
    grid = grid.cells if of_cells.get() == 1 else grid
    values = vtk_to_numpy(array).reshape(*grid.shape, -1)
    return values[..., -1], grid


def _matrix(volume):
    matrix = volume.GetMatrix()
    return np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])


def _corners(grid, deformation):
    """Of a box that holds what is deformed, (2, 3)."""
    corners = grid.corners()
    if deformation is None:
        return np.stack([corners.min(axis=0), corners.max(axis=0)])
    corners = np.concatenate([corners, deformation.deformed])
    low, high = corners.min(axis=0), corners.max(axis=0)
    return np.stack([low - (high - low), high + (high - low)])


def _passage(ends, corners):
    """From which to which fraction a ray is in a box."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (corners - ends[0]) / (ends[1] - ends[0])
    near, far = np.nanmax(t.min(axis=0)), np.nanmin(t.max(axis=0))
    return max(near, 0.0), max(min(far, 1.0), max(near, 0.0))


def _opacity(shown, points, values, grid, deformation):
    """Opacity of points (m, 3), per unit distance: (m,)."""
    hidden = np.zeros(len(points), bool)
    if deformation is not None:
        hidden = deformation.void(points) if deformation.cuts else hidden
        points = deformation.backward(points)
    index = grid.index_of(points)
    inside = grid.covers(index) & ~hidden
    at = sample(values, index[inside], "linear", 0, grid)
    of = shown.GetScalarOpacity(0)
    opacity = np.zeros(len(points))
    opacity[inside] = [of.GetValue(each) for each in at.ravel().tolist()]
    return opacity
