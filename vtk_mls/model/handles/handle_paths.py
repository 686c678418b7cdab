"""Paths of handles from the undeformed to the deformed space, in steps."""

from dataclasses import replace

import numpy as np

from vtk_mls.model.handles.curve import Segments
from vtk_mls.model.handles.region import RegionStep, moved
from vtk_mls.model.handles.rigid_motion import screw


def steps(handles, count):
    """The steps of a set along its path, first to last: each from one stage to the next.

    Points go along the straight lines between their places, at equal times for each line; curves
    node by node; regions along a screw. All steps have the rows of the whole set.
    """
    shares = np.linspace(0, 1, count + 1)
    motions = [[screw(region, share) for region in handles.regions] for share in shares]
    positions = [_positions(handles, *stage) for stage in zip(shares, motions)]
    ends = [_lerp(handles.segments.rest, handles.segments.deformed, share) for share in shares]
    return tuple(
        replace(
            handles,
            rest=positions[k],
            deformed=positions[k + 1],
            regions=tuple(map(RegionStep, handles.regions, motions[k], motions[k + 1])),
            segments=Segments(ends[k], ends[k + 1], handles.segments.weights),
            rest_anchors=handles.anchors[0],
        )
        for k in range(count)
    )


def blended_path(rest, deformed, path, blend):
    """Where points end (n, 3), and their `path` (k, n, 3), if they go a share `blend` of their way.

    Above 1 and below 0 they go straight on from the ends of the path.
    """
    places = [rest, *path, deformed]
    legs = len(places) - 1
    ends = [along(places, blend * (k / legs)) for k in range(1, legs + 1)]
    return ends[-1], np.reshape(ends[:-1], (legs - 1, *rest.shape))


def _positions(handles, share, motions):
    """Places (n, 3) of the points and proxies at a `share` of the path."""
    result = along([handles.rest, *handles.path.swapaxes(0, 1), handles.deformed], share)
    for row, motion in enumerate(motions):
        proxies = handles.region == row
        result[proxies] = moved(motion, handles.rest[proxies])
    return result


def along(places, share):
    """The place (n, 3) at a `share` of the way through `places`, with equal times between them."""
    time = share * (len(places) - 1)
    leg = min(max(int(time), 0), len(places) - 2)
    return _lerp(places[leg], places[leg + 1], time - leg)


def _lerp(a, b, share):
    return b.copy() if share == 1 else a + share * (b - a)
