"""MLSDeform moves meshes by the inverse of the map that deforms images, and cuts them open."""

import numpy as np
import pytest
from vtk_fixtures import (
    DEFORMED,
    FAST,
    REST,
    add_array,
    connect,
    control_points,
    device,  # noqa: F401
    make_image,
    messages,  # noqa: F401
    update,
)
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_FLOAT, vtkIdList, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAHEDRON,
    VTK_LINE,
    VTK_POLYHEDRON,
    VTK_PYRAMID,
    VTK_QUADRATIC_HEXAHEDRON,
    VTK_QUADRATIC_TETRA,
    VTK_TETRA,
    VTK_TRIANGLE,
    VTK_VOXEL,
    VTK_WEDGE,
    vtkCellArray,
    vtkDataSetAttributes,
    vtkExplicitStructuredGrid,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
    vtkPointSet,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkFiltersCore import (
    vtkAppendFilter,
    vtkCellCenters,
    vtkConnectivityFilter,
    vtkPolyDataNormals,
    vtkProbeFilter,
)
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersSources import vtkCellTypeSource, vtkPlaneSource, vtkSphereSource
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter

from vtk_mls import Deformation, HalfPlane, Plane, Surface, arrays
from vtk_mls.filters import MLSDeform, splitting, warping

LOW, HIGH = np.array([0.6, 0.4, 0.2]), np.array([7.4, 7.1, 5.9])
LINEAR = [VTK_TETRA, VTK_HEXAHEDRON, VTK_WEDGE, VTK_PYRAMID, VTK_VOXEL]
QUADRATIC = [VTK_QUADRATIC_TETRA, VTK_QUADRATIC_HEXAHEDRON]
CUTS = {
    "plane": Plane((4.03, 4, 3), (1, 0.2, 0.1)),
    "half-plane": HalfPlane((4.03, 4, 3.1), (1, 0.2, 0.1), (0, 0, 1)),
    "polygon": Surface.polygon([(4.03, 2, 1), (4.1, 6.1, 1), (4.1, 6.1, 5), (4.03, 2, 5)]),
    "tent": Surface(
        [(4, 0, 0), (4, 8, 0), (5, 0, 4), (5, 8, 4), (4, 0, 9), (4, 8, 9)],
        [(0, 1, 2), (1, 3, 2), (2, 3, 4), (3, 5, 4)],
    ),
}


def reference(cuts=(), **options):
    return Deformation(REST, DEFORMED, cuts=cuts, device="reference", **options)


def places_of(mesh):
    return arrays.to_numpy(mesh.GetPoints().GetData())


def set_places(mesh, places, vtk_type=VTK_DOUBLE):
    points = vtkPoints()
    points.SetDataType(vtk_type)
    dtype = np.float32 if vtk_type == VTK_FLOAT else np.float64
    points.SetData(arrays.from_numpy(np.ascontiguousarray(places, dtype), vtk_type))
    mesh.SetPoints(points)


def decorated(mesh):
    """With a linear function on the points, the number of each cell, and strings."""
    if mesh.GetNumberOfPoints():
        x = np.array([mesh.GetPoint(i) for i in range(mesh.GetNumberOfPoints())])
        add_array(mesh.GetPointData(), "linear", linear(x))
    add_array(mesh.GetCellData(), "number", np.arange(mesh.GetNumberOfCells()))
    names = vtkStringArray()
    names.SetName("names")
    for i in range(mesh.GetNumberOfPoints()):
        names.InsertNextValue(str(i))
    mesh.GetPointData().AddArray(names)
    add_array(mesh.GetFieldData(), "time", [2.5])
    return mesh


def split(mesh, cuts):
    """The divided mesh, and from each point to a place on its side."""
    output, foot, side = splitting.split(mesh, cuts)
    return output, foot + 1e-5 * np.max(HIGH - LOW) * side


def linear(x):
    return x @ [1.0, -2.0, 0.5] + 3


