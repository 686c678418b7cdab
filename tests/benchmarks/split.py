"""Where the time of an update goes: to its kernels, and to Python and VTK beside them.

Kernels are waited for one by one, so an update takes a little longer here. Interpolation between
nodes and its stores are one kernel; a filled array of the same size shows the share of the stores.
"""

from __future__ import annotations

import time

import contestants
import numpy as np
import roofline
from operations import handles

from vtk_mls import Deformation, Grid
from vtk_mls.engine.dispatch import engine_for

_RUNS = 7
_BESIDE, _ALL, _FILLED = "Python and VTK", "all", "its array filled"
# Columns by the names of kernels; others have a column of their own.
_STAGES = {
    "node_displacement": "nodes",
    "node_origin": "nodes",
    "node_cell": "nodes",
    "coarse_check": "check",
    "coarse_displacement": "between nodes",
    "coarse_source_index": "between nodes",
    "coarse_covariant": "between nodes",
    "grid_displacement": "exactly",
    "grid_source_index": "exactly",
    "grid_covariant": "exactly",
    "resample": "sampling",
    "gradient": "sampling",
    "void_by_corners": "void of cells",
    "doubtful_voxels": "check of folds",
}


def table(n):
    """Updates on a grid of n^3 points, as rows of a table of the benchmark, in milliseconds."""
    device, rows = engine_for().device, {}
    for name, update, size in _updates(n):
        row = min((_split(update) for _ in range(1 + _RUNS)), key=lambda row: row[_ALL])
        row[_FILLED] = roofline.filling_time(device, size)
        rows[name] = {stage: 1000 * seconds for stage, seconds in row.items()}
    return rows


def _updates(n):
    """(name, function, bytes of its output): the same maps in numpy and by filters."""
    image, grid = np.zeros((n, n, n), np.float32), Grid((n, n, n))
    for told, tolerance in contestants.TOLERANCES.items():
        value = Deformation(*handles(n), map_tolerance=tolerance)
        yield f"map{told}", lambda value=value: value.displacement_field(grid), 12 * grid.size
        yield f"volume{told}", lambda value=value: value.resample([image], grid), 4 * grid.size
    for name, update in contestants.updates(n):
        gradient = 12 * grid.size if name.endswith("Gradient") else 0
        yield f"MLSDeform, {name}", update, 4 * grid.size + gradient


def _split(update):
    """Seconds of an update by its stages."""
    with roofline.timed() as seconds:
        start = time.perf_counter()
        update()
        total = time.perf_counter() - start
    row = dict.fromkeys([*dict.fromkeys(_STAGES.values()), _BESIDE, _ALL], 0.0)
    for kernel, taken in seconds.items():
        stage = _STAGES.get(kernel, kernel)
        row[stage] = row.get(stage, 0.0) + taken
    return row | {_BESIDE: total - sum(seconds.values()), _ALL: total}
