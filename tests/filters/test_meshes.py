"""MLSDeform moves meshes by the inverse of the map that deforms images."""

import numpy as np
import pytest
from mesh_fixtures import (
    CUTS,
    HIGH,
    LINEAR,
    LOW,
    array_of,
    cells,
    count,
    deforming,
    places_of,
    rectilinear,
    reference,
    set_places,
    sizes,
    sphere,
    structured,
)
from pipelines import assert_fails, assert_same, content, control_points, update
from vtk_fixtures import DEFORMED, REST, add_array, make_image, polydata_of
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAHEDRON,
    VTK_TETRA,
    VTK_VOXEL,
    vtkMultiBlockDataSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import vtkCellCenters, vtkProbeFilter

from vtk_mls import Plane
from vtk_mls.base.linear_algebra import unit
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays, orientation
from vtk_mls.vtk.objects import configured, output_of

FREE = {VTK_VOXEL: VTK_HEXAHEDRON}  # what is a box along the axes by its type becomes


def test_points_go_where_the_deformation_moves_them(any_mesh, device):
    before = np.array([any_mesh.GetPoint(i) for i in range(any_mesh.GetNumberOfPoints())])
    output = update(deforming(any_mesh, device=device))
    expected = reference().forward(before)
    after = places_of(output)
    np.testing.assert_allclose(after, expected, atol=5e-5)
    assert after.dtype == (
        np.float32
        if any_mesh.IsA("vtkUnstructuredGrid") and any_mesh.GetPoints().GetDataType() == VTK_FLOAT
        else np.float64
    )
    displacement = array_of(output, "ForwardDisplacement")
    assert displacement.dtype == np.float32
    np.testing.assert_allclose(displacement, after - before, atol=1e-5)
    assert count(output, "FailedInverses") == 0
    assert not array_of(output, "NoInverse").any()


def test_everything_else_is_kept(any_mesh):
    kept = any_mesh.NewInstance()
    kept.DeepCopy(any_mesh)
    output = update(deforming(any_mesh))
    rectilinear = any_mesh.IsA("vtkRectilinearGrid")
    assert output.GetClassName() == (
        "vtkStructuredGrid" if rectilinear else any_mesh.GetClassName()
    )
    for number in range(0, any_mesh.GetNumberOfCells(), 7):
        ids, old = output.GetCell(number).GetPointIds(), any_mesh.GetCell(number).GetPointIds()
        ids, old = ([i.GetId(k) for k in range(i.GetNumberOfIds())] for i in (ids, old))
        kind = any_mesh.GetCellType(number)
        assert rectilinear or output.GetCellType(number) == FREE.get(kind, kind)
        assert sorted(ids) == sorted(old)
    assert_same(any_mesh, kept)  # the input is as it was
    changed = {"bounds", "points", ("Point", "Normals")}
    before, after = content(kept), content(output)
    rest = before.keys() - changed
    assert_same({name: after[name] for name in rest}, {name: before[name] for name in rest})
    names = [arrays.texts(mesh.GetPointData(), "names") for mesh in (output, kept)]
    assert names[0] == names[1]


def test_mesh_and_image_stay_registered(rng):
    image = make_image((72, 72, 60), origin=(-1, -1, -1), spacing=(0.15, 0.15, 0.15))
    x = np.array([image.GetPoint(i) for i in range(image.GetNumberOfPoints())])
    add_array(image.GetPointData(), "f", smooth(x))
    mesh = cells(VTK_TETRA, 24)
    add_array(mesh.GetPointData(), "f", smooth(places_of(mesh)))
    outputs = [update(deforming(dataset)) for dataset in (image, mesh)]
    probes = polydata_of(rng.uniform(LOW, HIGH, (10_000, 3)))
    values, valid = [], np.ones(10_000, bool)
    for output in outputs:
        probed = output_of(vtkProbeFilter(), InputData=probes, SourceData=output)
        values.append(array_of(probed, "f"))
        valid &= array_of(probed, "vtkValidPointMask") > 0
    assert valid.sum() > 5000
    # a quarter of the second derivative (0.5) times the square of the edge length (0.35), twice
    assert np.abs(values[0] - values[1])[valid].max() < 0.04
    assert np.ptp(values[0][valid]) > 1


