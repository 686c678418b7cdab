"""Measure vtk_mls against other programs, side by side in one run.

Four questions, each asked of everyone who can answer it, with 15 handles:

- the displacement map of a grid (the paper's Table 1);
- a volume, deformed: one filter from image to image;
- points, moved forward by the inverse of the map that deforms the volume, as many as the grid has;
- a mesh of two million tetrahedra, likewise: one filter from mesh to mesh. What a cut splits is
  kept from run to run, as it is while control points are dragged.

Cuts (of the rigid kind) are in the rest frame, and in the deformed one as the paper has them. Maps
"within 0.02" have that map tolerance.

Everyone runs once to warm up (kernels are built, threads started) and then several times, in
turns; the smallest and the median time are printed, and the smallest processor time of all threads
as a multiple of the rigid kind's: what else the machine does hardly changes that. VTK's filters use
its thread pool (STDThread).
"""

from __future__ import annotations

import argparse
import statistics
import time
from dataclasses import replace

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import VTK_FLOAT, vtkPoints, vtkSMPTools
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkPolyData
from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersHybrid import vtkTransformToGrid
from vtkmodules.vtkFiltersSources import vtkCellTypeSource
from vtkmodules.vtkImagingCore import vtkImageReslice, vtkRTAnalyticSource

import vtk_mls
from vtk_mls.engine.dispatch import engine_for
from vtk_mls.filters import MLSControlPoints, MLSDeform

