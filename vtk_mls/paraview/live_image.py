"""An image drawn deformed in place of ParaView's own prop."""

from paraview.modules.vtkPVVTKExtensionsFiltersRendering import vtkPVGeometryFilter
from paraview.modules.vtkRemotingViews import vtkPVImageSliceMapper
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkRenderingCore import vtkPolyDataMapper, vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

from vtk_mls.paraview.displays import apply_colors, color_array, set_scalar_mode
from vtk_mls.paraview.live_prop import (
    FEATURE_EDGES,
    SURFACES,
    LiveProp,
    feature_edges,
    representation_of,
)
from vtk_mls.paraview.server_manager import pending_value
from vtk_mls.rendering import DeformedVolume
from vtk_mls.rendering.pace import MapPace, adjust_rays, usual_step
from vtk_mls.vtk.objects import configured, output_of

MAX_POINTS_DRAGGING, MAX_POINTS = 2**18, 2**21  # of an image that is deformed as a whole
MAX_MAP_NODES = 128  # along an axis, of a volume's map at rest
_NORMAL_AXES = {5: 2, 6: 0, 7: 1}  # of VTK's codes for the XY, YZ and XZ planes
_GPU_MODES = (0, 2)  # of ParaView's volumes: Smart, GPU Based


class LiveImage(LiveProp):
    """The surface of an image, or its edges and points.

    Without cuts only the six faces of the image are visible, and only these are computed, exactly
    as Apply does. A cut opens the image: then all of it is computed, a large image on a coarser
    grid.
    """

    draws_images = True
    representations = (*SURFACES, FEATURE_EDGES)

    def __init__(self, display, image, renderer, index):
        self._mapper = vtkPolyDataMapper()
        apply_colors(self._mapper, display)
        self._has_cell_colors = color_array(display)[0]
        self._has_edges = representation_of(display) == FEATURE_EDGES
        super().__init__(display, image, renderer, self._mapper)

    def _show(self, pending, is_dragging):
        geometry = pending.geometry(self._data)
        max_points = MAX_POINTS_DRAGGING if is_dragging else MAX_POINTS
        if not pending.deformation.cuts:
            parts = [
                _flat_part(pending, self._data, face, self._has_cell_colors)
                for face in _faces(geometry.extent)
            ]
        elif geometry.grid.size <= max_points:
            parts = [pending.image(self._data, geometry.extent)]
        else:
            parts = [pending.coarse_image(self._data, max_points)]
        surface = vtkAppendPolyData()
        for part in parts:
            surface.AddInputData(output_of(vtkGeometryFilter(), InputData=part))
        drawn = feature_edges(surface) if self._has_edges else surface
        self._mapper.SetInputData(output_of(drawn))


class LiveSlice(LiveProp):
    """A slice of an image; only the slice is computed, exactly as Apply does."""

    draws_images = True
    representations = ("Slice",)

    def __init__(self, display, image, renderer, index):
        self._mapper = vtkPVImageSliceMapper()
        apply_colors(self._mapper, display)
        self._mapper.SetUseXYPlane(pending_value(display, "UseXYPlane", 0))
        self._has_cell_colors = color_array(display)[0]
        self._slice = pending_value(display, "Slice", 0)
        self._axis = _NORMAL_AXES[pending_value(display, "SliceMode", 5)]
        super().__init__(display, image, renderer, self._mapper)

    @staticmethod
    def settings(display):
        names = ("Slice", "SliceMode", "UseXYPlane")
        return LiveProp.settings(display), [pending_value(display, name) for name in names]

    def _show(self, pending, is_dragging):
        extent = list(pending.geometry(self._data).extent)
        low, high = extent[2 * self._axis : 2 * self._axis + 2]
        if all(first < last for first, last in zip(extent[::2], extent[1::2])):  # not flat
            extent[2 * self._axis : 2 * self._axis + 2] = [min(low + self._slice, high)] * 2
        self._mapper.SetInputData(_flat_part(pending, self._data, extent, self._has_cell_colors))


