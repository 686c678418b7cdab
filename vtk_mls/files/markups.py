"""Markups of 3D Slicer: .mrk.json, and its predecessor .fcsv.

Both say their frame, have positions with labels and descriptions, and points that are not placed.
The control points of all markups of a .mrk.json are read, whatever their type (points, lines,
curves, planes, boxes), but not their orientations. The points of a curve are the nodes of a
polyline, whatever its interpolation in Slicer. An .fcsv without a version is one of Slicer 3:
its label comes first, its frame is RAS.
"""

import csv
import json
import math
from contextlib import contextmanager, suppress

import numpy as np

from vtk_mls.base.errors import InputError
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, finite, numbers, shortened
from vtk_mls.model.handles.handle_cells import HandleCells

# All versions of Slicer compare this address, except for the last two numbers.
_SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/"
    "Schema/markups-schema-v1.0.3.json#"
)
_STATUSES = ("undefined", "preview", "defined", "missing")  # in the order of Slicer's numbers
_DEFINED = _STATUSES.index("defined")
_DEFORMABLE_TYPES = ("Fiducial", "Line", "Angle", "Curve", "ClosedCurve")
_CURVES = {"Curve": 0, "ClosedCurve": 1}  # how many of the first nodes follow the last one
_ORIENTATION = [-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0]  # the axes of RAS, in LPS
_FRAMES = {"0": "RAS", "1": "LPS", "RAS": "RAS", "LPS": "LPS"}
_NOWHERE = [math.nan] * 3
_LABEL, _DESCRIPTION, _STATUS = 11, 12, 14  # columns of .fcsv


def read_json(path):
    """The points of a .mrk.json, in LPS, and its curves."""
    positions, labels, descriptions = [np.empty((0, 3))], [], []
    vertices, curves = [], []
    for markups, factors, points in _lists(_document(path)):
        rows = np.arange(len(labels), len(labels) + len(points))
        if len(points) and markups.get("type") in _CURVES:
            curves.append(np.append(rows, rows[: _CURVES[markups["type"]]]))
        else:
            vertices.append(rows)
        numbered = enumerate(points, len(labels) + 1)
        list_positions = [_json_position(number, point) for number, point in numbered]
        positions.append(np.reshape(list_positions, (-1, 3)) * factors)
        for point in points:
            labels.append(_text(point.get("label", "")))
            descriptions.append(_text(point.get("description", "")))
    rows = np.concatenate([np.empty(0, int), *vertices])
    cells = HandleCells(rows, tuple(curves)) if curves else None
    return Landmarks(path, np.concatenate(positions), "LPS", labels, descriptions, cells=cells)


def write_json(file, landmarks):
    """Write points to a .mrk.json for Slicer 4.11 and later; those not placed are marked."""
    points = []
    rows = zip(landmarks.positions.tolist(), landmarks.labels, landmarks.descriptions)
    for number, (position, label, description) in enumerate(rows, 1):
        point = {
            "id": str(number),
            "label": label or str(number),
            "description": description,
            "associatedNodeID": "",
            "position": position,
            "orientation": _ORIENTATION,
            "selected": True,
            "locked": False,
            "visibility": True,
            "positionStatus": "defined",
        }
        points.append(_placed(point, np.array(position)))
    markups = {"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": points}
    json.dump({"@schema": _SCHEMA, "markups": [markups]}, file, indent=1)


def rewrite_json(path, file, positions):
    """Write a .mrk.json again, with other positions. Planes and boxes become points."""
    document, start = _document(path), 0
    for markups, factors, points in _lists(document):
        for i, point in enumerate(points):
            points[i] = _placed(point, positions[start + i] * factors)
        start += len(points)
        if markups.get("type") not in _DEFORMABLE_TYPES:
            copied = {key: markups[key] for key in ("name", "coordinateSystem") if key in markups}
            markups.clear()
            markups.update(copied, type="Fiducial", controlPoints=points)
        markups.pop("measurements", None)  # of the old positions
    document.setdefault("@schema", _SCHEMA)
    json.dump(document, file, indent=1)


def read_fcsv(path):
    positions, labels, descriptions, header = [], [], [], {}
    for row, number in _fcsv_rows(path, header):
        positions.append(_fcsv_position(number, row))
        is_old = "version" not in header
        labels.append(_cell(row, 0 if is_old else _LABEL))
        descriptions.append("" if is_old else _cell(row, _DESCRIPTION))
    frame = header.get("CoordinateSystem", "RAS")
    if frame not in _FRAMES:
        raise _wrong_frame(frame)
    positions = np.reshape(positions, (-1, 3))
    return Landmarks(path, positions, _FRAMES[frame], labels, descriptions)


