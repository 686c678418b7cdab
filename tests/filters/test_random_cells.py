"""`InvertedCells` of random cells of each linear type, against VTK's own measures."""

import mesh_fixtures
import numpy as np
import pytest
from mesh_fixtures import cells, count_inverted, places_of, scaled_jacobians_of, set_places
from vtkmodules.vtkCommonCore import vtkIdList
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
    vtkDataSetAttributes,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)

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


def grid_of(kind, corners):
    """Cells (n, k, 3) that share no points."""
    ids = np.arange(corners.shape[0] * corners.shape[1]).reshape(len(corners), -1)
    cells = [(kind, row) for row in ids.tolist()]
    return mesh_fixtures.grid_of(corners.reshape(-1, 3), cells)


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
    cell = grid_of(kind, corners[:1]).GetCell(0)
    edges = [ids_of(cell.GetEdge(i)) for i in range(cell.GetNumberOfEdges())]
    least = np.full(len(corners), np.inf)
    for corner in range(corners.shape[1]):
        ends = [sum(edge) - corner for edge in edges if corner in edge]
        quality = scaled_jacobians_of(grid_of(VTK_TETRA, corners[:, [corner, *ends]]))
        rest = scaled_jacobians_of(grid_of(VTK_TETRA, CORNERS[kind][None, [corner, *ends]]))
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
    expected = scaled_jacobians_of(grid_of(kind, moved)) <= 0
    assert_inverted(grid_of(kind, moved), rest, moved, expected)
    assert (scaled_jacobians_of(grid_of(kind, rest)) > 0).all()
    if kind == VTK_HEXAHEDRON:
        voxels = [x[:, VOXEL_ORDER] for x in (rest, moved)]
        assert_inverted(grid_of(VTK_VOXEL, voxels[1]), *voxels, expected)


@pytest.mark.parametrize("kind", [VTK_PENTAGONAL_PRISM, VTK_HEXAGONAL_PRISM])
def test_prisms_by_the_scaled_jacobian_at_their_corners(kind, rng):
    rest, moved = deformed(kind, rng, 0.25)
    expected = at_simple_corners(kind, moved) <= 0
    assert_inverted(grid_of(kind, moved), rest, moved, expected)
    assert_inverted(as_polyhedra(grid_of(kind, moved)), rest, moved, expected)


@pytest.mark.parametrize("kind", [VTK_TETRA, VTK_WEDGE])
def test_polyhedra_are_judged_as_the_same_cells(kind, rng):
    rest, moved = deformed(kind, rng, 0.4)
    grid = grid_of(kind, moved)
    assert_inverted(as_polyhedra(grid), rest, moved, scaled_jacobians_of(grid) <= 0)


def test_polyhedra_with_four_edges_at_a_corner(rng):
    """Pyramids: the tip is looked at, too."""
    rest, moved = deformed(VTK_PYRAMID, rng, 0.3)
    grid = grid_of(VTK_PYRAMID, moved)
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
    expected = (scaled_jacobians_of(grid_of(VTK_QUAD, quads)) <= 0) | (areas(quads) <= 0)
    assert_inverted(grid_of(kind, moved), rest, moved, expected)


@pytest.mark.parametrize("kind", [VTK_TRIANGLE, VTK_POLYGON, VTK_TRIANGLE_STRIP])
def test_other_flat_cells_by_their_side(kind, rng):
    rest, moved = deformed(kind, rng, 0.8)
    if kind == VTK_TRIANGLE_STRIP:
        triangles = [moved[:, three] for three in ([0, 2, 1], [1, 2, 3], [2, 4, 3])]
        expected = np.min([areas(x) for x in triangles], axis=0) <= 0
    else:
        expected = areas(moved) <= 0
    assert_inverted(grid_of(kind, moved), rest, moved, expected)


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
