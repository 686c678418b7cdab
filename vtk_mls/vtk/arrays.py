"""VTK arrays as numpy arrays, and back."""

import functools
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from vtkmodules.vtkCommonCore import (
    VTK_BIT,
    VTK_DOUBLE,
    VTK_FLOAT,
    VTK_ID_TYPE,
    VTK_UNSIGNED_CHAR,
    vtkDataArray,
    vtkIdTypeArray,
    vtkStringArray,
)
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkDataSetAttributes
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

from vtk_mls.base.errors import InputError
from vtk_mls.base.grid import Grid
from vtk_mls.vtk.objects import configured, shallow_copy

GHOSTS = vtkDataSetAttributes.GhostArrayName()
_EMPTY = (0, -1, 0, -1, 0, -1)
# Number of geometries whose grids are cached.
_CACHE_SIZE = 32
_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class ImageGeometry:
    """Extent and placement of a vtkImageData.

    The `extent` has the first and the last index along each axis; the first need not be 0. `origin`
    is the position of index (0, 0, 0), which need not be in the extent, world coordinates. Along an
    axis of one point `spacing` may be 0, which counts as 1. `direction` has 9 numbers, row by row.
    """

    extent: tuple
    origin: tuple = (0.0, 0.0, 0.0)
    spacing: tuple = (1.0, 1.0, 1.0)
    direction: tuple = _IDENTITY

    @classmethod
    def of_image(cls, image):
        """Of a vtkImageData."""
        matrix = image.GetDirectionMatrix()
        direction = tuple(matrix.GetElement(i, j) for i in range(3) for j in range(3))
        return cls(image.GetExtent(), image.GetOrigin(), image.GetSpacing(), direction)

    @classmethod
    def of_information(cls, info):
        """Whole extent and placement in pipeline information; empty without them."""
        extent = info.Get(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT()) or _EMPTY
        keys = (vtkDataObject.ORIGIN(), vtkDataObject.SPACING(), vtkDataObject.DIRECTION())
        defaults = (cls.origin, cls.spacing, cls.direction)
        return cls(extent, *(info.Get(key) or default for key, default in zip(keys, defaults)))

    @classmethod
    def of_grid(cls, grid):
        """Of a `Grid`, its first point at index (0, 0, 0)."""
        extent = tuple(i for n in grid.dimensions for i in (0, n - 1))
        direction = tuple(grid.direction.ravel().tolist())
        return cls(extent, tuple(grid.origin.tolist()), tuple(grid.spacing.tolist()), direction)

    def set_information(self, info):
        """Set the whole extent and the placement in pipeline information."""
        info.Set(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT(), self.extent, 6)
        info.Set(vtkDataObject.ORIGIN(), self.origin, 3)
        info.Set(vtkDataObject.SPACING(), self.spacing, 3)
        info.Set(vtkDataObject.DIRECTION(), self.direction, 9)

    def apply_to(self, image):
        """A vtkImageData, after it got this extent, origin, spacing and direction."""
        configured(image, Extent=self.extent, Origin=self.origin, Spacing=self.spacing)
        return configured(image, DirectionMatrix=self.direction)

    def part(self, extent):
        """The same geometry with another extent."""
        return ImageGeometry(tuple(extent), self.origin, self.spacing, self.direction)

    def holds(self, extent):
        """Whether another, non-empty extent lies within."""
        ends = zip(self.extent[::2], extent[::2], extent[1::2], self.extent[1::2])
        return all(first <= low <= high <= last for first, low, high, last in ends)

    def grid_within(self, whole):
        """The points as a part of the `Grid` of a whole that holds them."""
        return _part_of(whole, self.extent)

    @property
    def is_empty(self):
        """Whether there is no point."""
        return any(first > last for first, last in zip(self.extent[::2], self.extent[1::2]))

    @property
    def grid(self):
        """The points as a `Grid`, whose origin is the extent's first point."""
        return _grid_of(self)


@functools.lru_cache(_CACHE_SIZE)
def _grid_of(geometry):
    first, last = np.array(geometry.extent[::2]), np.array(geometry.extent[1::2])
    is_flat = (first == last) & (np.array(geometry.spacing) == 0)
    spacing = np.where(is_flat, 1.0, geometry.spacing)
    base = Grid((1, 1, 1), geometry.origin, spacing, np.reshape(geometry.direction, (3, 3)))
    origin = base.at(np.where(is_flat, 0, first)[None])[0]
    return Grid(last - first + 1, origin, base.spacing, base.direction)


