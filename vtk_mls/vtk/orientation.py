"""Cells of a mesh that a deformation has turned inside out."""

import functools

import numpy as np
from vtkmodules import vtkCommonDataModel as vtk

from vtk_mls.queries.void_cells import over_corners
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import BOXES, FACES, connectivity_of, polydata_cells

_CHUNK = 1 << 14  # hexahedra, or cells with as many points, per pass
# Shorter lengths, in roundings of float32, have no direction.
_ROUNDINGS = 8

_TETRAHEDRON = [(0, 1, 2, 3)]
_HEXAHEDRON = [(0, 1, 3, 4), (1, 2, 3, 6), (1, 6, 4, 5), (3, 4, 6, 7), (1, 3, 4, 6)]
_WEDGE = [(0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)]
_PYRAMID = [(0, 1, 2, 4), (0, 2, 3, 4)]

# Tetrahedra whose signed volumes add up to that of a cell, by VTK's numbers of cell types. The
# corners of quadratic, Lagrange and Bezier cells come first.
TETRAHEDRA = {
    **dict.fromkeys((10, 24, 71, 78), _TETRAHEDRON),
    **dict.fromkeys((12, 25, 29, 33, 72, 79), _HEXAHEDRON),
    **dict.fromkeys((13, 26, 31, 32, 73, 80), _WEDGE),
    **dict.fromkeys((14, 27, 37, 74, 81), _PYRAMID),
}


def _prism(sides):
    """For each corner of a prism, itself and the ends of its three edges."""
    ring = range(sides)
    lower = [(i, (i + 1) % sides, (i - 1) % sides, i + sides) for i in ring]
    upper = [(i + sides, (i - 1) % sides + sides, (i + 1) % sides + sides, i) for i in ring]
    return lower + upper


# A corner and the ends of its three edges, whose triple product has the sign of the Jacobian.
_CORNER_EDGES = {
    vtk.VTK_TETRA: _TETRAHEDRON,
    vtk.VTK_HEXAHEDRON: _prism(4),
    vtk.VTK_WEDGE: _prism(3),
    vtk.VTK_PYRAMID: [(i, (i + 1) % 4, (i - 1) % 4, 4) for i in range(4)],
    vtk.VTK_PENTAGONAL_PRISM: _prism(5),
    vtk.VTK_HEXAGONAL_PRISM: _prism(6),
}
# Corners at both ends of the axes of a hexahedron.
_AXIS_ENDS = (
    ([0, 3, 4, 7], [1, 2, 5, 6]),
    ([0, 1, 4, 5], [2, 3, 6, 7]),
    ([0, 1, 2, 3], [4, 5, 6, 7]),
)
_FLAT_SIZES = {vtk.VTK_TRIANGLE: 3, vtk.VTK_QUAD: 4}


def inverted(mesh, before, after, jacobian, ghosts=None):
    """Which cells are inside out, (m,) bool, and the number of cells that cannot be checked.

    A solid cell is inside out if the edges at a corner, or the axes of a hexahedron, span a volume
    of another sign than before, or none: VTK's scaled Jacobian is not above 0 there. A polygon is
    inside out if its vector area points against the normal that the map carries, J_G^T n (Eq. 29);
    a quad also if the edges at a corner span such an area; a triangle strip if one of its triangles
    is inside out. Vertices, lines, cells without a volume or area before (to rounding), curved
    cells with a positive volume, and cells with a point that is not finite cannot be checked. Cells
    of a vtkStructuredGrid with a blanked point do not count.

    `before` and `after` (n, 3) are the points of the deformed vtkDataSet, world coordinates, and
    `jacobian` (n, 3, 3) is dG_i/dv_j there. `ghosts` are flags of cells as of vtkGhostType: cells
    of other processes and hidden ones do not count.
    """
    margins = _Margins(before, after, jacobian)
    result = np.full(mesh.GetNumberOfCells(), np.nan)
    for cell_type, rows, points in _groups(mesh):
        result[rows] = margins.of_cells(cell_type, points)
    if isinstance(mesh, vtk.vtkUnstructuredGrid):
        for rows, faces in _polyhedra(mesh):
            result[rows] = margins.of_polyhedra(faces)
    counts = ~_has_blank_points(mesh)
    if ghosts is not None:
        flags = vtk.vtkDataSetAttributes.DUPLICATECELL | vtk.vtkDataSetAttributes.HIDDENCELL
        counts &= (ghosts & flags) == 0
    return counts & (result <= 0), np.count_nonzero(np.isnan(result[counts]))


