"""The property InitialTransform: the material moves by another transform before."""

import mesh_fixtures
import numpy as np
import pytest
from mesh_fixtures import CUTS, HIGH, LOW, array_of, cells, count, places_of, rectilinear, sphere
from pipelines import update, values_of
from vtk_fixtures import DEFORMED, FAST, REST, add_array, add_scalars, make_image
from vtkmodules.vtkCommonDataModel import VTK_TETRA

from vtk_mls import Affine, Chain, Deformation, Field, Grid, Sampling, io
from vtk_mls.base.linear_algebra import unit
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


def _field():
    grid = Grid((5, 5, 5), (-1, -1, -1), (2.5, 2.5, 2.5))
    return Field(np.random.default_rng(3).normal(0, 0.15, (*grid.shape, 3)), grid)


MATRIX = np.array([(1.1, 0.1, 0, -0.5), (-0.05, 0.95, 0, 0.3), (0, 0.1, 1, 0), (0, 0, 0, 1)])
INITIAL = {"affine": Affine(MATRIX), "field": _field(), "chain": Chain([_field(), Affine(MATRIX)])}


@pytest.fixture(params=INITIAL)
def initial(request):
    return INITIAL[request.param]


def chained(initial, cuts=(), device="reference"):
    return Chain([initial, Deformation(REST, DEFORMED, cuts=cuts, device=device)])


def deforming(dataset, initial, cut=None, kind=MLSDeform, device=FAST, **properties):
    properties["InitialTransform"] = initial
    return mesh_fixtures.deforming(dataset, None, device, cut, kind, **properties)


def scan():
    image = make_image((18, 16, 14), origin=(0, 0, 0), spacing=(0.45, 0.5, 0.5))
    grid = ImageGeometry.of_image(image).grid
    x = grid.points()
    return add_scalars(image, "values", np.sin(x[:, 0]) + 0.1 * x[:, 1] * x[:, 2]), grid


def test_images_are_resampled_once_by_both(initial, device):
    image, grid = scan()
    output = update(deforming(image, initial, device=device, GradientArray="values"))
    values = values_of(image, "values")
    (expected,) = chained(initial).resample([values], grid)
    inside = np.ones(grid.size, bool)
    index = grid.index_of(chained(initial).backward(grid.points()))
    for edge in (-0.5, np.array(grid.dimensions) - 0.5):
        inside &= (np.abs(index - edge) > 1e-3).all(axis=1)
    got = values_of(output, "values").ravel()
    np.testing.assert_allclose(got[inside], expected.ravel()[inside], atol=1e-4)
    assert np.abs(got - values.ravel()).max() > 0.3
    gradient = chained(initial).corrected_gradient(values, Sampling(grid))
    close = np.isclose(values_of(output, "Gradient"), gradient, atol=1e-3).all(axis=-1)
    assert close.mean() > 0.97  # a border between cells, or of the image, may be on the other side


@pytest.mark.parametrize("suffix", [".nrrd", ".nii.gz", ".mha"])
def test_a_file_is_what_it_holds(suffix, tmp_path):
    image, path = scan()[0], tmp_path / f"warp{suffix}"
    io.write_transform(INITIAL["field"], path)
    expected = update(deforming(image, INITIAL["field"]))
    for given in (path, str(path)):
        deform = deforming(image, given)
        output = update(deform)
        assert deform.GetInitialTransform() == given
        np.testing.assert_allclose(
            values_of(output, "values"), values_of(expected, "values"), atol=1e-5
        )
    deform.SetInitialTransform(None)
    assert deform.GetInitialTransform() == ""
    assert isinstance(deform.updated_deformation(), Deformation)


def test_points_of_meshes_are_moved_by_both(initial, device):
    mesh = cells(VTK_TETRA)
    before = places_of(mesh).copy()
    output = update(deforming(mesh, initial, device=device))
    expected = chained(initial).forward(before)
    np.testing.assert_allclose(places_of(output), expected, atol=5e-5)
    np.testing.assert_allclose(
        array_of(output, "ForwardDisplacement"), expected - before, atol=5e-5
    )
    assert not array_of(output, "NoInverse").any()
    assert count(output, "FailedInverses") == 0
    np.testing.assert_array_equal(array_of(output, "time", "Field"), [2.5])
    np.testing.assert_array_equal(places_of(mesh), before)


def test_a_rectilinear_grid_becomes_structured(initial):
    mesh = rectilinear()
    before = np.array([mesh.GetPoint(i) for i in range(mesh.GetNumberOfPoints())])
    output = update(deforming(mesh, initial))
    assert output.GetClassName() == "vtkStructuredGrid"
    np.testing.assert_allclose(places_of(output), chained(initial).forward(before), atol=5e-5)


