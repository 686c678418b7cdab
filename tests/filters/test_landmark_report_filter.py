"""MLSLandmarkReport: the report on pairs of landmarks, as tables."""

import numpy as np
import pytest
from pipelines import control_points, update
from vtk_fixtures import FAST
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

from vtk_mls.filters import MLSLandmarkReport
from vtk_mls.landmarks import report
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import fill_polydata
from vtk_mls.vtk.objects import configured

FAULTY, SWAPPED = 3, (5, 11)


def _pairs(rng):
    """40 pairs of a smooth warp; one is off and two are swapped."""
    p = np.round(rng.uniform(-50, 50, (40, 3)))  # so that p + (q - p) is q
    q = p + np.round(64 * np.sin(p[:, ::-1] / 40)) / 16 + [3, 0, 0]
    q[FAULTY] += (25, -10, 5)
    q[[*SWAPPED]] = q[[*SWAPPED[::-1]]]
    return p, q


def _reporting(p, q, labels=(), weights=None):
    polydata = vtkPolyData()
    fill_polydata(polydata, p, q, weights, labels)
    return configured(MLSLandmarkReport(), Device=FAST, InputData=polydata)


def _column(table, name):
    data = table.GetRowData()
    return arrays.texts(data, name) or arrays.to_numpy(data.GetArray(name))


def test_both_tables_are_those_of_the_report(rng):
    p, q = _pairs(rng)
    names = [f"L{i}" for i in range(len(p))]
    algorithm = _reporting(p, q, names)
    pairs = update(algorithm)
    expected = report(p, q, names, device=FAST).as_dict()
    assert _column(pairs, "Name") == names
    for column in ("Rest", "Deformed", "Moved", "Error", "Outlier"):
        values = [row[column.lower()] for row in expected["pairs"]]
        np.testing.assert_allclose(_column(pairs, column), values, rtol=1e-6)
    assert np.flatnonzero(_column(pairs, "Outlier")).tolist() == sorted((FAULTY, *SWAPPED))
    swapped = _column(pairs, "SwappedWith")
    assert {i: name for i, name in enumerate(swapped) if name} == {5: "L11", 11: "L5"}
    settings = algorithm.GetOutputDataObject(1)
    columns = "Kind", "Degree", "Order", "Alpha", "Smoothing"
    rows = zip(*(_column(settings, name) for name in columns))
    medians = dict(zip(rows, _column(settings, "Median")))
    tried = {
        tuple(row[column.lower()] or 0 for column in columns): row["median"]
        for row in expected["tried"]
    }
    baseline = {(kind, 0, 0, 0, 0): median for kind, median in expected["baseline"].items()}
    assert [*medians.items()] == [*tried.items(), *baseline.items()]
    (best,) = np.flatnonzero(_column(settings, "Recommended"))
    recommended = {key: value for key, value in expected["recommended"].items() if key != "median"}
    assert recommended.items() <= expected["tried"][best].items()
    field = pairs.GetFieldData()
    assert arrays.texts(field, "Recommended") == [_column(settings, "Options")[best]]
    value = field.GetArray("SmallestDeterminant").GetValue(0)
    assert value == expected["smallest_determinant"]
    assert any("L5 and L11" in sentence for sentence in arrays.texts(field, "Summary"))


def test_names_are_numbers_without_labels_and_q_can_be_a_second_input(rng):
    p, q = _pairs(rng)
    moved, algorithm = vtkPolyData(), _reporting(p[:12], p[:12])
    fill_polydata(moved, q[:12], q[:12], None)
    algorithm.SetInputData(1, moved)
    pairs = update(algorithm)
    assert _column(pairs, "Name")[:2] == ["1", "2"]
    np.testing.assert_array_equal(_column(pairs, "Deformed"), q[:12])
    algorithm.DisconnectDeformedControlPoints()
    assert not _column(update(algorithm), "Moved").any()


@pytest.mark.parametrize(
    ("count", "sentence"),
    [(3, "`Input` must have at least 4 pairs"), (8, "p of `Input` must be distinct places")],
)
def test_errors_are_one_sentence(rng, messages, count, sentence):
    p, q = _pairs(rng)
    p[count - 1] = p[0]
    algorithm = _reporting(p[:count], q[:count])
    assert not algorithm.GetExecutive().Update()
    messages.assert_one(f"MLSLandmarkReport: {sentence}")
    assert algorithm.GetOutputDataObject(0).GetNumberOfRows() == 0


def test_blocks_are_an_error(messages):
    blocks, algorithm = vtkMultiBlockDataSet(), MLSLandmarkReport()
    blocks.SetBlock(0, update(control_points()))
    algorithm.SetInputDataObject(0, blocks)
    algorithm.GetExecutive().Update()
    messages.assert_one("`Input` must be one point set, got a vtkMultiBlockDataSet; merge its")
