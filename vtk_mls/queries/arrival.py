"""Check that the material of a grid arrives on another grid."""

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.base.sampling import Sampling

MAX_SAMPLES = 32  # along each axis of a coarse grid
_BOX_SAMPLES = 9


def coarse(grid, max_samples=MAX_SAMPLES):
    """A grid with the same corners and few points."""
    full = np.array(grid.dimensions)
    dimensions = np.minimum(full, max_samples)
    spacing = grid.spacing * (np.maximum(full - 1, 1) / np.maximum(dimensions - 1, 1))
    return Grid(dimensions, grid.origin, spacing, grid.direction)


def has_material(deformation, grid, source):
    """Mask (n,) of the points of a grid that have material, of the grid `source` if not None."""
    points = grid.points()
    if source is None:
        mask = np.ones(len(points), bool)
    else:
        mask = source.covers(source.index_of(deformation.backward(points)))
    return mask & ~deformation.void(points) if deformation.cuts else mask


def arrives(deformation, source, target):
    """Whether points of the grid `target` have material that was on `source` at rest.

    A few points are tested first.
    """
    if has_material(deformation, coarse(target), source).any():
        return True
    mask = np.ones(source.shape, np.uint8)
    return bool(deformation.resample([mask], Sampling(source, target, "nearest"))[0].any())


def boxes(deformation, source, target):
    """Bounds of the deformed material of a grid, and of another grid: two texts."""
    moved = deformation.forward(coarse(source, _BOX_SAMPLES).points())
    return _box_of(moved), _box_of(target.corners())


def _box_of(points):
    """The bounding box of those points (n, 3) that are finite, for a sentence."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        return "no place that could be found"
    ranges = zip("xyz", points.min(axis=0), points.max(axis=0))
    return ", ".join(f"{axis} {low:.6g} to {high:.6g}" for axis, low, high in ranges)


def lost_share(deformation, points, target):
    """The fraction of material points (n, 3) that leave the grid `target`; 0 without points."""
    moved = deformation.forward(points)
    moved = moved[np.isfinite(moved).all(axis=1)]
    return 1 - target.covers(target.index_of(moved)).mean() if len(moved) > 0 else 0.0
