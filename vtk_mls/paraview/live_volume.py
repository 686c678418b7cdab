"""An image that ParaView shows as a volume, drawn deformed in its stead."""

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

from vtk_mls.paraview import colors
from vtk_mls.paraview.live_prop import LiveProp, shown_as, shown_prop
from vtk_mls.rendering import DeformedVolume
from vtk_mls.rendering.pace import MapPace, RaySpacing, usual_step

_MOST = 128  # nodes of the map at rest
_ON_CARD = (0, 2)  # modes of ParaView's volumes: Smart, GPU Based


class LiveVolume(LiveProp):
    """An image as a volume.

    ParaView's own vtkVolume cannot be drawn deformed: its mapper may be one of several.
    """

    def __init__(self, display, image, renderer, index=0):
        if _mode(display) not in _ON_CARD:
            raise ValueError("`Volume Rendering Mode` is neither Smart nor GPU Based")
        mapper = vtkGPUVolumeRayCastMapper()
        mapper.SetInputData(image)
        # as ParaView's own at rest; that one makes steps longer, not rays fewer, while it moves
        mapper.SetAutoAdjustSampleDistances(False)
        association, name = colors.array(display)
        if association == "1":
            mapper.SetScalarModeToUseCellFieldData()
        else:
            mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectScalarArray(name)
        mapper.SetBlendMode(_blend(display))
        volume = vtkVolume()
        volume.SetMapper(mapper)
        super().__init__(display, image, renderer, volume)
        self._mapper, self._spacing = mapper, RaySpacing(mapper)
        self._peels = renderer.GetUseDepthPeelingForVolumes()
        self._drawn, self._pace = DeformedVolume(volume, renderer), MapPace(_MOST)

    @staticmethod
    def can_draw(display, image):
        """Whether a display shows the image as a volume of one number a voxel."""
        if not isinstance(image, vtkImageData) or shown_as(display) != "Volume":
            return False
        association, name = colors.array(display)
        attributes = image.GetCellData() if association == "1" else image.GetPointData()
        array = attributes.GetArray(name)
        is_plain = array is not None and array.GetNumberOfComponents() == 1
        return (
            is_plain
            and min(image.GetDimensions()) > 1
            and isinstance(shown_prop(display), vtkVolume)
        )

    @staticmethod
    def look(display):
        return colors.array(display), _blend(display), _mode(display)

    def update(self, pending, is_held):
        """Draw the volume as pending edits have it."""
        # VTK draws volumes otherwise where they are peeled, and ParaView's is not
        self._renderer.SetUseDepthPeelingForVolumes(False)
        self._spacing.adjust(self._renderer.GetRenderWindow())
        super().update(pending, is_held)

    @property
    def has_failed(self):
        return self._drawn.failure is not None

    def _show(self, pending, is_held):
        self._mapper.SetSampleDistance(usual_step(self._data))  # of data that may have changed
        # fitted is large enough for all, in steps of a voxel
        within = None if pending.is_fitted else pending.geometry(self._data).grid

        def make_map(nodes):
            self._drawn.update(pending.deformation, nodes, within)

        self._pace.make(make_map, is_held)

    def end(self):
        """Let ParaView's volume be seen again."""
        self._drawn.detach()
        self._renderer.SetUseDepthPeelingForVolumes(self._peels)
        super().end()


def _blend(display):
    return _value(display, "BlendMode")


def _mode(display):
    return _value(display, "VolumeRenderingMode")


def _value(display, name):
    wanted = display.GetProperty(name)
    return wanted.GetElement(0) if wanted else 0