def cells(cell_type, blocks=4, vtk_type=VTK_DOUBLE):
    """Cells of one type that fill the box."""
    if cell_type == VTK_POLYHEDRON:
        return polyhedra(blocks)
    source = vtkCellTypeSource()
    source.SetCellType(cell_type)
    source.SetBlocksDimensions(blocks, blocks, blocks)
    source.Update()
    mesh = source.GetOutput()
    for data in (mesh.GetPointData(), mesh.GetCellData()):
        data.Initialize()
    set_places(mesh, LOW + places_of(mesh) / blocks * (HIGH - LOW), vtk_type)
    return decorated(mesh)


def polyhedra(blocks):
    """Hexahedra, told by their faces."""
    hexahedra = cells(VTK_HEXAHEDRON, blocks)
    mesh = vtkUnstructuredGrid()
    mesh.SetPoints(hexahedra.GetPoints())
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    for number in range(hexahedra.GetNumberOfCells()):
        corners, stream = hexahedra.GetCell(number).GetPointIds(), vtkIdList()
        stream.InsertNextId(len(faces))
        for face in faces:
            stream.InsertNextId(4)
            for corner in face:
                stream.InsertNextId(corners.GetId(corner))
        mesh.InsertNextCell(VTK_POLYHEDRON, stream)
    return decorated(mesh)


def mixed():
    append = vtkAppendFilter()
    for shift, kind in enumerate([VTK_TETRA, VTK_LINE, VTK_QUADRATIC_TETRA, VTK_TRIANGLE]):
        source = vtkCellTypeSource()
        source.SetCellType(kind)
        source.SetBlocksDimensions(2, 2, 2)
        source.Update()
        move, transform = vtkTransformFilter(), vtkTransform()
        transform.Translate(1.5 * shift, shift, 1)
        move.SetTransform(transform)
        move.SetInputConnection(source.GetOutputPort())
        move.Update()
        append.AddInputData(move.GetOutput())
    append.Update()
    return decorated(append.GetOutput())


def sphere():
    source = vtkSphereSource()
    source.SetCenter(4, 4, 3)
    source.SetRadius(2.4)
    source.SetThetaResolution(40)
    source.SetPhiResolution(30)
    source.SetOutputPointsPrecision(1)
    source.Update()
    return decorated(source.GetOutput())


def structured():
    mesh = vtkStructuredGrid()
    mesh.SetExtent(2, 6, 0, 5, -1, 3)
    z, y, x = np.meshgrid(
        *(np.linspace(a, b, n) for a, b, n in zip(LOW[::-1], HIGH[::-1], (5, 6, 5))), indexing="ij"
    )
    set_places(mesh, np.stack([x, y, z + 0.05 * x * y], axis=-1).reshape(-1, 3))
    return decorated(mesh)


def rectilinear():
    mesh = vtkRectilinearGrid()
    mesh.SetExtent(2, 6, 0, 5, -1, 3)
    for axis, name in enumerate("XYZ"):
        t = np.linspace(0, 1, (5, 6, 5)[axis]) ** 1.3
        values = arrays.from_numpy(LOW[axis] + t * (HIGH - LOW)[axis], VTK_DOUBLE)
        getattr(mesh, f"Set{name}Coordinates")(values)
    return decorated(mesh)


def explicit_structured():
    grid = cells(VTK_HEXAHEDRON, 3)
    mesh = vtkExplicitStructuredGrid()
    mesh.SetExtent(0, 3, 0, 3, 0, 3)
    mesh.SetPoints(grid.GetPoints())
    mesh.SetCells(grid.GetCells())
    return decorated(mesh)


def point_set():
    mesh = vtkPointSet()
    set_places(mesh, np.random.default_rng(1).uniform(LOW, HIGH, (50, 3)))
    return decorated(mesh)


