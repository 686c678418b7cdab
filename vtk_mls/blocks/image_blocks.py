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
from vtk_mls.base.sampling import AUTOMATIC, Sampling, corner_median, corners_of
from vtk_mls.files.ome_zarr import open_image, read, write
from vtk_mls.queries import fields
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms.parts import resampled_part, slices_of

MAX_VALUES = 1 << 23  # of a block, unless a chunk has more: 8 bytes each, and 12 for its origin


@dataclass(frozen=True, eq=False)
class Blocks:
    """The arrays of an output image, in blocks that processes share.

    `source` and `target` are folders of the images; the arrays of the target exist.
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
        """The shape of blocks: whole chunks, or shards, of about `MAX_VALUES` values.

        All channels are in one block if that suffices, so that the map is evaluated once for them.
        """
        array, axes = self._output.levels[stage].array, self._output.axes
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

    def _values(self, stage, place):
        raise NotImplementedError


def channel_backgrounds(image, background):
    """The background of an Image, or a tuple with one for each channel.

    `background` is a number, "auto", or a tuple with one of these for each channel. "auto" is the
    `corner_median` of the channel on the finest level at the first time, and 0 for labels.
    """
    array, lead = image.finest.array, len(image.axes.rstrip("zyx"))
    has_channels = "c" in image.axes
    given = background if isinstance(background, tuple) else (background,)
    if image.is_label and isinstance(background, (str, tuple)):
        return 0.0
    if AUTOMATIC not in given:
        return background if has_channels else given[0]
    first = [slice(0, array.shape[i] if image.axes[i] == "c" else 1) for i in range(lead)]
    corners = [(*first, *(slice(n, n + 1) for n in at)) for at in corners_of(array.shape[lead:])]
    medians = corner_median([read(array, corner).ravel() for corner in corners])
    given = given * (len(medians) // len(given))
    values = tuple(m if value == AUTOMATIC else value for m, value in zip(medians, given))
    return values if has_channels else values[0]


@dataclass(frozen=True, eq=False)
class DeformedBlocks(Blocks):
    """Blocks of a deformed image: first the finest level, then each level from the one before.

    Interpolation and void values are as of `Sampling`; a tuple has one for each channel.
    """

    interpolation: str | tuple[str, ...] = "linear"
    background: float | tuple = 0.0
    void_values: str = "background"

    def _values(self, stage, place):
        if stage:
            return self._coarsened(stage, place)
        level, array = self._input.finest, self._input.finest.array
        lead, space = _divided(place, self._output.axes)
        target = _part(level.grid, space)
        count = math.prod(rows.stop - rows.start for rows in lead)

        def read_part(part):
            values = read(array, lead + slices_of(part)[3 - len(space) :])
            return list(values.reshape(count, *part.shape))

        methods, background = self._methods(lead).ravel().tolist(), self.background
        if isinstance(background, tuple):  # the last leading axis is that of channels
            background = background[lead[-1]] * (count // (lead[-1].stop - lead[-1].start))
        sampling = Sampling(level.grid, target, methods, background, self.void_values)
        dtype = np.dtype(np.uint8 if array.dtype == bool else array.dtype)
        results = resampled_part(read_part, [dtype] * count, self.transform, sampling)
        values = results[0] if count == 1 else np.stack(results)
        return values.reshape([rows.stop - rows.start for rows in place])

    def _coarsened(self, stage, place):
        source, steps, first, widths = self._output.windows(stage)
        finer = self._output.levels[source].array
        lead, space = _divided(place, self._output.axes)
        parts, centers, widths = [], [], widths[-len(space) :]
        for axis, (rows, width) in enumerate(zip(space, widths), -len(space)):
            center = first[axis] + steps[axis] * np.arange(rows.start, rows.stop)
            last = finer.shape[axis] - 1
            low = min(max(int(center[0] - width / 2 + 0.5), 0), last)
            high = min(max(math.ceil(center[-1] + width / 2 - 0.5), low), last)
            parts.append(slice(low, high + 1))
            centers.append(center - low)
        values = read(finer, (*lead, *parts))
        are_labels = self._methods(lead) == "nearest"
        if not are_labels.any():
            return coarsened(values, centers, widths)
        nearest = coarsened(values, centers, np.ones(len(space)), is_label=True)
        if are_labels.all():
            return nearest
        are_labels = are_labels.reshape(*are_labels.shape, *[1] * len(space))
        return np.where(are_labels, nearest, coarsened(values, centers, widths))

    def _methods(self, lead):
        """The interpolation of times and channels in slices."""
        methods = np.array(self._input.methods(self.interpolation))
        shape = self._input.finest.array.shape[: len(lead)]
        methods = methods if "c" in self._input.axes else methods[0]
        return np.array(np.broadcast_to(methods, shape)[lead])


@dataclass(frozen=True, eq=False)
class FieldBlocks(Blocks):
    """Blocks of a displacement field G(v) - v on the grid of an image: axes c, z, y, x."""

    def _values(self, stage, place):
        lead, space = _divided(place, self._output.axes)
        part = _part(self._output.finest.grid, space)
        vectors = self.transform.displacement_field(part).displacement
        if not np.isfinite(vectors).all():  # warnings of blocks would be lost
            raise ValueError(fields.gaps("displacements", vectors))
        return np.moveaxis(vectors, -1, 0)[lead].reshape([rows.stop - rows.start for rows in place])


def coarsened(values, centers, widths, is_label=False):
    """Means of windows along the last axes of `values`, or for labels their middle values.

    For each of these axes `centers` are the windows' (count,), in indices of `values`, and `widths`
    their numbers of points, 1 for values between points. The border's value continues, as in
    `Sampling`.
    """
    space = range(values.ndim - len(centers), values.ndim)
    if is_label:
        for axis, center in zip(space, centers):
            index = np.ceil(center - 0.5).astype(int)
            values = values.take(index.clip(0, values.shape[axis] - 1), axis)
        return values
    taps = [list(_taps(*window, values.shape[a])) for a, *window in zip(space, centers, widths)]
    is_weighted = any(share is not None for axis in taps for _, share in axis)
    is_small = values.dtype.kind in "iu" and values.dtype.itemsize < 8 and not is_weighted
    shape = values.shape[: space[0]] + tuple(map(len, centers))
    total = np.zeros(shape, np.int64 if is_small else np.float64)
    for place in itertools.product(*taps):
        part, weight = values, np.ones((), int)
        for axis, (rows, share) in zip(space, place):
            part = part[(slice(None),) * axis + (rows,)]
            if share is not None:
                weight = weight * share.reshape([-1] + [1] * (values.ndim - 1 - axis))
        if not is_weighted and math.prod(map(len, taps)) == 1:
            return part
        np.add(total, part * weight if is_weighted else part, out=total, where=weight > 0)
    return interpolation.cast(total / math.prod(widths), values.dtype)


def _taps(centers, width, size):
    """Rows of an axis of `size` points, one for each window, with their shares of a point.

    Shares are None if all are 1.
    """
    low, high = centers - width / 2, centers + width / 2
    first = np.floor(low + 0.5).astype(int)
    for offset in range(math.ceil(width) + 1):
        rows = first + offset
        share = np.minimum(high, rows + 0.5) - np.maximum(low, rows - 0.5)
        if (share <= 0).all():
            continue
        step = rows[1] - rows[0] if len(rows) > 1 else 1
        is_regular = step > 0 and (np.diff(rows) == step).all() and 0 <= rows[0] <= rows[-1] < size
        index = slice(rows[0], rows[-1] + 1, step) if is_regular else rows.clip(0, size - 1)
        yield index, None if (share == 1).all() else share.clip(0)


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
