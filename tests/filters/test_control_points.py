"""MLSControlPoints makes the polydata that the other filters read."""

import numpy as np
from pipelines import control_points, update

from vtk_mls.filters import MLSControlPoints
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured


def test_explicit_points(rng):
    rest, deformed = rng.normal(size=(2, 5, 3)) * 1e-9 + 5e5
    source = control_points(rest, deformed)
    output = update(source)
    p, q, weights = arrays.control_points(output, "Displacement")
    np.testing.assert_array_equal(p, rest)
    np.testing.assert_array_equal(q, deformed)
    assert weights is None
    assert output.GetPointData().GetNumberOfArrays() == 1
    assert output.GetPointData().GetVectors().GetName() == "Displacement"
    assert output.GetNumberOfVerts() == output.GetNumberOfCells() == 5
    assert [output.GetCell(i).GetPointId(0) for i in range(5)] == list(range(5))
    source.SetWeights([1, 2, 3, 4, 5])
    weights = update(source).GetPointData().GetArray("Weight")
    assert arrays.to_numpy(weights).tolist() == [1, 2, 3, 4, 5]


def test_nothing_moves_without_deformed_points():
    source = MLSControlPoints()
    assert update(source).GetNumberOfPoints() == 0
    source.SetRestPoints([(1, 2, 3), (4, 5, 6)])
    displacement = update(source).GetPointData().GetArray("Displacement")
    np.testing.assert_array_equal(arrays.to_numpy(displacement), np.zeros((2, 3)))


def test_lattice():
    source = configured(MLSControlPoints(), Mode="lattice", LatticeDimensions=(2, 3, 1))
    source.SetBounds(0, 1, 0, 4, -3, 5)
    p, _, _ = arrays.control_points(update(source), "Displacement")
    expected = [(0, 0), (1, 0), (0, 2), (1, 2), (0, 4), (1, 4)]
    np.testing.assert_array_equal(p, [(x, y, 1) for x, y in expected])
    moved = p + [0, 0, 1]
    source.SetDeformedPoints(moved)
    _, q, _ = arrays.control_points(update(source), "Displacement")
    np.testing.assert_array_equal(q, moved)


def test_arrows_lead_from_rest_to_deformed():
    source = MLSControlPoints()
    source.SetRestPoints([(0, 0, 0), (5, 5, 5), (1, 2, 3)])
    assert update(source).GetNumberOfPoints() == 3
    assert source.GetOutputDataObject(1).GetNumberOfPoints() == 0
    source.SetDeformedPoints([(0, 0, 0), (np.nan, 5, 5), (1, 2, 7)])
    update(source)
    arrows = source.GetOutputDataObject(1)
    assert arrows.GetNumberOfPolys() > 0
    np.testing.assert_allclose(arrows.GetBounds()[4:], (3, 7))
    np.testing.assert_allclose(arrows.GetCenter()[:2], (1, 2), atol=0.01)
    assert arrows.GetPointData().GetArray("Displacement").GetRange(2) == (4, 4)
