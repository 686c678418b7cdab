"""Other programs that deform grids, images and meshes, as functions of control points.

A function does its job once and may be called again and again.
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersHybrid import vtkTransformToGrid
from vtkmodules.vtkImagingCore import vtkImageReslice

import vtk_mls


def again(algorithm):
    """Update one of VTK's algorithms that is up to date."""
    algorithm.Modified()
    algorithm.Update()


def spline(rest, deformed):
    """VTK's thin-plate spline, backward as ours: from the deformed to the rest positions."""
    transform = vtkThinPlateSplineTransform()
    transform.SetBasisToR()
    transform.SetSourceLandmarks(_vtk_points(deformed))
    transform.SetTargetLandmarks(_vtk_points(rest))
    return transform


def _vtk_points(array):
    points = vtkPoints()
    points.SetData(numpy_to_vtk(array, deep=True))
    return points


def to_grid(n, rest, deformed):
    """VTK's displacement field of a spline on a grid of n^3."""
    filter_ = vtkTransformToGrid()
    filter_.SetInput(spline(rest, deformed))
    filter_.SetGridExtent(0, n - 1, 0, n - 1, 0, n - 1)
    filter_.SetGridScalarTypeToFloat()
    return filter_


def reslice(image, rest, deformed):
    """VTK's image under a spline."""
    filter_ = vtkImageReslice()
    filter_.SetInputDataObject(0, image)
    filter_.SetResliceTransform(spline(rest, deformed))
    filter_.SetInterpolationModeToLinear()
    return filter_


def transform_filters(mesh, rest, deformed):
    """VTK's splines: one made to go forward, and the inverse of the one that deforms volumes."""
    own = mesh.NewInstance()  # VTK's filters touch their input, which would undo what ours keep
    own.DeepCopy(mesh)
    forward, inverse = spline(deformed, rest), spline(rest, deformed)
    inverse.Inverse()
    for name, transform in {"(TPS)": forward, "(TPS^-1)": inverse}.items():
        move = vtkTransformFilter()
        move.SetInputData(own)
        move.SetTransform(transform)
        yield f"vtkTransformFilter {name}", lambda move=move: again(move)


def set_landmarks(transform, source, target):
    """Fit a kernel transform of ITK that leads from source to target points."""

    def landmarks(points):
        out = type(transform.GetSourceLandmarks()).New()
        for number, point in enumerate(points.tolist()):
            out.SetPoint(number, point)
        return out

    transform.SetSourceLandmarks(landmarks(source))
    transform.SetTargetLandmarks(landmarks(target))
    transform.ComputeWMatrix()


def _itk(rest, deformed, n):
    import itk

    transform = itk.ThinPlateSplineKernelTransform[itk.D, 3].New()
    set_landmarks(transform, deformed, rest)
    field = itk.Image[itk.Vector[itk.F, 3], 3]
    to_field = itk.TransformToDisplacementFieldFilter[field, itk.D].New()
    to_field.SetTransform(transform)
    to_field.SetSize([n] * 3)
    to_field.SetOutputSpacing([1.0] * 3)
    to_field.SetOutputOrigin([0.0] * 3)
    return lambda: again(to_field)


def _scipy(rest, deformed, n):
    from scipy.interpolate import RBFInterpolator

    interpolator = RBFInterpolator(deformed, rest - deformed, kernel="linear", degree=1)
    points = vtk_mls.Grid((n, n, n)).points()
    return lambda: interpolator(points)


def _molesq(rest, deformed, n):
    from molesq import Transformer

    affine = Transformer(deformed, rest)
    points = vtk_mls.Grid((n, n, n)).points()
    parts = np.array_split(points, max(1, len(points) // 2**16))  # it holds all pairs in memory
    return lambda: [affine.transform(part) for part in parts]


# Packages, and makers of functions for displacements on a grid of n^3.
OPTIONAL = {
    "ITK displacement field (TPS)": ("itk", _itk),
    "scipy RBFInterpolator": ("scipy", _scipy),
    "molesq (affine MLS)": ("molesq", _molesq),
}


def absent():
    """Names of other programs that are not installed here."""
    return [name for name, (package, _) in OPTIONAL.items() if not find_spec(package)]
