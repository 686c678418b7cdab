"""A set of control points, prepared once in float64 for every engine.

The kernels compute in float32, so this module decides in float64 which control points are distinct,
which maps they determine (a line leaves the twist open, a plane the affine thickness, few points
cubic terms), and the local frame in which coordinates are small.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from vtk_mls.base.linear_algebra import fitted_affine
from vtk_mls.base.validation import freeze
from vtk_mls.kinds.kind import Kind

# Distance of coincident control points, as a fraction of `extent`.
_COINCIDENT = 1e-12


@dataclass(frozen=True, eq=False, init=False)
class ControlPoints:
    """Distinct control points with their local frame.

    Parameters
    ----------
    rest, deformed : (n, 3) float64, world coordinates
        p and q. Control points with the same q are merged into their weighted mean, which changes
        no kind of map; a set with a common displacement is merged into a single point.
    weights : (n,) float64
        Factor of each control point.
    kind : Kind
        Of the fitted maps.
    extent : float, world units
        Size of the deformed region: the scale if all control points coincide.

    Attributes
    ----------
    center, scale : (3,) float64 and float, world coordinates
        The local frame: (x - center) / scale. All tolerances are in its units.
    mean_displacement : (3,) float64, world units
        Mean of p - q.
    determined : object
        The maps of `kind` that the control points determine: `Kind.determined`.
    """

    rest: np.ndarray
    deformed: np.ndarray
    weights: np.ndarray
    kind: Kind
    center: np.ndarray
    scale: float
    mean_displacement: np.ndarray
    determined: object

    def __init__(self, rest, deformed, weights, kind, extent):
        rest, deformed, weights = _merge(rest, deformed, weights)
        center = deformed.mean(axis=0)
        size = np.abs(deformed - center).max()
        scale = float(size if size > _COINCIDENT * extent else extent)
        freeze(
            self,
            rest=rest,
            deformed=deformed,
            weights=weights,
            kind=kind,
            center=center,
            scale=scale,
            mean_displacement=(rest - deformed).mean(axis=0),
            determined=kind.determined(rest, deformed, (deformed - center) / scale),
        )

    def __len__(self) -> int:
        return len(self.rest)

    @functools.cached_property
    def affine(self) -> tuple[np.ndarray, np.ndarray]:
        """The best fitting affine map from deformed to rest positions: (3, 3) and (3,)."""
        return fitted_affine(self.deformed, self.rest)

    def local(self, points) -> np.ndarray:
        """World coordinates `points` (m, 3) in the local frame."""
        return (points - self.center) / self.scale


def _merge(rest, deformed, weights):
    """Weighted means of control points with equal q, or of all if their displacement is common."""
    _, group = np.unique(deformed, axis=0, return_inverse=True)
    group = group.ravel()
    is_translation = (rest - deformed == rest[0] - deformed[0]).all()
    if is_translation:
        group = np.zeros_like(group)
    count = group.max() + 1
    if count == len(rest):
        return rest, deformed, weights
    total = np.bincount(group, weights)

    def mean(points):
        offset = points - points[0]  # keeps the digits of large coordinates
        sums = np.stack([np.bincount(group, weights * c) for c in offset.T], axis=1)
        return points[0] + sums / total[:, None]

    merged = mean(deformed)
    if is_translation:  # p - q exactly as given
        return merged + (rest[:1] - deformed[:1]), merged, total
    return mean(rest), merged, total
