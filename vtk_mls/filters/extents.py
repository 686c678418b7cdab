"""Which part of an image a part of the deformed image needs."""

from __future__ import annotations

import numpy as np

from vtk_mls import arrays

# Points beyond those next to a place: of interpolation, and of differences for gradients.
_REACH = {"nearest": 0, "linear": 0, "cubic": 1}
GRADIENT_REACH = 2


def needed_extent(deformation, source, target, whole_target, interpolation, void_values, more=0):
    """The extent of an image from which all values of a deformed part can be found.

    Parameters
    ----------
    deformation : Deformation
    source : ImageGeometry
        Of the whole input.
    target, whole_target : ImageGeometry
        The part of the output, and all of it.
    interpolation, void_values
        As of `Deformation.resample`.
    more : int
        How many points more are needed on every side.

    Returns
    -------
    (6,) ints
        At least a cell of the input, where nothing is needed.
    """
    grids = source.grid, target.grid_within(whole_target)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    reach = _REACH.get(interpolation, 0) + more
    for corner, pair in enumerate((grids, map(arrays.cell_grid, grids))):
        lowest, highest = deformation.source_bounds(*pair, void_values)
        # a cell needs its last corner as well
        low, high = np.minimum(low, lowest), np.maximum(high, highest + corner)
    last = np.array(source.grid.dimensions) - 1
    if not np.isfinite(low).all():
        low = high = np.zeros(3)
    low = np.clip(np.floor(low) - reach, 0, np.maximum(last - 1, 0))
    high = np.clip(np.ceil(high) + reach, np.minimum(low + 1, last), last)
    first = np.array(source.extent[::2])
    return tuple(np.stack([first + low, first + high], axis=1).astype(int).ravel().tolist())


def first_cell(geometry):
    """The smallest extent that every image can be asked for."""
    first, last = np.array(geometry.extent[::2]), np.array(geometry.extent[1::2])
    return tuple(np.stack([first, np.minimum(first + 1, last)], axis=1).ravel().tolist())
