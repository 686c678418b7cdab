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
    set_places,
    sphere,
    structured,
)
from pipelines import control_points, update
from vtk_fixtures import REST, add_array
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAHEDRON,
    VTK_TETRA,
    VTK_TRIANGLE,
    vtkCellArray,
    vtkDataSetAttributes,
    vtkPolyData,
    vtkStructuredGrid,
)

from vtk_mls.vtk import arrays
from vtk_mls.vtk.orientation import _find_faces_in_stream, _structured

MIRRORED = control_points(REST, REST * [1, 1, -1])


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


def areas(points, corners):
    """Signed areas in a plane of constant z."""
    p = points[corners].astype(float)
    after = np.roll(p, -1, axis=1)
    return (p[..., 0] * after[..., 1] - p[..., 1] * after[..., 0]).sum(axis=1) / 2


TURNS = [np.eye(3)]
for _axis, _degrees in ((0, 90), (0, 180), (1, 137), (2, 180)):
    _c, _s = np.cos(np.radians(_degrees)), np.sin(np.radians(_degrees))
    TURNS.append(np.roll([(_c, -_s, 0), (_s, _c, 0), (0, 0, 1)], _axis + 1, (0, 1)))


@pytest.mark.parametrize("turn", TURNS)
def test_quads_by_their_signed_areas(turn):
    """The plate lies anywhere, and turns by any angle while it is folded."""
    mesh = plate()
    corners = arrays.to_numpy(mesh.GetCells().GetConnectivityArray()).reshape(-1, 4)
    moved = FLAT_PINCHED.copy()
    moved[4:, 0] += (1.8, -1.8)
    # alpha 2 turns the plate over between the two handles, which areas in its plane cannot tell
    output, inverted, unchecked = judged(
        mesh, control_points(FLAT_PINCHED, moved @ turn.T), Alpha=1
    )
    flat = places_of(output) @ turn
    at_corners = [areas(flat, np.roll(corners, k, axis=1)[:, :3]) for k in range(4)]
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


def surface_plate():
    surface, quads = vtkPolyData(), plate()
    surface.SetPoints(quads.GetPoints())
    surface.SetPolys(quads.GetCells())
    return surface


def structured_plate(dimensions):
    mesh = vtkStructuredGrid()
    mesh.SetDimensions(*dimensions)
    set_places(mesh, places_of(plate()))
    return mesh


PLATES = [
    surface_plate,
    *(
        partial(structured_plate, dimensions)
        for dimensions in ((21, 21, 1), (21, 1, 21), (1, 21, 21))
    ),
]


@pytest.mark.parametrize("make", PLATES)
def test_quads_of_other_meshes_are_those_of_a_grid(make):
    moved = FLAT_PINCHED.copy()
    moved[4:, 0] += (1.8, -1.8)
    expected, found = (
        judged(mesh, control_points(FLAT_PINCHED, moved))[1:] for mesh in (plate(), make())
    )
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
    mesh, some = vtkPolyData(), vtkCellArray()
    set_places(mesh, [(1, 1, 3), (7, 1, 3), (7, 7, 3), (6, 2, 3)])
    some.InsertNextCell(4, range(4))
    mesh.SetPolys(some)
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
