"""Random shapes with limits, in images and meshes, by filters in threads."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from scenes import Scene
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPointSet

sys.path.append(str(Path(__file__).parents[1]))
from vtk_fixtures import collected_messages

import vtk_mls
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

_MISS = 3e-3  # as of checks, relative to the size of the data
_TETRAHEDRON = [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]
_THREADS = 3
_SAID = "handles are not met", "regions overlap", "stays at rest", "`background`", "is lost"
_used = []  # whether a case of this process has used a device


def check_limits(rng, device):
    """Filters show the map of `Deformation`, alone and several at a time."""
    scene = Scene(rng)
    make = (MLSDisplacementField, MLSDeform)[rng.random() < 0.7]
    data = scene.image() if rng.random() < 0.3 else scene.structured()
    rest, deformed, _ = scene.handles()
    rest, deformed = rest[:3], rest[:3] + 0.2 * (deformed - rest)[:3]
    handles = [_handle(scene) for _ in range(rng.integers(0, 3))]
    mask, faces = _mask(scene), [_face(scene) for _ in range(rng.integers(0, 2))]
    case = f"{make.__name__} of {data.GetClassName()}, {handles}, "
    case += f"{mask}, {faces} in a world of {scene.size:g}"

    def run(_=None):
        filter_ = configured(make(), InputData=data, Device=device, Mask=mask)
        configured(filter_, RestPoints=rest, DeformedPoints=deformed)
        for handle in handles:
            filter_.AddHandle(handle)
        for face in faces:
            filter_.AddConstraint(face)
        if make is MLSDisplacementField:
            filter_.SetSampleDimensions(3, 2, 4)
        done = filter_.GetExecutive().Update()
        return done, filter_.GetOutputDataObject(0)

    with collected_messages() as messages:
        results = []
        if rng.random() < 0.2 or not _used:  # also the first use of the device
            _used.append(1)
            with ThreadPoolExecutor(_THREADS) as pool:
                results = list(pool.map(run, range(_THREADS)))
        done, output = run()
    said = [line for line in messages.take().splitlines() if line.strip()]
    assert all(line.startswith("Warning: MLS") for line in said), f"{said[:2]}: {case}"
    assert all(any(words in line for words in _SAID) for line in said), f"{said[:2]}: {case}"
    assert done, f"failed: {case}"
    truth = vtk_mls.Deformation(
        rest, deformed, handles=handles, mask=mask, constraints=faces, device="reference"
    )
    for is_done, other in results:
        assert is_done, f"failed in a thread: {case}"
        assert _values(output) == _values(other), f"not the same in a thread: {case}"
    _check_map(truth, data, output, scene, case)


def _check_map(truth, before, after, scene, case):
    """Displacements are those of the specification."""
    data = after.GetPointData()
    if data.HasArray("BackwardDisplacement"):
        v = ImageGeometry.of_image(after).grid.points()
        found = v + arrays.to_numpy(data.GetArray("BackwardDisplacement"))
        miss = np.abs(truth.backward(v) - found).max(axis=1, initial=0)
    elif isinstance(after, vtkImageData):
        return  # by the tests of images
    else:
        count = before.GetNumberOfPoints()
        assert after.GetNumberOfPoints() == count, f"points are lost: {case}"
        assert after.GetNumberOfCells() == before.GetNumberOfCells(), f"cells are lost: {case}"
        x, v = (np.array([d.GetPoint(i) for i in range(count)]) for d in (before, after))
        has_inverse = arrays.to_numpy(data.GetArray("NoInverse")) == 0
        miss = np.abs(truth.backward(v) - x).max(axis=1)[has_inverse]
    bound = _MISS * scene.size + 1e-6 * np.abs(scene.low).max()
    assert (miss <= bound).all(), f"off by {miss.max() / scene.size:.2g} of the size: {case}"


def _values(data):
    """All numbers of the points."""
    found = [arrays.to_numpy(a) for a in arrays.all_arrays(data.GetPointData())]
    if isinstance(data, vtkPointSet):
        found.append(arrays.to_numpy(data.GetPoints().GetData()))
    return [values.tobytes() for values in found]


def _handle(scene):
    """A curve or a region."""
    rng, (a, b), size = scene.rng, scene.places(2), scene.size * scene.rng.uniform(0.05, 0.2)
    kind = rng.choice(5, p=[0.25, 0.25, 0.2, 0.05, 0.25])  # a Solid takes a second
    if kind == 0:
        moved = np.array([a, b]) + rng.normal(0, 0.05 * scene.size, (2, 3))
        return vtk_mls.CurveHandle([a, b], moved)
    if kind == 1:
        shape = vtk_mls.Ball(a, size)
    elif kind == 2:
        shape = vtk_mls.Capsule(a, b, size)
    elif kind == 3:
        shape = vtk_mls.Solid(a + size * np.vstack([np.zeros(3), np.eye(3)]), _TETRAHEDRON)
    else:
        mask = rng.random((4, 3, 2)) < 0.4
        mask[rng.integers(4), 0, 0] = True
        shape = vtk_mls.Labels(mask, vtk_mls.Grid((2, 3, 4), a, [size / 2] * 3))
    turn, _ = np.linalg.qr(np.eye(3) + rng.normal(0, 0.2, (3, 3)))
    turn *= np.sign(np.diagonal(turn))
    motion = np.eye(4)
    motion[:3, :3] = turn if np.linalg.det(turn) > 0 else np.eye(3)
    motion[:3, 3] = a - motion[:3, :3] @ a + rng.normal(0, 0.05 * scene.size, 3)
    return vtk_mls.RegionHandle(shape, motion)


def _mask(scene):
    rng, (low, high), size = scene.rng, np.sort(scene.places(2), axis=0), scene.size
    kind = rng.integers(4)
    if kind == 0:
        return vtk_mls.BallMask(low, size * rng.uniform(0.1, 1), size * rng.uniform(0.3, 1))
    if kind == 1:
        return vtk_mls.BoxMask(low, high, size * rng.uniform(0.3, 1))
    if kind == 2:
        grid = vtk_mls.Grid((3, 2, 4), scene.low, [size / 2, size, size / 3])
        return vtk_mls.ImageMask(rng.uniform(0.7, 1, grid.shape), grid)  # gentle: few folds
    return None


def _face(scene):
    rng = scene.rng
    plane = vtk_mls.Plane(scene.places(1)[0], rng.normal(size=3))
    kind = vtk_mls.FixedFace if rng.random() < 0.5 else vtk_mls.SlidingFace
    return kind(plane, scene.size * rng.uniform(0.3, 1))
