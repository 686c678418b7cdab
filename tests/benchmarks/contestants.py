"""Who takes part in the benchmark: ours and other programs, as pairs (name, function).

A function does its job once and may be called again and again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import VTK_FLOAT, vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkPolyData
from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersHybrid import vtkTransformToGrid
from vtkmodules.vtkFiltersSources import vtkCellTypeSource
from vtkmodules.vtkImagingCore import vtkImageReslice, vtkRTAnalyticSource

import vtk_mls
from vtk_mls.filters import MLSControlPoints, MLSDeform
from vtk_mls.rendering.map_layers import layers
from vtk_mls.rendering.map_pace import MapPace

HANDLES = 15
TOLERANCE = 0.02  # voxels
KINDS = {
    "affine": {"kind": "affine"},
    "rigid": {"kind": "rigid"},
    "similarity": {"kind": "similarity"},
    "polynomial, degree 2": {"kind": "polynomial", "degree": 2},
    "polynomial, degree 3": {"kind": "polynomial", "degree": 3},
}


def maps(n):
    """Everyone who makes a displacement map, as (name, function)."""
    rest, deformed = _handles(n)
    for name, ours in _ours(n):
        yield name, lambda ours=ours: ours.displacement_field((n, n, n))
    to_grid = _to_grid(n, rest, deformed)
    yield "vtkTransformToGrid (TPS)", lambda: _again(to_grid)
    for name, peer in OPTIONAL.items():
        function = peer(rest, deformed, n)
        if function is not None:
            yield name, function


def volumes(n):
    """Everyone who deforms an image, as (name, function)."""
    rest, deformed = _handles(n)
    image = _image(n)
    for name, value in _ours(n):
        deform = _filter(image, value)
        yield name, lambda deform=deform: _again(deform)
    for name, cut in (("rigid, Gradient", []), ("half-plane, Gradient", [_half_plane(n)])):
        deform = _filter(image, vtk_mls.Deformation(rest, deformed, cuts=cut))
        deform.SetGradientArray("RTData")
        yield name, lambda deform=deform: _again(deform)
    reslice = _reslice(image, rest, deformed)
    yield "vtkImageReslice (TPS)", lambda: _again(reslice)


def points(n):
    """Everyone who moves points forward, as (name, function)."""
    rest, deformed = _handles(n)
    random = np.random.default_rng(2)
    # as near to each other in memory as those of a mesh are
    points = vtk_mls.Grid((n, n, n)).points() + random.uniform(-0.5, 0.5, (n**3, 3))
    points = points.astype(np.float32)
    for name, ours in (*_kinds(n), *_cut(n)):
        yield name, lambda ours=ours: ours.forward_field(points)
    mesh, places = vtkPolyData(), vtkPoints()
    places.SetData(numpy_to_vtk(points))
    mesh.SetPoints(places)
    yield from _transform_filters(mesh, rest, deformed)


def meshes(n):
    """Everyone who deforms a mesh of n^3 blocks of 12 tetrahedra, as (name, function)."""
    rest, deformed = _handles(n)
    blocks = vtkCellTypeSource()
    blocks.SetCellType(VTK_TETRA)
    blocks.SetBlocksDimensions(n, n, n)
    blocks.Update()
    mesh = blocks.GetOutput()
    ours = _deform(mesh, rest, deformed)
    yield "rigid", lambda: _again(ours)
    cut = _deform(mesh, rest, deformed)
    cut.AddCut(_half_plane(n))
    yield "half-plane", lambda: _again(cut)
    yield from _transform_filters(mesh, rest, deformed)


def maps_of_many(n, most):
    """The rigid map of a grid by growing numbers of control points, as (name, function)."""
    for count in (4, 15, 64, 256, 1024, 10_000, 100_000):
        if count > most:
            return
        rest, deformed = _handles(n, count)
        for told, tolerance in (("", 0), (f", within {TOLERANCE}", TOLERANCE)):
            ours = vtk_mls.Deformation(rest, deformed, map_tolerance=tolerance)
            yield f"{count}{told}", lambda ours=ours: ours.displacement_field((n, n, n))
        if count <= 1024:  # it solves a full system of equations
            to_grid = _to_grid(n, rest, deformed)
            yield f"{count}, vtkTransformToGrid (TPS)", lambda to_grid=to_grid: _again(to_grid)


def maps_with_cuts(n):
    """The rigid map of a grid by growing numbers of parallel cuts, as (name, function)."""
    rest, deformed = _handles(n)
    for count in (0, 1, 2, 4, 8):
        places = [(n * (k + 1) / (count + 1), n / 2, n / 2) for k in range(count)]
        planes = [vtk_mls.Plane(each, (1, 0, 0)) for each in places]
        halves = [vtk_mls.HalfPlane(each, (1, 0, 0), (0, 0, 1)) for each in places]
        for what, cuts in (("planes", planes), ("half-planes", halves)):
            # of full planes there can be six; no cut is no cut
            if count <= 4 if what == "planes" else count:
                ours = vtk_mls.Deformation(rest, deformed, cuts=cuts)
                yield f"{count} {what}", lambda ours=ours: ours.displacement_field((n, n, n))


def drags(n):
    """A volume while one control point is dragged on, as (name, function)."""
    rest, deformed = _handles(n)
    image = _image(n)
    for name, tolerance, cut in (
        ("rigid", 0, []),
        (f"rigid, within {TOLERANCE}", TOLERANCE, []),
        ("half-plane", 0, [_half_plane(n)]),
    ):
        value = vtk_mls.Deformation(rest, deformed, cuts=cut, map_tolerance=tolerance)
        deform = _filter(image, value)
        handles, places = deform.GetInputAlgorithm(1, 0), _dragged(n, deformed)

        def drag(deform=deform, handles=handles, places=places):
            handles.SetDeformedPoints(next(places).tolist())
            deform.Update()

        yield name, drag
    reslice = _reslice(image, rest, deformed)
    places = _dragged(n, deformed)

    def drag_spline():
        reslice.SetResliceTransform(_spline(rest, next(places)))
        reslice.Update()

    yield "vtkImageReslice (TPS)", drag_spline


def live_maps():
    """What a renderer draws through while a control point is dragged, as (name, function).

    At all nodes, and at as many as `MapPace` lets it have while the mouse moves.
    """
    n = 64
    grid = vtk_mls.Grid((n, n, n))
    for name, count, cuts in (
        ("rigid", HANDLES, []),
        ("rigid, 500 control points", 500, []),
        ("plane", HANDLES, [vtk_mls.Plane((n / 2, n / 2, n / 2), (1, 0.1, 0.2))]),
        ("half-plane", HANDLES, [_half_plane(n)]),
    ):
        rest, deformed = _handles(n, count)
        places, pace = _dragged(n, deformed), MapPace(n)

        def make(nodes, cuts=cuts, rest=rest, places=places):
            value = vtk_mls.Deformation(rest, next(places), cuts=cuts)
            spacing = (n - 1) / (nodes - 1)
            layers(value, vtk_mls.Grid((nodes,) * 3, spacing=(spacing,) * 3) if nodes < n else grid)

        yield name, lambda make=make: make(n)
        yield f"{name}, as fine as the mouse allows", lambda make=make, p=pace: p.make(make, True)


def _dragged(n, deformed):
    """Positions of the control points, the first on its way round, without an end."""
    angle = 0.0
    while True:
        angle += 0.1
        moved = deformed.copy()
        moved[0] += 0.05 * n * np.array([np.cos(angle), np.sin(angle), 0])
        yield moved


def _image(n):
    source = vtkRTAnalyticSource()
    source.SetWholeExtent(0, n - 1, 0, n - 1, 0, n - 1)
    source.SetCenter(n / 2, n / 2, n / 2)
    source.Update()
    return source.GetOutput()


def _to_grid(n, rest, deformed):
    to_grid = vtkTransformToGrid()
    to_grid.SetInput(_spline(rest, deformed))
    to_grid.SetGridExtent(0, n - 1, 0, n - 1, 0, n - 1)
    to_grid.SetGridScalarTypeToFloat()
    return to_grid


def _reslice(image, rest, deformed):
    reslice = vtkImageReslice()
    reslice.SetInputDataObject(0, image)
    reslice.SetResliceTransform(_spline(rest, deformed))
    reslice.SetInterpolationModeToLinear()
    return reslice


def _transform_filters(mesh, rest, deformed):
    """VTK's splines: one made to go forward, and the inverse of the one that deforms volumes."""
    own = mesh.NewInstance()  # VTK's filters touch their input, which would undo what ours keep
    own.DeepCopy(mesh)
    forward, inverse = _spline(deformed, rest), _spline(rest, deformed)
    inverse.Inverse()
    for name, transform in {"(TPS)": forward, "(TPS^-1)": inverse}.items():
        move = vtkTransformFilter()
        move.SetInputData(own)
        move.SetTransform(transform)
        yield f"vtkTransformFilter {name}", lambda move=move: _again(move)


