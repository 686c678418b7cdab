"""What a vtkVolume must be like to be drawn deformed; else a sentence says why it cannot be."""

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

from vtk_mls.rendering.errors import RenderingError

_ON_CARD = vtkSmartVolumeMapper.DefaultRenderMode, vtkSmartVolumeMapper.GPURenderMode


def checked_mapper(volume):
    """The mapper of a volume, which can be drawn deformed."""
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
    """Whether a mapper is not told to draw otherwise than on the graphics card."""
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
    """Whether no other volume has the same mapper, and with it the same data in the same place."""
    mapper = volume.GetMapper()
    if any(each is not volume and each.GetMapper() is mapper for each in others):
        raise ValueError(
            "`volume` shares its mapper with another vtkVolume, which would be drawn in a wrong "
            "place; give each a mapper of its own"
        )


def check_support(volume, window):
    """Whether VTK can draw a volume on the graphics card."""
    mapper = volume.GetMapper()
    if not isinstance(mapper, vtkGPUVolumeRayCastMapper):
        mapper = vtkGPUVolumeRayCastMapper()
    if not mapper.IsRenderSupported(window, volume.GetProperty()):
        raise RenderingError(
            "`volume` must be drawn on the graphics card, which VTK cannot do in this window; "
            "draw the resampled volume instead"
        )


def check_image(image):
    """Whether an image can be drawn deformed."""
    if not isinstance(image, vtkImageData):
        raise TypeError(
            f"`volume` must show a vtkImageData, got {type(image).__name__}; resample it to one"
        )
    if min(image.GetDimensions()) < 2:
        raise ValueError(
            f"`volume` must have at least two points along each axis, got {image.GetDimensions()}"
        )
