"""Points in text files of elastix: the input (`-def`) and the output of transformix.

The input has a line `point`, a line with the number of points, and a line x y z for each. Files
with the first line `index` have voxel indices, which are no positions without the image.

The output, outputpoints.txt, has lines `Point N ; InputIndex = [..] ; InputPoint = [..] ; ... ;
OutputPoint = [x y z] ; ...`. OutputPoint is read, with N as the label. transformix maps the fixed
to the moving image: OutputPoint is the position in the moving image whose material comes to
InputPoint.
"""

from __future__ import annotations

import re

import numpy as np

from vtk_mls.files.landmarks import Landmarks, counted_lines, numbered_lines, shortened

_RESULT = re.compile(r"Point\s+(\d+)\s*;")
_POSITION = re.compile(r"\bOutputPoint\s*=\s*\[([^\]]*)\]")


def reader(line):
    """The function that reads a file with this first line; None for other files."""
    if line.strip().lower() in ("point", "index"):
        return read_points
    return read_results if _RESULT.match(line) else None


def read_points(path):
    """The points of an input of transformix."""
    lines = numbered_lines(path)
    if next(lines)[1].lower() == "index":
        raise ValueError(
            f"`{path}` holds indices of voxels; expected positions, after a first line `point`"
        )
    positions = [_position(path, *line) for line in counted_lines(path, lines)]
    return Landmarks(path, np.reshape(positions, (-1, 3)))


def read_results(path):
    """The points of an output of transformix."""
    positions, labels = [], []
    for number, line in numbered_lines(path):
        label, position = _RESULT.match(line), _POSITION.search(line)
        if label is None or position is None:
            raise ValueError(
                f"`{path}`, line {number}: expected `Point N ; ... OutputPoint = [x y z]`, got "
                + shortened(line)
            )
        labels.append(label[1])
        positions.append(_position(path, number, position[1]))
    return Landmarks(path, np.reshape(positions, (-1, 3)), labels=labels)


def write(file, landmarks):
    """Write points as an input of transformix, without those that are not placed."""
    positions = landmarks.positions[landmarks.is_placed].tolist()
    file.write(f"point\n{len(positions)}\n")
    file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in positions)
    return len(landmarks.positions) - len(positions)


def _position(path, number, text):
    try:
        x, y, z = map(float, text.split())
    except ValueError:
        raise ValueError(
            f"`{path}`, line {number}: expected three numbers, got {shortened(text)}"
        ) from None
    if not np.isfinite([x, y, z]).all():
        raise ValueError(f"`{path}` has a coordinate that is not a finite number in line {number}")
    return x, y, z
