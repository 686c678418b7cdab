"""Which cells of a mesh a deformation has turned inside out."""

from __future__ import annotations

import numpy as np
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
    vtkExplicitStructuredGrid,
    vtkPolyData,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)

from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import FACES, corners, polydata_cells

_CHUNK = 1 << 14  # hexahedra, or cells with as many points, that are looked at together
# What float32 blurs, in units of its rounding of the distance from the middle of the mesh: lengths
# below it have no direction.
_BLUR = 8

_TETRAHEDRON = [(0, 1, 2, 3)]
_HEXAHEDRON = [(0, 1, 3, 4), (1, 2, 3, 6), (1, 6, 4, 5), (3, 4, 6, 7), (1, 3, 4, 6)]
_VOXEL_ORDER = (0, 1, 3, 2, 4, 5, 7, 6)
_VOXEL = [tuple(_VOXEL_ORDER[corner] for corner in four) for four in _HEXAHEDRON]
_WEDGE = [(0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)]
_PYRAMID = [(0, 1, 2, 4), (0, 2, 3, 4)]

# Tetrahedra whose signed volumes add up to that of a cell, by VTK's numbers of cell types. The
# corners of quadratic, Lagrange and Bezier cells come first.
TETRAHEDRA = {
    **dict.fromkeys((10, 24, 71, 78), _TETRAHEDRON),
    **dict.fromkeys((12, 25, 29, 33, 72, 79), _HEXAHEDRON),
    11: _VOXEL,
    **dict.fromkeys((13, 26, 31, 32, 73, 80), _WEDGE),
    **dict.fromkeys((14, 27, 37, 74, 81), _PYRAMID),
}


def _prism(sides):
    """For each corner of a prism, itself and the ends of its three edges."""
    ring = range(sides)
    lower = [(i, (i + 1) % sides, (i - 1) % sides, i + sides) for i in ring]
    upper = [(i + sides, (i - 1) % sides + sides, (i + 1) % sides + sides, i) for i in ring]
    return lower + upper


# Corners at which three edges span a parallelepiped of the sign of the Jacobian there.
_SPANS = {
    VTK_TETRA: _TETRAHEDRON,
    VTK_HEXAHEDRON: _prism(4),
    VTK_VOXEL: [tuple(_VOXEL_ORDER[corner] for corner in four) for four in _prism(4)],
    VTK_WEDGE: _prism(3),
    VTK_PYRAMID: [(i, (i + 1) % 4, (i - 1) % 4, 4) for i in range(4)],
    VTK_PENTAGONAL_PRISM: _prism(5),
    VTK_HEXAGONAL_PRISM: _prism(6),
}
# Corners at both ends of the axes of a hexahedron.
_OPPOSITE = (
    ([0, 3, 4, 7], [1, 2, 5, 6]),
    ([0, 1, 4, 5], [2, 3, 6, 7]),
    ([0, 1, 2, 3], [4, 5, 6, 7]),
)
# Corners of flat cells in their order along the edge.
_AREAS = {
    VTK_TRIANGLE: (0, 1, 2),
    VTK_QUAD: (0, 1, 2, 3),
    VTK_PIXEL: (0, 1, 3, 2),
}


