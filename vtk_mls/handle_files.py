"""Control points in files of text: tables, and the markups of 3D Slicer.

Tables (.csv, .txt) have lines `px,py,pz,qx,qy,qz[,weight]`, in the world coordinates of the image;
a first line that is not of numbers, and what follows a #, are skipped. A table that ParaView wrote
of control points is one too: its columns Points and Displacement (and Weight) are found by their
names.

Markups (.fcsv, .mrk.json) are places only: p, with q = p, or, in a second file, q. They come and go
in the coordinates of MetaImage and NRRD, x to the left and y to the back of the patient; markups in
those of NIfTI are turned to them.
"""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np

from vtk_mls.replacing import replacing

_COLUMNS = ["px", "py", "pz", "qx", "qy", "qz"]
_KEPT, _TURNED = (1.0, 1.0, 1.0), (-1.0, -1.0, 1.0)
_TO_LPS = {"LPS": _KEPT, "1": _KEPT, "RAS": _TURNED, "0": _TURNED}


def read(path, deformed_path=None):
    """Read control points.

    Parameters
    ----------
    path : path
        Its name says the format, one of `FORMATS`.
    deformed_path : path, optional
        Another file, whose p are q.

    Returns
    -------
    rest, deformed : (n, 3) float64, world coordinates
        p and q.
    weights : (n,) float64 or None

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    rest, deformed, weights = _parsed(Path(path))
    if deformed_path:
        deformed, _, _ = _parsed(Path(deformed_path))
        if len(deformed) != len(rest):
            raise ValueError(
                f"`{deformed_path}` must hold one place for each of the {len(rest)} control points "
                f"of `{path}`, got {len(deformed)}"
            )
    return rest, deformed, weights


def write(path, rest, deformed, weights=None):
    """Write control points.

    Parameters
    ----------
    path : path
        Its name says the format, one of `FORMATS`. Markups get q.
    rest, deformed : (n, 3) array_like, world coordinates
    weights : (n,) array_like, optional

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = Path(path)
    _, store = _format(path, "write control points to")
    rest, deformed = np.asarray(rest, float), np.asarray(deformed, float)
    with replacing(path) as new, new.open("w", newline="", encoding="utf-8") as file:
        store(file, rest, deformed, weights)


def _parsed(path):
    parse, _ = _format(path, "read control points from")
    if not path.is_file():
        raise FileNotFoundError(f"there is no file `{path}`")
    try:
        rest, deformed, weights = parse(path)
    except UnicodeDecodeError as error:
        raise ValueError(
            f"`{path}` is no text in UTF-8: its byte {error.start} is {error.object[error.start]}"
        ) from None
    if len(rest) == 0:
        raise ValueError(f"`{path}` holds no control points")
    if not (np.isfinite(rest).all() and np.isfinite(deformed).all()):
        raise ValueError(f"`{path}` has a coordinate that is not a finite number")
    if weights is not None and not (np.isfinite(weights) & (weights > 0)).all():
        raise ValueError(f"`{path}` has a weight that is not a positive number")
    return rest, deformed, weights


def _format(path, purpose):
    for suffix, functions in FORMATS.items():
        if path.name.lower().endswith(suffix):
            return functions
    raise ValueError(f"cannot {purpose} `{path}`: its name must end in one of {', '.join(FORMATS)}")


def _read_table(path):
    rows, order, seen = [], None, False
    with path.open(newline="", encoding="utf-8-sig") as file:
        lines = csv.reader(line.partition("#")[0] for line in file)
        for row in _rows(path, lines):
            if not any(cell.strip() for cell in row):
                continue
            numbers = _numbers(row)
            if not (numbers or seen or any(_numbers([cell]) for cell in row)):
                seen, order = True, _paraview_columns(row)  # the header
                continue
            seen = True
            if order and len(numbers) == len(row):
                numbers = [numbers[column] for column in order]
            if len(numbers) not in (6, 7) or (rows and len(numbers) != len(rows[0])):
                raise ValueError(
                    f"`{path}`, line {lines.line_num}: expected numbers "
                    "px,py,pz,qx,qy,qz[,weight], as many in each line, got "
                    + _shortened(",".join(row))
                )
            rows.append(numbers)
    table = np.reshape(rows, (len(rows), -1 if rows else 6)).astype(float)
    rest, deformed = table[:, :3], table[:, 3:6]
    if order:
        deformed = rest + deformed
    return rest, deformed, table[:, 6] if table.shape[1] == 7 else None


