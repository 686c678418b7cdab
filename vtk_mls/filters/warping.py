"""Deformation of point sets by the inverse of the map that deforms images."""

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkIdList, vtkObject, vtkPoints, vtkWeakReference
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkDataSetAttributes,
    vtkExplicitStructuredGrid,
    vtkPointSet,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import vtkCellCenters
from vtkmodules.vtkFiltersGeneral import vtkRectilinearGridToPointSet

from vtk_mls.filters import derived_arrays
from vtk_mls.filters.algorithm import run_all
from vtk_mls.queries.fields import rounding_sizes
from vtk_mls.queries.vector_fields import contravariant, covariant
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import (
    FACES,
    convert_integer_points,
    is_empty,
    make_boxes_free,
    positions_of,
    scaled_jacobians,
    set_positions,
    without_empty,
)
from vtk_mls.vtk.objects import output_of, shallow_copy
from vtk_mls.vtk.orientation import inverted
from vtk_mls.vtk.splitting import crossed, split

# Distance from a cut at which the map is evaluated for points on it, as a share of the extent of
# the control points or of the distance from them: more than the device's float32 blurs.
_OFF_CUT = 1e-5
# Points whose Jacobians are in memory at once.
_CHUNK = 1 << 20

# Inverted cells that decide on the number of steps.
_MAX_CELLS = 1 << 12
_BLEND_STEPS = 100  # of a blend of 1

_MOVED_WHOLE = ("vtkPolyData", "vtkUnstructuredGrid")

# Getters of the objects that hold the geometry of a mesh.
_PARTS = {
    vtkPointSet: (vtkPointSet.GetPoints,),
    vtkRectilinearGrid: (
        vtkRectilinearGrid.GetXCoordinates,
        vtkRectilinearGrid.GetYCoordinates,
        vtkRectilinearGrid.GetZCoordinates,
    ),
    vtkPolyData: (
        vtkPolyData.GetVerts,
        vtkPolyData.GetLines,
        vtkPolyData.GetPolys,
        vtkPolyData.GetStrips,
    ),
    vtkUnstructuredGrid: (vtkUnstructuredGrid.GetCells, arrays.cell_type_array, *FACES),
    vtkExplicitStructuredGrid: (vtkExplicitStructuredGrid.GetCells,),
    vtkPoints: (vtkPoints.GetData,),
    vtkCellArray: (vtkCellArray.GetConnectivityArray, vtkCellArray.GetOffsetsArray),
}


def output_type(mesh, splits):
    """Name of the class of a deformed mesh.

    Only vtkPolyData and vtkUnstructuredGrid can hold divided cells; a deformed vtkRectilinearGrid
    has curved lines, and is a vtkStructuredGrid.
    """
    for name in _MOVED_WHOLE:
        if mesh.IsA(name):
            return name
    if splits and mesh.GetNumberOfCells() > 0:
        return "vtkUnstructuredGrid"
    return "vtkStructuredGrid" if isinstance(mesh, vtkRectilinearGrid) else mesh.GetClassName()


class MeshCache:
    """Cached values for meshes, valid while the mesh (without field data) and a key are unchanged.

    Control points are dragged far more often than cuts are moved.
    """

    def __init__(self):
        self._cache = {}

    def of(self, mesh, key, make):
        """The value of `make()` for a mesh and a key."""
        self._cache = {k: entry for k, entry in self._cache.items() if entry[0].Get() is not None}
        state = stamps(mesh), key
        entry = self._cache.get(mesh.__this__)
        if entry is None or entry[1] != state:
            reference = vtkWeakReference()
            reference.Set(mesh)
            entry = self._cache[mesh.__this__] = reference, state, make()
        return entry[2]


@dataclass(frozen=True)
class MeshOptions:
    """How the arrays of a mesh are transformed, and which are added."""

    directions: derived_arrays.DirectionArrays
    has_jacobian: bool = False  # adds "Jacobian"
    has_determinant: bool = False  # "JacobianDeterminant" and the number of inverted cells
    has_quality: bool = False  # "CellQuality" and "CellQualityBefore"
    has_largest_blend: bool = False  # "LargestBlend"


