"""Validation of the arguments of a deformation.

Errors are one sentence with the argument, what was expected, and what came.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls import cuts as shapes
from vtk_mls.base.validation import as_float, points, short_repr

# Coordinates of control points, in world units: float32 ends at 3.4e38.
LARGEST = 1e37
# Distances of cuts, as a share of the extent of control points.
FARTHEST = 1e10


def control_points(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """As `points`, but within what float32 holds: displacements are float32."""
    array = points(name, value)
    far = np.abs(array).max(axis=1, initial=0) > LARGEST
    if far.any():
        row = int(np.flatnonzero(far)[0])
        raise ValueError(
            f"`{name}` must be within {LARGEST:g}, for displacements are float32, "
            f"got {array[row].tolist()} in row {row}"
        )
    return array


def positive_weights(value, count):
    """A positive factor for each of `count` control points; 1 without."""
    if value is None:
        return np.ones(count)
    weights = as_float("weights", value)
    if weights.shape != (count,):
        raise ValueError(
            f"`weights` must be one number per control point, shape ({count},), got {weights.shape}"
        )
    bad = ~(np.isfinite(weights) & (weights > 0))
    if bad.any():
        first = int(np.flatnonzero(bad)[0])
        raise ValueError(
            f"`weights` must be positive, got {weights[first]} for control point {first}"
        )
    return weights


def cut_shapes(value):
    """A tuple of cuts, of one or several; none for None."""
    if value is None:
        return ()
    is_one = isinstance(value, shapes.Cut) or not isinstance(value, Iterable)
    cuts = (value,) if is_one else tuple(value)
    for cut in cuts:
        if not isinstance(cut, shapes.Cut):
            *most, last = shapes.SHAPES
            names = f"{', '.join(most)} or {last}"
            raise TypeError(f"`cuts` must be {names}, got {short_repr(cut)}")
    return cuts


def check_reach(cuts, regions):
    """Raise if a cut is so far from control points that squares in the kernels' float32 end."""
    for control_points in (region.control_points for region in regions):
        for cut in cuts:
            if not cut.farthest(control_points) <= FARTHEST:
                raise ValueError(
                    f"`cuts` must be within {FARTHEST:g} times the extent of the control points, "
                    f"{control_points.scale:g}, got {short_repr(cut)}"
                )
