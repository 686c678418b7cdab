"""`InvertedCells` and `UncheckedCells`, against signed areas, volumes and VTK's scaled Jacobian."""

from functools import partial

import numpy as np
import pytest
from mesh_fixtures import (
    FLAT_PINCHED,
    PINCHED,
    QUADRATIC,
    cells,
    count,
    count_inverted,
    deforming,
    explicit_structured,
    grid_of,
    pinch,
    places_of,
    plate,
    rectilinear,
    scaled_jacobians_of,
    set_places,
    sphere,
    structured,
)
from pipelines import control_points, update
from vtk_fixtures import REST, add_array, polydata_of
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR, vtkIdList
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAGONAL_PRISM,
    VTK_HEXAHEDRON,
    VTK_PENTAGONAL_PRISM,
    VTK_PIXEL,
    VTK_POLYGON,
    VTK_POLYHEDRON,
    VTK_PYRAMID,
    VTK_QUAD,
    VTK_TETRA,
    VTK_TRIANGLE,
    VTK_TRIANGLE_STRIP,
    VTK_VOXEL,
    VTK_WEDGE,
    vtkCellArray,
    vtkDataSetAttributes,
    vtkPolyData,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)

from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured
from vtk_mls.vtk.orientation import _find_faces_in_stream, _structured

MIRRORED = control_points(REST, REST * [1, 1, -1])
FOLDED = FLAT_PINCHED + np.outer([0, 0, 0, 0, 1.8, -1.8], [1, 0, 0])


def judged(mesh, handles, **options):
    output = update(deforming(mesh, handles, GenerateJacobianDeterminant=True, **options))
    return output, count(output, "InvertedCells"), count(output, "UncheckedCells")


SOLID = partial(cells, VTK_HEXAHEDRON), structured, rectilinear, explicit_structured


@pytest.mark.parametrize("make", SOLID)
def test_mirrored_and_turned(make):
    mesh = make()
    total = mesh.GetNumberOfCells()
    assert judged(mesh, MIRRORED, Kind="affine")[1:] == (total, 0)
    turned = control_points(REST, REST * [-1, 1, -1])
    assert judged(mesh, turned, Kind="rigid")[1:] == (0, 0)


# Surfaces


TURNS = [np.eye(3)]
for _axis, _degrees in ((0, 90), (0, 180), (1, 137), (2, 180)):
    _c, _s = np.cos(np.radians(_degrees)), np.sin(np.radians(_degrees))
    TURNS.append(np.roll([(_c, -_s, 0), (_s, _c, 0), (0, 0, 1)], _axis + 1, (0, 1)))


@pytest.mark.parametrize("turn", TURNS)
def test_quads_by_their_signed_areas(turn):
    """The plate lies anywhere, and turns by any angle while it is folded."""
    mesh = plate()
    corners = arrays.to_numpy(mesh.GetCells().GetConnectivityArray()).reshape(-1, 4)
    # alpha 2 turns the plate over between the two handles, which areas in its plane cannot tell
    handles = control_points(FLAT_PINCHED, FOLDED @ turn.T)
    output, inverted, unchecked = judged(mesh, handles, Alpha=1, Device="reference")
    flat = places_of(output) @ turn
    at_corners = [areas(flat[np.roll(corners, k, axis=1)[:, :3]]) for k in range(4)]
    assert inverted == (np.min(at_corners, axis=0) <= 0).sum() > 0
    assert unchecked == 0


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("make", [sphere, plate])
def test_surfaces_may_turn(make, turn):
    mesh = make()
    handles = control_points(REST, (REST - 4) @ turn.T + 5)
    assert judged(mesh, handles, Kind="rigid")[1:] == (0, 0)


