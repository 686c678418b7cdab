"""Arrays on a grid, resampled through a deformation block by block."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any

import dask
import dask.array as da
import numpy as np
from numpy.typing import NDArray

from vtk_mls.base import interpolation, validation
from vtk_mls.base.grid import Grid
from vtk_mls.base.sampling import AUTOMATIC, Sampling, corner_median, corners_of
from vtk_mls.base.validation import short_repr
from vtk_mls.queries.resampling import check_values
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms.parts import resampled_part, slices_of


def resample(
    array: Any, deformation: Transform, sampling: Sampling | Grid, chunks: Any = "auto"
) -> da.Array:
    """Deform an array on a grid, lazily: `Transform.resample` in blocks.

    Each block of the output is one task, which reads only the part of `array` that it needs. Blocks
    are, put together, the result of `Transform.resample` to the bit, also with `map_tolerance`.
    Every worker process uses one device, the `device` of the deformation or, by default, that of
    its environment variable VTK_MLS_DEVICE; the threads of a process share it.

    Parameters
    ----------
    array : (nz, ny, nx) or (nz, ny, nx, components) dask array, or other array with slices
        Such as an array of zarr or HDF5 or a numpy.memmap, of any real dtype. Tasks read slices of
        it; the blocks of a dask array that a slice needs are computed in the task.
    deformation : Deformation or other transform
    sampling : Sampling or Grid
        A Grid is short for `Sampling(grid)`.
    chunks : optional
        Of the three axes of the result, as of `dask.array.rechunk`. Larger blocks read less of
        `array` twice.

    Returns
    -------
    dask.array.Array
        With the target's shape, the components and the dtype of `array`.

    Raises
    ------
    TypeError, ValueError
        Naming the argument.

    Examples
    --------
    >>> image = dask.array.from_zarr("image.zarr")
    >>> moved = vtk_mls.dask.resample(image, deformation, Grid(image.shape[::-1]))
    >>> moved.to_zarr("moved.zarr")
    """
    sampling = Sampling.of(sampling)
    if sampling.source.whole is not sampling.source:
        raise ValueError("`sampling` must have a whole grid as its source, got a part of one")
    if not isinstance(deformation, Transform):
        raise TypeError(f"`deformation` must be a transform, got {short_repr(deformation)}")
    if getattr(array, "shape", None) is None or not hasattr(array, "dtype"):
        raise TypeError(f"`array` must have a shape and a dtype, got {short_repr(array)}")
    validation.check_unmasked("array", array)
    check_values("array", array, sampling.source)
    dtype = np.dtype(array.dtype)
    (method,) = sampling.methods(1)
    sampling.warn_of_background({"the array": dtype})
    (background,) = sampling.backgrounds(1)
    if not interpolation.is_in_range(background, dtype):  # blocks warn no more
        background = interpolation.cast(background, dtype).tolist()
        sampling = replace(sampling, background=(background,))
    components = tuple(array.shape[3:])
    shape = (*sampling.target.shape, *components)
    if isinstance(chunks, dict):
        chunks = tuple(chunks.get(axis, "auto") for axis in range(3))
    if not isinstance(chunks, (tuple, list)):
        chunks = (chunks,) * 3
    chunks = da.core.normalize_chunks((*chunks, *components), shape, dtype=dtype)
    if len(chunks) == 4 and len(chunks[3]) > 1:
        raise ValueError(f"`chunks` must not divide the components, got {chunks[3]}")
    sampling = replace(sampling, interpolation=method, versions=())
    blocks = dask.delayed(_Blocks(array, deformation, sampling, chunks), traverse=False)
    meta = np.empty((0,) * len(shape), dtype)
    return da.map_blocks(_Blocks.block, blocks, chunks=chunks, dtype=dtype, meta=meta)


@dataclass(frozen=True, eq=False)
class _Blocks:
    """The blocks of a resampled array: a value that all tasks share."""

    array: Any
    deformation: Transform
    sampling: Sampling
    chunks: tuple[tuple[int, ...], ...]

    def block(self, block_id: tuple[int, ...]) -> NDArray[Any]:
        """The block with an index along each axis."""
        first = [sum(sizes[:n]) for sizes, n in zip(self.chunks[:3], block_id)]
        size = [sizes[n] for sizes, n in zip(self.chunks[:3], block_id)]
        target = self.sampling.target.part(first[::-1], size[::-1])
        dtype = np.dtype((self.array.dtype, tuple(self.array.shape[3:])))
        sampling = replace(self.sampling, target=target, background=(self._background,))
        (values,) = resampled_part(self._read, [dtype], self.deformation, sampling)
        return values

    @functools.cached_property
    def _background(self) -> Any:
        """A number, or one for each component."""
        (background,) = self.sampling.backgrounds(1)
        if background != AUTOMATIC:
            return background
        grid = self.sampling.source
        corners = [grid.part(index[::-1], (1, 1, 1)) for index in corners_of(grid.shape)]
        return corner_median([self._read(corner)[0][0, 0, 0] for corner in corners])

    def _read(self, part: Grid) -> list[NDArray[Any]]:
        values = self.array[slices_of(part)]
        if dask.is_dask_collection(values):
            (values,) = dask.compute(values, scheduler="synchronous")  # this task has one thread
        validation.check_unmasked("array", values)
        return [np.asarray(values)]
