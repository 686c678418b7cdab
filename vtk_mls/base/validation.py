"""Validation of arguments.

Errors are one sentence with the argument, the expected value, and the given value.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError

_MAX_REPR_LENGTH = 60


def check_unmasked(name, value):
    """Raise ValueError, naming it `name`, if values of a numpy or dask array are masked."""
    is_lazy = np.ma.isMaskedArray(getattr(value, "_meta", None))  # whose masks are not known
    if is_lazy or np.ma.is_masked(value):
        raise InputError(
            f"must have no masked values, got a masked array; fill it first, as by "
            f"`{'dask.array' if is_lazy else 'numpy'}.ma.filled`",
            argument=name,
        )


def as_float(name, value, expected="numbers"):
    """A float64 copy of `value`, of any shape.

    TypeError or ValueError, naming it `name`, if it is not made of real numbers within the range of
    floats, or if values are masked.
    """
    check_unmasked(name, value)
    try:
        array = np.asarray(value)
        if array.dtype.kind != "c" and value is not None:  # numpy makes NaN of None
            return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        pass
    raise TypeError(f"`{name}` must be {expected}, got {short_repr(value)}")


def short_repr(value):
    """`value` on one short line, for errors."""
    if isinstance(value, np.ndarray) and value.size > 4:
        return f"an array of shape {value.shape} of {value.dtype}"
    if isinstance(value, np.generic):  # as Python writes it
        value = value.item()
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # an integer of thousands of digits
        text = f"an {type(value).__name__}"
    return text if len(text) <= _MAX_REPR_LENGTH else f"{text[: _MAX_REPR_LENGTH - 3]}..."


def freeze(instance, **attributes):
    """Set attributes of a frozen dataclass, in its `__init__`; arrays become read-only."""
    for value in attributes.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    vars(instance).update(attributes)


def coordinates(value: ArrayLike, name: str = "points") -> NDArray[Any]:
    """Rows of three numbers (n, 3), float32 or float64; they need not be finite."""
    array = value
    if not isinstance(value, np.ndarray) or value.dtype != np.float32:
        array = as_float(name, value, "numbers of shape (n, 3)")
    if array.size == 0 and array.ndim <= 2:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"must have the shape (n, 3), got {array.shape}", argument=name)
    return np.ascontiguousarray(array)


def points(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Rows of three finite numbers (n, 3), float64; a copy."""
    array = coordinates(value, name).astype(np.float64)
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise InputError(f"must be finite, got {array[row].tolist()} in row {row}", argument=name)
    return array


def corners(name: str, value: ArrayLike, size: int, count: int) -> NDArray[np.int64]:
    """Corners (m, size) of triangles or tetrahedra, as rows of `count` points; m > 0."""
    values = as_float(name, value)
    rows = np.where(np.isfinite(values), values, -1).astype(np.int64)
    if (rows != values).any():
        raise TypeError(f"`{name}` must be integers, rows of `points`")
    if rows.ndim != 2 or rows.shape[1:] != (size,) or len(rows) == 0:
        raise InputError(f"must have the shape (m, {size}), m > 0, got {rows.shape}", argument=name)
    if rows.min() < 0 or rows.max() >= count:
        message = f"must be rows of the {count} `points`, got {rows.min()} to {rows.max()}"
        raise InputError(message, argument=name)
    return rows


def same_count(p, q, elements="points"):
    """Raise unless `rest` and `deformed` have as many rows."""
    if len(p) != len(q):
        raise InputError(
            f"must have the same number of {elements}, got {len(p)} and {len(q)}",
            argument=("rest", "deformed"),
        )


def single_precision(name, value):
    """Real numbers of any shape, float32."""
    if isinstance(value, np.ndarray) and value.dtype == np.float32:
        return value
    return as_float(name, value).astype(np.float32)


def native_array(array):
    """A contiguous array in the byte order of this machine; uint8 for bool."""
    array = array.view(np.uint8) if array.dtype == bool else array
    return np.ascontiguousarray(array, array.dtype.newbyteorder("="))


def number(name, value):
    array = as_float(name, value, "a number")
    if array.ndim:
        raise TypeError(f"`{name}` must be a number, got {short_repr(value)}")
    return float(array)


def vector(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """An argument of three finite numbers."""
    return finite(name, value, (3,), "three")


def finite(name: str, value: ArrayLike, shape: Any, count: str = "") -> NDArray[np.float64]:
    """Finite numbers of a shape, which an error calls `count` numbers."""
    array = as_float(name, value, f"{count} numbers".strip())
    if array.shape != shape or not np.isfinite(array).all():
        text = f"must be {count or shape} finite numbers, got {short_repr(value)}"
        raise InputError(text, argument=name)
    return array


def positive(name: str, value: Any) -> float:
    array = as_float(name, value, "a number")
    if array.ndim or not (np.isfinite(array) and array > 0):
        raise InputError(f"must be a positive number, got {short_repr(value)}", argument=name)
    return float(array)


def choice(name, value, choices):
    """One of `choices`, strings or numbers."""
    if not np.isscalar(value) or value not in choices:
        listed = ", ".join(map(str, choices))
        raise InputError(f"must be one of {listed}, got {short_repr(value)}", argument=name)
    return value


def values_of(name: str, value: Any, kind: Any) -> tuple[Any, ...]:
    """A tuple of values of a class, from one value, several or None."""
    if value is None:
        return ()
    is_single = isinstance(value, kind) or not isinstance(value, Iterable)
    values = (value,) if is_single else tuple(value)
    for item in values:
        if not isinstance(item, kind):
            raise TypeError(f"`{name}` must be {kind.expected()}, got {short_repr(item)}")
    return values


def output_array(name, value, shape, dtype):
    """Check a contiguous array that is to be filled."""
    fits = isinstance(value, np.ndarray) and (value.shape, value.dtype) == (shape, dtype)
    if not (fits and value.flags.c_contiguous and value.flags.writeable):
        raise InputError(
            f"must be a writeable, contiguous array of {np.dtype(dtype)} with the shape "
            f"{shape}, got {short_repr(value)}",
            argument=name,
        )