def test_a_long_strip_is_judged_as_its_triangles_are():
    """A strip that is folded once."""
    size = 100_000
    x = np.stack([np.arange(size) / 2, np.arange(size) % 2, np.zeros(size)], axis=1)
    moved = x * (1, 1, 1)
    moved[-1, 1] *= -3
    numbers = np.arange(size - 2)[:, None] + np.arange(3)
    found = []
    for set_cells, ids in (("SetPolys", numbers), ("SetStrips", np.arange(size)[None])):
        mesh, some = vtkPolyData(), vtkCellArray()
        set_places(mesh, x)
        some.SetData(ids.shape[1], arrays.ids(ids.ravel()))
        getattr(mesh, set_cells)(some)
        found.append(count_inverted(mesh, x, moved, np.broadcast_to(np.eye(3), (size, 3, 3))))
    assert found == [(1, 0), (1, 0)]


def test_points_of_a_cell_of_a_large_structured_grid():
    ((_, _, points),) = _structured((0, 9999, 0, 9999, 0, 9999), np.array([9999]))
    assert points.tolist() == [
        [plane + corner for plane in (10**4, 10**4 + 10**8) for corner in (0, 1, 10**4 + 1, 10**4)]
    ]


@pytest.mark.parametrize("dimensions", [None, (21, 21, 1), (21, 1, 21), (1, 21, 21)])
def test_quads_of_other_meshes_are_those_of_a_grid(dimensions):
    quads, handles = plate(), control_points(FLAT_PINCHED, FOLDED)
    if dimensions:
        mesh = configured(vtkStructuredGrid(), Dimensions=dimensions)
    else:
        mesh = configured(vtkPolyData(), Polys=quads.GetCells())
    mesh.SetPoints(quads.GetPoints())
    expected, found = (judged(dataset, handles)[1:] for dataset in (quads, mesh))
    assert found == expected
    assert expected[0] > 0


def test_blanked_cells_of_structured_grids_do_not_count():
    mesh = structured()
    mesh.BlankPoint(0)  # of one cell
    mesh.BlankPoint(7 + 5 * 2 + 30)  # of eight cells
    visible = [mesh.IsCellVisible(i) for i in range(mesh.GetNumberOfCells())]
    assert judged(mesh, MIRRORED, Kind="affine")[1:] == (sum(visible), 0)
    assert sum(visible) == mesh.GetNumberOfCells() - 9


def test_concave_polygons_are_not_inside_out():
    mesh = polydata_of([(1, 1, 3), (7, 1, 3), (7, 7, 3), (6, 2, 3)], Polys=[range(4)])
    assert judged(mesh, control_points(REST, REST + 1))[1:] == (0, 0)
    assert judged(mesh, control_points(REST, REST * [1, -1, 1]), Kind="affine")[1:] == (1, 0)


# Cells that are not judged, and cells that do not count


@pytest.mark.parametrize("kind", QUADRATIC)
def test_curved_cells_are_known_by_their_corners_only(kind):
    mesh = cells(kind)
    total = mesh.GetNumberOfCells()
    assert judged(mesh, control_points(REST, REST + 1))[1:] == (0, total)
    assert judged(mesh, MIRRORED, Kind="affine")[1:] == (total, 0)


def test_lines_vertices_and_cells_without_size_are_unchecked():
    unknown = [
        (1, [0]),
        (3, [0, 1]),
        (4, [0, 1, 2]),
        (0, []),
        (VTK_TRIANGLE, [0, 1, 2]),  # on a line
        (VTK_TETRA, [0, 1, 2, 3]),  # in a plane
        (VTK_TRIANGLE, [0, 1, 5]),  # nowhere
        (VTK_TETRA, [0, 1, 3, 5]),
    ]
    places = [(1, 1, 1), (3, 1, 1), (5, 1, 1), (1, 4, 1), (1, 1, 5), (np.nan, 0, 0)]
    mesh = grid_of(places, [*unknown, (VTK_TETRA, [0, 1, 3, 4]), (VTK_TRIANGLE, [0, 1, 3])])
    assert judged(mesh, control_points(REST, REST + 1))[1:] == (0, len(unknown))
    assert judged(mesh, MIRRORED, Kind="affine")[1:] == (2, len(unknown))


