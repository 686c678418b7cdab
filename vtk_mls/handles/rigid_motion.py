"""Rigid motions: the one that fits moved points, and a part of one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vtk_mls.handles.curve import CurveHandle
from vtk_mls.handles.handle_set import Handle
from vtk_mls.handles.region import RegionHandle


def fitted_motion(
    rest: NDArray[np.float64], deformed: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """The rotation and translation that fit moved points best (Kabsch).

    Parameters
    ----------
    rest, deformed : (n, 3) float64, world coordinates

    Returns
    -------
    motion : (4, 4) float64
        From `rest` to `deformed`.
    residual : float, world units
        The largest distance of a moved point from its position in `deformed`.
    """
    before, after = rest.mean(axis=0), deformed.mean(axis=0)
    covariance = np.einsum("ni,nj->ij", deformed - after, rest - before)
    left, _, right = np.linalg.svd(covariance)
    left[:, 2] *= np.sign(np.linalg.det(left @ right))  # no mirror image
    motion = np.eye(4)
    motion[:3, :3] = left @ right
    motion[:3, 3] = after - motion[:3, :3] @ before
    moved = np.einsum("ij,nj->ni", motion[:3, :3], rest - before) + after
    return motion, float(np.linalg.norm(moved - deformed, axis=1).max())


def blended(handle: Handle, share: float) -> Handle:
    """A handle with a `share` of its displacement: regions turn by that share of their angle."""
    if isinstance(handle, CurveHandle):
        return CurveHandle(handle.rest, handle.rest + share * (handle.deformed - handle.rest))
    center, moved = handle.center
    motion = np.eye(4)
    motion[:3, :3] = _turned_by_share(handle.motion[:3, :3], share)
    motion[:3, 3] = center + share * (moved - center) - motion[:3, :3] @ center
    return RegionHandle(handle.shape, motion)


def _turned_by_share(turn, share):
    """The rotation (3, 3) about the axis of another, by a share of its angle."""
    values, vectors = np.linalg.eig(turn)
    axis = np.real(vectors[:, np.argmin(np.abs(values - 1))])
    across = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    # the sign of the angle is that about this axis
    angle = np.arctan2(-np.einsum("ij,ij->", across, turn.T), np.trace(turn) - 1) * share
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across
