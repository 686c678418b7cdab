"""Points of IDAV Landmark, .pts: a line `Version 1.0`, their number, and lines `label x y z`.

Missing points are at 9999, 9999, 9999, as the R packages for such files have it.
"""

from __future__ import annotations

import re

import numpy as np

from vtk_mls.files.landmarks import Landmarks, counted_lines, numbered_lines, shortened
from vtk_mls.files.point_tables import numbers

_VERSION = re.compile(r"version\s+\d+(\.\d+)?", re.IGNORECASE)
_MISSING = [9999.0] * 3


def reader(line):
    """The function that reads a file with this first line; None for other files."""
    return read if _VERSION.fullmatch(line.strip()) else None


def read(path):
    """The points of a file."""
    lines = numbered_lines(path)
    next(lines)  # the version
    labels, places = [], []
    for number, line in counted_lines(path, lines):
        label, *cells = line.rsplit(maxsplit=3)
        place = numbers(cells)
        if len(place) != 3 or not np.isfinite(place).all():
            raise ValueError(
                f"`{path}`, line {number}: expected a label and three numbers, got "
                + shortened(line)
            )
        labels.append(label)
        places.append(3 * [np.nan] if place == _MISSING else place)
    return Landmarks(path, np.reshape(places, (-1, 3)), labels=labels)
