"""The layout of a table of points: which columns are positions, labels, weights.

A layout comes from the names in a header (see `column_names`) or, without them, from the first row.

Headers 0,1,2,.. are those of pandas and R for columns without names. A first row of the integers
0, 1, 2, .. can also be the point (0, 1, 2) or the pair (0, 1, 2) and (3, 4, 5). It is a header if

- its first cell is empty, or `index` or the like, and the others are counted: the first column is
  an index or a label, and no row below lacks it;
- every row below has one cell more, an index or a label;
- a column has text in every row below;
- no row below has an integer, as in tables of floats written by one program.

Otherwise the table is refused.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from vtk_mls.files import column_names
from vtk_mls.files.landmarks import shortened

PAIRS = "numbers px,py,pz,qx,qy,qz[,weight], as many in each line"
POSITIONS = "numbers x,y,z, as many in each line"
_BIGWARP = "name,active,x,y,z,u,v,w with `true` or `false` and numbers"
_MAX_NAMED = 100  # columns of a row whose error asks for a header
_INDEX_NAMES = ("", "index", "id", "label", "name", "unnamed: 0")


@dataclass(frozen=True)
class Layout:
    """Columns of a table, by index.

    Attributes
    ----------
    width : int
        Number of cells in each row.
    position : (x, y, z)
    partner : (x, y, z) or None
        Of q or, if `is_offset`, of q - p.
    weight, label, description, defined, active, time : int or None
    frame : str
        As in `frames.signs`; "" if the header does not say it.
    expected : str
        What a row must be, for errors.
    unused : str
        Names of columns that could be another position.
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
    time: int | None = None
    frame: str = ""
    expected: str = PAIRS
    unused: str = ""

    def error(self, path, number, row):
        """The error of a row that does not have this layout."""
        return ValueError(
            f"`{path}`, line {number}: expected {self.expected}, got {shortened(','.join(row))}"
        )


def find(path, comments, rows):
    """The layout of a table.

    Parameters
    ----------
    path : path
        For errors.
    comments, rows : lists of (line number, cells)
        Comments before the first row, and all rows.

    Returns
    -------
    layout : Layout or None
        None without points.
    start : int
        Index of the first point in `rows`.

    Raises
    ------
    ValueError
    """
    if not rows:
        return None, 0
    (number, header), *below = rows
    cells = [row for _, row in below]
    start, has_index, layout, problem = 0, False, None, ""
    if not any(map(is_number, header)):
        start, has_index = 1, _has_index(header, cells)
        try:
            layout = _named([""] * (has_index and _are_wider(header, cells)) + header)
        except ValueError as error:
            problem = f"`{path}`, line {number}: {error}"
        if layout and layout.label is None and has_index and not _have_number_first(cells):
            layout = replace(layout, label=0)
    else:
        layout = _commented(comments, len(header))
        if layout is None and _is_counted_header(path, rows):
            start, has_index = 1, _has_index_name(header) or _are_wider(header, cells)
    if layout is None and rows[start:]:
        if problem and any(map(is_number, rows[start][1])):
            raise ValueError(problem)
        layout = _unnamed(path, rows[start:], has_index)
        if has_index and not _have_number_first(cells):
            layout = replace(layout, label=0)
    return layout, start


def is_number(cell):
    """Whether a cell is a number."""
    return bool(numbers([cell]))


def numbers(cells):
    """The numbers in cells; an empty list if one is not a number."""
    try:
        return [] if any("_" in cell for cell in cells) else [float(cell) for cell in cells]
    except ValueError:
        return []


def _named(header):
    """The layout of a header; None without names of positions."""
    names = [name.strip().lower() for name in header]

    def first(*choices):
        return next((names.index(name) for name in choices if name in names), None)

    active = first("use", "active")
    columns = column_names.interpreted(header, active is not None)
    if columns is None:
        return None
    position = column_names.joined(header, columns.position)
    return Layout(
        len(header),
        columns.position,
        columns.partner,
        is_offset=columns.is_offset,
        weight=first("weight"),
        label=first("label", "name"),
        description=first("description", "comment"),
        defined=first("defined"),
        active=active,
        time=first("time"),
        frame=columns.frame,
        expected=f"{len(header)} cells in each line, with numbers in {position}",
        unused="; ".join(column_names.joined(header, triple) for triple in columns.unused),
    )


def _commented(comments, width):
    """The layout of the last comment before the rows, if it is a header of this width."""
    try:
        layout = _named(comments[-1][1]) if comments else None
    except ValueError:  # it need not be a header
        return None
    return layout if layout and layout.width == width else None


