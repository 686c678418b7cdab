"""An image as a volume that follows the handles, drawn by its look."""

from __future__ import annotations

import numpy as np
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  draws volumes
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

from vtk_mls import Deformation
from vtk_mls.editor import looks
from vtk_mls.editor.scalar_image import scalar_image
from vtk_mls.editor.visible_voxels import VisibleVoxels
from vtk_mls.editor.volume_surface import VolumeSurface
from vtk_mls.files import provenance
from vtk_mls.rendering import DeformedVolume
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_STEP, _COARSE_STEP = 0.5, 1.2  # of a voxel, along a ray


class ShownVolume:
    """A vtkImageData, deformed and drawn.

    Attributes
    ----------
    looks : list of Look
    """

    def __init__(self, image, renderer):
        self._image, self._deformation = scalar_image(image), None
        self._grid = ImageGeometry.of_image(self._image).grid
        scalars = self._image.GetPointData().GetScalars()
        self._values = arrays.to_numpy(scalars).reshape(self._grid.shape)
        labels = provenance.kept(image, provenance.LABEL_ARRAYS)
        self.looks = looks.looks_of(self._values.ravel(), scalars.GetName() in labels)
        self._look = None
        self._mapper, self._volume = vtkGPUVolumeRayCastMapper(), vtkVolume()
        self._mapper.SetInputData(self._image)
        self._mapper.SetAutoAdjustSampleDistances(False)
        self._mapper.UseJitteringOn()
        self.set_coarseness(1)
        self._volume.SetMapper(self._mapper)
        self.set_look(0)
        renderer.AddVolume(self._volume)
        self._drawn = DeformedVolume(self._volume, renderer)

    @property
    def bounds(self):
        """Corners (2, 3) of a box round what is not transparent."""
        return self._visible().bounds

    def nearest(self, points):
        """What is not transparent of it at rest, next to each of `points` (n, 3): (n, 3)."""
        return self._visible().nearest(points)

    def _visible(self):
        return VisibleVoxels(self._grid, self._values, self._look)

    def set_look(self, number):
        """Draw it by one of the looks, whose name is returned."""
        self._look = look = self.looks[number % len(self.looks)]
        colours, opacities = vtkColorTransferFunction(), vtkPiecewiseFunction()
        for each in look.colours:
            colours.AddRGBPoint(*each)
        for each in look.opacities:
            opacities.AddPoint(*each)
        drawn_as = self._volume.GetProperty()
        drawn_as.SetColor(colours)
        drawn_as.SetScalarOpacity(opacities)
        drawn_as.SetScalarOpacityUnitDistance(float(np.abs(self._grid.spacing).mean()))
        if look.is_nearest:
            drawn_as.SetInterpolationTypeToNearest()
        else:
            drawn_as.SetInterpolationTypeToLinear()
        drawn_as.ShadeOn()
        drawn_as.SetAmbient(0.35)
        drawn_as.SetDiffuse(0.75)
        drawn_as.SetSpecular(0.15)
        drawn_as.SetSpecularPower(20)
        return look.name

    def show(self, deformation, nodes, is_final):
        """Draw it as a Deformation has it, or undeformed for None."""
        self._deformation = deformation
        if deformation is not None:
            self._drawn.update(deformation, nodes)
        elif self._drawn.uploads > 0:  # its shader stays: to build another takes a second
            corner = self._grid.corners()[:1]
            self._drawn.update(Deformation(corner, corner), 2)

    def detach(self):
        """Leave the volume as it is at rest."""
        self._drawn.detach()

    def set_coarseness(self, pixels):
        """Cast a ray for each so many pixels along both axes, with longer steps if above 1."""
        step = _STEP if pixels <= 1 else _COARSE_STEP
        self._mapper.SetSampleDistance(step * float(np.abs(self._grid.spacing).min()))
        self._mapper.SetImageSampleDistance(pixels)

    def colours_at(self, points):
        """Which points (n, 3) of the deformed space it has material at, and colours (n, 3)."""
        is_there, values = self._samples.at(points)
        return is_there, looks.slice_colours(self._look, values)

    def mesh(self):
        """None: in slices it is an image."""

    @property
    def _samples(self):
        return VolumeSurface(self._grid, self._values, self._look, self._deformation)

    def surface(self):
        """What one sees of it now, as a `VolumeSurface`."""
        return self._samples
