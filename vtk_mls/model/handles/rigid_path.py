"""A path of points that is as rigid as possible."""

import numpy as np

from vtk_mls.model.handles.rigid_motion import axis_and_angle, rotation

MAX_POINTS = 1000
_NEIGHBORS = 10
_FOLLOWS = 0.2  # misses of neighbors, relative to their distance, above which they count less
_STRAIGHT = 0.01  # weight of the straight line of a point, relative to its neighbors
_ROUNDS = 5
_MAX_GROWTH = 100.0
_TINY = 1e-12


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
