"""A share of the movement of a handle."""

from __future__ import annotations

import numpy as np

from vtk_mls.handles.curve import CurveHandle
from vtk_mls.handles.region import RegionHandle

_TINY_ANGLE = 1e-9  # radians, below which a motion is a translation


def blended(handle, share):
    """The handle after a `share` of its movement: 0 at rest, 1 as it is.

    Nodes of curves move along straight lines, regions along a screw.
    """
    if share == 1:
        return handle
    if isinstance(handle, RegionHandle):
        return RegionHandle(handle.shape, screw(handle.motion, share))
    return CurveHandle(handle.rest, handle.rest + share * (handle.deformed - handle.rest))


def at_rest(handle):
    """The handle at its rest position."""
    if isinstance(handle, RegionHandle):
        return RegionHandle(handle.shape, np.eye(4))
    return CurveHandle(handle.rest, handle.rest)


def is_resting(handle):
    """Whether a handle moves nothing."""
    if isinstance(handle, RegionHandle):
        return bool((handle.motion == np.eye(4)).all())
    return bool((handle.rest == handle.deformed).all())


def screw(motion, share):
    """The motion (4, 4) by a `share` of the turn and the shift along the screw axis of `motion`.

    In the group of motions it is exp(share log(motion)). A half turn may go either way.
    """
    axis, angle = _axis_angle(motion[:3, :3])
    velocity = np.linalg.solve(_shift_of(axis, angle), motion[:3, 3])
    part = np.eye(4)
    part[:3, :3] = _rotation(axis, share * angle)
    part[:3, 3] = share * _shift_of(axis, share * angle) @ velocity
    return part


def _skew(axis):
    x, y, z = axis
    return np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])


def _rotation(axis, angle):
    """Rodrigues' formula."""
    cross = _skew(axis)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _shift_of(axis, angle):
    """The matrix from the constant velocity of a screw to its shift after a unit of time."""
    if abs(angle) < _TINY_ANGLE:
        return np.eye(3)
    cross = _skew(axis)
    bend, slip = (1 - np.cos(angle)) / angle, 1 - np.sin(angle) / angle
    return np.eye(3) + bend * cross + slip * cross @ cross


def _axis_angle(turn):
    """Unit axis (3,) and angle from 0 to pi of a rotation, by its quaternion."""
    # the quaternion is the eigenvector of the largest eigenvalue (Bar-Itzhack)
    xx, xy, xz, yx, yy, yz, zx, zy, zz = turn.ravel()
    form = np.array(
        [
            (xx - yy - zz, yx + xy, zx + xz, zy - yz),
            (yx + xy, yy - xx - zz, zy + yz, xz - zx),
            (zx + xz, zy + yz, zz - xx - yy, yx - xy),
            (zy - yz, xz - zx, yx - xy, xx + yy + zz),
        ]
    )
    *vector, scalar = np.linalg.eigh(form)[1][:, -1]
    vector = np.array(vector) * (1.0 if scalar >= 0 else -1.0)
    length = np.linalg.norm(vector)
    axis = vector / length if length > 0 else np.array((0.0, 0.0, 1.0))
    return axis, 2 * float(np.arctan2(length, abs(scalar)))
