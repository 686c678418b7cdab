"""Data in time: one step is shown at a time, the first one at first."""

from contextlib import suppress

from vtk_mls import io
from vtk_mls.files.ome_zarr import is_ome_zarr


def read(path, index=0):
    """The dataset of a file, at one of its time steps if it has any."""
    return io.open_dataset(path)[1](index)


def times_of(path):
    """The times of a file; () if it has no steps in time, or cannot be read any more."""
    with suppress(OSError, ValueError):
        return () if is_ome_zarr(path) else io.open_dataset(path)[0]
    return ()
