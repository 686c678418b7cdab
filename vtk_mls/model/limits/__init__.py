"""Limits: masks and faces that say where a deformation acts."""

import numpy as np

from vtk_mls.model.limits.faces import FixedFace, SlidingFace
from vtk_mls.model.limits.limit import Limit
from vtk_mls.model.limits.masks import BallMask, BoxMask, ImageMask, Mask

__all__ = ["BallMask", "BoxMask", "FixedFace", "ImageMask", "Limit", "Mask", "SlidingFace"]


def limited(limits, v, displacement):
    """The displacements (m, 3) at points `v` (m, 3) after all `limits`."""
    for limit in limits:
        factor = limit.factor(v)[0][:, None]
        if limit.slides:
            normal = limit.normal(v)[0]
            along = np.sum(normal * displacement, axis=1, keepdims=True)
            displacement = displacement - (1 - factor) * along * normal
        else:
            displacement = factor * displacement
    return displacement


def limited_jacobians(limits, v, displacement, d_dv, d_dx):
    """The derivatives (m, 3, 3) of displacements after all `limits`.

    `d_dv` and `d_dx` are those of the `displacement` (m, 3) before them, at fixed origins x and by
    the origins.
    """
    for limit in limits:
        factor, slope = limit.factor(v)
        share = (1 - factor)[:, None, None]
        if limit.slides:
            normal, turn = limit.normal(v)
            outer = normal[:, :, None] * normal[:, None]
            along = np.sum(normal * displacement, axis=1)[:, None, None]
            turned = np.einsum("mij,mi->mj", turn, displacement)
            d_dv = d_dv - share * (outer @ d_dv) + along * normal[:, :, None] * slope[:, None]
            d_dv = d_dv - share * (along * turn + normal[:, :, None] * turned[:, None])
            d_dx = d_dx - share * (outer @ d_dx)
            displacement = displacement - share[:, :, 0] * along[:, :, 0] * normal
        else:
            d_dv = factor[:, None, None] * d_dv + displacement[:, :, None] * slope[:, None]
            d_dx = factor[:, None, None] * d_dx
            displacement = factor[:, None] * displacement
    return d_dv, d_dx


def are_fixed(limits, points):
    """Which `points` (m, 3) stay at rest whatever the handles do: (m,) bool."""
    fixed = [limit.factor(points)[0] == 0 for limit in limits if not limit.slides]
    return np.any(fixed, axis=0) if fixed else np.zeros(len(points), bool)