def _unnamed(path, rows, has_index):
    """The layout of rows without names, from the first one."""
    number, row = rows[0]
    layout = _layout_of_row(path, number, row, has_index)
    if layout is None:
        error = Layout(len(row), ()).error(path, number, row)
        has_positions = len(row) < _MAX_NAMED and sum(map(is_number, row)) > 2
        question = ": which column is what? name them in a header above"
        raise ValueError(f"{error}{question * has_positions}")
    if layout.weight == 6:
        _check_no_index(path, [cells for _, cells in rows])
    return layout


def _check_no_index(path, rows):
    """Raise ValueError if one of 7 columns can be an index."""
    columns = [*zip(*(row for row in rows if len(row) == 7))]
    first, *others, last = columns
    is_index = len(set(first)) == len(first) > 1 and _are_integers(first)
    if _are_numbered(rows) or (is_index and not any(map(_are_integers, others))):
        name, meaning = "first", "an index or x"
    elif _are_numbered([[cell] for cell in last]):
        name, meaning = "last", "an index or a weight"
    else:
        return
    raise ValueError(
        f"`{path}`: the {name} of 7 columns has whole numbers, and can be {meaning}; which is it? "
        "put a header above, such as px,py,pz,qx,qy,qz,weight or index,px,py,pz,qx,qy,qz"
    )


def _layout_of_row(path, number, row, has_index):
    cells, columns = row[has_index:], tuple(range(len(row)))[has_index:]
    if len(cells) in (6, 8) and cells[1].strip().lower() in ("true", "false"):
        if len(cells) == 6:
            raise ValueError(
                f"`{path}`, line {number}: this is a landmark of BigWarp in two dimensions; it "
                "must have three"
            )
        position, partner = columns[2:5], columns[5:]
        label, active = columns[:2]
        return Layout(len(row), position, partner, label=label, active=active, expected=_BIGWARP)
    start = 0 if numbers(cells[:1]) else 1
    count = len(numbers(cells[start:]))
    if count not in (3, 6, 7):
        return None
    return Layout(
        len(row),
        columns[start : start + 3],
        columns[start + 3 : start + 6] if count > 3 else None,
        weight=columns[-1] if count == 7 else None,
        label=columns[0] if start else None,
        expected=POSITIONS if count == 3 else PAIRS,
    )


def _has_index(header, rows):
    """Whether the first column below a header of names is an index or a label."""
    if header[0].strip() == "":
        return True
    is_index = _are_numbered(rows) or not _have_number_first(rows)
    return len(header) > 2 and _are_wider(header, rows) and is_index


def _are_wider(header, rows):
    """Whether each row has one cell more than the header."""
    return bool(rows) and all(len(row) == len(header) + 1 for row in rows)


def _are_numbered(rows):
    """Whether the first cells of at least two rows are 0, 1, 2, .. or 1, 2, 3, .."""
    cells = [row[0].strip() for row in rows]
    return len(rows) > 1 and any(
        cells == [str(start + i) for i in range(len(cells))] for start in (0, 1)
    )


def _have_number_first(rows):
    return any(is_number(row[0]) for row in rows)


def _is_counted_header(path, rows):
    """Whether the first row is a header 0,1,2,.. (see above)."""
    (number, header), *below = rows
    cells, has_name = [row for _, row in below], _has_index_name(header)
    names = [cell.strip() for cell in header[has_name:]]
    is_counted = names == [str(i) for i in range(len(names))]
    if len(names) < 3 or not (is_counted or (has_name and _is_rising(names, cells))):
        return False
    if has_name:
        is_header = all(row[0].strip() for row in cells)
    else:
        is_header = (
            _are_wider(header, cells) or _have_text_column(cells) or not _have_integers(cells)
        )
    if not cells or not is_header:
        raise ValueError(
            f"`{path}`, line {number}: {shortened(','.join(header))} can be a header that counts "
            "the columns, as pandas writes it, or the first point; put a header "
            "px,py,pz,qx,qy,qz or x,y,z above the first point"
        )
    return True


def _has_index_name(header):
    return header[0].strip().lower() in _INDEX_NAMES


def _is_rising(names, rows):
    """Whether the names are a selection of the columns of a larger table, above numbered rows."""
    if not all(re.fullmatch(r"\d{1,9}", name) for name in names) or not _are_numbered(rows):
        return False
    indices = [int(name) for name in names]
    return indices == sorted(set(indices))


def _have_text_column(rows):
    width = min(map(len, rows), default=0)
    return any(all(row[i].strip() and not is_number(row[i]) for row in rows) for i in range(width))


def _have_integers(rows):
    return any(_are_integers([cell]) for row in rows for cell in row)


def _are_integers(cells):
    """Whether all cells are integers."""
    return all(re.fullmatch(r"[-+]?\d+", cell.strip()) for cell in cells)
