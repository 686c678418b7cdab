"""Rigid and similarity deformations: the best fitting rotation, Eq. 8 to 22."""

from typing import NamedTuple

import numpy as np

from vtk_mls.base.linear_algebra import finite, unit
from vtk_mls.model.kinds.kind import Fit, Kind

# Smallest product of the relative widths of p and q that determines the twist about a line.
TWIST_TOLERANCE = 1e-5
_ANY_AXIS = np.array([1.0, 0.0, 0.0])


class RotationRank(NamedTuple):
    """The part of a rotation that control points determine, for all weights in C of Eq. 11."""

    rank: int  # 0: nothing, 1: all except the twist about a line, 2: everything
    # with rank 1 a unit vector normal to the line: the axis of a rotation by exactly 180 degrees
    flip_axis: np.ndarray


class Rigid(Kind):
    """Rotations and translations."""

    name = "rigid"
    kernel = "fit_rotation.cl"
    equation = 8
    scales = False  # whether the fitted map has a uniform factor

    def determined(self, points):
        positions = np.stack(points.handles.positions)
        offsets = positions - positions.mean(axis=1, keepdims=True)
        lengths = np.linalg.svd(offsets, compute_uv=False)
        size = np.abs(positions).max(axis=(1, 2))
        if lengths.shape[1] < 2 or (lengths[:, 0] <= 1e-12 * size).any():
            return RotationRank(0, _ANY_AXIS)
        width_p, width_q = lengths[:, 1] / lengths[:, 0]
        if width_p * width_q > TWIST_TOLERANCE:
            return RotationRank(2, _ANY_AXIS)
        narrow = offsets[0 if width_p < width_q else 1]
        line = np.linalg.svd(narrow, full_matrices=False)[2][0]
        normal = np.cross(line, np.eye(3)[np.abs(line).argmin()])
        return RotationRank(1, normal / np.linalg.norm(normal))

    def fit(self, weighted):
        fit = _RotationFit(weighted, self.scales)
        return Fit(fit.displacement, fit.linear, fit.influence)

    def constants(self):
        return {"SIMILARITY": int(self.scales)}

    def params(self, control_points):
        rank, flip_axis = control_points.determined
        return {"rank": rank, "flip_axis": flip_axis}


class Similarity(Rigid):
    """Rotations and translations with a uniform factor, end of section 2."""

    name = "similarity"
    equation = 22
    scales = True


