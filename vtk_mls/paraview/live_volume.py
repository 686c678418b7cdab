"""An image that ParaView shows as a volume, drawn deformed in its stead."""

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkVolume
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

from vtk_mls.paraview.server_manager import elements, find
from vtk_mls.rendering import DeformedVolume

_MOVING, _RESTING = 64, 128  # nodes of the map


class LiveVolume:
    """A volume of our own with the look of ParaView's, which is hidden.

    ParaView's own cannot be drawn deformed: its mapper may be one of several.

    Parameters
    ----------
    display : proxy of a representation
        One that `can_draw` accepts.
    image : vtkImageData
        To be drawn.
    renderer : vtkRenderer
    """

    def __init__(self, display, image, renderer):
        self._image, self._renderer, self._array = image, renderer, _array(display)
        self._hidden = _volume_of(display)
        self._display = display.GetGlobalID()
        mapper = vtkSmartVolumeMapper()  # as ParaView's, for the same steps along rays
        mapper.SetRequestedRenderModeToGPU()
        mapper.SetInputData(image)
        self._volume = vtkVolume()
        self._volume.SetMapper(mapper)
        self._volume.PickableOff()
        self._update_look(display)
        renderer.AddViewProp(self._volume)
        self._peels = renderer.GetUseDepthPeelingForVolumes()
        self._drawn, self._latest = DeformedVolume(self._volume, renderer), None

    @staticmethod
    def can_draw(display, image):
        """Whether a display shows the image as a volume of one number a voxel."""
        shows = display.GetProperty("Representation")
        if not isinstance(image, vtkImageData) or shows is None or shows.GetElement(0) != "Volume":
            return False
        association, name = _array(display)
        attributes = image.GetCellData() if association == "1" else image.GetPointData()
        array = attributes.GetArray(name)
        is_plain = array is not None and array.GetNumberOfComponents() == 1
        return is_plain and min(image.GetDimensions()) > 1 and _volume_of(display) is not None

    def is_of(self, display, image):
        """Whether this still draws what the display shows."""
        return (
            self.can_draw(display, image)
            and image is self._image
            and _array(display) == self._array
            and _volume_of(display) is self._hidden
        )

    def update(self, deformation, is_held, limits):
        """Draw the image as a deformation has it; whether the graphics card can.

        Parameters
        ----------
        deformation : Deformation
        is_held : bool
            Whether the mouse holds a handle: the map is coarser then.
        limits : ImageGeometry or None
            What lies outside of it is not drawn.
        """
        self._hidden.SetVisibility(False)
        # VTK draws volumes otherwise where they are peeled, and ParaView's is not
        self._renderer.SetUseDepthPeelingForVolumes(False)
        nodes = _MOVING if is_held else _RESTING
        if self._drawn.failure is None and self._latest != (deformation, nodes, limits):
            self._latest = deformation, nodes, limits
            self._drawn.update(deformation, nodes, limits and limits.grid)
            self._renderer.ResetCameraClippingRange()
        return self._drawn.failure is None

    def end(self):
        """Let ParaView's volume be seen again."""
        self._drawn.detach()
        self._renderer.RemoveViewProp(self._volume)
        self._renderer.SetUseDepthPeelingForVolumes(self._peels)
        display = find(self._display, "representations")
        if display and _volume_of(display) is self._hidden:
            self._hidden.SetVisibility(display.GetProperty("Visibility").GetElement(0))

    def _update_look(self, display):
        association, name = self._array
        mapper = self._volume.GetMapper()
        if association == "1":
            mapper.SetScalarModeToUseCellFieldData()
        else:
            mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectScalarArray(name)
        blend = display.GetProperty("BlendMode")
        mapper.SetBlendMode(blend.GetElement(0) if blend else 0)
        self._volume.SetProperty(self._hidden.GetProperty())


def _array(display):
    """Association ("0" of points, "1" of cells) and name of the array that a display shows."""
    return tuple(elements(display.GetProperty("ColorArrayName"))[3:5])


def _volume_of(display):
    """ParaView's own vtkVolume of a display; None where it has none here."""
    active = display.GetClientSideObject().GetActiveRepresentation()
    volume = active.GetActor() if hasattr(active, "GetActor") else None
    return volume if isinstance(volume, vtkVolume) else None
