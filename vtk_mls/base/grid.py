"""A regular grid in the world: what `vtkImageData` describes, without VTK."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.linear_algebra import transformed
from vtk_mls.base.progress import SILENT, Progress
from vtk_mls.base.validation import as_float, short_repr

# How the grid of a deformed volume is found: samples per axis, times that a side may move out by
# half of the size, times that the box shrinks to the samples.
_SAMPLES, _GROWTH, _SHRINKING = 48, 8, 2
_OTHERS = ((1, 2), (0, 2), (0, 1))  # axes beside each


@dataclass(frozen=True, eq=False)
class Grid:
    """Points in oriented rows, layers and columns with equal distances, x fastest.

    Parameters
    ----------
    dimensions : (3,) ints
        Number of points along the three axes (nx, ny, nz), each at least 1.
    origin : (3,) floats, world coordinates
        Position of the first point.
    spacing : (3,) floats, world units
        Distance between neighbours along each axis, not zero.
    direction : (3, 3) floats, optional
        Columns are the directions of the axes in the world; the identity if not given.

    Attributes
    ----------
    whole : Grid
        The grid of which this is a `part`; the grid itself if it is none.
    first : (3,) ints
        Index of the first point in `whole`.

    Raises
    ------
    ValueError
        If a parameter has the wrong shape, is not finite, or gives no volume.
    """

    dimensions: tuple[int, int, int]
    origin: NDArray[np.float64] = (0.0, 0.0, 0.0)
    spacing: NDArray[np.float64] = (1.0, 1.0, 1.0)
    direction: NDArray[np.float64] = None
    whole: Grid = field(init=False, repr=False)
    first: tuple[int, int, int] = field(init=False, default=(0, 0, 0))

    if TYPE_CHECKING:

        def __init__(
            self,
            dimensions: ArrayLike,
            origin: ArrayLike = ...,
            spacing: ArrayLike = ...,
            direction: ArrayLike | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        dimensions = _positive_integers(self.dimensions)
        direction = np.eye(3) if self.direction is None else self.direction
        for name, value, shape in (
            ("origin", self.origin, (3,)),
            ("spacing", self.spacing, (3,)),
            ("direction", direction, (3, 3)),
        ):
            array = as_float(name, value)
            if array.shape != shape or not np.isfinite(array).all():
                raise ValueError(
                    f"`{name}` must be {shape} finite numbers, got {short_repr(value)}"
                )
            object.__setattr__(self, name, _read_only(array))
        object.__setattr__(self, "dimensions", dimensions)
        object.__setattr__(self, "whole", self)
        if abs(np.linalg.det(self.direction)) < 1e-9 or not self.spacing.all():
            raise ValueError(
                "`spacing` must not be zero and `direction` must be invertible, "
                f"got {self.spacing.tolist()} and {self.direction.tolist()}"
            )

    def part(self, first: ArrayLike, dimensions: ArrayLike) -> Grid:
        """The `dimensions` points from the index `first` on, which stay part of this grid.

        Points are placed, and values at the border are found, as in the whole: what is computed
        in parts is the same to the bit.
        """
        size = _positive_integers(dimensions)
        start = tuple(int(a) + int(b) for a, b in zip(self.first, first))
        last = [a + n for a, n in zip(start, size)]
        if min(start) < 0 or any(a > n for a, n in zip(last, self.whole.dimensions)):
            raise ValueError(
                f"`first` and `dimensions` must be of a part of the {self.whole.dimensions} "
                f"points, got {start} and {size}"
            )
        part = object.__new__(Grid)
        for name, value in {
            "dimensions": size,
            "origin": _read_only(self.at([first])[0]),
            "spacing": self.spacing,
            "direction": self.direction,
            "whole": self.whole,
            "first": start,
        }.items():
            object.__setattr__(part, name, value)
        return part

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape (nz, ny, nx) of a numpy array with one value per point."""
        return self.dimensions[::-1]

    @property
    def size(self) -> int:
        """Number of points."""
        return int(np.prod(self.dimensions, dtype=np.int64))

    @functools.cached_property
    def index_to_world(self) -> NDArray[np.float64]:
        """(3, 3) matrix whose columns are the steps between neighbours in the world."""
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
        """Whether the continuous indices `index` (m, 3) are within half a spacing: (m,) bool."""
        return ((index >= -0.5) & (index <= np.array(self.dimensions) - 0.5)).all(axis=1)

    def index_transform(self, other: Grid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Matrix (3, 3) and offset (3,) from indices of this grid to those of `other`.

        Grids whose points coincide, as far as both reach, get exact integers.
        """
        matrix = other.world_to_index @ self.index_to_world
        offset = other.index_of(self.origin[None])[0]
        return _snapped(matrix), _snapped(offset)

    @functools.cached_property
    def cells(self) -> Grid:
        """The centres of the cells; along an axis with one point lies one layer of cells."""
        dimensions, whole = np.array(self.dimensions), np.array(self.whole.dimensions)
        number = np.maximum(dimensions - 1, 1)
        if self.whole is not self and ((dimensions > 1) | (whole == 1)).all():
            return self.whole.cells.part(self.first, number)
        centre = np.where(dimensions > 1, 0.5, 0.0)
        return Grid(number, self.at(centre[None])[0], self.spacing, self.direction)

    def indices(self, start: int = 0, stop: int | None = None) -> NDArray[np.float64]:
        """Indices (m, 3) = (i, j, k) of the points `start` to `stop`, x fastest."""
        return self._indices_of(np.arange(start, self.size if stop is None else stop))

    def points(self, start: int = 0, stop: int | None = None) -> NDArray[np.float64]:
        """World positions (m, 3) of the points `start` to `stop`, x fastest."""
        return self.whole.at(self.indices(start, stop) + self.first)

    def numbered(self, numbers: NDArray[np.int64]) -> NDArray[np.float64]:
        """World positions (m, 3) of the points with the `numbers` (m,), x fastest."""
        return self.whole.at(self._indices_of(numbers) + self.first)

    def corners(self) -> NDArray[np.float64]:
        """World positions (8, 3) of the corners."""
        last = np.array(self.dimensions) - 1
        return self.at(np.stack(np.meshgrid(*[(0, n) for n in last]), axis=-1).reshape(-1, 3))

    def _indices_of(self, numbers):
        return np.stack(np.unravel_index(numbers, self.shape)[::-1], axis=1)


def _positive_integers(dimensions):
    wanted = as_float("dimensions", dimensions, "three positive integers (nx, ny, nz)")
    if wanted.shape != (3,) or not ((wanted >= 1) & (wanted % 1 == 0) & (wanted < 2**62)).all():
        raise ValueError(
            "`dimensions` must be three positive integers (nx, ny, nz), "
            f"got {short_repr(dimensions)}"
        )
    return tuple(int(n) for n in wanted)


def _read_only(array):
    array.flags.writeable = False
    return array


def _snapped(values: np.ndarray) -> np.ndarray:
    """`values` with what differs from an integer by rounding only made that integer."""
    whole = np.rint(values)
    return np.where(np.abs(values - whole) < 1e-7, whole, values)


def fitted_grid(deformation: Any, source: Grid, progress: Progress = SILENT) -> Grid:
    """Smallest grid in line with `source` found to hold the deformed volume.

    The backward map is sampled all over a box, inside and on its faces. The box grows on each
    side where the volume reaches it, then shrinks to the samples with one sample step to spare.
    Polynomials can bring copies of the volume from far away: growth stops after a few sizes.
    """
    size = np.array(source.dimensions, dtype=np.float64)
    low, high = np.full(3, -0.5), size - 0.5
    # control points say where the volume goes even if that is far
    control_points = source.index_of(deformation.deformed[_is_inside(source, deformation.rest)])
    low, high = _enclosed(low, high, control_points)
    margin = 0.25 * (high - low) + 1
    low, high = low - margin, high + margin
    growing, shrinking = progress.divided(_GROWTH, _SHRINKING)
    for part in growing.divided(*[1] * _GROWTH):
        inside, axes = _sampled(deformation, source, (low, high), part)
        step = 0.5 * (high - low)
        faces_low, faces_high = _touched(inside)
        if not (faces_low.any() or faces_high.any()):
            break
        low, high = low - step * faces_low, high + step * faces_high
    for part in shrinking.divided(*[1] * _SHRINKING):
        inside, axes = _sampled(deformation, source, (low, high), part)
        if not inside.any():
            break
        step = (high - low) / (_SAMPLES - 1)
        found = [axis[np.any(inside, axis=others)] for axis, others in zip(axes, _OTHERS)]
        low = np.array([axis[0] for axis in found]) - step
        high = np.array([axis[-1] for axis in found]) + step
    low, high = _enclosed(low, high, control_points)
    first, last = np.floor(low), np.ceil(high)
    flat = size == 1  # a slice stays a slice
    first, last = np.where(flat, 0, first), np.where(flat, 0, last)
    return Grid(
        (last - first + 1).astype(int), source.at(first[None])[0], source.spacing, source.direction
    )


def _sampled(deformation, source, box, progress):
    """Whether G maps each sample of the index box into `source`; the samples' axes."""
    axes = [np.linspace(low, high, _SAMPLES) for low, high in zip(*box)]
    index = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = _is_inside(source, deformation.backward(source.at(index), progress))
    return inside.reshape((_SAMPLES,) * 3), axes


def _is_inside(source, points):
    return source.covers(source.index_of(points))


def _touched(inside):
    faces = [
        (np.take(inside, 0, axis=a).any(), np.take(inside, -1, axis=a).any()) for a in range(3)
    ]
    return np.array(faces).T


def _enclosed(low, high, index):
    if len(index) == 0:
        return low, high
    return np.minimum(low, index.min(axis=0)), np.maximum(high, index.max(axis=0))


def checked_grid(name, value):
    """A `Grid`."""
    if not isinstance(value, Grid):
        raise TypeError(f"`{name}` must be a Grid, got {short_repr(value)}")
    return value
