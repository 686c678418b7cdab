"""The lists of control points of a proxy, pending edits included, as arrays of rows."""

from contextlib import suppress

import numpy as np
from vtkmodules.vtkCommonCore import vtkObject

from vtk_mls.files import control_point_files
from vtk_mls.filters.control_point_source import lattice
from vtk_mls.paraview.server_manager import EDITED, input_of, pending_value, pending_values

LISTS = ("RestPoints", "DeformedPoints", "Weights")
OTHER_LIST = {"RestPoints": "DeformedPoints", "DeformedPoints": "RestPoints"}
DRAGGED = {"deformed": "DeformedPoints", "rest": "RestPoints"}  # by the values of Drag
_FILE_PROPERTIES = ("FileName", "DeformedFileName", "Space")
LAYOUT_PROPERTIES = ("Mode", "LatticeDimensions", "Bounds", *_FILE_PROPERTIES)


def pending_lists(proxy):
    """The elements of all lists."""
    return [pending_values(proxy.GetProperty(name)) for name in LISTS]


def pending_rows(prop):
    """The rows of a list property: (n, columns) float64."""
    columns = 1 if prop.GetXMLName() == "Weights" else 3
    return np.reshape(pending_values(prop), (-1, columns)).astype(float)


def set_pending_rows(prop, rows):
    displays_warnings = vtkObject.GetGlobalWarningDisplay()
    vtkObject.SetGlobalWarningDisplay(displays_warnings and len(rows))  # of widgets without handles
    prop.SetUncheckedElements(np.ravel(rows).tolist(), rows.size)
    show_empty_list(prop)
    vtkObject.SetGlobalWarningDisplay(displays_warnings)


def show_empty_list(prop):
    """Tell ParaView's panel that a list is empty: it does not learn of that."""
    if prop.GetNumberOfUncheckedElements() == 0:
        prop.InvokeEvent(EDITED)


def first_difference(before, after):
    """The first row in which `after`, which is not shorter, differs from `before`."""
    differs = (before != after[: len(before)]).any(axis=1)
    return int(differs.argmax()) if differs.any() else len(before)


def is_one_edit(before, after):
    """Whether rows were only removed from `before`, or only added, all at one place."""
    if len(after) < len(before):
        return np.count_nonzero(remaining_rows(before, after)) == len(after)
    first, count = first_difference(before, after), len(after) - len(before)
    return np.array_equal(np.delete(after, slice(first, first + count), axis=0), before)


def remaining_rows(before, after):
    """Mask (n,) of the rows of `before` that remain in `after`, in the same order."""
    mask, count = np.zeros(len(before), bool), 0
    for index, row in enumerate(before):
        if count < len(after) and (row == after[count]).all():
            mask[index] = True
            count += 1
    return mask


def pending_layout(proxy):
    """p, q and weights of the lattice or the file that the panel selects; None without."""
    mode = pending_value(proxy, "Mode", "lattice")
    with suppress(ValueError, OSError):  # Apply reports it; the file may be on the server
        if mode == "file":
            path, deformed_path, space = (pending_value(proxy, name) for name in _FILE_PROPERTIES)
            if control_point_files.times(path, deformed_path):
                return np.empty((0, 3)), np.empty((0, 3)), np.empty(0)  # the file's, at each time
            rest, deformed, weights, *_ = control_point_files.read_pairs(path, deformed_path, space)
            return rest, deformed, np.empty(0) if weights is None else weights
        if mode == "lattice":
            dimensions = pending_values(proxy.GetProperty("LatticeDimensions"))
            positions = lattice(dimensions, lattice_bounds(proxy))
            return positions, positions, np.empty(0)
    return None


def lattice_bounds(proxy):
    """The property Bounds, or the bounds of the input."""
    if proxy.GetProperty("Bounds"):
        return pending_values(proxy.GetProperty("Bounds"))
    source, port = input_of(proxy)
    return source.GetDataInformation(port).GetBounds()
