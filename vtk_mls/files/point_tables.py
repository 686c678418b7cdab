"""Tables of points in text, one in a line: of positions, or of pairs p and q.

Cells are separated by commas, tabs or, in lines without these, by blanks; or by semicolons, as
spreadsheets do where the comma is the decimal mark, which it may then be (also between tabs). A
first line without a number is a header. What follows a # is skipped, in lines without quotation
marks, but for a header that is the last such line before the points. What the columns are is said
by the names in a header, in any order and letters of any case (see `column_names`):

    px py pz qx qy qz           control points
    x_moving .. x_fixed ..      and other names of both: rest and deformed, source and target, ...
    x y z x1 y1 z1              positions, and where they go; also x y z new_x new_y new_z
    x y z dx dy dz              positions, and how far they go, q - p
    Points:0 .. Displacement:0  those that ParaView has written, q - p; without it, positions
    r a s  or  l p s            3D Slicer's table of control points, which so says its frame
    x y z                       positions, also those of ITK and ANTs (x,y,z,t,label,comment)

with `weight`, `label` or `name`, `description` or `comment`, `defined` (0: not placed), and `use`
or `active` (false: the line does not count) beside them, and others that do not matter. Columns
that may be a second position (x,y,z,u,v,w) are an error in files of control points. Without a
header, or with names that are none of these, all lines must be alike and one of

    px,py,pz,qx,qy,qz           control points; a seventh number is the weight
    x,y,z                       positions
    label,...                   either of them after a label that is no number
    name,active,x,y,z,u,v,w     BigWarp's landmarks, with `true` or `false` as the second

The header 0,1,2,.. of pandas, with or without an index column, is told from a first point by what
is below it (see `counted_headers`). An index column, whose name is empty, does not count.

BigWarp's first position is in the moving image, the second in the target, and the moving image is
what it deforms: p is the first, q the second. Lines that are not active do not count.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace

import numpy as np

from vtk_mls.base.messages import warn
from vtk_mls.files import column_names, counted_headers
from vtk_mls.files.counted_headers import is_number, is_numbered, is_wider
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, shortened

_BOOLEANS, _NOT = {"true": True, "1": True, "false": False, "0": False}, ("0", "", "false")
_PAIRS = "numbers px,py,pz,qx,qy,qz[,weight], as many in each line"
_POSITIONS = "numbers x,y,z, as many in each line"
_LANDMARKS = "name,active,x,y,z,u,v,w with `true` or `false` and numbers"


@dataclass(frozen=True)
class _Layout:
    """What the columns of a table are, by number.

    Attributes
    ----------
    width : int
        Numbers of cells in each line.
    position : (x, y, z)
    partner : (x, y, z) or None
        Of q, or, if `is_offset`, q - p.
    weight, label, description, defined, active : int or None
    frame : str
    expected : str
        What a line must be, for errors.
    unused : str
        Names of columns that may be another position, and do not count.
    """

    width: int
    position: tuple
    partner: tuple | None = None
    is_offset: bool = False
    weight: int | None = None
    label: int | None = None
    description: int | None = None
    defined: int | None = None
    active: int | None = None
    frame: str = ""
    expected: str = _PAIRS
    unused: str = ""

    def behind_an_index(self):
        """The same if there is one column more before the others."""
        roles = ("weight", "label", "description", "defined", "active")
        known = {role: getattr(self, role) for role in roles}
        return replace(
            self,
            width=self.width + 1,
            position=tuple(column + 1 for column in self.position),
            partner=self.partner and tuple(column + 1 for column in self.partner),
            **{role: column + 1 for role, column in known.items() if column is not None},
        )


def read(path, is_alone=False):
    """The points of a table.

    Parameters
    ----------
    path : path
    is_alone : bool
        As of `control_point_files.read_landmarks`.

    Returns
    -------
    Landmarks
        With partners if the table has pairs.

    Raises
    ------
    ValueError
        Naming the file and the line.
    """
    table = _Table(path)
    positions, partners, weights, labels, descriptions = [], [], [], [], []
    layout = None
    for layout, number, row in table.rows():
        if is_alone and not positions:
            _check_is_told(path, layout, number, row)
        position, partner = table.pair(layout, number, row)
        positions.append(position)
        if layout.partner:
            partners.append(partner)
        if layout.weight is not None:
            weights.append(table.numbers(layout, number, row, [layout.weight])[0])
        labels.append("" if layout.label is None else row[layout.label].strip())
        descriptions.append("" if layout.description is None else row[layout.description])
    if layout is None:
        return Landmarks(path, np.empty((0, 3)))
    if layout.unused:
        warn(
            f"`{path}`: columns {layout.unused} count for nothing; "
            "control points have px,py,pz,qx,qy,qz"
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


def _check_is_told(path, layout, number, row):
    """Raise if a table without q has no header that says so, or may have q under another name."""
    if layout.partner is None and layout.unused:
        raise ValueError(
            f"`{path}`: it is not clear what the columns {layout.unused} are; call them qx,qy,qz "
            "if the points go there, dx,dy,dz if they go as far, or leave them out"
        )
    if layout.expected is _POSITIONS:
        raise ValueError(
            f"`{path}`, line {number}: expected {_PAIRS}, got {shortened(','.join(row))}"
        )


def write_pairs(file, pairs):
    """Write control points.

    Parameters
    ----------
    file : text file
    pairs : Pairs
    """
    write_row = _row_writer(file)
    has_labels, has_weights = any(pairs.labels), pairs.weights is not None
    names = ["px", "py", "pz", "qx", "qy", "qz"]
    write_row(["label"] * has_labels + names + ["weight"] * has_weights)
    columns = [pairs.rest, pairs.deformed] + [np.c_[pairs.weights]] * has_weights
    for label, numbers in zip(pairs.labels, np.hstack(columns).tolist()):
        write_row([label] * has_labels + numbers)


def write(file, landmarks):
    """Write points as antsApplyTransformsToPoints reads them.

    Parameters
    ----------
    file : text file
    landmarks : Landmarks
        Points that are not placed are left out.

    Returns
    -------
    int
        How many are left out.
    """
    write_row = _row_writer(file)
    write_row(["x", "y", "z", "t", "label", "comment"])
    for i in np.flatnonzero(landmarks.is_placed).tolist():
        position = landmarks.positions[i].tolist()
        write_row([*position, 0, landmarks.labels[i], landmarks.descriptions[i]])
    return int((~landmarks.is_placed).sum())


def rewrite(path, file, positions, space):
    """Write a table again, with other positions.

    Parameters
    ----------
    path : path
    file : text file
    positions : (n, 3) float64, LPS
        Of pairs the first ones. NaN for points that have none any more: they are marked as such in
        the tables of BigWarp (as points that are still to be set) and 3D Slicer, and left out of
        others.
    space : str
        The frame of a table that does not say its own.

    Returns
    -------
    int
        How many are left out.
    """
    table, left_out = _Table(path), 0
    positions = iter(positions)

    def write_row(row):
        if table.mark == " ":
            file.write(" ".join(row) + "\n")
        else:
            _row_writer(file, table.mark)(row)

    factors = None
    for layout, _, row in table.rows(with_header=True):
        if layout is None:
            write_row(row)
            continue
        if factors is None:
            factors = signs(layout.frame or space)
        if _put(layout, row, next(positions) * factors):
            write_row(row)
        else:
            left_out += 1
    return left_out


def _put(layout, row, position):
    """Put a row at another position, NaN for none; False if it cannot say that it has none."""
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
    """A function that writes cells as a line, in which a # is in quotation marks."""
    plain, quoting = (
        csv.writer(file, delimiter=mark, lineterminator="\n", quoting=quoting)
        for quoting in (csv.QUOTE_MINIMAL, csv.QUOTE_ALL)
    )

    def write(row):
        has_mark = any("#" in cell for cell in row if isinstance(cell, str))
        (quoting if has_mark else plain).writerow(row)

    return write


