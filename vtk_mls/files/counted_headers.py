"""Headers 0,1,2,.. as pandas and R write them for columns without names, and index columns.

A first row of the integers 0, 1, 2, .. is a header if what is below it tells so, for it can be the
point (0, 1, 2) or the pair (0, 1, 2) and (3, 4, 5), too:

- its first cell is empty, or `index` or the like, and the others are counted: the first column is
  the index, or labels, and no row below has none;
- every row below has one cell more, an index or a label;
- a column has texts in every row below;
- no row below has an integer, as in all tables of floats that one program has written.

Otherwise it is an error.
"""

from __future__ import annotations

import re

_CORNERS = ("", "index", "id", "label", "name", "unnamed: 0")


def has_counted_header(rows):
    """Whether the first row counts the columns.

    Parameters
    ----------
    rows : list of lists of str

    Raises
    ------
    ValueError
        If it cannot be known. The sentence continues one that begins with the row.
    """
    (first, *rest), has_corner = rows, _has_corner(rows)
    names = [cell.strip() for cell in first[has_corner:]]
    if len(names) < 3 or not (_is_counted(names) or (has_corner and _is_rising(names, rest))):
        return False
    if has_corner:
        is_header = bool(rest) and all(row[0].strip() for row in rest)
    else:
        is_header = bool(rest) and (
            is_wider(first, rest) or _has_text_column(rest) or not _has_integers(rest)
        )
    if not is_header:
        raise ValueError(
            "can be a header that counts the columns, as pandas writes it, or the first point; put "
            "a header px,py,pz,qx,qy,qz or x,y,z above the first point"
        )
    return True


def has_index(rows):
    """Whether the first column is of numbers or labels of the rows, given that row 0 is a header.

    Parameters
    ----------
    rows : list of lists of str
    """
    return _has_corner(rows) or is_wider(rows[0], rows[1:])


def is_number(cell):
    """Whether a cell is a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def is_wider(header, rows):
    """Whether each row has one cell more than the header."""
    return bool(rows) and all(len(row) == len(header) + 1 for row in rows)


def is_numbered(rows):
    """Whether the first cells of at least two rows are 0, 1, 2, .. or 1, 2, 3, .."""
    cells = [row[0].strip() for row in rows]
    return len(rows) > 1 and any(
        cells == [str(start + i) for i in range(len(cells))] for start in (0, 1)
    )


def _has_corner(rows):
    return rows[0][0].strip().lower() in _CORNERS


def _is_counted(names):
    return names == [str(i) for i in range(len(names))]


def _is_rising(names, rows):
    """Whether these are some of the columns of a larger table, above numbered rows."""
    if not all(re.fullmatch(r"\d{1,9}", name) for name in names) or not is_numbered(rows):
        return False
    numbers = [int(name) for name in names]
    return numbers == sorted(set(numbers))


def _has_text_column(rows):
    width = min(map(len, rows))
    return any(all(row[i].strip() and not is_number(row[i]) for row in rows) for i in range(width))


def _has_integers(rows):
    return any(re.fullmatch(r"[-+]?\d+", cell.strip()) for row in rows for cell in row)