def test_vectors_and_the_jacobian_are_those_of_both(initial):
    mesh = sphere()
    before = places_of(mesh).astype(float)
    add_array(mesh.GetPointData(), "speed", np.tile([1.0, 2, 3], (len(before), 1)))
    normals = arrays.to_numpy(mesh.GetPointData().GetNormals()).astype(float)
    jacobians = {"GenerateJacobian": True, "GenerateJacobianDeterminant": True}
    deform = deforming(mesh, initial, **jacobians)
    deform.AddPushForwardArray("speed")
    output = update(deform)
    chain = chained(initial)
    jacobian = chain.jacobian(chain.forward(before))
    # the slopes of a field have steps at the faces of its cells
    rows = np.ones(len(before), bool)
    for member in initial.transforms if isinstance(initial, Chain) else [initial]:
        if isinstance(member, Field):
            middle = Chain([member]).forward(before)
            rows = (np.abs(member.grid.index_of(middle) % 1 - 0.5) < 0.499).all(axis=1)
    expected = unit(np.einsum("mji,mj->mi", jacobian, normals))
    found = arrays.to_numpy(output.GetPointData().GetNormals())
    np.testing.assert_allclose(found[rows], expected[rows], atol=1e-4)
    speed = np.linalg.solve(jacobian, np.tile([1.0, 2, 3], (len(before), 1))[..., None])[..., 0]
    np.testing.assert_allclose(array_of(output, "speed")[rows], speed[rows], rtol=1e-3)
    rows_of = jacobian.swapaxes(1, 2).reshape(-1, 9)
    np.testing.assert_allclose(array_of(output, "Jacobian")[rows], rows_of[rows], atol=1e-3)
    determinant = np.linalg.det(jacobian)
    np.testing.assert_allclose(
        array_of(output, "JacobianDeterminant")[rows], determinant[rows], rtol=1e-3
    )


def test_cells_that_both_turn_inside_out_are_counted():
    mirror = Affine(np.diag([-1.0, 1, 1, 1]) + [[0, 0, 0, 8], *np.zeros((3, 4))])
    mesh = cells(VTK_TETRA)
    for initial, expected in ((Affine(np.eye(4)), 0), (mirror, mesh.GetNumberOfCells())):
        output = update(deforming(mesh, initial, GenerateJacobianDeterminant=True))
        assert count(output, "InvertedCells") == expected


@pytest.mark.parametrize("name", ["plane", "tent"])
def test_meshes_are_split_in_the_space_between(name, initial):
    mesh, cut = cells(VTK_TETRA), CUTS[name]
    between = cells(VTK_TETRA)
    mesh_fixtures.set_places(between, initial.forward(places_of(mesh)))
    alone = mesh_fixtures.deforming(between, cut=cut)
    expected = update(alone)
    deform = deforming(mesh, initial, cut)
    output = update(deform)
    assert output.GetNumberOfPoints() > mesh.GetNumberOfPoints()
    np.testing.assert_allclose(places_of(output), places_of(expected), atol=1e-4)
    back = places_of(output) - array_of(output, "ForwardDisplacement")
    assert (back > LOW - 1e-3).all()
    assert (back < HIGH + 1e-3).all()
    deform.SetBlend(0.5)  # by the mesh that was divided before
    alone.SetBlend(0.5)
    np.testing.assert_allclose(places_of(update(deform)), places_of(update(alone)), atol=1e-4)


def test_the_void_of_images_is_that_of_the_chain(initial):
    image, grid = scan()
    output = update(deforming(image, initial, CUTS["plane"]))
    distance = chained(initial, CUTS["plane"]).void_distance(grid.points())
    got = values_of(output, "VoidDistance").ravel()
    np.testing.assert_allclose(got, distance, atol=1e-3)
    assert (got < 0).any()


def test_the_field_is_that_of_both(initial):
    image, grid = scan()
    chain = chained(initial)
    output = update(deforming(image, initial, kind=MLSDisplacementField))
    v = grid.points()
    got = values_of(output, "BackwardDisplacement").reshape(-1, 3)
    np.testing.assert_allclose(got, chain.backward(v) - v, atol=1e-4)
    output = update(deforming(image, initial, kind=MLSDisplacementField, Inverse=True))
    found = values_of(output, "NoInverse").ravel() == 0
    moved = v + values_of(output, "ForwardDisplacement").reshape(-1, 3)
    np.testing.assert_allclose(chain.backward(moved)[found], v[found], atol=1e-3)
    assert found.mean() > 0.99


def test_a_fitted_grid_holds_what_both_move():
    image, grid = scan()
    far = Affine(np.eye(4) + [[0, 0, 0, 40], *np.zeros((3, 4))])
    output = update(deforming(image, far, OutputGrid="fitted"))
    moved = chained(far).forward(grid.points())
    fitted = ImageGeometry.of_image(output).grid
    assert fitted.covers(fitted.index_of(moved)).mean() > 0.99