MESHES = {
    **{f"cells {kind}": lambda kind=kind: cells(kind) for kind in [*LINEAR, *QUADRATIC]},
    "single precision": lambda: cells(VTK_TETRA, vtk_type=VTK_FLOAT),
    "polyhedra": lambda: polyhedra(3),
    "mixed": mixed,
    "polydata": sphere,
    "structured": structured,
    "rectilinear": rectilinear,
    "explicit structured": explicit_structured,
    "points": point_set,
}
VOLUMES = [name for name in MESHES if name not in ("mixed", "polydata", "points")]


@pytest.fixture(params=MESHES)
def mesh(request):
    return MESHES[request.param]()


def deforming(mesh, handles=None, device=FAST, cut=None, **properties):  # noqa: F811
    filter_ = connect(MLSDeform(), mesh, handles or control_points())
    filter_.SetDevice(device)
    if cut is not None:
        filter_.AddCut(cut)
    for name, value in properties.items():
        getattr(filter_, f"Set{name}")(value)
    return filter_


def array_of(dataset, name, data="Point"):
    return arrays.to_numpy(getattr(dataset, f"Get{data}Data")().GetArray(name))


def count(dataset, name):
    return dataset.GetFieldData().GetArray(name).GetValue(0)


def as_grid(mesh):
    append = vtkAppendFilter()
    append.AddInputData(mesh)
    append.SetOutputPointsPrecision(2)
    append.Update()
    return append.GetOutput()


def sizes(mesh):
    """Signed size of each cell of the highest dimension."""
    filter_ = vtkCellSizeFilter()
    filter_.SetInputData(mesh)
    filter_.Update()
    data = filter_.GetOutput().GetCellData()
    volumes = arrays.to_numpy(data.GetArray("Volume"))
    return volumes if volumes.any() else arrays.to_numpy(data.GetArray("Area"))


def test_points_go_where_the_value_says(mesh, device):  # noqa: F811
    before = np.array([mesh.GetPoint(i) for i in range(mesh.GetNumberOfPoints())])
    output = update(deforming(mesh, device=device))
    expected = reference().forward(before)
    after = places_of(output)
    np.testing.assert_allclose(after, expected, atol=5e-5)
    assert after.dtype == (
        np.float32
        if mesh.IsA("vtkUnstructuredGrid") and mesh.GetPoints().GetDataType() == VTK_FLOAT
        else np.float64
    )
    displacement = array_of(output, "ForwardDisplacement")
    assert displacement.dtype == np.float32
    np.testing.assert_allclose(displacement, after - before, atol=1e-5)
    assert count(output, "FailedInverses") == 0
    assert not array_of(output, "NoInverse").any()


def test_everything_else_is_kept(mesh):
    kept = mesh.NewInstance()
    kept.DeepCopy(mesh)
    output = update(deforming(mesh))
    rectilinear = mesh.IsA("vtkRectilinearGrid")
    assert output.GetClassName() == ("vtkStructuredGrid" if rectilinear else mesh.GetClassName())
    assert output.GetNumberOfCells() == mesh.GetNumberOfCells()
    for number in range(0, mesh.GetNumberOfCells(), 7):
        ids, old = output.GetCell(number).GetPointIds(), mesh.GetCell(number).GetPointIds()
        ids, old = ([i.GetId(k) for k in range(i.GetNumberOfIds())] for i in (ids, old))
        assert rectilinear or output.GetCellType(number) == mesh.GetCellType(number)
        assert sorted(ids) == sorted(old)
    for data in ("Point", "Cell", "Field"):
        ours, theirs = (getattr(d, f"Get{data}Data")() for d in (output, kept))
        for i in range(theirs.GetNumberOfArrays()):
            old = theirs.GetAbstractArray(i)
            if old.GetName() == "Normals":
                continue
            new = ours.GetAbstractArray(old.GetName())
            values = [
                [a.GetVariantValue(k).ToString() for k in range(a.GetNumberOfValues())]
                for a in (new, old)
            ]
            assert values[0] == values[1], old.GetName()
    # and the input is as it was
    names = [
        mesh.GetPointData().GetArrayName(i) for i in range(mesh.GetPointData().GetNumberOfArrays())
    ]
    assert "ForwardDisplacement" not in names
    assert not mesh.GetFieldData().HasArray("FailedInverses")
    assert mesh.GetBounds() == kept.GetBounds()


