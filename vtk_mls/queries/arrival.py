"""Where the material of a grid arrives: on another grid, or on the grid that is fitted to it."""

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.base.sampling import Sampling

MAX_SAMPLES = 32  # along each axis of a coarse grid
_BOX_SAMPLES = 9
FITTED_SAMPLES = 48  # along each axis of the box of a fitted grid
MAX_GROWTHS = 8  # of the box, by half of its size on a side
SHRINKINGS = 2  # of the box to the samples inside the volume
_OTHER_AXES = ((1, 2), (0, 2), (0, 1))


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
        mask = _is_inside(source, deformation.backward(points))
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
    return 1 - _is_inside(target, moved).mean() if len(moved) > 0 else 0.0


def fitted_grid(deformation, source, progress):
    """The smallest `Grid` found that is aligned with `source` and holds the deformed volume.

    The backward map is sampled over a box. The box grows on each side that the volume reaches,
    then shrinks to the samples inside the volume, plus one sample step. Polynomials can bring
    copies of the volume from far away, so the number of growth steps is limited.
    """
    size = np.array(source.dimensions, dtype=np.float64)
    low, high = np.full(3, -0.5), size - 0.5
    # far moves are found by control points
    rest, deformed = deformation._material_samples(source)
    material = source.index_of(deformed[_is_inside(source, rest)])
    low, high = _enclosed(low, high, material)
    margin = 0.25 * (high - low) + 1
    low, high = low - margin, high + margin
    growing, shrinking = progress.divided(MAX_GROWTHS, SHRINKINGS)
    for part in growing.divided(*[1] * MAX_GROWTHS):
        inside, axes = _sampled(deformation, source, (low, high), part)
        step = 0.5 * (high - low)
        faces_low, faces_high = (
            np.array([inside.take(end, axis).any() for axis in range(3)]) for end in (0, -1)
        )
        if not (faces_low.any() or faces_high.any()):
            break
        low, high = low - step * faces_low, high + step * faces_high
    for part in shrinking.divided(*[1] * SHRINKINGS):
        inside, axes = _sampled(deformation, source, (low, high), part)
        if not inside.any():
            break
        step = (high - low) / (FITTED_SAMPLES - 1)
        found = [axis[np.any(inside, axis=others)] for axis, others in zip(axes, _OTHER_AXES)]
        low = np.array([axis[0] for axis in found]) - step
        high = np.array([axis[-1] for axis in found]) + step
    low, high = _enclosed(low, high, material)
    first, last = np.floor(low), np.ceil(high)
    flat = size == 1  # a slice stays a slice
    first, last = np.where(flat, 0, first), np.where(flat, 0, last)
    return Grid(
        (last - first + 1).astype(int), source.at(first[None])[0], source.spacing, source.direction
    )


def _sampled(deformation, source, box, progress):
    """Whether G maps each sample of an index box into `source`, (n, n, n) bool; and the axes."""
    axes = [np.linspace(low, high, FITTED_SAMPLES) for low, high in zip(*box)]
    index = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = _is_inside(source, deformation.backward(source.at(index), progress))
    return inside.reshape((FITTED_SAMPLES,) * 3), axes


def _is_inside(source, points):
    return source.covers(source.index_of(points))


def _enclosed(low, high, index):
    return np.vstack([low, index]).min(axis=0), np.vstack([high, index]).max(axis=0)