class _Table:
    """The rows of a file, and errors that name its lines."""

    def __init__(self, path):
        self._path = path
        self.mark = " "  # between cells of what is written again; a comma for a semicolon
        self._doubt = ""  # what is wrong with a header, if there are numbers below

    def rows(self, with_header=False):
        """(layout, number of the line, cells) of each point; a header, if asked for, has None."""
        comments, rows = self._cells()
        if not rows:
            return
        header, *below = [row for _, row in rows]
        start, has_index = 0, False
        if not any(map(is_number, header)):
            start, has_index = 1, _has_index(header, below)
            layout = self._named(rows[0][0], header, has_index and is_wider(header, below))
            if layout and layout.label is None and has_index and not _has_number_first(below):
                layout = replace(layout, label=0)
        else:
            layout = self._commented(comments, len(header))
            if layout is None and self._is_counted(rows):
                start, has_index = 1, counted_headers.has_index([header, *below])
        if start and with_header:
            yield None, *rows[0]
        for number, row in rows[start:]:
            if layout is None:
                if self._doubt and any(map(is_number, row)):
                    raise ValueError(self._doubt)
                layout = self._unnamed(number, row, has_index)
                if layout.weight == 6 and is_numbered([row for _, row in rows[start:]]):
                    raise ValueError(
                        f"`{self._path}`: the first of 7 columns counts the rows, and can be an "
                        "index or x; put a header above: px,py,pz,qx,qy,qz,weight, or "
                        "index,px,py,pz,qx,qy,qz"
                    )
                if has_index and not _has_number_first(below):
                    layout = replace(layout, label=0)
            if len(row) != layout.width:
                raise self._wrong(number, layout, row)
            yield layout, number, row

    def _commented(self, comments, width):
        """The layout of as many cells that the last comment before the rows says; or None."""
        layout = self._named(*comments[-1], False) if comments else None
        self._doubt = ""  # it need not be a header
        return layout if layout and layout.width == width else None

    def _is_counted(self, rows):
        """Whether the first row is the header 0,1,2,.. of pandas."""
        number, first = rows[0]
        try:
            return counted_headers.has_counted_header([row for _, row in rows])
        except ValueError as error:
            raise ValueError(
                f"`{self._path}`, line {number}: {shortened(','.join(first))} {error}"
            ) from None

    def numbers(self, layout, number, row, columns):
        """The numbers in some columns of a row."""
        found = _numbers([row[column] for column in columns])
        if not found:
            raise self._wrong(number, layout, row)
        return found

    def pair(self, layout, number, row):
        """p and q of a row, NaN where they are not placed or do not count; q None without."""
        nowhere = 3 * (math.nan,)
        if layout.defined is not None and row[layout.defined].strip().lower() in _NOT:
            return nowhere, nowhere
        activity = "true" if layout.active is None else row[layout.active].strip().lower()
        if activity not in _BOOLEANS:
            raise self._wrong(number, layout, row)
        is_active = _BOOLEANS[activity]
        if not is_active and layout.partner is None:
            return nowhere, nowhere
        p = self.numbers(layout, number, row, layout.position)
        q = layout.partner and self.numbers(layout, number, row, layout.partner)
        is_finite = all(map(math.isfinite, p))
        if is_active and not (is_finite and all(map(math.isfinite, q or ()))):
            raise ValueError(
                f"`{self._path}` has a coordinate that is not a finite number in line {number}"
            )
        if layout.is_offset:
            q = [start + offset for start, offset in zip(p, q)]
        return p if is_finite else nowhere, q if is_active else nowhere

    def _cells(self):
        """Comments before the first row, and the rows: each (number of its last line, cells)."""
        with self._path.open(newline="", encoding="utf-8-sig") as file:
            text = _with_closed_quotes(file.readlines())
        lines = [line if '"' in line else line.partition("#")[0] for line in text]
        mark = _mark(lines)
        self.mark = mark.replace(";", ",")
        begin = next((n for n, line in enumerate(lines) if line.strip()), len(lines))
        comments = [
            (number, cells)
            for number, line in enumerate(text[:begin], 1)
            for _, cells in self._split([line.partition("#")[2]], mark)
        ]
        return comments, [*self._split(lines, mark)]

    def _split(self, lines, mark):
        """(number of its last line, cells) of each row with something in it."""
        rows = csv.reader(lines, delimiter="," if mark == " " else mark)
        try:
            for row in rows:
                if any(cell.strip() for cell in row):
                    if mark in (";", "\t"):
                        row = [_with_point(cell) for cell in row]
                    yield rows.line_num, row if len(row) > 1 else row[0].split()
        except csv.Error as error:
            raise ValueError(f"`{self._path}`, line {rows.line_num}: {error}") from None

    def _named(self, number, header, lacks_corner):
        """The layout that the names in a header say; None if they are others."""
        names = [name.strip().lower() for name in header]

        def first(*choices):
            return next((names.index(name) for name in choices if name in names), None)

        active = first("use", "active")
        try:
            columns = column_names.interpreted(header, active is not None)
        except ValueError as error:
            columns = None
            self._doubt = f"`{self._path}`, line {number}: {error}"
        if columns is None:
            return None
        position = column_names.joined(header, columns.position)
        layout = _Layout(
            len(header),
            columns.position,
            columns.partner,
            is_offset=columns.is_offset,
            weight=first("weight"),
            label=first("label", "name"),
            description=first("description", "comment"),
            defined=first("defined"),
            active=active,
            frame=columns.frame,
            expected=f"{len(header)} cells as in the header, with numbers in {position}",
            unused="; ".join(column_names.joined(header, each) for each in columns.unused),
        )
        return layout.behind_an_index() if lacks_corner else layout

    def _unnamed(self, number, row, has_index):
        """The layout of a table without such names, from its first points."""
        layout = self._of_columns(number, row[has_index:])
        if layout is None:
            raise self._wrong(number, _Layout(len(row), ()), row)
        return layout.behind_an_index() if has_index else layout

    def _of_columns(self, number, row):
        """The layout of a row by what is in it; None if it is none."""
        width = len(row)
        if width in (6, 8) and row[1].strip().lower() in ("true", "false"):
            if width == 6:
                raise ValueError(
                    f"`{self._path}`, line {number}: this is a landmark of BigWarp in two "
                    "dimensions; it must have three"
                )
            return _Layout(8, (2, 3, 4), (5, 6, 7), label=0, active=1, expected=_LANDMARKS)
        start = 0 if _numbers(row[:1]) else 1
        count = width - start if _numbers(row[start:]) else 0
        if count not in (3, 6, 7):
            return None
        return _Layout(
            width,
            tuple(range(start, start + 3)),
            tuple(range(start + 3, start + 6)) if count > 3 else None,
            weight=width - 1 if count == 7 else None,
            label=0 if start else None,
            expected=_POSITIONS if count == 3 else _PAIRS,
        )

    def _wrong(self, number, layout, row):
        return ValueError(
            f"`{self._path}`, line {number}: expected {layout.expected}, got "
            + shortened(",".join(row))
        )