def _rows(path, lines):
    try:
        yield from lines
    except csv.Error as error:
        raise ValueError(f"`{path}`, line {lines.line_num}: {error}") from None


def _paraview_columns(header):
    """Where in a table by ParaView the columns are, or None."""
    names = [re.sub(r"[:_](?=\d$)", "", name.strip()) for name in header]
    wanted = [f"{name}{axis}" for name in ("Points", "Displacement") for axis in range(3)]
    wanted += ["Weight"] * ("Weight" in names)
    return [names.index(name) for name in wanted] if set(wanted) <= set(names) else None


def _shortened(text):
    """A text in backticks, or its beginning and how long it is."""
    return f"`{text}`" if len(text) <= 60 else f"`{text[:60]}...` of {len(text)} characters"


def _numbers(row):
    """The numbers in a row of text, or none if not all are."""
    try:
        return [float(cell) for cell in row]
    except ValueError:
        return []


def _write_table(file, rest, deformed, weights):
    lines = csv.writer(file, lineterminator="\n")
    table = np.hstack([rest, deformed] if weights is None else [rest, deformed, np.c_[weights]])
    lines.writerow(_COLUMNS + ["weight"] * (weights is not None))
    lines.writerows(table.tolist())


def _read_fiducials(path):
    system, rows = "RAS", []
    with path.open(newline="", encoding="utf-8-sig") as file:
        for line in file:
            if line.startswith("#"):
                key, _, value = line.lstrip("# ").partition("=")
                system = value.strip() if key.strip() == "CoordinateSystem" else system
            elif line.strip():
                rows.append(line.split(",")[1:4])
    return _places(path, rows, system)


def _write_fiducials(file, rest, deformed, weights):
    file.write("# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n")
    file.write("# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n")
    for number, (x, y, z) in enumerate(deformed.tolist(), 1):
        file.write(f"{number},{x!r},{y!r},{z!r},0,0,0,1,1,1,0,{number},,\n")


def _read_markups(path):
    try:
        markups = json.loads(path.read_text(encoding="utf-8"))["markups"][0]
        points = [
            each["position"]
            for each in markups["controlPoints"]
            if each.get("positionStatus", "defined") == "defined"
        ]
        system = markups.get("coordinateSystem", "LPS")
    except UnicodeDecodeError:
        raise
    except RecursionError:
        raise ValueError(f"`{path}` is no list of markups: it is nested too deeply") from None
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise ValueError(f"`{path}` is no list of markups: {error!r:.80}") from error
    return _places(path, points, system)


def _write_markups(file, rest, deformed, weights):
    points = [
        {"id": str(number), "label": str(number), "position": place}
        for number, place in enumerate(deformed.tolist(), 1)
    ]
    markups = {"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": points}
    json.dump({"markups": [markups]}, file, indent=1)


def _places(path, rows, system):
    """Control points at rest at the places that markups say."""
    if str(system) not in _TO_LPS:
        raise ValueError(
            f"`{path}` has the coordinate system {system!s:.20}; it must be LPS or RAS"
        )
    try:
        places = np.array(rows, dtype=float).reshape(len(rows), 3) * _TO_LPS[str(system)]
    except (OverflowError, TypeError, ValueError):
        raise ValueError(f"`{path}` has a place that is not three numbers") from None
    return places, places, None


FORMATS = {
    ".csv": (_read_table, _write_table),
    ".txt": (_read_table, _write_table),
    ".fcsv": (_read_fiducials, _write_fiducials),
    ".mrk.json": (_read_markups, _write_markups),
}