class LiveBox(LiveProp):
    """The outline of an image's grid."""

    draws_images = True
    representations = ("Outline",)

    def __init__(self, display, image, renderer, index):
        self._grid = vtkImageData()
        outline = configured(vtkPVGeometryFilter(), InputData=self._grid, UseOutline=True)
        mapper = configured(vtkPolyDataMapper(), ScalarVisibility=False)
        mapper.SetInputConnection(outline.GetOutputPort())
        super().__init__(display, image, renderer, mapper)

    def _show(self, pending, is_dragging):
        pending.geometry(self._data).apply_to(self._grid)


class LiveVolume(LiveProp):
    """An image as a volume with one number per voxel.

    ParaView's own vtkVolume cannot be deformed, since its mapper may be one of several.
    """

    draws_images = True
    representations = ("Volume",)
    prop_type = vtkVolume

    def __init__(self, display, image, renderer, index):
        if pending_value(display, "VolumeRenderingMode", 0) not in _GPU_MODES:
            raise ValueError("`Volume Rendering Mode` is neither Smart nor GPU Based")
        # as ParaView's own at rest, which takes longer steps during interaction, not fewer rays
        settings = {"InputData": image, "AutoAdjustSampleDistances": False}
        self._mapper = configured(vtkGPUVolumeRayCastMapper(), **settings)
        is_of_cells, name = color_array(display)
        set_scalar_mode(self._mapper, is_of_cells)
        self._mapper.SelectScalarArray(name)
        self._mapper.SetBlendMode(pending_value(display, "BlendMode", 0))
        super().__init__(display, image, renderer, self._mapper)
        self._uses_depth_peeling = renderer.GetUseDepthPeelingForVolumes()
        self._deformed, self._pace = DeformedVolume(self._prop, renderer), MapPace(MAX_MAP_NODES)

    @classmethod
    def can_draw(cls, display, image):
        if not super().can_draw(display, image) or min(image.GetDimensions()) < 2:
            return False
        is_of_cells, name = color_array(display)
        array = (image.GetCellData() if is_of_cells else image.GetPointData()).GetArray(name)
        return array is not None and array.GetNumberOfComponents() == 1

    @staticmethod
    def settings(display):
        names = ("BlendMode", "VolumeRenderingMode")
        return color_array(display), [pending_value(display, name) for name in names]

    def update(self, pending, is_dragging):
        # ParaView's own volume is drawn without depth peeling, which changes its colors
        self._renderer.SetUseDepthPeelingForVolumes(False)
        adjust_rays(self._mapper, self._renderer.GetRenderWindow())
        super().update(pending, is_dragging)

    @property
    def has_failed(self):
        return self._deformed.failure is not None

    def _show(self, pending, is_dragging):
        self._mapper.SetSampleDistance(usual_step(self._data))  # the input may have changed
        limits = pending.limits(self._data)

        def make_map(nodes):
            self._deformed.update(pending.deformation, nodes, limits)

        self._pace.make(make_map, is_dragging)

    def end(self):
        self._deformed.detach()
        self._renderer.SetUseDepthPeelingForVolumes(self._uses_depth_peeling)
        super().end()


def _flat_part(pending, image, extent, has_cells):
    """The deformed image in a flat extent: its points, or the cells next to them."""
    if not has_cells:
        return pending.image(image, extent)
    whole = pending.geometry(image).extent
    thick = list(extent)
    for low, high in ((2 * axis, 2 * axis + 1) for axis in range(3)):
        if extent[low] == extent[high] and whole[low] < whole[high]:
            thick[low] = min(extent[low], whole[high] - 1)
            thick[high] = thick[low] + 1
    deformed, flat = pending.image(image, thick), vtkImageData()
    flat.CopyStructure(deformed)
    flat.SetExtent(extent)
    flat.GetCellData().ShallowCopy(deformed.GetCellData())
    return flat


def _faces(extent):
    """The extents of the six faces of an extent; a flat extent itself."""
    if any(extent[2 * axis] == extent[2 * axis + 1] for axis in range(3)):
        return [extent]
    faces = []
    for end in range(6):
        face = list(extent)
        face[end ^ 1] = face[end]
        faces.append(face)
    return faces