class _RotationFit:
    """The rotation that maximizes Eq. 9, and the factor of the similarity kind."""

    def __init__(self, weighted, scales):
        self.weighted, self.scales = weighted, scales
        w, p, q = weighted.w, weighted.p, weighted.q
        # C of Eq. 11
        self.c = np.einsum("mi,mia,mib->mab", w, p, q)
        self.rank, self.flip_axis = weighted.control_points.determined
        if self.rank == 2:
            self.rotation = _largest_rotation(self.c)
        elif self.rank == 1:
            self.rotation = self._rotation_of_line()
        else:
            self.rotation = np.broadcast_to(np.eye(3), self.c.shape)
        self.r_max = np.einsum("mab,mab->m", self.rotation, self.c)
        self.spread = np.einsum("mi,mia,mia->m", w, q, q)
        self.factor = np.ones(len(w))
        if scales:  # mu_s, end of section 2
            np.divide(self.r_max, self.spread, out=self.factor, where=self.spread > 0)
        offset = weighted.x - weighted.q_star
        self.rotated = np.einsum("mab,mb->ma", self.rotation, offset)
        self.displacement = (
            (weighted.p_k - weighted.q_k)
            + (weighted.p_star - weighted.q_star)
            + (self.factor[:, None] * self.rotated - offset)
        )
        self.linear = self.factor[:, None, None] * self.rotation

    def _rotation_of_line(self):
        """The twist-free rotation for C = s a^T b, which turns b to a."""
        rows = np.linalg.norm(self.c, axis=2)
        b = unit(np.take_along_axis(self.c, rows.argmax(axis=1)[:, None, None], axis=1)[:, 0])
        a = unit(np.einsum("mab,mb->ma", self.c, b))
        b = np.where(np.einsum("mab,ma,mb->m", self.c, a, b)[:, None] < 0, -b, b)
        self.line = a, b
        half = a + b
        opposite = np.linalg.norm(half, axis=1) < 1e-5
        half = np.where(opposite[:, None], 0, unit(half))
        quaternion = np.hstack([np.sum(half * b, axis=1)[:, None], np.cross(b, half)])
        quaternion[opposite, 1:] = self.flip_axis
        quaternion[(a == 0).all(axis=1)] = (1, 0, 0, 0)
        return _rotation_matrix(quaternion)

    def influence(self):
        p, q = self.weighted.p, self.weighted.q
        rotated = np.einsum("mab,mib->mia", self.rotation, q)
        residual = p - self.factor[:, None, None] * rotated
        influence = residual / self.weighted.total[:, None, None]
        moved = self.factor[:, None] * self.rotated
        if self.rank == 2:
            # R^T C = S stays symmetric: (tr(S) I - S) omega = q x R^T p for each control point
            s = np.einsum("mba,mbc->mac", self.rotation, self.c)
            trace = np.trace(s, axis1=1, axis2=2)[:, None, None]
            stiffness = trace * np.eye(3) - (s + s.swapaxes(1, 2)) / 2
            torque = np.cross(q, np.einsum("mba,mib->mia", self.rotation, p))
            omega = np.einsum("mab,mib->mia", np.linalg.pinv(finite(stiffness)), torque)
            omega = np.einsum("mab,mib->mia", self.rotation, omega)
            influence = influence + np.cross(omega, moved[:, None])
        elif self.rank == 1:
            influence = influence + np.cross(self._velocity_of_line(), moved[:, None])
        if self.scales:
            stretch = np.sum(p * rotated, axis=2) - self.factor[:, None] * np.sum(q**2, axis=2)
            spread = np.where(self.spread > 0, self.spread, np.inf)
            influence = influence + (stretch / spread[:, None])[:, :, None] * self.rotated[:, None]
        return influence

    def _velocity_of_line(self):
        """Derivative of the twist-free rotation by each weight, as an angular velocity."""
        p, q = self.weighted.p, self.weighted.q
        a, b = (axis[:, None] for axis in self.line)
        strength = np.maximum(self.r_max, np.finfo(float).tiny)[:, None, None]
        da = p * np.sum(q * b, axis=2, keepdims=True) / strength
        db = q * np.sum(p * a, axis=2, keepdims=True) / strength
        da -= a * np.sum(a * da, axis=2, keepdims=True)
        db -= b * np.sum(b * db, axis=2, keepdims=True)
        rotated = np.einsum("mab,mib->mia", self.rotation, np.cross(a + b, db))
        divisor = np.maximum(1 + np.sum(a * b, axis=2, keepdims=True), 1e-10)
        return (np.cross(a + b, da) - rotated) / divisor


def _largest_rotation(c):
    """The rotation (m, 3, 3) that maximizes tr(R^T C), as column matrix p = R q.

    The largest root of the quartic of Eq. 22 is the largest eigenvalue of this symmetric matrix,
    and the eigenvector is the rotation of Eq. 10 as a quaternion (Horn 1987).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.moveaxis(c, 0, -1)
    rows = [
        [xx + yy + zz, zy - yz, xz - zx, yx - xy],
        [zy - yz, xx - yy - zz, xy + yx, zx + xz],
        [xz - zx, xy + yx, yy - xx - zz, yz + zy],
        [yx - xy, zx + xz, yz + zy, zz - xx - yy],
    ]
    horn = np.array(rows)
    scale = np.abs(horn).max(axis=(0, 1))
    horn = finite(np.moveaxis(horn / np.where(scale > 0, scale, 1), -1, 0))
    return _rotation_matrix(np.linalg.eigh(horn)[1][:, :, -1])


def _rotation_matrix(quaternion):
    """Rotation matrices (m, 3, 3) of unit quaternions (m, 4) = (w, x, y, z)."""
    w, x, y, z = quaternion.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
