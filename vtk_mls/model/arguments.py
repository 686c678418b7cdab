"""Validation of the arguments of a deformation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import as_float, points, short_repr
from vtk_mls.model.handles.region import RegionHandle

# Largest coordinate of control points, world units: displacements are float32, up to 3.4e38.
MAX_COORDINATE = 1e37
# Largest distance of cuts, in units of the control points' extent: the kernels square it.
MAX_CUT_DISTANCE = 1e10


def control_points(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """As `points`, with coordinates up to `MAX_COORDINATE`."""
    array = points(name, value)
    is_far = np.abs(array).max(axis=1, initial=0) > MAX_COORDINATE
    if is_far.any():
        row = int(np.flatnonzero(is_far)[0])
        raise InputError(
            f"must be within {MAX_COORDINATE:g}, the range of float32 displacements, "
            f"got {array[row].tolist()} in row {row}",
            argument=name,
        )
    return array


def path(value: ArrayLike | None, count: int, name: str = "path") -> NDArray[np.float64]:
    """Intermediate places (k, count, 3) of the control points; none for None."""
    if value is None or np.size(value) == 0:
        return np.zeros((0, count, 3))
    places = as_float(name, value, "numbers of shape (k, n, 3)")
    if places.ndim != 3 or places.shape[1:] != (count, 3) or not np.isfinite(places).all():
        raise InputError(
            f"must be finite numbers of shape (k, {count}, 3), places of each control "
            f"point, got {short_repr(value)}",
            argument=name,
        )
    return places


def positive_weights(value: ArrayLike | None, count: int) -> NDArray[np.float64]:
    """A positive factor for each of `count` control points; 1 for None."""
    if value is None:
        return np.ones(count)
    weights = as_float("weights", value)
    if weights.shape != (count,):
        raise InputError(
            f"must be one number per control point, shape ({count},), got {weights.shape}",
            argument="weights",
        )
    is_bad = ~(np.isfinite(weights) & (weights > 0))
    if is_bad.any():
        first = int(np.flatnonzero(is_bad)[0])
        raise InputError(
            f"must be positive, got {weights[first]} for control point {first}", argument="weights"
        )
    return weights


def has_regions(handles):
    """Whether there are rigid regions among handles."""
    return any(isinstance(handle, RegionHandle) for handle in handles)


def check_cut_distances(cuts, regions):
    """Raise ValueError for a cut too far from the control points for the kernels' float32."""
    for control_points in (region.control_points for region in regions):
        for cut in cuts:
            if not cut.farthest(control_points) <= MAX_CUT_DISTANCE:
                raise InputError(
                    f"must be within {MAX_CUT_DISTANCE:g} times the extent of the control "
                    f"points, {control_points.scale:g}, got {short_repr(cut)}",
                    argument="cuts",
                )
