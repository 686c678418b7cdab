"""The lists of control points of a proxy: pending edits, as arrays of rows, and the first ones.

ParaView places the handles of a filter as a lattice over the bounds of its input. If the material
does not fill the bounds, they move to the material. The handles of a source of control points move
to the bounds of the selection. Scripts outside the GUI get ParaView's lattice and default cube.
"""

from contextlib import suppress

import numpy as np
from vtkmodules.vtkCommonCore import vtkObject
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData

from vtk_mls.files import control_point_files
from vtk_mls.filters.control_point_source import lattice
from vtk_mls.paraview import undo
from vtk_mls.paraview.server_manager import (
    EDITED,
    blocks_of,
    input_data,
    input_of,
    is_remote,
    pending_value,
    pending_values,
)
from vtk_mls.rendering.surfaces import SurfaceLocator, VolumeSurface, handles_on
from vtk_mls.rendering.transfer_functions import presets_of, scalar_image
from vtk_mls.vtk import arrays

LISTS = ("RestPoints", "DeformedPoints", "Weights")
OTHER_LIST = {"RestPoints": "DeformedPoints", "DeformedPoints": "RestPoints"}
DRAGGED = {"deformed": "DeformedPoints", "rest": "RestPoints"}  # by the values of Drag
_FILE_PROPERTIES = ("FileName", "DeformedFileName", "Space")
LAYOUT_PROPERTIES = ("Mode", "LatticeDimensions", "Bounds", *_FILE_PROPERTIES)
_COUNT = 3  # first handles along each axis
_MAX_CELLS = 10**6  # of a mesh; the search for closest points takes a second
_MIN_EMPTY_SHARE = 0.5  # of the faces of an image
_BACKGROUND_RANGE = 0.02  # of the range of values


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


def place(proxy, selected=None):
    """Place the handles of a proxy with default values, unless a script has set them."""
    if proxy.GetSessionProxyManager().GetInLoadXMLState() or undo.is_running():
        return
    if proxy.GetProperty("Bounds"):
        _place_over(proxy, selected)
    elif not is_remote(proxy) and input_of(proxy):
        _place_on_material(proxy)


def _place_over(source, selected):
    """Set the cube and the lattice of a source to the bounds of the selection."""
    rest, box = source.GetProperty("RestPoints"), source.GetProperty("Bounds")
    if selected is None or not (rest.IsValueDefault() and box.IsValueDefault()):
        return
    bounds = np.array(selected.GetDataInformation().GetBounds())
    low, high = bounds[::2], bounds[1::2]
    if (low > high).any():
        return  # no data yet
    corners = np.where(pending_rows(rest) > 0, high, low)
    _set(box, bounds)
    _set(rest, list(dict.fromkeys(map(tuple, corners.tolist()))))  # fewer for flat data


def _place_on_material(proxy):
    """Move the handles of ParaView's lattice to the material of the input."""
    rest, deformed = proxy.GetProperty("RestPoints"), proxy.GetProperty("DeformedPoints")
    rows = pending_rows(rest)
    expected = lattice((_COUNT,) * 3, lattice_bounds(proxy))
    is_lattice = len(rows) == len(expected) and np.allclose(rows[np.lexsort(rows.T)], expected)
    if not (is_lattice and np.array_equal(rows, pending_rows(deformed))):
        return  # set by a script
    positions = None
    with suppress(ValueError):  # images without point values
        positions = _positions_on_material(blocks_of(input_data(proxy)))
    if positions is not None:
        _set(rest, positions)
        _set(deformed, positions)


def _positions_on_material(blocks):
    """Positions (n, 3) of handles; None if the lattice over the bounds is suitable."""
    materials = [_material_of(block) for block in blocks]
    if not materials or None in materials:
        return None
    boxes = np.array([box for _, box in materials])
    box = np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
    return handles_on([material for material, _ in materials], box, _COUNT)


def _material_of(data):
    """An object with closest points of the material, and the corners (2, 3) of a box around it.

    None for data that fill their bounds or are too large for a search.
    """
    if isinstance(data, vtkImageData):
        image = scalar_image(data)
        grid = arrays.ImageGeometry.of_image(image).grid
        values = arrays.to_numpy(image.GetPointData().GetScalars()).reshape(grid.shape)
        if not _has_empty_faces(values):
            return None
        surface = VolumeSurface(grid, values, presets_of(values.ravel(), False)[0])
        return surface, surface.bounds
    if not isinstance(data, vtkDataSet) or not 0 < data.GetNumberOfCells() <= _MAX_CELLS:
        return None
    return SurfaceLocator(data), np.reshape(data.GetBounds(), (3, 2)).T


def _has_empty_faces(values):
    """Whether most of an image's (nz, ny, nx) faces are background, such as air around a head."""
    if min(values.shape) < 2:
        return False
    ends = [np.take(values, (0, -1), axis=axis).ravel() for axis in range(3)]
    faces = np.concatenate(ends).astype(float)
    value_range = float(np.nanmax(values)) - float(np.nanmin(values))
    is_background = ~(np.abs(faces - np.nanmedian(faces)) > _BACKGROUND_RANGE * value_range)
    return is_background.mean() >= _MIN_EMPTY_SHARE


def _set(prop, values):
    prop.SetElements(np.ravel(values).tolist(), np.size(values))