def smooth(x):
    return np.sin(0.7 * x[:, 0]) + np.cos(0.6 * x[:, 1]) * np.sin(0.5 * x[:, 2])


@pytest.mark.parametrize("cut", [None, CUTS["plane"]])
@pytest.mark.parametrize("name", [None, ""])
def test_normals_need_no_name(name, cut):
    mesh, other = sphere(), sphere()
    expected = update(deforming(other, cut=cut)).GetPointData().GetNormals()
    mesh.GetPointData().GetNormals().SetName(name)
    found = update(deforming(mesh, cut=cut)).GetPointData().GetNormals()
    np.testing.assert_array_equal(*(arrays.to_numpy(array) for array in (found, expected)))
    assert not mesh.GetPointData().GetNormals().GetName()


def test_vectors_are_pushed_and_gradients_turned_by_the_jacobian(device, rng):
    mesh = cells(VTK_TETRA)
    x = places_of(mesh)
    flow, slope = rng.normal(size=x.shape), rng.normal(size=x.shape)
    for name, values in (("flow", flow), ("slope", slope), ("other", flow)):
        add_array(mesh.GetPointData(), name, values)
    in_cells = rng.normal(size=(mesh.GetNumberOfCells(), 3))
    add_array(mesh.GetCellData(), "flow", in_cells)
    for data, values in ((mesh.GetPointData(), slope), (mesh.GetCellData(), in_cells)):
        data.SetNormals(add_array(data, "normals", unit(values)))
    jacobian = {"GenerateJacobian": True, "GenerateJacobianDeterminant": True}
    filter_ = deforming(mesh, device=device, **jacobian)
    filter_.AddPushForwardArray("flow")
    filter_.AddGradientVectorArray("slope")
    output = update(filter_)
    d, step = reference(), 1e-5
    ahead, behind = d.forward(x + step * flow), d.forward(x - step * flow)
    np.testing.assert_allclose(array_of(output, "flow"), (ahead - behind) / (2 * step), atol=2e-3)
    jacobian = d.jacobian(d.forward(x))
    turned = np.einsum("nij,ni->nj", jacobian, slope)
    ours = array_of(output, "Jacobian").reshape(-1, 3, 3)
    np.testing.assert_allclose(ours, jacobian.swapaxes(1, 2), atol=1e-3)
    determinant = array_of(output, "JacobianDeterminant")
    np.testing.assert_allclose(determinant, np.linalg.det(jacobian), atol=1e-3)
    assert count(output, "InvertedCells") == 0
    np.testing.assert_allclose(array_of(output, "slope"), turned, atol=1e-3)
    np.testing.assert_array_equal(array_of(output, "other"), flow)
    np.testing.assert_allclose(array_of(output, "normals"), unit(turned), atol=1e-3)
    jacobian = d.jacobian(places_of(output_of(vtkCellCenters(), InputData=output)))
    expected = np.linalg.solve(jacobian, in_cells[..., None])[..., 0]
    np.testing.assert_allclose(array_of(output, "flow", "Cell"), expected, atol=2e-3)
    turned = unit(np.einsum("nij,ni->nj", jacobian, in_cells))
    np.testing.assert_allclose(array_of(output, "normals", "Cell"), turned, atol=2e-3)
    for data in (output.GetPointData(), output.GetCellData()):
        assert data.GetNormals().GetName() == "normals"


