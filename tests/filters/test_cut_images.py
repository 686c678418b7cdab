"""Cuts and voids in the filters: the value's numbers, and hidden from VTK."""

import tracemalloc

import numpy as np
import pytest
from handle_surfaces import soup
from mesh_fixtures import array_of, count
from pipelines import connect, control_points, update, values_of
from vtk_fixtures import FAST, add_array, make_image
from vtkmodules.vtkCommonDataModel import vtkCellArray
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersSources import vtkDiskSource, vtkPlaneSource, vtkSphereSource

from vtk_mls import CUT_FRAMES, Deformation, HalfPlane, Plane, Sampling, Surface
from vtk_mls.base.linear_algebra import unit
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

# Pulled apart across x = 3.9, held below.
REST = np.array([(2.0, 3.0, 5.0), (6.0, 3.0, 5.0), (2.0, 3.0, 1.0), (6.0, 3.0, 1.0)])
APART = REST + [(-1.2, 0, 0), (1.2, 0, 0), (0, 0, 0), (0, 0, 0)]
HALF = (3.9, 3.0, 2.6), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
HALF_PLANE = {"CutType": "half-plane"}
HALF_PLANE |= {"CutOrigin": HALF[0], "CutNormal": HALF[1], "CutInward": HALF[2]}
BOTH = pytest.mark.parametrize("kind", [MLSDeform, MLSDisplacementField])


def scene(kind, device=FAST, image=None, **properties):
    """A filter on an image with the point array "values"."""
    image = image or make_image()
    if not image.GetPointData().HasArray("values"):
        x, y, z = grid_of(image).points().T
        add_array(image.GetPointData(), "values", 5 + np.sin(0.3 * x) + 0.2 * y * z)
        add_array(image.GetCellData(), "cells", np.ones(image.GetNumberOfCells()))
        image.GetPointData().SetActiveScalars("values")
    deforming = configured(kind(), Device=device, **properties)
    return connect(deforming, image, control_points(REST, APART))


def grid_of(image):
    return ImageGeometry.of_image(image).grid


def rectangle(x=3.9, z=2.6):
    """A large polygon in a plane of constant x, from z upwards."""
    source = configured(vtkPlaneSource(), Origin=(x, -90, z))
    return configured(source, Point1=[x, 90, z], Point2=[x, -90, 90])


@BOTH
@pytest.mark.parametrize("cut", ["plane", "half-plane"])
@pytest.mark.parametrize("frame", CUT_FRAMES)
def test_void_is_that_of_the_value(kind, device, cut, frame):
    properties = {**HALF_PLANE, "CutType": cut, "CutFrame": frame, "Nu": 3}
    output = update(scene(kind, device, **properties))
    shape = Plane(*HALF[:2]) if cut == "plane" else HalfPlane(*HALF)
    options = {"cuts": [shape], "cut_frame": frame, "nu": 3}
    value = Deformation(REST, APART, **options, device="reference")
    grid = grid_of(output)
    points, cells = value.void(grid.points()), value.void(grid.cells.points())
    assert 10 < points.sum() < len(points) / 2
    distance = array_of(output, "VoidDistance")
    np.testing.assert_allclose(distance, value.void_distance(grid.points()), atol=1e-4)
    np.testing.assert_array_equal(array_of(output, "Void"), points)
    assert distance.dtype == np.float32
    if kind is MLSDeform:
        np.testing.assert_array_equal(array_of(output, "Void", "Cell"), cells)
        assert (array_of(output, "values")[points] == 0).all()
        assert (array_of(output, "cells", "Cell")[cells] == 0).all()
    else:
        assert not output.GetPointData().HasArray("vtkGhostType")


@BOTH
def test_no_cut_makes_no_arrays(kind):
    output = update(scene(kind))
    for name in ("Void", "VoidDistance", "vtkGhostType", "Gradient", "Jacobian"):
        assert not output.GetPointData().HasArray(name)
        assert not output.GetCellData().HasArray(name)


