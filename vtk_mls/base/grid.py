"""A regular grid in the world, as `vtkImageData` has it, without VTK."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.linear_algebra import transformed
from vtk_mls.base.validation import as_float, finite, freeze, short_repr


@dataclass(frozen=True, eq=False, init=False)
class Grid:
    """Points in oriented rows, layers and columns at equal distances, x fastest.

    Parameters
    ----------
    dimensions : (3,) ints
        Number of points along the three axes (nx, ny, nz), each at least 1.
    origin : (3,) floats, world coordinates
        Position of the first point.
    spacing : (3,) floats, world units
        Distance between neighbors along each axis, not zero.
    direction : (3, 3) floats, optional
        Columns are the directions of the axes in the world; the identity by default.

    Attributes
    ----------
    whole : Grid
        The full grid if this is a `part` of one, else this grid.
    first : (3,) ints
        Index of the first point in `whole`.

    Raises
    ------
    ValueError
        If a parameter has the wrong shape, is not finite, or gives no volume.
    """

    dimensions: tuple[int, int, int]
    origin: NDArray[np.float64]
    spacing: NDArray[np.float64]
    direction: NDArray[np.float64]
    whole: Grid = field(init=False, repr=False)
    first: tuple[int, int, int] = field(init=False)

    def __init__(
        self,
        dimensions: ArrayLike,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        spacing: ArrayLike = (1.0, 1.0, 1.0),
        direction: ArrayLike | None = None,
    ) -> None:
        freeze(
            self,
            dimensions=_positive_integers(dimensions),
            origin=finite("origin", origin, (3,)),
            spacing=finite("spacing", spacing, (3,)),
            direction=finite("direction", np.eye(3) if direction is None else direction, (3, 3)),
            whole=self,
            first=(0, 0, 0),
        )
        if abs(np.linalg.det(self.direction)) < 1e-9 or not self.spacing.all():
            raise InputError(
                "must not be zero and `direction` must be invertible, "
                f"got {self.spacing.tolist()} and {self.direction.tolist()}",
                argument="spacing",
            )

    def part(self, first: Iterable[int], dimensions: ArrayLike) -> Grid:
        """The `dimensions` points from the index `first` on, as a part of this grid.

        Positions and border values are those of the whole grid, so results computed in parts are
        equal to the bit.
        """
        size = _positive_integers(dimensions)
        first = tuple(int(i) for i in first)
        start = tuple(i + j for i, j in zip(self.first, first))
        last = [a + n for a, n in zip(start, size)]
        if min(start) < 0 or any(a > n for a, n in zip(last, self.whole.dimensions)):
            raise ValueError(
                f"`first` and `dimensions` must select a part of the {self.whole.dimensions} "
                f"points, got {start} and {size}"
            )
        part = object.__new__(Grid)
        freeze(
            part,
            dimensions=size,
            origin=self.at([first])[0],
            spacing=self.spacing,
            direction=self.direction,
            whole=self.whole,
            first=start,
        )
        return part

    def is_same(self, other: Grid | None) -> bool:
        """Whether a grid has the same points."""
        return self is other or (
            other is not None
            and self.dimensions == other.dimensions
            and np.array_equal(self.origin, other.origin)
            and np.array_equal(self.index_to_world, other.index_to_world)
        )

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape (nz, ny, nx) of an array with one value per point."""
        return self.dimensions[::-1]

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.dimensions)

    @property
    def is_part(self) -> bool:
        """Whether this is a part of a larger grid."""
        return self.dimensions != self.whole.dimensions

    @functools.cached_property
    def index_to_world(self) -> NDArray[np.float64]:
        """(3, 3) matrix whose columns are the steps between neighbors in the world."""
        return _read_only(self.direction * self.spacing)

    @functools.cached_property
    def world_to_index(self) -> NDArray[np.float64]:
        """(3, 3) inverse of `index_to_world`."""
        return _read_only(np.linalg.inv(self.index_to_world))

    def at(self, index: ArrayLike) -> NDArray[np.float64]:
        """World positions (m, 3) of the continuous indices `index` (m, 3) = (i, j, k)."""
        return self.origin + transformed(self.index_to_world, np.asarray(index, dtype=np.float64))

    def index_of(self, points: ArrayLike) -> NDArray[np.float64]:
        """Continuous indices (m, 3) = (i, j, k) of the world positions `points` (m, 3)."""
        offset = np.asarray(points, dtype=np.float64) - self.origin
        return transformed(self.world_to_index, offset)

    def covers(self, index: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether continuous indices (m, 3) are at most half a spacing outside: (m,) bool."""
        inside = (index >= -0.5) & (index <= np.array(self.dimensions) - 0.5)
        return np.logical_and.reduce(inside, axis=1)

    def index_transform(self, other: Grid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Matrix (3, 3) and offset (3,) from indices of this grid to those of `other`.

        They are exact integers if the points of both grids coincide.
        """
        matrix = other.world_to_index @ self.index_to_world
        return _snapped(matrix), _snapped(other.index_of(self.origin[None])[0])

    @functools.cached_property
    def cells(self) -> Grid:
        """The centers of the cells; an axis with one point has one layer of cells."""
        dimensions, whole = np.array(self.dimensions), np.array(self.whole.dimensions)
        count = np.maximum(dimensions - 1, 1)
        if self.whole is not self and ((dimensions > 1) | (whole == 1)).all():
            return self.whole.cells.part(self.first, count)
        center = np.where(dimensions > 1, 0.5, 0.0)
        return Grid(count, self.at(center[None])[0], self.spacing, self.direction)

    def indices(self, start: int = 0, stop: int | None = None) -> NDArray[np.float64]:
        """Indices (m, 3) = (i, j, k) of the points `start` to `stop`, x fastest."""
        return self._indices_of(np.arange(start, self.size if stop is None else stop))

    def points(self, start: int = 0, stop: int | None = None) -> NDArray[np.float64]:
        """World positions (m, 3) of the points `start` to `stop`, x fastest."""
        return self.whole.at(self.indices(start, stop) + self.first)

    def points_of(self, ids: NDArray[np.int64]) -> NDArray[np.float64]:
        """World positions (m, 3) of the points with the `ids` (m,), x fastest."""
        return self.whole.at(self._indices_of(ids) + self.first)

    def corners(self) -> NDArray[np.float64]:
        """World positions (8, 3) of the corners."""
        last = np.array(self.dimensions) - 1
        return self.at(np.stack(np.meshgrid(*[(0, n) for n in last]), axis=-1).reshape(-1, 3))

    def _indices_of(self, ids):
        return np.stack(np.unravel_index(ids, self.shape)[::-1], axis=1)


def _positive_integers(dimensions):
    values = as_float("dimensions", dimensions, "three positive integers (nx, ny, nz)")
    is_valid = (values >= 1) & (values % 1 == 0) & (values < 2**62)
    if values.shape != (3,) or not is_valid.all():
        raise InputError(
            f"must be three positive integers (nx, ny, nz), got {short_repr(dimensions)}",
            argument="dimensions",
        )
    return tuple(int(n) for n in values)


def _read_only(array):
    array.flags.writeable = False
    return array


def _snapped(values):
    """`values`, rounded where they are integers to rounding error."""
    integers = np.rint(values)
    return np.where(np.abs(values - integers) < 1e-7, integers, values)


def checked_grid(name, value):
    """`value`, which must be a `Grid`."""
    if not isinstance(value, Grid):
        raise TypeError(f"`{name}` must be a Grid, got {short_repr(value)}")
    return value
