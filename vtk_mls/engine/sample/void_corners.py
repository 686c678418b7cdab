"""Flags of void cells from void distances at their corners, on an OpenCL device."""

import numpy as np

from vtk_mls.base import buffer_pool
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, filled
from vtk_mls.queries import void_cells

MAX_LAUNCH_CELLS = 1 << 24  # so that progress is reported


def void_by_corners(launcher, void_distance, min_distance, progress):
    """`void_cells.by_corners`."""
    memory, (nz, ny, nx) = launcher.memory, void_distance.shape
    cells = tuple(max(n - 1, 1) for n in void_distance.shape)
    result = buffer_pool.empty(cells, np.uint8)
    constants = tuple(launcher.sums(double=False))
    lanes = dict(constants)["LANES"]
    step = max(1, MAX_LAUNCH_CELLS // (nx * ny))
    if not memory.in_place:
        step = max(1, min(step, int(memory.limit / 2 / (5 * nx * ny)) - 3))
    starts = range(0, cells[0], step)
    for start in progress.over(starts):
        stop = min(start + step, cells[0])
        # the flags of a cell depend on its neighbors
        low, high = (0, nz) if memory.in_place else (max(start - 1, 0), min(stop + 2, nz))
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
        with (
            memory.input_buffer(void_distance[low:high]) as values,
            memory.output_buffer(result[start:stop]) as out,
        ):
            launcher.launch("void_by_corners", constants, count, layers, values, out)
    return result