def count_inverted(mesh, before, after, jacobian, ghosts=None):
    """Number of cells that are inside out, and of those of which that is not known.

    Cells of three dimensions are inside out where the edges at a corner, or those through the
    middle of a hexahedron, span a volume of another sign than before, or none; so VTK's scaled
    Jacobian is not above 0 there. Polygons are where their vector area points against the
    normal that goes with the material: J_G^T n (Eq. 29); triangle strips where one of their
    triangles does. A cell that had no volume or area before, to rounding, is not known, nor are
    vertices, lines, curved cells whose corners have kept their order, and cells with a point that
    is not finite.

    Parameters
    ----------
    mesh : vtkDataSet
        Its cells count.
    before, after : (n, 3) arrays, world coordinates
        Its points.
    jacobian : (n, 3, 3) array
        dG_i/dv_j at them.
    ghosts : (n,) array, optional
        Flags of cells as of vtkGhostType; cells of other processes and hidden ones do not count.

    Returns
    -------
    inverted, unchecked : int
    """
    judge = _Judge(before, after, jacobian)
    state = np.full(mesh.GetNumberOfCells(), np.nan)
    for kind, rows, points in _groups(mesh):
        step = max(8 * _CHUNK // points.size, 1)
        for start in range(0, len(rows), step):
            part = slice(start, min(start + step, len(rows)))
            state[rows[part]] = judge.margin(kind, points[part])
    if isinstance(mesh, vtkUnstructuredGrid):
        for rows, sides in _polyhedra(mesh):
            state[rows] = judge.margin_of_polyhedra(sides)
    if ghosts is not None:
        flags = vtkDataSetAttributes.DUPLICATECELL | vtkDataSetAttributes.HIDDENCELL
        state = state[(ghosts & flags) == 0]
    return np.count_nonzero(state <= 0), np.count_nonzero(np.isnan(state))


class _Judge:
    """Compares points before and after, and says of cells whether they are inside out.

    A margin is above 0 for cells that are not, not above 0 for those that are, NaN if unknown.
    What it is made of are measures: sizes before and after, and how far those before are blurred.
    """

    def __init__(self, before, after, jacobian):
        self._before, self._after, self._jacobian = before, after, jacobian
        self._blur = _blur(before, after)

    def margin(self, kind, points):
        """Of cells of a type whose points are (n, k)."""
        if kind in _SPANS:
            return self._of_spans(kind, points)
        if kind in TETRAHEDRA:  # curved, of which nobody knows where they bend
            spanned = self._spanned(points, TETRAHEDRA[kind])
            margin = _least([tuple(np.sum(column, axis=0) for column in zip(*spanned))])
            return np.where(margin <= 0, margin, np.nan)
        if kind == VTK_TRIANGLE_STRIP:
            three = points[:, np.arange(points.shape[1] - 2)[:, None] + np.arange(3)]
            margins, finite = _margins(self._areas(three.reshape(-1, 3)))
            return _least_of(margins.reshape(three.shape[:2]).T, finite.reshape(three.shape[:2]).T)
        order = _AREAS.get(kind, range(points.shape[1]))
        return _least([self._areas(points[:, order])])

    def margin_of_polyhedra(self, sides):
        """Of the polyhedra that `_Sides` describe."""
        owner, four = sides.edges()
        measures = [(owner, *self._spanned(four, _TETRAHEDRON))]
        owner, three = sides.fans()
        if len(owner) > 0:
            measures.append((owner, self._towards_middle(sides, owner, three)))
        least = np.full(sides.count, np.inf)
        is_finite = np.ones(sides.count, bool)
        for owner, measure in measures:
            margin, finite = _margins(measure)
            known = ~np.isnan(margin)
            np.minimum.at(least, owner[known], margin[known])
            is_finite[owner[~finite]] = False
        return np.where(is_finite & np.isfinite(least), least, np.nan)

    def _of_spans(self, kind, points):
        measures = self._spanned(points, _SPANS[kind])
        if kind == VTK_VOXEL:
            points = points[:, _VOXEL_ORDER]
        if kind in (VTK_HEXAHEDRON, VTK_VOXEL):
            measures.append(self._at_middle(points))
        return _least(measures)

    def _spanned(self, points, spans):
        """Measures of what the edges from a corner to three others span, for each of `spans`."""
        before, after = _columns(self._before, points), _columns(self._after, points)
        blur = self._blur[points].max(axis=1)
        measures = []
        for corner, *ends in spans:
            rest, moved = ([x[end] - x[corner] for end in ends] for x in (before, after))
            measures.append((_triple(*rest), _triple(*moved), blur * _change(*rest)))
        return measures

    def _at_middle(self, points):
        """Measure of what the axes through the middle of hexahedra span."""
        rest, moved = (
            [x[high].sum(axis=0) - x[low].sum(axis=0) for low, high in _OPPOSITE]
            for x in (_columns(self._before, points), _columns(self._after, points))
        )
        blur = 4 * self._blur[points].max(axis=1)
        return _triple(*rest), _triple(*moved), blur * _change(*rest)

    def _towards_middle(self, sides, owner, three):
        """Measure of what edges of faces at a corner (m, 3) span with the middle of their cell."""
        rest, moved = (
            [first - corner, then - corner, sides.middles(x)[owner].T - corner]
            for x in (self._before, self._after)
            for first, corner, then in [_columns(x, three)]
        )
        blur = self._blur[three].max(axis=1)
        return _triple(*rest), _triple(*moved), blur * _change(*rest)

    def _areas(self, points):
        """Measure of the vector areas of polygons, along the normals that go with the material."""
        x = self._before[points].astype(np.float64)
        normal = _vector_area(x)
        around = np.linalg.norm(np.roll(x, -1, axis=1) - x, axis=2).sum(axis=1)
        carried = np.einsum("nij,ni->nj", self._jacobian[points].mean(axis=1), normal)
        area = _vector_area(self._after[points].astype(np.float64))
        blur = self._blur[points].max(axis=1) * around
        return np.linalg.norm(normal, axis=1), np.einsum("nj,nj->n", area, carried), blur


def _least(measures):
    """The least of the margins that each cell has by some measures."""
    return _least_of(*zip(*map(_margins, measures)))


def _least_of(margins, finite):
    """The same of margins (k, n), and whether they are of finite points (k, n)."""
    return np.where(np.all(finite, axis=0), np.fmin.reduce(margins), np.nan)


def _margins(measure):
    """Margins, NaN where there was no size before; and whether the cell's points are finite."""
    before, after, blur = measure
    margin = np.where(np.abs(before) > blur, after * np.sign(before), np.nan)
    return margin, np.isfinite(after)


def _columns(x, points):
    """Coordinates (k, 3, n) float64 of points (n, k)."""
    return np.ascontiguousarray(x[points].transpose(1, 2, 0), np.float64)


def _blur(before, after):
    """How far each of the points (n, 3) may be off by rounding: (n,)."""
    x = np.stack([before, after]).astype(np.float64)
    finite = np.isfinite(x[0]).all(axis=1)
    middle = np.median(x[0][finite], axis=0) if finite.any() else np.zeros(3)
    distance = np.abs(x - middle).max(axis=(0, 2))
    usual = np.median(distance[finite]) if finite.any() else 0.0
    stored = np.abs(x).max(axis=(0, 2)) * np.finfo(after.dtype).eps
    return _BLUR * (np.finfo(np.float32).eps * (distance + usual) + stored)


def _triple(a, b, c):
    """Triple products of (3, n) vectors."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def _change(*edges):
    """What the triple product of (3, n) vectors changes by at most when an end moves by 1."""
    a, b, c = (np.sqrt(np.einsum("in,in->n", edge, edge)) for edge in edges)
    return a * b + b * c + c * a


def _vector_area(x):
    """Twice the vector areas of polygons (n, k, 3)."""
    edges = x[:, 1:] - x[:, :1]
    return np.cross(edges[:, :-1], edges[:, 1:]).sum(axis=1)


def _groups(mesh):
    """Type, numbers (n,) and points (n, k) of cells with the same type and number of points."""
    if isinstance(mesh, vtkUnstructuredGrid):
        if mesh.GetNumberOfCells():
            yield from _by_size(arrays.cell_types(mesh), *corners(mesh.GetCells()), 0)
    elif isinstance(mesh, vtkPolyData):
        first = 0
        for kind, cells in polydata_cells(mesh):
            connectivity, offsets = corners(cells)
            kinds = np.full(len(offsets) - 1, kind)
            yield from _by_size(kinds, connectivity, offsets, first)
            first += len(kinds)
    elif isinstance(mesh, vtkExplicitStructuredGrid):
        connectivity, offsets = corners(mesh.GetCells())
        yield from _by_size(np.full(len(offsets) - 1, VTK_HEXAHEDRON), connectivity, offsets, 0)
    elif isinstance(mesh, vtkStructuredGrid):
        lattice = _Lattice(mesh.GetExtent())
        if lattice.kind:
            yield lattice.kind, np.arange(mesh.GetNumberOfCells()), lattice


def _by_size(types, connectivity, offsets, first):
    sizes = np.diff(offsets)
    for kind in np.unique(types).tolist():
        for size in np.unique(sizes[types == kind]).tolist():
            rows = np.flatnonzero((types == kind) & (sizes == size))
            if _is_whole(kind, size):
                yield kind, first + rows, _Rows(connectivity, offsets[rows], size)


def _is_whole(kind, size):
    """Whether a cell of this size has the points of its type."""
    if kind in (VTK_POLYGON, VTK_TRIANGLE_STRIP):
        return size > 2
    if kind in _AREAS:
        return size == len(_AREAS[kind])
    tables = _SPANS.get(kind) or TETRAHEDRA.get(kind)
    return tables is not None and size > max(map(max, tables))


class _Rows:
    """Points (n, k) of cells, of which a slice is made when it is asked for."""

    def __init__(self, connectivity, first, size):
        self._connectivity, self._first, self.size = connectivity, first, size

    def __getitem__(self, part):
        return self._connectivity[self._first[part][:, None] + np.arange(self.size)]


class _Lattice:
    """Points (n, k) of the cells of a vtkStructuredGrid, made when a slice of it is asked for."""

    def __init__(self, extent):
        self._dimensions = np.subtract(extent[1::2], extent[::2]) + 1
        axes = np.flatnonzero(self._dimensions > 1)
        steps = np.cumprod([1, *self._dimensions[:2]])[axes]
        self._cells = np.maximum(self._dimensions - 1, 1)
        self.kind = {2: VTK_QUAD, 3: VTK_HEXAHEDRON}.get(len(axes))
        if self.kind:
            square = np.array([0, steps[0], steps[0] + steps[1], steps[1]])
            self._corners = np.concatenate([square + up for up in (0, *steps[2:])])
            self.size = len(self._corners)

    def __getitem__(self, part):
        cells = np.arange(part.start, part.stop)
        i, j, k = np.unravel_index(cells, self._cells, order="F")
        first = i + self._dimensions[0] * (j + self._dimensions[1] * k)
        return first[:, None] + self._corners


class _Sides:
    """The corners of the faces of some polyhedra, each with the one before and the one after."""

    def __init__(self, count, owner, first, size, connectivity):
        self.count, self._owner = count, np.repeat(owner, size)
        start = np.repeat(np.cumsum(size) - size, size)
        first, size = np.repeat(first, size), np.repeat(size, size)
        place = np.arange(len(size)) - start
        self._corner = connectivity[first + place]
        self._before = connectivity[first + (place - 1) % size]
        self._after = connectivity[first + (place + 1) % size]

    def edges(self):
        """Cell (m,), and corner and ends of edges (m, 4), of corners with just three edges."""
        rows, counts = self._distinct_edges()
        first = np.cumsum(counts) - counts
        first = first[counts == 3]
        ends = rows[2][first[:, None] + np.arange(3)]
        return rows[0][first], np.column_stack([rows[1][first], ends])

    def fans(self):
        """Cell (m,), and corner of a face with its neighbors (m, 3), of the other corners."""
        rows, counts = self._distinct_edges()
        first = np.cumsum(counts) - counts
        others = first[counts != 3]
        span = self._corner.max(initial=0) + 1
        is_other = np.isin(
            self._owner * span + self._corner, rows[0][others] * span + rows[1][others]
        )
        three = np.column_stack([self._before, self._corner, self._after])
        return self._owner[is_other], three[is_other]

    def middles(self, x):
        """Means of the corners of faces, of each cell (count, 3)."""
        weights = np.maximum(np.bincount(self._owner, minlength=self.count), 1)
        sums = [
            np.bincount(self._owner, x[self._corner, axis].astype(np.float64), self.count)
            for axis in range(3)
        ]
        return np.stack(sums, axis=1) / weights[:, None]

    def _distinct_edges(self):
        """Cell, corner and end of each edge (3, m), sorted, and how many are at each corner."""
        rows = np.stack(
            [
                np.tile(self._owner, 2),
                np.tile(self._corner, 2),
                np.concatenate([self._before, self._after]),
            ]
        )
        rows = rows[:, np.lexsort(rows[::-1])]
        is_new = np.append(True, (np.diff(rows) != 0).any(axis=0))[: rows.shape[1]]
        rows = rows[:, is_new]
        starts = np.append(True, (np.diff(rows[:2]) != 0).any(axis=0))[: rows.shape[1]]
        return rows, np.diff(np.append(np.flatnonzero(starts), rows.shape[1]))


def _polyhedra(grid):
    """Numbers (n,) of some polyhedra, and their `_Sides`, one lot after the other."""
    if grid.GetNumberOfCells() == 0:
        return
    polyhedra = np.flatnonzero(arrays.cell_types(grid) == VTK_POLYHEDRON)
    faces, locations = (get(grid) for get in FACES)
    if faces is None or locations is None:
        return
    find = _sides if isinstance(locations, vtkCellArray) else _sides_of_stream
    for start in range(0, len(polyhedra), _CHUNK):
        rows = polyhedra[start : start + _CHUNK]
        yield rows, _Sides(len(rows), *find(faces, locations, rows))


def _sides(faces, locations, rows):
    """The faces of cells: cell, where the corners begin and their number, (m,) each; corners."""
    numbers, offsets = corners(locations)
    connectivity, starts = corners(faces)
    counts = offsets[rows + 1] - offsets[rows]
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    face = numbers[np.repeat(offsets[rows], counts) + place]
    owner = np.repeat(np.arange(len(rows)), counts)
    return owner, starts[face], starts[face + 1] - starts[face], connectivity


def _sides_of_stream(faces, locations, rows):
    """The same as VTK before 9.4 keeps them: number of faces, then number and corners of each."""
    stream, place = arrays.to_numpy(faces), arrays.to_numpy(locations)[rows].copy()
    counts, found = stream[place], []
    place += 1
    for number in range(counts.max(initial=0)):
        owner = np.flatnonzero(counts > number)
        size = stream[place[owner]]
        found.append((owner, place[owner] + 1, size))
        place[owner] += size + 1
    owner, first, size = (np.concatenate(column) for column in zip(*found))
    order = np.argsort(owner, kind="stable")
    return owner[order], first[order], size[order], stream
