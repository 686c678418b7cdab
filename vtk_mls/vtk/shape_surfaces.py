"""Closed surfaces of the shapes of rigid regions, to draw and to write them."""

import functools

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkFlyingEdges3D, vtkTriangleFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls.base.grid import Grid
from vtk_mls.base.linear_algebra import unit
from vtk_mls.model.handles.shapes import Solid
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import connectivity_of, positions_of
from vtk_mls.vtk.objects import configured, output_of

_RESOLUTION = 32  # around a ball


@functools.lru_cache(maxsize=64)
def surface_of(shape):
    """Points (n, 3), world coordinates, and triangles (m, 3) of the closed surface of a Shape.

    Balls and capsules are polyhedra with their corners on the shape; of other shapes without a
    surface of their own, it is the contour of their distance image.
    """
    if isinstance(shape, Solid):
        return shape.points, shape.triangles
    return _of_capsule(shape) if shape.image is None else _of_image(shape.image)


def triangles_of(algorithm):
    """Points (n, 3) and triangles (m, 3) of an algorithm's polygons; coincident points are one."""
    clean = configured(vtkCleanPolyData(), ConvertLinesToPoints=False, ConvertPolysToLines=False)
    configured(clean, ToleranceIsAbsolute=True, AbsoluteTolerance=0)
    clean.SetInputConnection(algorithm.GetOutputPort())
    triangulate = configured(vtkTriangleFilter(), PassVerts=False, PassLines=False)
    surface = output_of(triangulate, InputConnection=clean.GetOutputPort())
    if surface.GetNumberOfPolys() == 0:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    connectivity, _ = connectivity_of(surface.GetPolys())
    return positions_of(surface).astype(float), connectivity.reshape(-1, 3).astype(np.int64)


def _of_capsule(shape):
    """A sphere whose halves are moved to the ends of the segment."""
    source = configured(vtkSphereSource(), Radius=1.0, ThetaResolution=_RESOLUTION)
    source.SetPhiResolution(_RESOLUTION)  # even: no points between the halves
    source.SetOutputPointsPrecision(vtkSphereSource.DOUBLE_PRECISION)
    points, triangles = triangles_of(source)
    along = shape.b - shape.a
    axis = unit(along) if along.any() else np.array((0.0, 0.0, 1.0))
    across = unit(np.cross(axis, np.eye(3)[np.abs(axis).argmin()]))
    frame = np.stack([across, np.cross(axis, across), axis])
    ends = np.where(points[:, 2:] > 0, shape.b, shape.a)
    return ends + shape.radius * np.einsum("ni,ij->nj", points, frame), triangles


def _of_image(distances):
    """The contour of a DistanceImage at 0."""
    grid = distances.grid
    # in indices, and taken to the world afterwards, which also keeps the frame
    image = arrays.ImageGeometry.of_grid(Grid(grid.dimensions)).apply_to(vtkImageData())
    arrays.add(image.GetPointData(), "distance", distances.values.ravel())
    image.GetPointData().SetActiveScalars("distance")
    contour = configured(vtkFlyingEdges3D(), ComputeNormals=False, ComputeGradients=False)
    contour.SetInputData(image)
    contour.SetValue(0, 0.0)
    points, triangles = triangles_of(contour)
    # the distance grows outwards, and normals are to point there
    is_mirrored = np.linalg.det(grid.index_to_world) < 0
    return grid.at(points), triangles if is_mirrored else triangles[:, ::-1]
