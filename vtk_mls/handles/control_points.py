"""A set of control points, prepared once in float64 for every engine.

The kernels work in float32. What they cannot decide safely is decided here: which control points
are distinct, what the set determines (a line has no twist, a plane no affine thickness, few points
no cubic), and the local frame in which coordinates are small.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field

import numpy as np

from vtk_mls.base.linear_algebra import fitted_affine
from vtk_mls.kinds.kind import Kind

# Control points coincide if they are no farther apart than this share of the world.
_COINCIDENT = 1e-12


@dataclass(frozen=True, eq=False)
class ControlPoints:
    """Distinct control points with their classification and local frame.

    Attributes
    ----------
    rest, deformed : (n, 3) float64, world coordinates
        p and q. Control points with the same q are merged into their weighted mean, which leaves
        every kind of map as it is; a set that moves as one is merged into a single point.
    weights : (n,) float64
        Factor of each control point.
    kind : Kind
        Of the maps that are fitted to them.
    world : float, world units
        The size of all that is deformed: the scale where the control points coincide.
    centre, scale : (3,) float64 and float, world coordinates
        The local frame: (x - centre) / scale. All tolerances are in its units.
    mean_displacement : (3,) float64, world units
        Mean of p - q.
    determined : object
        What they tell of the maps of `kind`, as `Kind.determined` has it.
    """

    rest: np.ndarray
    deformed: np.ndarray
    weights: np.ndarray
    kind: Kind
    world: float
    centre: np.ndarray = field(init=False)
    scale: float = field(init=False)
    mean_displacement: np.ndarray = field(init=False)
    determined: object = field(init=False)

    def __post_init__(self):
        rest, deformed, weights = _merge(self.rest, self.deformed, self.weights)
        centre = deformed.mean(axis=0)
        size = np.abs(deformed - centre).max()
        values = {
            "rest": rest,
            "deformed": deformed,
            "weights": weights,
            "centre": centre,
            "scale": float(size if size > _COINCIDENT * self.world else self.world),
            "mean_displacement": (rest - deformed).mean(axis=0),
        }
        local = (deformed - centre) / values["scale"]
        values["determined"] = self.kind.determined(rest, deformed, local)
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.rest)

    @functools.cached_property
    def affine(self) -> tuple[np.ndarray, np.ndarray]:
        """The affine map from deformed to rest positions that fits best: (3, 3) and (3,)."""
        return fitted_affine(self.deformed, self.rest)

    def local(self, points) -> np.ndarray:
        """`points` (m, 3) of the world in the local frame."""
        return (points - self.centre) / self.scale


def _merge(rest, deformed, weights):
    """Weighted means of the control points that share q; one point if all of them move alike."""
    _, group = np.unique(deformed, axis=0, return_inverse=True)
    group = group.ravel()
    alike = (rest - deformed == rest[0] - deformed[0]).all()
    if alike:
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
    if alike:  # p - q exactly as given
        return merged + (rest[:1] - deformed[:1]), merged, total
    return mean(rest), merged, total
