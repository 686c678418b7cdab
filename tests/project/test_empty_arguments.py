"""Every public function takes empty arguments, or refuses them in one sentence."""

import inspect
from dataclasses import replace

import numpy as np
import pytest
from pipelines import ball, control_points, update
from vtk_fixtures import messages
from vtkmodules import vtkCommonDataModel

import vtk_mls
from vtk_mls import filters, io, landmarks

__all__ = ["messages"]

GRID = vtk_mls.Grid((4, 4, 4))
REST = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
DEFORMED = [(0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
CUT = vtk_mls.HalfPlane((0.5, 0.5, 0.5), (1, 0, 0), (0, 0, 1))
SPLIT = vtk_mls.Plane((0.5, 0.5, 0.5), (1, 0, 0))


def deformation(**options):
    return vtk_mls.Deformation(REST, DEFORMED, device="reference", **options)


TRANSFORMS = {
    "plain": deformation(),
    "cut": deformation(cuts=CUT),
    "split": deformation(cuts=SPLIT, cut_frame="rest"),
    "steps": deformation(steps=3),
    "polynomial": deformation(kind="polynomial", degree=3),
    "affine": vtk_mls.Affine(np.eye(4)),
    "field": vtk_mls.Field(np.zeros((4, 4, 4, 3)), GRID),
    "chain": vtk_mls.Chain([deformation(cuts=CUT), vtk_mls.Affine(np.eye(4))]),
}
NOTHING = {
    "points": np.zeros((0, 3)),
    "where": np.zeros((0, 3)),
    "arrays": [],
    "array": np.zeros((0, 4, 4), np.float32),
    "vectors": np.zeros((0, 4, 4, 3), np.float32),
}
OTHERS = {"grid": GRID, "sampling": GRID, "source": GRID, "dimensions": (0, 4, 4), "versions": []}


def calls(owner):
    """Methods of an object that take one of `NOTHING`, with their arguments."""
    for name, method in inspect.getmembers(owner, inspect.isroutine):
        if name.startswith("_"):
            continue
        needed = [
            p.name
            for p in inspect.signature(method).parameters.values()
            if p.default is p.empty or p.name in NOTHING
        ]
        if any(name in NOTHING for name in needed):
            for points in (np.zeros((0, 3)), []):
                values = {**NOTHING, **OTHERS, "points": points, "where": points}
                yield name, method, {key: values[key] for key in needed}


def outcome(function, *arguments, **named):
    """The result; None after a sentence."""
    try:
        return function(*arguments, **named)
    except (OSError, TypeError, ValueError) as error:
        sentence = str(error)
    assert "`" in sentence
    assert "\n" not in sentence
    return None


@pytest.mark.parametrize("name", TRANSFORMS)
@pytest.mark.parametrize("device", ["reference", None])
def test_questions_at_no_points_have_no_answers(name, device):
    transform = TRANSFORMS[name]
    if isinstance(transform, vtk_mls.Deformation):
        transform = replace(transform, device=device)
    asked = set()
    for method_name, method, arguments in calls(transform):
        asked.add(method_name)
        answer = outcome(method, **arguments)
        if "points" in arguments:
            parts = vars(answer).values() if hasattr(answer, "found") else [answer]
            assert all(len(part) == 0 for part in parts), method_name
        elif answer is not None and method_name != "corrected_gradient":
            assert method_name in ("resample", "resample_gradients", "resample_vectors")
            assert len(answer) == 0
    assert {"backward", "forward", "void", "jacobian", "overlap", "resample"} <= asked


EMPTY = np.zeros((0, 3))
IMAGE = landmarks.Image(np.random.default_rng(0).random((4, 4, 4)), GRID)
CONSTRUCTED = {
    "no control points": lambda: vtk_mls.Deformation(EMPTY, EMPTY),
    "no rows": lambda: vtk_mls.Deformation([], []),
    "no weights": lambda: vtk_mls.Deformation(REST, DEFORMED, weights=[]),
    "no path": lambda: deformation(path=[]).backward(EMPTY),
    "chain": lambda: vtk_mls.Chain([]),
    "matrix": lambda: vtk_mls.Affine([]),
    "field": lambda: vtk_mls.Field([], GRID),
    "field of no grid": lambda: vtk_mls.Field(np.zeros((0, 0, 0, 3)), GRID),
    "curve": lambda: vtk_mls.CurveHandle([], []),
    "region": lambda: vtk_mls.RegionHandle(vtk_mls.Ball((0, 0, 0), 1), []),
    "ball": lambda: vtk_mls.Ball([], 1),
    "solid": lambda: vtk_mls.Solid([], []),
    "labels": lambda: vtk_mls.Labels(np.zeros((4, 4, 4), bool), GRID),
    "surface": lambda: vtk_mls.Surface(REST, []),
    "surface without points": lambda: vtk_mls.Surface([], [(0, 1, 2)]),
    "image mask": lambda: vtk_mls.ImageMask(np.zeros((0, 0, 0)), GRID),
    "face": lambda: vtk_mls.FixedFace([], 1.0),
    "grid": lambda: vtk_mls.Grid([]),
    "grid without points": lambda: vtk_mls.Grid((0, 1, 1)),
    "report": lambda: landmarks.report([], []),
    "report of no rows": lambda: landmarks.report(EMPTY, EMPTY),
    "image": lambda: landmarks.Image(np.zeros((0, 4, 4)), GRID),
    "refine": lambda: landmarks.refine(IMAGE, IMAGE, EMPTY, EMPTY),
    "refine nothing": lambda: landmarks.refine(IMAGE, IMAGE, [], []),
}


@pytest.mark.parametrize("name", CONSTRUCTED)
def test_empty_values_are_refused_or_right(name):
    outcome(CONSTRUCTED[name])


def test_empty_arrays_of_dask():
    dask = pytest.importorskip("vtk_mls.dask")
    array = np.zeros((0, 4, 4), np.float32)
    outcome(lambda: dask.resample(array, deformation(), GRID).compute())


@pytest.mark.parametrize(
    "suffix", ["csv", "vtp", "mrk.json", "fcsv", "vti", "vtu", "mha", "nii.gz"]
)
def test_empty_data_of_files(suffix, tmp_path):
    path = tmp_path / f"empty.{suffix}"

    def written(write):
        outcome(write)
        if path.exists():
            for read in (io.read_control_points, io.read_dataset, io.read_surface):
                outcome(read, path)
            path.unlink()

    written(lambda: io.write_handles(path))
    written(lambda: io.write_handles(path, EMPTY, EMPTY))
    for kind in ("ImageData", "PolyData", "UnstructuredGrid"):
        dataset = getattr(vtkCommonDataModel, f"vtk{kind}")()
        written(lambda dataset=dataset: io.write_dataset(dataset, path))


KINDS = ["ImageData", "PolyData", "UnstructuredGrid", "StructuredGrid", "RectilinearGrid"]
KINDS += ["MultiBlockDataSet", "PartitionedDataSet", "Table"]


@pytest.mark.parametrize("port", [0, 1, 2])
@pytest.mark.parametrize(
    "name", ["MLSDeform", "MLSDisplacementField", "MLSControlPoints", "MLSLandmarkReport"]
)
def test_filters_of_empty_data(name, port, messages, capfd):
    for kind in KINDS:
        filter_ = getattr(filters, name)()
        inputs = {0: ball((0, 0, 0), 1), 1: update(control_points([(0, 0, 0)], []))}
        inputs[port] = getattr(vtkCommonDataModel, f"vtk{kind}")()
        for number in range(filter_.GetNumberOfInputPorts()):
            if number in inputs:
                filter_.SetInputDataObject(number, inputs[number])
        filter_.Update()
        text = messages.take()
        assert "Traceback" not in text, (kind, text)
        assert "\n\n" not in text.strip(), (kind, text)
    assert "Traceback" not in "".join(capfd.readouterr())
