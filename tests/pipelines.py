"""Pipelines of VTK: filters, their inputs and outputs. Tests import them."""

from __future__ import annotations

from vtk_fixtures import DEFORMED, REST
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls.filters import MLSControlPoints
from vtk_mls.vtk import arrays


def control_points(rest=REST, deformed=DEFORMED, weights=()):
    source = MLSControlPoints()
    source.SetRestPoints(rest)
    source.SetDeformedPoints(deformed)
    source.SetWeights(weights)
    return source


def connect(deforming, image, handles):
    """Connect a filter to an image (data or algorithm) and control points."""
    for port, source in enumerate((image, handles)):
        if hasattr(source, "GetOutputPort"):
            deforming.SetInputConnection(port, source.GetOutputPort())
        else:
            deforming.SetInputDataObject(port, source)
    return deforming


def update(algorithm):
    """The output after an update."""
    assert algorithm.GetExecutive().Update()
    return algorithm.GetOutputDataObject(0)


def values_of(image, name):
    """A point array of an image as (nz, ny, nx) or (nz, ny, nx, components) array."""
    values = arrays.to_numpy(image.GetPointData().GetArray(name))
    return values.reshape(image.GetDimensions()[::-1] + values.shape[1:])


class Executions:
    """Counts how often an algorithm runs."""

    def __init__(self, algorithm):
        self.count = 0
        algorithm.AddObserver("StartEvent", self._add)

    def _add(self, *_):
        self.count += 1


def ball(center, radius, resolution=30, normals=True):
    """The surface of a ball."""
    source = vtkSphereSource()
    source.SetCenter(*center)
    source.SetRadius(radius)
    source.SetThetaResolution(resolution)
    source.SetPhiResolution(resolution)
    source.SetGenerateNormals(normals)
    return update(source)


def picture_of(window):
    """The picture in a vtkRenderWindow: (height, width, 3) float, 0 to 255."""
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()
    image = update(grab)
    width, height, _ = image.GetDimensions()
    pixels = arrays.to_numpy(image.GetPointData().GetScalars())
    return pixels.reshape(height, width, -1)[..., :3].astype(float)
