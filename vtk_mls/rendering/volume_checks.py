"""Checks of a vtkVolume that is to be drawn deformed."""

from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

_ON_CARD = vtkSmartVolumeMapper.DefaultRenderMode, vtkSmartVolumeMapper.GPURenderMode


class RenderingError(RuntimeError):
    """The graphics driver or VTK cannot draw the deformation."""


def checked_mapper(volume):
    """The mapper of a volume, if it can draw a deformation."""
    mapper = volume.GetMapper()
    if not isinstance(mapper, (vtkGPUVolumeRayCastMapper, vtkSmartVolumeMapper)):
        raise TypeError(
            "`volume` must have a vtkGPUVolumeRayCastMapper or a vtkSmartVolumeMapper, "
            f"got {type(mapper).__name__}"
        )
    if mapper.GetNumberOfInputConnections(0) != 1:
        raise ValueError("the mapper of `volume` must have one input, got none or several")
    check_mode(mapper)
    return mapper


def check_mode(mapper):
    """Raise ValueError if a mapper is set to draw without the graphics card."""
    if isinstance(mapper, vtkGPUVolumeRayCastMapper):
        return
    mode = mapper.GetRequestedRenderMode()
    if mode not in _ON_CARD:
        names = (name for name, value in vars(vtkSmartVolumeMapper).items() if value == mode)
        name = next(name for name in names if name.endswith("RenderMode"))
        raise ValueError(
            "the mapper of `volume` must draw on the graphics card, "
            f"got {name}; call its SetRequestedRenderModeToGPU()"
        )


def check_own_mapper(volume, others):
    """Raise ValueError if another volume shares the mapper, and so the data and its placement."""
    mapper = volume.GetMapper()
    if any(other is not volume and other.GetMapper() is mapper for other in others):
        raise ValueError(
            "`volume` shares its mapper with another vtkVolume, which would be drawn in a wrong "
            "place; give each a mapper of its own"
        )


def check_support(volume, window):
    """Raise RenderingError if VTK cannot draw a volume on the graphics card."""
    mapper = volume.GetMapper()
    if not isinstance(mapper, vtkGPUVolumeRayCastMapper):
        mapper = vtkGPUVolumeRayCastMapper()
    if not mapper.IsRenderSupported(window, volume.GetProperty()):
        raise RenderingError(
            "`volume` must be drawn on the graphics card, which VTK cannot do in this window; "
            "draw the resampled volume instead"
        )


def check_image(image):
    """Raise TypeError or ValueError if an image cannot be drawn deformed."""
    if not isinstance(image, vtkImageData):
        raise TypeError(
            f"`volume` must show a vtkImageData, got {type(image).__name__}; resample it to one"
        )
    if min(image.GetDimensions()) < 2:
        raise ValueError(
            f"`volume` must have at least two points along each axis, got {image.GetDimensions()}"
        )