def test_a_hexahedron_that_is_a_wedge():
    """As many programs write wedges: its doubled corners have no size, the others count."""
    corners = [(1, 1, 1), (4, 1, 1), (4, 4, 1), (1, 1, 5), (4, 1, 5), (4, 4, 5)]
    mesh = grid_of(corners, [(VTK_HEXAHEDRON, [0, 1, 2, 2, 3, 4, 5, 5])])
    assert judged(mesh, control_points(REST, REST + 1))[1:] == (0, 0)
    assert judged(mesh, MIRRORED, Kind="affine")[1:] == (1, 0)


@pytest.mark.parametrize("make", [lambda: cells(VTK_HEXAHEDRON), structured])
@pytest.mark.parametrize("flag", ["DUPLICATECELL", "HIDDENCELL"])
def test_cells_of_others_and_hidden_ones_do_not_count(make, flag):
    mesh = make()
    ghosts = np.zeros(mesh.GetNumberOfCells(), np.uint8)
    ghosts[::3] = getattr(vtkDataSetAttributes, flag)
    add_array(mesh.GetCellData(), arrays.GHOSTS, ghosts, VTK_UNSIGNED_CHAR)
    assert judged(mesh, MIRRORED, Kind="affine")[1:] == ((ghosts == 0).sum(), 0)


@pytest.mark.parametrize("shift", [0, 5e6])
@pytest.mark.parametrize("size", [1e-6, 1, 1e6])
def test_wherever_the_mesh_is_and_whatever_its_unit(shift, size):
    """The same cells in other units, and in a world that begins far away."""
    mesh, handles = cells(VTK_HEXAHEDRON, 14), pinch(2.5)
    expected = judged(mesh, handles)[1:]
    place = shift * size
    set_places(mesh, places_of(mesh) * size + place)
    moved = PINCHED.copy()
    moved[-2:, 0] += (2.5, -2.5)
    handles = control_points(PINCHED * size + place, moved * size + place)
    inverted, unchecked = judged(mesh, handles)[1:]
    assert unchecked == 0
    assert abs(inverted - expected[0]) <= (2 if shift else 0)  # coordinates of 1e-9 are rounded


def test_only_on_request():
    output = update(deforming(cells(VTK_HEXAHEDRON), GenerateJacobian=True))
    for name in ("InvertedCells", "UncheckedCells"):
        assert not output.GetFieldData().HasArray(name)


def test_a_stream_of_faces_may_have_none():
    """Before VTK 9.4 a polyhedron without faces is a count of 0 in the stream."""
    owner, first, size, _ = _find_faces_in_stream(
        arrays.ids(np.array([0])), arrays.ids(np.array([0])), np.array([0])
    )
    assert len(owner) == len(first) == len(size) == 0


# Random cells of each linear type, against VTK's own measures


COUNT = 400
VOXEL_ORDER = [0, 1, 3, 2, 4, 5, 7, 6]


def ring(sides):
    angle = 2 * np.pi * np.arange(sides) / sides
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)


def prism(sides):
    return np.concatenate([ring(sides), ring(sides) + (0, 0, 1.2)])