class Blends(NamedTuple):
    """Shares of a deformation."""

    blend: float  # that of the filter
    whole: object  # the Transform at this blend
    at: object = None  # a function that gives the Transform at another


class Warp:
    """The deformation of one mesh, a vtkPointSet or vtkRectilinearGrid.

    `output`, of the class that `output_type` names, is filled. `splits` is a MeshCache of divided
    meshes, or None to keep cells whole.
    """

    def __init__(self, options, deformations, mesh, output, splits):
        self.options, self.mesh, self.output = options, mesh, output
        self.deformations, self.deformation = deformations, deformations.whole
        self.splits = splits if mesh.GetNumberOfCells() > 0 else None
        self.keeps_whole = self.deformation.cuts and splits is None
        self.divides = bool(self.deformation.cuts) and self.splits is not None
        self.offset = self.inverted = None

    def tasks(self):
        """Functions of a Progress, in their order."""
        if self.divides:
            return [self._split, self._warp]
        copy(self.mesh, self.output)
        return [self._warp]

    def _split(self, progress):
        cuts = self.deformation.cuts
        make = partial(split, self.mesh, cuts, progress)
        divided, to_cut, side = self.splits.of(self.mesh, cuts, make)
        self.offset = offset_from_cuts(self.deformation, positions_of(divided), to_cut, side)
        self.output.ShallowCopy(divided)
        self.output.GetFieldData().ShallowCopy(self.mesh.GetFieldData())

    def _warp(self, progress):
        """Move the points of the output and add its arrays; the cells are there."""
        arrays.name_normals(self.output)
        convert_integer_points(self.output)
        if isinstance(self.output, vtkUnstructuredGrid):
            make_boxes_free(self.output)
        self.ghosts = self.output.GetCellData().GetArray(arrays.GHOSTS)  # without torn cells
        self.before = positions_of(self.output)
        tasks = [self._move]
        if self.options.has_jacobian or self.options.has_determinant:
            tasks.append(self._add_jacobian)
        if self.options.has_quality:
            tasks.append(self._add_quality)
        if self.options.has_largest_blend:
            tasks.append(self._add_largest_blend)
        for attributes, positions in (
            (self.output.GetPointData(), lambda: self._positions(self.deformation, self._points())),
            (self.output.GetCellData(), self._center_positions),
        ):
            directions = self.options.directions.of(attributes)
            if directions:
                tasks.append(partial(self._transform, attributes, positions, directions))
        run_all(tasks, progress)

    def _move(self, progress):
        searching, placing = progress.divided(4, 1)
        field = self.deformation.forward_field(self._off_cuts(self.before), searching)
        placing.report(0)
        points, cells = self.output.GetPointData(), self.output.GetCellData()
        if self.keeps_whole:
            torn = crossed(self.output, self.deformation.cuts)
            arrays.add(cells, "Void", torn)
            derived_arrays.hide(cells, torn)
        moved = self.before + field.displacement
        set_positions(self.output, moved, self.output.GetPoints().GetDataType())
        displacement, found = self._from_rest(field)
        arrays.add(points, "ForwardDisplacement", displacement)
        arrays.add(points, "NoInverse", ~found)
        arrays.add(self.output.GetFieldData(), "FailedInverses", np.count_nonzero(~found))

    def _from_rest(self, field):
        """Displacements of the points from the input, and whether they were found."""
        return field.displacement, field.found

    def _add_jacobian(self, progress):
        mapping, measuring = progress.divided(3, 1)
        jacobian = self._jacobian(self.deformation, self._points(), mapping)
        measuring.report(0)
        points = self.output.GetPointData()
        if self.options.has_jacobian:
            arrays.add(points, "Jacobian", jacobian.swapaxes(1, 2).reshape(-1, 9))
        if self.options.has_determinant:
            arrays.add(points, "JacobianDeterminant", np.linalg.det(jacobian))
            self.inverted, unchecked = self._inverted(self._points(), jacobian)
            arrays.add(self.output.GetFieldData(), "InvertedCells", np.count_nonzero(self.inverted))
            arrays.add(self.output.GetFieldData(), "UncheckedCells", unchecked)

    def _jacobians(self, deformation, moved, progress):
        """Slices of the points, and Jacobians where a deformation has `moved` them."""
        return jacobians(deformation, *self._positions(deformation, moved), progress)

    def _rest(self):
        """The points in the undeformed space."""
        return self.before

    def _jacobian(self, deformation, moved, progress):
        """Jacobians (n, 3, 3) float32 at the points (n, 3) of the output."""
        jacobian = np.empty((len(moved), 3, 3), np.float32)
        for part, values in self._jacobians(deformation, moved, progress):
            jacobian[part] = values
        return jacobian

    def _inverted(self, moved, jacobian):
        """Which cells are inside out, and the number of those that cannot be checked."""
        ghosts = None if self.ghosts is None else arrays.to_numpy(self.ghosts)
        return inverted(self.output, self._rest(), moved, jacobian, ghosts)

    def _add_quality(self, progress):
        cells = self.output.GetCellData()
        arrays.add(cells, "CellQualityBefore", scaled_jacobians(self.output, self._rest()))
        arrays.add(cells, "CellQuality", scaled_jacobians(self.output, self._points()))

    def _add_largest_blend(self, progress):
        blend, (checking, searching) = self.deformations.blend, progress.divided(1, 30)
        if self.inverted_cells(checking).any():
            blend = largest_blend(blend, self._inverts, searching)
        arrays.add(self.output.GetFieldData(), "LargestBlend", float(blend))

    def inverted_cells(self, progress):
        """Which cells are inside out, (m,) bool, when the points have moved."""
        if self.inverted is None:
            jacobian = self._jacobian(self.deformation, self._points(), progress)
            self.inverted, _ = self._inverted(self._points(), jacobian)
        return self.inverted

    def points_of_inverted(self):
        """Points (n, 3) of inverted cells, and centers, where the deformation takes them."""
        ids, x, found = vtkIdList(), self._off_cuts(self.before), []
        for cell in np.flatnonzero(self.inverted)[:_MAX_CELLS].tolist():
            self.output.GetCellPoints(cell, ids)
            corners = x[[ids.GetId(i) for i in range(ids.GetNumberOfIds())]]
            found += [corners, corners.mean(axis=0)[None]]
        return np.concatenate(found)

    def _inverts(self, blend, progress):
        """Whether some cell is inside out at a blend."""
        moving, mapping = progress.divided(3, 1)
        deformation = self.deformations.at(blend)
        field = deformation.forward_field(self._off_cuts(self.before), moving)
        moved = (self.before + field.displacement).astype(self._points().dtype)
        return self._inverted(moved, self._jacobian(deformation, moved, mapping))[0].any()

    def _transform(self, attributes, positions, directions, progress):
        """Transform covariant and contravariant vectors at positions that a function gives."""
        at = jacobians(self.deformation, *positions(), progress)
        if attributes is self.output.GetCellData():
            at = with_identity(at, is_empty(self.output))
        transform(attributes, directions, at, self.options.directions.is_unit)

    def _off_cuts(self, points):
        """`points`, those on a cut moved a little towards their cells."""
        return points if self.offset is None else points + self.offset

    def _points(self):
        return positions_of(self.output)

    def _positions(self, deformation, moved):
        """Positions (n, 3) at which a deformation is evaluated, and origins (n, 3) or None."""
        if deformation.in_rest_frame:
            return moved, self._off_cuts(self.before)
        return self._off_cuts(moved), None

    def _center_positions(self):
        """`_positions` of the centers of the cells of the output."""
        if not self.deformation.in_rest_frame:
            return cell_centers(self.output), None
        before = shallow_copy(self.output)
        set_positions(before, self.before, VTK_DOUBLE)
        return cell_centers(self.output), cell_centers(before)


