"""What arguments of a deformation must be.

Errors are one sentence with the argument, what was expected, and what came.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls import cuts as shapes
from vtk_mls.grid import Grid
from vtk_mls.reals import real, shown

# Coordinates of control points, in world units: float32 ends at 3.4e38.
LARGEST = 1e37
# Distances of cuts, as a share of the extent of control points.
FARTHEST = 1e10


def coordinates(value: ArrayLike, name: str = "points") -> NDArray[Any]:
    """Rows of three numbers (n, 3), float32 or float64; they need not be finite."""
    array = value
    if not isinstance(value, np.ndarray) or value.dtype != np.float32:
        array = real(name, value, "numbers of shape (n, 3)")
    if array.size == 0 and array.ndim <= 2:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"`{name}` must have the shape (n, 3), got {array.shape}")
    return np.ascontiguousarray(array)


def points(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Rows of three finite numbers (n, 3), float64; a copy."""
    array = coordinates(value, name).astype(np.float64)
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise ValueError(f"`{name}` must be finite, got {array[bad].tolist()} in row {bad}")
    return array


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
    weights = real("weights", value)
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
            raise TypeError(f"`cuts` must be {names}, got {shown(cut)}")
    return cuts


def single(name, value):
    """Real numbers of any shape, float32."""
    if isinstance(value, np.ndarray) and value.dtype == np.float32:
        return value
    return real(name, value).astype(np.float32)


def plain(array):
    """An array, contiguous, in the byte order of this machine, which arrays of files may lack."""
    array = array.view(np.uint8) if array.dtype == bool else array
    return np.ascontiguousarray(array, array.dtype.newbyteorder("="))


def check_reach(cuts, regions):
    """Raise if a cut is so far from control points that squares in the kernels' float32 end."""
    for control_points in (region.control_points for region in regions):
        for cut in cuts:
            if not cut.farthest(control_points) <= FARTHEST:
                raise ValueError(
                    f"`cuts` must be within {FARTHEST:g} times the extent of the control points, "
                    f"{control_points.scale:g}, got {shown(cut)}"
                )


def number(name, value):
    """A float."""
    array = real(name, value, "a number")
    if array.ndim:
        raise TypeError(f"`{name}` must be a number, got {shown(value)}")
    return float(array)


def choice(name, value, choices):
    """One of `choices`, strings or numbers."""
    if not np.isscalar(value) or value not in choices:
        listed = ", ".join(map(str, choices))
        raise ValueError(f"`{name}` must be one of {listed}, got {shown(value)}")
    return value


def grid(name, value):
    """A `Grid`."""
    if not isinstance(value, Grid):
        raise TypeError(f"`{name}` must be a Grid, got {shown(value)}")
    return value


def output(name, value, shape, dtype):
    """A contiguous array that is to be filled."""
    fits = isinstance(value, np.ndarray) and (value.shape, value.dtype) == (shape, dtype)
    if not (fits and value.flags.c_contiguous and value.flags.writeable):
        raise ValueError(
            f"`{name}` must be a writeable, contiguous array of {np.dtype(dtype)} with the shape "
            f"{shape}, got {shown(value)}"
        )
