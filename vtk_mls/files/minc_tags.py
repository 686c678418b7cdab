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

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, shortened
from vtk_mls.files.point_tables import numbers

_TITLE = "MNI Tag Point File"
_VOLUMES = re.compile(r"Volumes\s*=\s*(\d{1,9})\s*;?")
_POINTS = re.compile(r"Points\s*=(.*)")
# The cells of a point, its label with \" and \\, and the end of all points.
_ROW = re.compile(r'\s*([^";]*?)\s*("(?:[^"\\]|\\.)*")?\s*(;?)\s*')


class _Tag(NamedTuple):
    """A point: the line's number, its coordinates, other cells, and label with quotes, or ""."""

    line: int
    coordinates: list
    others: list
    label: str


def read(path):
    """The points of a file, in RAS; with partners if it has two volumes."""
    _, count, tags = _parsed(path)
    places = np.reshape([tag.coordinates for tag in tags], (len(tags), count, 3))
    for tag, place in zip(tags, places):
        if not np.isfinite(place).all():
            raise ValueError(
                f"`{path}` has a coordinate that is not a finite number in line {tag.line}"
            )
    labels = [re.sub(r"\\(.)", r"\1", tag.label[1:-1]) for tag in tags]
    partners = places[:, 0] if count == 2 else None
    return Landmarks(path, places[:, -1], "RAS", labels, partners=partners)


def write(file, landmarks):
    """Write points of one volume, without those that are not placed."""
    placed = np.flatnonzero(landmarks.is_placed)
    labels = [_quoted(landmarks.labels[i]) for i in placed]
    _write(file, f"{_TITLE}\nVolumes = 1;\n", landmarks.positions[placed] * signs("RAS"), labels)
    return len(landmarks.positions) - len(placed)


def write_pairs(file, pairs):
    """Write `Pairs`, in LPS: q in the first volume, p in the second. Weights are left out."""
    places = np.hstack([pairs.deformed * signs("RAS"), pairs.rest * signs("RAS")])
    _write(file, f"{_TITLE}\nVolumes = 2;\n", places, [_quoted(label) for label in pairs.labels])


def rewrite(path, file, positions, space):
    """Write a file again, with other positions, of pairs in the second volume; NaN is left out."""
    head, _, tags = _parsed(path)
    positions = positions * signs("RAS")
    placed = np.flatnonzero(np.isfinite(positions).all(axis=1))
    places = [[*tags[i].coordinates[:-3], *positions[i].tolist()] for i in placed]
    _write(file, head, places, [" ".join([*tags[i].others, tags[i].label]) for i in placed])
    return len(tags) - len(placed)


def _write(file, head, places, ends):
    """Write a head, and coordinates (n, 3 or 6) with the rest of each line."""
    rows = [[float(x) for x in place] for place in places]
    lines = [" ".join([" ", *map(repr, row), end]).rstrip() for row, end in zip(rows, ends)]
    file.write(f"{head}\nPoints =\n" + "\n".join(lines) + ";\n")


def _quoted(label):
    """A label between quotation marks, on one line."""
    text = re.sub(r'(["\\])', r"\\\1", " ".join(label.splitlines()))
    return f'"{text}"' if text else ""


def _parsed(path):
    """The text before the points, the number of volumes, and a list of _Tag."""
    with path.open(encoding="utf-8-sig") as file:
        lines = list(enumerate(file, 1))
    if not lines or lines[0][1].strip() != _TITLE:
        raise ValueError(f"`{path}` does not begin with `{_TITLE}`")
    start = next((i for i, (_, line) in enumerate(lines) if _POINTS.match(line.strip())), None)
    head = lines[: len(lines) if start is None else start]
    counts = [match[1] for _, line in head if (match := _VOLUMES.match(line.strip()))]
    if start is None or counts not in (["1"], ["2"]):
        raise ValueError(f"`{path}` must have a line `Volumes = 1;` or 2, and then `Points =`")
    number, first = lines[start]
    rows = [(number, _POINTS.match(first.strip())[1]), *lines[start + 1 :]]
    return (
        "".join(line for _, line in head).rstrip() + "\n",
        int(counts[0]),
        _tags(path, rows, int(counts[0])),
    )


def _tags(path, rows, count):
    """The points of lines, which end with a semicolon."""
    tags, has_ended = [], False
    for number, line in rows:
        if not line.strip() or line.lstrip().startswith(("%", "#")):
            continue
        row = _ROW.fullmatch(line)
        cells = row[1].split() if row else []
        coordinates = numbers(cells[: 3 * count])
        is_point = len(coordinates) == 3 * count and len(cells) in (3 * count, 3 * count + 3)
        is_end = row is not None and not cells and not row[2] and row[3]
        if has_ended or not (is_point or is_end):
            raise ValueError(
                f"`{path}`, line {number}: expected {3 * count} coordinates, perhaps three other "
                f"numbers, and a label in quotes, got {shortened(line.strip())}"
            )
        has_ended = bool(row[3])
        if is_point:
            tags.append(_Tag(number, coordinates, cells[3 * count :], row[2] or ""))
    if not has_ended:
        raise ValueError(f"`{path}` is cut off: a semicolon must follow its last point")
    return tags
