"""The lists of control points of a proxy, with edits that wait for Apply, as rows."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from vtk_mls.files import control_point_files
from vtk_mls.filters.control_points import lattice
from vtk_mls.paraview.server_manager import elements

LISTS = ("RestPoints", "DeformedPoints", "Weights")
DRAGGED = {"deformed": "DeformedPoints", "rest": "RestPoints"}  # by what *Drag* says
_FILES = ("FileName", "DeformedFileName", "Space")
LAYING = ("Mode", "LatticeDimensions", "Bounds", *_FILES)


def lists(proxy):
    """The pending elements of all lists."""
    return [elements(proxy.GetProperty(name)) for name in LISTS]


def pending(changed):
    """The pending rows of a list property: (n, columns)."""
    values = elements(changed)
    columns = 1 if changed.GetXMLName() == "Weights" else 3
    return np.reshape(values, (-1, columns)).astype(float)


def set_pending(changed, rows):
    changed.SetUncheckedElements(np.ravel(rows).tolist(), rows.size)


def first_difference(before, after):
    """The first row in which `after`, which is not shorter, differs from `before`."""
    differs = (before != after[: len(before)]).any(axis=1)
    return int(differs.argmax()) if differs.any() else len(before)


def is_one_edit(before, after):
    """Whether rows were only added to `before`, all at one place, or only removed from it."""
    if len(after) < len(before):
        return np.count_nonzero(kept(before, after)) == len(after)
    first, count = first_difference(before, after), len(after) - len(before)
    return np.array_equal(np.delete(after, slice(first, first + count), axis=0), before)


def kept(before, after):
    """Which rows of `before` are, in their order, those of `after`: bool."""
    are_kept, found = np.zeros(len(before), bool), 0
    for number, row in enumerate(before):
        if found < len(after) and (row == after[found]).all():
            are_kept[number] = True
            found += 1
    return are_kept


def layout(proxy):
    """p, q and weights of the lattice or the file that pending edits ask for; None without."""
    mode = proxy.GetProperty("Mode")
    mode = mode.GetUncheckedElement(0) if mode else "lattice"
    with suppress(ValueError, OSError):  # Apply will say it, and the file may be the server's
        if mode == "file":
            named = (proxy.GetProperty(name) for name in _FILES)
            rest, deformed, weights = control_point_files.read(
                *(elements(each)[0] for each in named)
            )
            return rest, deformed, np.empty(0) if weights is None else weights
        if mode == "lattice":
            positions = lattice(elements(proxy.GetProperty("LatticeDimensions")), _bounds(proxy))
            return positions, positions, np.empty(0)
    return None


def _bounds(proxy):
    """Bounds for a lattice: the property's, or those of the input."""
    if proxy.GetProperty("Bounds"):
        return elements(proxy.GetProperty("Bounds"))
    source = proxy.GetProperty("Input")
    data = source.GetProxy(0).GetDataInformation(source.GetOutputPortForConnection(0))
    return data.GetBounds()