def largest_blend(blend, inverts, progress):
    """The largest blend at which no cell is inside out, a multiple of 1 / `_BLEND_STEPS`.

    By bisection between 0, where nothing moves, and `blend`, where some cell is inside out: at the
    result none is, and at one step more some is. Cells that are inside out over a part of the way
    only can be missed. `inverts(blend, progress)` says whether some cell is inside out.
    """
    low, high = 0, math.ceil(abs(blend) * _BLEND_STEPS)
    parts = iter(progress.divided(*[1] * (high.bit_length() + 1)))
    while high - low > 1:
        middle = (low + high) // 2
        if inverts(math.copysign(middle / _BLEND_STEPS, blend), next(parts)):
            high = middle
        else:
            low = middle
    return math.copysign(low / _BLEND_STEPS, blend)


def offset_from_cuts(deformation, positions, to_cut, side):
    """Offsets from `positions` (n, 3) to the points at which the map is evaluated.

    Points on a cut move onto it and a little further, towards their cells; `to_cut` and `side` are
    those of `splitting.split`.
    """
    size = rounding_sizes(deformation, positions)
    return to_cut + _OFF_CUT * np.where(np.isfinite(size), size, 0)[:, None] * side


def transform(attributes, directions, parts, unit):
    """Transform covariant and contravariant vectors of point or cell data.

    `directions` are as of `DirectionArrays.of`, `parts` slices and Jacobians (m, 3, 3) there, as of
    `jacobians`. With `unit` gradients get length 1, as normals always have.
    """
    values = {name: arrays.to_numpy(attributes.GetArray(name)).copy() for name in directions}
    for part, jacobian in parts:
        for name, how in directions.items():
            rows = values[name][part]
            if how == "tangent":
                rows[:] = contravariant(rows, jacobian)
            else:
                rows[:] = covariant(rows, jacobian.swapaxes(1, 2), unit or how == "normal")
    for name, rows in values.items():
        arrays.replace(attributes, name, rows)


