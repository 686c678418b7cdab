"""Surfaces and curves that move, as data of VTK. Tests import them."""

from __future__ import annotations

import numpy as np
from vtk_fixtures import add_array, polydata_of
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkMassProperties, vtkTriangleFilter
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of


def ball(center, radius=1.0, resolution=16):
    """A closed surface, a vtkPolyData."""
    source = configured(vtkSphereSource(), Center=center, Radius=radius)
    configured(source, ThetaResolution=resolution, PhiResolution=resolution)
    return output_of(source, OutputPointsPrecision=1)  # double


def transform(turn=30.0, axis=(1, 2, 3), move=(0.5, 0.2, -0.3)):
    """A vtkTransform: a rotation, then a translation."""
    result = vtkTransform()
    result.PostMultiply()
    result.RotateWXYZ(turn, axis)
    result.Translate(move)
    return result


def carried(surface, by):
    """The surface where a vtkTransform moves it."""
    return output_of(vtkTransformFilter(), InputData=surface, Transform=by)


def moved(surface, by):
    """The surface with point vectors "Displacement" to where a vtkTransform moves it."""
    return displaced(surface, positions(carried(surface, by)) - positions(surface))


def displaced(surface, displacement):
    """The surface with point vectors "Displacement"."""
    copy = vtkPolyData()
    copy.DeepCopy(surface)
    copy.GetPointData().Initialize()
    shape = (surface.GetNumberOfPoints(), 3)
    values = np.broadcast_to(np.asarray(displacement, float), shape)
    add_array(copy.GetPointData(), "Displacement", values)
    return copy


def polyline(nodes, displacement=(0, 0, 0), kind="Lines"):
    """One cell of points (n, 3), with their displacement."""
    return displaced(polydata_of(nodes, **{kind: [range(len(nodes))]}), displacement)


def soup(surface):
    """The triangles of a surface, each with corners of its own, as in .stl files."""
    corners = positions(surface)[arrays.to_numpy(surface.GetPolys().GetConnectivityArray())]
    return polydata_of(corners, Polys=np.arange(len(corners)).reshape(-1, 3).tolist())


def joined(*parts):
    """One vtkPolyData of several."""
    append = vtkAppendPolyData()
    for part in parts:
        append.AddInputData(part)
    return output_of(append, OutputPointsPrecision=1)


def positions(point_set):
    """(n, 3) float64"""
    return arrays.to_numpy(point_set.GetPoints().GetData()).astype(float)


def volume(surface):
    """By VTK's mass properties."""
    triangles, mass = vtkTriangleFilter(), vtkMassProperties()
    triangles.SetInputData(surface)
    mass.SetInputConnection(triangles.GetOutputPort())
    mass.Update()
    return mass.GetVolume()
