"""Which part of an image a part of the deformed image needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

# Points needed beyond those next to an origin: of interpolation, and of differences for gradients.
_REACH = {"nearest": 0, "linear": 0, "cubic": 1}
GRADIENT_REACH = 2


def needed_extent(deformation, geometry, sampling, more=0):
    """The extent of an image from which all values of a deformed part can be found.

    Parameters
    ----------
    deformation : Deformation
    geometry : ImageGeometry
        Of the whole input.
    sampling : Sampling
        From the grid of the whole input to the part of the output.
    more : int
        How many points more are needed on every side.

    Returns
    -------
    (6,) ints
        At least a cell of the input, where nothing is needed.
    """
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    reach = _REACH[sampling.interpolation] + more
    for corner, each in enumerate((sampling, of_cells(sampling))):
        lowest, highest = deformation.source_bounds(each)
        # a cell needs its last corner as well
        low, high = np.minimum(low, lowest), np.maximum(high, highest + corner)
    last = np.array(sampling.source.dimensions) - 1
    if not np.isfinite(low).all():
        low = high = np.zeros(3)
    low = np.clip(np.floor(low) - reach, 0, np.maximum(last - 1, 0))
    high = np.clip(np.ceil(high) + reach, np.minimum(low + 1, last), last)
    first = np.array(geometry.extent[::2])
    return tuple(np.stack([first + low, first + high], axis=1).astype(int).ravel().tolist())


def of_cells(sampling):
    """How cells are sampled where points are as `sampling` says."""
    return replace(
        sampling,
        source=sampling.source.cells,
        target=sampling.target.cells,
    )


def first_cell(geometry):
    """The smallest extent that every image can be asked for."""
    first, last = np.array(geometry.extent[::2]), np.array(geometry.extent[1::2])
    return tuple(np.stack([first, np.minimum(first + 1, last)], axis=1).ravel().tolist())