def test_ghosts_hide_the_void_beside_what_was_hidden():
    image = make_image()
    ghosts = np.zeros(image.GetNumberOfPoints())
    ghosts[7] = 1
    add_array(image.GetPointData(), "vtkGhostType", ghosts, 3)
    deforming = scene(MLSDeform, image=image)
    deforming.AddCut(HalfPlane(*HALF))
    output = update(deforming)
    kept = array_of(output, "vtkGhostType")
    np.testing.assert_array_equal(kept & 2 > 0, array_of(output, "Void"))
    assert (kept & 1).any()
    hidden = array_of(output, "vtkGhostType", "Cell") == 32
    assert hidden[array_of(output, "Void", "Cell") > 0].all()
    corners = values_of(output, "Void").astype(bool)
    touching = corners[:-1] | corners[1:]
    touching = touching[:, :-1] | touching[:, 1:]
    touching = touching[:, :, :-1] | touching[:, :, 1:]
    assert hidden[touching.ravel()].all()
    assert not hidden.all()
    deforming.SetHideVoid(False)
    output = update(deforming)
    assert not (array_of(output, "vtkGhostType") & 2).any()
    assert not output.GetCellData().HasArray("vtkGhostType")


def test_continued_values_end_sharp_at_the_face(device):
    deforming = scene(MLSDeform, device, GradientArray="values")
    deforming.AddCut(HalfPlane(*HALF))
    deforming.AddGradientVectorArray("g")
    image = deforming.GetInputDataObject(0, 0)
    add_array(image.GetPointData(), "g", np.tile([1.0, 0, 0], (image.GetNumberOfPoints(), 1)))
    before = update(deforming)
    void = values_of(before, "Void") > 0
    names = "values", "g", "Gradient"
    kept = {name: values_of(before, name).copy() for name in names}
    deforming.SetVoidValues("continued")
    output = update(deforming)
    np.testing.assert_array_equal(values_of(output, "Void") > 0, void)
    value = Deformation(REST, APART, cuts=[HalfPlane(*HALF)], device=device)
    sampling = Sampling(grid_of(image), void_values="continued")
    expected = {
        "values": value.resample([values_of(image, "values")], sampling)[0],
        "g": value.resample_gradients(values_of(image, "g"), sampling),
        "Gradient": value.corrected_gradient(values_of(image, "values"), sampling),
    }
    for name in names:
        assert not kept[name][void].any()
        result = values_of(output, name)
        np.testing.assert_allclose(result, expected[name].reshape(result.shape), atol=1e-5)
        assert np.count_nonzero(result[void]) > void.sum() / 2


@BOTH
def test_polygons_cut(kind, device):
    deforming, source = scene(kind, device), rectangle()
    name = "values" if kind is MLSDeform else "BackwardDisplacement"
    whole = values_of(update(deforming), name).copy()
    deforming.SetInputConnection(2, source.GetOutputPort())
    by_polygon = update(deforming)
    void, values = values_of(by_polygon, "Void").copy(), values_of(by_polygon, name).copy()
    by_properties = update(scene(kind, device, **HALF_PLANE))
    np.testing.assert_array_equal(void, values_of(by_properties, "Void"))
    np.testing.assert_allclose(values, values_of(by_properties, name), atol=1e-4)
    source.SetOrigin(3.9, -90, 3.7)
    source.SetPoint1(3.9, 90, 3.7)
    assert values_of(update(deforming), "Void").sum() != void.sum()
    deforming.RemoveAllInputConnections(2)
    np.testing.assert_array_equal(values_of(update(deforming), name), whole)


def test_each_surface_is_a_cut():
    first, second = rectangle(), rectangle(x=5.3)
    disk = configured(vtkDiskSource(), InnerRadius=0)  # of quads, far away
    append = vtkAppendPolyData()
    for source in (first, second, disk):
        append.AddInputConnection(source.GetOutputPort())
    deforming = scene(MLSDeform)
    deforming.SetInputConnection(2, append.GetOutputPort())
    together = values_of(update(deforming), "values").copy()
    deforming.SetInputConnection(2, first.GetOutputPort())
    for source in (second, disk):
        deforming.AddInputConnection(2, source.GetOutputPort())
    np.testing.assert_allclose(values_of(update(deforming), "values"), together, atol=1e-5)
    # two parallel surfaces together are not as if there were none
    deforming.SetInputConnection(2, first.GetOutputPort())
    assert not np.array_equal(values_of(update(deforming), "values"), together)


def test_fitted_grid_knows_the_cuts():
    deforming, source = scene(MLSDeform, OutputGrid="fitted"), rectangle()
    deforming.SetInputConnection(2, source.GetOutputPort())
    output = update(deforming)
    corners = [(3.9, -90, 2.6), (3.9, 90, 2.6), (3.9, 90, 90), (3.9, -90, 90)]
    value = Deformation(REST, APART, cuts=[Surface(corners, [(0, 1, 2), (0, 2, 3)])], device=FAST)
    fitted = value.fitted_grid(grid_of(make_image()))
    assert output.GetDimensions() == fitted.dimensions


