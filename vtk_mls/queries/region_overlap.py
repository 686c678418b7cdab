"""Rigid regions that push into each other."""

from itertools import combinations

from vtk_mls.model.handles.region import RegionHandle

_SAMPLES = 24  # along each axis of the bounds of a region


def overlapping_regions(handles):
    """Pairs (i, j) of `handles`, a sequence, that are regions and overlap where they were moved to.

    Found by points inside of the first, about 1/24 of its size apart.
    """
    regions = {i: h for i, h in enumerate(handles) if isinstance(h, RegionHandle)}
    samples = {}
    for i, region in regions.items():
        points = region.shape.lattice(_SAMPLES)
        samples[i] = region.moved(points[region.shape.distance(points)[0] == 0])
    return [
        (i, j)
        for i, j in combinations(regions, 2)
        if _reaches(samples[i], regions[j]) or _reaches(samples[j], regions[i])
    ]


def _reaches(points, region):
    return bool((region.distance(points)[0] == 0).any())