@pytest.mark.parametrize(
    "options",
    [
        {"kind": "affine"},
        {"kind": "similarity"},
        {"kind": "polynomial", "degree": 2},
        {"kind": "rigid"},
    ],
)
def test_mesh_and_image_stay_registered(options, rng):
    image = make_image((72, 72, 60), origin=(-1, -1, -1))
    image.SetSpacing(0.15, 0.15, 0.15)
    x = np.array([image.GetPoint(i) for i in range(image.GetNumberOfPoints())])
    add_array(image.GetPointData(), "f", smooth(x))
    mesh = cells(VTK_TETRA, 24)
    add_array(mesh.GetPointData(), "f", smooth(places_of(mesh)))
    outputs = []
    for each in (image, mesh):
        filter_ = deforming(each)
        for name, value in options.items():
            getattr(filter_, f"Set{name.title()}")(value)
        outputs.append(update(filter_))
    probes = vtkPolyData()
    set_places(probes, rng.uniform(LOW, HIGH, (10_000, 3)))
    values, valid = [], np.ones(10_000, bool)
    for output in outputs:
        probe = vtkProbeFilter()
        probe.SetInputData(probes)
        probe.SetSourceData(output)
        probe.Update()
        values.append(array_of(probe.GetOutput(), "f"))
        valid &= array_of(probe.GetOutput(), "vtkValidPointMask") > 0
    assert valid.sum() > 5000
    # a quarter of the second derivative (0.5) times the square of the edge length (0.35), twice
    assert np.abs(values[0] - values[1])[valid].max() < 0.04
    assert np.ptp(values[0][valid]) > 1


def smooth(x):
    return np.sin(0.7 * x[:, 0]) + np.cos(0.6 * x[:, 1]) * np.sin(0.5 * x[:, 2])


def test_normals_stay_normal():
    sphere_ = sphere()
    normals = vtkPolyDataNormals()
    normals.SetInputData(sphere_)
    normals.ComputeCellNormalsOn()
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.SetOutputPointsPrecision(1)
    normals.Update()
    output = update(deforming(normals.GetOutput()))
    again = vtkPolyDataNormals()
    again.SetInputData(output)
    again.ComputeCellNormalsOn()
    again.SplittingOff()
    again.ConsistencyOff()
    again.Update()
    for data in ("Point", "Cell"):
        turned = array_of(output, "Normals", data)
        true = array_of(again.GetOutput(), "Normals", data)
        np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1, atol=1e-5)
        # as far as facets have the normals of what they stand for
        assert np.sum(turned * true, axis=1).min() > 0.99
        assert getattr(output, f"Get{data}Data")().GetNormals() is not None
    straight = np.abs(array_of(output, "Normals") - array_of(normals.GetOutput(), "Normals"))
    assert straight.max() > 0.1


def test_vectors_are_pushed_and_gradients_turned(rng):
    mesh = cells(VTK_TETRA)
    x = places_of(mesh)
    flow, slope = rng.normal(size=x.shape), rng.normal(size=x.shape)
    for name, values in (("flow", flow), ("slope", slope), ("other", flow)):
        add_array(mesh.GetPointData(), name, values)
    in_cells = rng.normal(size=(mesh.GetNumberOfCells(), 3))
    add_array(mesh.GetCellData(), "flow", in_cells)
    filter_ = deforming(mesh)
    filter_.AddPushForwardArray("flow")
    filter_.AddGradientVectorArray("slope")
    output = update(filter_)
    d, step = reference(), 1e-5
    ahead, behind = d.forward(x + step * flow), d.forward(x - step * flow)
    np.testing.assert_allclose(array_of(output, "flow"), (ahead - behind) / (2 * step), atol=2e-3)
    turned = np.einsum("nij,ni->nj", d.jacobian(d.forward(x)), slope)
    np.testing.assert_allclose(array_of(output, "slope"), turned, atol=1e-3)
    np.testing.assert_array_equal(array_of(output, "other"), flow)
    centers = vtkCellCenters()
    centers.SetInputData(output)
    centers.Update()
    jacobian = d.jacobian(places_of(centers.GetOutput()))
    expected = np.linalg.solve(jacobian, in_cells[..., None])[..., 0]
    np.testing.assert_allclose(array_of(output, "flow", "Cell"), expected, atol=2e-3)