def stamps(mesh):
    """Time stamps of all objects that a divided mesh depends on.

    Those of the point data and the cell data do not count: since VTK 9.7 vtkTransformFilter, for
    one, changes them in its input though no array changes.
    """
    result = _stamps_of_parts(mesh)
    for data in (mesh.GetPointData(), mesh.GetCellData()):
        kinds = range(vtkDataSetAttributes.NUM_ATTRIBUTES)
        active = [data.GetAbstractAttribute(kind) for kind in kinds]
        result.append([_stamp(array) for array in arrays.all_arrays(data) + active])
    return result


def _stamps_of_parts(thing):
    """The time stamp of a mesh or of a part of it, and, as lists like this, of its own parts."""
    parts = [get(thing) for kind, gets in _PARTS.items() if isinstance(thing, kind) for get in gets]
    return [_stamp(thing), *map(_stamps_of_parts, parts)]


def _stamp(thing):
    """The time stamp of a vtkObject without its parts; None for None."""
    return None if thing is None else vtkObject.GetMTime(thing)


def cell_centers(mesh):
    """Centers of the cells (n, 3); NaN for cells without points."""
    filled = without_empty(mesh)
    points = output_of(vtkCellCenters(), InputData=filled, VertexCells=False).GetPoints()
    positions = np.zeros((0, 3)) if points is None else arrays.to_numpy(points.GetData())
    if filled is mesh:
        return positions
    result = np.full((mesh.GetNumberOfCells(), 3), np.nan)
    result[~is_empty(mesh)] = positions
    return result


def with_identity(parts, rows):
    """Slices and Jacobians as of `jacobians`, with the identity at `rows` (n,) bool."""
    for part, jacobian in parts:
        jacobian[rows[part]] = np.eye(3)
        yield part, jacobian


def jacobians(deformation, points, origins, progress):
    """Slices of `points` (n, 3), and dG_i/dv_j (m, 3, 3) float64 there; NaN at NaN.

    For the material of `origins` (n, 3), if they are given.
    """
    for part, chunk in progress.chunks(len(points), _CHUNK):
        finite = np.isfinite(points[part]).all(axis=1)
        jacobian = np.full((len(finite), 3, 3), np.nan)
        finite_origins = None if origins is None else origins[part][finite]
        jacobian[finite] = deformation.jacobian(points[part][finite], chunk, finite_origins)
        yield part, jacobian


def copy(mesh, output):
    """Fill `output` with `mesh`; a vtkRectilinearGrid becomes a vtkStructuredGrid."""
    if isinstance(mesh, vtkRectilinearGrid):
        mesh = output_of(vtkRectilinearGridToPointSet(), InputData=mesh)
    output.ShallowCopy(mesh)