def _scipy(rest, deformed, n):
    try:
        from scipy.interpolate import RBFInterpolator
    except ImportError:
        return None
    spline = RBFInterpolator(deformed, rest - deformed, kernel="linear", degree=1)
    points = vtk_mls.Grid((n, n, n)).points()
    return lambda: spline(points)


def _molesq(rest, deformed, n):
    try:
        from molesq import Transformer
    except ImportError:
        return None
    affine = Transformer(deformed, rest)
    points = vtk_mls.Grid((n, n, n)).points()
    parts = np.array_split(points, max(1, len(points) // 2**16))  # it holds all pairs in memory
    return lambda: [affine.transform(part) for part in parts]


def absent():
    """Names of other programs that are not installed here."""
    return [name for name, peer in OPTIONAL.items() if peer(*_handles(8), 8) is None]


OPTIONAL = {"scipy RBFInterpolator": _scipy, "molesq (affine MLS)": _molesq}


def _handles(n, count=HANDLES):
    """Random handles in a cube of n voxels, moved by some percent of its size."""
    random = np.random.default_rng(1)
    rest = random.uniform(0.1 * n, 0.9 * n, (count, 3))
    return rest, rest + random.normal(0, 0.05 * n, rest.shape)


def _ours(n):
    """What deforms grids, as (name, Deformation): kinds, cuts, alpha, maps within a tolerance."""
    kinds, cuts = dict(_kinds(n)), dict(_cut(n))
    yield from {**kinds, **cuts}.items()
    for name in ("affine", "polynomial, degree 2"):
        yield f"{name}, alpha 2", replace(kinds[name], alpha=2.0)
    for name in ("affine", "rigid", "polynomial, degree 2", "half-plane"):
        value = {**kinds, **cuts}[name]
        yield f"{name}, within {TOLERANCE}", replace(value, map_tolerance=TOLERANCE)


def _kinds(n):
    """Every kind, as (name, Deformation)."""
    rest, deformed = _handles(n)
    for name, options in KINDS.items():
        yield name, vtk_mls.Deformation(rest, deformed, **options)


def _half_plane(n):
    return vtk_mls.HalfPlane((n / 2, n / 2, n / 2), (0, 0, 1), (1, 0, 0))


def _cut(n):
    """Rigid deformations with a cut in one of the frames, as (name, Deformation)."""
    rest, deformed = _handles(n)
    c, s = np.cos(np.radians(10)), np.sin(np.radians(10))
    turned = (rest - n / 2) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) + n / 2
    plane = vtk_mls.Plane((n / 2, n / 2, n / 2), (0, 0, 1))
    for name, cut, moved, frame in [
        ("half-plane", _half_plane(n), deformed, "rest"),
        ("half-plane, all turned", _half_plane(n), turned, "rest"),
        ("half-plane, paper's frame", _half_plane(n), deformed, "deformed"),
        ("plane", plane, deformed, "rest"),
        ("plane, paper's frame", plane, deformed, "deformed"),
    ]:
        yield name, vtk_mls.Deformation(rest, moved, cuts=[cut], cut_frame=frame)


def _filter(image, value):
    """A filter that does to an image what a Deformation does."""
    deform = _deform(image, value.rest, value.deformed)
    deform.SetKind(value.kind)
    deform.SetDegree(value.degree)
    deform.SetAlpha(value.alpha)
    deform.SetMapTolerance(value.map_tolerance)
    deform.SetCutFrame(value.cut_frame)
    for cut in value.cuts:
        deform.AddCut(cut)
    return deform


def _deform(data, rest, deformed):
    handles = MLSControlPoints()
    handles.SetRestPoints(rest.tolist())
    handles.SetDeformedPoints(deformed.tolist())
    deform = MLSDeform()
    deform.SetInputDataObject(0, data)
    deform.SetInputConnection(1, handles.GetOutputPort())
    return deform


def _spline(rest, deformed):
    """VTK's thin-plate spline, backward as ours: from the deformed to the rest positions."""
    spline = vtkThinPlateSplineTransform()
    spline.SetBasisToR()
    spline.SetSourceLandmarks(_vtk_points(deformed))
    spline.SetTargetLandmarks(_vtk_points(rest))
    return spline


def _vtk_points(array):
    points = vtkPoints()
    points.SetDataType(VTK_FLOAT)
    for point in array:
        points.InsertNextPoint(point)
    return points


def _again(algorithm):
    algorithm.Modified()
    algorithm.Update()