HANDLES = 15
TOLERANCE = 0.02  # voxels
KINDS = {
    "affine": {"kind": "affine"},
    "rigid": {"kind": "rigid"},
    "similarity": {"kind": "similarity"},
    "polynomial, degree 2": {"kind": "polynomial", "degree": 2},
    "polynomial, degree 3": {"kind": "polynomial", "degree": 3},
}
# Table 1 of the paper, milliseconds on its GPU (GeForce 8800 Ultra) and its CPU (2 GHz).
PAPER = {
    ("64^3", "affine"): (4, 633),
    ("64^3", "rigid"): (8, 1125),
    ("64^3", "similarity"): (8, 1133),
    ("64^3", "polynomial, degree 2"): (102, 9270),
    ("128^3", "affine"): (15, 4868),
    ("128^3", "rigid"): (45, 8779),
    ("128^3", "similarity"): (45, 8976),
    ("128^3", "polynomial, degree 2"): (460, 117180),
    ("256^3", "affine"): (104, 38550),
    ("256^3", "rigid"): (325, 69970),
    ("256^3", "similarity"): (325, 70550),
    ("256^3", "polynomial, degree 2"): (730, 793000),
}
# How many times quicker we want to be.
GOALS = {
    "vtkTransformToGrid (TPS)": 5,
    "vtkImageReslice (TPS)": 3,
    "vtkTransformFilter (TPS)": 1,
    "vtkTransformFilter (TPS^-1)": 5,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--large", action="store_true", help="also 256^3")
    arguments = parser.parse_args()
    vtkSMPTools.SetBackend("STDThread")
    absent = [name for name, peer in OPTIONAL.items() if peer(*_handles(8), 8) is None]
    print(f"vtk_mls {vtk_mls.__version__} on {engine_for().NAME}; {HANDLES} handles")
    print(
        f"VTK on {vtkSMPTools.GetEstimatedNumberOfThreads()} threads ({vtkSMPTools.GetBackend()})"
    )
    for name in absent:
        print(f"Not installed here, so not measured: {name} (pip install 'vtk-mls[bench]')")
    ratios = []
    for n in (64, 128, 256) if arguments.large else (64, 128):
        ratios += _compare(f"displacement map, {n}^3", f"{n}^3", _maps(n))
        ratios += _compare(f"deformed volume, {n}^3", f"{n}^3", _volumes(n))
        ratios += _compare(f"points moved forward, {n}^3", f"{n}^3", _points(n))
    ratios += _compare("mesh of 2 million tetrahedra (341,991 points)", "mesh", _meshes(55))
    print("\nTimes of VTK's thin-plate spline over ours (rigid)")
    for line in ratios:
        print(line)


def _maps(n):
    """Everyone who makes a displacement map, as (name, function)."""
    rest, deformed = _handles(n)
    for name, ours in _ours(n):
        yield name, lambda ours=ours: ours.displacement_field((n, n, n))
    to_grid = vtkTransformToGrid()
    to_grid.SetInput(_spline(rest, deformed))
    to_grid.SetGridExtent(0, n - 1, 0, n - 1, 0, n - 1)
    to_grid.SetGridScalarTypeToFloat()
    yield "vtkTransformToGrid (TPS)", lambda: _again(to_grid)
    for name, peer in OPTIONAL.items():
        function = peer(rest, deformed, n)
        if function is not None:
            yield name, function


def _volumes(n):
    """Everyone who deforms an image, as (name, function)."""
    rest, deformed = _handles(n)
    source = vtkRTAnalyticSource()
    source.SetWholeExtent(0, n - 1, 0, n - 1, 0, n - 1)
    source.SetCenter(n / 2, n / 2, n / 2)
    source.Update()
    image = source.GetOutput()
    for name, value in _ours(n):
        deform = _filter(image, value)
        yield name, lambda deform=deform: _again(deform)
    for name, cut in (("rigid, Gradient", []), ("half-plane, Gradient", [_half_plane(n)])):
        deform = _filter(image, vtk_mls.Deformation(rest, deformed, cuts=cut))
        deform.SetGradientArray("RTData")
        yield name, lambda deform=deform: _again(deform)
    reslice = vtkImageReslice()
    reslice.SetInputDataObject(0, image)
    reslice.SetResliceTransform(_spline(rest, deformed))
    reslice.SetInterpolationModeToLinear()
    yield "vtkImageReslice (TPS)", lambda: _again(reslice)


def _points(n):
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


def _meshes(n):
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


OPTIONAL = {"scipy RBFInterpolator": _scipy, "molesq (affine MLS)": _molesq}


def _compare(title, size, peers):
    """Measure and print one table; the lines for the summary."""
    papers = {name: t for (n, name), t in PAPER.items() if n == size and "map" in title}
    print(f"\n{title}, milliseconds")
    print(f"{'':36}{'smallest':>10}{'median':>10}{'x rigid':>10}{'processor':>10}", end="")
    print(f"{'paper GPU':>12}{'paper CPU':>12}" if papers else "")
    times = _measure(dict(peers))
    for name, (smallest, median, processor) in times.items():
        columns = "".join(f"{t:12.0f}" for t in papers.get(name, ()))
        ratio, share = smallest / times["rigid"][0], processor / times["rigid"][2]
        print(f"{name:36}{smallest:10.1f}{median:10.1f}{ratio:10.2f}{share:10.2f}{columns}")
    lines = []
    for spline in GOALS.keys() & times.keys():
        smallest, median = (times[spline][i] / times["rigid"][i] for i in (0, 1))
        line = f"  {spline:36}{size:>7}{smallest:8.1f} of the smallest,{median:6.1f} of the medians"
        lines.append(line + (f"   (goal: at least {GOALS[spline]})" if size == "128^3" else ""))
    return sorted(lines)


def _measure(functions, seconds=2.0, least=5, most=30):
    """Milliseconds of each function, after one run to warm up.

    The smallest and the median time, and the smallest processor time of all threads.

    They take turns, so that what else the machine does meets them all alike.
    """
    times, processor = ({name: [] for name in functions} for _ in range(2))
    for function in functions.values():
        function()
    for turn in range(most):
        for name, function in functions.items():
            if turn < least or sum(times[name]) < seconds:
                start, used = time.perf_counter(), time.process_time()
                function()
                times[name].append(time.perf_counter() - start)
                processor[name].append(time.process_time() - used)
    return {
        name: (1000 * min(t), 1000 * statistics.median(t), 1000 * min(processor[name]))
        for name, t in times.items()
    }


def _handles(n):
    """Random handles in a cube of n voxels, moved by some percent of its size."""
    random = np.random.default_rng(1)
    rest = random.uniform(0.1 * n, 0.9 * n, (HANDLES, 3))
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


if __name__ == "__main__":
    main()