def test_a_vector_array_must_be_one(messages):  # noqa: F811
    filter_ = deforming(cells(VTK_TETRA))
    filter_.AddPushForwardArray("linear")
    assert not filter_.GetExecutive().Update()
    messages.assert_one("`PushForwardArrays` names `linear`, which must have 3 components")
    filter_.ClearPushForwardArrays()
    filter_.AddPushForwardArray("nothing")
    assert not filter_.GetExecutive().Update()
    messages.assert_one("`PushForwardArrays` names `nothing`, which the input has not")
    filter_.ClearPushForwardArrays()
    assert update(filter_).GetNumberOfPoints() > 0


def test_jacobian_is_that_of_the_map(device):  # noqa: F811
    mesh = cells(VTK_TETRA)
    output = update(
        deforming(mesh, device=device, GenerateJacobian=True, GenerateJacobianDeterminant=True)
    )
    expected = reference().jacobian(places_of(output))
    ours = array_of(output, "Jacobian").reshape(-1, 3, 3)
    np.testing.assert_allclose(ours, expected.swapaxes(1, 2), atol=1e-3)
    np.testing.assert_allclose(
        array_of(output, "JacobianDeterminant"), np.linalg.det(expected), atol=1e-3
    )
    assert count(output, "InvertedCells") == 0


@pytest.mark.parametrize("kind", [*LINEAR, *QUADRATIC])
def test_cells_inside_out_are_counted(kind):
    handles = control_points(REST, REST * [1, 1, -1])
    filter_ = deforming(cells(kind), handles, Kind="affine", GenerateJacobianDeterminant=True)
    output = update(filter_)
    assert count(output, "InvertedCells") == output.GetNumberOfCells()
    assert (array_of(output, "JacobianDeterminant") < 0).all()
    handles.SetDeformedPoints(DEFORMED)
    assert count(update(filter_), "InvertedCells") == 0


def test_what_has_no_inverse_is_marked_and_counted():
    # the half x > 4 is pushed over the cut into the other half
    rest = np.array([(x, y, z) for x in (2.0, 6.0) for y in (1, 7) for z in (1, 5)])
    deformed = rest - np.where(rest[:, :1] > 4, [[1.0, 0, 0]], [[0.0, 0, 0]])
    cut = Plane((4, 4, 3), (1, 0, 0))
    mesh = cells(VTK_TETRA, 8)
    output = update(deforming(mesh, control_points(rest, deformed), cut=cut, SplitCells=False))
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
    one = vtkPolyData()
    set_places(one, [[7, 7, 5]])
    verts = vtkCellArray()
    verts.InsertNextCell(1, [0])
    one.SetVerts(verts)
    for cut in (None, CUTS["plane"], Plane((7, 7, 5), (1, 0, 0))):
        output = update(deforming(one, cut=cut))
        assert (output.GetNumberOfPoints(), output.GetNumberOfVerts()) == (1, 1)
        assert output.GetPoint(0) != (7, 7, 5)