@pytest.mark.parametrize("kind", [kind for kind in LINEAR if kind != VTK_VOXEL])
def test_volumes_are_those_of_vtk(kind):
    """Of cells that taper, so that no tetrahedron makes up for another."""
    mesh = cells(kind, 1)
    x = places_of(mesh)
    set_places(mesh, x / (1 + x @ [0.3, 0.2, 0.1])[:, None])  # faces stay flat
    corners = arrays.to_numpy(mesh.GetCells().GetConnectivityArray())
    corners = corners.reshape(mesh.GetNumberOfCells(), -1)
    total = 0
    for four in orientation.TETRAHEDRA[kind]:
        a, b, c, d = (places_of(mesh)[corners[:, corner]] for corner in four)
        total = total + np.sum(np.cross(b - a, c - a) * (d - a), axis=1) / 6
    np.testing.assert_allclose(total, sizes(mesh), rtol=1e-9)


def test_what_has_no_inverse_is_marked_and_counted():
    # the half x > 4 is pushed over the cut, which stays, into the other half
    rest = np.array([(x, y, z) for x in (2.0, 6.0) for y in (1, 7) for z in (1, 5)])
    deformed = rest - np.where(rest[:, :1] > 4, [[1.0, 0, 0]], [[0.0, 0, 0]])
    cut = Plane((4, 4, 3), (1, 0, 0))
    mesh = cells(VTK_TETRA, 8)
    properties = {"SplitCells": False, "CutFrame": "deformed"}
    output = update(deforming(mesh, control_points(rest, deformed), cut=cut, **properties))
    x = places_of(mesh)
    lost = (x[:, 0] >= 4) & (x[:, 0] < 5)  # places on a plane belong to the side of its normal
    np.testing.assert_array_equal(array_of(output, "NoInverse") > 0, lost)
    assert count(output, "FailedInverses") == lost.sum() > 0
    assert np.isfinite(places_of(output)).all()


def test_points_that_are_nowhere_stay_so():
    mesh = cells(VTK_TETRA)
    x = places_of(mesh).copy()
    x[[3, 40]] = np.nan
    set_places(mesh, x)
    for cut in (None, CUTS["plane"]):
        output = update(deforming(mesh, cut=cut, GenerateJacobianDeterminant=True))
        assert np.isnan(places_of(output)).any(axis=1).sum() == 2
        lost = array_of(output, "NoInverse") > 0
        assert count(output, "FailedInverses") == lost.sum()
        assert lost[np.isnan(places_of(output)).any(axis=1)].all()
        assert lost.sum() == 2 or cut is not None


def test_small_meshes():
    empty = update(deforming(vtkUnstructuredGrid()))
    assert (empty.GetNumberOfPoints(), empty.GetClassName()) == (0, "vtkUnstructuredGrid")
    assert update(deforming(vtkPolyData(), cut=CUTS["plane"])).GetNumberOfPoints() == 0
    one = polydata_of([(7, 7, 5)], Verts=[[0]])
    for cut in (None, CUTS["plane"], Plane((7, 7, 5), (1, 0, 0))):
        output = update(deforming(one, cut=cut))
        assert (output.GetNumberOfPoints(), output.GetNumberOfVerts()) == (1, 1)
        assert output.GetPoint(0) != (7, 7, 5)


def test_names_of_arrays_are_those_of_any_block(messages):
    image, mesh = make_image(), cells(VTK_TETRA)
    add_array(image.GetPointData(), "values", np.arange(504))
    add_array(image.GetPointData(), "labels", np.arange(504) % 3)
    add_array(mesh.GetPointData(), "flow", np.ones((mesh.GetNumberOfPoints(), 3)))
    composite = vtkMultiBlockDataSet()
    for number, block in enumerate((mesh, image, make_image())):
        composite.SetBlock(number, block)
    filter_ = deforming(composite, GradientArray="values")
    filter_.AddLabelArray("labels")
    filter_.AddPushForwardArray("flow")
    output = update(filter_)
    assert output.GetBlock(1).GetPointData().HasArray("Gradient")
    assert not output.GetBlock(2).GetPointData().HasArray("Gradient")
    assert (array_of(output.GetBlock(0), "flow") != 1).any()


