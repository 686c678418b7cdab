"""Voxels in which a displacement field may fold, on an OpenCL device."""

from __future__ import annotations

import numpy as np

from vtk_mls.base import buffer_pool
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, filled
from vtk_mls.queries import certificate

MAX_LAUNCH_VOXELS = 1 << 24  # so that progress is reported


def doubtful_voxels(launcher, displacement, axes, progress):
    """`certificate.doubtful_voxels`."""
    memory, (nz, ny, nx, _) = launcher.memory, displacement.shape
    result = buffer_pool.empty((nz - 1, ny - 1, nx - 1), np.uint8)
    constants = tuple(launcher.sums(double=False))
    lanes, limit = dict(constants)["LANES"], MAX_LAUNCH_VOXELS
    if not memory.in_place:
        limit = min(limit, int(memory.limit / 2 / 13))
    step = max(1, limit // (nx * ny) - 1)
    for start in progress.over(range(0, nz - 1, step)):
        stop = min(start + step, nz - 1)
        voxels = filled(
            "voxels_t",
            size=(nx, ny, stop - start + 1),
            axes=axes.T.ravel(),
            inverse_volume=1 / np.linalg.det(axes),
            share=certificate.DOUBTFUL / 6,
        )
        columns = -(-(nx - 1) // lanes) * -(-(ny - 1) // CONSTANTS["VOXEL_ROWS"])
        with (
            memory.input_buffer(displacement[start : stop + 1]) as values,
            memory.output_buffer(result[start:stop]) as out,
        ):
            count = columns * (stop - start) * lanes
            launcher.launch("doubtful_voxels", constants, count, voxels, values, out)
    return result