@pytest.mark.parametrize("kind", [vtkMultiBlockDataSet, vtkPartitionedDataSetCollection])
def test_composite_data_of_all_types(kind):
    blocks = [cells(VTK_TETRA), make_image(), sphere(), None, rectilinear()]
    composite = kind()
    for number, block in enumerate(blocks):
        if kind is vtkMultiBlockDataSet:
            composite.SetBlock(number, block)
        else:
            part = vtkPartitionedDataSet()
            if block is not None:
                part.SetPartition(0, block)
            composite.SetPartitionedDataSet(number, part)
    filter_ = deforming(composite)
    for cut in (None, CUTS["plane"]):
        if cut is not None:
            filter_.AddCut(cut)
        output = update(filter_)
        for number, block in enumerate(blocks):
            if kind is vtkMultiBlockDataSet:
                ours = output.GetBlock(number)
            else:
                ours = output.GetPartition(number, 0)
            if block is None:
                assert ours is None
                continue
            alone = update(deforming(block, cut=cut))
            assert ours.GetClassName() == alone.GetClassName()
            assert ours.GetBounds() == alone.GetBounds()
            assert ours.GetNumberOfCells() == alone.GetNumberOfCells()


def test_names_of_arrays_are_those_of_any_block(messages):  # noqa: F811
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


# Cut meshes


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("name", VOLUMES)
def test_cells_are_split_along_the_cut(name, cut):
    mesh, cut = MESHES[name](), CUTS[cut]
    output, shift = split(mesh, [cut])
    assert output.GetClassName() == "vtkUnstructuredGrid"
    x = places_of(output)
    assert np.isclose(sizes(output).sum(), sizes(as_grid(mesh)).sum(), rtol=1e-2)
    assert (sizes(output) > 0).all()
    np.testing.assert_allclose(array_of(output, "linear"), linear(x), atol=1e-5)
    # no cell is on both sides: its middle sees all of its corners, seen from their side
    centers = vtkCellCenters()
    centers.SetInputData(output)
    centers.Update()
    middle = places_of(centers.GetOutput()).astype(np.float64)
    corners = arrays.to_numpy(output.GetCells().GetConnectivityArray())
    cell = np.repeat(
        np.arange(len(middle)), np.diff(arrays.to_numpy(output.GetCells().GetOffsetsArray()))
    )
    blocked = cut.opening(middle[cell], (x + shift)[corners]) < 0
    assert blocked.sum() <= (0 if cut is not CUTS["tent"] else 0.002 * len(blocked))
    # each piece has the data of the cell it was part of
    origin = array_of(output, "number", "Cell").astype(int)
    total = np.bincount(origin, sizes(output), mesh.GetNumberOfCells())
    np.testing.assert_allclose(total, sizes(as_grid(mesh)), rtol=1e-2)


@pytest.mark.parametrize(
    ("cut", "parts"), [("plane", 2), ("half-plane", 1), ("polygon", 1), ("tent", 2)]
)
@pytest.mark.parametrize("kind", [VTK_TETRA, VTK_HEXAHEDRON, VTK_POLYHEDRON, VTK_QUADRATIC_TETRA])
def test_what_is_not_cut_stays_in_one_piece(cut, parts, kind):
    output, shift = split(cells(kind), [CUTS[cut]])
    connected = vtkConnectivityFilter()
    connected.SetInputData(output)
    connected.SetExtractionModeToAllRegions()
    connected.Update()
    assert connected.GetNumberOfExtractedRegions() == parts
    # no points are double but those on the cut
    x = places_of(output)[~shift.any(axis=1)]
    assert len(np.unique(x.round(9), axis=0)) == len(x)
    assert shift.any(axis=1).sum() > 0


def test_tetrahedra_stay_tetrahedra():
    output, _ = split(cells(VTK_TETRA), [CUTS["plane"], CUTS["polygon"]])
    assert (arrays.cell_types(output) == VTK_TETRA).all()


@pytest.mark.parametrize("name", ["cells 10", "polydata", "structured"])
def test_split_meshes_keep_their_active_arrays(name):
    mesh = MESHES[name]()
    mesh.GetPointData().SetActiveScalars("linear")
    mesh.GetCellData().SetActiveScalars("number")
    output, _ = split(mesh, [CUTS["plane"]])
    assert output.GetPointData().GetScalars().GetName() == "linear"
    assert output.GetCellData().GetScalars().GetName() == "number"


