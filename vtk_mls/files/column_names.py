"""What the header of a table says: which columns are p, which q, and in which frame.

Three columns that differ by x, y and z are a position: `x y z`, `px py pz`, `x_moving y_moving
z_moving`, `new_x new_y new_z`. What remains of their names, the qualifier, says which position.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from vtk_mls.files.landmarks import shortened

# Qualifiers of positions that are moved, of those that they are moved to, and of differences.
_STARTS = ("p", "rest", "moving", "source", "old", "before", "pre")
_ENDS = ("q", "deformed", "moved", "fixed", "target", "new", "after", "post")
_OFFSETS = ("displacement", "d", "delta")
_PLAIN = ("points", "RAS", "LPS", "")
_NUMBERED = ({"0", "1"}, {"1", "2"})  # x1 y1 z1 x2 y2 z2
# Names that say more, or less, than a position in x, y and z.
_WHOLE = {"RAS": ("r", "a", "s"), "LPS": ("l", "p", "s")}
_UNCLEAR = {"uvw": ("u", "v", "w"), "napari": ("axis_0", "axis_1", "axis_2")}  # the latter z y x
_NO_QUALIFIERS = ("mm", "pos", "position")
_COMPONENT = re.compile(r"(points|displacement)_?([012])")  # of ParaView


@dataclass(frozen=True)
class Columns:
    """Columns of a table, by number.

    Attributes
    ----------
    position : (x, y, z)
    partner : (x, y, z) or None
        Of q, or, if `is_offset`, q - p.
    frame : str
        As of `frames.signs`, if the names say it.
    unused : tuple of (x, y, z)
        Others that can be positions.
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
        Whether there is a column of BigWarp's that says which landmarks count. Only beside it
        u, v, w are a position.

    Returns
    -------
    Columns or None
        None if no names are of positions.

    Raises
    ------
    ValueError
        Saying which names are missing, twice there, or unclear.
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
    taken = {column for qualifier in used for column in triples[qualifier]}
    return Columns(
        triples[start],
        None if end is None else triples[end],
        end in _OFFSETS,
        start if start in _WHOLE else "",
        tuple(triple for triple in triples.values() if not taken & {*triple}),
    )


def joined(header, columns):
    """Names of columns in a sentence."""
    return ", ".join(header[column].strip().lower() for column in columns)


def _groups(header):
    """Columns by qualifier and axis: {qualifier: {axis: [column, ...]}}."""
    groups = {}
    for column, name in enumerate(header):
        for qualifier, axis in _parts(name):
            groups.setdefault(qualifier, {}).setdefault(axis, []).append(column)
    return groups


def _parts(name):
    """The (qualifier, axis) that a name can be read as."""
    words = [word for word in re.findall(r"[a-z0-9]+", name.lower()) if word not in _NO_QUALIFIERS]
    text = "_".join(words)
    component = _COMPONENT.fullmatch(text)
    if component:
        return [(component[1], "xyz"[int(component[2])])]
    found = [
        (qualifier, "xyz"[names.index(text)])
        for qualifier, names in {**_WHOLE, **_UNCLEAR}.items()
        if text in names
    ]
    axes = [word for word in words if word in ("x", "y", "z")]
    if len(axes) == 1:
        words.remove(axes[0])
        found.append(("_".join(words), axes[0]))
    elif len(words) == 1:
        found += [(text[1:], text[0])] if text[0] in "xyz" else []
        found += [(text[:-1], text[-1])] if text[-1] in "xyz" else []
    return found


def _pair(qualifiers, has_switch):
    """The qualifiers of p and q, or None and None."""
    if {"p", "q"} <= qualifiers:
        return "p", "q"
    starts = [each for each in _STARTS if each in qualifiers]
    ends = [each for each in _ENDS if each in qualifiers]
    offsets = [each for each in _OFFSETS if each in qualifiers]
    numbers = {each for each in qualifiers if each.isdigit()}
    is_plain = not starts
    starts += [each for each in _PLAIN if each in qualifiers][:1] if is_plain else []
    if not starts and not ends and numbers in _NUMBERED:
        return tuple(sorted(numbers))
    if len(starts) != 1:
        return None, None
    if is_plain and "fixed" in ends:  # what is not said to be moving may be anything
        return None, None
    if not ends and is_plain and numbers in ({"1"}, {"2"}):
        ends = [*numbers]
    if not ends and has_switch and "uvw" in qualifiers:
        ends = ["uvw"]
    ends = ends or offsets
    return (starts[0], ends[0]) if len(ends) == 1 else (None, None)


def _only_position(header, triples):
    """The qualifier of the positions of a table without pairs."""
    known = [each for each in ("p", *_PLAIN) if each in triples]
    if known:
        return known[0]
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
    """Raise ValueError if some, not all, columns of a position or difference are there."""
    partners = ("displacement", *_ENDS)
    for qualifier in (*_STARTS, *_PLAIN, *partners) if start is None else partners:
        count = len(groups.get(qualifier, ()))
        is_told = start is not None and qualifier in ("q", "displacement")
        if count == 2 or (count == 1 and is_told):
            raise ValueError(
                f"expected columns {', '.join(_names(qualifier))}, got "
                + shortened(",".join(header))
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
    columns = [found for axes in groups for found in axes.values() if len(found) > 1]
    if columns:
        names = sorted({header[column].strip().lower() for found in columns for column in found})
        raise ValueError(f"several columns are {', '.join(names)}")
