"""Control points and landmarks in files of text.

What a file is, its name and its content say. Markups of 3D Slicer (.mrk.json, .fcsv) are described
in `markups`. Other text (.csv, .txt, .pts) is what its first line with something in it says: one of
elastix if that is the word `point` or `index`, or begins with `Point` and a number and a semicolon
(`elastix_points`); else a table (`point_tables`), which can be of control points, or of landmarks
as plain text, ITK, ANTs, BigWarp or 3D Slicer have them.

Files that hold positions only give control points that rest there (q = p), or, as a second file,
the positions that control points are moved to. All coordinates are handed on in LPS (see `frames`),
and those of a file that does not say its frame count as LPS unless the caller knows better.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np

from vtk_mls.files import elastix_points, formats, markups, point_tables
from vtk_mls.files.existing import existing_file
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, Pairs, paired
from vtk_mls.files.replacing import check_replaceable, replacing

_READ, _WRITE = {"reads": (formats.POINTS,)}, {"writes": (formats.POINTS,)}


def read(path, deformed_path=None, space="LPS"):
    """Read control points.

    Parameters
    ----------
    path : path
        Of a format of `formats.POINTS`.
    deformed_path : path, optional
        Another file, whose positions are q: how they find their p is said in `landmarks.paired`.
    space : str
        The frame of files that do not say theirs, as of `frames.signs`.

    Returns
    -------
    rest, deformed : (n, 3) float64, LPS
        p and q.
    weights : (n,) float64 or None

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    found = read_pairs(path, deformed_path, space)
    return found.rest, found.deformed, found.weights


def read_pairs(path, deformed_path=None, space="LPS"):
    """The same as `read`, with the labels: `Pairs`."""
    rest = read_landmarks(path, space, is_alone=not deformed_path)
    return paired(rest, read_landmarks(deformed_path, space) if deformed_path else None)


def read_landmarks(
    path: str | PathLike[str], space: str = "LPS", is_alone: bool = False
) -> Landmarks:
    """Read points with their labels.

    Parameters
    ----------
    path, space
        As of `read`.
    is_alone : bool
        Whether these are to be control points, without another file that says where they go: a
        table must then have pairs, or a header that says that it has none.

    Returns
    -------
    Landmarks
        In LPS.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = existing_file(path)
    read_file = formats.choose(path, "read points from", **_READ).read
    try:
        is_table = _reader(path) is point_tables.read
        found: Landmarks = point_tables.read(path, is_alone) if is_table else read_file(path)
    except UnicodeDecodeError as error:
        raise ValueError(
            f"`{path}` is no text in UTF-8: its byte {error.start} is {error.object[error.start]}"
        ) from None
    if len(found.positions) == 0:
        raise ValueError(f"`{path}` holds no control points")
    return found.in_lps(space)


def write(path, rest, deformed, weights=None, labels=()):
    """Write control points.

    Parameters
    ----------
    path : path
        Of a format of `formats.POINTS`. Tables (.csv, .txt) get all; the others hold positions and
        get q, without weights.
    rest, deformed : (n, 3) array_like, LPS
    weights : (n,) array_like, optional
    labels : list of n str, optional

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = Path(path)
    line = formats.choose(path, "write control points to", **_WRITE)
    as_pairs = formats.find(path, writes=(formats.PAIRS,))
    rest, deformed = np.asarray(rest, float), np.asarray(deformed, float)
    points = Landmarks(path, deformed, "LPS", labels)
    with _written(path) as file:
        if as_pairs:
            as_pairs.write(file, Pairs(rest, deformed, weights, points.labels))
        else:
            line.write(file, points)


def check_writable(path: str | PathLike[str]) -> Path:
    """`path` as a Path, if landmarks can be written to a file of this name, and there is room."""
    path = Path(path)
    formats.choose(path, "write points to", **_WRITE)
    check_replaceable(path)
    return path


def write_landmarks(path, points, source=None, space="LPS"):
    """Write points with their labels.

    Parameters
    ----------
    path : path
        Of a format of `formats.POINTS`.
    points : Landmarks
        In LPS. Those that are not placed are marked so, or left out where a format cannot say it.
    source : path, optional
        The file that they were read from. If its name ends as that of the new one, all else that
        it holds is kept, except that elastix' results become its points. Otherwise the new file
        is ITK's and ANTs' table (.csv), transformix' points (.txt, .pts) or markups, with the
        labels and descriptions that it can hold.
    space : str
        The frame of files that do not say theirs.

    Returns
    -------
    int
        How many points are left out.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = check_writable(path)
    line = formats.choose(path, "write points to", **_WRITE)
    rewrite = source and _rewriter(Path(source), line.ending(path))
    with _written(path) as file:
        if rewrite:
            return rewrite(Path(source), file, points.positions, space)
        if line.frame == formats.CALLER:
            points = replace(points, positions=points.positions * signs(space))
        return line.write(file, points)


def read_text(path):
    """Points of a file whose first line says what it is."""
    return _reader(path)(path)


def _reader(path):
    """The function that reads a file, by its name or its first line."""
    read_file = formats.choose(path, "read points from", **_READ).read
    if read_file is not read_text:
        return read_file
    with path.open(encoding="utf-8-sig") as file:
        first = next((line for line in file if line.strip()), "")
    return elastix_points.reader(first) or point_tables.read


def _rewriter(source, ending):
    """The function that writes `source` again, under a name with this ending; or None."""
    if not source.name.lower().endswith(ending):
        return None
    rewriters = {
        markups.read_json: markups.rewrite_json,
        markups.read_fcsv: markups.rewrite_fcsv,
        point_tables.read: point_tables.rewrite,
    }
    return rewriters.get(_reader(source))


@contextmanager
def _written(path):
    with replacing(path) as new, new.open("w", newline="", encoding="utf-8") as file:
        yield file
