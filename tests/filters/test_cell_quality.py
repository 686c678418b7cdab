"""`CellQuality` by VTK's scaled Jacobian, and `LargestBlend` by trying all blends."""

import numpy as np
import pytest
from mesh_fixtures import (
    CUTS,
    LINEAR,
    MESHES,
    array_of,
    cells,
    count,
    deforming,
    grid_of,
    pinch,
    plate,
    polyhedra,
    scaled_jacobians_of,
    structured,
)
from pipelines import control_points, update
from vtk_fixtures import REST
from vtkmodules.vtkCommonDataModel import (
    VTK_EMPTY_CELL,
    VTK_HEXAHEDRON,
    VTK_QUAD,
    VTK_TETRA,
)

from vtk_mls import RegionHandle
from vtk_mls.base.progress import SILENT
from vtk_mls.filters.warping import largest_blend
from vtk_mls.model.handles.shapes import Ball

MEASURED = (5, 9, 10, 12, 13, 14)
NAMES = [f"cells {kind}" for kind in LINEAR]
NAMES += ["mixed", "polydata", "structured", "rectilinear", "explicit structured"]


def scaled_jacobians(mesh):
    """By VTK; NaN for other cells than those of MEASURED."""
    types = [mesh.GetCellType(i) for i in range(mesh.GetNumberOfCells())]
    return np.where(np.isin(types, MEASURED), scaled_jacobians_of(mesh), np.nan)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("cut", [None, CUTS["plane"]])
def test_quality_before_and_after_is_that_of_vtk(name, cut):
    filter_ = deforming(MESHES[name](), cut=cut, GenerateCellQuality=True)
    output = update(filter_)
    after = array_of(output, "CellQuality", "Cell").copy()
    np.testing.assert_allclose(after, scaled_jacobians(output), rtol=1e-12)
    before = array_of(output, "CellQualityBefore", "Cell").copy()
    filter_.SetBlend(0)
    at_rest = update(filter_)
    np.testing.assert_array_equal(array_of(at_rest, "CellQualityBefore", "Cell"), before)
    np.testing.assert_allclose(before, scaled_jacobians(at_rest), rtol=1e-6, atol=1e-7)
    np.testing.assert_array_equal(before, array_of(at_rest, "CellQuality", "Cell"))
    assert np.nanmax(np.abs(after - before)) > 1e-3


def test_bad_cells_have_a_quality_of_zero_or_less():
    properties = {"GenerateCellQuality": True, "GenerateJacobianDeterminant": True}
    output = update(deforming(cells(VTK_HEXAHEDRON, 14), pinch(2.5), **properties))
    quality = array_of(output, "CellQuality", "Cell")
    assert count(output, "InvertedCells") == (quality <= 0).sum() > 0


def test_cells_without_a_measure_are_nan():
    filter_ = deforming(polyhedra(2), GenerateCellQuality=True)
    assert np.isnan(array_of(update(filter_), "CellQuality", "Cell")).all()
    mesh = grid_of(
        [(1, 1, 1), (3, 1, 1), (3, 3, 1), (1, 3, 1), (1, 1, 3), (np.nan, 0, 0)],
        [
            (VTK_EMPTY_CELL, []),
            (VTK_QUAD, [0, 1, 2, 3]),
            (VTK_QUAD, [0, 1, 2, 5]),
            (VTK_TETRA, [0, 1, 3, 5]),
            (VTK_TETRA, [0, 0, 0, 0]),
            (VTK_TETRA, [0, 1, 3, 4]),
            (VTK_HEXAHEDRON, [0, 1, 2, 3, 4, 4, 4, 5]),
        ],
    )
    output = update(deforming(mesh, control_points(REST, REST + 1), GenerateCellQuality=True))
    for name in ("CellQuality", "CellQualityBefore"):
        quality = array_of(output, name, "Cell")
        np.testing.assert_array_equal(np.isfinite(quality), [0, 1, 0, 0, 0, 1, 0])
        np.testing.assert_allclose(quality[[1, 5]], [1, 0.5**0.5], rtol=1e-6)


def inverted_at(filter_, blend):
    filter_.SetBlend(blend)
    return count(update(filter_), "InvertedCells")


@pytest.mark.parametrize(
    ("mesh", "handles", "properties"),
    [
        (lambda: cells(VTK_HEXAHEDRON, 12), pinch(2.5), {}),
        pytest.param(
            *(lambda: cells(VTK_TETRA, 8), pinch(4), {"Kind": "affine"}), marks=pytest.mark.matrix
        ),
        (lambda: cells(VTK_HEXAHEDRON, 12), pinch(1.25), {"Blend": 2.0}),
        (lambda: cells(VTK_HEXAHEDRON, 12), pinch(-2.5), {"Blend": -1.0}),
        pytest.param(plate, pinch(1.8), {"Alpha": 1.0}, marks=pytest.mark.matrix),
        (structured, control_points(REST, REST * [1, 1, -1]), {"Kind": "affine"}),
    ],
    ids=["hexahedra", "tetrahedra", "twice", "backward", "surface", "mirrored"],
)
def test_the_largest_blend_inverts_nothing_and_one_step_more_does(mesh, handles, properties):
    filter_ = deforming(mesh(), handles, GenerateLargestBlend=True, **properties)
    blend, found = filter_.GetBlend(), count(update(filter_), "LargestBlend")
    assert not filter_.GetOutput().GetFieldData().HasArray("InvertedCells")
    assert 0 < found / blend < 1
    filter_.SetGenerateJacobianDeterminant(True)
    assert inverted_at(filter_, blend) > 0
    assert inverted_at(filter_, found) == 0
    assert count(filter_.GetOutput(), "LargestBlend") == found
    assert inverted_at(filter_, found + np.sign(blend) * 0.01) > 0
    assert count(filter_.GetOutput(), "LargestBlend") == pytest.approx(found, abs=1e-12)


def test_a_deformation_that_inverts_nothing_may_be_applied_whole():
    for blend in (0.0, 0.735, 1.0):
        filter_ = deforming(cells(VTK_TETRA), GenerateLargestBlend=True, Blend=blend)
        assert count(update(filter_), "LargestBlend") == blend


@pytest.mark.matrix
def test_the_largest_blend_of_cut_meshes_and_rigid_regions(messages):
    """Split cells count as they come; regions turn by a share of their angle."""
    mesh = cells(VTK_HEXAHEDRON, 8)
    turn = np.diag([-1.0, -1.0, 1, 1])
    turn[:2, 3] = 8, 6  # by 180 degrees about (4, 3)
    properties = {"GenerateLargestBlend": True, "GenerateJacobianDeterminant": True}
    filter_ = deforming(mesh, control_points(REST, REST), cut=CUTS["polygon"], **properties)
    filter_.AddHandle(RegionHandle(Ball((4, 3, 3), 0.9), turn))
    found = count(update(filter_), "LargestBlend")
    assert 0 < found < 1
    assert inverted_at(filter_, found) == 0
    assert inverted_at(filter_, found + 0.01) > 0


@pytest.mark.parametrize("threshold", [0.001, 0.01, 0.5, 0.734, 0.99, 0.995, 1.7])
def test_bisection_finds_each_step(threshold):
    """Against all steps; each blend is tried once."""
    tried = []

    def inverts(blend, _):
        tried.append(blend)
        return blend >= threshold

    steps = np.arange(200) / 100
    whole = 1.999 if threshold > 1 else 0.9951
    found = largest_blend(whole, inverts, SILENT)
    assert found == steps[(steps < threshold) & (steps < whole)].max()
    assert len(set(tried)) == len(tried) <= 8
