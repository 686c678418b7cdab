"""Sampling of arrays on an OpenCL device."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pyopencl as cl

from vtk_mls.base import interpolation
from vtk_mls.base.grid import Grid
from vtk_mls.engine.device import devices
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import filled

_TAPS = {"nearest": 1, "linear": 2, "cubic": 4}
# Arguments and build constants of "grid_source_index" without covariant vectors.
NO_VECTORS = (filled("array_t"), np.int32(0), None, None), (("VECTOR_FILE", "no_vectors.cl"),)


class Piece(NamedTuple):
    """The points `first` to `stop` of a slab, and the part of an array that they need."""

    first: int
    stop: int
    values: cl.Buffer | cl.SVM
    grid: Grid  # of the values


class Sampler:
    """The values of one array (nz, ny, nx[, components]) on the Grid `source` at points of slabs.

    The whole array is on the device if it `fits`, else the slices that the points need. `method` is
    "nearest", "linear" or "cubic", and `background` a number, or one for each component.
    `covariant` is None, or for covariant vectors, which are 0 outside, whether they are normalized.
    A `version` identifies the contents of the array.
    """

    def __init__(
        self, launcher, array, source, fits, method, background, covariant=None, version=None
    ):
        self.launcher, self.memory = launcher, launcher.memory
        self.array, self.source, self.fits = array, source, fits
        self.method, self.background = method, background
        self.covariant, self.version = covariant, version
        self._whole = self._background = None

    def sample(self, index, result):
        """Write into `result` (m, ...) the values at the indices in a buffer, in planes."""
        count = len(result)
        if not kernel_arguments.is_for_device(self.array, self.launcher.device):
            points = self.memory.planes(index, count).T.astype(np.float64)
            result[:] = interpolation.sample(
                self.array, points, self.method, self.background, self.source
            )
            return
        planes = None if self.fits else self.memory.planes(index, count)
        for piece in self.pieces(index, count):
            if planes is None:
                self._launch(piece, index, result)
                continue
            rows = slice(piece.first, piece.stop)
            own = np.ascontiguousarray(planes[:, rows])
            with self.memory.input_buffer(own) as own_index:
                self._launch(piece, own_index, result[rows])

    def transform(self, launch, part, index, distance, competing, result):
        """Fill `result` (m, 3) with the covariant vectors at the points `part` of the target.

        `launch` is that of `Engine._sources`. It writes to the buffers `index` and `distance` if
        the whole array is on the device; else these have been filled, and those of pieces differ.
        """
        count = part.stop - part.start
        for piece in self.pieces(index, count):
            if piece.stop - piece.first < count:
                index = self.memory.scratch("sources of a piece", 12 * count)
                distance = competing
            points = slice(part.start + piece.first, part.start + piece.stop)
            with self.memory.output_buffer(result[piece.first : piece.stop]) as out:
                normalize = np.int32(bool(self.covariant))
                arguments = self.record(piece), normalize, piece.values, out
                file = "VECTOR_FILE", "vectors.cl"
                constants = kernel_arguments.offset(self.array), self.taps, file
                launch(points, index, distance, (arguments, constants))

    def pieces(self, index, count):
        """The pieces of a slab of `count` points with the indices in a buffer, in planes."""
        if self.fits:
            if self._whole is None and (self.memory.in_place or self.version is None):
                self._whole = self.memory.argument(self.array)
            elif self._whole is None:
                self._whole = self.memory.resident(self.array, self.version)
            yield Piece(0, count, self._whole, self.source)
            return
        planes = self.memory.planes(index, count)
        pieces = [(0, count)]
        while pieces:
            first, stop = pieces.pop()
            low, high = _slices_needed(planes[2, first:stop], self.source)
            slices = self.array[low:high]
            if not self.memory.fits(slices.nbytes):
                if stop - first == 1:
                    raise devices.DeviceError(
                        f"a few slices of the image ({slices.nbytes} bytes) do not fit the memory "
                        f"of {self.launcher.device}; use another `device`"
                    )
                middle = (first + stop) // 2
                pieces += [(middle, stop), (first, middle)]
                continue
            with self.memory.input_buffer(slices) as values:
                nx, ny, _ = self.source.dimensions
                grid = self.source.part((0, 0, low), (nx, ny, high - low))
                yield Piece(first, stop, values, grid)

    @property
    def taps(self):
        """The build constant for the method."""
        return "SAMPLE_TAPS", _TAPS[self.method]

    def record(self, piece):
        """The array_t of a piece."""
        return filled(
            "array_t",
            size=self.source.whole.dimensions,
            first=piece.grid.first,
            stored=piece.grid.dimensions,
            components=np.prod(self.array.shape[3:]),
        )

    def _launch(self, piece, index, result):
        array, count = self.array, piece.stop - piece.first
        # nearest values are copies: one kernel serves all types of a size
        values = array.view(f"u{array.itemsize}") if self.method == "nearest" else array
        constants = (*kernel_arguments.array_constants(values, self.launcher.device), self.taps)
        if self._background is None:
            background = interpolation.cast(self.background, array.dtype)
            values = np.empty(int(np.prod(array.shape[3:])), array.dtype)
            values[:] = background
            self._background = self.memory.constant(values)
        with self.memory.output_buffer(result) as out:
            ends = self._background, piece.values, out
            arguments = np.int64(count), index, self.record(piece), *ends
            self.launcher.launch("resample", constants, count, *arguments)


def samplers(launcher, arrays, sampling, covariant):
    """A Sampler for each of `arrays`, which share the memory of the device.

    `covariant` has the indices of arrays of covariant vectors, and whether they are normalized.
    """
    size = sum(array.nbytes for array in arrays)
    fits = launcher.memory.in_place or launcher.memory.fits(size)
    return [
        Sampler(
            *(launcher, array, sampling.source, fits, method, background),
            *(covariant.get(i), sampling.version(i)),
        )
        for i, (array, method, background) in enumerate(
            zip(arrays, sampling.methods(len(arrays)), sampling.backgrounds(len(arrays)))
        )
    ]


def _slices_needed(z, grid):
    """First and past-the-last slice that interpolation at the indices `z` can touch."""
    z = z[(z >= -0.5) & (z <= grid.whole.dimensions[2] - 0.5)] - grid.first[2]
    if len(z) == 0:
        return 0, 1
    count = grid.dimensions[2]
    low, high = np.clip((int(z.min()) - 1, int(z.max()) + 2), 0, count - 1)
    return int(low), int(high) + 1
