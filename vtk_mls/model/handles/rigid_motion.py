"""Rigid motions: the one that fits moved points, and a part of one."""

import numpy as np


def fitted_motion(rest, deformed):
    """The rotation and translation (4, 4) that fit moved points (n, 3) best (Kabsch).

    And the largest distance of a moved point from its position in `deformed`.
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


def screw(region, share):
    """A `share` of the motion (4, 4) of a region as a screw: about one axis, and along it."""
    center, moved = region.center
    axis, angle = axis_and_angle(region.motion[:3, :3])
    along = axis * (axis @ (moved - center))
    around = moved - center - along
    # (I - R(share angle)) (I - R(angle))^-1, a turn with a factor in the plane across the axis
    factor = np.sin(share * angle / 2) / np.sin(angle / 2) if angle else share
    motion = np.eye(4)
    motion[:3, :3] = turn = rotation(axis, share * angle)
    offset = factor * np.einsum("ij,j->i", rotation(axis, (share - 1) * angle / 2), around)
    motion[:3, 3] = center + share * along + offset - np.einsum("ij,j->i", turn, center)
    return motion


def axis_and_angle(turn):
    """The axis (3,) and angle of a rotation (3, 3)."""
    values, vectors = np.linalg.eig(turn)
    axis = np.real(vectors[:, np.argmin(np.abs(values - 1))])
    # the sign of the angle is that about this axis
    return axis, np.arctan2(-np.einsum("ij,ij->", _cross(axis), turn.T), np.trace(turn) - 1)


def rotation(axis, angle):
    """The rotation (3, 3) by an angle."""
    across = _cross(axis)
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def _cross(axis):
    return np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