def test_a_cut_along_faces_needs_no_new_cells():
    mesh = cells(VTK_HEXAHEDRON, 4)
    middle = (LOW + HIGH) / 2
    output, shift = split(mesh, [Plane(middle, (1, 0, 0))])
    assert output.GetNumberOfCells() == mesh.GetNumberOfCells()
    assert output.GetNumberOfPoints() == mesh.GetNumberOfPoints() + 25
    assert shift.any(axis=1).sum() == 50


def test_several_cuts_cross():
    middle = (LOW + HIGH) / 2
    cuts = [Plane(middle + 0.01, normal) for normal in np.eye(3)]
    for kind in (VTK_TETRA, VTK_HEXAHEDRON):
        output, _ = split(cells(kind), cuts)
        connected = vtkConnectivityFilter()
        connected.SetInputData(output)
        connected.SetExtractionModeToAllRegions()
        connected.Update()
        assert connected.GetNumberOfExtractedRegions() == 8


def test_points_of_ones_own_that_coincide_stay_apart():
    append = vtkAppendFilter()
    append.AddInputData(cells(VTK_TETRA))
    append.AddInputData(cells(VTK_TETRA))
    append.Update()
    both, _ = split(append.GetOutput(), [CUTS["half-plane"]])
    one, _ = split(cells(VTK_TETRA), [CUTS["half-plane"]])
    assert both.GetNumberOfPoints() == 2 * one.GetNumberOfPoints()
    assert both.GetNumberOfCells() == 2 * one.GetNumberOfCells()


def test_a_cut_elsewhere_changes_nothing(mesh):
    away = Surface.polygon([(40, 2, 1), (40, 6, 1), (40, 6, 5)])
    output, shift = split(mesh, [Plane((50, 0, 0), (1, 0, 0)), away])
    assert not shift.any()
    assert output.GetNumberOfCells() == mesh.GetNumberOfCells()
    assert output.GetNumberOfPoints() == mesh.GetNumberOfPoints()


OPENED = DEFORMED + np.where(REST[:, :1] > 4, [[1.2, 0, 0]], [[-1.2, 0, 0]])


@pytest.mark.parametrize("cut", ["plane", "half-plane", "polygon"])
@pytest.mark.parametrize("name", ["cells 10", "structured", "polyhedra"])
def test_each_side_moves_by_its_own_map(name, cut, device):  # noqa: F811
    mesh, cut = MESHES[name](), CUTS[cut]
    output = update(deforming(mesh, control_points(REST, OPENED), device, cut))
    assert output.GetClassName() == "vtkUnstructuredGrid"
    d = Deformation(REST, OPENED, cuts=[cut], device="reference")
    undeformed, shift = split(mesh, [cut])
    x = places_of(undeformed) + shift
    field = d.forward_field(x)
    sane = field.found
    found = array_of(output, "NoInverse") == 0
    assert (found == sane).mean() > 0.995
    v = places_of(output).astype(np.float64)
    expected = places_of(undeformed) + field.displacement
    both = found & sane
    assert np.abs(v - expected)[both].max() < 5e-4
    # the sides have come apart: there is room between them, and it is the void
    face = np.flatnonzero(shift.any(axis=1) & both)
    assert np.ptp(v[face, 0]) > 0.5 + np.ptp(x[face, 0])
    between = v[face] - 0.05 * np.sign(shift[face] @ [1, 0, 0])[:, None] * [1.0, 0, 0]
    assert d.void(between).mean() > 0.7


