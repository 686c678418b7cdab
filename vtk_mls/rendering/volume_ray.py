"""Opacity of a volume along a ray."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkImageData
from vtkmodules.vtkRenderingVolume import vtkVolumeMapper

from vtk_mls.base.interpolation import sample
from vtk_mls.files.block_files import leaves
from vtk_mls.rendering import deformed_volume
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.transforms import matrix_of

_OPAQUE = 0.5  # accumulated opacity that counts as opaque
_STEP = 0.5  # of the smallest spacing
_MAX_STEPS = 2000


def opaque_at(volume, start, end):
    """Where a ray becomes half opaque, in VTK's composite blending.

    The fraction of the ray from `start` to `end`, world coordinates; None if it does not become
    opaque, as with other blend modes, and for volumes that are no images.
    """
    mapper, image, deformation = _drawn(volume)
    if image is None or mapper.GetBlendMode() != vtkVolumeMapper.COMPOSITE_BLEND:
        return None
    data = _values(mapper, image)
    if data is None:
        return None
    values, grid = data
    to_data = np.linalg.inv(matrix_of(volume.GetMatrix()))
    ends = np.stack([start, end]) @ to_data[:3, :3].T + to_data[:3, 3]
    property_ = volume.GetProperty()
    light = light_along(
        lambda points: _opacity(property_, points, values, grid, deformation),
        ends,
        _corners(grid, deformation),
        _STEP * min(grid.spacing),
        property_.GetScalarOpacityUnitDistance(0),
    )
    if light is None:
        return None
    t, transmitted = light
    return np.interp(_OPAQUE, 1 - transmitted, t) if transmitted[-1] <= 1 - _OPAQUE else None


def light_along(opacity_at, ends, corners, step, unit):
    """Transmitted light along a ray: fractions of the ray (n,), and the light there (n,) from 1 on.

    `opacity_at(points)` is per `unit` of distance, `ends` (2, 3) are those of the ray, and
    `corners` (2, 3) those of the box that contains the volume. Samples are `step` apart, or more if
    there would be too many. None if the ray misses the box.
    """
    near, far = _passage(ends, corners)
    length = np.linalg.norm(ends[1] - ends[0])
    count = int(np.clip((far - near) * length / step, 0, _MAX_STEPS))
    if count == 0:
        return None
    t = np.linspace(near, far, count + 1)
    middles = (t[1:] + t[:-1]) / 2
    opacity = opacity_at(ends[0] + middles[:, None] * (ends[1] - ends[0]))
    transmitted = (1 - np.clip(opacity, 0, 1)) ** ((far - near) * length / count / unit)
    return t, np.cumprod([1, *transmitted])


def _drawn(volume):
    """The mapper of a volume, its image or None, and its Deformation or None."""
    mapper = volume.GetMapper()
    if drawn := deformed_volume.drawn_as(volume):
        return mapper, *drawn
    data = mapper.GetDataObjectInput() if isinstance(mapper, vtkVolumeMapper) else None
    if isinstance(data, vtkCompositeDataSet):
        data = next(iter(leaves(data)), None)
    return mapper, data if isinstance(data, vtkImageData) else None, None


def _values(mapper, image):
    """The component for opacity, (nz, ny, nx), and its Grid; None without an array."""
    array, is_cell_data = deformed_volume.scalars_of(mapper, image)
    if array is None:
        return None
    grid = ImageGeometry.of_image(image).grid
    grid = grid.cells if is_cell_data else grid
    values = arrays.to_numpy(array).reshape(*grid.shape, -1)
    return values[..., -1], grid


def _corners(grid, deformation):
    corners = grid.corners()
    if deformation is None:
        return np.stack([corners.min(axis=0), corners.max(axis=0)])
    corners = np.concatenate([corners, deformation.handle_set.positions[1]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    return np.stack([low - (high - low), high + (high - low)])


def _passage(ends, corners):
    """The fractions at which a ray enters and leaves a box."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (corners - ends[0]) / (ends[1] - ends[0])
    near, far = np.nanmax(t.min(axis=0)), np.nanmin(t.max(axis=0))
    return max(near, 0.0), max(min(far, 1.0), max(near, 0.0))


def _opacity(property_, points, values, grid, deformation):
    origins, has_material = material_at(deformation, points)
    index = grid.index_of(origins)
    inside = grid.covers(index) & has_material
    samples = sample(values, index[inside], "linear", 0, grid)
    function = property_.GetScalarOpacity(0)
    opacity = np.zeros(len(points))
    opacity[inside] = [function.GetValue(value) for value in samples.ravel().tolist()]
    return opacity


def material_at(deformation, points):
    """Origins of `points` (m, 3), world coordinates, and which of them have material: (m,) bool.

    They have none in voids between the faces of cuts. The Deformation None is the identity.
    """
    if deformation is None:
        return points, np.ones(len(points), bool)
    has_material = ~deformation.void(points) if deformation.cuts else np.ones(len(points), bool)
    return deformation.backward(points), has_material