class _Margins:
    """Margins of cells: above 0 if a cell kept its orientation, NaN if it cannot be checked.

    A margin is computed from measures: tuples of the signed sizes before and after, and the
    rounding error of the size before.
    """

    def __init__(self, before, after, jacobian):
        self._rows, self._jacobian = (before, after), jacobian
        self._columns = [np.ascontiguousarray(x.T, np.float64) for x in self._rows]
        self._rounding = _rounding(*self._columns, np.finfo(after.dtype).eps)

    def of_cells(self, cell_type, points):
        """Margins of cells of one type with the points (n, k)."""
        if cell_type in _CORNER_EDGES:
            measures, positions = self._volumes(points, _CORNER_EDGES[cell_type])
            if cell_type == vtk.VTK_HEXAHEDRON:
                measures.append(self._axes_volume(points, positions))
            return _least(measures)
        if cell_type in TETRAHEDRA:  # curved: only a negative total volume is certain
            measures, _ = self._volumes(points, TETRAHEDRA[cell_type])
            margin = _least([tuple(np.sum(column, axis=0) for column in zip(*measures))])
            return np.where(margin <= 0, margin, np.nan)
        if cell_type == vtk.VTK_TRIANGLE_STRIP:
            triangles = points[:, np.arange(points.shape[1] - 2)[:, None] + np.arange(3)]
            margins, finite = _margins(*self._areas(triangles.reshape(-1, 3)))
            shape = triangles.shape[:2]
            return _least_of(margins.reshape(shape).T, finite.reshape(shape).T)
        return _least(self._areas(points, at_corners=cell_type == vtk.VTK_QUAD))

    def of_polyhedra(self, faces):
        """Margins of the polyhedra of a `_Faces`."""
        owner, edges = faces.edges_of_simple_corners()
        measures = [(owner, self._volumes(edges, _TETRAHEDRON)[0][0])]
        owner, corners = faces.other_corners()
        if len(owner) > 0:
            measures.append((owner, self._middle_volume(faces, owner, corners)))
        least = np.full(faces.count, np.inf)
        is_finite = np.ones(faces.count, bool)
        for owner, measure in measures:
            margin, finite = _margins(measure)
            has_margin = ~np.isnan(margin)
            np.minimum.at(least, owner[has_margin], margin[has_margin])
            is_finite[owner[~finite]] = False
        return np.where(is_finite & np.isfinite(least), least, np.nan)

    def _volumes(self, points, edges):
        """Volumes spanned by the edges from one point of cells to three others.

        For `points` (n, k) of cells and `edges` (corner, end, end, end): a measure for each edge;
        and the positions (3, k, n) of the points before and after.
        """
        points = np.ascontiguousarray(points.T)
        positions = [np.take(x, points, axis=1) for x in self._columns]
        rounding = np.take(self._rounding, points).max(axis=0)
        measures = []
        for corner, *ends in edges:
            before, after = ([x[:, end] - x[:, corner] for end in ends] for x in positions)
            error = rounding * _error_factor(*before)
            measures.append((_triple(*before), _triple(*after), error))
        return measures, positions

    def _axes_volume(self, points, positions):
        """Volume spanned by the axes of hexahedra, positions (3, 8, n), through their middles."""
        before, after = (
            [x[:, high].sum(axis=1) - x[:, low].sum(axis=1) for low, high in _AXIS_ENDS]
            for x in positions
        )
        rounding = 4 * np.take(self._rounding, points.T).max(axis=0)
        return _triple(*before), _triple(*after), rounding * _error_factor(*before)

    def _middle_volume(self, faces, owner, corners):
        """Volume spanned by two edges of faces (m, 3) and the line to the middle of their cell."""
        before, after = (
            [x[:, first] - x[:, corner], x[:, last] - x[:, corner]]
            + [faces.middles(x)[:, owner] - x[:, corner]]
            for x in self._columns
            for first, corner, last in [corners.T]
        )
        rounding = self._rounding[corners].max(axis=1)
        return _triple(*before), _triple(*after), rounding * _error_factor(*before)

    def _areas(self, points, at_corners=False):
        """Areas of polygons along the normals that the map carries: J_G^T n (Eq. 29).

        A list of measures: the vector areas, and if `at_corners` those of the edges at each corner.
        """
        before, after = (x[points].astype(np.float64) for x in self._rows)
        normal = _vector_area(before)
        length = np.linalg.norm(normal, axis=1)
        mapped_normal = np.einsum("nij,ni->nj", self._jacobian[points].mean(axis=1), normal)
        perimeter = np.linalg.norm(np.roll(before, -1, axis=1) - before, axis=2).sum(axis=1)
        error = self._rounding[points].max(axis=1) * perimeter
        measures = [(length, np.einsum("nj,nj->n", _vector_area(after), mapped_normal), error)]
        if at_corners:
            sizes = np.einsum("nkj,nj->kn", _corner_normals(before), normal) / length
            areas = np.einsum("nkj,nj->kn", _corner_normals(after), mapped_normal)
            measures += [(size, area, error) for size, area in zip(sizes, areas)]
        return measures


