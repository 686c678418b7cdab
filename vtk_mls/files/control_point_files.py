"""Control points and landmarks in files of text.

What a file is, its name and its content say. Markups of 3D Slicer (.mrk.json, .fcsv) are described
in `markups`. Other text (.csv, .txt, .pts) is what its first line with something in it says: one of
elastix if that is the word `point` or `index`, or begins with `Point` and a number and a semicolon
(`elastix_points`); else a table (`point_tables`), which can be of control points, or of landmarks
as plain text, ITK, ANTs, BigWarp or 3D Slicer have them.

Files that hold places only give control points that rest there (q = p), or, as a second file, the
places that control points are moved to. All coordinates are handed on in LPS (see `frames`), and
those of a file that does not say its frame count as LPS unless the caller knows better.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from vtk_mls.files import elastix_points, markups, point_tables
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Handles, Landmarks, handles
from vtk_mls.files.replacing import check_replaceable, replacing

FORMATS = (".csv", ".txt", ".pts", ".fcsv", ".mrk.json")
_TABLES = (".csv", ".txt")  # to which control points are written as pairs


def read(path, deformed_path=None, space="LPS"):
    """Read control points.

    Parameters
    ----------
    path : path
        Its name ends in one of `FORMATS`.
    deformed_path : path, optional
        Another file, whose places are q: how they find their p is said in `landmarks.handles`.
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
    found = read_handles(path, deformed_path, space)
    return found.rest, found.deformed, found.weights


def read_handles(path, deformed_path=None, space="LPS"):
    """The same as `read`, with the labels: `Handles`."""
    rest = read_landmarks(path, space, is_alone=not deformed_path)
    return handles(rest, read_landmarks(deformed_path, space) if deformed_path else None)


def read_landmarks(path, space="LPS", is_alone=False):
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
    path = Path(path)
    suffix = _suffix(path, "read points from")
    if not path.is_file():
        raise FileNotFoundError(f"there is no file `{path}`")
    try:
        reader = _reader(path, suffix)
        found = reader(path)
        if is_alone and reader is point_tables.read and found.partners is None:
            point_tables.check_is_told(path)
    except UnicodeDecodeError as error:
        raise ValueError(
            f"`{path}` is no text in UTF-8: its byte {error.start} is {error.object[error.start]}"
        ) from None
    if len(found.places) == 0:
        raise ValueError(f"`{path}` holds no control points")
    return found.in_lps(space)


def write(path, rest, deformed, weights=None, labels=()):
    """Write control points.

    Parameters
    ----------
    path : path
        Its name ends in one of `FORMATS`. Tables (.csv, .txt) get all; the others hold places and
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
    suffix = _suffix(path, "write control points to")
    rest, deformed = np.asarray(rest, float), np.asarray(deformed, float)
    points = Landmarks(path, deformed, "LPS", labels)
    with _written(path) as file:
        if suffix in _TABLES:
            point_tables.write_handles(file, Handles(rest, deformed, weights, points.labels))
        else:
            _WRITERS[suffix](file, points)


def check_writable(path):
    """`path` as a Path, if landmarks can be written to a file of this name, and there is room."""
    path = Path(path)
    _suffix(path, "write points to")
    check_replaceable(path)
    return path


def write_landmarks(path, points, source=None, space="LPS"):
    """Write points with their labels.

    Parameters
    ----------
    path : path
        Its name ends in one of `FORMATS`.
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
    suffix = _suffix(path, "write points to")
    rewrite = source and _rewriter(Path(source), suffix)
    with _written(path) as file:
        if rewrite:
            return rewrite(Path(source), file, points.places, space)
        if suffix not in _SAYING_A_FRAME:
            points = replace(points, places=points.places * signs(space))
        return _WRITERS[suffix](file, points)


def _suffix(path, purpose):
    for suffix in FORMATS:
        if path.name.lower().endswith(suffix):
            return suffix
    raise ValueError(f"cannot {purpose} `{path}`: its name must end in one of {', '.join(FORMATS)}")


def _reader(path, suffix):
    if suffix in _SAYING_A_FRAME:
        return markups.read_json if suffix == ".mrk.json" else markups.read_fcsv
    with path.open(encoding="utf-8-sig") as file:
        first = next((line for line in file if line.strip()), "")
    return elastix_points.reader(first) or point_tables.read


def _rewriter(source, suffix):
    """The function that writes `source` again, under a name that ends in `suffix`; or None."""
    if not source.name.lower().endswith(suffix):
        return None
    rewriters = {
        markups.read_json: markups.rewrite_json,
        markups.read_fcsv: markups.rewrite_fcsv,
        point_tables.read: point_tables.rewrite,
    }
    return rewriters.get(_reader(source, suffix))


@contextmanager
def _written(path):
    with replacing(path) as new, new.open("w", newline="", encoding="utf-8") as file:
        yield file


_SAYING_A_FRAME = (".fcsv", ".mrk.json")
_WRITERS = {
    ".csv": point_tables.write,
    ".txt": elastix_points.write,
    ".pts": elastix_points.write,
    ".fcsv": markups.write_fcsv,
    ".mrk.json": markups.write_json,
}
