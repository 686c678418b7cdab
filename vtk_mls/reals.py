"""Numbers that come from outside, as float64; and what came, in few words."""

from __future__ import annotations

import numpy as np

_LONG = 60


def real(name, value, expected="numbers"):
    """A float64 copy of `value`, of any shape.

    Raises
    ------
    TypeError
        If it is not made of real numbers, or of such as no float holds; naming it `name`.
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind != "c":
            return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        pass
    raise TypeError(f"`{name}` must be {expected}, got {shown(value)}")


def shown(value):
    """What `value` is, on one short line."""
    if isinstance(value, np.ndarray) and value.size > 4:
        return f"an array of shape {value.shape} of {value.dtype}"
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # Python writes no integers of thousands of digits
        text = f"an {type(value).__name__}"
    return text if len(text) <= _LONG else f"{text[: _LONG - 3]}..."
