"""Tables of points in text, one in a line: of positions, or of pairs p and q.

Cells are separated by commas or, in lines without one, by blanks; or by semicolons, as spreadsheets
do where the comma is the decimal mark, which it may then be. A first line without a number is a
header. What follows a # is skipped, in lines without quotation marks. What the columns are is
said by the names in a header, in any order and letters of any case:

    px py pz qx qy qz           control points
    Points:0 .. Displacement:0  those that ParaView has written, q - p; without it, positions
    r a s  or  l p s            3D Slicer's table of control points, which so says its frame
    x y z                       positions, also those of ITK and ANTs (x,y,z,t,label,comment)

with `weight`, `label` or `name`, `description` or `comment`, and `defined` (0: not placed) beside
them, and others that do not matter. Without a header, or with names that are none of these, all
lines must be alike and one of

    px,py,pz,qx,qy,qz           control points; a seventh number is the weight
    x,y,z                       positions
    label,...                   either of them after a label that is no number
    name,active,x,y,z,u,v,w     BigWarp's landmarks, with `true` or `false` as the second

BigWarp's first position is in the moving image, the second in the target, and the moving image is
what it deforms: p is the first, q the second. Lines that are not active do not count.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass

import numpy as np

from vtk_mls.announcements import warn
from vtk_mls.files.frames import signs
from vtk_mls.files.landmarks import Landmarks, shortened

_AXES = {  # names of the columns with positions: what file says them, and its frame
    ("px", "py", "pz"): "",
    ("points0", "points1", "points2"): "",
    ("r", "a", "s"): "RAS",
    ("l", "p", "s"): "LPS",
    ("x", "y", "z"): "",
}
_PARTNERS = ("qx", "qy", "qz")
_OFFSETS = ("displacement0", "displacement1", "displacement2")
_BOOLEANS, _NOT = ("true", "false"), ("0", "", "false", "False")
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
    idle : tuple of str
        Names of three columns that look like positions of their own, and do not count; or none.
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
    idle: tuple = ()


def read(path):
    """The points of a table.

    Parameters
    ----------
    path : path

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
    if layout.idle:
        warn(
            f"`{path}`: columns {', '.join(layout.idle)} count for nothing; "
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


def check_is_told(path):
    """Raise if a table is of three numbers in a line, with no header that calls them positions."""
    for layout, number, row in _Table(path).rows():
        if layout.expected is not _POSITIONS:
            return
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
    names = ["px", "py", "pz", *_PARTNERS]
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
    write_cells, positions = _row_writer(file), iter(positions)

    def write_row(row):
        if table.has_commas:
            write_cells(row)
        else:
            file.write(" ".join(row) + "\n")

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
    elif layout.active is not None:
        cells = 3 * ["Infinity"]
    else:
        return True
    for column, cell in zip(layout.position, cells):
        row[column] = cell
    return True


def _row_writer(file):
    """A function that writes cells as a line, in which a # is in quotation marks."""
    plain, quoting = (
        csv.writer(file, lineterminator="\n", quoting=quoting)
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
        self.has_commas = False  # so far
        self._doubt = ""  # what is wrong with a header, if there are numbers below

    def rows(self, with_header=False):
        """(layout, number of the line, cells) of each point; a header, if asked for, has None."""
        layout, is_first = None, True
        for number, row in self._cells():
            if layout is None:
                is_header = is_first and not any(_numbers([cell]) for cell in row)
                is_first = False
                if is_header:
                    layout = self._named(number, row)
                    if with_header:
                        yield None, number, row
                    continue
                if self._doubt and any(_numbers([cell]) for cell in row):
                    raise ValueError(self._doubt)
                layout = self._unnamed(number, row)
            if len(row) != layout.width:
                raise self._wrong(number, layout, row)
            yield layout, number, row

    def numbers(self, layout, number, row, columns):
        """The numbers in some columns of a row."""
        found = _numbers([row[column] for column in columns])
        if not found:
            raise self._wrong(number, layout, row)
        return found

    def pair(self, layout, number, row):
        """p and q of a row, NaN where they are not placed or do not count; q None without."""
        nowhere = 3 * (math.nan,)
        if layout.defined is not None and row[layout.defined].strip() in _NOT:
            return nowhere, nowhere
        p = self.numbers(layout, number, row, layout.position)
        q = layout.partner and self.numbers(layout, number, row, layout.partner)
        activity = "true" if layout.active is None else row[layout.active].strip().lower()
        if activity not in _BOOLEANS:
            raise self._wrong(number, layout, row)
        is_active = activity == "true"
        is_finite = all(map(math.isfinite, p))
        if is_active and not (is_finite and all(map(math.isfinite, q or ()))):
            raise ValueError(
                f"`{self._path}` has a coordinate that is not a finite number in line {number}"
            )
        if layout.is_offset:
            q = [start + offset for start, offset in zip(p, q)]
        return p if is_finite else nowhere, q if is_active else nowhere

    def _cells(self):
        """(number of its last line, cells) of each row with something in it."""
        with self._path.open(newline="", encoding="utf-8-sig") as file:
            lines = [line if '"' in line else line.partition("#")[0] for line in file]
        has_semicolons = _has_semicolons(next(filter(str.strip, lines), ""))
        rows = csv.reader(lines, delimiter=";" if has_semicolons else ",")
        try:
            for row in rows:
                if any(cell.strip() for cell in row):
                    self.has_commas |= len(row) > 1
                    if has_semicolons:
                        row = [_with_point(cell) for cell in row]
                    yield rows.line_num, row if len(row) > 1 else row[0].split()
        except csv.Error as error:
            raise ValueError(f"`{self._path}`, line {rows.line_num}: {error}") from None

    def _named(self, number, header):
        """The layout that the names in a header say; None if they are others."""
        names = [re.sub(r"[:_](?=\d$)", "", name.strip().lower()) for name in header]
        column = {name: i for i, name in enumerate(names)}

        def columns(group):
            return tuple(column[name] for name in group) if set(group) <= set(names) else None

        def first(*choices):
            return next((column[name] for name in choices if name in column), None)

        groups = (*_AXES, _PARTNERS, _OFFSETS)
        position = next((group for group in _AXES if columns(group)), None)
        for group in groups if position is None else (_PARTNERS, _OFFSETS):
            found = sum(name in column for name in group)
            if found == 2 or (found == 1 and position):
                self._doubt = (
                    f"`{self._path}`, line {number}: expected columns {', '.join(group)}, got "
                    + shortened(",".join(header))
                )
        twice = sorted({name for group in groups for name in group if names.count(name) > 1})
        if twice:
            self._doubt = f"`{self._path}`, line {number}: several columns are {', '.join(twice)}"
        if position is None or self._doubt:
            return None
        return _Layout(
            len(header),
            columns(position),
            columns(_PARTNERS) or columns(_OFFSETS),
            is_offset=columns(_PARTNERS) is None and columns(_OFFSETS) is not None,
            weight=first("weight"),
            label=first("label", "name"),
            description=first("description", "comment"),
            defined=first("defined"),
            frame=_AXES[position],
            expected=f"{len(header)} cells as in the header, with numbers in {', '.join(position)}",
            idle=_other_axes({*names} - {*position, *_PARTNERS}),
        )

    def _unnamed(self, number, row):
        """The layout of a table without such names, from its first points."""
        width = len(row)
        if width in (6, 8) and row[1].strip().lower() in _BOOLEANS:
            if width == 6:
                raise ValueError(
                    f"`{self._path}`, line {number}: this is a landmark of BigWarp in two "
                    "dimensions; it must have three"
                )
            return _Layout(8, (2, 3, 4), (5, 6, 7), label=0, active=1, expected=_LANDMARKS)
        start = 0 if _numbers(row[:1]) else 1
        count = width - start if _numbers(row[start:]) else 0
        if count not in (3, 6, 7):
            raise self._wrong(number, _Layout(width, ()), row)
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


def _other_axes(names):
    """Three names that differ by x, y and z at an end; none if there are none."""
    for name in sorted(names):
        for of_x in (r"^x", r"x(?=\d*$)"):
            axes = tuple(re.sub(of_x, axis, name) for axis in "xyz")
            if len({*axes} & names) == 3:
                return axes
    return ()


def _numbers(row):
    """The numbers in a row of text, or none if not all are."""
    try:
        return [] if any("_" in cell for cell in row) else [float(cell) for cell in row]
    except ValueError:
        return []


def _has_semicolons(line):
    """Whether these are between the cells of a line, which have a decimal comma at most."""
    cells = line.split(";")
    return len(cells) > 2 and all(cell.count(",") <= 1 for cell in cells)


def _with_point(cell):
    """A cell with a point as decimal mark, if it is a number with a comma."""
    number = cell.replace(",", ".")
    return number if _numbers([number]) else cell
