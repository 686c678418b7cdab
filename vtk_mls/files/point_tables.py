"""Tables of points in text, one point or pair in a line.

Cells are separated by commas, tabs or, in lines without these, by blanks; or by semicolons, as in
spreadsheets with a decimal comma, which is also read between tabs. A first line without a number is
a header. Text after a # is skipped in lines without quotation marks, but the last such line before
the points can be the header. The names in a header say what the columns are, in any order, in upper
or lower case (see `column_names`):

    px py pz qx qy qz           control points
    x_moving .. x_fixed ..      and other names of both: rest and deformed, source and target, ...
    x y z x1 y1 z1              positions, and where they go; also x y z new_x new_y new_z
    x y z dx dy dz              positions, and how far they go, q - p
    Points:0 .. Displacement:0  those that ParaView has written, q - p; without it, positions
    r a s  or  l p s            3D Slicer's table of control points, which so says its frame
    x y z                       positions, also those of ITK and ANTs (x,y,z,t,label,comment)

Other columns are `weight`, `label` or `name`, `description` or `comment`, `defined` (0: not
placed), and `use` or `active` (false: the line does not count). All others are ignored, except
columns that may be a second position (x,y,z,u,v,w), which are an error in files of control points.
With a column `time` control points move in time: each line is of one time.
Without such names all lines must be alike and one of

    px,py,pz,qx,qy,qz           control points; a seventh number is the weight
    x,y,z                       positions
    label,...                   either of them after a label that is not a number
    name,active,x,y,z,u,v,w     BigWarp's landmarks, with `true` or `false` as the second

An index column, whose name is empty, is ignored. `table_layouts` tells the header 0,1,2,.. of
pandas from a first point.

BigWarp's first position is in the moving image, the second in the target, and BigWarp deforms the
moving image: p is the first, q the second. Lines that are not active do not count.
"""

from __future__ import annotations

import csv
import math
from typing import NamedTuple

import numpy as np

from vtk_mls.base.messages import warn
from vtk_mls.base.time_steps import step_at
from vtk_mls.files import table_layouts
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks

_BOOLEANS = {"true": True, "1": True, "false": False, "0": False}
_UNDEFINED = ("0", "", "false")
_NOWHERE = 3 * (math.nan,)


def times(path):
    """The different times in the column `time` of a table, sorted; () without the column."""
    table = _open(path)
    if table.layout is None or table.layout.time is None:
        return ()
    return tuple(sorted({_time(path, table.layout, *row) for row in _points(path, table)}))


def read(path, is_alone=False, time=None):
    """The points of a table.

    Parameters
    ----------
    path : path
    is_alone, time
        As in `control_point_files.read_landmarks`.

    Returns
    -------
    Landmarks
        With partners if the table has pairs.

    Raises
    ------
    ValueError
        Naming the file and the line.
    """
    table = _open(path)
    layout = table.layout
    if not table.rows:
        return Landmarks(path, np.empty((0, 3)))
    positions, partners, weights, labels, descriptions = [], [], [], [], []
    for number, row in _rows_at(path, table, time, is_alone):
        if is_alone and not positions:
            _check_has_pairs(path, layout, number, row)
        position, partner = _pair(path, layout, number, row)
        positions.append(position)
        if layout.partner:
            partners.append(partner)
        if layout.weight is not None:
            weights += _numbers(path, layout, number, row, [layout.weight])
        labels.append("" if layout.label is None else row[layout.label].strip())
        descriptions.append("" if layout.description is None else row[layout.description])
    if layout.unused:
        warn(
            f"`{path}`: columns {layout.unused} are ignored; control points have px,py,pz,qx,qy,qz"
        )
    weights = np.array(weights) if weights else None
    if weights is not None and not (np.isfinite(weights) & (weights > 0)).all():
        raise ValueError(f"`{path}` has a weight that is not a positive number")
    return Landmarks(
        path,
        np.array(positions, dtype=np.float64),
        layout.frame,
        labels,
        descriptions,
        np.array(partners, dtype=np.float64) if partners else None,
        weights,
    )


