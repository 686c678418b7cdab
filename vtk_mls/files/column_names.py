"""The names in the header of a table: which columns are p and q, and in which frame.

Three columns that differ by x, y and z are a position: `x y z`, `px py pz`, `x_moving y_moving
z_moving`, `new_x new_y new_z`. The rest of their names, the qualifier, says which position.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from vtk_mls.files.landmarks import shortened

# Qualifiers of rest positions, of deformed positions, and of displacements.
_STARTS = ("p", "rest", "moving", "source", "old", "before", "pre")
_ENDS = ("q", "deformed", "moved", "fixed", "target", "new", "after", "post")
_OFFSETS = ("displacement", "d", "delta")
_PLAIN = ("points", "RAS", "LPS", "")
_NUMBERED = ({"0", "1"}, {"1", "2"})  # x1 y1 z1 x2 y2 z2
# Positions with other names than x, y and z.
_WHOLE = {"RAS": ("r", "a", "s"), "LPS": ("l", "p", "s")}
_UNCLEAR = {"uvw": ("u", "v", "w"), "napari": ("axis_0", "axis_1", "axis_2")}  # z y x in napari
_NO_QUALIFIERS = ("mm", "pos", "position")
_COMPONENT = re.compile(r"(points|displacement)_?([012])")  # of ParaView


@dataclass(frozen=True)
class Columns:
    """Columns of a table, by index.

    Attributes
    ----------
    position : (x, y, z)
    partner : (x, y, z) or None
        Of q or, if `is_offset`, of q - p.
    frame : str
        As in `frames.signs`; "" if the names do not say it.
    unused : tuple of (x, y, z)
        Other columns that can be positions.
    """

    position: tuple
    partner: tuple | None
    is_offset: bool
    frame: str
    unused: tuple


def interpreted(header, has_switch):
    """The columns of a table.

    Parameters
    ----------
    header : list of str
    has_switch : bool
        Whether the table has BigWarp's column of active landmarks. Only then u, v, w are a
        position.

    Returns
    -------
    Columns or None
        None without names of positions.

    Raises
    ------
    ValueError
        If names are missing, duplicate or unclear.
    """
    groups = _groups(header)
    triples = {
        qualifier: tuple(columns[axis][0] for axis in "xyz")
        for qualifier, columns in groups.items()
        if len(columns) == 3
    }
    start, end = _pair({*triples}, has_switch)
    if start is None:
        start = _only_position(header, triples)
    _check_complete(header, groups, start)
    if start is None:
        return None
    used = {start, end} - {None}
    _check_single(header, [groups[qualifier] for qualifier in {*used, *_ENDS} & {*groups}])
    used_columns = {column for qualifier in used for column in triples[qualifier]}
    return Columns(
        triples[start],
        None if end is None else triples[end],
        end in _OFFSETS,
        start if start in _WHOLE else "",
        tuple(triple for triple in triples.values() if not used_columns & {*triple}),
    )


def joined(header, columns):
    """Names of columns, for a sentence."""
    return ", ".join(header[column].strip().lower() for column in columns)


def _groups(header):
    """Columns by qualifier and axis: {qualifier: {axis: [column, ...]}}."""
    groups = {}
    for column, name in enumerate(header):
        for qualifier, axis in _parts(name):
            groups.setdefault(qualifier, {}).setdefault(axis, []).append(column)
    return groups


def _parts(name):
    """The possible (qualifier, axis) of a name."""
    words = [word for word in re.findall(r"[a-z0-9]+", name.lower()) if word not in _NO_QUALIFIERS]
    text = "_".join(words)
    component = _COMPONENT.fullmatch(text)
    if component:
        return [(component[1], "xyz"[int(component[2])])]
    parts = [
        (qualifier, "xyz"[names.index(text)])
        for qualifier, names in {**_WHOLE, **_UNCLEAR}.items()
        if text in names
    ]
    axes = [word for word in words if word in ("x", "y", "z")]
    if len(axes) == 1:
        words.remove(axes[0])
        parts.append(("_".join(words), axes[0]))
    elif len(words) == 1:
        parts += [(text[1:], text[0])] if text[0] in "xyz" else []
        parts += [(text[:-1], text[-1])] if text[-1] in "xyz" else []
    return parts


def _pair(qualifiers, has_switch):
    """The qualifiers of p and q, or None and None."""
    if {"p", "q"} <= qualifiers:
        return "p", "q"
    starts = [name for name in _STARTS if name in qualifiers]
    ends = [name for name in _ENDS if name in qualifiers]
    offsets = [name for name in _OFFSETS if name in qualifiers]
    numbers = {name for name in qualifiers if name.isdigit()}
    is_plain = not starts
    starts += [name for name in _PLAIN if name in qualifiers][:1] if is_plain else []
    if not starts and not ends and numbers in _NUMBERED:
        return tuple(sorted(numbers))
    if len(starts) != 1:
        return None, None
    if is_plain and "fixed" in ends:  # a position without a qualifier need not be the moving one
        return None, None
    if not ends and is_plain and numbers in ({"1"}, {"2"}):
        ends = [*numbers]
    if not ends and has_switch and "uvw" in qualifiers:
        ends = ["uvw"]
    ends = ends or offsets
    return (starts[0], ends[0]) if len(ends) == 1 else (None, None)


def _only_position(header, triples):
    """The qualifier of the positions of a table without pairs."""
    qualifiers = [name for name in ("p", *_PLAIN) if name in triples]
    if qualifiers:
        return qualifiers[0]
    if len(triples) == 1 and not {*triples} & {*_OFFSETS, *_UNCLEAR}:
        return next(iter(triples))
    if triples:
        names = "; ".join(joined(header, triple) for triple in triples.values())
        raise ValueError(
            f"it is not clear which positions the columns {names:.120} are; call those at rest "
            "px,py,pz and the moved ones qx,qy,qz, or single ones x,y,z"
        )
    return None


def _check_complete(header, groups, start):
    """Raise ValueError if a position or displacement has only some of its columns."""
    partners = ("displacement", *_ENDS)
    for qualifier in (*_STARTS, *_PLAIN, *partners) if start is None else partners:
        count = len(groups.get(qualifier, ()))
        is_certain = start is not None and qualifier in ("q", "displacement")
        if count == 2 or (count == 1 and is_certain):
            raise ValueError(
                f"expected columns {', '.join(_names(qualifier))}, got "
                + shortened(",".join(header).lstrip(","))
            )


def _names(qualifier):
    """Names of the three columns with this qualifier."""
    if qualifier in _WHOLE:
        return _WHOLE[qualifier]
    if qualifier in ("points", "displacement"):
        return [f"{qualifier.capitalize()}:{number}" for number in range(3)]
    return [f"{axis}_{qualifier}" if qualifier[1:] else qualifier + axis for axis in "xyz"]


def _check_single(header, groups):
    """Raise ValueError if there are several columns for one axis."""
    names = {
        header[column].strip().lower()
        for axes in groups
        for columns in axes.values()
        if len(columns) > 1
        for column in columns
    }
    if names:
        raise ValueError(f"several columns are {', '.join(sorted(names))}")