@functools.lru_cache(_CACHE_SIZE)
def _part_of(whole, extent):
    first, last, start = (np.array(ends) for ends in (extent[::2], extent[1::2], whole.extent[::2]))
    return whole.grid.part(first - start, last - first + 1)


def to_numpy(array):
    """Values of a vtkDataArray of any type and layout: (n,) or (n, components).

    A view of VTK's memory where that is contiguous, else a copy; bits are uint8.
    """
    n, components = array.GetNumberOfTuples(), array.GetNumberOfComponents()
    shape = (n,) if components == 1 else (n, components)
    is_bits = array.GetDataType() == VTK_BIT
    dtype = np.dtype(np.uint8) if is_bits else _dtype(array)
    if n == 0:
        return np.empty(shape, dtype)
    if is_bits:
        return np.unpackbits(np.frombuffer(array, dtype), count=n * components).reshape(shape)
    if not array.HasStandardMemoryLayout():
        standard = vtkDataArray.CreateDataArray(array.GetDataType())
        standard.DeepCopy(array)
        array = standard
    return np.frombuffer(array, dtype, n * components).reshape(shape)


def from_numpy(values, vtk_type):
    """A vtkDataArray of the type `vtk_type` that shares the memory of `values` if it can.

    Memory is shared from VTK 9.7 on. Older versions cannot keep it alive for shallow copies of the
    array, which ParaView makes: they copy it. `values` (n,) or (n, components) have the dtype that
    `to_numpy` returns for the type; TypeError otherwise.
    """
    array = vtkDataArray.CreateDataArray(vtk_type)
    if vtk_type != VTK_BIT and values.dtype != _dtype(array):
        raise TypeError(
            f"`values` must be {_dtype(array)} for a {array.GetClassName()}, got {values.dtype}"
        )
    array.SetNumberOfComponents(1 if values.ndim == 1 else values.shape[1])
    flat = np.ascontiguousarray(values).ravel()
    if vtk_type == VTK_BIT:
        array.SetNumberOfTuples(len(values))
        np.frombuffer(array, np.uint8)[:] = np.packbits(flat != 0)
    elif hasattr(array, "GetBuffer"):
        array.SetVoidArray(flat, flat.size, 1)
        array.GetBuffer()._numpy_reference = flat
    elif flat.size:
        array.SetNumberOfTuples(len(values))
        np.frombuffer(array, flat.dtype)[:] = flat
    return array


def ids(values):
    """A vtkIdTypeArray of integers (n,) of any size."""
    return from_numpy(values.astype(_ID, copy=False), VTK_ID_TYPE)


def add(attributes, name, values):
    """Add (n,) or (n, components) values, or one number: float32, float64, uint8, bool or integers.

    Integers become vtkIdType. The array may share the memory of `values`, as `from_numpy` says.
    """
    values = np.atleast_1d(values)
    if values.dtype == bool:
        values = values.view(np.uint8)
    if values.dtype.kind == "i":
        array = ids(values)
    else:
        vtk_type = {"f4": VTK_FLOAT, "f8": VTK_DOUBLE, "u1": VTK_UNSIGNED_CHAR}
        array = from_numpy(values, vtk_type[values.dtype.str[1:]])
    array.SetName(name)
    attributes.AddArray(array)


def add_texts(attributes, name, texts):
    """Add an array of texts, (n,) str."""
    array = configured(vtkStringArray(), Name=name, NumberOfValues=len(texts))
    for i, text in enumerate(texts):
        array.SetValue(i, text)
    attributes.AddArray(array)


def texts(attributes, name):
    """The texts of an array (n,); an empty list without such an array of strings."""
    array = attributes.GetAbstractArray(name)
    if not isinstance(array, vtkStringArray):
        return []
    values = [array.GetValue(i) for i in range(array.GetNumberOfValues())]
    # values that are not UTF-8 are bytes
    return [value if isinstance(value, str) else value.decode("latin-1") for value in values]


