"""Properties that hold in every random case."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from limits import check_limits
from scenes import CONSTANT, Scene, properties_text
from tolerance import check_tolerance
from vtkmodules.vtkCommonDataModel import (
    VTK_PIXEL,
    VTK_VOXEL,
    vtkCompositeDataSet,
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPointSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkIOLegacy import vtkGenericDataObjectWriter

sys.path.append(str(Path(__file__).parents[1]))
from pipelines import Source
from vtk_fixtures import collected_messages

from vtk_mls import CUT_FRAMES, Deformation, DeviceError
from vtk_mls.base import interpolation
from vtk_mls.filters import MLSControlPoints, MLSDeform, MLSDisplacementField
from vtk_mls.model.options import named
from vtk_mls.reference.fit import fit_of
from vtk_mls.reference.weights import EvaluationPoints
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import is_empty
from vtk_mls.vtk.control_point_polydata import fill_polydata

# Largest error of G(v) = x at inverses that were found, relative to the size of the data: the
# tolerance of the search and rounding of the device's float32.
_MISS = {"polynomial": 3e-3, "affine": 1e-3}, 1e-4
TIMES = 0.0, 0.5, 1.0, 2.0, 3.0

# Said of images in blocks, and of maps that explode.
_SAID = "what crosses a border between them is lost", "are not finite (NaN or infinite)"


def check(seed, device):
    """Run a case; an AssertionError describes a failure."""
    check_limits(np.random.default_rng([seed, 3]), device)
    rng = np.random.default_rng(seed)
    crashes, device = [], "reference" if rng.random() < 0.15 else device
    usual, sys.excepthook = sys.excepthook, lambda *error: crashes.append(error)  # VTK calls it
    try:
        if device != "reference" and rng.random() < 0.1:
            check_tolerance(rng, device)
        elif rng.random() < 0.12:
            _check_series(Scene(rng), device)
        else:
            (_check_value if rng.random() < 0.3 else _check_filter)(Scene(rng), device)
    finally:
        sys.excepthook = usual
    assert not crashes, f"{crashes[0][0].__name__}: {crashes[0][1]}"


def _check_value(scene, device):
    """A `Deformation`, asked without VTK."""
    rng = scene.rng
    rest, deformed, weights = scene.handles()
    options = {
        "kind": str(rng.choice(named("kind").choices)),
        "degree": int(rng.integers(1, 4)),
        "order": int(rng.integers(0, 4)),
        "smoothing": float(rng.choice([0.0, 0.0, 0.0, -1.0, 0.1 * scene.size])),
        "alpha": float(rng.choice([0.5, 1.0, 1.5, 2.0])),
        "weights": weights,
        "cuts": [scene.cut() for _ in range(rng.choice([0, 0, 1, 2]))],
        "cut_frame": str(rng.choice(CUT_FRAMES)),
    }
    x = scene.places(int(rng.choice([0, 1, 50, 3000])), rng.choice([1.0, 3.0]))
    if len(x) > 1 and rng.random() < 0.2:
        x[0] = rng.choice([np.nan, np.inf, 1e30, 1e300, -1e9])
    if rng.random() < 0.3:
        with np.errstate(all="ignore"):
            x = x.astype(np.float32)
    given = [array.copy() for array in (rest, deformed, x)]
    case = f"{len(rest)} control points, {properties_text(options)}, {len(x)} points"
    case = f"{case} in a world of {scene.size:g}"
    try:
        d = Deformation(rest, deformed, **options, device=device)
        truth = Deformation(rest, deformed, **options, device="reference")
        field = d.forward_field(x)
    except (ValueError, TypeError, DeviceError) as error:
        _check_sentence(str(error))
        return
    for before, after in zip(given, (rest, deformed, x)):
        np.testing.assert_array_equal(before, after)
    finite = np.isfinite(x).all(axis=1)
    assert not field.found[~finite].any(), f"what is not finite was found: {case}"
    assert np.isfinite(field.displacement[finite]).all(), f"a finite place went nowhere: {case}"
    if len(x):
        _check_equal_points(d, x, field, case)
    rows = np.flatnonzero(field.found)[:400]
    _check_found(truth, x[rows], x[rows] + field.displacement[rows].astype(float), case)


def _check_equal_points(d, x, field, case):
    """Some of the points again, in another order and several times, go where they went."""
    order = np.random.default_rng(len(x)).integers(0, len(x), min(len(x), 40))
    again = d.forward_field(x[order])
    same = np.array_equal(again.displacement, field.displacement[order], equal_nan=True)
    assert same, f"equal points go to different places: {case}"
    assert np.array_equal(again.found, field.found[order]), f"found or not: {case}"


def _origins(truth, v, x):
    """G(v), with the weights of the material x if cuts move with it: that v may show other too."""
    if not truth.in_rest_frame:
        return truth.backward(v)
    origins = np.full(v.shape, np.nan)
    at = EvaluationPoints(x, np.zeros((len(x), len(truth.obstacles)), bool))
    for region in truth.regions:
        rows = region.holds(truth.planes, x)
        there = EvaluationPoints(*(values[rows] for values in at))
        fit = fit_of(truth, region.control_points, v[rows], there)
        origins[rows] = v[rows] + fit.displacement()
    return origins


def _check_found(truth, x, v, case):
    with np.errstate(all="ignore"):
        miss = np.abs(_origins(truth, v, x) - x).max(axis=1, initial=0)
    scale = max(region.control_points.scale for region in truth.regions)
    middle = truth.deformed.mean(axis=0)
    size = np.maximum(scale, np.abs(np.stack([x - middle, v - middle])).max(axis=(0, 2)))
    bound = _MISS[0].get(truth.kind, _MISS[1])
    bound = bound * size + 1e-6 * np.abs(x).max(axis=1)
    wrong = ~(miss <= bound)
    assert not wrong.any(), (
        f"{wrong.sum()} of {len(x)} are called found {(miss / size)[wrong].max():.2g} away: {case}"
    )


def _check_filter(scene, device):
    """One filter, changed and updated a few times."""
    rng = scene.rng
    make = MLSDisplacementField if rng.random() < 0.15 else MLSDeform
    filter_, settings, cuts = make(), {"Device": device}, ()
    data, handles, surfaces = scene.dataset(), scene.connected_handles(), None
    for _ in range(rng.integers(1, 4)):
        if rng.random() < 0.3:
            data = scene.dataset()
        if rng.random() < 0.5:
            handles = scene.connected_handles()
        settings.update(scene.properties())
        if rng.random() < 0.4:
            cuts = tuple(scene.cut() for _ in range(rng.integers(0, 3)))
        # the specification would take minutes along many polygons
        if device != "reference" and rng.random() < 0.3:
            surfaces = scene.surfaces() if rng.random() < 0.7 else None
        case = f"{make.__name__} of {data.GetClassName()} in a world of {scene.size:g}"
        case = f"{case}, handles {handles[0]}, {len(cuts)} cuts, {properties_text(settings)}"
        given = data, handles, settings, cuts, surfaces
        before = _state(data), _state(surfaces)
        reused = _outcome(_set(filter_, *given))
        fresh = _outcome(_set(make(), *given))
        assert before == (_state(data), _state(surfaces)), f"the input has changed: {case}"
        assert reused == fresh, f"a reused filter is not as a fresh one: {case}"
        if make is MLSDeform and reused[0]:
            if isinstance(data, vtkPointSet) and data.GetNumberOfPoints():
                _check_mesh(data, filter_.GetOutput(), case)
            if isinstance(data, vtkImageData):
                _check_constant(data, filter_, case)


def _check_series(scene, device):
    """One filter at several times, with inputs that change in time, or not."""
    rng = scene.rng

    def given(make):
        return _series(rng, make) if rng.random() < 0.6 else make()

    def polydata():
        made = vtkPolyData()
        fill_polydata(made, *scene.handles())
        return made

    data = _series(rng, scene.polydata) if rng.random() < 0.4 else scene.dataset()
    handles, settings = given(polydata), {**scene.properties(), "Device": device}
    surfaces = given(scene.surfaces) if device != "reference" and rng.random() < 0.3 else None
    make = MLSDisplacementField if rng.random() < 0.3 else MLSDeform
    filter_, inputs = make(), (data, handles, surfaces)
    case = f"{make.__name__}, steps {[getattr(source, 'steps', None) for source in inputs]}"
    case = f"{case} in a world of {scene.size:g}, {properties_text(settings)}"
    _connect(filter_, inputs, settings)
    for time in rng.choice(TIMES, 4).tolist():
        fresh = make()
        _connect(fresh, inputs, settings)
        found, expected = _outcome(filter_, time), _outcome(fresh, time)
        assert found == expected, f"at {time} a reused filter is not as a fresh one: {case}"


def _series(rng, make):
    """A source of results of `make` at random times."""
    steps = sorted(rng.choice(TIMES, rng.integers(1, 4), replace=False).tolist())
    made = {step: make() for step in steps}
    return Source(lambda output, time: output.ShallowCopy(made[time]), steps)


def _connect(filter_, inputs, settings):
    for port, source in enumerate(inputs):
        if isinstance(source, Source):
            filter_.SetInputConnection(port, source.GetOutputPort())
        else:
            filter_.SetInputDataObject(port, source)
    _set_properties(filter_, settings)


def _set_properties(filter_, settings):
    for name, value in settings.items():
        if hasattr(filter_, f"Set{name}"):
            getattr(filter_, f"Set{name}")(value)


def _set(filter_, data, handles, settings, cuts, surfaces):
    filter_.SetInputDataObject(0, data)
    filter_.SetInputDataObject(2, surfaces)
    _set_handles(filter_, *handles)
    filter_.ClearCuts()
    for cut in cuts:
        filter_.AddCut(cut)
    _set_properties(filter_, settings)
    return filter_


def _set_handles(filter_, origin, rest, deformed, weights):
    """Give a filter its own handles, or connect a polydata, or a source that makes one."""
    owner = MLSControlPoints() if origin == "source" else filter_
    if origin != "polydata":
        owner.SetRestPoints(rest)
        owner.SetDeformedPoints(deformed)
        owner.SetWeights([] if weights is None else weights.tolist())
    filter_.SetInputDataObject(1, None)
    if origin == "source":
        filter_.SetInputConnection(1, owner.GetOutputPort())
    elif origin == "polydata":
        polydata = vtkPolyData()
        fill_polydata(polydata, rest, deformed, weights)
        filter_.SetInputDataObject(1, polydata)


def _outcome(filter_, time=None):
    """Whether an update (at a time) succeeded, its errors, and the state of the output."""
    with collected_messages() as messages:
        is_still = time is None
        done = filter_.GetExecutive().Update() if is_still else filter_.UpdateTimeStep(time)
    said = messages.take()
    lines = {line for line in said.splitlines() if line.strip()}
    lines = {line for line in lines if not any(words in line for words in _SAID)}
    said = "\n".join(sorted(lines))
    # an update with failed blocks succeeds, but reports an error
    in_blocks = isinstance(filter_.GetInputDataObject(0, 0), vtkCompositeDataSet)
    if not done or (in_blocks and any(line.startswith("ERROR") for line in lines)):
        lines = {line for line in lines if not line.startswith("Warning: ")}
        assert len(lines) == 1, f"not one sentence: {said[:500]!r}"
        _check_sentence(lines.pop().partition(f"{type(filter_).__name__}: ")[2])
    else:
        for line in lines:  # a background that a type does not have
            warning = f"Warning: {type(filter_).__name__}: "
            assert line.startswith(f"{warning}`background`"), f"VTK said: {said[:500]!r}"
            _check_sentence(line[len(warning) :])
    errors = sorted(line for line in said.splitlines() if line.startswith("ERROR"))
    return done, errors, _state(filter_.GetOutput())  # up to date: no new warning


def _check_sentence(text):
    assert "`" in text, f"no argument is named: {text[:300]!r}"
    assert len(text) < 400, f"too long for a sentence: {text[:300]!r}"
    assert "\n" not in text, f"more than a line: {text[:300]!r}"


def _check_mesh(data, output, case):
    """No point and no cell is lost, and points with an inverse are finite."""
    has_no_inverse = arrays.to_numpy(output.GetPointData().GetArray("NoInverse")) > 0
    x = arrays.to_numpy(output.GetPoints().GetData())
    assert np.isfinite(x[~has_no_inverse]).all(), f"a found place is not finite: {case}"
    is_curved = isinstance(data, vtkUnstructuredGrid) and (arrays.cell_types(data) > 20).any()
    if not is_curved:  # of curved cells that are divided only the corners remain
        assert output.GetNumberOfPoints() >= data.GetNumberOfPoints(), f"points are lost: {case}"
    assert output.GetNumberOfCells() >= data.GetNumberOfCells(), f"cells are lost: {case}"
    assert is_empty(output).sum() == is_empty(data).sum(), f"empty cells are lost: {case}"
    if isinstance(output, vtkUnstructuredGrid) and output.GetNumberOfCells():
        boxes = np.isin(arrays.cell_types(output), (VTK_PIXEL, VTK_VOXEL))
        assert not boxes.any(), f"boxes along the axes have moved: {case}"
    if isinstance(output, (vtkPolyData, vtkUnstructuredGrid)):
        for cells in _cell_arrays(output):
            ids = arrays.to_numpy(cells.GetConnectivityArray())
            assert ids.size == 0 or 0 <= ids.min() <= ids.max() < len(x), f"bad corners: {case}"


def _check_constant(image, filter_, case):
    """A constant array has its value and the background, no other."""
    array = image.GetPointData().GetArray(CONSTANT)
    if array is None or filter_.GetOutput().GetNumberOfPoints() == 0:
        return
    given = arrays.to_numpy(array)
    found = arrays.to_numpy(filter_.GetOutput().GetPointData().GetArray(CONSTANT))
    background = 0 if filter_.GetAutomaticBackground() else filter_.GetBackground()  # of labels
    background = interpolation.cast(background, given.dtype)
    wrong = (found != given[0]) & (found != background)
    assert not wrong.any(), f"{given.dtype} {given[0]} became {found[wrong][0]}: {case}"


def _cell_arrays(mesh):
    if isinstance(mesh, vtkUnstructuredGrid):
        return [mesh.GetCells()] if mesh.GetNumberOfCells() else []
    return [mesh.GetVerts(), mesh.GetLines(), mesh.GetPolys(), mesh.GetStrips()]


def _state(data):
    """All numbers of a dataset, as a file has them."""
    if data is None or data.IsA("vtkUniformGridAMR"):
        return data and data.GetNumberOfPoints()
    if isinstance(data, vtkMultiBlockDataSet):
        return [_state(data.GetBlock(i)) for i in range(data.GetNumberOfBlocks())]
    if data.GetClassName() == "vtkPointSet":  # has no file format
        points, data = data, vtkPolyData()
        data.ShallowCopy(points)
    writer = vtkGenericDataObjectWriter()
    writer.SetInputDataObject(data)
    writer.SetFileTypeToBinary()
    writer.WriteToOutputStringOn()
    assert writer.Write()
    return writer.GetOutputStdString()
