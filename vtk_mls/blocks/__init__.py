"""OME-Zarr images, deformed block by block: larger than memory, on clusters, resumed."""