def write_pairs(file, pairs):
    """Write `Pairs`."""
    write_row = _row_writer(file)
    has_labels, has_weights = any(pairs.labels), pairs.weights is not None
    names = ["px", "py", "pz", "qx", "qy", "qz"]
    write_row(["label"] * has_labels + names + ["weight"] * has_weights)
    columns = [pairs.rest, pairs.deformed] + [np.c_[pairs.weights]] * has_weights
    for label, numbers in zip(pairs.labels, np.hstack(columns).tolist()):
        write_row([label] * has_labels + numbers)


def write(file, landmarks):
    """Write points as antsApplyTransformsToPoints reads them, without those not placed."""
    write_row = _row_writer(file)
    write_row(["x", "y", "z", "t", "label", "comment"])
    for i in np.flatnonzero(landmarks.is_placed).tolist():
        position = landmarks.positions[i].tolist()
        write_row([*position, 0, landmarks.labels[i], landmarks.descriptions[i]])
    return int((~landmarks.is_placed).sum())


def rewrite(path, file, positions, space):
    """Write a table again, with other positions, of pairs the first ones.

    Points at NaN are marked as not placed in tables of BigWarp and 3D Slicer, and left out of
    others.
    """
    table, left_out = _open(path), 0
    write_row = _row_writer(file, table.mark)
    if table.header:
        write_row(table.header)
    if table.layout is not None:
        positions = positions * signs(table.layout.frame or space)
    for (_, row), position in zip(_points(path, table), positions):
        if _set_position(table.layout, row, position):
            write_row(row)
        else:
            left_out += 1
    return left_out


class _Table(NamedTuple):
    """The text of a table.

    `mark` separates the cells of a new file; `rows` are (line number, cells) without the header.
    """

    mark: str
    layout: table_layouts.Layout | None
    header: list
    rows: list


def _open(path):
    with path.open(newline="", encoding="utf-8-sig") as file:
        text = _with_closed_quotes(file.readlines())
    lines = [line if '"' in line else line.partition("#")[0] for line in text]
    mark = _mark(lines)
    begin = next((i for i, line in enumerate(lines) if line.strip()), len(lines))
    comments = [
        (number, cells)
        for number, line in enumerate(text[:begin], 1)
        for _, cells in _split(path, [line.partition("#")[2]], mark)
    ]
    rows = list(_split(path, lines, mark))
    layout, start = table_layouts.find(path, comments, rows)
    return _Table(mark.replace(";", ","), layout, rows[0][1] if start else [], rows[start:])


def _points(path, table):
    """(line number, cells) of each point."""
    for number, row in table.rows:
        if len(row) != table.layout.width:
            raise table.layout.error(path, number, row)
        yield number, row


def _rows_at(path, table, time, is_alone):
    """(line number, cells) of the points of the last time that is not after `time`.

    All points without a column of times, or without `time` if the points are landmarks, which may
    have several times.
    """
    rows = list(_points(path, table))
    if table.layout.time is None or (time is None and not is_alone):
        return rows
    row_times = [_time(path, table.layout, number, row) for number, row in rows]
    if time is None and len({*row_times}) > 1:
        raise ValueError(
            f"`{path}` has control points at {len({*row_times})} times; `vtk-mls deform` and "
            "MLSControlPoints take them, here give those of one time"
        )
    steps = sorted({*row_times})
    step = steps[step_at(steps, time)]
    return [row for row, row_time in zip(rows, row_times) if row_time == step]


def _time(path, layout, number, row):
    (time,) = _numbers(path, layout, number, row, [layout.time])
    if not math.isfinite(time):
        raise ValueError(f"`{path}`, line {number}: its time must be finite, got {time}")
    return time


def _check_has_pairs(path, layout, number, row):
    """Raise if a table without q has no header, or may have q under another name."""
    if layout.partner is None and layout.unused:
        raise ValueError(
            f"`{path}`: it is not clear what the columns {layout.unused} are; call them qx,qy,qz "
            "if the points go there, dx,dy,dz if they go as far, or leave them out"
        )
    if layout.expected == table_layouts.POSITIONS:
        raise table_layouts.Layout(0, ()).error(path, number, row)


