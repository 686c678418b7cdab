"""Warnings about handles: kept from their places, overlapping, or in each other's places."""

from itertools import combinations

import numpy as np

from vtk_mls.model.handles.region import RegionHandle
from vtk_mls.model.handles.rigid_motion import fitted_motion
from vtk_mls.model.handles.shapes import Solid

_MAX_MISS = 1e-4  # largest miss of a handle that is met, as a fraction of the extent of all
_SAME_SHAPE = 1e-4  # largest distance of points of equal surfaces, as a fraction of the size
_SAMPLES = 8  # along each axis of the bounds of a region
_OVERLAP_SAMPLES = 24  # the same, to find overlaps
_MAX_PAIRS = 5  # in a sentence


def handle_warnings(deformation, has_overlap=True):
    """Sentences, without a capital and a full stop, about the handles of a Deformation."""
    overlap = overlap_warnings(deformation) if has_overlap else []
    return [*_held_handles(deformation), *overlap, *_exchanged_regions(deformation)]


def _held_handles(deformation):
    """A sentence about handles that a mask or a face keeps from their places."""
    if not deformation.limits:
        return
    points = zip(deformation.rest[:, None], deformation.deformed[:, None])
    pairs = [*points, *(handle.samples(_SAMPLES) for handle in deformation.handles)]
    starts = np.cumsum([0, *(len(p) for p, _ in pairs[:-1])])
    rest, deformed = (np.concatenate(points) for points in zip(*pairs))
    factors = [limit.factor(deformed)[0] for limit in deformation.limits]
    miss = np.linalg.norm(deformation.backward(deformed) - rest, axis=1)
    misses = np.maximum.reduceat(np.where(np.min(factors, axis=0) < 1, miss, 0), starts)
    positions = np.concatenate(deformation.handle_set.positions)
    is_missed = misses > _MAX_MISS * np.ptp(positions, axis=0).max()
    if is_missed.any():
        yield (
            f"{is_missed.sum()} of {len(is_missed)} handles are not met, by up to "
            f"{misses.max():.3g}, because the mask or a face holds them"
        )


def _exchanged_regions(deformation):
    """A sentence about surfaces of the same shape that are moved to each other's places."""
    handles = [handle for handle in deformation.handles if isinstance(handle, RegionHandle)]
    regions = [region for region in handles if isinstance(region.shape, Solid)]
    if len(regions) < 2:
        return
    rest, moved = np.swapaxes([region.center for region in regions], 0, 1)
    nearest = np.linalg.norm(moved[:, None] - rest, axis=2).argmin(axis=1)
    rows = np.arange(len(regions))
    for _ in regions:  # rows that are not in a cycle drop out
        rows = np.unique(nearest[rows])
    rows = [i for i in rows if nearest[i] != i and _are_equal(regions[i], regions[nearest[i]])]
    if rows:
        numbers = " and ".join(str(handles.index(regions[i])) for i in rows)
        yield (
            f"rigid regions {numbers} have the same shape, and are moved to each other's places; "
            "if they are not to be, append the moved surfaces in the order of the others"
        )


def _are_equal(region, other):
    """Whether surfaces have the same points, by their numbers, but for a motion."""
    points, others = region.shape.points, other.shape.points
    if points.shape != others.shape:
        return False
    return fitted_motion(points, others)[1] <= _SAME_SHAPE * np.ptp(points, axis=0).max()


def overlap_warnings(deformation, names=None):
    """A sentence about rigid regions that overlap, or none.

    `names` are those of `deformation.handles`; by default, regions have numbers.
    """
    regions = [row for row, h in enumerate(deformation.handles) if isinstance(h, RegionHandle)]
    pairs = deformation.overlapping_regions if len(regions) > 1 else []
    if pairs:
        if names is None:
            names = {row: number for number, row in enumerate(regions)}
        texts = [f"{names[i]} and {names[j]}" for i, j in pairs[:_MAX_PAIRS]]
        more = f" and {len(pairs) - _MAX_PAIRS} more pairs" * (len(pairs) > _MAX_PAIRS)
        return [f"rigid regions overlap where they were moved to: {', '.join(texts)}{more}"]
    return []


def overlapping_regions(handles):
    """Pairs (i, j) of `handles`, a sequence, that are regions and overlap where they were moved to.

    Found by points inside of the first, about 1/24 of its size apart.
    """
    regions = {i: h for i, h in enumerate(handles) if isinstance(h, RegionHandle)}
    samples = {}
    for i, region in regions.items():
        points = region.shape.lattice(_OVERLAP_SAMPLES)
        samples[i] = region.moved(points[region.shape.distance(points)[0] == 0])
    return [
        (i, j)
        for i, j in combinations(regions, 2)
        if _reaches(samples[i], regions[j]) or _reaches(samples[j], regions[i])
    ]


def _reaches(points, region):
    return bool((region.distance(points)[0] == 0).any())
