"""An image that ParaView shows as a surface or a slice, drawn deformed in its stead."""

from __future__ import annotations

from paraview.modules.vtkPVVTKExtensionsFiltersRendering import vtkPVGeometryFilter
from paraview.modules.vtkRemotingViews import vtkPVImageSliceMapper
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls.paraview import colors
from vtk_mls.paraview.live_mesh import EDGES, SURFACES, edges_of, has_actor
from vtk_mls.paraview.live_prop import LiveProp, shown_as
from vtk_mls.paraview.pending_filter import PendingFilter
from vtk_mls.paraview.server_manager import elements

_MOST_HELD, _MOST = 2**18, 2**21  # points of an image that is made as a whole
_NORMALS = {5: 2, 6: 0, 7: 1}  # axes of VTK's codes of planes: XY, YZ, XZ


class LiveImage(LiveProp):
    """The surface of an image, or its edges and points.

    Without cuts the six faces of the image are all that is to be seen, and just these are made, as
    Apply makes them. A cut opens the image: then it is made as a whole, a large one on a coarser
    grid.
    """

    def __init__(self, display, image, renderer, index=0):
        self._mapper, actor = vtkPolyDataMapper(), vtkActor()
        colors.apply(self._mapper, display)
        actor.SetMapper(self._mapper)
        self._has_cell_colors = colors.array(display)[0] == "1"
        self._has_edges = shown_as(display) == EDGES
        super().__init__(display, image, renderer, actor)

    @staticmethod
    def can_draw(display, image):
        """Whether a display shows the image so."""
        is_image = isinstance(image, vtkImageData)
        return is_image and shown_as(display) in (*SURFACES, EDGES) and has_actor(display)

    @staticmethod
    def look(display):
        return colors.look(display), shown_as(display)

    def _show(self, pending, is_held):
        geometry = pending.geometry(self._data)
        most = _MOST_HELD if is_held else _MOST
        if not pending.deformation.cuts:
            make = _cells if self._has_cell_colors else PendingFilter.image
            parts = [make(pending, self._data, extent) for extent in _faces(geometry.extent)]
        elif geometry.grid.size <= most:
            parts = [pending.image(self._data, geometry.extent)]
        else:
            parts = [pending.coarse_image(self._data, most)]
        surface = vtkAppendPolyData()
        for each in parts:
            faces = vtkGeometryFilter()
            faces.SetInputData(each)
            faces.Update()
            surface.AddInputData(faces.GetOutput())
        drawn = edges_of(surface) if self._has_edges else surface
        drawn.Update()
        self._mapper.SetInputData(drawn.GetOutput())


class LiveSlice(LiveProp):
    """A slice of an image: just this is made, as Apply makes it."""

    def __init__(self, display, image, renderer, index=0):
        self._mapper, actor = vtkPVImageSliceMapper(), vtkActor()
        colors.apply(self._mapper, display)
        self._mapper.SetUseXYPlane(_value(display, "UseXYPlane"))
        actor.SetMapper(self._mapper)
        self._has_cell_colors = colors.array(display)[0] == "1"
        self._slice, self._axis = _value(display, "Slice"), _NORMALS[_value(display, "SliceMode")]
        super().__init__(display, image, renderer, actor)

    @staticmethod
    def can_draw(display, image):
        """Whether a display shows the image so."""
        is_slice = isinstance(image, vtkImageData) and shown_as(display) == "Slice"
        return is_slice and has_actor(display)

    @staticmethod
    def look(display):
        names = ("Representation", "Slice", "SliceMode", "UseXYPlane")
        return colors.look(display), [_value(display, name) for name in names]

    def _show(self, pending, is_held):
        extent = list(pending.geometry(self._data).extent)
        low, high = extent[2 * self._axis : 2 * self._axis + 2]
        if all(first < last for first, last in zip(extent[::2], extent[1::2])):  # else it is one
            extent[2 * self._axis : 2 * self._axis + 2] = [min(low + self._slice, high)] * 2
        make = _cells if self._has_cell_colors else PendingFilter.image
        self._mapper.SetInputData(make(pending, self._data, extent))


class LiveBox(LiveProp):
    """The outline of an image: that of its grid."""

    def __init__(self, display, image, renderer, index=0):
        self._grid, outline = vtkImageData(), vtkPVGeometryFilter()
        outline.SetInputData(self._grid)
        outline.SetUseOutline(True)
        mapper, actor = vtkPolyDataMapper(), vtkActor()
        mapper.SetInputConnection(outline.GetOutputPort())
        mapper.ScalarVisibilityOff()
        actor.SetMapper(mapper)
        super().__init__(display, image, renderer, actor)

    @staticmethod
    def can_draw(display, image):
        """Whether a display shows the image so."""
        is_image = isinstance(image, vtkImageData)
        return is_image and shown_as(display) == "Outline" and has_actor(display)

    @staticmethod
    def look(display):
        return shown_as(display)

    def _show(self, pending, is_held):
        pending.geometry(self._data).apply_to(self._grid)


def _cells(pending, image, extent):
    """What an image becomes within a flat extent: the cells there, which lie half a cell deep."""
    whole = pending.geometry(image).extent
    deep = list(extent)
    for low, high in ((2 * axis, 2 * axis + 1) for axis in range(3)):
        if extent[low] == extent[high] and whole[low] < whole[high]:
            deep[low] = min(extent[low], whole[high] - 1)
            deep[high] = deep[low] + 1
    made, flat = pending.image(image, deep), vtkImageData()
    flat.CopyStructure(made)
    flat.SetExtent(extent)
    flat.GetCellData().ShallowCopy(made.GetCellData())
    return flat


def _faces(extent):
    """Extents of the faces of an extent; of a flat one itself."""
    if any(extent[2 * axis] == extent[2 * axis + 1] for axis in range(3)):
        return [extent]
    sides = [(end, end ^ 1) for end in range(6)]
    return [[extent[s] if e == other else v for e, v in enumerate(extent)] for s, other in sides]


def _value(display, name):
    changed = display.GetProperty(name)
    return elements(changed)[0] if changed else 0
