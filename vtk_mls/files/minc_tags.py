"""Tag points of MINC, .tag: points of one volume, or pairs of two.

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

import numpy as np

from vtk_mls.base.errors import InputError
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, finite, numbers, shortened

_TITLE = "MNI Tag Point File"
_VOLUMES = re.compile(r"Volumes\s*=\s*(\d{1,9})\s*;?")
_POINTS = re.compile(r"Points\s*=(.*)")
# The cells of a point, its label with \" and \\, and the end of all points.
_ROW = re.compile(r'\s*([^";]*?)\s*("(?:[^"\\]|\\.)*")?\s*(;?)\s*')


def read(path):
    """The points of a file, in RAS; with partners if it has two volumes."""
    count, rows = _parsed(path)
    tags = list(_tags(rows, count))
    places = np.reshape([place for place, _ in tags], (len(tags), count, 3))
    labels = [re.sub(r"\\(.)", r"\1", label[1:-1]) for _, label in tags]
    partners = places[:, 0] if count == 2 else None
    return Landmarks(path, places[:, -1], "RAS", labels, partners=partners, are_marked=True)


def write(file, landmarks):
    """Write points of one volume."""
    places = landmarks.positions[landmarks.is_placed] * signs("RAS")
    _write(file, places, [label for _, _, label, _ in landmarks.placed_rows])


def write_pairs(file, pairs):
    """Write `Pairs`, in LPS: q in the first volume, p in the second. Weights are left out."""
    _write(file, np.hstack([pairs.deformed, pairs.rest]) * np.tile(signs("RAS"), 2), pairs.labels)


def _write(file, places, labels):
    """Write coordinates (n, 3 or 6), in RAS, with labels."""
    rows = zip(places.tolist(), map(_quoted, labels))
    lines = [" ".join([" ", *map(repr, place), label]).rstrip() for place, label in rows]
    count = places.shape[1] // 3
    file.write(f"{_TITLE}\nVolumes = {count};\n\nPoints =\n" + "\n".join(lines) + ";\n")


def _quoted(label):
    """A label between quotation marks, on one line."""
    text = re.sub(r'(["\\])', r"\\\1", " ".join(label.splitlines()))
    return f'"{text}"' if text else ""


def _parsed(path):
    """The number of volumes, and (line number, text) from `Points =` on."""
    with path.open(encoding="utf-8-sig") as file:
        lines = list(enumerate(file, 1))
    if not lines or lines[0][1].strip() != _TITLE:
        raise InputError(f"does not begin with `{_TITLE}`")
    start = next((i for i, (_, line) in enumerate(lines) if _POINTS.match(line.strip())), None)
    counts = [match[1] for _, line in lines[:start] if (match := _VOLUMES.match(line.strip()))]
    if start is None or counts not in (["1"], ["2"]):
        raise InputError("must have a line `Volumes = 1;` or 2, and then `Points =`")
    number, first = lines[start]
    return int(counts[0]), [(number, _POINTS.match(first.strip())[1]), *lines[start + 1 :]]


def _tags(rows, count):
    """(coordinates, label with quotes) of each point in lines, which end with a semicolon."""
    has_ended = False
    for number, line in rows:
        if not line.strip() or line.lstrip().startswith(("%", "#")):
            continue
        row = _ROW.fullmatch(line)
        cells = row[1].split() if row else []
        coordinates = numbers(cells[: 3 * count])
        is_point = len(coordinates) == 3 * count and len(cells) in (3 * count, 3 * count + 3)
        is_end = row is not None and not cells and not row[2] and row[3]
        if has_ended or not (is_point or is_end):
            raise InputError(
                f", line {number}: expected {3 * count} coordinates, perhaps three other "
                f"numbers, and a label in quotes, got {shortened(line.strip())}"
            )
        has_ended = bool(row[3])
        if is_point:
            yield finite(f"line {number}", coordinates), row[2] or ""
    if not has_ended:
        raise InputError("is cut off: a semicolon must follow its last point")
