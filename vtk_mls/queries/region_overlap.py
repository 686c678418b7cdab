"""Rigid regions that push into each other."""

from itertools import combinations

from vtk_mls.model.handles.region import RegionHandle

_SAMPLES = 24  # along each axis of the bounds of a region


def overlapping_regions(handles):
    """Pairs (i, j) of `handles`, a sequence, that are regions and overlap where they were moved to.

    Found by points inside of the first, about 1/24 of its size apart.
    """
    regions = {i: h for i, h in enumerate(handles) if isinstance(h, RegionHandle)}
    samples = {i: region.moved(_inside(region.shape)) for i, region in regions.items()}
    return [
        (i, j)
        for i, j in combinations(regions, 2)
        if _reaches(samples[i], regions[j]) or _reaches(samples[j], regions[i])
    ]


def _inside(shape):
    """Points (m, 3) inside of a shape, in the undeformed space."""
    points = shape.lattice(_SAMPLES)
    return points[shape.distance(points)[0] == 0]


def _reaches(points, region):
    return bool((region.distance(points)[0] == 0).any())