def test_polydata_stays_polydata():
    mesh = sphere()
    lines = vtkCellArray()
    lines.InsertNextCell(3, [0, 100, 1])
    mesh.SetLines(lines)
    mesh.GetCellData().Initialize()
    add_array(mesh.GetCellData(), "number", np.arange(mesh.GetNumberOfCells()))
    output = update(deforming(mesh, control_points(REST, OPENED), cut=CUTS["plane"]))
    assert output.GetClassName() == "vtkPolyData"
    assert output.GetNumberOfLines() > 1
    assert output.GetNumberOfPolys() > mesh.GetNumberOfPolys()
    number = array_of(output, "number", "Cell")
    assert set(number[: output.GetNumberOfLines()]) == {0}
    assert set(number[output.GetNumberOfLines() :]) == set(range(1, mesh.GetNumberOfCells()))
    assert sizes(split(mesh, [CUTS["plane"]])[0]).sum() == pytest.approx(sizes(mesh).sum())


@pytest.mark.parametrize("name", ["cells 10", "structured", "rectilinear", "polydata"])
def test_whole_cells_are_marked_and_hidden(name):
    mesh = MESHES[name]()
    ghosts = np.zeros(mesh.GetNumberOfCells())
    ghosts[5] = vtkDataSetAttributes.DUPLICATECELL
    add_array(mesh.GetCellData(), arrays.GHOSTS, ghosts, 3)
    cut = CUTS["half-plane"]
    filter_ = deforming(mesh, control_points(REST, OPENED), cut=cut, SplitCells=False)
    output = update(filter_)
    assert output.GetNumberOfCells() == mesh.GetNumberOfCells()
    torn = []
    for number in range(mesh.GetNumberOfCells()):
        points = mesh.GetCell(number).GetPoints()
        x = np.array([points.GetPoint(i) for i in range(points.GetNumberOfPoints())])
        a, b = np.triu_indices(len(x), 1)
        torn.append((cut.opening(x[a], x[b]) < 0).any())
    np.testing.assert_array_equal(array_of(output, "Void", "Cell"), torn)
    expected = ghosts + vtkDataSetAttributes.HIDDENCELL * np.array(torn)
    np.testing.assert_array_equal(array_of(output, arrays.GHOSTS, "Cell"), expected)
    assert sum(torn) > 0


@pytest.mark.parametrize("way", ["AddCut", "properties", "port 2"])
def test_dragging_does_not_split_again(way, monkeypatch):
    calls = []
    monkeypatch.setattr(warping, "split", lambda *a: calls.append(1) or splitting.split(*a))
    mesh, handles, scalpel = cells(VTK_TETRA), control_points(), vtkPlaneSource()
    scalpel.SetOrigin(4.03, 1, 1)
    scalpel.SetPoint1(4.03, 6, 1)
    scalpel.SetPoint2(4.03, 1, 5)
    filter_ = deforming(mesh, handles)
    if way == "AddCut":
        filter_.AddCut(CUTS["plane"])
    elif way == "properties":
        filter_.SetCutType("plane")
        filter_.SetCutOrigin(4.03, 4, 3)
    else:
        filter_.SetInputConnection(2, scalpel.GetOutputPort())
    update(filter_)
    handles.SetDeformedPoints(OPENED)
    update(filter_)
    filter_.SetKind("affine")
    update(filter_)
    assert len(calls) == 1
    mesh.Modified()
    update(filter_)
    assert len(calls) == 2
    filter_.AddCut(CUTS["half-plane"])
    update(filter_)
    assert len(calls) == 3


def test_abort_leaves_nothing_and_progress_rises():
    filter_ = deforming(cells(VTK_TETRA, 20), GenerateJacobian=True)
    seen = []
    filter_.AddObserver("ProgressEvent", lambda *_: seen.append(filter_.GetProgress()))
    update(filter_)
    assert seen == sorted(seen)
    assert 0 < np.median(seen) < seen[-1] == 1
    tag = filter_.AddObserver("ProgressEvent", lambda *_: filter_.SetAbortExecute(1))
    filter_.Modified()
    filter_.Update()
    assert filter_.GetOutput().GetNumberOfPoints() == 0
    filter_.RemoveObserver(tag)
    filter_.SetAbortExecute(0)
    filter_.Modified()
    assert update(filter_).GetNumberOfPoints() > 0
