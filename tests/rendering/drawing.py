"""A volume to draw, windows, and pictures as arrays."""

from __future__ import annotations

import numpy as np
import vtkmodules.vtkRenderingOpenGL2
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  (registers the volume mappers)
from pipelines import picture_of
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import (
    vtkColorTransferFunction,
    vtkRenderer,
    vtkRenderWindow,
    vtkVolume,
    vtkVolumeProperty,
)
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

from vtk_mls import Grid
from vtk_mls.rendering import DeformedVolume
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

SIZE = 48  # voxels along an edge
MIDDLE = (SIZE - 1) / 2
PIXELS = 150
_COLORS = (
    (0, 0, 0, 0),
    (40, 0.8, 0.5, 0.4),
    (90, 1, 0.8, 0.5),
    (180, 0.4, 0.6, 1),
    (255, 1, 1, 1),
)


def phantom(size=SIZE):
    """An ellipsoid with waves within and a bright ball, (size, size, size) uint8."""
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, size)] * 3, indexing="ij")
    radius = np.sqrt((x / 0.8) ** 2 + (y / 0.6) ** 2 + (z / 0.8) ** 2)
    waves = (90 + 50 * np.sin(9 * z) + 40 * np.sin(9 * x)) / (1 + np.exp((radius - 1) * 20))
    ball = 80 * np.exp(-((x - 0.3) ** 2 + (y + 0.2) ** 2 + (z - 0.2) ** 2) / 0.02)
    return np.clip(waves + ball * (radius < 1), 0, 255).astype(np.uint8)


def image_of(values, grid=None, ghosts=None):
    """A vtkImageData of values (nz, ny, nx) or (nz, ny, nx, components) on a `Grid`."""
    grid = grid or Grid(values.shape[2::-1])
    image = vtkImageData()
    ImageGeometry.of_grid(grid).apply_to(image)
    array = configured(numpy_to_vtk(values.reshape(grid.size, -1), deep=True), Name="density")
    image.GetPointData().SetScalars(array)
    if ghosts is not None:
        arrays.add(image.GetPointData(), arrays.GHOSTS, ghosts.astype(np.uint8).ravel() * 2)
    return image


def volume_of(image, blend="Composite", mapper=None, components=1, **property):
    """A vtkVolume; keywords are values of its vtkVolumeProperty."""
    mapper = mapper or vtkGPUVolumeRayCastMapper()
    configured(mapper, InputData=image, AutoAdjustSampleDistances=False, SampleDistance=0.5)
    getattr(mapper, f"SetBlendModeTo{blend}")()
    colors, opacity = vtkColorTransferFunction(), vtkPiecewiseFunction()
    for point in _COLORS:
        colors.AddRGBPoint(*point)
    for point in ((0, 0), (15, 0), (60, 0.9), (255, 0.9)):
        opacity.AddPoint(*point)
    material = configured(vtkVolumeProperty(), Shade=True, Ambient=0.3)
    material.SetInterpolationTypeToLinear()
    for component in range(components):
        material.SetColor(component, colors)
        material.SetScalarOpacity(component, opacity)
    material.GetIsoSurfaceValues().SetValue(0, 60)
    return configured(vtkVolume(), Mapper=mapper, Property=configured(material, **property))


class Scene:
    """An offscreen window that shows props from the side."""

    def __init__(self, *props, focal=(MIDDLE,) * 3, distance=3.5 * SIZE, pixels=PIXELS):
        self.window, self.renderer = vtkRenderWindow(), vtkRenderer()
        configured(self.window, OffScreenRendering=True, MultiSamples=0).SetSize(pixels, pixels)
        self.window.AddRenderer(self.renderer)
        self.renderer.SetBackground(0.1, 0.12, 0.16)
        for prop in props:
            self.renderer.AddViewProp(prop)
        position = np.array(focal) + distance * np.array((0.54, -0.66, 0.5))
        camera = configured(self.renderer.GetActiveCamera(), FocalPoint=focal, Position=position)
        configured(camera, ViewUp=(0, 0, 1), ViewAngle=26)

    def picture(self):
        """(height, width, 3) float, 0 to 255."""
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        return picture_of(self.window)


def drawn_volume(image, *arguments, **looks):
    """A vtkVolume of an image as of `volume_of`, a `Scene` of it, and its `DeformedVolume`."""
    volume = volume_of(image, *arguments, **looks)
    scene = Scene(volume)
    return volume, scene, DeformedVolume(volume, scene.renderer)


def assert_alike(picture, other, mean=1.0, p99=16.0):
    """Pictures differ by little, of 255."""
    difference = np.abs(picture - other)
    assert difference.mean() <= mean
    assert np.percentile(difference, 99) <= p99
