"""Foundations that need only numpy: validation, grids, sampling, interpolation, progress."""
