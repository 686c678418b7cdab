"""What void distances at the corners of cells tell of the void, on an OpenCL device."""

from __future__ import annotations

import numpy as np

from vtk_mls.base import buffer_pool
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.queries import void_cells

_MOST = 1 << 24  # cells of a launch, so that progress shows


def void_by_corners(launcher, void_distance, least, progress):
    """`void_cells.by_corners`."""
    memory, (nz, ny, nx) = launcher.memory, void_distance.shape
    cells = tuple(max(n - 1, 1) for n in void_distance.shape)
    result = buffer_pool.empty(cells, np.uint8)
    constants = tuple(launcher.sums(double=False))
    lanes = dict(constants)["LANES"]
    step = max(1, _MOST // (nx * ny))
    if not memory.in_place:
        step = max(1, min(step, int(memory.limit / 2 / (5 * nx * ny)) - 3))
    starts = range(0, cells[0], step)
    for start in progress.over(starts):
        stop = min(start + step, cells[0])
        # cells beside those that are wanted tell of them, too
        low, high = (0, nz) if memory.in_place else (max(start - 1, 0), min(stop + 2, nz))
        layers = kernel_arguments.filled(
            kernel_arguments.LAYERS,
            size=(nx, ny, nz),
            first=low,
            stored=high - low,
            start=start,
            stop=stop,
            min_distance=least,
            far_factor=void_cells.FAR,
        )
        columns = -(-cells[2] // lanes) * -(-cells[1] // kernel_arguments.CELL_ROWS)
        count = columns * -(-(stop - start) // kernel_arguments.CELL_LAYERS) * lanes
        with (
            memory.read(void_distance[low:high]) as values,
            memory.written(result[start:stop]) as out,
        ):
            launcher.launch("void_by_corners", constants, count, layers, values, out)
    return result
