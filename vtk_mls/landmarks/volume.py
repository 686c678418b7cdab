"""What pairs tell about the volume around them, and whether a map of them makes sense there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vtk_mls.deformation import Deformation
from vtk_mls.landmarks.left_out import PointPairs, Settings
from vtk_mls.queries.inverses import cubic_grid

_MAX_THINNESS = 0.1  # smallest extent of a thin set, in the largest
_ROUNDING = 1e-9  # of the largest extent; smaller extents and motions are 0
# Error of the best reflection that shows a mirror, in that of the best similarity.
_MAX_MIRROR_ERROR = 0.5
_SAMPLES = 216  # in a cube around the pairs
_MAX_BAD = 0.1  # share of the samples that may be beyond the limits
# Limits of sensible maps: the factor of volume, beside that of all pairs, either way; and the
# displacement around thin sets, in the largest of the pairs, both without the mean. Pairs that
# hardly move count as moved by `_MIN_MOVED` of their extent.
_MAX_FACTOR, _MAX_REACH, _MIN_MOVED = 10.0, 3.0, 0.01


@dataclass(frozen=True, eq=False)
class Shape:
    """The shape of a set of pairs.

    Attributes
    ----------
    extents : (3,) float64, world units
        Along the principal axes of p or q, whichever is thinner, the largest first.
    mirror : str
        The axis "x", "y" or "z" along which q is a mirror image of p, "oblique", or "" for none.
        Thin sets have none: on a plane, a mirror and a rotation fit alike.
    is_drag : bool
        Whether most pairs rest and others move: handles, for which no outliers are looked for.
    """

    extents: NDArray[np.float64]
    mirror: str
    is_drag: bool

    @staticmethod
    def of(pairs: PointPairs) -> Shape:
        """The shape of at least 4 distinct pairs."""
        found = []
        for offset in _centered(pairs):
            axes = np.linalg.svd(offset, full_matrices=False)[2]
            found.append(np.sort(np.ptp(offset @ axes.T, axis=0))[::-1])
        extents = min(found, key=lambda extent: float(np.prod(extent / extent[0])))
        extents[extents < _ROUNDING * extents[0]] = 0
        moved = np.linalg.norm(pairs.rest - pairs.deformed, axis=1)
        at_rest = np.count_nonzero(moved <= _ROUNDING * extents[0])
        mirror = "" if _is_thin(extents) else _mirror(*_centered(pairs))
        return Shape(extents, mirror, bool(len(pairs) / 2 < at_rest < len(pairs)))

    @property
    def is_thin(self) -> bool:
        """Whether the pairs are nearly on a line or a plane: an extent is below 0.1 of another."""
        return _is_thin(self.extents)

    @property
    def is_line(self) -> bool:
        """Whether they are nearly on a line."""
        return _is_thin(self.extents[:2])


def excess(pairs: PointPairs, settings: Settings, device: str | None) -> tuple[float, Deformation]:
    """How far a map is beyond the limits of sensible ones, at most 1 for these, and the map.

    It is sampled in a cube around q as large as their largest extent, which holds the volume beside
    a line or a plane of pairs.
    """
    deformation = pairs.deformation(settings, device)
    low, high = pairs.deformed.min(axis=0), pairs.deformed.max(axis=0)
    center, side = (low + high) / 2, (high - low).max()
    v = cubic_grid(np.stack([center - side / 2, center + side / 2]), _SAMPLES).points()
    before, after = map(np.linalg.norm, _centered(pairs))
    if before == 0:  # all p are at one place
        return math.inf, deformation
    factor = np.linalg.det(deformation.jacobian(v)) * (after / before) ** 3
    factor = np.clip(np.nan_to_num(factor), 1e-300, 1e300)
    result = _quantile(np.abs(np.log(factor))) / math.log(_MAX_FACTOR)
    if not Shape.of(pairs).is_thin:
        return result, deformation
    displacement = pairs.rest - pairs.deformed
    mean = displacement.mean(axis=0)
    moved = np.linalg.norm(displacement - mean, axis=1).max()
    reach = _quantile(np.linalg.norm(deformation.backward(v) - v - mean, axis=1))
    return max(result, reach / float(_MAX_REACH * max(moved, _MIN_MOVED * side))), deformation


def _centered(pairs):
    return [points - points.mean(axis=0) for points in (pairs.rest, pairs.deformed)]


def _is_thin(extents: NDArray[np.float64]) -> bool:
    return bool(extents[-1] < _MAX_THINNESS * extents[0])


def _mirror(p, q):
    """`Shape.mirror` of centered points (n, 3)."""
    left, size, right = np.linalg.svd(p.T @ q)
    size /= np.linalg.norm(p) * np.linalg.norm(q)
    turn = np.sign(np.linalg.det(left @ right))
    # squared errors of the best similarity without and with a reflection
    error, reflected = (1 - (size @ (1, 1, sign)) ** 2 for sign in (turn, -turn))
    if turn > 0 or reflected > _MAX_MIRROR_ERROR**2 * error:
        return ""
    axes = [axis for axis, cosine in zip("xyz", np.diag(left @ right)) if cosine < -0.9]
    return axes[0] if len(axes) == 1 else "oblique"


def _quantile(values):
    return float(np.quantile(np.nan_to_num(values, nan=1e300, posinf=1e300), 1 - _MAX_BAD))