def _pair(path, layout, number, row):
    """p and q of a row: NaN if not placed or not active; q is None in a table of positions."""
    if layout.defined is not None and row[layout.defined].strip().lower() in _UNDEFINED:
        return _NOWHERE, _NOWHERE
    activity = "true" if layout.active is None else row[layout.active].strip().lower()
    if activity not in _BOOLEANS:
        raise layout.error(path, number, row)
    is_active = _BOOLEANS[activity]
    if not is_active and layout.partner is None:
        return _NOWHERE, _NOWHERE
    p = _numbers(path, layout, number, row, layout.position)
    q = layout.partner and _numbers(path, layout, number, row, layout.partner)
    is_finite = all(map(math.isfinite, p))
    if is_active and not (is_finite and all(map(math.isfinite, q or ()))):
        raise ValueError(f"`{path}` has a coordinate that is not a finite number in line {number}")
    if layout.is_offset:
        q = [start + offset for start, offset in zip(p, q)]
    return p if is_finite else _NOWHERE, q if is_active else _NOWHERE


def _numbers(path, layout, number, row, columns):
    numbers = table_layouts.numbers([row[column] for column in columns])
    if not numbers:
        raise layout.error(path, number, row)
    return numbers


def _set_position(layout, row, position):
    """Change the position of a row; False if it is NaN and the table cannot say that."""
    is_placed = np.isfinite(position).all()
    if not is_placed and layout.active is None and layout.defined is None:
        return False
    if layout.defined is not None:
        row[layout.defined] = "1" if is_placed else "0"
    if layout.active is not None and not is_placed:
        row[layout.active] = "false"
    if is_placed:
        cells = map(repr, position.tolist())
    elif layout.active is not None and layout.partner:
        cells = 3 * ["Infinity"]
    else:
        return True
    for column, cell in zip(layout.position, cells):
        row[column] = cell
    return True


def _row_writer(file, mark=","):
    """A function that writes cells as a line; blanks as `mark` mean that cells are never quoted."""
    plain, quoting = (
        csv.writer(file, delimiter=mark, lineterminator="\n", quoting=quoting)
        for quoting in (csv.QUOTE_MINIMAL, csv.QUOTE_ALL)
    )

    def write_row(row):
        if mark == " ":
            file.write(" ".join(row) + "\n")
        else:
            has_comment = any("#" in cell for cell in row if isinstance(cell, str))
            (quoting if has_comment else plain).writerow(row)

    return write_row


def _split(path, lines, mark):
    """(number of its last line, cells) of each row that is not blank."""
    rows = csv.reader(lines, delimiter="," if mark == " " else mark)
    try:
        for row in rows:
            if any(cell.strip() for cell in row):
                if mark in (";", "\t"):
                    row = [_with_point(cell) for cell in row]
                yield rows.line_num, row if len(row) > 1 else row[0].split()
    except csv.Error as error:
        raise ValueError(f"`{path}`, line {rows.line_num}: {error}") from None


def _mark(lines):
    """The separator of cells: semicolon, tab, comma or blank."""
    filled = [line.strip("\r\n") for line in lines if line.strip()]
    first = filled[0] if filled else ""
    if _are_cells(first.split(";")):
        return ";"
    cells = first.split("\t")
    is_tabbed = _are_cells(cells) and all(cell.strip(", ") == cell.strip() for cell in cells)
    if is_tabbed and all(cells[1:]) and len({line.count("\t") for line in filled}) == 1:
        return "\t"
    return "," if any("," in line for line in filled) else " "


def _are_cells(cells):
    """Whether these can be the cells of a line, each with one decimal comma at most."""
    return len(cells) > 2 and all(cell.count(",") <= 1 for cell in cells)


def _with_closed_quotes(lines):
    """The lines of a file, without the quotation marks of a header in which one is missing.

    An example is `"Label","Use","X","Y","Z,"X1","Y1","Z1"` of flybrains, for BigWarp.
    """
    start = next((i for i, line in enumerate(lines) if line.strip()), None)
    if start is None or lines[start].count('"') % 2 == 0:
        return lines
    names = lines[start].replace('"', "")
    row = next(csv.reader(lines[start + 1 : start + 2]), [])
    if len(names.split(",")) == len(row) > 2:
        return [*lines[:start], names, *lines[start + 1 :]]
    return lines


def _with_point(cell):
    """A cell with a decimal point, if it is a number with a decimal comma."""
    number = cell.replace(",", ".")
    return number if table_layouts.is_number(number) else cell
