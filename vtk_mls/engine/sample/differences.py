"""Gradients of arrays on a grid, by differences on an OpenCL device."""

import numpy as np

from vtk_mls.base import buffer_pool
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import filled

_REACH = 2  # slices that a difference takes on either side
MAX_LAUNCH_POINTS = 1 << 24  # so that progress is reported


def gradient(launcher, array, grid, progress):
    """`vector_fields.gradient` of an array (nz, ny, nx) that the device can read."""
    memory, (nx, ny, nz) = launcher.memory, grid.dimensions
    result = buffer_pool.empty((*grid.shape, 3), np.float32)
    constants = kernel_arguments.array_constants(array, launcher)
    matrix = grid.world_to_index.T
    to_world = kernel_arguments.transform(matrix, np.zeros(3))
    lanes = dict(constants)["LANES"]
    row = -(-nx // lanes) * lanes  # points that a launch counts
    for start, stop in progress.over(_slabs(nz, nx * ny, array.itemsize, memory)):
        low, high = max(start - _REACH, 0), min(stop + _REACH, nz)
        if memory.in_place:
            low, high = 0, nz
        slices = filled(
            "slices_t", size=(nx, ny, nz), first=low, start=start, stop=stop, to_world=to_world
        )
        count = row * ny * (stop - start)
        with (
            memory.input_buffer(array[low:high]) as values,
            memory.output_buffer(result[start:stop]) as out,
        ):
            launcher.launch("gradient", constants, count, slices, values, out)
    return result


def _slabs(count, size, itemsize, memory):
    """Slabs of `count` slices with `size` points each: first and past-the-last slice."""
    step = max(1, MAX_LAUNCH_POINTS // size)
    if not memory.in_place:
        step = max(1, min(step, int(memory.limit / 2 / size / (12 + itemsize)) - 2 * _REACH))
    return [(start, min(start + step, count)) for start in range(0, count, step)]
