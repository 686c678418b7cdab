"""The axes of an OME-Zarr: their names, units and directions in a patient (RFC 4)."""

import numpy as np

from vtk_mls.files import frames, volumes
from vtk_mls.files.units import NANOMETERS, symbol

_AXES = "t", "c", "z", "y", "x"  # in the order of the specification


def names(entries):
    """The names of axes in lower case, as one text."""
    names = [str(entry["name"]).lower() for entry in entries]
    is_ordered = names == [name for name in _AXES if name in names]
    if not is_ordered or names[-2:] != ["y", "x"]:
        raise ValueError(
            "its axes must be t, c, z, y, x in this order, where t, c and z are optional, "
            f"got {', '.join(names)[:80]}"
        )
    return "".join(names)


def in_space(entries, image_entries):
    """Entries of axes in space with one unit, the lengths of their own units, and what is guessed.

    The unit is that of the last axis that has one. Label images take unit and orientation from the
    entries of their image, if it has some.
    """
    space = [{**entry, "name": str(entry["name"]).lower()} for entry in entries]
    if not any(map(_orientation, space)):
        stated = {axis["name"]: axis["orientation"] for axis in image_entries if _orientation(axis)}
        for axis in space:
            axis |= {"orientation": stated[axis["name"]]} if axis["name"] in stated else {}
    units = [axis.get("unit") or "" for axis in space]
    image_units = [axis.get("unit") or "" for axis in image_entries]
    unit = next(filter(None, (*image_units, *units[::-1])), "")
    missing = ", ".join(axis["name"] for axis, own in zip(space, units) if unit and not own)
    units = [own or unit for own in units]
    nanometers = [NANOMETERS.get(symbol(name)) for name in (unit, *units)]
    lengths = [1.0] * len(units)
    if {*units} != {unit} and None not in nanometers:
        lengths = [float(f"{own / nanometers[0]:.12g}") for own in nanometers[1:]]
    elif {*units} != {unit}:
        raise ValueError(
            f"its axes in space must have units of length, got {', '.join(sorted({unit, *units}))}"
        )
    if unit:
        space = [{**axis, "unit": unit} for axis in space]
    is_guess = missing and not image_entries
    return space, lengths, f"{missing} has no unit; {unit} is assumed" if is_guess else ""


def directions(space):
    """Columns (3, 3) along x, y, z in LPS (the identity if not stated), and what is guessed."""
    words = [_orientation(axis) for axis in space[::-1]]
    if not any(words):
        return np.eye(3), ""
    columns = np.zeros((3, 3))
    columns[:, : len(words)] = np.transpose([frames.direction(word) for word in words])
    columns = volumes.full_steps(columns, (2, 2, len(words) - 1))
    if np.linalg.matrix_rank(columns) == 3:
        return columns, ""
    listed = ", ".join(f"{axis['name']} {word or '?'}" for axis, word in zip(space[::-1], words))
    return np.eye(3), f"the orientation ({listed}) does not give LPS; positions are used as LPS"


def _orientation(axis):
    """What an axis states, as "left-to-right"; "" for nothing about a patient."""
    stated = axis.get("orientation") or ""
    if isinstance(stated, dict):
        stated = stated.get("value") if stated.get("type") == "anatomical" else ""
    return str(stated)