CORNERS = {
    VTK_TRIANGLE: ring(3),
    VTK_QUAD: ring(4),
    VTK_PIXEL: ring(4)[VOXEL_ORDER[:4]],
    VTK_POLYGON: ring(5),
    VTK_TRIANGLE_STRIP: np.array([(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (2, 0, 0)], float),
    VTK_TETRA: np.concatenate([ring(3), [(0, 0, 1.2)]]),
    VTK_HEXAHEDRON: prism(4),
    VTK_VOXEL: prism(4)[VOXEL_ORDER],
    VTK_WEDGE: prism(3),
    VTK_PYRAMID: np.concatenate([ring(4), [(0, 0, 1.2)]]),
    VTK_PENTAGONAL_PRISM: prism(5),
    VTK_HEXAGONAL_PRISM: prism(6),
}


def cells_of(kind, corners):
    """Cells (n, k, 3) that share no points."""
    ids = np.arange(corners.shape[0] * corners.shape[1]).reshape(len(corners), -1)
    cells = [(kind, row) for row in ids.tolist()]
    return grid_of(corners.reshape(-1, 3), cells)


def ids_of(cell):
    ids = cell.GetPointIds()
    return [ids.GetId(i) for i in range(ids.GetNumberOfIds())]


def as_polyhedra(grid):
    """The same cells, told by the faces that VTK says they have."""
    result = vtkUnstructuredGrid()
    result.SetPoints(grid.GetPoints())
    for number in range(grid.GetNumberOfCells()):
        cell, stream = grid.GetCell(number), vtkIdList()
        stream.InsertNextId(cell.GetNumberOfFaces())
        for face in range(cell.GetNumberOfFaces()):
            ids = ids_of(cell.GetFace(face))
            for value in (len(ids), *ids):
                stream.InsertNextId(value)
        result.InsertNextCell(VTK_POLYHEDRON, stream)
    return result


def assert_inverted(grid, before, after, expected):
    """The cells (n,) bool, and no others, are inverted; all can be checked.

    By the numbers in parts of the mesh, by each binary digit of the number of a cell.
    """
    jacobian = np.broadcast_to(np.eye(3), (before.shape[0] * before.shape[1], 3, 3))
    rows = before.reshape(-1, 3), after.reshape(-1, 3)
    numbers = np.arange(len(before))
    for digit in range(len(before).bit_length()):
        mask = (numbers >> digit) % 2 == 0
        ghosts = np.where(mask, 0, vtkDataSetAttributes.DUPLICATECELL)
        found = count_inverted(grid, *rows, jacobian, ghosts)
        assert found == (np.count_nonzero(expected & mask), 0)
    assert 0 < expected.sum() < len(expected)


def at_simple_corners(kind, corners):
    """The least scaled Jacobian of the tetrahedra at the corners with three of VTK's edges."""
    cell = cells_of(kind, corners[:1]).GetCell(0)
    edges = [ids_of(cell.GetEdge(i)) for i in range(cell.GetNumberOfEdges())]
    least = np.full(len(corners), np.inf)
    for corner in range(corners.shape[1]):
        ends = [sum(edge) - corner for edge in edges if corner in edge]
        quality = scaled_jacobians_of(cells_of(VTK_TETRA, corners[:, [corner, *ends]]))
        rest = scaled_jacobians_of(cells_of(VTK_TETRA, CORNERS[kind][None, [corner, *ends]]))
        least = np.minimum(least, quality * np.sign(rest))
    return least


def deformed(kind, rng, spread):
    """The corners (n, k, 3) of equal cells, and after random displacements; flat cells in z = 0."""
    rest = np.broadcast_to(CORNERS[kind], (COUNT, *CORNERS[kind].shape))
    moved = rest + rng.normal(0, spread, rest.shape)
    if not CORNERS[kind][:, 2].any():
        moved[..., 2] = 0
    return rest, moved


@pytest.mark.parametrize("spread", [0.4, 0.8])
@pytest.mark.parametrize("kind", [VTK_TETRA, VTK_HEXAHEDRON, VTK_WEDGE, VTK_PYRAMID])
def test_solid_cells_by_the_scaled_jacobian(kind, spread, rng):
    rest, moved = deformed(kind, rng, spread)
    expected = scaled_jacobians_of(cells_of(kind, moved)) <= 0
    assert_inverted(cells_of(kind, moved), rest, moved, expected)
    assert (scaled_jacobians_of(cells_of(kind, rest)) > 0).all()
    if kind == VTK_HEXAHEDRON:
        voxels = [x[:, VOXEL_ORDER] for x in (rest, moved)]
        assert_inverted(cells_of(VTK_VOXEL, voxels[1]), *voxels, expected)
    if kind in (VTK_TETRA, VTK_WEDGE):
        assert_inverted(as_polyhedra(cells_of(kind, moved)), rest, moved, expected)


@pytest.mark.parametrize("kind", [VTK_PENTAGONAL_PRISM, VTK_HEXAGONAL_PRISM])
def test_prisms_by_the_scaled_jacobian_at_their_corners(kind, rng):
    rest, moved = deformed(kind, rng, 0.25)
    expected = at_simple_corners(kind, moved) <= 0
    assert_inverted(cells_of(kind, moved), rest, moved, expected)
    assert_inverted(as_polyhedra(cells_of(kind, moved)), rest, moved, expected)


def test_polyhedra_with_four_edges_at_a_corner(rng):
    """Pyramids: the tip is looked at, too."""
    rest, moved = deformed(VTK_PYRAMID, rng, 0.3)
    grid = cells_of(VTK_PYRAMID, moved)
    at_base = scaled_jacobians_of(grid) <= 0
    edges = moved - moved.mean(axis=1, keepdims=True)
    sides = [edges[:, [i, (i + 1) % 4, 4]] for i in range(4)]
    at_tip = np.min([np.linalg.det(side) for side in sides], axis=0) <= 0
    assert_inverted(as_polyhedra(grid), rest, moved, at_base | at_tip)


@pytest.mark.parametrize("kind", [VTK_QUAD, VTK_PIXEL])
def test_quads_by_the_scaled_jacobian_and_their_side(kind, rng):
    """VTK's measure tells whether they are concave, the area whether they are turned over."""
    rest, moved = deformed(kind, rng, 0.4)
    quads = moved if kind == VTK_QUAD else moved[:, VOXEL_ORDER[:4]]
    expected = (scaled_jacobians_of(cells_of(VTK_QUAD, quads)) <= 0) | (areas(quads) <= 0)
    assert_inverted(cells_of(kind, moved), rest, moved, expected)


@pytest.mark.parametrize("kind", [VTK_TRIANGLE, VTK_POLYGON, VTK_TRIANGLE_STRIP])
def test_other_flat_cells_by_their_side(kind, rng):
    rest, moved = deformed(kind, rng, 0.8)
    if kind == VTK_TRIANGLE_STRIP:
        triangles = [moved[:, three] for three in ([0, 2, 1], [1, 2, 3], [2, 4, 3])]
        expected = np.min([areas(x) for x in triangles], axis=0) <= 0
    else:
        expected = areas(moved) <= 0
    assert_inverted(cells_of(kind, moved), rest, moved, expected)


def areas(polygons):
    """Signed areas of polygons (n, k, 3) in z = 0."""
    x, y, _ = np.moveaxis(polygons, 2, 0)
    return (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1) / 2


@pytest.mark.parametrize("extent", [(0, 9, 0, 8, 0, 7), (-3, 6, 2, 10, 5, 12)])
def test_structured_grids_by_the_scaled_jacobian(extent, rng):
    grid = vtkStructuredGrid()
    grid.SetExtent(extent)
    axes = [np.arange(a, b + 1.0) for a, b in zip(extent[::2], extent[1::2])]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    rest = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    moved = rest + rng.normal(0, 0.2, rest.shape)
    set_places(grid, moved)
    expected = (scaled_jacobians_of(grid) <= 0).sum()
    jacobian = np.broadcast_to(np.eye(3), (len(rest), 3, 3))
    assert count_inverted(grid, rest, moved, jacobian) == (expected, 0)
    assert 0 < expected < grid.GetNumberOfCells()


def test_cells_that_were_inside_out_keep_their_side(rng):
    """Cells of vtkCellTypeSource. Some have a negative scaled Jacobian at rest."""
    grid = cells(VTK_TETRA, 5)
    before = places_of(grid).copy()
    rest = scaled_jacobians_of(grid)
    after = before + rng.normal(0, 0.4, before.shape)
    set_places(grid, after)
    expected = (scaled_jacobians_of(grid) * np.sign(rest) <= 0).sum()
    jacobian = np.broadcast_to(np.eye(3), (len(before), 3, 3))
    assert count_inverted(grid, before, after, jacobian) == (expected, 0)
    assert expected > 0