def replace(attributes, name, values):
    """Replace the values of an array of point or cell data; active attributes stay active."""
    old = attributes.GetArray(name)
    array = configured(from_numpy(values, old.GetDataType()), Name=name)
    array.CopyComponentNames(old)
    attributes.AddArray(array)  # in place of the old one, with its role


def name_normals(dataset):
    """Name active normals that have no name, in a copy: VTK's filters would lose them."""
    for attributes in (dataset.GetPointData(), dataset.GetCellData()):
        normals = attributes.GetNormals()
        if normals is not None and not normals.GetName():
            named, name = shallow_copy(normals), "Normals"
            while attributes.HasArray(name):
                name += "_"
            named.SetName(name)
            attributes.SetNormals(named)


def image_values(attributes, grid):
    """All arrays of an image's point or cell data, (nz, ny, nx) or (nz, ny, nx, components).

    Views as of `to_numpy`, at the points of a `Grid`. An array that is not numeric (strings) gives
    the indices of its own tuples.
    """
    values = []
    for array in all_arrays(attributes):
        if array.GetNumberOfTuples() != grid.size:
            raise ValueError(
                f"array `{array.GetName()}` must have one tuple for each of the {grid.size} points "
                f"or cells of the image, got {array.GetNumberOfTuples()}"
            )
        flat = to_numpy(array) if is_numeric(array) else np.arange(grid.size)
        values.append(flat.reshape(grid.shape + flat.shape[1:]))
    return values


def check_lengths(dataset, are_exact=False):
    """Raise ValueError for a point or cell array that is too short, or with `are_exact` too long:
    VTK would read past its end.
    """
    for attributes, what, count in (
        (dataset.GetPointData(), "points", dataset.GetNumberOfPoints()),
        (dataset.GetCellData(), "cells", dataset.GetNumberOfCells()),
    ):
        for array in all_arrays(attributes):
            size = array.GetNumberOfTuples()
            if size < count or (are_exact and size > count):
                raise ValueError(
                    f"array `{array.GetName()}` must have one tuple for each of the {count} {what}"
                    f", got {size}"
                )


def set_rows(attributes, source, rows):
    """Fill point or cell data with the tuples `rows` (n,) of those of `source`."""
    values = [to_numpy(old)[rows] if is_numeric(old) else rows for old in all_arrays(source)]
    set_values(attributes, values, source)


def set_values(attributes, values, source):
    """Fill point or cell data with one of `values` per array of `source`, also point or cell data.

    They are (n,), (n, components), or as `image_values` gives them; an index that is negative
    leaves a string empty. `source` gives types, names, component names, lookup tables and roles.
    """
    for new, old in zip(values, all_arrays(source)):
        if new.ndim > 2:
            new = new.reshape(-1, *new.shape[3:])
        if is_numeric(old):
            array = from_numpy(new, old.GetDataType())
            array.SetLookupTable(old.GetLookupTable())
        else:
            array = _pick_tuples(old, new)
        array.SetName(old.GetName())
        array.CopyComponentNames(old)
        attributes.AddArray(array)
    for kind, active in _roles(source):
        position = [array is active for array in all_arrays(source)].index(True)
        attributes.SetActiveAttribute(position, kind)


def set_roles(attributes, source):
    """Make arrays the active attributes (scalars, normals, ...) that they are in `source`."""
    for kind, active in _roles(source):
        if attributes.HasArray(active.GetName()):
            attributes.SetActiveAttribute(active.GetName(), kind)


def _roles(source):
    """Active attributes. Global ids become plain arrays: several points may have the same now."""
    for kind in range(vtkDataSetAttributes.NUM_ATTRIBUTES):
        active = source.GetAbstractAttribute(kind)
        if active is not None and kind != vtkDataSetAttributes.GLOBALIDS:
            yield kind, active


def cell_types(grid):
    """VTK's number for the type of each cell of a vtkUnstructuredGrid: (n,) integers."""
    return to_numpy(cell_type_array(grid))


def cell_type_array(grid):
    """The vtkDataArray of a vtkUnstructuredGrid with the types of its cells."""
    try:
        return grid.GetCellTypes()  # VTK 9.6
    except TypeError:
        return grid.GetCellTypesArray()


def is_numeric(array):
    """Whether a vtkAbstractArray holds numbers."""
    return isinstance(array, vtkDataArray)


