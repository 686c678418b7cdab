"""The time axis of NRRD files.

An axis is time if its kind says so; or if it is the last of four that have a spacing each, or are
directions in a space of four dimensions, and no kind says another thing (ITK and pynrrd write
these).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from vtk_mls.files.units import in_seconds

_IN_TIME = ("domain", "space", "time", "???", "none")


@dataclass(frozen=True)
class TimeAxis:
    """The time axis of a file: its `index`, fastest axis first, `times`, and their `unit` as of
    `volumes.Volume`.
    """

    index: int
    times: tuple
    unit: str


def without_time(fields, sizes):
    """The time axis or None; and the fields of a header (a dict) and the sizes of one volume,
    unchanged without a time axis.
    """
    count = len(sizes)
    kinds = fields.get("kinds", "??? " * count).lower().split()
    vectors = re.findall(r"none|\([^)]*\)", fields.get("space directions", ""))
    numbers = [_numbers(vector) for vector in vectors]
    in_spacetime = [i for i, vector in enumerate(numbers) if len(vector) == 4]
    is_spacetime = len(vectors) == count and len(in_spacetime) == 4
    spacings = _numbers(fields.get("spacings", ""))
    has_spacings = count == len(spacings) == 4 and np.isfinite(spacings).all() and not vectors
    index = None
    if "time" in kinds:
        index = kinds.index("time")
    elif is_spacetime:
        index = in_spacetime[-1]
    elif has_spacings and {*kinds} <= {*_IN_TIME}:
        index = 3
    if index is None or len(kinds) != count:
        return None, fields, sizes
    start, step = 0.0, spacings[index] if len(spacings) == count else 1.0
    rest = dict(fields)
    if is_spacetime:
        matrix, row = np.array([numbers[i] for i in in_spacetime]), in_spacetime.index(index)
        if matrix[row, :3].any() or np.delete(matrix[:, 3], row).any():
            raise ValueError("its axis of time must not be turned into space")
        step, origin = numbers[index][3], _numbers(fields.get("space origin", ""))
        start = origin[3] if len(origin) == 4 else 0.0
        vectors = [
            f"({','.join(map(repr, vector[:3]))})" if vector else "none" for vector in numbers
        ]
        rest["space origin"] = f"({','.join(map(repr, [*origin, 0.0, 0.0, 0.0][:3]))})"
        rest.pop("space dimension", None)
    elif len(_numbers(fields.get("axis mins", ""))) == count:
        start = _numbers(fields["axis mins"])[index]
    if len(vectors) == count:
        rest["space directions"] = " ".join(np.delete(vectors, index))
    _drop_words(rest, fields, index, count, bool(vectors))
    rest["dimension"] = str(count - 1)
    (start, step), unit = in_seconds(_unit(rest, fields, index, count), start, step)
    times = _times(start, step, sizes[index])
    return TimeAxis(index, times, unit), rest, [*sizes[:index], *sizes[index + 1 :]]


def _drop_words(rest, fields, index, count, has_directions):
    """Leave an axis out of the fields with a word for each of `count` axes."""
    for name in ("kinds", "spacings", "axis mins", "axis maxs", "centers"):
        words = fields.get(name, "").split()
        if len(words) == count and not (name == "spacings" and has_directions):
            rest[name] = " ".join(np.delete(words, index))


def _times(start, step, count):
    """Equal steps; a start that is not said is 0, a step that is not said 1."""
    start = start if np.isfinite(start) else 0.0
    step = step if np.isfinite(step) else 1.0
    return tuple(float(start + step * index) for index in range(count))


def _unit(rest, fields, index, count):
    """The unit of time, which becomes the last of four `space units`."""
    units = re.findall(r'"[^"]*"', rest.pop("units", ""))
    spatial = re.findall(r'"[^"]*"', fields.get("space units", ""))
    if len(spatial) != 4 and len(units) == count:
        if len(spatial) != 3:
            lengths = [unit for unit in np.delete(units, index) if unit != '""']
            spatial = lengths if len(lengths) == 3 else ['""'] * 3
        spatial = [*spatial, units[index]]
        rest["space units"] = " ".join(spatial)
    return spatial[3].strip('"') if len(spatial) == 4 else ""


def _numbers(text):
    return [float(word) for word in re.findall(r"[^\s,()]+", text) if word != "none"]
