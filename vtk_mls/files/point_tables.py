"""Tables of points in text, one point or pair in a line.

The names in a header say what the columns are, in any order, in upper or lower case:

    px py pz qx qy qz           control points
    x y z dx dy dz              positions, and how far they go, q - p
    x y z                       positions, also those of ITK and ANTs (x,y,z,t,label,comment)
    Points:0 .. Displacement:0  those that ParaView has written, q - p; without it, positions
    r a s  or  l p s            3D Slicer's table of control points, which so says its frame
    label use x y z x1 y1 z1    landmarks of BigWarp, whatever the names of the positions

Other columns are `weight`, `label` or `name`, `description` or `comment`, `defined` (0: not
placed), `use` or `active` (false: the line does not count), and `time`: with it control points move
in time, each line is of one time. Further columns are ignored, but three or more are an error in a
file of control points without q.

Without a header all lines must be alike and one of

    px,py,pz,qx,qy,qz           control points; a seventh number is the weight
    x,y,z                       positions
    label,...                   either of them after a label that is not a number
    name,active,x,y,z,u,v,w     BigWarp's landmarks, with `true` or `false` as the second

Cells are separated by semicolons, tabs or commas, or in lines without these, by blanks. Between
semicolons or tabs a decimal comma is read. Text after a # is skipped in lines without quotation
marks, but the last such line before the points can be the header.

BigWarp's first position is in the moving image, the second in the target, and BigWarp deforms the
moving image: p is the first, q the second.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, field

import numpy as np

from vtk_mls.base.errors import InputError, of_file
from vtk_mls.base.messages import warn
from vtk_mls.base.time_steps import step_at
from vtk_mls.files.landmarks import Landmarks, finite, numbers, shortened

# Names of three columns, and the frame that they say.
_POSITIONS = {
    ("px", "py", "pz"): "",
    ("x", "y", "z"): "",
    ("points_0", "points_1", "points_2"): "",
    ("r", "a", "s"): "RAS",
    ("l", "p", "s"): "LPS",
}
# Those of q, and whether they are q - p.
_PARTNERS = {
    ("qx", "qy", "qz"): False,
    ("dx", "dy", "dz"): True,
    ("displacement_0", "displacement_1", "displacement_2"): True,
}
_OTHERS = {  # choices, the first that a header has
    "weight": ("weight",),
    "label": ("label", "name"),
    "description": ("description", "comment"),
    "defined": ("defined",),
    "active": ("use", "active"),
    "time": ("time",),
}
_BOOLEANS = {"true": True, "1": True, "false": False, "0": False}
_UNDEFINED = ("0", "", "false")
_NOWHERE = 3 * (math.nan,)
_EXAMPLES = "name the columns in a header, as in px,py,pz,qx,qy,qz or x,y,z,dx,dy,dz"
_PAIRS = "numbers px,py,pz,qx,qy,qz[,weight], as many in each line"
_PLACES = "numbers x,y,z, as many in each line"
_BIGWARP = "name,active,x,y,z,u,v,w with `true` or `false` and numbers"


@dataclass(frozen=True)
class _Layout:
    """Columns of a table, by index; `expected` is what a row must be, for errors."""

    width: int
    position: tuple = ()
    partner: tuple | None = None
    is_offset: bool = False
    others: dict = field(default_factory=dict)  # by the names in `_OTHERS`
    frame: str = ""
    expected: str = _PAIRS
    unknown: tuple = ()  # names of further columns

    def error(self, number, row, advice=""):
        """The error of a row that does not have this layout."""
        text = shortened(",".join(row))
        return InputError(f", line {number}: expected {self.expected}, got {text}{advice}")

    def text(self, row, name, default=""):
        """The cell in one of the `others`; the default without this column."""
        return row[self.others[name]] if name in self.others else default

    def numbers(self, number, row, columns):
        found = numbers([row[column] for column in columns])
        if not found:
            raise self.error(number, row)
        return found


def times(path):
    """The different times in the column `time` of a table, sorted; () without the column."""
    with of_file(path):
        layout, rows = _open(path)
        has_times = layout is not None and "time" in layout.others
        return tuple(sorted({_time(layout, *row) for row in rows if has_times}))


def read(path, is_alone=False, time=None):
    """The `Landmarks` of a table, with partners if it has pairs; `is_alone` and `time` are as in
    `control_point_files.read_landmarks`. An InputError names the line.
    """
    layout, rows = _open(path)
    if not rows:
        return Landmarks(path, np.empty((0, 3)))
    _check_columns(path, layout, rows[0], is_alone and layout.partner is None)
    rows, weights = _rows_at(layout, rows, time, is_alone), None
    positions, partners = zip(*(_pair(layout, *row) for row in rows))
    if "weight" in layout.others:
        weights = np.ravel([layout.numbers(*row, [layout.others["weight"]]) for row in rows])
        if not (np.isfinite(weights) & (weights > 0)).all():
            raise InputError("has a weight that is not a positive number")
    return Landmarks(
        path,
        np.array(positions, dtype=np.float64),
        layout.frame,
        [layout.text(row, "label").strip() for _, row in rows],
        [layout.text(row, "description") for _, row in rows],
        np.array(partners, dtype=np.float64) if layout.partner else None,
        weights,
        are_marked="active" in layout.others,
    )


def write_pairs(file, pairs):
    has_labels, has_weights = any(pairs.labels), pairs.weights is not None
    names = ["px", "py", "pz", "qx", "qy", "qz"]
    _write_row(file, ["label"] * has_labels + names + ["weight"] * has_weights)
    columns = [pairs.rest, pairs.deformed] + [np.c_[pairs.weights]] * has_weights
    for label, row in zip(pairs.labels, np.hstack(columns).tolist()):
        _write_row(file, [label] * has_labels + row)


def has_positions_alone(path):
    """Whether a table has three columns."""
    layout, _ = _open(path)
    return layout is not None and layout.width == 3


def write(file, landmarks, are_alone=False):
    """Write points as antsApplyTransformsToPoints reads them, or their positions alone."""
    _write_row(file, ["x", "y", "z"] + ["t", "label", "comment"] * (not are_alone))
    for _, position, label, description in landmarks.placed_rows:
        _write_row(file, position + [0, label, description] * (not are_alone))


def _open(path):
    """The layout of a table, None without rows, and (line number, cells) of each point."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        text = file.readlines()
    lines = [line if '"' in line else line.partition("#")[0] for line in text]
    begin = next((i for i, line in enumerate(lines) if line.strip()), len(lines))
    comments = [line.partition("#")[2] for line in text[:begin] if line.strip()]
    if begin < len(lines) and lines[begin].count('"') % 2:  # as in tables of flybrains
        lines[begin] = lines[begin].replace('"', "")
    rows = list(_split(lines, _separator(lines[begin:])))
    if not rows:
        return None, rows
    number, first = rows[0]
    if not any(numbers([cell]) for cell in first):
        layout, rows = _named(number, first), rows[1:]
    else:
        layout = _commented(comments[-1:], len(first)) or _unnamed(rows)
    for number, row in rows:
        if len(row) != layout.width:
            raise layout.error(number, row)
    return layout, rows


