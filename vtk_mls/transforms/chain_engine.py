"""The engine of transforms that are evaluated point by point: implements `engine.protocol.Engine`.

Questions on grids go through slabs of points. Arrays are sampled by the engine of the device.
"""

import numpy as np

from vtk_mls.base.linear_algebra import transformed
from vtk_mls.base.progress import SILENT
from vtk_mls.engine.dispatch import engine_for
from vtk_mls.queries import fields
from vtk_mls.queries.vector_fields import sampled_parts
from vtk_mls.reference import reference_engine as reference

NAME = "pointwise (numpy, float64)"

gradient, sample = reference.gradient, reference.sample
void_by_corners = reference.void_by_corners


def doubtful_voxels(displacement, axes, progress=SILENT):
    return engine_for(None).doubtful_voxels(displacement, axes, progress)


def backward(transform, points, progress=SILENT):
    return transform._origins(points, progress)


def jacobian(transform, points, progress=SILENT, origins=None):
    return transform._jacobians(points, progress)


def forward(transform, points, progress=SILENT):
    return transform._search(points, progress)


def displacement_field(transform, grid, progress=SILENT):
    displacement = np.empty((grid.size, 3), np.float32)
    void_distance = np.empty(grid.size, np.float32) if transform.cuts else None
    for part, v, origins, distance, _ in _slabs(transform, grid, progress):
        displacement[part] = origins - v
        if transform.cuts:
            void_distance[part] = distance
    void_distance = void_distance.reshape(grid.shape) if transform.cuts else None
    return displacement.reshape(*grid.shape, 3), void_distance


def jacobian_field(transform, grid, progress=SILENT):
    result = np.empty((grid.size, 3, 3), np.float32)
    for part, *_, jacobian in _slabs(transform, grid, progress, with_jacobian=True):
        result[part] = jacobian.swapaxes(1, 2)
    return result.reshape(*grid.shape, 3, 3)


def resample(transform, arrays, sampling, progress=SILENT, void_distance=None, covariant=None):
    parts = _sources(transform, sampling, progress, with_jacobian=bool(covariant))
    versions = map(sampling.version, range(len(arrays)))
    # by a new version a device keeps the array for all slabs
    versions = [object() if version is None else version for version in versions]
    sample = engine_for(transform.device).sample
    return sampled_parts(arrays, versions, sampling, parts, sample, void_distance, covariant)


def void_distance_listed(transform, grid, indices, progress=SILENT):
    result = np.empty(len(indices), np.float32)
    for rows, part in progress.chunks(len(indices), fields.MAX_SLAB_POINTS):
        result[rows] = transform._void_distance(grid.points_of(indices[rows]), part)
    return result


def source_index(transform, sampling, progress=SILENT):
    return np.concatenate([index for _, index, *_ in _sources(transform, sampling, progress)])


def _sources(transform, sampling, progress, with_jacobian=False):
    """Parts of the target with their origins, as indices (m, 3) of the whole source.

    And their void distances (m,) or None, and Jacobians (m, 3, 3) or None.
    """
    source, target = sampling.source, sampling.target
    matrix, offset = target.whole.index_transform(source.whole)
    for part, v, origins, distance, jacobian in _slabs(transform, target, progress, with_jacobian):
        index = transformed(matrix, target.indices(part.start, part.stop) + target.first)
        # exact where nothing moves
        index += offset + transformed(source.world_to_index, origins - v)
        if distance is not None and not sampling.continues:
            index[distance < 0] = -np.inf
        yield part, index, distance, jacobian


def _slabs(transform, grid, progress, with_jacobian=False):
    """Slices of the points of a grid, the points, and what `_on_grid` returns there."""
    start = 0
    for _, slab, part in fields.slabs(grid, progress):
        v = slab.points()
        results = transform._on_grid(slab, v, part, with_jacobian)
        yield slice(start, start + slab.size), v, *results
        start += slab.size