def control_points(polydata, displacement, weight=None, moved=None):
    """p and q (n, 3), world coordinates, and weights (n,) or None of a vtkPointSet: float64.

    `displacement` names the point vectors q - p, `weight` a point array with factors. The points of
    `moved`, a vtkPointSet, are q, in the same order, in place of displacements. ValueError if there
    is no point, an array is missing or has a wrong shape, or `moved` has more or fewer points.
    """
    count = polydata.GetNumberOfPoints()
    if count == 0:
        raise InputError(
            "has no points; a deformation needs at least one control point",
            argument="ControlPoints",
        )
    rest = to_numpy(polydata.GetPoints().GetData()).astype(np.float64)
    if moved is None:
        deformed = rest + _control_point_values(polydata, displacement, 3)
    elif moved.GetNumberOfPoints() == count:
        deformed = to_numpy(moved.GetPoints().GetData()).astype(np.float64)
    else:
        raise ValueError(
            f"`DeformedControlPoints` must have a point for each of the {count} points of "
            f"`ControlPoints`, got {moved.GetNumberOfPoints()}; connect the same data, moved, for "
            "example by Transform"
        )
    weights = None if weight is None else _control_point_values(polydata, weight, 1)
    return rest, deformed, weights


def _control_point_values(polydata, name, components):
    data, count = polydata.GetPointData(), polydata.GetNumberOfPoints()
    array = data.GetArray(name)
    if array is None:
        found = ", ".join(f"`{other.GetName()}`" for other in all_arrays(data))
        problem = f"has no numeric point array `{name}`; it has {found or 'none'}"
    elif array.GetNumberOfComponents() != components:
        problem = (
            f", array `{name}`, must have {components} component{'s' * (components > 1)}, "
            f"got {array.GetNumberOfComponents()}"
        )
    elif array.GetNumberOfTuples() != count:
        problem = (
            f", array `{name}`, must have one tuple per point, got "
            f"{array.GetNumberOfTuples()} for {count} points"
        )
    else:
        return to_numpy(array).astype(np.float64)
    raise InputError(problem, argument="ControlPoints")


def all_arrays(attributes):
    """The vtkAbstractArrays of point, cell or field data."""
    return [attributes.GetAbstractArray(i) for i in range(attributes.GetNumberOfArrays())]


def _dtype(array):
    """The dtype of a vtkDataArray that is not of bits; VTK decides whether char is signed."""
    if array.GetDataType() in (VTK_FLOAT, VTK_DOUBLE):
        kind = "f"
    else:
        kind = "i" if array.GetDataTypeMin() < 0 else "u"
    return np.dtype(f"{kind}{array.GetDataTypeSize()}")


_ID = _dtype(vtkIdTypeArray())


def _pick_tuples(array, index):
    """The tuples `index` of a vtkAbstractArray; none where negative."""
    result = configured(array.NewInstance(), NumberOfComponents=array.GetNumberOfComponents())
    result.SetNumberOfTuples(len(index))
    for row in np.flatnonzero(index >= 0).tolist():
        result.SetTuple(row, int(index[row]), array)
    return result


def along_world_axes(grid):
    """A Grid with its axes in the order and the direction of x, y and z, and a function.

    The function takes values (nz, ny, nx, ...) of `grid` to those of the result, as a view. The
    direction matrix is then the identity, or for oblique axes the smallest possible rotation. It is
    `grid` itself if its axes are in order.
    """

    def alignment(axes):
        return np.abs(np.diagonal(grid.direction[:, axes])).sum()

    order = list(max(permutations(range(3)), key=alignment))
    signs = np.where(np.diagonal(grid.direction[:, order]) < 0, -1, 1)
    if order == [0, 1, 2] and (signs > 0).all():
        return grid, lambda values: values
    dimensions = np.array(grid.dimensions)[order]
    first = np.zeros(3)
    first[order] = np.where(signs < 0, dimensions - 1, 0)
    reordered = Grid(
        dimensions,
        grid.at(first[None])[0],
        np.array(grid.spacing)[order],
        grid.direction[:, order] * signs + 0.0,
    )
    axes = list(2 - np.array(order[::-1]))  # of arrays (nz, ny, nx)
    flipped = tuple(2 - np.flatnonzero(signs < 0))

    def reorder(values):
        return np.flip(np.transpose(values, [*axes, *range(3, values.ndim)]), flipped)

    return reordered, reorder