def _least(measures):
    """The least margin of each cell by some measures."""
    return _least_of(*zip(*map(_margins, measures)))


def _least_of(margins, finite):
    """The least of margins (k, n); NaN for cells whose points are not all `finite` (k, n)."""
    return np.where(np.all(finite, axis=0), np.fmin.reduce(margins), np.nan)


def _margins(measure):
    """Margins, NaN without a size before; and whether the points of the cells are finite."""
    before, after, error = measure
    margin = np.where(np.abs(before) > error, after * np.sign(before), np.nan)
    return margin, np.isfinite(after)


def _rounding(before, after, eps):
    """Rounding error of each of the points (3, n), stored with the precision `eps`: (n,)."""
    finite = np.isfinite(before).all(axis=0)
    middle = np.median(before[:, finite], axis=1) if finite.any() else np.zeros(3)
    distance, largest = np.zeros((2, len(finite)))
    for x in (*zip(before, middle), *zip(after, middle)):
        np.maximum(distance, np.abs(x[0] - x[1]), out=distance)
        np.maximum(largest, np.abs(x[0]), out=largest)
    usual = np.median(distance[finite]) if finite.any() else 0.0
    return _ROUNDINGS * (np.finfo(np.float32).eps * (distance + usual) + largest * eps)


def _triple(a, b, c):
    """Triple products of (3, n) vectors."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def _error_factor(*edges):
    """Largest change of the triple product of (3, n) vectors when one end moves by 1."""
    a, b, c = (np.sqrt(np.einsum("in,in->n", edge, edge)) for edge in edges)
    return a * b + b * c + c * a


def _vector_area(x):
    """Twice the vector areas of polygons (n, k, 3)."""
    edges = x[:, 1:] - x[:, :1]
    return np.cross(edges[:, :-1], edges[:, 1:]).sum(axis=1)


def _corner_normals(x):
    """Cross products of the edges at the corners of polygons (n, k, 3)."""
    return np.cross(np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x)


def _has_blank_points(mesh):
    """Which cells of a vtkStructuredGrid have a point that is hidden: (n,) bool."""
    if not (isinstance(mesh, vtk.vtkStructuredGrid) and mesh.HasAnyBlankPoints()):
        return np.zeros(mesh.GetNumberOfCells(), bool)
    flags = arrays.to_numpy(mesh.GetPointData().GetArray(arrays.GHOSTS))
    hidden = (flags & vtk.vtkDataSetAttributes.HIDDENPOINT) != 0
    extent = mesh.GetExtent()
    shape = (np.subtract(extent[1::2], extent[::2]) + 1)[::-1]
    return over_corners(np.logical_or, hidden.reshape(shape)).ravel()


def _groups(mesh):
    """Type, indices (n,) and points (n, k) of cells of one type and size, in chunks.

    Voxels and pixels are hexahedra and quads.
    """
    if isinstance(mesh, vtk.vtkUnstructuredGrid):
        if mesh.GetNumberOfCells():
            yield from _by_size(arrays.cell_types(mesh), *connectivity_of(mesh.GetCells()))
    elif isinstance(mesh, vtk.vtkPolyData):
        first = 0
        for cell_type, cells in polydata_cells(mesh):
            connectivity, offsets = connectivity_of(cells)
            is_quad = (cell_type == vtk.VTK_POLYGON) & (np.diff(offsets) == 4)  # as VTK says
            types = np.where(is_quad, vtk.VTK_QUAD, cell_type)
            yield from _by_size(types, connectivity, offsets, first)
            first += len(types)
    elif isinstance(mesh, vtk.vtkExplicitStructuredGrid):
        connectivity, offsets = connectivity_of(mesh.GetCells())
        types = np.full(len(offsets) - 1, vtk.VTK_HEXAHEDRON)
        yield from _by_size(types, connectivity, offsets)
    elif isinstance(mesh, vtk.vtkStructuredGrid):
        yield from _structured(mesh.GetExtent(), np.arange(mesh.GetNumberOfCells()))


def _by_size(types, connectivity, offsets, first=0):
    """`_groups` of cells; `first` is the index of the first."""
    sizes = np.diff(offsets)
    for cell_type in np.unique(types).tolist():
        for size in np.unique(sizes[types == cell_type]).tolist():
            free_type, order = BOXES.get(cell_type, (cell_type, slice(None)))
            if _is_complete(free_type, size):
                for rows in _chunks(np.flatnonzero((types == cell_type) & (sizes == size)), size):
                    points = connectivity[offsets[rows][:, None] + np.arange(size)]
                    yield free_type, first + rows, points[:, order]


def _structured(extent, cells):
    """`_groups` of the quads or hexahedra of a vtkStructuredGrid."""
    dimensions = np.subtract(extent[1::2], extent[::2]) + 1
    axes = np.flatnonzero(dimensions > 1)
    cell_type = {2: vtk.VTK_QUAD, 3: vtk.VTK_HEXAHEDRON}.get(len(axes))
    if cell_type is None:
        return
    steps = np.cumprod([1, *dimensions[:2]])[axes]
    square = np.array([0, steps[0], steps[0] + steps[1], steps[1]])
    offsets = np.concatenate([square + up for up in (0, *steps[2:])])
    for rows in _chunks(cells, len(offsets)):
        index = np.unravel_index(rows, np.maximum(dimensions - 1, 1), order="F")
        first = np.ravel_multi_index(index, dimensions, order="F")
        yield cell_type, rows, first[:, None] + offsets


def _chunks(rows, size):
    """Parts of the indices of cells with `size` points."""
    step = max(8 * _CHUNK // size, 1)
    return (rows[start : start + step] for start in range(0, len(rows), step))


def _is_complete(cell_type, size):
    """Whether a cell with `size` points has all points that its type needs."""
    if cell_type in (vtk.VTK_POLYGON, vtk.VTK_TRIANGLE_STRIP):
        return size > 2
    if cell_type in _FLAT_SIZES:
        return size == _FLAT_SIZES[cell_type]
    tables = _CORNER_EDGES.get(cell_type) or TETRAHEDRA.get(cell_type)
    return tables is not None and size > max(map(max, tables))


class _Faces:
    """The corners of the faces of `count` polyhedra, each with the corners before and after it.

    Face i belongs to the polyhedron owner[i] and has size[i] points of `connectivity` from
    first[i] on.
    """

    def __init__(self, count, owner, first, size, connectivity):
        self.count, self._owner = count, np.repeat(owner, size)
        start = np.repeat(np.cumsum(size) - size, size)
        first, size = np.repeat(first, size), np.repeat(size, size)
        position = np.arange(len(size)) - start
        self._corner = connectivity[first + position]
        self._before = connectivity[first + (position - 1) % size]
        self._after = connectivity[first + (position + 1) % size]

    def edges_of_simple_corners(self):
        """Cell (m,), and corner and ends of edges (m, 4), of corners with three edges."""
        rows, first, counts = self._distinct_edges
        first = first[counts == 3]
        ends = rows[2][first[:, None] + np.arange(3)]
        return rows[0][first], np.column_stack([rows[1][first], ends])

    def other_corners(self):
        """Cell (m,), and corner of a face between its neighbors (m, 3), of the other corners."""
        rows, first, counts = self._distinct_edges
        others = first[counts != 3]
        span = self._corner.max(initial=0) + 1
        keys = rows[0][others] * span + rows[1][others]
        is_other = np.isin(self._owner * span + self._corner, keys)
        corners = np.column_stack([self._before, self._corner, self._after])
        return self._owner[is_other], corners[is_other]

    def middles(self, x):
        """Means (3, count) of the corners of the faces of each cell, for positions x (3, n)."""
        weights = np.maximum(np.bincount(self._owner, minlength=self.count), 1)
        sums = [np.bincount(self._owner, axis[self._corner], self.count) for axis in x]
        return np.stack(sums) / weights

    @functools.cached_property
    def _distinct_edges(self):
        """Cell, corner and end of each edge (3, m), sorted; first edge and count at each corner."""
        ends = np.concatenate([self._before, self._after])
        rows = np.stack([np.tile(self._owner, 2), np.tile(self._corner, 2), ends])
        rows = rows[:, np.lexsort(rows[::-1])]
        is_new = np.append(True, (np.diff(rows) != 0).any(axis=0))[: rows.shape[1]]
        rows = rows[:, is_new]
        is_first = np.append(True, (np.diff(rows[:2]) != 0).any(axis=0))[: rows.shape[1]]
        first = np.flatnonzero(is_first)
        return rows, first, np.diff(np.append(first, rows.shape[1]))


def _polyhedra(grid):
    """Indices (n,) of polyhedra and their `_Faces`, in chunks."""
    faces, locations = (get(grid) for get in FACES)
    if grid.GetNumberOfCells() == 0 or faces is None or locations is None:
        return
    polyhedra = np.flatnonzero(arrays.cell_types(grid) == vtk.VTK_POLYHEDRON)
    find = _find_faces if isinstance(locations, vtk.vtkCellArray) else _find_faces_in_stream
    for start in range(0, len(polyhedra), _CHUNK):
        rows = polyhedra[start : start + _CHUNK]
        yield rows, _Faces(len(rows), *find(faces, locations, rows))


def _find_faces(faces, locations, rows):
    """Owner, first point and size (m,) of the faces of cells, and the connectivity."""
    indices, offsets = connectivity_of(locations)
    connectivity, face_offsets = connectivity_of(faces)
    counts = offsets[rows + 1] - offsets[rows]
    position = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    face = indices[np.repeat(offsets[rows], counts) + position]
    owner = np.repeat(np.arange(len(rows)), counts)
    return owner, face_offsets[face], face_offsets[face + 1] - face_offsets[face], connectivity


def _find_faces_in_stream(faces, locations, rows):
    """As `_find_faces` before VTK 9.4: number of faces, then size and points of each face."""
    stream, position = arrays.to_numpy(faces), arrays.to_numpy(locations)[rows].copy()
    counts = stream[position]
    found = [np.zeros((3, 0), np.int64)]
    position += 1
    for index in range(counts.max(initial=0)):
        owner = np.flatnonzero(counts > index)
        size = stream[position[owner]]
        found.append(np.stack([owner, position[owner] + 1, size]))
        position[owner] += size + 1
    found = np.concatenate(found, axis=1)
    owner, first, size = found[:, np.argsort(found[0], kind="stable")]
    return owner, first, size, stream
