"""Points in text files of elastix and of IDAV Landmark.

elastix. The input (`-def`) of transformix has a line `point`, a line with the number of points, and
a line x y z for each. Files with the first line `index` have voxel indices, which are no positions
without the image. The output, outputpoints.txt, has lines `Point N ; InputIndex = [..] ; InputPoint
= [..] ; ... ; OutputPoint = [x y z] ; ...`. OutputPoint is read, with N as the label. transformix
maps the fixed to the moving image: OutputPoint is the position in the moving image whose material
comes to InputPoint.

IDAV Landmark, .pts. A line `Version 1.0`, the number of points, and lines `label x y z`. Missing
points are at 9999, 9999, 9999, as the R packages for such files have it.
"""

import re
from functools import partial

import numpy as np

from vtk_mls.base.errors import InputError
from vtk_mls.files.landmarks import Landmarks, finite, numbers, shortened

_RESULT = re.compile(r"Point\s+(\d+)\s*;")
_POSITION = re.compile(r"\bOutputPoint\s*=\s*\[([^\]]*)\]")
_VERSION = re.compile(r"version\s+\d+(\.\d+)?", re.IGNORECASE)
_MISSING = [9999.0] * 3


def reader(line):
    """The function that reads a file with this first line; None for other files."""
    if line.strip().lower() in ("point", "index"):
        return partial(_read_list, has_labels=False)
    if _VERSION.fullmatch(line.strip()):
        return partial(_read_list, has_labels=True)
    return _read_results if _RESULT.match(line) else None


def write(file, landmarks):
    """Write points as an input of transformix."""
    positions = landmarks.positions[landmarks.is_placed].tolist()
    file.write(f"point\n{len(positions)}\n")
    file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in positions)


def _read_list(path, has_labels):
    """The points of a file with their number in its second line."""
    lines = list(_numbered_lines(path))
    if lines[0][1].lower() == "index":
        raise InputError("holds indices of voxels; expected positions, after a first line `point`")
    number, count = lines[1] if len(lines) > 1 else (2, "")
    if not re.fullmatch(r"\d{1,18}", count):
        text = shortened(count)
        raise InputError(f", line {number}: expected the number of points, got {text}")
    if len(lines) - 2 != int(count):
        raise InputError(f"must hold {int(count)} points, as it says, got {len(lines) - 2}")
    labels, positions = [], []
    for number, line in lines[2:]:
        label, *cells = line.rsplit(maxsplit=3) if has_labels else ("", *line.split())
        position = _position(number, cells, "a label and " * has_labels, line)
        labels.append(label)
        positions.append(3 * [np.nan] if has_labels and position == _MISSING else position)
    return Landmarks(path, np.reshape(positions, (-1, 3)), labels=labels)


def _read_results(path):
    """The points of an output of transformix."""
    positions, labels = [], []
    for number, line in _numbered_lines(path):
        label, position = _RESULT.match(line), _POSITION.search(line)
        if label is None or position is None:
            expected = "`Point N ; ... OutputPoint = [x y z]`"
            raise InputError(f", line {number}: expected {expected}, got {shortened(line)}")
        labels.append(label[1])
        positions.append(_position(number, position[1].split(), "", position[1]))
    return Landmarks(path, np.reshape(positions, (-1, 3)), labels=labels)


def _numbered_lines(path):
    """(number, stripped text) of each line that is not blank."""
    with path.open(encoding="utf-8-sig") as file:
        yield from ((number, line.strip()) for number, line in enumerate(file, 1) if line.strip())


def _position(number, cells, more, line):
    position = numbers(cells)
    if len(position) != 3:
        text = shortened(line)
        raise InputError(f", line {number}: expected {more}three numbers, got {text}")
    return finite(f"line {number}", position)