def write_fcsv(file, landmarks):
    """Write points to an .fcsv for Slicer 4.4 and later."""
    # Versions before 4.11 read the frame as a number, and the word LPS as RAS.
    file.write("# Markups fiducial file version = 4.11\n# CoordinateSystem = 1\n")
    file.write("# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n")
    lines = csv.writer(file, lineterminator="\n")
    for i, position, label, description in landmarks.placed_rows:
        # Slicer reads by lines
        label, description = (" ".join(x.split()) for x in (label or str(i + 1), description))
        lines.writerow([i + 1, *position, 0, 0, 0, 1, 1, 1, 0, label, description, ""])


def _document(path):
    """The content of a JSON file, if it has a list of markups."""
    with _as_sentence():
        document = json.loads(path.read_text(encoding="utf-8-sig"))
        if not isinstance(document["markups"], list):
            raise TypeError("`markups` is not a list")
    return document


def _lists(document):
    """(markups, signs to LPS, points) of each markups of a document."""
    for markups in document["markups"]:
        with _as_sentence():
            points = markups.get("controlPoints", [])
            if not isinstance(points, list) or not all(isinstance(point, dict) for point in points):
                raise TypeError("`controlPoints` is not a list of dictionaries")
            frame = markups.get("coordinateSystem", "LPS")
        if not isinstance(frame, str) or frame not in _FRAMES:
            raise _wrong_frame(frame)
        yield markups, signs(_FRAMES[frame]), points


@contextmanager
def _as_sentence():
    try:
        yield
    except UnicodeDecodeError:
        raise
    except RecursionError:
        raise InputError("has no markups: it is nested too deeply") from None
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise InputError(f"has no markups: {error!r:.80}") from error


def _json_position(number, point):
    """The position of a control point, three numbers; NaN if it has none."""
    status, position = point.get("positionStatus", "defined"), point.get("position", "")
    if status not in _STATUSES:
        raise InputError(
            f", point {number}: `positionStatus` must be one of {', '.join(_STATUSES)}, "
            f"got {shortened(str(status))}"
        )
    if status != "defined" or position == "":
        return _NOWHERE
    with suppress(OverflowError, TypeError):
        if [type(coordinate) in (int, float) for coordinate in position] == [True] * 3:
            return finite(f"point {number}", [*map(float, position)])
    text = shortened(f"{position!s:.200}")
    raise InputError(f"has a position that is not three numbers: point {number} is at {text}")


def _placed(point, position):
    """A control point of JSON at another position; undefined if that is NaN."""
    if np.isfinite(position).all():
        status = {"positionStatus": "defined"} if "positionStatus" in point else {}
        return point | {"position": position.tolist()} | status
    return {k: v for k, v in point.items() if k != "position"} | {"positionStatus": "undefined"}


def _fcsv_rows(path, header):
    """(cells, line number) of each point; `header` gets the keys and values of lines with #."""

    def lines(file):
        for line in file:
            if line.startswith("#"):
                key, _, value = line.lstrip("# ").partition("=")
                header[key.strip().removeprefix("Markups fiducial file ")] = value.strip()
                line = "\n"
            yield line

    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = csv.reader(lines(file))
        try:
            for row in rows:
                if any(cell.strip() for cell in row):
                    yield row, rows.line_num
        except csv.Error as error:
            raise InputError(f", line {rows.line_num}: {error}") from None


def _fcsv_position(number, row):
    """The position of a row, three numbers; NaN if it has none."""
    if _cell(row, _STATUS).strip() not in ("", str(_DEFINED)):
        return _NOWHERE
    position = numbers(row[1:4])
    if len(position) != 3:
        text = shortened(",".join(row))
        raise InputError(f"has a position that is not three numbers in line {number}: {text}")
    return finite(f"line {number}", position)


def _wrong_frame(frame):
    return InputError(f"has the coordinate system {frame!s:.20}; it must be LPS or RAS")


def _cell(row, column):
    return row[column] if column < len(row) else ""


def _text(value):
    """A label of JSON, of any type, as text that can be written as UTF-8."""
    return "" if value is None else str(value).encode("utf-8", "replace").decode()
