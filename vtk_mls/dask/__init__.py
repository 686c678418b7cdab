"""Arrays larger than memory, deformed lazily on dask: `vtk_mls.dask.resample`."""

from vtk_mls.dask.resampling import resample

__all__ = ["resample"]
