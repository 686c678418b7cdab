"""Kernels over layers of a grid: gradients, void cells, and voxels in which a field may fold."""

import numpy as np

from vtk_mls.base import buffer_pool
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, filled
from vtk_mls.queries import certificate, void_cells

_REACH = 2  # layers that a difference takes on either side
MAX_LAUNCH_POINTS = 1 << 24  # so that progress is reported


def gradient(launcher, array, grid, progress):
    """`vector_fields.gradient` of an array (nz, ny, nx) that the device can read."""
    nx, ny, nz = grid.dimensions
    result = buffer_pool.empty((*grid.shape, 3), np.float32)
    constants = kernel_arguments.array_constants(array, launcher.device)
    to_world = kernel_arguments.transform(grid.world_to_index.T, np.zeros(3))
    lanes = dict(constants)["LANES"]
    row = -(-nx // lanes) * lanes  # points that a launch counts
    slabs = _slabs(launcher.memory, nz, nx * ny, 12 + array.itemsize, 2 * _REACH)
    for start, stop in progress.over(slabs):
        low, high = max(start - _REACH, 0), min(stop + _REACH, nz)
        if launcher.memory.in_place:
            low, high = 0, nz
        slices = filled(
            "slices_t", size=(nx, ny, nz), first=low, start=start, stop=stop, to_world=to_world
        )
        count = row * ny * (stop - start)
        values, out = array[low:high], result[start:stop]
        _launch(launcher, "gradient", constants, count, slices, values, out)
    return result


def void_by_corners(launcher, void_distance, min_distance, progress):
    """`void_cells.by_corners`."""
    nz, ny, nx = void_distance.shape
    cells = tuple(max(n - 1, 1) for n in void_distance.shape)
    result = buffer_pool.empty(cells, np.uint8)
    lanes = launcher.device.lanes
    for start, stop in progress.over(_slabs(launcher.memory, cells[0], nx * ny, 4 + 1, 3)):
        # the flags of a cell depend on its neighbors
        low, high = max(start - 1, 0), min(stop + 2, nz)
        if launcher.memory.in_place:
            low, high = 0, nz
        layers = filled(
            "layers_t",
            size=(nx, ny, nz),
            first=low,
            stored=high - low,
            start=start,
            stop=stop,
            min_distance=min_distance,
            far_factor=void_cells.FAR,
        )
        columns = -(-cells[2] // lanes) * -(-cells[1] // CONSTANTS["CELL_ROWS"])
        count = columns * -(-(stop - start) // CONSTANTS["CELL_LAYERS"]) * lanes
        values, out = void_distance[low:high], result[start:stop]
        _launch(launcher, "void_by_corners", (("LANES", lanes),), count, layers, values, out)
    return result


def doubtful_voxels(launcher, displacement, axes, progress):
    """`certificate.doubtful_voxels`."""
    nz, ny, nx, _ = displacement.shape
    result = buffer_pool.empty((nz - 1, ny - 1, nx - 1), np.uint8)
    lanes = launcher.device.lanes
    for start, stop in progress.over(_slabs(launcher.memory, nz - 1, nx * ny, 12 + 1, 1)):
        voxels = filled(
            "voxels_t",
            size=(nx, ny, stop - start + 1),
            axes=axes.T.ravel(),
            inverse_volume=1 / np.linalg.det(axes),
            share=certificate.DOUBTFUL / 6,
        )
        columns = -(-(nx - 1) // lanes) * -(-(ny - 1) // CONSTANTS["VOXEL_ROWS"])
        count = columns * (stop - start) * lanes
        values, out = displacement[start : stop + 1], result[start:stop]
        _launch(launcher, "doubtful_voxels", (("LANES", lanes),), count, voxels, values, out)
    return result


def _slabs(memory, count, size, bytes_per_point, more):
    """First and past-the-last layer of slabs of `count` layers with `size` points each.

    A slab takes `more` layers of the input than it has itself.
    """
    step = MAX_LAUNCH_POINTS // size
    if not memory.in_place:
        step = min(step, int(memory.limit / 2 / size / bytes_per_point) - more)
    step = max(1, step)
    return [(start, min(start + step, count)) for start in range(0, count, step)]


def _launch(launcher, name, constants, count, record, array, result):
    memory = launcher.memory
    with memory.input_buffer(array) as values, memory.output_buffer(result) as out:
        launcher.launch(name, constants, count, record, values, out)
