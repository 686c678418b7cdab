"""Points of IDAV Landmark, .pts: a line `Version 1.0`, their number, and lines `label x y z`.

Missing points are at 9999, 9999, 9999, as the R packages for such files have it.
"""

from __future__ import annotations

import re

import numpy as np

from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, counted_lines, numbered_lines, shortened
from vtk_mls.files.point_tables import numbers

_VERSION = re.compile(r"version\s+\d+(\.\d+)?", re.IGNORECASE)
_MISSING = [9999.0] * 3


def reader(line):
    """The function that reads a file with this first line; None for other files."""
    return read if _VERSION.fullmatch(line.strip()) else None


def read(path):
    """The points of a file."""
    _, rows = _parsed(path)
    places = [3 * [np.nan] if place == _MISSING else place for _, place in rows]
    return Landmarks(path, np.reshape(places, (-1, 3)), labels=[label for label, _ in rows])


def rewrite(path, file, positions, space):
    """Write a file again, with other positions; those at NaN are marked as missing."""
    version, rows = _parsed(path)
    positions = positions * signs(space)
    file.write(f"{version}\n{len(rows)}\n")
    for (label, _), position in zip(rows, positions.tolist()):
        place = position if np.isfinite(position).all() else [9999] * 3
        file.write(" ".join([label, *map(repr, place)]) + "\n")
    return 0


def _parsed(path):
    """The first line, and (label, [x, y, z]) of each point."""
    lines = numbered_lines(path)
    _, version = next(lines)
    rows = []
    for number, line in counted_lines(path, lines):
        label, *cells = line.rsplit(maxsplit=3)
        place = numbers(cells)
        if len(place) != 3 or not np.isfinite(place).all():
            raise ValueError(
                f"`{path}`, line {number}: expected a label and three numbers, got "
                + shortened(line)
            )
        rows.append((label, place))
    return version, rows
