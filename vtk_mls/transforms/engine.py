"""The engine of transforms that are evaluated point by point: `engine.protocol.Engine`.

Questions on grids go through slabs of points. Arrays are sampled by the engine of the transform's
device.
"""

from __future__ import annotations

NAME = "pointwise (numpy, float64)"


def backward(transform, points, progress):
    return transform.origins(points, progress)


def jacobian(transform, points, progress, origins=None):
    return transform.jacobians(points, progress)


def forward(transform, points, progress):
    return transform.search(points, progress)
