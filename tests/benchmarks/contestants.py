"""Who takes part in the benchmark: ours and other programs, as pairs (name, function).

A function does its job once and may be called again and again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import peers
from operations import HANDLES, handles
from peers import again
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkPolyData
from vtkmodules.vtkFiltersSources import vtkCellTypeSource
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

import vtk_mls
from vtk_mls.filters import MLSControlPoints, MLSDeform
from vtk_mls.model.options import named
from vtk_mls.rendering.map_layers import layers
from vtk_mls.rendering.pace import MapPace
from vtk_mls.vtk.objects import configured, output_of

TOLERANCE = 0.02  # voxels
TOLERANCES = {"": 0, f", within {TOLERANCE}": TOLERANCE}  # by the ending of a row's name
KINDS = {
    "affine": {"kind": "affine"},
    "rigid": {"kind": "rigid"},
    "similarity": {"kind": "similarity"},
    "polynomial, degree 2": {"kind": "polynomial", "degree": 2},
    "polynomial, degree 3": {"kind": "polynomial", "degree": 3},
}


def maps(n):
    """Everyone who makes a displacement map, as (name, function)."""
    rest, deformed = handles(n)
    for name, ours in _ours(n):
        yield name, lambda ours=ours: ours.displacement_field((n, n, n))
    for name, options in {**_features(n), "16 steps": {"steps": 16}}.items():
        ours = vtk_mls.Deformation(rest, deformed, **options)
        yield f"rigid, {name}", lambda ours=ours: ours.displacement_field((n, n, n))
    to_grid = peers.to_grid(n, rest, deformed)
    yield "vtkTransformToGrid (TPS)", lambda: again(to_grid)
    absent = peers.absent()
    for name, (_, peer) in peers.OPTIONAL.items():
        if name not in absent:
            yield name, peer(rest, deformed, n)


def own_maps(n):
    """The kinds of the paper, exact and within a tolerance, as (name, function)."""
    for name, ours in _ours(n):
        if name.removesuffix(f", within {TOLERANCE}") in tuple(KINDS)[:4]:
            yield name, lambda ours=ours: ours.displacement_field((n, n, n))


def maps_by_grid(sizes):
    """The rigid map of growing grids, as (name, function)."""
    for n in sizes:
        for told, tolerance in TOLERANCES.items():
            ours = vtk_mls.Deformation(*handles(n), map_tolerance=tolerance)
            yield f"{n}^3{told}", lambda ours=ours, n=n: ours.displacement_field((n, n, n))


def maps_by_alpha(n):
    """Maps of a grid by alpha, as (name, function)."""
    for name in ("affine", "rigid", "polynomial, degree 2"):
        for alpha in (0.5, 0.75, 1.0, 1.5, 2.0, 3.0):
            ours = vtk_mls.Deformation(*handles(n), alpha=alpha, **KINDS[name])
            yield f"{name}, {alpha:g}", lambda ours=ours: ours.displacement_field((n, n, n))


def volumes(n):
    """Everyone who deforms an image, as (name, function)."""
    rest, deformed = handles(n)
    image = _image(n)
    for name, value in _ours(n):
        deform = _filter(image, value)
        yield name, lambda deform=deform: again(deform)
    for name, cut in (("rigid, Gradient", []), ("half-plane, Gradient", [_half_plane(n)])):
        deform = _filter(image, vtk_mls.Deformation(rest, deformed, cuts=cut))
        deform.SetGradientArray("RTData")
        yield name, lambda deform=deform: again(deform)
    reslice = peers.reslice(image, rest, deformed)
    yield "vtkImageReslice (TPS)", lambda: again(reslice)


def points(n):
    """Everyone who moves points forward, as (name, function)."""
    rest, deformed = handles(n)
    random = np.random.default_rng(2)
    # as near to each other in memory as those of a mesh are
    points = vtk_mls.Grid((n, n, n)).points() + random.uniform(-0.5, 0.5, (n**3, 3))
    points = points.astype(np.float32)
    for name, ours in (*_kinds(n), *_cut(n)):
        yield name, lambda ours=ours: ours.forward_field(points)
    mesh, places = vtkPolyData(), vtkPoints()
    places.SetData(numpy_to_vtk(points))
    mesh.SetPoints(places)
    yield from peers.transform_filters(mesh, rest, deformed)


def meshes(n):
    """Everyone who deforms a mesh of n^3 blocks of 12 tetrahedra, as (name, function)."""
    rest, deformed = handles(n)
    blocks = configured(vtkCellTypeSource(), CellType=VTK_TETRA)
    blocks.SetBlocksDimensions(n, n, n)
    mesh = output_of(blocks)
    ours = _deform(mesh, rest, deformed)
    yield "rigid", lambda: again(ours)
    cut = _deform(mesh, rest, deformed)
    cut.AddCut(_half_plane(n))
    yield "half-plane", lambda: again(cut)
    yield from peers.transform_filters(mesh, rest, deformed)


def maps_by_steps(n):
    """The rigid map of a grid by growing numbers of steps, as (name, function)."""
    for steps in (1, 4, 16, 64):
        for told, tolerance in TOLERANCES.items():
            ours = vtk_mls.Deformation(*handles(n), steps=steps, map_tolerance=tolerance)
            yield f"{steps}{told}", lambda ours=ours: ours.displacement_field((n, n, n))


def maps_of_many(n, most):
    """The rigid map of a grid by growing numbers of control points, as (name, function)."""
    for count in (4, 15, 64, 256, 1024, 20_000, 100_000):
        if count > most:
            return
        rest, deformed = handles(n, count)
        for told, tolerance in TOLERANCES.items():
            ours = vtk_mls.Deformation(rest, deformed, map_tolerance=tolerance)
            yield f"{count}{told}", lambda ours=ours: ours.displacement_field((n, n, n))
        if count <= 1024:  # it solves a full system of equations
            to_grid = peers.to_grid(n, rest, deformed)
            yield f"{count}, vtkTransformToGrid (TPS)", lambda to_grid=to_grid: again(to_grid)


def maps_with_cuts(n):
    """The rigid map of a grid by growing numbers of parallel cuts, as (name, function)."""
    rest, deformed = handles(n)
    for count in (0, 1, 2, 4, 8):
        places = [(n * (k + 1) / (count + 1), n / 2, n / 2) for k in range(count)]
        planes = [vtk_mls.Plane(place, (1, 0, 0)) for place in places]
        halves = [vtk_mls.HalfPlane(place, (1, 0, 0), (0, 0, 1)) for place in places]
        for what, cuts in (("planes", planes), ("half-planes", halves)):
            # of full planes there can be six; no cut is no cut
            if count <= 4 if what == "planes" else count:
                ours = vtk_mls.Deformation(rest, deformed, cuts=cuts)
                yield f"{count} {what}", lambda ours=ours: ours.displacement_field((n, n, n))


def drags(n):
    """A volume while one control point is dragged on, as (name, function)."""
    rest, deformed = handles(n)
    image = _image(n)
    for name, tolerance, cut in (
        ("rigid", 0, []),
        (f"rigid, within {TOLERANCE}", TOLERANCE, []),
        ("half-plane", 0, [_half_plane(n)]),
    ):
        value = vtk_mls.Deformation(rest, deformed, cuts=cut, map_tolerance=tolerance)
        deform = _filter(image, value)
        source, places = deform.GetInputAlgorithm(1, 0), _dragged(n, deformed)

        def drag(deform=deform, source=source, places=places):
            source.SetDeformedPoints(next(places).tolist())
            deform.Update()

        yield name, drag
    reslice = peers.reslice(image, rest, deformed)
    places = _dragged(n, deformed)

    def drag_spline():
        reslice.SetResliceTransform(peers.spline(rest, next(places)))
        reslice.Update()

    yield "vtkImageReslice (TPS)", drag_spline


def live_maps():
    """What a renderer draws through while a control point is dragged, as (name, function).

    At all nodes, and at as many as `MapPace` lets it have while the mouse moves.
    """
    n = 64
    grid = vtk_mls.Grid((n, n, n))
    plane = vtk_mls.Plane((n / 2, n / 2, n / 2), (1, 0.1, 0.2))
    for name, count, options in (
        ("rigid", HANDLES, {}),
        ("rigid, 500 control points", 500, {}),
        ("plane", HANDLES, {"cuts": [plane]}),
        ("half-plane", HANDLES, {"cuts": [_half_plane(n)]}),
        *((name, HANDLES, options) for name, options in _features(n).items()),
    ):
        rest, deformed = handles(n, count)
        places, pace = _dragged(n, deformed), MapPace(n)

        def make(nodes, options=options, rest=rest, places=places):
            value = vtk_mls.Deformation(rest, next(places), **options)
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
    source = configured(vtkRTAnalyticSource(), Center=[n / 2] * 3)
    source.SetWholeExtent(0, n - 1, 0, n - 1, 0, n - 1)
    return output_of(source)


def _ours(n):
    """What deforms grids, as (name, Deformation): kinds, cuts, alpha, maps within a tolerance."""
    kinds, cuts = dict(_kinds(n)), dict(_cut(n))
    yield from {**kinds, **cuts}.items()
    for name in ("affine", "polynomial, degree 2"):
        yield f"{name}, alpha 1", replace(kinds[name], alpha=1.0)
    for name in ("affine", "rigid", "polynomial, degree 2", "half-plane"):
        value = {**kinds, **cuts}[name]
        yield f"{name}, within {TOLERANCE}", replace(value, map_tolerance=TOLERANCE)


def _kinds(n):
    """Every kind, as (name, Deformation)."""
    for name, options in KINDS.items():
        yield name, vtk_mls.Deformation(*handles(n), **options)


def _features(n):
    """Options of maps with more than control points and cuts, by the name in a row."""
    along = np.linspace(0.2 * n, 0.8 * n, 17)
    line = np.stack([along, 0.3 * n + 0.1 * n * np.sin(along), along], axis=1)
    turn = np.eye(4)
    turn[:3, 3] = 0.03 * n
    places = [np.where([a, b, 0], 0.75, 0.25) * n for a in (0, 1) for b in (0, 1)]
    balls = [vtk_mls.RegionHandle(vtk_mls.Ball(place, 0.08 * n), turn) for place in places]
    return {
        "4 steps": {"steps": 4},
        "a curve of 16 segments": {"handles": [vtk_mls.CurveHandle(line, line + 0.03 * n)]},
        "4 regions": {"handles": balls},
        "a mask": {"mask": vtk_mls.BallMask([n / 2] * 3, 0.3 * n, 0.1 * n)},
    }


def _half_plane(n):
    return vtk_mls.HalfPlane((n / 2, n / 2, n / 2), (0, 0, 1), (1, 0, 0))


def _cut(n):
    """Rigid deformations with a cut in one of the frames, as (name, Deformation)."""
    rest, deformed = handles(n)
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
    for name in ("kind", "degree", "alpha", "map_tolerance", "cut_frame"):
        configured(deform, **{named(name).property_name: getattr(value, name)})
    for cut in value.cuts:
        deform.AddCut(cut)
    return deform


def _deform(data, rest, deformed):
    source = configured(MLSControlPoints(), RestPoints=rest, DeformedPoints=deformed)
    deform = configured(MLSDeform(), InputData=data)
    deform.SetInputConnection(1, source.GetOutputPort())
    return deform
