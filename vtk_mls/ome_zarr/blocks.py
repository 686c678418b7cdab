"""The blocks of an output: whole chunks of its arrays, each computed and written by itself."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vtk_mls.base import interpolation
from vtk_mls.base.sampling import Sampling, corner_median, corners_of
from vtk_mls.files.ome_zarr import open_image, read, write
from vtk_mls.queries import fields
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms.parts import resampled_part, slices_of

MAX_VALUES = 1 << 23  # of a block, unless a chunk has more: 8 bytes each, and 12 for its origin


@dataclass(frozen=True, eq=False)
class Blocks:
    """The arrays of an output image, in blocks that processes share.

    Parameters
    ----------
    source : Path
        Folder of the input image.
    target : Path
        Folder of the output image, whose arrays exist.
    transform : Transform
    """

    source: Path
    target: Path
    transform: Transform

    def __getstate__(self):  # without opened images
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}

    @functools.cached_property
    def _input(self):
        return open_image(self.source)

    @functools.cached_property
    def _output(self):
        return open_image(self.target, "r+")

    @property
    def stages(self):
        """Number of stages. The blocks of a stage need those of the stage before."""
        return len(self._output.levels)

    def starts(self, stage):
        """The first indices (tuples) of the blocks of a stage."""
        array = self._output.levels[stage].array
        shape = self._shape(stage)
        return list(itertools.product(*map(range, [0] * array.ndim, array.shape, shape)))

    def size(self, stage):
        """The number of values of a block."""
        return math.prod(self._shape(stage))

    def write(self, stage, start):
        """Compute a block, a large shard in parts, and write it at once."""
        array = self._output.levels[stage].array
        stops = np.minimum(np.add(start, self._shape(stage)), array.shape).tolist()
        values = np.empty(np.subtract(stops, start), array.dtype)
        for part in _parts([*map(slice, start, stops)]):
            where = tuple(slice(r.start - a, r.stop - a) for r, a in zip(part, start))
            values[where] = self._values(stage, part)
        write(array, tuple(map(slice, start, stops)), values)

    def _shape(self, stage):
        return block_shape(self._output.levels[stage].array, self._output.axes)

    def _values(self, stage, place):
        raise NotImplementedError


def channel_backgrounds(image):
    """The automatic background of an Image: a tuple with one for each channel; 0 for labels.

    It is the `corner_median` of each channel of the finest level at the first time.
    """
    if image.is_label:
        return 0.0
    array, lead = image.finest.array, len(image.axes.rstrip("zyx"))
    first = [slice(0, array.shape[i] if image.axes[i] == "c" else 1) for i in range(lead)]
    corners = [(*first, *(slice(n, n + 1) for n in at)) for at in corners_of(array.shape[lead:])]
    values = corner_median([read(array, corner).ravel() for corner in corners])
    return values if "c" in image.axes else values[0]


@dataclass(frozen=True, eq=False)
class DeformedBlocks(Blocks):
    """Blocks of a deformed image: first the finest level, then each level from the one before.

    Parameters
    ----------
    interpolation, void_values
        As of `Sampling`.
    background : number, or tuple with one for each channel
    """

    interpolation: str = "linear"
    background: float | tuple = 0.0
    void_values: str = "background"

    def _values(self, stage, place):
        return self._coarsened(stage, place) if stage else self._deformed(place)

    def _deformed(self, place):
        level, array = self._input.finest, self._input.finest.array
        lead, space = _divided(place, self._output.axes)
        target = _part(self._output.finest.grid, space)
        count = math.prod(rows.stop - rows.start for rows in lead)

        def read_part(part):
            values = read(array, lead + slices_of(part)[3 - len(space) :])
            return list(values.reshape(count, *part.shape))

        method = "nearest" if self._output.is_label else self.interpolation
        background = self.background
        if isinstance(background, tuple):  # the last leading axis is that of channels
            background = background[lead[-1]] * (count // (lead[-1].stop - lead[-1].start))
        sampling = Sampling(level.grid, target, method, background, self.void_values)
        results = resampled_part(
            read_part, [np.dtype(array.dtype)] * count, self.transform, sampling
        )
        values = results[0] if count == 1 else np.stack(results)
        return values.reshape([rows.stop - rows.start for rows in place])

    def _coarsened(self, stage, place):
        finer = self._output.levels[stage - 1].array
        lead, space = _divided(place, self._output.axes)
        factors = self._output.factors(stage)[3 - len(space) :]
        rows = [
            slice(rows.start * n, min(rows.stop * n, size))
            for rows, n, size in zip(space, factors, finer.shape[len(lead) :])
        ]
        values = read(finer, (*lead, *rows))
        size = [rows.stop - rows.start for rows in space]
        return coarsened(values, factors, size, self._output.is_label)


@dataclass(frozen=True, eq=False)
class FieldBlocks(Blocks):
    """Blocks of a displacement field G(v) - v on the grid of an image: axes c, z, y, x."""

    def _values(self, stage, place):
        lead, space = _divided(place, self._output.axes)
        part = _part(self._output.finest.grid, space)
        vectors = self.transform.displacement_field(part).displacement
        if not np.isfinite(vectors).all():  # warnings of blocks would be lost
            raise ValueError(fields.gaps("displacements", vectors))
        return np.moveaxis(vectors, -1, 0)[lead]


def block_shape(array, axes):
    """The shape of blocks: whole chunks, or shards, of about `MAX_VALUES` values.

    All channels are in one block if that suffices, so that the map is evaluated once for them.
    """
    shape = [min(n, size) for n, size in zip(array.shards or array.chunks, array.shape)]
    if "c" in axes:
        axis = axes.index("c")
        all_channels = [*shape[:axis], array.shape[axis], *shape[axis + 1 :]]
        shape = all_channels if math.prod(all_channels) <= MAX_VALUES else shape
    space = range(len(axes.rstrip("zyx")), len(axes))
    while True:
        growing = [a for a in space if shape[a] < array.shape[a]]
        if not growing or 2 * math.prod(shape) > MAX_VALUES:
            return tuple(shape)
        axis = min(growing, key=lambda a: shape[a])
        shape[axis] = min(2 * shape[axis], array.shape[axis])


def coarsened(values, factors, size, is_label):
    """Means of windows of `factors` points along the last axes, or for labels their middle values.

    Parameters
    ----------
    values : (..., n) array
    factors, size : sequences of ints
        Along the last axes: points of a window, and windows. The last window may be smaller, and
        points may follow it.
    is_label : bool
    """
    space = range(values.ndim - len(factors), values.ndim)
    if is_label:
        for axis, n, count in zip(space, factors, size):
            index = np.minimum(np.arange(count) * n + (n - 1) // 2, values.shape[axis] - 1)
            values = values.take(index, axis)
        return values
    is_small = values.dtype.kind in "iu" and values.dtype.itemsize < 8
    total = np.zeros(values.shape[: space[0]] + tuple(size), np.int64 if is_small else np.float64)
    for offsets in itertools.product(*map(range, factors)):
        part = values
        for axis, n, count, offset in zip(space, factors, size, offsets):
            # the border's value continues, as in `Sampling`
            index = np.minimum(np.arange(count) * n + offset, values.shape[axis] - 1)
            is_regular = index[-1] == (count - 1) * n + offset
            rows = slice(offset, index[-1] + 1, n) if is_regular else index
            part = part[(slice(None),) * axis + (rows,)]
        total += part
    return interpolation.cast(total / math.prod(factors), values.dtype)


def _parts(place):
    """Halves of slices, of halves and so on, with at most `MAX_VALUES` values each."""
    sizes = [rows.stop - rows.start for rows in place]
    if math.prod(sizes) <= MAX_VALUES:
        yield tuple(place)
        return
    axis = int(np.argmax(sizes))
    first, stop = place[axis].start, place[axis].stop
    middle = (first + stop) // 2
    for rows in (slice(first, middle), slice(middle, stop)):
        yield from _parts([*place[:axis], rows, *place[axis + 1 :]])


def _divided(place, axes):
    """Slices of times and channels, and slices of space."""
    count = len(axes.rstrip("zyx"))
    return place[:count], place[count:]


def _part(grid, space):
    """The part of a grid in slices along its last axes, (z,) y, x."""
    first = [rows.start for rows in space[::-1]] + [0] * (3 - len(space))
    size = [rows.stop - rows.start for rows in space[::-1]] + [1] * (3 - len(space))
    return grid.part(first, size)