@pytest.mark.parametrize("share", [0.005, 0.1, 0.17, 0.22])
def test_abort_while_a_block_is_cut(share):
    """At each of the steps of splitting, and just after it."""
    blocks = vtkMultiBlockDataSet()
    for number, size in enumerate((5, 4)):
        blocks.SetBlock(number, cells(VTK_TETRA, size))
    filter_, seen = deforming(blocks, cut=CUTS["plane"]), []

    def abort(*_):
        seen.append(filter_.GetProgress())
        if seen[-1] > share:
            filter_.SetAbortExecute(1)

    tag = filter_.AddObserver("ProgressEvent", abort)
    filter_.Update()
    assert sum(share < fraction < 1 for fraction in seen) == 2
    assert filter_.GetOutput().GetNumberOfPoints() == 0
    filter_.RemoveObserver(tag)
    filter_.SetAbortExecute(0)
    filter_.Modified()
    assert update(filter_).GetNumberOfPoints() > 0


@pytest.mark.parametrize("far", [1e30, 1e300])
@pytest.mark.parametrize("cut", [None, *CUTS])
def test_a_far_point_does_not_empty_a_mesh(far, cut):
    def moved(spoil):
        mesh = cells(VTK_HEXAHEDRON, 3)
        x = places_of(mesh).copy()
        x[0] = spoil or x[0]
        set_places(mesh, x)
        output = update(deforming(mesh, control_points(), cut=CUTS.get(cut)))
        return places_of(output), array_of(output, "NoInverse")

    clean, spoilt = moved(None), moved((far, 0, 0))
    # all points are where they were, but for those of pieces of the cell that has it
    distance = np.abs(clean[0][:, None] - spoilt[0]).max(axis=2).min(axis=1)
    assert (distance > 1e-5).sum() <= (1 if cut is None else 16)
    assert (spoilt[1] > 0).sum() <= (clean[1] > 0).sum() + 8


@pytest.mark.parametrize("make", [lambda: cells(VTK_HEXAHEDRON, 2), make_image])
def test_control_points_that_are_no_places_get_a_sentence(make, messages):
    """As ParaView lays them over an input that has no bounds yet."""
    for far, sentence in ((1e299, "`RestPoints` must be places"), (1e12, "where the data are")):
        rest, deformed = [(far,) * 3, (-far,) * 3], [(far, far, 0), (-far,) * 3]
        for kind in (MLSDeform, MLSDisplacementField):
            filter_ = configured(kind(), RestPoints=rest, DeformedPoints=deformed)
            filter_.SetInputData(0, make())
            assert_fails(filter_, messages, sentence)


@pytest.mark.parametrize("data", ["Point", "Cell"])
@pytest.mark.parametrize("cut", [None, "plane"])
@pytest.mark.parametrize("make", [make_image, lambda: cells(VTK_HEXAHEDRON, 2)])
def test_arrays_that_are_too_short_get_a_sentence(make, data, cut, messages):
    dataset = make()
    add_array(getattr(dataset, f"Get{data}Data")(), "short", [1.0, 2.0, 3.0])
    filter_ = deforming(dataset, device="reference", cut=CUTS.get(cut))
    assert_fails(filter_, messages, r"`short` must have one tuple for each of the \d+ .* got 3")


@pytest.mark.parametrize("make", [structured, rectilinear])
def test_a_smaller_grid_of_another_type_may_follow_an_image(make):
    """VTK keeps the extent that was asked for last."""
    filter_ = configured(MLSDeform(), RestPoints=REST, DeformedPoints=DEFORMED)
    filter_.SetInputDataObject(0, make_image((9, 20, 30)))
    update(filter_)
    filter_.SetInputDataObject(0, make())
    assert update(filter_).GetNumberOfPoints() == make().GetNumberOfPoints()