def _named(number, header):
    """The layout of a header."""
    names = [name.strip().lower().replace(":", "_") for name in header]
    column = {name: i for i, name in enumerate(names)}
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise InputError(f", line {number}: several columns are {', '.join(twice)}")
    others = {
        member: column[name]
        for member, choices in _OTHERS.items()
        for name in choices[::-1]
        if name in column
    }
    if len(names) == 8 and others.get("active") == 1:
        others["label"] = 0
        return _Layout(8, (2, 3, 4), (5, 6, 7), others=others, expected=_BIGWARP)
    position, partner = (
        next((triple for triple in choices if column.keys() >= {*triple}), ())
        for choices in (_POSITIONS, _PARTNERS)
    )
    known = {*position, *partner, "t", *(name for choices in _OTHERS.values() for name in choices)}
    unknown = tuple(name for name in names if name and name not in known)
    if not position or any({*unknown} & {*triple} for triple in _PARTNERS):
        text = shortened(",".join(header))
        raise InputError(f", line {number}: the columns {text} are not known; {_EXAMPLES}")
    return _Layout(
        len(names),
        tuple(column[name] for name in position),
        tuple(column[name] for name in partner) or None,
        _PARTNERS.get(partner, False),
        others,
        frame=_POSITIONS[position],
        expected=f"{len(names)} cells in each line, with numbers in {', '.join(position)}",
        unknown=unknown,
    )


def _commented(comments, width):
    """The layout of the last comment before the rows, if it is a header of this width."""
    for _, names in _split(comments, _separator(comments)):
        try:
            layout = _named(1, names)
        except InputError:  # it need not be a header
            return None
        return layout if layout.width == width else None
    return None


def _unnamed(rows):
    """The layout of rows without names, from the first one."""
    number, row = rows[0]
    columns = tuple(range(len(row)))
    if len(row) in (6, 8) and row[1].strip().lower() in ("true", "false"):
        if len(row) == 6:
            raise InputError(
                f", line {number}: this is a landmark of BigWarp in two dimensions; it must have "
                "three"
            )
        others = {"label": 0, "active": 1}
        return _Layout(8, columns[2:5], columns[5:], others=others, expected=_BIGWARP)
    start = 0 if numbers(row[:1]) else 1
    values = row[start:]
    count = len(numbers(values))
    if count not in (3, 6, 7):
        has_positions = len(row) < 100 and sum(bool(numbers([cell])) for cell in row) > 2
        raise _Layout(len(row)).error(number, row, f"; {_EXAMPLES}" * has_positions)
    is_counted = not row[0].strip() or start == 0
    if is_counted and [cell.strip() for cell in values] == [str(i) for i in range(count)]:
        raise InputError(
            f", line {number}: {shortened(','.join(row))} can be a header that counts the columns, "
            f"or the first point; {_EXAMPLES}"
        )
    if count == 7 and start == 0:
        _check_no_index(rows)
    others = {"label": 0} if start else {}
    if count == 7:
        others["weight"] = len(row) - 1
    return _Layout(
        len(row),
        columns[start : start + 3],
        columns[start + 3 : start + 6] or None,
        others=others,
        expected=_PLACES if count == 3 else _PAIRS,
    )