def _numbers(row):
    """The numbers in a row of text, or none if not all are."""
    try:
        return [] if any("_" in cell for cell in row) else [float(cell) for cell in row]
    except ValueError:
        return []


def _mark(lines):
    """What separates cells: a semicolon, a tab, a comma, or a blank."""
    filled = [line.strip("\r\n") for line in lines if line.strip()]
    first = filled[0] if filled else ""
    if _is_split(first.split(";")):
        return ";"
    cells = first.split("\t")
    is_tabbed = _is_split(cells) and all(cell.strip(", ") == cell.strip() for cell in cells)
    if is_tabbed and all(cells[1:]) and len({line.count("\t") for line in filled}) == 1:
        return "\t"
    return "," if any("," in line for line in filled) else " "


def _is_split(cells):
    """Whether these are the cells of a line, which have a decimal comma at most."""
    return len(cells) > 2 and all(cell.count(",") <= 1 for cell in cells)


def _with_closed_quotes(lines):
    """The lines of a file; names in a header of which a quotation mark is lost get none.

    As in `"Label","Use","X","Y","Z,"X1","Y1","Z1"`, which flybrains has for BigWarp.
    """
    start = next((n for n, line in enumerate(lines) if line.strip()), None)
    if start is None or lines[start].count('"') % 2 == 0:
        return lines
    names = lines[start].replace('"', "")
    row = next(csv.reader(lines[start + 1 : start + 2]), [])
    if len(names.split(",")) == len(row) > 2:
        return [*lines[:start], names, *lines[start + 1 :]]
    return lines


def _has_number_first(rows):
    return any(is_number(row[0]) for row in rows)


def _has_index(header, rows):
    """Whether the first column below a header of names is of numbers or labels of the rows."""
    if header[0].strip() == "":
        return True
    is_index = is_numbered(rows) or not _has_number_first(rows)
    return len(header) > 2 and is_wider(header, rows) and is_index


def _with_point(cell):
    """A cell with a point as decimal mark, if it is a number with a comma."""
    number = cell.replace(",", ".")
    return number if is_number(number) else cell
