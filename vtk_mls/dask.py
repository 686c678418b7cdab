"""Arrays larger than memory, deformed lazily on dask: `vtk_mls.dask.resample`."""

from vtk_mls.blocks.array_blocks import resample

__all__ = ["resample"]
