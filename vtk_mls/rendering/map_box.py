"""The box that rays traverse: it contains the deformed volume."""

from dataclasses import dataclass, replace

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.vtk.arrays import ImageGeometry

_MARGIN = 0.15  # of the size, on each side
_GROWTH = 0.4  # of the size, on a side that the volume reaches
_MAX_SIZE = 64  # times the volume: polynomials bring copies of it from far away
_SAMPLES = 17  # of the map along an axis, to find the volume
_UNBOUNDED = np.array([[-np.inf] * 3, [np.inf] * 3])
_MIN_FILLED = 0.5  # share of an axis that the volume fills, below which the box shrinks


@dataclass(frozen=True, eq=False)
class MapBox:
    """A box that is aligned with an image, an ImageGeometry.

    Its ends `low` and `high` (3,), and its limits `within` (2, 3), are continuous indices of the
    values: of points, or of cells if `is_cell_data`.
    """

    image: ImageGeometry
    is_cell_data: bool
    within: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def around(cls, image, is_cell_data, within=None):
        """The box around an undeformed volume, with a margin.

        `within`, a Grid that is aligned with the image, has at least two points along each axis.
        """
        values = _values_of(image, is_cell_data)
        ends = _ends(values, within)
        box = cls(image, is_cell_data, ends, np.full(3, -0.5), np.array(values.dimensions) - 0.5)
        if np.any(box.high <= ends[0]) or np.any(box.low >= ends[1]):
            return replace(box, low=ends[0], high=ends[1])
        return box._with_margin()

    def ends_at(self, within):
        """Whether a Grid, or None, has the same limits."""
        return np.array_equal(self.within, _ends(self.values, within))

    @property
    def values(self):
        """The `Grid` of the volume's values."""
        return _values_of(self.image, self.is_cell_data)

    def nodes(self, count):
        """The `Grid` of the map, with `count` nodes along the longest side."""
        length = (self.high - self.low) * np.abs(self.values.spacing)
        dimensions = np.maximum(np.rint(count * length / length.max()), 2).astype(int)
        spacing = self.values.spacing * (self.high - self.low) / (dimensions - 1)
        origin = self.values.at(self.low[None])[0]
        return Grid(dimensions, origin, spacing, self.values.direction)

    def image_geometry(self):
        """The geometry of an image with the same points that fills the box."""
        points = np.array(self.image.grid.dimensions)
        spacing = self.values.spacing * (self.high - self.low) / (points - 1)
        first = self.image.extent[::2]
        origin = self.values.at(self.low[None])[0] - (self.values.direction * spacing) @ first
        return ImageGeometry(self.image.extent, tuple(origin), tuple(spacing), self.image.direction)

    def fitted(self, layers, grid, control_points):
        """The box that fits the deformed volume: this one if it does.

        `layers` is the map (layers, nz, ny, nx, 4) on the `grid` of `nodes`; `control_points` (n,
        3) are parts of the volume that nodes may miss.
        """
        size = self.high - self.low
        first, last = self._filled(layers, grid)
        if len(control_points) > 0:
            share = (self.values.index_of(control_points) - self.low) / size
            first, last = np.minimum(first, share.min(axis=0)), np.maximum(last, share.max(axis=0))
        ends = (self.within - self.low) / size
        first, last = np.clip(first, *ends), np.clip(last, *ends)
        too_large = size > _MAX_SIZE * np.array(self.values.dimensions)
        short = ((first < 0) & ~too_large, (last > 1) & ~too_large)
        if np.any(short):
            first = np.where(short[0], np.minimum(first, 0) - _GROWTH, 0)
            last = np.where(short[1], np.maximum(last, 1) + _GROWTH, 1)
            return self._part(first, last)
        if (last - first < _MIN_FILLED).any():
            return self._part(first, last)._with_margin()
        return self

    def _filled(self, layers, grid):
        """The ends of the volume, as shares of the box, extended by a sample: (3,) and (3,)."""
        axes = [np.unique(np.linspace(0, n - 1, _SAMPLES).astype(int)) for n in grid.dimensions]
        values = layers[np.ix_(range(len(layers)), *axes[::-1])].reshape(-1, 4)
        index = np.stack(np.meshgrid(*axes[::-1], indexing="ij"), axis=-1)[..., ::-1]
        index = np.tile(index.reshape(-1, 3), (len(layers), 1))
        origin = self.values.index_of(grid.at(index) + values[:, :3])
        index = index[self.values.covers(origin) & (values[:, 3] >= 0)]
        if len(index) == 0:
            return np.zeros(3), np.ones(3)
        end, step = np.array(grid.dimensions) - 1, 1 / (_SAMPLES - 1)
        return index.min(axis=0) / end - step, index.max(axis=0) / end + step

    def _part(self, first, last):
        """The box from one share to another, within the limits."""
        size = self.high - self.low
        low = np.maximum(self.low + first * size, self.within[0])
        high = np.minimum(self.low + last * size, self.within[1])
        return replace(self, low=low, high=high)

    def _with_margin(self):
        return self._part(np.full(3, -_MARGIN), np.full(3, 1 + _MARGIN))


def _values_of(image, is_cell_data):
    return image.grid.cells if is_cell_data else image.grid


def _ends(values, within):
    """Continuous indices (2, 3) of the ends of a Grid; infinite for None."""
    if within is None:
        return _UNBOUNDED
    return np.sort(values.index_of(within.corners()[[0, -1]]), axis=0)