def _check_no_index(rows):
    """Raise InputError if the first or the last of 7 columns counts the rows."""
    for name, column in (("first", 0), ("last", -1)):
        cells = [row[column].strip() for _, row in rows if len(row) == 7]
        if len(cells) > 1 and cells in ([str(i + k) for i in range(len(cells))] for k in (0, 1)):
            raise InputError(
                f": the {name} of 7 columns counts the rows, and can be an index, x or a weight; "
                + _EXAMPLES
            )


def _check_columns(path, layout, row, lacks_partner):
    """Raise InputError if control points lack q, and nothing says that they rest."""
    if lacks_partner and layout.expected == _PLACES:
        raise _Layout(0).error(*row)
    if len(layout.unknown) < 3:
        return
    names = shortened(",".join(layout.unknown))
    if lacks_partner:
        raise InputError(f": the columns {names} are not known; {_EXAMPLES}")
    warn(f"`{path}`: the columns {names} are ignored; control points have px,py,pz,qx,qy,qz")


def _rows_at(layout, rows, time, is_alone):
    """(line number, cells) of the points of the last time that is not after `time`.

    All points without a column of times, or without `time` if the points are landmarks, which may
    have several times.
    """
    if "time" not in layout.others or (time is None and not is_alone):
        return rows
    row_times = [_time(layout, number, row) for number, row in rows]
    if time is None and len({*row_times}) > 1:
        raise InputError(
            f"has control points at {len({*row_times})} times; `vtk-mls deform` and "
            "MLSControlPoints take them, here give those of one time"
        )
    steps = sorted({*row_times})
    step = steps[step_at(steps, time)]
    return [row for row, row_time in zip(rows, row_times) if row_time == step]


def _time(layout, number, row):
    (time,) = layout.numbers(number, row, [layout.others["time"]])
    if not math.isfinite(time):
        raise InputError(f", line {number}: its time must be finite, got {time}")
    return time


def _pair(layout, number, row):
    """p and q of a row: NaN if not placed or not active; q is None in a table of positions."""
    if layout.text(row, "defined", "1").strip().lower() in _UNDEFINED:
        return _NOWHERE, _NOWHERE
    is_active = _BOOLEANS.get(layout.text(row, "active", "true").strip().lower())
    if is_active is None:
        raise layout.error(number, row)
    if not is_active and layout.partner is None:
        return _NOWHERE, _NOWHERE
    p = layout.numbers(number, row, layout.position)
    q = layout.partner and layout.numbers(number, row, layout.partner)
    is_finite = all(map(math.isfinite, p))
    if is_active:
        finite(f"line {number}", [*p, *(q or ())])
    if layout.is_offset:
        q = [start + offset for start, offset in zip(p, q)]
    return p if is_finite else _NOWHERE, q if is_active else _NOWHERE


def _write_row(file, row):
    has_comment = any("#" in cell for cell in row if isinstance(cell, str))
    quoting = csv.QUOTE_ALL if has_comment else csv.QUOTE_MINIMAL
    csv.writer(file, lineterminator="\n", quoting=quoting).writerow(row)


def _split(lines, mark):
    """(number of its last line, cells) of each row that is not blank."""
    rows = csv.reader(lines, delimiter="," if mark == " " else mark)
    try:
        for row in rows:
            if any(cell.strip() for cell in row):
                if mark in (";", "\t"):
                    row = [_with_point(cell) for cell in row]
                yield rows.line_num, row if len(row) > 1 else row[0].split()
    except csv.Error as error:
        raise InputError(f", line {rows.line_num}: {error}") from None


def _separator(lines):
    """The separator of cells: semicolon, tab, comma or blank, by the first line."""
    first = lines[0].strip("\r\n") if lines else ""
    if first.count(";") > 1 and all(cell.count(",") < 2 for cell in first.split(";")):
        return ";"
    if first.count("\t") > 1 and ",\t" not in first:
        return "\t"
    return "," if any("," in line for line in lines) else " "


def _with_point(cell):
    """A cell with a decimal point, if it is a number with a decimal comma."""
    number = cell.replace(",", ".")
    return number if numbers([number]) else cell
