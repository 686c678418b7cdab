"""An image in the scene as a volume."""

import numpy as np
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  renders volumes
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

from vtk_mls import Deformation
from vtk_mls.editor.scene_image import SceneImage
from vtk_mls.rendering import DeformedVolume
from vtk_mls.rendering.surfaces import STEP
from vtk_mls.vtk.objects import configured

_COARSE_STEP = 1.2  # between samples along a ray, in voxels
_COARSE_PIXELS = 2  # between rays, from which on steps are longer still
_MAX_STEP_FACTOR = 3  # of longer steps instead of fewer rays


class SceneVolume(SceneImage):
    """A deformed image in the `Scene`, with its volume and a list of `TransferFunctionPreset`s."""

    def __init__(self, image, renderer):
        super().__init__(image)
        self._mapper = configured(vtkGPUVolumeRayCastMapper(), InputData=self._image)
        configured(self._mapper, AutoAdjustSampleDistances=False, UseJittering=True)
        self.set_coarseness(1)
        self.prop = self._volume = configured(vtkVolume(), Mapper=self._mapper)
        material = self._volume.GetProperty()
        material.SetScalarOpacityUnitDistance(float(np.abs(self._grid.spacing).mean()))
        configured(material, Ambient=0.35, Diffuse=0.75, Specular=0.15, SpecularPower=20)
        material.ShadeOn()
        self._draw_preset()
        renderer.AddVolume(self._volume)
        self._deformed = DeformedVolume(self._volume, renderer)

    def set_preset(self, index):
        name = super().set_preset(index)
        self._draw_preset()
        return name

    def _draw_preset(self):
        preset = self._preset
        colors, opacities = vtkColorTransferFunction(), vtkPiecewiseFunction()
        for node in preset.colors:
            colors.AddRGBPoint(*node)
        for node in preset.opacities:
            opacities.AddPoint(*node)
        material = configured(self._volume.GetProperty(), Color=colors, ScalarOpacity=opacities)
        if preset.is_nearest:
            material.SetInterpolationTypeToNearest()
        else:
            material.SetInterpolationTypeToLinear()

    def set_coarseness(self, pixels, has_offset=False):
        """Set the pixels between rays along both axes; above 1, steps along rays are longer.

        `has_offset`: the renderer does not begin in the corner of the window. VTK 9.6 draws nothing
        there with fewer rays, so only the steps are longer.
        """
        step = STEP if pixels <= 1 else _COARSE_STEP * max(1, pixels / _COARSE_PIXELS)
        if has_offset:
            step, pixels = step * min(max(pixels, 1), _MAX_STEP_FACTOR), 1
        self._mapper.SetSampleDistance(step * float(np.abs(self._grid.spacing).min()))
        self._mapper.SetImageSampleDistance(pixels)

    def show(self, deformation, nodes, distortion, is_final):
        super().show(deformation, nodes, distortion, is_final)
        lines = distortion.lines if distortion.has_grid else None
        self._deformed.paint(lines, distortion.has_colors)
        if deformation is not None:
            self._deformed.update(deformation, nodes)
        elif self._deformed.uploads > 0 or lines is not None:
            # keeps the shader: to build another takes a second
            corner = self._grid.corners()[:1]
            self._deformed.update(Deformation(corner, corner), 2)

    def detach(self):
        """Leave the volume undeformed."""
        self._deformed.detach()
