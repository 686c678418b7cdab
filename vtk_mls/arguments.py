"""What arguments of a deformation must be.

Errors are one sentence with the argument, what was expected, and what came.
"""

from __future__ import annotations

import numpy as np

from vtk_mls.cuts import HalfPlane, Plane, Surface

# What the void that a cut opens can hold: nothing, or material as if each side went on.
VOID_VALUES = ("background", "continued")
# Coordinates of control points, in world units: float32 ends at 3.4e38.
LARGEST = 1e37
# Distances of cuts, as a share of the extent of control points.
FARTHEST = 1e10


def places(value, name="points"):
    """Rows of three numbers (n, 3), float32 or float64; they need not be finite."""
    array = np.asarray(value)
    if array.dtype != np.float32:
        try:
            array = array.astype(np.float64)
        except (TypeError, ValueError):
            raise TypeError(
                f"`{name}` must be numbers of shape (n, 3), got {value!r:.60}"
            ) from None
    if array.size == 0 and array.ndim <= 2:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"`{name}` must have the shape (n, 3), got {array.shape}")
    return np.ascontiguousarray(array)


def points(name, value):
    """Rows of three finite numbers (n, 3), float64; a copy."""
    array = places(value, name).astype(np.float64)
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise ValueError(f"`{name}` must be finite, got {array[bad].tolist()} in row {bad}")
    return array


def control_points(name, value):
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
    try:
        weights = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"`weights` must be numbers, got {value!r:.60}") from None
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
    """A tuple of cuts, of one or several."""
    cuts = (value,) if isinstance(value, (Plane, HalfPlane, Surface)) else tuple(value)
    for cut in cuts:
        if not isinstance(cut, (Plane, HalfPlane, Surface)):
            raise TypeError(f"`cuts` must be Plane, HalfPlane or Surface, got {cut!r:.60}")
    return cuts


def check_reach(cuts, regions):
    """Raise if a cut is so far from control points that squares in the kernels' float32 end."""
    for handles in (region.handles for region in regions):
        for cut in cuts:
            if isinstance(cut, Plane):
                distance = abs(cut.height(handles.centre)) / handles.scale
            else:
                places = cut.points if isinstance(cut, Surface) else cut.point
                distance = np.abs(handles.local(places)).max()
            if not distance <= FARTHEST:
                raise ValueError(
                    f"`cuts` must be within {FARTHEST:g} times the extent of the control points, "
                    f"{handles.scale:g}, got {cut!r:.200}"
                )


def number(name, value):
    """A float."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"`{name}` must be a number, got {value!r}") from None


def continues(void_values):
    """Whether `void_values` asks for values that go on in the void."""
    if void_values not in VOID_VALUES:
        raise ValueError(
            f"`void_values` must be one of {', '.join(VOID_VALUES)}, got {void_values!r}"
        )
    return void_values == "continued"