def test_doubled_points_and_lines_do_not_matter():
    # closed; two rows of triangles that meet at the poles
    sphere = configured(vtkSphereSource(), Center=(4, 3, 3), Radius=1.5)
    deforming = scene(MLSDeform)
    deforming.SetInputConnection(2, sphere.GetOutputPort())
    expected = values_of(update(deforming), "values").copy()
    doubled, lines = soup(update(sphere)), vtkCellArray()
    doubled.GetPolys().InsertNextCell(3, (0, 0, 1))
    lines.InsertNextCell(2, (0, 5))
    doubled.SetLines(lines)
    deforming.SetInputDataObject(2, doubled)
    np.testing.assert_allclose(values_of(update(deforming), "values"), expected, atol=1e-5)


def test_memory_is_that_of_input_and_output(monkeypatch):
    """In bytes for each voxel of 1 byte: VoidDistance 4, and five arrays of 1, beside the input."""
    monkeypatch.setattr("vtk_mls.queries.fields.MAX_SLAB_POINTS", 1 << 16)
    size = 160
    image = make_image((size, size, size))
    values = np.random.default_rng(3).integers(0, 255, size**3).astype(np.uint8)
    arrays.add(image.GetPointData(), "values", values)
    deforming = scene(MLSDeform, image=image, **HALF_PLANE)
    image.GetCellData().Initialize()
    tracemalloc.start()
    try:
        output = update(deforming)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert output.GetPointData().GetArray("VoidDistance").GetDataTypeSize() == 4
    assert peak <= 12 * size**3


# Gradients, normals and Jacobians


def test_normals_and_gradients_of_the_input_are_turned(device):
    image = make_image()
    count = image.GetNumberOfPoints()
    normals = np.tile([0.6, 0.0, 0.8], (count, 1))
    add_array(image.GetPointData(), "n", normals)
    image.GetPointData().SetActiveNormals("n")
    add_array(image.GetPointData(), "g", 3 * normals)
    add_array(image.GetPointData(), "plain", 3 * normals)
    deforming = scene(MLSDeform, device, image)
    deforming.AddGradientVectorArray("g")
    output = update(deforming)
    value = Deformation(REST, APART, device="reference")
    expected = np.einsum("nij,ni->nj", value.jacobian(grid_of(image).points()), 3 * normals)
    inside = array_of(output, "plain")[:, 0] > 1.7
    np.testing.assert_allclose(array_of(output, "g")[inside], expected[inside], atol=1e-3)
    assert np.abs(expected - 3 * normals).max() > 0.1
    assert output.GetPointData().GetNormals().GetName() == "n"
    np.testing.assert_allclose(array_of(output, "n")[inside], unit(expected)[inside], atol=1e-3)
    assert np.ptp(array_of(output, "plain")[inside], axis=0).max() < 1e-6
    deforming.ClearGradientVectorArrays()
    assert deforming.GetGradientVectorArrays() == ()
    plain = array_of(update(deforming), "g")
    np.testing.assert_allclose(plain[inside], 3 * normals[inside], atol=1e-6)


@BOTH
def test_jacobians(kind, device):
    properties = {"GenerateJacobian": True, "GenerateJacobianDeterminant": True, **HALF_PLANE}
    output = update(scene(kind, device, **properties))
    value = Deformation(REST, APART, cuts=[HalfPlane(*HALF)], device="reference")
    expected = value.jacobian(grid_of(output).points())
    jacobian = array_of(output, "Jacobian").reshape(-1, 3, 3)
    np.testing.assert_allclose(jacobian, expected.swapaxes(-1, -2), atol=1e-3)
    determinant = array_of(output, "JacobianDeterminant")
    np.testing.assert_allclose(determinant, np.linalg.det(expected), atol=1e-3)
    folded = (determinant <= 0) & (array_of(output, "Void") == 0)
    assert count(output, "FoldedVoxels") == folded.sum()


def test_folds_are_counted():
    deforming = scene(MLSDeform, Kind="affine", GenerateJacobianDeterminant=True)
    # one control point is dragged past its neighbor
    rest = [(2.0, 3, 3), (4.0, 3, 3), (6.0, 3, 3)]
    deformed = [(2.0, 3, 3), (6.5, 3, 3), (6.0, 3, 3)]
    output = update(connect(deforming, make_image(), control_points(rest, deformed)))
    folded = (array_of(output, "JacobianDeterminant") <= 0).sum()
    assert count(output, "FoldedVoxels") == folded > 0
    output = update(connect(deforming, make_image(), control_points(REST, REST)))
    assert count(output, "FoldedVoxels") == 0
