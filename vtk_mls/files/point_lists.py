"""Points in text files of elastix, of IDAV Landmark and of MINC.

elastix. The input (`-def`) of transformix has a line `point`, a line with the number of points, and
a line x y z for each. Files with the first line `index` have voxel indices, which are no positions
without the image. The output, outputpoints.txt, has lines `Point N ; InputIndex = [..] ; InputPoint
= [..] ; ... ; OutputPoint = [x y z] ; ...`. OutputPoint is read, with N as the label. transformix
maps the fixed to the moving image: OutputPoint is the position in the moving image whose material
comes to InputPoint.

IDAV Landmark, .pts. A line `Version 1.0`, the number of points, and lines `label x y z`. Missing
points are at 9999, 9999, 9999, as the R packages for such files have it.

MINC. Tag points, .tag, are points of one volume, or pairs of two.

    MNI Tag Point File
    Volumes = 2;
    % a comment
    Points =
     x1 y1 z1 x2 y2 z2 [weight structure patient] ["label"]
     ...;

Coordinates are in MINC's world, x to the right and y to the front of the patient: RAS. The programs
of MINC transform the second volume onto the first (tagtoxfm), so p is the point of the second
volume, and q the point of the first. Weights, structures and patients do not count.
"""

import re
from functools import partial

import numpy as np

from vtk_mls.base.errors import InputError
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, finite, numbers, shortened

_RESULT = re.compile(r"Point\s+(\d+)\s*;")
_POSITION = re.compile(r"\bOutputPoint\s*=\s*\[([^\]]*)\]")
_VERSION = re.compile(r"version\s+\d+(\.\d+)?", re.IGNORECASE)
_MISSING = [9999.0] * 3
_TITLE = "MNI Tag Point File"
_VOLUMES = re.compile(r"Volumes\s*=\s*(\d{1,9})\s*;?")
_POINTS = re.compile(r"Points\s*=(.*)")
# The cells of a point, its label with \" and \\, and the end of all points.
_ROW = re.compile(r'\s*([^";]*?)\s*("(?:[^"\\]|\\.)*")?\s*(;?)\s*')


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
        raise InputError(f", line {number}: expected the number of points, got {shortened(count)}")
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
        raise InputError(f", line {number}: expected {more}three numbers, got {shortened(line)}")
    return finite(f"line {number}", position)


def read_tags(path):
    """The points of a file, in RAS; with partners if it has two volumes."""
    count, rows = _parsed(path)
    tags = list(_tags(rows, count))
    places = np.reshape([place for place, _ in tags], (len(tags), count, 3))
    labels = [re.sub(r"\\(.)", r"\1", label[1:-1]) for _, label in tags]
    partners = places[:, 0] if count == 2 else None
    return Landmarks(path, places[:, -1], "RAS", labels, partners=partners, are_marked=True)


def write_tags(file, landmarks):
    """Write points of one volume."""
    places = landmarks.positions[landmarks.is_placed] * signs("RAS")
    _write_tags(file, places, [label for _, _, label, _ in landmarks.placed_rows])


def write_tag_pairs(file, pairs):
    """Write `Pairs`, in LPS: q in the first volume, p in the second. Weights are left out."""
    places = np.hstack([pairs.deformed, pairs.rest]) * np.tile(signs("RAS"), 2)
    _write_tags(file, places, pairs.labels)


def _write_tags(file, places, labels):
    """Write coordinates (n, 3 or 6), in RAS, with labels."""
    rows = zip(places.tolist(), map(_quoted, labels))
    lines = [" ".join([" ", *map(repr, place), label]).rstrip() for place, label in rows]
    count = places.shape[1] // 3
    file.write(f"{_TITLE}\nVolumes = {count};\n\nPoints =\n" + "\n".join(lines) + ";\n")


def _quoted(label):
    text = re.sub(r'(["\\])', r"\\\1", " ".join(label.splitlines()))
    return f'"{text}"' if text else ""


def _parsed(path):
    """The number of volumes, and (line number, text) from `Points =` on."""
    lines = list(_numbered_lines(path))
    if lines[:1] != [(1, _TITLE)]:
        raise InputError(f"does not begin with `{_TITLE}`")
    start = next((i for i, (_, line) in enumerate(lines) if _POINTS.match(line)), None)
    counts = [match[1] for _, line in lines[:start] if (match := _VOLUMES.match(line))]
    if start is None or counts not in (["1"], ["2"]):
        raise InputError("must have a line `Volumes = 1;` or 2, and then `Points =`")
    number, first = lines[start]
    return int(counts[0]), [(number, _POINTS.match(first)[1].strip()), *lines[start + 1 :]]


def _tags(rows, count):
    """(coordinates, label with quotes) of each point in lines, which end with a semicolon."""
    has_ended = False
    for number, line in rows:
        if not line or line.startswith(("%", "#")):
            continue
        row = _ROW.fullmatch(line)
        cells = row[1].split() if row else []
        coordinates = numbers(cells[: 3 * count])
        is_point = len(coordinates) == 3 * count and len(cells) in (3 * count, 3 * count + 3)
        is_end = row is not None and not cells and not row[2] and row[3]
        if has_ended or not (is_point or is_end):
            raise InputError(
                f", line {number}: expected {3 * count} coordinates, perhaps three other "
                f"numbers, and a label in quotes, got {shortened(line)}"
            )
        has_ended = bool(row[3])
        if is_point:
            yield finite(f"line {number}", coordinates), row[2] or ""
    if not has_ended:
        raise InputError("is cut off: a semicolon must follow its last point")
