"""Paths of handles from the undeformed to the deformed space, in steps."""

from dataclasses import replace

import numpy as np

from vtk_mls.model.handles.curve import Segments
from vtk_mls.model.handles.region import RegionStep, moved
from vtk_mls.model.handles.rigid_motion import axis_and_angle, rotation, screw

MAX_POINTS = 1000  # of a rigid path
_NEIGHBORS = 10
_FOLLOWS = 0.2  # misses of neighbors, relative to their distance, above which they count less
_STRAIGHT = 0.01  # weight of the straight line of a point, relative to its neighbors
_ROUNDS = 5
_MAX_GROWTH = 100.0
_TINY = 1e-12


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


def rigid_path(rest, deformed, legs):
    """Intermediate places (legs - 1, n, 3) of points (n, 3) on a way that is as rigid as possible.

    Each point turns and grows at constant rates, as its neighbors do that move with it. The edges
    between neighbors follow in the sense of least squares (Alexa, Cohen-Or and Levin 2000). The
    middles of groups go straight, and points that do not move stay.
    """
    count = len(rest)
    squares = np.minimum(*(((x[:, None] - x) ** 2).sum(axis=2) for x in (rest, deformed)))
    squares = np.maximum(squares, _TINY * squares.max() or 1)  # points may coincide
    squares[range(count), range(count)] = np.inf
    near = np.argsort(squares, axis=1)[:, :_NEIGHBORS]
    rows = np.arange(count)[:, None]
    turns, growth, weights = _motions(rest, deformed, near, 1 / squares[rows, near])
    weight = np.zeros((count, count))
    weight[rows, near] = weights
    weight += weight.T
    sums = weight.sum(axis=1)
    inverse = np.linalg.inv(np.diag((1 + _STRAIGHT) * sums) - weight)
    edges = rest[:, None] - rest
    axes = [axis_and_angle(turn) for turn in turns]
    shares, places = np.linspace(0, 1, legs + 1), []
    for share in shares:
        motions = [g**share * rotation(axis, share * a) for (axis, a), g in zip(axes, growth)]
        moved = np.einsum("iab,ijb->ija", np.stack(motions), edges)
        pulls = np.einsum("ij,ija->ia", weight, moved - moved.swapaxes(0, 1)) / 2
        straight = (1 - share) * rest + share * deformed
        places.append(inverse @ (pulls + _STRAIGHT * sums[:, None] * straight))
    shares, places = shares[:, None, None], np.stack(places)
    places += (1 - shares) * (rest - places[0]) + shares * (deformed - places[-1])
    stays = (rest == deformed).all(axis=1)
    places[:, stays] = rest[stays]
    return places[1:-1]


def _motions(rest, deformed, near, weights):
    """Turns (n, 3, 3) and growths (n,) of points with neighbors (n, k), and weights of these.

    Neighbors that do not move with a point count less and less.
    """
    before, after = (x[near] - x[:, None] for x in (rest, deformed))
    lengths = [(x**2).sum(axis=2) for x in (before, after)]
    first, longest = weights, np.maximum(*lengths)
    for _ in range(_ROUNDS):
        left, _, right = np.linalg.svd(np.einsum("nk,nki,nkj->nij", weights, after, before))
        left[..., 2] *= np.sign(np.linalg.det(left @ right))[:, None]  # no mirror image
        turns = left @ right
        sums = np.stack([(weights * length).sum(axis=1) for length in lengths])
        sums = np.maximum(sums, _TINY * sums.max() or 1)
        growth = np.sqrt(sums[1] / sums[0])
        growth[np.abs(np.log(growth)) > np.log(_MAX_GROWTH)] = 1  # of points that coincide
        misses = after - growth[:, None, None] * np.einsum("nij,nkj->nki", turns, before)
        share = (misses**2).sum(axis=2) / np.maximum(longest, _TINY * longest.max() or 1)
        weights = first / (share + _FOLLOWS**2) ** 2
    return turns, growth, weights
