"""Control points and landmarks in text files.

Markups of 3D Slicer (.mrk.json, .fcsv) are described in `markups`, tag points of MINC (.tag) in
`point_lists`. The first line that is not blank tells what other files (.csv, .txt, .pts) are: files
of elastix begin with `point`, `index`, or `Point`, a number and a semicolon; files of IDAV Landmark
begin with `Version 1.0` (`point_lists`). All others are tables (`point_tables`) of control points,
or of landmarks as in plain text, ITK, ANTs, BigWarp or 3D Slicer.

A file of positions alone gives control points at rest (q = p); a second file of positions gives q.
All coordinates are returned in LPS (see `frames`). The caller can name the frame of files that do
not say theirs; otherwise it is LPS.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np

from vtk_mls.base.errors import InputError, of_file
from vtk_mls.files import formats, markups, point_lists, point_tables
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, Pairs, paired
from vtk_mls.files.paths import check_replaceable, existing_file, replacing

_READ, _WRITE = {"reads": (formats.POINTS,)}, {"writes": (formats.POINTS,)}


def read_pairs(path, deformed_path=None, space="LPS", time=None):
    """The `Pairs` of control points in LPS, as of `io.read_control_points`.

    `path` and `deformed_path` are of a format of `formats.POINTS`; `time` is as of
    `read_landmarks`.
    """
    rest = read_landmarks(path, space, not deformed_path, time)
    deformed = read_landmarks(deformed_path, space, time=time) if deformed_path else None
    return paired(rest, deformed)


def times(path, deformed_path=None):
    """The times at which control points of one or two files are given, sorted; () for others."""
    paths = [existing_file(name) for name in (path, deformed_path) if name]
    tables = [path for path in paths if formats.find(path, **_READ) and _is_table(path)]
    return tuple(sorted({time for table in tables for time in point_tables.times(table)}))


def _is_table(path):
    try:
        return _reader(path) is point_tables.read
    except UnicodeDecodeError:
        return False  # reading says so


def read_landmarks(
    path: str | PathLike[str], space: str = "LPS", is_alone: bool = False, time: float | None = None
) -> Landmarks:
    """The `Landmarks` of a file of `formats.POINTS` in LPS, as of `io.read_landmarks`."""
    path = existing_file(path)
    with of_file(path):
        read_file = _reader(path)
        options = (is_alone, time) if read_file is point_tables.read else ()
        landmarks: Landmarks = read_file(path, *options)
        if len(landmarks.positions) == 0:
            raise InputError("holds no control points")
    return landmarks.in_lps(space)


def write(path, rest, deformed, weights=None, labels=()):
    """Write control points, p and q (n, 3) in LPS.

    `path` is of a format of `formats.POINTS`. Tables (.csv, .txt) hold everything, tag points
    (.tag) all but weights, the others q only. Errors (OSError, ValueError) name the file.
    """
    path = Path(path)
    line = formats.choose(path, "write control points to", **_WRITE)
    as_pairs = formats.find(path, writes=(formats.PAIRS,))
    rest, deformed = np.asarray(rest, float), np.asarray(deformed, float)
    points = Landmarks(path, deformed, "LPS", labels)
    with _new_text_file(path) as file:
        if as_pairs:
            as_pairs.write(file, Pairs(rest, deformed, weights, points.labels))
        else:
            line.write(file, points)


def check_writable(path: str | PathLike[str]) -> Path:
    """`path` as a Path, if landmarks can be written to it."""
    path = Path(path)
    formats.choose(path, "write points to", **_WRITE)
    check_replaceable(path)
    return path


def write_landmarks(path, points, source=None, space="LPS"):
    """Write `Landmarks` in LPS; how many points are left out.

    `path` is of a format of `formats.POINTS`. Points that are not placed are marked, or left out if
    the format has no mark. From .mrk.json, the file `source` of the points, to .mrk.json all other
    contents are copied. A table of positions alone stays one. Otherwise the new file is a table of
    ITK and ANTs (.csv), an input of transformix (.txt, .pts), tag points of one volume (.tag) or
    markups, with labels and descriptions if the format has them. `space` is the frame of files that
    do not say theirs. Errors (OSError, ValueError) name the file.
    """
    path = check_writable(path)
    line = formats.choose(path, "write points to", **_WRITE)
    source = source and Path(source)
    old = source and formats.find(source, **_READ)
    is_json = line.read is markups.read_json
    with _new_text_file(path) as file, of_file(source):
        if is_json and old and old.read is markups.read_json:
            markups.rewrite_json(source, file, points.positions)
        elif line.frame != formats.CALLER:
            line.write(file, points)
        else:
            points = replace(points, positions=points.positions * signs(space))
            is_table = old and path.suffix == source.suffix and _is_table(source)
            if is_table and point_tables.has_positions_alone(source):
                point_tables.write(file, points, are_alone=True)
            else:
                line.write(file, points)
    return 0 if is_json else int((~points.is_placed).sum())


def read_text(path):
    """The points of a file whose first line says its format."""
    return _reader(path)(path)


def _reader(path):
    """The function that reads a file, by its name or its first line."""
    read_file = formats.choose(path, "read points from", **_READ).read
    if read_file is not read_text:
        return read_file
    with path.open(encoding="utf-8-sig") as file:
        first = next((line for line in file if line.strip()), "")
    return point_lists.reader(first) or point_tables.read


@contextmanager
def _new_text_file(path):
    with replacing(path) as new, new.open("w", newline="", encoding="utf-8") as file:
        yield file
