"""A set of handles, prepared once in float64 for every engine.

The kernels compute in float32. So this module decides in float64 which control points are distinct
and which maps they determine (a line does not determine the twist, a plane the affine thickness,
few points the cubic terms), and finds the local frame in which coordinates are small.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field, replace

import numpy as np

from vtk_mls.base.linear_algebra import fitted_affine
from vtk_mls.base.validation import freeze
from vtk_mls.model.handles import handle_paths
from vtk_mls.model.handles.curve import Segments
from vtk_mls.model.handles.handle_set import HandleSet
from vtk_mls.model.kinds.kind import Kind

# Distance of coincident control points, as a fraction of `extent`.
_COINCIDENT = 1e-12


@dataclass(frozen=True, eq=False)
class ControlPoints:
    """Distinct control points with their local frame, for a kind of map.

    Points of the `HandleSet` with the same q are merged into their weighted mean, which changes no
    kind of map; a set with a common displacement becomes a single point. If all control points
    coincide, `extent`, the size of the deformed region, is the scale. All tolerances are in units
    of the local frame, (x - center) / scale. The mean displacement p - q counts as 0 with
    `has_zero_mean`: if the displacement is exactly 0 at some places, and in steps.
    """

    handles: HandleSet
    kind: Kind
    has_zero_mean: bool
    center: np.ndarray
    scale: float
    mean_displacement: np.ndarray
    _steps: tuple[ControlPoints, ...] = field(default=(), init=False)

    @classmethod
    def of(cls, handles, kind, extent, has_zero_mean=False):
        """The control points of a `HandleSet`."""
        handles = _merged(handles)
        rest, deformed = handles.positions
        center = deformed.mean(axis=0)
        size = np.abs(deformed - center).max()
        scale = float(size if size > _COINCIDENT * extent else extent)
        mean = np.zeros(3) if has_zero_mean else (rest - deformed).mean(axis=0)
        return cls(handles, kind, has_zero_mean, center, scale, mean)

    @functools.cached_property
    def determined(self) -> object:
        """The part of the map that the control points determine."""
        return self.kind.determined(self)

    def __len__(self) -> int:
        return len(self.handles)

    @property
    def swapped(self) -> ControlPoints:
        """The control points with p and q swapped."""
        return ControlPoints.of(self.handles.swapped, self.kind, self.scale, self.has_zero_mean)

    def steps(self, count: int) -> tuple[ControlPoints, ...]:
        """The steps along the path, in the local frame of the whole; only with `has_zero_mean`."""
        if count == 1:
            return (self,)
        if len(self._steps) != count:
            steps = handle_paths.steps(self.handles, count)
            freeze(self, _steps=tuple(replace(self, handles=step) for step in steps))
        return self._steps

    @functools.cached_property
    def affine(self) -> tuple[np.ndarray, np.ndarray]:
        """The best fitting affine map from deformed to rest positions: (3, 3) and (3,)."""
        rest, deformed = self.handles.positions
        return fitted_affine(deformed, rest)

    def local(self, points) -> np.ndarray:
        """World coordinates `points` (m, 3) in the local frame."""
        return (points - self.center) / self.scale


def _merged(handles):
    """The weighted means of points with equal q, or of all if their displacement is common."""
    segments = handles.segments
    of_segments = (segments.rest - segments.deformed).reshape(-1, 3)
    displacement = np.concatenate([handles.rest - handles.deformed, of_segments])
    if handles.path.shape[1] == 0 and (displacement == displacement[0]).all():
        return _translation(handles, displacement[0])
    # proxies of a region stay together, and come first
    key = np.where(handles.region < 0, len(handles.regions), handles.region)
    rows, group = np.unique(np.column_stack([key, handles.deformed]), axis=0, return_inverse=True)
    group = group.ravel()
    if len(rows) == len(handles):
        return handles
    weights = handles.weights
    total = np.bincount(group, weights)
    offset = handles.rest - handles.rest[0]  # keeps the digits of large coordinates
    sums = np.stack([np.bincount(group, weights * c) for c in offset.T], axis=1)
    rest = handles.rest[0] + sums / total[:, None]
    key = rows[:, 0].astype(int)
    region = np.where(key == len(handles.regions), -1, key)
    path = np.zeros((len(rows), *handles.path.shape[1:]))
    np.add.at(path, group, weights[:, None, None] * handles.path)
    path /= total[:, None, None]
    return HandleSet(rest, rows[:, 1:], total, region, handles.regions, handles.segments, path)


def _translation(handles, displacement):
    """One point with a `displacement` (3,), exactly as given."""
    if len(handles) > 0:
        weights, first = handles.weights, handles.deformed[0]
        at = first + (weights @ (handles.deformed - first) / weights.sum())[None]
    else:
        at = handles.positions[1].mean(axis=0, keepdims=True)
    total = np.array([handles.weights.sum() + handles.segments.weights.sum()])
    none = Segments.of([])
    path = np.zeros((1, 0, 3))
    return HandleSet(at + displacement, at, total, np.array([-1]), (), none, path)
