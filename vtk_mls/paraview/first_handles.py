"""Where the handles of a new filter or source lie, in ParaView's GUI.

ParaView lays those of a filter as a lattice over the bounds of its input. Where the material does
not fill these, the handles are brought to it. Those of a source of control points, which has no
input, go to the bounds of what is selected. Scripts outside of the GUI have ParaView's lattice, and
the cube that is the source's default.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData

from vtk_mls.editor.first_handles import handles_on
from vtk_mls.editor.scene_mesh import MeshSurface
from vtk_mls.editor.scene_volume import VolumeSurface, scalar_image
from vtk_mls.editor.transfer_functions import presets_of
from vtk_mls.paraview import undo
from vtk_mls.paraview.handle_rows import pending
from vtk_mls.paraview.server_manager import blocks_of, input_of, is_remote
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_COUNT = 3  # along each axis
_MAX_CELLS = 10**6  # of a mesh: to find what is nearest takes a second
_EMPTY, _ALIKE = 0.5, 0.02  # share of an image's faces; of the range of its values


def lay(proxy, selected):
    """Lay the handles of a proxy that was just made, unless somebody else has.

    Parameters
    ----------
    proxy : proxy with lists of control points
    selected : proxy of a source or an output port, or None
    """
    if proxy.GetSessionProxyManager().GetInLoadXMLState() or undo.is_busy():
        return
    if proxy.GetProperty("Bounds"):
        _lay_over(proxy, selected)
    elif not is_remote(proxy) and proxy.GetProperty("Input").GetNumberOfProxies():
        _lay_on_material(proxy)


def _lay_over(source, selected):
    """Make the bounds of what is selected those of a source's cube and lattice."""
    rest, box = source.GetProperty("RestPoints"), source.GetProperty("Bounds")
    if selected is None or not (rest.IsValueDefault() and box.IsValueDefault()):
        return
    bounds = np.array(selected.GetDataInformation().GetBounds())
    if (bounds[::2] > bounds[1::2]).any():
        return  # it has no data yet
    low, high = bounds[::2], bounds[1::2]
    corners = np.where(pending(rest) > 0, high, low)
    _set(box, bounds)
    _set(rest, list(dict.fromkeys(map(tuple, corners.tolist()))))  # of flat data there are fewer
    source.UpdateVTKObjects()


def _lay_on_material(proxy):
    """Bring the handles of ParaView's lattice to where the input has something."""
    rest, deformed = proxy.GetProperty("RestPoints"), proxy.GetProperty("DeformedPoints")
    laid = pending(rest)
    if len(laid) != _COUNT**3 or not np.array_equal(laid, pending(deformed)):
        return  # a script has set them
    positions = None
    with suppress(ValueError):  # images without values at points
        positions = _on_material(blocks_of(input_of(proxy)))
    if positions is not None:
        _set(rest, positions)
        _set(deformed, positions)
        proxy.UpdateVTKObjects()


def _on_material(blocks):
    """Positions (n, 3) of handles; None where the lattice over the bounds is as good."""
    shapes = [_shape_of(block) for block in blocks]
    if not shapes or None in shapes:
        return None
    boxes = np.array([box for _, box in shapes])
    box = np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
    return handles_on([shape for shape, _ in shapes], box, _COUNT)


def _shape_of(data):
    """What tells points that are nearest to data, and corners (2, 3) of a box round these.

    None for what fills its bounds, or is too large to ask.
    """
    if isinstance(data, vtkImageData):
        image = scalar_image(data)
        grid = ImageGeometry.of_image(image).grid
        values = arrays.to_numpy(image.GetPointData().GetScalars()).reshape(grid.shape)
        if not _has_empty_faces(values):
            return None
        surface = VolumeSurface(grid, values, presets_of(values.ravel(), False)[0])
        return surface, surface.bounds
    if not isinstance(data, vtkDataSet) or not 0 < data.GetNumberOfCells() <= _MAX_CELLS:
        return None
    return MeshSurface(data), np.reshape(data.GetBounds(), (3, 2)).T


def _has_empty_faces(values):
    """Whether the faces of an image (nz, ny, nx) are of a background, as air round a head is."""
    if min(values.shape) < 2:
        return False
    ends = [np.take(values, (0, -1), axis=axis).ravel() for axis in range(3)]
    faces = np.concatenate(ends).astype(float)
    scale = float(np.nanmax(values)) - float(np.nanmin(values))
    is_background = ~(np.abs(faces - np.nanmedian(faces)) > _ALIKE * scale)
    return is_background.mean() >= _EMPTY


def _set(changed, values):
    changed.SetElements(np.ravel(values).tolist(), np.size(values))
