"""Host data as the kernels read it: float32 tables, vectors and transforms."""

from __future__ import annotations

import numpy as np

from vtk_mls.control_points import MONOMIAL_COUNT


def planes(points):
    """Points (m, 3) as the kernels take them: (3, m) float32."""
    return np.ascontiguousarray(points.T, dtype=np.float32)


def tables(control_points):
    """What the kernels read of a handle set, float32: points, basis values, basis coefficients."""
    count, functions = len(control_points), MONOMIAL_COUNT[control_points.degree]
    points = np.zeros((count, 8), np.float32)
    points[:, 0:3] = control_points.local(control_points.deformed)
    points[:, 3] = control_points.weights / control_points.weights.mean()
    points[:, 4:7] = (
        control_points.rest - control_points.deformed - control_points.mean_displacement
    ) / control_points.scale
    values = np.zeros((count, functions), np.float32)
    values[:, : len(control_points.basis)] = (
        control_points.basis.values - control_points.basis.values.mean(axis=0)
    )
    coefficients = np.zeros((functions, functions), np.float32)
    coefficients[: len(control_points.basis)] = control_points.basis.coefficients
    return points, values, coefficients


def lattice(grid, part, control_points):
    """Kernel arguments of the points `part` of `grid`, with their way to the local frame."""
    frame = transform(
        grid.index_to_world / control_points.scale, control_points.local(grid.whole.origin)
    )
    nx, ny, _ = grid.dimensions
    bounds = np.int64(part.start), np.int64(part.stop)
    return *bounds, np.int32(nx), np.int32(ny), int4(grid.first), frame


def transform(matrix, offset):
    """An affine transform as `transformed` in lattice.cl takes it."""
    packed = np.zeros(16, np.float32)
    packed[:12] = np.concatenate([np.asarray(matrix).T.ravel(), offset])
    return packed


def to_source(source, target, control_points, continued):
    """First arguments of the kernels that tell where in `source` points of `target` come from."""
    matrix, offset = target.whole.index_transform(source.whole)
    turn = np.linalg.inv(source.index_to_world)
    return (
        transform(matrix, offset + turn @ control_points.mean_displacement),
        transform(turn * control_points.scale, np.zeros(3)),
        np.int32(continued),
    )


def float4(vector):
    packed = np.zeros(4, np.float32)
    packed[:3] = vector
    return packed


def int4(vector):
    packed = np.zeros(4, np.int32)
    packed[:3] = vector
    return packed
